//! What verification found, as a table for people and as JSON for programs.

use std::fmt;

use glam::DVec2;
use serde::Serialize;
use terrain_codec::address::TileAddress;

/// Metres of disagreement that are put down to the rounding of Earth-centred coordinates in thin triangles.
pub(super) const ROUNDING: f64 = 1e-4;

/// How many violations are told in full.
const TOLD: usize = 20;

/// Something claimed that does not hold.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Violation {
    /// What does not hold.
    pub what: String,
    /// zoom/x/y of the tile.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tile: Option<String>,
    /// Level of detail: a number, 0 the coarsest, or `finest` for the one with all four sides fine.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub level: Option<String>,
    /// Longitude and latitude in degrees, or x and y in units of the raster's reference system for a plain mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub place: Option<[f64; 2]>,
    /// The claimed figure, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub claimed: Option<f64>,
    /// The measured figure, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub measured: Option<f64>,
}

impl Violation {
    pub(super) fn new(what: impl Into<String>) -> Self {
        Self {
            what: what.into(),
            ..Self::default()
        }
    }

    pub(super) fn of_tile(what: impl Into<String>, tile: TileAddress) -> Self {
        Self {
            tile: Some(tile.to_string()),
            ..Self::new(what)
        }
    }

    pub(super) fn at(self, place: DVec2) -> Self {
        Self {
            place: Some(place.to_array()),
            ..self
        }
    }

    pub(super) fn figures(self, claimed: f64, measured: f64) -> Self {
        Self {
            claimed: Some(claimed),
            measured: Some(measured),
            ..self
        }
    }
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(tile) = &self.tile {
            write!(f, "tile {tile} ")?;
        }
        if let Some(level) = &self.level {
            write!(f, "level {level} ")?;
        }
        write!(f, "{}", self.what)?;
        if let Some([x, y]) = self.place {
            write!(f, " at {x:.7} {y:.7}")?;
        }
        if let (Some(claimed), Some(measured)) = (self.claimed, self.measured) {
            write!(f, ": claimed {claimed:.4} m, measured {measured:.4} m")?;
        }
        Ok(())
    }
}

/// Claims and measurements of one zoom, in metres.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ZoomReport {
    /// Which.
    pub zoom: u8,
    /// How many tiles.
    pub tiles: usize,
    /// Triangles of their finest surfaces.
    pub triangles: usize,
    /// Largest claim for a finest surface.
    pub claimed_finest: f64,
    /// Largest claim for a finest surface of a leaf.
    pub claimed_leaves: f64,
    /// Largest deviation of a finest surface.
    pub measured_finest: f64,
    /// Largest claim for a coarsest surface.
    pub claimed_coarsest: f64,
    /// Largest deviation of a coarsest surface.
    pub measured_coarsest: f64,
    /// Largest measured deviation over claim, of all levels of all tiles.
    pub worst_ratio: f64,
    /// Largest claim for an outline, in plan view.
    pub claimed_outline: f64,
    /// Largest distance of an outline, in plan view.
    pub measured_outline: f64,
}

/// The result of [`super::archive`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ArchiveReport {
    /// `surface` or `samples`: where errors were measured.
    pub bound: String,
    /// By zoom, coarsest first.
    pub zooms: Vec<ZoomReport>,
    /// Levels of detail measured, of all tiles.
    pub levels: usize,
    /// Sides shared by two tiles of one zoom, each compared fine and coarse.
    pub shared_sides: usize,
    /// Tiles whose finest surface was compared with the coarsest ones of their children.
    pub parents: usize,
    /// Tiles drawn in random selections of zooms, levels and sides, to find gaps between them.
    pub mixed_tiles: usize,
    /// How many claims do not hold.
    pub violation_count: usize,
    /// The first of them.
    pub violations: Vec<Violation>,
}

impl ArchiveReport {
    /// Whether every claim holds.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.violation_count == 0
    }

    /// Counts all `violations` and keeps the first.
    pub(super) fn set_violations(&mut self, violations: Vec<Violation>) {
        self.violation_count = violations.len();
        self.violations = violations;
        self.violations.truncate(TOLD);
    }
}

impl fmt::Display for ArchiveReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "                          finest, metres          coarsest, metres        worst   outline, metres"
        )?;
        writeln!(
            f,
            "zoom   tiles  triangles   claimed     measured    claimed     measured    ratio   claimed     measured"
        )?;
        for zoom in &self.zooms {
            writeln!(
                f,
                "{:>4} {:>7} {:>10}   {:<11} {:<11} {:<11} {:<11} {:<7.4} {:<11} {:<11}",
                zoom.zoom,
                zoom.tiles,
                zoom.triangles,
                metres(zoom.claimed_finest),
                metres(zoom.measured_finest),
                metres(zoom.claimed_coarsest),
                metres(zoom.measured_coarsest),
                zoom.worst_ratio,
                metres(zoom.claimed_outline),
                metres(zoom.measured_outline),
            )?;
        }
        self.violations
            .iter()
            .try_for_each(|violation| writeln!(f, "violation: {violation}"))?;
        write!(f, "{}", verdict(self.violation_count))?;
        write!(
            f,
            "{} levels of detail against the source's {}, {} shared sides, nesting under {} tiles, {} tiles drawn in random mixes",
            self.levels, self.bound, self.shared_sides, self.parents, self.mixed_tiles
        )
    }
}

/// The result of [`super::mesh`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeshReport {
    /// `surface` or `samples`: what the claim is for.
    pub bound: String,
    /// How many vertices.
    pub vertices: usize,
    /// How many triangles.
    pub triangles: usize,
    /// The claimed error, metres.
    pub claimed: f64,
    /// Largest deviation at samples, metres.
    pub measured_at_samples: f64,
    /// Largest deviation anywhere, metres.
    pub measured_between_samples: f64,
    /// How many claims do not hold.
    pub violation_count: usize,
    /// The first of them.
    pub violations: Vec<Violation>,
}

impl MeshReport {
    /// Whether the mesh is sound and the claim holds.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.violation_count == 0
    }

    /// Counts all `violations` and keeps the first.
    pub(super) fn set_violations(&mut self, violations: Vec<Violation>) {
        self.violation_count = violations.len();
        self.violations = violations;
        self.violations.truncate(TOLD);
    }
}

impl fmt::Display for MeshReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{} triangles, {} vertices", self.triangles, self.vertices)?;
        writeln!(f, "claimed error           {} m ({})", metres(self.claimed), self.bound)?;
        writeln!(f, "measured at samples     {} m", metres(self.measured_at_samples))?;
        writeln!(f, "measured between them   {} m", metres(self.measured_between_samples))?;
        self.violations
            .iter()
            .try_for_each(|violation| writeln!(f, "violation: {violation}"))?;
        write!(
            f,
            "{}every sample covered, no void covered, error within the claim",
            verdict(self.violation_count)
        )
    }
}

fn verdict(violations: usize) -> String {
    match violations {
        0 => "verified: ".to_owned(),
        1 => "FAILED: 1 violation in: ".to_owned(),
        count => format!("FAILED: {count} violations in: "),
    }
}

fn metres(value: f64) -> String {
    format!("{value:.4}")
}
