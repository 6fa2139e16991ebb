//! From elevation rasters to an archive of progressive terrain tiles: reading, positions on the Earth, and the build.

mod border;
mod breaklines;
mod certify;
mod chunk_view;
mod chunks;
mod coarse;
pub mod curved_model;
pub mod curved_terrain;
mod distances;
pub mod georeference;
pub mod globe;
pub mod height_grid;
mod intake;
mod lattice;
mod leaf;
mod memory;
mod node;
mod outside;
pub mod pack;
pub mod polygonal_model;
pub mod progress;
pub mod pyramid;
pub mod raster;
mod raster_outline;
pub mod samples;
pub mod store;
pub mod stored_raster;
mod strips;
pub mod tin;
pub mod verify;
mod whole_raster;

pub use georeference::GeoReference;
pub use height_grid::HeightGrid;
pub use memory::{peak_memory, quarter_of_memory};
pub use progress::Progress;
pub use raster::{ReadError, ReadOptions};
