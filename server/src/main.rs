//! `terrain-server`: see `--help`.

use std::collections::HashSet;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, bail};
use clap::Parser;
use terrain_server::curved::{self, CurvedFile};
use terrain_server::{Tileset, router};
use tokio::net::TcpListener;

/// Serves terrain archives made by terrain-ingest.
///
/// Open the printed address in a browser to fly over the terrain. CesiumJS and other clients of quantized-mesh take
/// http://HOST:PORT/NAME as the address of their terrain, NAME being the archive's file name without its ending.
#[derive(Parser)]
#[command(
    version,
    after_help = "Examples:\n  terrain-server fault.pmtiles\n  terrain-server alps.pmtiles andes.pmtiles --listen 0.0.0.0:80\n\n\
        In CesiumJS:\n  viewer.terrainProvider = await Cesium.CesiumTerrainProvider.fromUrl(\n    \
        'http://127.0.0.1:8080/fault', { requestVertexNormals: true })\n\n\
        Exit codes: 0 after Ctrl-C, 2 when an archive cannot be read or the address cannot be listened on."
)]
struct Arguments {
    /// Archives to serve, and .clod files, each under its file name without its ending.
    #[arg(required = true, value_name = "ARCHIVE")]
    archives: Vec<PathBuf>,

    /// Where to listen. Port 0 takes any free port; 0.0.0.0 makes the server reachable from other machines.
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "127.0.0.1:8080")]
    listen: SocketAddr,
}

#[tokio::main]
async fn main() -> ExitCode {
    match run(&Arguments::parse()).await {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::from(2)
        }
    }
}

async fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let (models, archives): (Vec<PathBuf>, Vec<PathBuf>) = arguments
        .archives
        .iter()
        .cloned()
        .partition(|path| CurvedFile::is_one(path));
    let models = models
        .iter()
        .map(|path| CurvedFile::open(path))
        .collect::<Result<Vec<_>, _>>()?;
    let tilesets = open(&archives)?;
    let listener = TcpListener::bind(arguments.listen)
        .await
        .with_context(|| format!("cannot listen on {}", arguments.listen))?;
    let address = listener.local_addr()?;
    for tileset in &tilesets {
        println!("{}: http://{address}/{}/layer.json", tileset.name, tileset.name);
    }
    for CurvedFile { name, .. } in &models {
        println!("{name}: http://{address}/curved.html?model={name}");
    }
    println!("http://{address}/");
    axum::serve(listener, router(tilesets).merge(curved::router(models)))
        .with_graceful_shutdown(asked_to_stop())
        .await?;
    Ok(())
}

fn open(paths: &[PathBuf]) -> anyhow::Result<Vec<Tileset>> {
    let tilesets = paths
        .iter()
        .map(|path| Tileset::open(path))
        .collect::<Result<Vec<_>, _>>()?;
    let mut names = HashSet::new();
    if let Some(twin) = tilesets.iter().find(|tileset| !names.insert(&tileset.name)) {
        bail!("two archives are called “{}”; rename one", twin.name);
    }
    Ok(tilesets)
}

/// Ctrl-C, or SIGTERM from a service manager. Requests under way are answered first.
async fn asked_to_stop() {
    use tokio::signal::unix::{SignalKind, signal};
    match signal(SignalKind::terminate()) {
        Ok(mut terminate) => tokio::select! {
            _ = tokio::signal::ctrl_c() => {}
            _ = terminate.recv() => {}
        },
        Err(_) => drop(tokio::signal::ctrl_c().await),
    }
}
