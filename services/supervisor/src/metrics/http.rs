//! Requests over HTTP, by route: a path that no route has is `other`, whatever it is.

use std::time::Duration;

use axum::http::{Method, StatusCode};
use prometheus::{
    HistogramOpts, HistogramVec, IntCounter, IntCounterVec, IntGauge, IntGaugeVec, Opts, Registry, Result,
};

use super::Word;

/// The route of paths that no route has, and the method that nobody has heard of.
const OTHER: &str = "other";
const SECONDS: [f64; 9] = [0.001, 0.002, 0.005, 0.01, 0.05, 0.1, 0.5, 2.5, 20.0];

/// Requests over HTTP.
#[derive(Debug, Clone)]
pub struct HttpMetrics {
    requests: IntCounterVec,
    seconds: HistogramVec,
    /// Live streams that are open.
    pub streams: IntGauge,
    open: IntGaugeVec,
    closed: IntCounterVec,
    refused: IntCounterVec,
    accept_errors: IntCounterVec,
}

/// The server's reasons for closing a connection: a new connection needs its place, no request came, a request did not go on, or
/// the client did not read an answer.
const CLOSED: [Word; 4] = [DISPLACED, "IDLE", "SLOW_ANSWER", "SLOW_REQUEST"];
const DISPLACED: Word = "DISPLACED";
/// The limits that can refuse a connection: per address, or in total.
const REFUSED: [Word; 2] = ["ADDRESS", "TOTAL"];

/// Connections of one listener.
#[derive(Debug, Clone)]
pub struct ConnectionMetrics {
    /// Connections that are open.
    pub open: IntGauge,
    /// Connections that the system could not give.
    pub accept_errors: IntCounter,
    displaced: IntCounter,
    closed: IntCounterVec,
    refused: IntCounterVec,
    listener: Word,
}

impl ConnectionMetrics {
    /// Counts a connection that was closed for another one.
    pub fn displaced(&self) {
        self.displaced.inc();
    }

    /// Counts a connection that the server closed for that reason.
    pub fn closed(&self, reason: Word) {
        self.closed.with_label_values(&[self.listener, reason]).inc();
    }

    /// Counts a connection that was refused because of that limit.
    pub fn refused(&self, limit: Word) {
        self.refused.with_label_values(&[self.listener, limit]).inc();
    }
}

impl HttpMetrics {
    pub(super) fn declare(registry: &Registry) -> Result<Self> {
        let requests = Opts::new("vibrissa_http_requests_total", "Requests answered, by route and status.");
        let requests = IntCounterVec::new(requests, &["method", "route", "status"])?;
        let seconds = HistogramOpts::new("vibrissa_http_request_seconds", "Time until an answer begins, by route.");
        let seconds = HistogramVec::new(seconds.buckets(SECONDS.to_vec()), &["method", "route"])?;
        let streams = IntGauge::new("vibrissa_http_streams", "Live streams that are open.")?;
        registry.register(Box::new(requests.clone()))?;
        registry.register(Box::new(seconds.clone()))?;
        registry.register(Box::new(streams.clone()))?;
        let open = Opts::new("vibrissa_http_connections", "Connections that are open, by listener.");
        let open = IntGaugeVec::new(open, &["listener"])?;
        let closed = Opts::new(
            "vibrissa_http_connections_closed_total",
            "Connections closed by the server because another one needed the place, no request came, an answer was not taken, or a \
             request did not go on.",
        );
        let closed = IntCounterVec::new(closed, &["listener", "reason"])?;
        let refused = Opts::new(
            "vibrissa_http_connections_refused_total",
            "Connections refused because of a limit while all others had requests under way.",
        );
        let refused = IntCounterVec::new(refused, &["listener", "limit"])?;
        let accept_errors = Opts::new(
            "vibrissa_http_accept_errors_total",
            "Failed attempts to accept a connection, such as for want of file descriptors.",
        );
        let accept_errors = IntCounterVec::new(accept_errors, &["listener"])?;
        registry.register(Box::new(open.clone()))?;
        for family in [&closed, &refused, &accept_errors] {
            registry.register(Box::new(family.clone()))?;
        }
        Ok(Self { requests, seconds, streams, open, closed, refused, accept_errors })
    }

    /// The metrics of a listener's connections. Asking for them makes them be shown.
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

    /// Counts an answer. `route` is the route's pattern, none if no route has the path.
    pub fn answered(&self, method: &Method, route: Option<&str>, status: StatusCode, time: Duration) {
        let method = known(method);
        let route = route.unwrap_or(OTHER);
        self.requests.with_label_values(&[method, route, status.as_str()]).inc();
        self.seconds.with_label_values(&[method, route]).observe(time.as_secs_f64());
    }
}

/// A method's name; callers can make methods up.
fn known(method: &Method) -> &str {
    let known = [Method::GET, Method::HEAD, Method::POST, Method::PUT, Method::DELETE, Method::OPTIONS, Method::PATCH];
    if known.contains(method) { method.as_str() } else { OTHER }
}
