//! Figures for Prometheus.

use std::fmt;
use std::sync::Arc;
use std::time::Duration;

use prometheus_client::encoding::EncodeLabelSet;
use prometheus_client::encoding::text::encode;
use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::gauge::Gauge;
use prometheus_client::metrics::histogram::Histogram;
use prometheus_client::registry::Registry;

/// Bounds of the classes that answers' times are counted in, seconds.
const SECONDS: [f64; 10] = [0.0001, 0.0003, 0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 10.0];

/// All figures; shared by whoever counts.
#[derive(Clone)]
pub struct Metrics {
    registry: Arc<Registry>,
    requests: Family<Answered, Counter>,
    seconds: Family<Route, Histogram, fn() -> Histogram>,
    body_bytes: Counter,
    /// Answers from memory.
    pub(crate) remembered: Counter,
    /// Open connections.
    pub(crate) connections: Gauge,
    /// Connections that waited because too many were open.
    pub(crate) waiting: Counter,
    tilesets: Gauge,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash, EncodeLabelSet)]
struct Route {
    route: &'static str,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash, EncodeLabelSet)]
struct Answered {
    route: &'static str,
    status: u16,
}

impl Default for Metrics {
    fn default() -> Self {
        let mut registry = Registry::with_prefix("terrain");
        let requests = Family::default();
        let seconds = Family::new_with_constructor(time_classes as fn() -> Histogram);
        let body_bytes = Counter::default();
        let remembered = Counter::default();
        let connections = Gauge::default();
        let waiting = Counter::default();
        let tilesets = Gauge::default();
        registry.register("requests", "Answers by route and status", requests.clone());
        registry.register("answer_seconds", "Time until an answer's body begins", seconds.clone());
        registry.register("body_bytes", "Bytes of answers' bodies", body_bytes.clone());
        registry.register(
            "remembered_answers",
            "Answers to what was asked before in the same words",
            remembered.clone(),
        );
        registry.register("connections", "Open connections", connections.clone());
        registry.register(
            "waiting_connections",
            "Connections that had to wait for others",
            waiting.clone(),
        );
        registry.register("tilesets", "Archives that are served", tilesets.clone());
        Self {
            registry: Arc::new(registry),
            requests,
            seconds,
            body_bytes,
            remembered,
            connections,
            waiting,
            tilesets,
        }
    }
}

fn time_classes() -> Histogram {
    Histogram::new(SECONDS)
}

impl Metrics {
    /// Counts an answer.
    pub(crate) fn count(&self, route: &'static str, status: u16, elapsed: Duration, bytes: u64) {
        self.seconds
            .get_or_create(&Route { route })
            .observe(elapsed.as_secs_f64());
        self.requests.get_or_create(&Answered { route, status }).inc();
        self.body_bytes.inc_by(bytes);
    }

    /// All figures in the text format of OpenMetrics.
    pub(crate) fn text(&self, tilesets: usize) -> Result<String, fmt::Error> {
        self.tilesets.set(tilesets as i64);
        let mut text = String::new();
        encode(&mut text, &self.registry)?;
        Ok(text)
    }
}
