//! A service over one small archive, asked without a socket.

#![expect(dead_code, reason = "each test program uses a part of it")]

use std::io::Read;
use std::path::{Path, PathBuf};

use axum::body::{Body, to_bytes};
use axum::http::{HeaderMap, Request, StatusCode, header};
use flate2::read::GzDecoder;
use glam::DVec3;
use serde_json::Value;
use tempfile::TempDir;
use terrain_codec::address::TileAddress;
use terrain_codec::filled::Filled;
use terrain_codec::spt;
use terrain_codec::tile::{Lineage, Tile};
use terrain_core::{Band, CollapseLog, Mesh, SurfacePartition};
use terrain_server::{Catalogue, ModelFile, Server, Settings, Shared};
use terrain_tiles::archive::Writer;
use terrain_tiles::formats::quantized_mesh::{QuantizedMesh, QuantizedMeshLimits, decode};
use terrain_tiles::metadata::{Metadata, Source, Zoom};

#[path = "../empty_archive/mod.rs"]
mod empty_archive;

pub(crate) fn address(zoom: u8, x: u32, y: u32) -> TileAddress {
    TileAddress::new(zoom, x, y).unwrap()
}

/// A square of two triangles in the middle of the tile, 500 m up.
pub(crate) fn tile(address: TileAddress) -> Tile {
    let corners = [(256.0, 256.0), (768.0, 256.0), (768.0, 768.0), (256.0, 768.0)];
    let mesh = Mesh {
        positions: corners.map(|(x, y)| DVec3::new(x, y, 500.0)).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    };
    let log = CollapseLog {
        collapses: Vec::new(),
        bands: vec![Band { end: 0, error: 1.0 }; 4],
    };
    let partition = SurfacePartition::from_log(&mesh, &log, 1.0).unwrap();
    Tile {
        address,
        extent_bits: 10,
        height_exponent: -2,
        sampling: None,
        lineage: Lineage::default(),
        breaklines: Vec::new(),
        filled: Filled::default(),
        partition,
        outline_errors: vec![0.0; 5],
    }
}

pub(crate) fn metadata() -> Metadata {
    let zoom = |zoom, available| Zoom {
        zoom,
        tiles: 1,
        triangles: 2,
        finest_error: 1.0,
        leaves: 0,
        leaf_error: 0.0,
        coarsest_error: 1.0,
        outline_error: 0.0,
        available: vec![available],
    };
    let empty = empty_archive::metadata();
    Metadata {
        bounds: [-157.5, -67.5, -112.5, -22.5],
        heights: [500.0, 500.0],
        max_zoom: 1,
        source: Source {
            files: vec!["square.tif".to_owned()],
            ..empty.source
        },
        zooms: vec![zoom(0, [0, 0, 0, 0]), zoom(1, [0, 0, 0, 0])],
        ..empty
    }
}

/// Where the archive has bytes that are no tile.
pub(crate) const DAMAGED: TileAddress = TileAddress { zoom: 2, x: 5, y: 3 };

pub(crate) fn write_archive(path: &Path) {
    let mut writer = Writer::create(path).unwrap();
    for address in [address(0, 0, 0), address(1, 0, 0)] {
        writer.add(address, &spt::encode(&tile(address)).unwrap()).unwrap();
    }
    writer.add(DAMAGED, b"no tile").unwrap();
    writer.finish(&metadata()).unwrap();
}

/// The service over one archive called `square`.
pub(crate) struct Service {
    pub(crate) server: Server,
    pub(crate) folder: TempDir,
}

pub(crate) struct Reply {
    pub(crate) status: StatusCode,
    pub(crate) headers: HeaderMap,
    pub(crate) body: Vec<u8>,
}

impl Reply {
    pub(crate) fn header(&self, name: header::HeaderName) -> &str {
        self.headers.get(name).map_or("", |value| value.to_str().unwrap())
    }

    pub(crate) fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap()
    }

    /// The body without the coding that the headers tell.
    pub(crate) fn plain(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        let body = &self.body[..];
        match self.header(header::CONTENT_ENCODING) {
            "gzip" => drop(GzDecoder::new(body).read_to_end(&mut bytes).unwrap()),
            "br" => drop(brotli::Decompressor::new(body, 4096).read_to_end(&mut bytes).unwrap()),
            "zstd" => bytes = zstd::stream::decode_all(body).unwrap(),
            _ => bytes.clone_from(&self.body),
        }
        bytes
    }

    /// The body as a quantized mesh.
    pub(crate) fn mesh(&self) -> QuantizedMesh {
        decode(&self.plain(), &QuantizedMeshLimits::default()).unwrap()
    }
}

impl Service {
    pub(crate) fn new() -> Self {
        Self::with(Settings::default())
    }

    pub(crate) fn with(settings: Settings) -> Self {
        Self::of(Vec::new(), settings)
    }

    pub(crate) fn of(models: Vec<ModelFile>, settings: Settings) -> Self {
        let folder = tempfile::tempdir().unwrap();
        write_archive(&folder.path().join("square.pmtiles"));
        let catalogue = Catalogue::open(vec![folder.path().to_owned()]).unwrap();
        Self {
            server: Server::new(Shared::new(catalogue, models, &settings), &settings).unwrap(),
            folder,
        }
    }

    pub(crate) fn archive(&self) -> PathBuf {
        self.folder.path().join("square.pmtiles")
    }

    pub(crate) async fn ask(&self, method: &str, path: &str, headers: &[(&str, &str)]) -> Reply {
        let request = Request::builder().method(method).uri(path).header("host", "here");
        let request = headers
            .iter()
            .fold(request, |builder, (name, value)| builder.header(*name, *value));
        self.answer(request.body(Body::empty()).unwrap()).await
    }

    /// A request with a body, which is JSON.
    pub(crate) async fn post(&self, path: &str, body: &str) -> Reply {
        let request = Request::post(path).header("host", "here");
        self.answer(request.body(Body::from(body.to_owned())).unwrap()).await
    }

    async fn answer(&self, request: Request<Body>) -> Reply {
        let (parts, body) = self.server.answer(request).await.into_parts();
        let body = to_bytes(body, 1 << 24).await.unwrap().to_vec();
        Reply {
            status: parts.status,
            headers: parts.headers,
            body,
        }
    }

    pub(crate) async fn get(&self, path: &str) -> Reply {
        self.ask("GET", path, &[]).await
    }
}
