//! Connections: how many there may be, how long each may be silent, and how all of them end.
//!
//! ```text
//! wait for a place among the connections ─▶ accept ─▶ serve with limits ─▶ leave the place
//! asked to stop ─▶ accept no more ─▶ let answers end ─▶ leave the rest at the deadline
//! ```

use std::convert::Infallible;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use axum::body::Body;
use axum::extract::{ConnectInfo, Request};
use axum::response::Response;
use hyper::body::{Body as _, Incoming};
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::server::graceful::{GracefulShutdown, Watcher};
use socket2::SockRef;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio_io_timeout::TimeoutStream;

use crate::metrics::Metrics;
use crate::server::Server;
use crate::settings::Settings;

/// Bytes of answers that the system keeps for a client before it has sent them. Without a limit there are up to 4 MiB for each that reads
/// slowly, and a few hundred such clients take all memory that the system has for connections: then it resets those of others.
const MOST_UNSENT: u32 = 128 << 10;
/// Open files that are not connections: archives, logs, what libraries need.
const OTHER_FILES: u64 = 64;
/// After a failure to accept, such as too many open files: those that are open end meanwhile.
const PAUSE: Duration = Duration::from_millis(100);

/// Answers what comes to `listener` by `server` until `stop` is ready, then at most as long as the settings say.
pub async fn serve(listener: TcpListener, server: Server, settings: &Settings, stop: impl Future<Output = ()>) {
    if let Err(error) = SockRef::from(&listener).set_tcp_notsent_lowat(MOST_UNSENT) {
        tracing::warn!("the system does not limit what it keeps for slow readers: {error}");
    }
    let server = Arc::new(server);
    let metrics = server.metrics();
    let places = Arc::new(Semaphore::new(most_connections(settings)));
    let connections = GracefulShutdown::new();
    tokio::pin!(stop);
    loop {
        let next = next_connection(&listener, &places, metrics);
        let (stream, peer, place) = tokio::select! {
            connection = next => connection,
            () = &mut stop => break,
        };
        let connection = Connection {
            place,
            metrics: metrics.clone(),
            watcher: connections.watcher(),
        };
        tokio::spawn(connection.serve(
            stream,
            peer,
            Arc::clone(&server),
            limits(settings),
            settings.write_timeout,
        ));
    }
    drop(listener);
    let deadline = Duration::from_secs(settings.stop_within);
    let open = connections.count();
    if tokio::time::timeout(deadline, connections.shutdown()).await.is_err() {
        tracing::warn!("stopped with connections that did not end in {deadline:?}; {open} were open");
    }
}

/// No more than the system allows this process to open, which is raised as far as it may be.
fn most_connections(settings: &Settings) -> usize {
    let wanted = settings.max_connections as u64;
    let files = rlimit::increase_nofile_limit(wanted + OTHER_FILES).unwrap_or(OTHER_FILES);
    let allowed = files.saturating_sub(OTHER_FILES).max(1).min(wanted);
    if allowed < wanted {
        tracing::warn!("{files} files may be open here: at most {allowed} connections instead of {wanted}");
    }
    usize::try_from(allowed)
        .unwrap_or(usize::MAX)
        .min(Semaphore::MAX_PERMITS)
}

async fn next_connection(
    listener: &TcpListener,
    places: &Arc<Semaphore>,
    metrics: &Metrics,
) -> (TcpStream, SocketAddr, OwnedSemaphorePermit) {
    if places.available_permits() == 0 {
        metrics.waiting.inc();
        tracing::warn!("as many connections are open as may be; others wait");
    }
    let place = Arc::clone(places).acquire_owned().await.expect("it is never closed");
    loop {
        match listener.accept().await {
            Ok((stream, peer)) => return (stream, peer, place),
            Err(error) => {
                tracing::warn!("a connection could not be accepted: {error}");
                tokio::time::sleep(PAUSE).await;
            }
        }
    }
}

fn limits(settings: &Settings) -> http1::Builder {
    let mut builder = http1::Builder::new();
    builder
        .timer(TokioTimer::new())
        .header_read_timeout(Duration::from_secs(settings.header_timeout))
        .max_buf_size(settings.max_headers << 10);
    builder
}

fn body(incoming: Incoming) -> Body {
    if incoming.is_end_stream() {
        Body::empty()
    } else {
        Body::new(incoming)
    }
}

/// One of the places, while it is taken.
struct Connection {
    place: OwnedSemaphorePermit,
    metrics: Metrics,
    watcher: Watcher,
}

impl Connection {
    async fn serve(
        self,
        stream: TcpStream,
        peer: SocketAddr,
        server: Arc<Server>,
        limits: http1::Builder,
        write_timeout: u64,
    ) {
        self.metrics.connections.inc();
        if let Err(error) = stream.set_nodelay(true) {
            tracing::debug!("{peer}: {error}");
        }
        let mut stream = TimeoutStream::new(stream);
        stream.set_write_timeout(Some(Duration::from_secs(write_timeout)));
        let answer = service_fn(move |mut request: Request<Incoming>| {
            request.extensions_mut().insert(ConnectInfo(peer));
            let server = Arc::clone(&server);
            async move { Ok::<Response, Infallible>(server.answer(request.map(body)).await) }
        });
        let connection = limits.serve_connection(TokioIo::new(Box::pin(stream)), answer);
        if let Err(error) = self.watcher.watch(connection).await {
            tracing::debug!("{peer}: {error}");
        }
        self.metrics.connections.dec();
        drop(self.place);
    }
}
