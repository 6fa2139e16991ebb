//! The surface of the finest zoom for FlightGear: triangles above the sea, cut into its buckets.
//!
//! ```text
//! tiles ─▶ triangles in space, lowered by the geoid ─▶ cut where buckets end ─▶ a .btg.gz of each, and a .stg that names it
//! ```

mod btg;
mod bucket;
mod cut;

use std::collections::BTreeSet;
use std::io::Write;

use anyhow::Context;
use flate2::Compression;
use flate2::write::GzEncoder;
use glam::DVec3;
use rayon::prelude::*;
use serde_json::json;
use terrain_codec::address::TileAddress;
use terrain_codec::ellipsoid::{Geodetic, east_north_up, normal, to_earth_centred, to_geodetic};
use terrain_tiles::archive::Reader;
use terrain_tiles::formats::three_d_tiles::{Packing, TileSurface};
use terrain_tiles::water::{MASK_SIDE, WATER};

use self::bucket::Bucket;
use self::cut::{Corner, Cut};
use super::choice::Choice;
use super::folder::{Folder, sums};
use super::sea_level::AboveSea;
use super::stored::{self, Surfaces};
use super::unusable::Unusable;

/// What ground is made of, if nothing else is asked for: a name of FlightGear's materials.
pub const USUAL_MATERIAL: &str = "Grassland";
const LAKE: &str = "Lake";
/// Triangles reach out of their tile's square by no more than this part of its side: edges that are straight in space bulge in plan.
const REACH: f64 = 0.25;

/// Writes the files of all buckets that `choice` means into `folder`, of the tiles `chosen`, of which none is below another one. Gives
/// how many buckets there are.
pub(super) fn write(
    archive: &Reader,
    chosen: &BTreeSet<TileAddress>,
    choice: &Choice,
    material: &str,
    sea: &AboveSea,
    folder: &Folder,
) -> anyhow::Result<usize> {
    let metadata = archive.metadata();
    let ground = Ground {
        archive,
        surfaces: Surfaces::of(archive),
        chosen,
        sea,
        materials: [material, LAKE],
    };
    let buckets: BTreeSet<Bucket> = Bucket::all(choice.bounds(metadata.bounds)?)
        .filter(|bucket| choice.meets(bucket.bounds()))
        .collect();
    let buckets: Vec<Bucket> = buckets.into_iter().collect();
    let written: Vec<Option<Errors>> = buckets
        .par_iter()
        .map(|&bucket| ground.write(bucket, folder))
        .collect::<anyhow::Result<_>>()?;
    let errors: Vec<Errors> = written.into_iter().flatten().collect();
    if errors.is_empty() {
        return Err(Unusable("there is no ground in that box".to_owned()).into());
    }
    let greatest = |of: fn(&Errors) -> f64| errors.iter().map(of).fold(0.0, f64::max);
    let manifest = json!({
        "generator": metadata.generator,
        "source": metadata.source.files,
        "archive": format!("{:032x}", archive.version()),
        "heights_above": sea.in_words(),
        "zoom": chosen.iter().map(|address| address.zoom).max(),
        "buckets": errors.len(),
        // Metres along the vertical, from the source.
        "certified_error": greatest(|errors| errors.certified),
        "rounding_error": greatest(|errors| errors.rounding),
        "error": greatest(|errors| errors.certified + errors.rounding),
        "files": sums(folder.path())?,
    });
    folder.write("manifest.json", &serde_json::to_vec_pretty(&manifest)?)?;
    Ok(errors.len())
}

/// Metres along the vertical, at most.
#[derive(Clone, Copy)]
struct Errors {
    /// Of the surface, from the source.
    certified: f64,
    /// Of the file, from the surface.
    rounding: f64,
}

/// Where triangles come from.
struct Ground<'a> {
    archive: &'a Reader,
    surfaces: Surfaces<'a>,
    chosen: &'a BTreeSet<TileAddress>,
    sea: &'a AboveSea,
    materials: [&'a str; 2],
}

impl Ground<'_> {
    /// Writes the files of a bucket, if that has ground.
    fn write(&self, bucket: Bucket, folder: &Folder) -> anyhow::Result<Option<Errors>> {
        let bounds = bucket.bounds();
        let mut cut = Cut::default();
        let mut certified = 0.0_f64;
        for &address in self.chosen.iter().filter(|address| may_meet(**address, bounds)) {
            certified = certified.max(self.add(address, bounds, &mut cut)?);
        }
        if cut.triangles.is_empty() {
            return Ok(None);
        }
        let [west, south, east, north] = bounds;
        let (longitude, latitude) = (west.midpoint(east), south.midpoint(north));
        let middle = Geodetic {
            longitude,
            latitude,
            height: 0.0,
        };
        let axes = east_north_up(longitude, latitude);
        let (file, moved) = btg::encode(
            &cut,
            to_earth_centred(middle),
            [axes.x_axis, axes.y_axis],
            &self.materials,
        );
        let mut gzip = GzEncoder::new(Vec::new(), Compression::best());
        gzip.write_all(&file)?;
        let (path, index) = (format!("Terrain/{}", bucket.folder()), bucket.index());
        folder.write(&format!("{path}/{index}.btg.gz"), &gzip.finish()?)?;
        folder.write(
            &format!("{path}/{index}.stg"),
            format!("OBJECT_BASE {index}.btg\n").as_bytes(),
        )?;
        Ok(Some(Errors {
            certified,
            rounding: moved / flattest(&cut),
        }))
    }

    /// Adds what of a tile is in a bucket. Gives the certified error of that.
    fn add(&self, address: TileAddress, bounds: [f64; 4], cut: &mut Cut) -> anyhow::Result<f64> {
        let finest = self.surfaces.at(address)?;
        let finest = finest.with_context(|| format!("tile {address} is not there"))?;
        let surface = TileSurface::at(&finest, stored::detail(self.archive, &finest.tile), Packing::Plain);
        let lowered = |&position: &DVec3| {
            let Geodetic {
                longitude,
                latitude,
                height,
            } = to_geodetic(position);
            let above_sea = self.sea.height(longitude, latitude, height)?;
            Ok(position + (above_sea - height) * normal(longitude, latitude))
        };
        let positions: Vec<DVec3> = surface.positions.iter().map(lowered).collect::<Result<_, Unusable>>()?;
        let corners: Vec<Corner> = positions
            .iter()
            .zip(&surface.normals)
            .map(|(&position, &normal)| Corner::new(position, normal))
            .collect();
        let water = &self.archive.metadata().water;
        let mask = (!water.is_empty()).then(|| water.mask(address));
        let before = cut.triangles.len();
        for triangle in &surface.triangles {
            let triangle = triangle.map(|index| corners[index as usize]);
            let is_water = mask.as_ref().is_some_and(|mask| is_water(address, mask, triangle));
            cut.add(triangle, bounds, usize::from(is_water));
        }
        let is_there = cut.triangles.len() > before;
        Ok(if is_there {
            surface.error.unwrap_or(f64::INFINITY)
        } else {
            0.0
        })
    }
}

/// Whether triangles of a tile may be in a box.
fn may_meet(address: TileAddress, [west, south, east, north]: [f64; 4]) -> bool {
    let side = address.degrees();
    let (left, low, reach) = (address.west(), address.south(), REACH * side);
    let is_across = [-360.0, 0.0, 360.0]
        .iter()
        .any(|turn| left + turn < east && left + side + turn > west);
    is_across && low - reach < north && low + side + reach > south
}

/// Whether the middle of a triangle is in water by a tile's mask.
fn is_water(address: TileAddress, mask: &[u8], triangle: [Corner; 3]) -> bool {
    let middle = to_geodetic(triangle.iter().map(|corner| corner.position).sum::<DVec3>() / 3.0);
    let pixel = |share: f64| ((share * MASK_SIDE as f64).floor().clamp(0.0, MASK_SIDE as f64 - 1.0)) as usize;
    let column = pixel((middle.longitude - address.west()).rem_euclid(360.0) / address.degrees());
    let row = pixel(1.0 - (middle.latitude - address.south()) / address.degrees());
    mask.get(row * MASK_SIDE + column).or(mask.first()) == Some(&WATER)
}

/// The least cosine between a triangle's normal and the vertical.
fn flattest(cut: &Cut) -> f64 {
    let upwards = |(_, triangle): &(usize, [u32; 3])| {
        let [a, b, c] = triangle.map(|index| cut.corners[index as usize].position);
        let across = (b - a).cross(c - a);
        let place = to_geodetic(a);
        let cosine = across.dot(normal(place.longitude, place.latitude)) / across.length();
        // Splinters of a cut have no direction.
        if across.length() > 1e-6 { cosine } else { 1.0 }
    };
    cut.triangles.iter().map(upwards).fold(1.0, f64::min).max(0.0)
}
