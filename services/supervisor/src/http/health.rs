//! Is it alive, is it ready, what does it count: for orchestrators and Prometheus, who have no tokens.

use axum::extract::State;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Json, Response};
use serde_json::json;

use super::{App, FOLLOWERS_MAX};

pub(super) async fn livez() -> &'static str {
    "alive\n"
}

/// Ready means: every fleet that is supervised here is heard, and the database takes what is written. A supervisor
/// that stands by for another is ready.
pub(super) async fn readyz(State(app): State<App>) -> Response {
    let mut reasons = app.readiness.problems();
    let fleets = app.readiness.fleets();
    if let Err(problem) = app.store.ping().await {
        reasons.insert(problem.to_string());
    }
    let is_ready = reasons.is_empty();
    let status = if is_ready { StatusCode::OK } else { StatusCode::SERVICE_UNAVAILABLE };
    (status, Json(json!({ "ready": is_ready, "reasons": reasons, "fleets": fleets }))).into_response()
}

pub(super) async fn metrics(State(app): State<App>) -> Response {
    let open = FOLLOWERS_MAX - app.followers.available_permits();
    app.metrics.http.streams.set(open as i64);
    match app.metrics.text() {
        Ok(text) => ([(header::CONTENT_TYPE, prometheus::TEXT_FORMAT)], text).into_response(),
        Err(problem) => (StatusCode::INTERNAL_SERVER_ERROR, problem.to_string()).into_response(),
    }
}
