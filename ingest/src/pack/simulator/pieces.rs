//! Tiles in a local frame, each place in one of them, one by one from the archive; and each as meshes to collide with.

use std::io::Write;

use anyhow::{Context, ensure};
use glam::DVec3;
use rayon::prelude::*;
use terrain_codec::address::TileAddress;
use terrain_tiles::archive::Reader;
use terrain_tiles::formats::{gltf, obj};

use super::super::folder::Folder;
use super::super::stored;
use super::frame::Frame;
use super::piece::{Bounds, Piece};
use super::usd;
use crate::archive_tiles;

/// Where the pieces of a pack come from.
pub(super) struct Pieces<'a> {
    archive: &'a Reader,
    frame: &'a Frame,
    /// In the order of their addresses.
    pub(super) records: Vec<Record>,
}

/// What is known of a piece that is not in memory.
#[derive(Clone, Debug)]
pub(super) struct Record {
    pub(super) address: TileAddress,
    /// Path of its files, without their extensions.
    pub(super) path: String,
    /// Certified vertical error, metres; with what triangles are bent on a plane.
    pub(super) error: f64,
    pub(super) bounds: Bounds,
    /// Where the point is in the frame that coordinates in files are from.
    pub(super) offset: DVec3,
    pub(super) vertices: usize,
    pub(super) triangles: usize,
    pub(super) steepest: f64,
}

impl<'a> Pieces<'a> {
    /// Writes the meshes of all tiles; holds one of them for each thread.
    pub(super) fn write(
        archive: &'a Reader,
        tiles: &[TileAddress],
        frame: &'a Frame,
        folder: &Folder,
    ) -> anyhow::Result<Self> {
        let records = tiles.par_iter().map(|&address| write(archive, address, frame, folder));
        Ok(Self {
            archive,
            frame,
            records: records.collect::<anyhow::Result<_>>()?,
        })
    }

    pub(super) fn read(&self, address: TileAddress) -> anyhow::Result<Piece> {
        let tile = archive_tiles::tile(self.archive, address)?;
        Ok(Piece::of(&tile, stored::detail(self.archive, &tile), self.frame))
    }

    pub(super) fn greatest(&self, number: impl Fn(&Record) -> f64) -> f64 {
        self.records.iter().map(number).fold(0.0, f64::max)
    }
}

fn write(archive: &Reader, address: TileAddress, frame: &Frame, folder: &Folder) -> anyhow::Result<Record> {
    let tile = archive_tiles::tile(archive, address)?;
    let detail = stored::detail(archive, &tile);
    let piece = Piece::of(&tile, detail, frame);
    let bounds = piece.bounds().with_context(|| format!("tile {address} is empty"))?;
    let offset = frame.rounded(bounds.low.midpoint(bounds.high));
    let positions = about(&piece.positions, offset).with_context(|| format!("tile {address}"))?;
    let path = format!("meshes/{}_{}_{}", address.zoom, address.x, address.y);
    let note = format!("east, north, up in metres from {offset} of the frame of manifest.json");
    folder.stream(&format!("{path}.glb"), |mut out| {
        Ok(gltf::write_for_collisions(
            &mut out,
            offset,
            &positions,
            &piece.triangles,
        )?)
    })?;
    folder.stream(&format!("{path}.obj"), |mut out| {
        let positions: Vec<DVec3> = positions.iter().map(|at| at.as_dvec3()).collect();
        Ok(obj::write(&mut out, &positions, &piece.triangles, &note)?)
    })?;
    folder.stream(&format!("{path}.usda"), |out: &mut dyn Write| {
        Ok(usd::write_mesh(out, offset, &positions, &piece.triangles)?)
    })?;
    Ok(Record {
        address,
        path,
        error: tile.error(detail) + frame.bend(piece.longest()),
        bounds,
        offset,
        vertices: piece.positions.len(),
        triangles: piece.triangles.len(),
        steepest: piece.steepest(frame),
    })
}

/// Positions from `offset`, in single precision, which has to hold them.
fn about(positions: &[DVec3], offset: DVec3) -> anyhow::Result<Vec<glam::Vec3>> {
    let near = |&at: &DVec3| {
        let single = (at - offset).as_vec3();
        ensure!(
            single.as_dvec3() == at - offset,
            "single precision does not hold {at} from {offset}"
        );
        Ok(single)
    };
    positions.iter().map(near).collect()
}
