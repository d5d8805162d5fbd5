//! Requests over HTTP, by route: a path that no route has is `other`, whatever it is.

use std::time::Duration;

use axum::http::{Method, StatusCode};
use prometheus::{HistogramOpts, HistogramVec, IntCounterVec, IntGauge, Opts, Registry, Result};

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
        Ok(Self { requests, seconds, streams })
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
