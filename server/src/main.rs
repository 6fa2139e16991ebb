//! `terrain-server`: see `--help`.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;

use anyhow::{Context, bail};
use clap::Parser;
use terrain_server::{ACCESS, AccessLog, Catalogue, Given, ModelFile, Server, Settings, Shared, serve};
use tokio::net::TcpListener;
use tokio::signal::unix::{Signal, SignalKind, signal};
use tracing_appender::non_blocking::WorkerGuard;
use tracing_subscriber::filter::{LevelFilter, filter_fn};
use tracing_subscriber::prelude::*;

#[tokio::main]
async fn main() -> ExitCode {
    match run(&Given::parse()).await {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::from(2)
        }
    }
}

async fn run(given: &Given) -> anyhow::Result<()> {
    let settings = Settings::from_given(given)?;
    // From here on signals are heard, and wait until somebody asks for them.
    let look = signal(SignalKind::hangup())?;
    let stop = [SignalKind::interrupt(), SignalKind::terminate()].map(signal);
    let (models, archives): (Vec<PathBuf>, Vec<PathBuf>) = settings
        .archives
        .iter()
        .cloned()
        .partition(|path| ModelFile::is_one(path));
    let models = models
        .iter()
        .map(|path| ModelFile::open(path))
        .collect::<anyhow::Result<Vec<_>>>()?;
    if let Some(name) = ModelFile::twin(&models) {
        bail!("two models are called “{name}”; rename one");
    }
    let catalogue = tokio::task::spawn_blocking(|| Catalogue::open(archives)).await??;
    if let Some(name) = catalogue.twin() {
        bail!("two archives are called “{name}”; rename one");
    }
    let listener = TcpListener::bind(settings.listen)
        .await
        .with_context(|| format!("cannot listen on {}", settings.listen))?;
    let address = format!("http://{}{}", listener.local_addr()?, settings.base_path);
    let service = Shared::new(catalogue, models, &settings);
    let server = Server::new(Arc::clone(&service), &settings)?;
    for name in service.catalogue.names() {
        println!("{name}: {address}/{name}/layer.json");
    }
    for ModelFile { name, kind, .. } in &service.models {
        println!("{name}: {address}/{}?model={name}", kind.page());
    }
    println!("{address}/");
    let _written_at_the_end = start_logs(settings.access_log);
    tokio::spawn(keep_looking(Arc::clone(&service), look, settings.look_every));
    let [interrupt, terminate] = stop;
    let stop = asked_to_stop(Arc::clone(&service), interrupt?, terminate?);
    serve(listener, server, &settings, stop).await;
    Ok(())
}

/// What goes wrong to standard error, the access log to standard output, from a thread of its own.
fn start_logs(access: AccessLog) -> WorkerGuard {
    let (output, guard) = tracing_appender::non_blocking(std::io::stdout());
    let is_access = |metadata: &tracing::Metadata<'_>| metadata.target() == ACCESS;
    let lines = tracing_subscriber::fmt::layer().with_target(false);
    let access_lines = lines.with_ansi(false).with_writer(output);
    let access_layer = match access {
        AccessLog::Off => None,
        AccessLog::Text => Some(access_lines.boxed()),
        AccessLog::Json => Some(access_lines.json().boxed()),
    };
    let others = tracing_subscriber::fmt::layer()
        .with_ansi(false)
        .with_target(false)
        .with_writer(std::io::stderr)
        .with_filter(LevelFilter::INFO)
        .with_filter(filter_fn(move |metadata| !is_access(metadata)));
    tracing_subscriber::registry()
        .with(others)
        .with(access_layer.map(|layer| layer.with_filter(filter_fn(is_access))))
        .init();
    guard
}

/// Looks at the archives again every so many seconds, if any, and when asked to by SIGHUP.
async fn keep_looking(service: Arc<Shared>, mut asked: Signal, seconds: u64) {
    loop {
        let pause = async {
            match seconds {
                0 => std::future::pending().await,
                seconds => tokio::time::sleep(Duration::from_secs(seconds)).await,
            }
        };
        tokio::select! {
            () = pause => {}
            _ = asked.recv() => tracing::info!("asked to look at the archives again"),
        }
        service.look_again().await;
    }
}

/// Ctrl-C, or SIGTERM from a service manager.
async fn asked_to_stop(service: Arc<Shared>, mut interrupt: Signal, mut terminate: Signal) {
    tokio::select! {
        _ = interrupt.recv() => {}
        _ = terminate.recv() => {}
    }
    service.is_about_to_stop();
}
