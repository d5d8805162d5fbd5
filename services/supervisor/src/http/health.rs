//! Liveness, readiness and metrics, for orchestrators and Prometheus.

use std::collections::BTreeMap;

use axum::Router;
use axum::extract::State;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Json, Response};
use axum::routing::get;
use serde_json::json;

use super::App;
use super::problem::{Kind, Problem};
use crate::readiness::Readiness;

/// The routes that reveal more than whether the process runs.
pub(super) fn routes() -> Router<App> {
    Router::new().route("/readyz", get(readyz)).route("/metrics", get(metrics))
}

pub(super) async fn livez() -> &'static str {
    "alive\n"
}

/// Ready: the messages of every fleet owned here are received, committed and receipted, and the database renews the leases.
/// Standby is ready too.
///
/// The answer is what the parts of the service have noted. The handler has no database, so that it answers at once also
/// while the database hangs.
async fn readyz(State(readiness): State<Readiness>) -> Response {
    let reasons = readiness.problems();
    let (fleets, nodes) = (readiness.fleets(), readiness.nodes());
    let promises: BTreeMap<String, _> =
        readiness.promises().into_iter().map(|(fleet, ages)| (fleet.to_string(), ages)).collect();
    let fleets: BTreeMap<String, _> = fleets.iter().map(|(fleet, standing)| (fleet.to_string(), standing)).collect();
    let nodes: BTreeMap<String, _> = nodes.into_iter().map(|(fleet, nodes)| (fleet.to_string(), nodes)).collect();
    let is_ready = reasons.is_empty();
    let status = if is_ready { StatusCode::OK } else { StatusCode::SERVICE_UNAVAILABLE };
    let body = json!({
        "ready": is_ready, "reasons": reasons, "notices": readiness.notices(), "fleets": fleets,
        "mqtt_nodes": nodes, "oldest_open_s": promises,
    });
    (status, Json(body)).into_response()
}

async fn metrics(State(app): State<App>) -> Result<Response, Problem> {
    app.metrics.http.streams.set(app.streams.count() as i64);
    app.metrics.rows_set_aside(app.store.set_aside().count());
    let text = app.metrics.text().map_err(|problem| {
        tracing::error!(%problem, "cannot encode the metrics");
        Problem::new(Kind::Internal, "the metrics cannot be encoded; see the log")
    })?;
    Ok(([(header::CONTENT_TYPE, prometheus::TEXT_FORMAT)], text).into_response())
}

#[cfg(test)]
mod tests {
    use std::task::{Context, Poll, Waker};

    use super::*;

    /// While PostgreSQL was frozen, `/readyz` took three seconds, longer than an orchestrator waits.
    #[test]
    fn regress_readyz_waits_for_nothing() {
        let readiness = Readiness::default();
        let status = || {
            let answer = std::pin::pin!(readyz(State(readiness.clone())));
            match answer.poll(&mut Context::from_waker(Waker::noop())) {
                Poll::Ready(answer) => answer.status(),
                Poll::Pending => panic!("it waits"),
            }
        };
        assert_eq!(status(), StatusCode::OK);
        readiness.set("database", Some("it does not answer".to_owned()));
        assert_eq!(status(), StatusCode::SERVICE_UNAVAILABLE);
    }
}
