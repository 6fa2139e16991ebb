//! Serves terrain archives over HTTP: to CesiumJS and its kin as quantized-mesh, to our own viewer as the progressive
//! tiles that they are, and to a browser the viewer itself.
//!
//! | path | what |
//! | --- | --- |
//! | `/` | the viewer, embedded in the program |
//! | `/healthz`, `/readyz` | `ok` while the server runs, and while it has archives and is not about to stop |
//! | `/metrics` | figures for Prometheus |
//! | `/tilesets` | name, version and metadata of every archive, as JSON |
//! | `/{name}/layer.json` | what CesiumJS asks first |
//! | `/{name}/{z}/{x}/{y}.terrain` | quantized-mesh 1.0, extensions on request |
//! | `/{name}/3d-tiles/tileset.json` | 3D Tiles with certified errors, and below it the tiles as GLB |
//! | `/{name}/3d-terrain/tileset.json` | the implicit tileset that CesiumJS takes for its globe, and below it subtrees and tiles |
//! | `/{name}/height`, `/{name}/profile` and others | heights at places and along paths: [`elevation`] |
//! | `/{name}/terrarium.json`, `/{name}/mapbox.json` | TileJSON of raster tiles of heights, and below it the tiles |
//! | `/{name}/gradients/{z}/{x}/{y}.webp` | normals of a tile's square, for light: `raster_dem/gradients.rs`, or `.png` |
//! | `/docs`, `/openapi.json` | a page to try them on, and their description |
//! | `/{name}/{z}/{x}/{y}.spt` | our own tile, by byte ranges where asked |
//! | `/curved.html?model={name}` | the viewer of curved models |
//! | `/{name}/curved.clod` | curved levels of detail |
//! | `/model.html?model={name}` | the viewer of progressive meshes |
//! | `/{name}/model.spm` | a mesh with its levels of detail |
//!
//! Errors are one sentence of JSON: `{"error": "…"}`; 400 for what no archive could have, 404 for what these do not have.

mod answer;
mod bodies;
mod catalogue;
mod coding;
mod documentation;
mod elevation;
mod failure;
mod form;
mod guard;
mod heights;
mod listen;
mod mercator;
mod metrics;
mod models;
mod observe;
mod page;
mod raster_dem;
mod remembered;
mod remote;
mod server;
mod service;
mod settings;
mod three_d_tiles;
mod tiles;
mod tileset;

pub use catalogue::Catalogue;
pub use listen::serve;
pub use metrics::Metrics;
pub use models::ModelFile;
pub use observe::ACCESS;
pub use server::Server;
pub use service::Shared;
pub use settings::{AccessLog, Given, Settings};
