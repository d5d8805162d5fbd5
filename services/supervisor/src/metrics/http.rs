//! Metrics of HTTP requests by route. Requests whose path has no route count as `other`, whatever their path.

use std::time::Duration;

use axum::http::{Method, StatusCode};
use prometheus::{
    HistogramOpts, HistogramVec, IntCounter, IntCounterVec, IntGauge, IntGaugeVec, Opts, Registry, Result,
};

use super::Word;

/// Label value for a path without a route, and for an unknown method.
const OTHER: &str = "other";
const SECONDS: [f64; 9] = [0.001, 0.002, 0.005, 0.01, 0.05, 0.1, 0.5, 2.5, 20.0];

/// Metrics of the HTTP servers.
#[derive(Debug, Clone)]
pub struct HttpMetrics {
    requests: IntCounterVec,
    seconds: HistogramVec,
    /// Open live streams.
    pub streams: IntGauge,
    open: IntGaugeVec,
    closed: IntCounterVec,
    refused: IntCounterVec,
    accept_errors: IntCounterVec,
}

/// Reasons for which the server closes a connection: a new connection needs its place, no request came, the client
/// did not read an answer, or a request stalled.
const CLOSED: [Word; 4] = [DISPLACED, "IDLE", "SLOW_ANSWER", "SLOW_REQUEST"];
const DISPLACED: Word = "DISPLACED";
/// Limits that can refuse a connection: of the client's address, or of all connections.
const REFUSED: [Word; 2] = ["ADDRESS", "TOTAL"];

/// Metrics of the connections of one listener.
#[derive(Debug, Clone)]
pub struct ConnectionMetrics {
    /// Connections that are open now.
    pub open: IntGauge,
    /// Failed attempts to accept a connection, for example because there are no free file descriptors.
    pub accept_errors: IntCounter,
    displaced: IntCounter,
    closed: IntCounterVec,
    refused: IntCounterVec,
    listener: Word,
}

impl ConnectionMetrics {
    /// Counts a connection that was closed to make room for another one.
    pub fn displaced(&self) {
        self.displaced.inc();
    }

    /// Counts a connection that the server closed, by reason.
    pub fn closed(&self, reason: Word) {
        self.closed.with_label_values(&[self.listener, reason]).inc();
    }

    /// Counts a refused connection, by limit.
    pub fn refused(&self, limit: Word) {
        self.refused.with_label_values(&[self.listener, limit]).inc();
    }
}

impl HttpMetrics {
    pub(super) fn declare(registry: &Registry) -> Result<Self> {
        let requests = Opts::new("vibrissa_http_requests_total", "Requests answered, by route and status.");
        let requests = IntCounterVec::new(requests, &["method", "route", "status"])?;
        let seconds = HistogramOpts::new(
            "vibrissa_http_request_seconds",
            "Time from a request to the begin of its answer, by route.",
        );
        let seconds = HistogramVec::new(seconds.buckets(SECONDS.to_vec()), &["method", "route"])?;
        let streams = IntGauge::new("vibrissa_http_streams", "Open live streams.")?;
        registry.register(Box::new(requests.clone()))?;
        registry.register(Box::new(seconds.clone()))?;
        registry.register(Box::new(streams.clone()))?;
        let open = Opts::new("vibrissa_http_connections", "Open connections, by listener.");
        let open = IntGaugeVec::new(open, &["listener"])?;
        let closed = Opts::new(
            "vibrissa_http_connections_closed_total",
            "Connections closed by the server because another one needed the place, no request came, an answer was not \
             read, or a request stalled.",
        );
        let closed = IntCounterVec::new(closed, &["listener", "reason"])?;
        let refused = Opts::new(
            "vibrissa_http_connections_refused_total",
            "Connections refused because of a limit while all others had requests in progress.",
        );
        let refused = IntCounterVec::new(refused, &["listener", "limit"])?;
        let accept_errors = Opts::new(
            "vibrissa_http_accept_errors_total",
            "Failed attempts to accept a connection, for example because there were no free file descriptors.",
        );
        let accept_errors = IntCounterVec::new(accept_errors, &["listener"])?;
        registry.register(Box::new(open.clone()))?;
        for family in [&closed, &refused, &accept_errors] {
            registry.register(Box::new(family.clone()))?;
        }
        Ok(Self { requests, seconds, streams, open, closed, refused, accept_errors })
    }

    /// Metrics of a listener's connections. The call creates their series, with the value 0.
    #[must_use]
    pub fn connections(&self, listener: Word) -> ConnectionMetrics {
        for reason in CLOSED {
            self.closed.with_label_values(&[listener, reason]);
        }
        for limit in REFUSED {
            self.refused.with_label_values(&[listener, limit]);
        }
        ConnectionMetrics {
            open: self.open.with_label_values(&[listener]),
            accept_errors: self.accept_errors.with_label_values(&[listener]),
            displaced: self.closed.with_label_values(&[listener, DISPLACED]),
            closed: self.closed.clone(),
            refused: self.refused.clone(),
            listener,
        }
    }

    /// Counts an answer. `route` is the pattern of the route, or `None` if the path has no route.
    pub fn answered(&self, method: &Method, route: Option<&str>, status: StatusCode, time: Duration) {
        let method = known(method);
        let route = route.unwrap_or(OTHER);
        self.requests.with_label_values(&[method, route, status.as_str()]).inc();
        self.seconds.with_label_values(&[method, route]).observe(time.as_secs_f64());
    }
}

/// Name of a method; `other` for methods that clients made up.
fn known(method: &Method) -> &str {
    let known = [Method::GET, Method::HEAD, Method::POST, Method::PUT, Method::DELETE, Method::OPTIONS, Method::PATCH];
    if known.contains(method) { method.as_str() } else { OTHER }
}
