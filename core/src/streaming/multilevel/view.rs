//! Drawing one level of detail of a multilevel mesh, whole or on its way to the next coarser one.

use thiserror::Error;

use super::MultilevelMesh;

/// There is no such level.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[error("level {level} does not exist; the mesh has {count} levels, 0 being the finest")]
pub struct LevelRangeError {
    /// The level asked for.
    pub level: f64,
    /// How many there are.
    pub count: usize,
}

/// The surface of one level of detail. Going to another level costs the same whichever was drawn before, and uses the
/// buffers again.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LevelView<const DIMENSION: usize = 3> {
    positions: Vec<[f64; DIMENSION]>,
    triangles: Vec<[u32; 3]>,
    roots: Vec<u32>,
}

impl<const DIMENSION: usize> LevelView<DIMENSION> {
    /// Vertices of the level, in the order of the mesh.
    #[must_use]
    pub fn positions(&self) -> &[[f64; DIMENSION]] {
        &self.positions
    }

    /// Triangles of the level, in the order of the mesh.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Draws level `level` of `mesh`: the paper's `setLevel(int)`.
    ///
    /// # Errors
    /// When there is no such level; the view is then as it was.
    pub fn set_level(&mut self, mesh: &MultilevelMesh<DIMENSION>, level: usize) -> Result<(), LevelRangeError> {
        let count = mesh.level_count();
        let missing = || LevelRangeError {
            level: level as f64,
            count,
        };
        let end = mesh.end(level).ok_or_else(missing)?;
        self.find_roots(mesh, end.vertices);
        self.positions.clear();
        self.positions
            .extend_from_slice(&mesh.positions[..end.vertices as usize]);
        self.triangles.clear();
        let drawn = mesh.triangles[..end.triangles as usize].iter();
        self.triangles
            .extend(drawn.map(|corners| corners.map(|corner| root(mesh, &self.roots, corner))));
        Ok(())
    }

    /// Draws the geomorph at `level`, from 0 to the number of levels less one: the paper's `setLevel(float)`. It has the
    /// triangles of level ⌊`level`⌋; each vertex that the next coarser level lacks stands `level` − ⌊`level`⌋ of the way
    /// to what represents it there, or at its own place where nothing does.
    ///
    /// # Errors
    /// When `level` is outside, or no number; the view is then as it was.
    pub fn set_fractional_level(
        &mut self,
        mesh: &MultilevelMesh<DIMENSION>,
        level: impl Into<f64>,
    ) -> Result<(), LevelRangeError> {
        let (level, count) = (level.into(), mesh.level_count());
        if !(level >= 0.0 && level <= count as f64 - 1.0) {
            return Err(LevelRangeError { level, count });
        }
        let finer = level.floor() as usize;
        self.set_level(mesh, finer)?;
        let own_weight = 1.0 - level.fract();
        if let Some(coarser) = mesh.end(finer + 1) {
            self.morph(mesh, coarser.vertices, own_weight);
        }
        Ok(())
    }

    fn morph(&mut self, mesh: &MultilevelMesh<DIMENSION>, present: u32, own_weight: f64) {
        self.find_roots(mesh, present);
        for vertex in present as usize..self.positions.len() {
            let representative = mesh.positions[self.roots[vertex] as usize];
            for (own, other) in self.positions[vertex].iter_mut().zip(representative) {
                *own = *own * own_weight + other * (1.0 - own_weight);
            }
        }
    }

    /// The pc-rep array: for each vertex the one below `present` that stands for it, else, where the chain ends early,
    /// itself. One pass does, because representatives come before their vertices.
    fn find_roots(&mut self, mesh: &MultilevelMesh<DIMENSION>, present: u32) {
        self.roots.clear();
        self.roots.extend(0..present);
        for vertex in present..mesh.positions.len() as u32 {
            let of_representative = self.roots.get(mesh.representatives[vertex as usize] as usize);
            let reached = of_representative.copied().filter(|&root| root < present);
            self.roots.push(reached.unwrap_or(vertex));
        }
    }
}

/// What draws `corner`, which may be a vertex that has yet to come.
fn root<const DIMENSION: usize>(mesh: &MultilevelMesh<DIMENSION>, roots: &[u32], corner: u32) -> u32 {
    let mut vertex = corner;
    while let (None, Some(&representative)) = (roots.get(vertex as usize), mesh.awaited.get(&vertex)) {
        vertex = representative;
    }
    roots[vertex as usize]
}

#[cfg(test)]
#[path = "view_tests.rs"]
mod tests;
