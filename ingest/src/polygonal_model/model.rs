//! A surface and what its vertices have besides positions.

use terrain_core::Mesh;
use terrain_core::topology::manifold::ManifoldError;
use terrain_core::topology::parting::parted;
use terrain_tiles::formats::polygons::Column;

/// A model as a file has it, welded: no two vertices at one position, each used by a triangle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Model {
    /// Its surface.
    pub mesh: Mesh,
    /// What its vertices have besides positions.
    pub columns: Vec<Column>,
    /// Names of columns that were left out, because triangles that meet in a vertex have different values there.
    pub seams: Vec<String>,
}

impl Model {
    /// The same with vertices for each of the surfaces that touch in them.
    ///
    /// # Errors
    /// An edge whose triangles cannot belong to surfaces that touch.
    pub(super) fn parted(&self) -> Result<Self, ManifoldError> {
        let (mesh, originals) = parted(&self.mesh)?;
        let spread = |column: &Column| Column {
            values: originals.iter().map(|&vertex| column.values[vertex as usize]).collect(),
            ..column.clone()
        };
        Ok(Self {
            mesh,
            columns: self.columns.iter().map(spread).collect(),
            seams: self.seams.clone(),
        })
    }
}
