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

/// The routes that reveal more than whether the process runs.
pub(super) fn told() -> Router<App> {
    Router::new().route("/readyz", get(readyz)).route("/metrics", get(metrics))
}

pub(super) async fn livez() -> &'static str {
    "alive\n"
}

/// Ready: the messages of every fleet owned here are received, and the database accepts writes. Standby is ready too.
async fn readyz(State(app): State<App>) -> Response {
    let mut reasons = app.readiness.problems();
    let (shards, nodes) = (app.readiness.shards(), app.readiness.nodes());
    let fleets: BTreeMap<String, _> = shards.iter().map(|(shard, standing)| (shard.to_string(), standing)).collect();
    let nodes: BTreeMap<String, _> = nodes.into_iter().map(|(shard, nodes)| (shard.to_string(), nodes)).collect();
    if let Err(problem) = app.store.ping().await {
        tracing::debug!(%problem, "not ready");
        reasons.insert(problem.told());
    }
    let is_ready = reasons.is_empty();
    let status = if is_ready { StatusCode::OK } else { StatusCode::SERVICE_UNAVAILABLE };
    let body = json!({ "ready": is_ready, "reasons": reasons, "fleets": fleets, "mqtt_nodes": nodes });
    (status, Json(body)).into_response()
}

async fn metrics(State(app): State<App>) -> Result<Response, Problem> {
    app.metrics.http.streams.set(app.streams.count() as i64);
    let text = app.metrics.text().map_err(|problem| {
        tracing::error!(%problem, "cannot encode the metrics");
        Problem::new(Kind::Internal, "the metrics cannot be encoded; see the log")
    })?;
    Ok(([(header::CONTENT_TYPE, prometheus::TEXT_FORMAT)], text).into_response())
}
