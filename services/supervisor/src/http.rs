//! HTTP: is it alive, is it ready, what does it count, and what does it know.

use std::collections::BTreeMap;
use std::net::SocketAddr;

use axum::Router;
use axum::extract::State;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Json, Response};
use axum::routing::get;
use serde_json::json;
use tokio::net::TcpListener;
use tokio::sync::watch;

use crate::metrics::Metrics;
use crate::readiness::Readiness;
use crate::store::{Store, StoreError};

/// What the handlers share.
#[derive(Debug, Clone)]
struct Shared {
    store: Store,
    metrics: Metrics,
    readiness: Readiness,
}

/// Why HTTP is not served.
#[derive(Debug, thiserror::Error)]
#[error("cannot listen for HTTP on {address}: {source}; choose another address with --http")]
pub struct ListenError {
    address: SocketAddr,
    source: std::io::Error,
}

/// Serves until `stop`. Returns the address, which tells the port where 0 was asked for.
///
/// # Errors
/// The address is taken.
pub async fn serve(
    address: SocketAddr,
    store: Store,
    metrics: Metrics,
    readiness: Readiness,
    mut stop: watch::Receiver<bool>,
) -> Result<(SocketAddr, tokio::task::JoinHandle<()>), ListenError> {
    let failed = |source| ListenError { address, source };
    let listener = TcpListener::bind(address).await.map_err(failed)?;
    let bound = listener.local_addr().map_err(failed)?;
    let router = Router::new()
        .route("/livez", get(livez))
        .route("/readyz", get(readyz))
        .route("/metrics", get(metrics_text))
        .route("/v1/whiskers", get(whiskers))
        .route("/v1/compensations", get(compensations))
        .with_state(Shared { store, metrics, readiness });
    let task = tokio::spawn(async move {
        let stopped = async move {
            let _ = stop.wait_for(|&stop| stop).await;
        };
        if let Err(problem) = axum::serve(listener, router).with_graceful_shutdown(stopped).await {
            tracing::error!(%problem, "HTTP has stopped");
        }
    });
    Ok((bound, task))
}

async fn livez() -> &'static str {
    "alive\n"
}

/// Ready means: every fleet that is supervised here is heard, and the database takes what is written. A supervisor
/// that stands by for another is ready.
async fn readyz(State(shared): State<Shared>) -> Response {
    let mut reasons = shared.readiness.problems();
    let fleets = shared.readiness.fleets();
    if let Err(problem) = shared.store.ping().await {
        reasons.insert(problem.to_string());
    }
    let is_ready = reasons.is_empty();
    let status = if is_ready { StatusCode::OK } else { StatusCode::SERVICE_UNAVAILABLE };
    (status, Json(json!({ "ready": is_ready, "reasons": reasons, "fleets": fleets }))).into_response()
}

async fn metrics_text(State(shared): State<Shared>) -> Response {
    match shared.metrics.text() {
        Ok(text) => ([(header::CONTENT_TYPE, prometheus::TEXT_FORMAT)], text).into_response(),
        Err(problem) => (StatusCode::INTERNAL_SERVER_ERROR, problem.to_string()).into_response(),
    }
}

async fn whiskers(State(shared): State<Shared>) -> Response {
    answer("whiskers", shared.store.whiskers().await)
}

async fn compensations(State(shared): State<Shared>) -> Response {
    answer("compensations", shared.store.compensations().await)
}

/// A list under its name, or a problem in the form of RFC 9457.
fn answer<T: serde::Serialize>(name: &'static str, rows: Result<Vec<T>, StoreError>) -> Response {
    match rows {
        // Not a JSON value: the fields keep their order.
        Ok(rows) => Json(BTreeMap::from([(name, rows)])).into_response(),
        Err(problem) => {
            tracing::error!(%problem, "a query failed");
            let status = StatusCode::SERVICE_UNAVAILABLE;
            let body = json!({ "title": "the database does not answer", "status": status.as_u16(), "detail": problem.to_string() });
            (status, [(header::CONTENT_TYPE, "application/problem+json")], body.to_string()).into_response()
        }
    }
}
