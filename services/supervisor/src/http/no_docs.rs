//! Stands in for the module `docs` in a build without the feature `api-page`.

use axum::Router;
use axum::response::{IntoResponse, Response};
use axum::routing::get;

use super::problem::{Kind, Problem};

/// Says at `/docs` how to get the page.
pub(super) fn routes() -> Router {
    Router::new().route("/docs", get(missing)).route("/docs/{*path}", get(missing)).route("/docs/", get(missing))
}

async fn missing() -> Response {
    let what =
        "this program was built without the API's page: build it with --features api-page, or read /openapi.json";
    Problem::new(Kind::NotFound, what).into_response()
}
