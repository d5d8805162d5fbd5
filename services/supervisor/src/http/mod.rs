//! HTTP: the operators' console, the API under `/v1`, its documentation, and whether the service is alive and ready.
//!
//! A request passes `passage` (a name, a place in the log, a limit in time), then `access` (who asks, and whether
//! they may), then its handler in `api`, which takes it apart with `extract` and asks the store or the engine. What
//! goes wrong is a `Problem`. The OpenAPI document is read off the handlers (`document`).

pub mod access;
pub mod api;
pub mod asking;
mod console;
pub mod document;
pub mod extract;
mod health;
pub mod moment;
pub mod number;
pub mod page;
pub mod passage;
pub mod problem;
pub mod words;

use std::net::SocketAddr;
use std::sync::Arc;

use axum::Router;
use axum::extract::DefaultBodyLimit;
use axum::middleware::from_fn_with_state;
use axum::response::Json;
use axum::routing::get;
use tokio::net::TcpListener;
use tokio::sync::{Semaphore, watch};
use utoipa::openapi::OpenApi as Document;
use utoipa_axum::router::OpenApiRouter;
use utoipa_swagger_ui::{Config, SwaggerUi};
use vibrissa_core::robot::Params;

use crate::engine::mail;
use crate::mailroom::Mailroom;
use crate::metrics::Metrics;
use crate::readiness::Readiness;
use crate::store::{Store, StoreError};
use access::{Access, Gate};

/// What the handlers share.
#[derive(Debug, Clone)]
pub struct App {
    /// The database.
    pub store: Store,
    /// What is counted.
    pub metrics: Metrics,
    /// Which fleets are supervised here, and what keeps the service from its work.
    pub readiness: Readiness,
    /// Who is let in.
    pub access: Access,
    /// Places for those who follow live.
    pub followers: Arc<Semaphore>,
    /// Becomes true when the service stops.
    pub stop: watch::Receiver<bool>,
    /// The core's parameters, as the configuration has them.
    pub params: Arc<Params>,
    /// Where engines are asked for actions.
    pub mailroom: Mailroom,
}

impl App {
    /// What handlers share; they may follow live until `stop` becomes true.
    #[must_use]
    pub fn new(
        store: Store,
        metrics: Metrics,
        readiness: Readiness,
        access: Access,
        mailroom: Mailroom,
        params: Arc<Params>,
        stop: watch::Receiver<bool>,
    ) -> Self {
        let followers = Arc::new(Semaphore::new(FOLLOWERS_MAX));
        Self { store, metrics, readiness, access, followers, stop, params, mailroom }
    }
}

impl App {
    /// The parameters that a fleet works with: the configuration's, with the policy and the calibrations that people have
    /// put in force over them.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn params_of(&self, fleet: &str) -> Result<Arc<Params>, StoreError> {
        let policy = self.store.policy(fleet).await?;
        let params = mail::with_policy(self.params.clone(), policy.as_ref());
        Ok(mail::with_calibrations(params, &self.store.active_calibrations(fleet).await?))
    }
}

/// How many may follow live at once.
const FOLLOWERS_MAX: usize = 100;

/// Bytes of a body at the most, unless a route takes more.
const BODY_BYTES_MAX: usize = 64 * 1024;

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
    app: App,
    mut stop: watch::Receiver<bool>,
) -> Result<(SocketAddr, tokio::task::JoinHandle<()>), ListenError> {
    let failed = |source| ListenError { address, source };
    let listener = TcpListener::bind(address).await.map_err(failed)?;
    let bound = listener.local_addr().map_err(failed)?;
    let (router, _) = router(app);
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

/// Everything that is served, and the document of what is under `/v1`.
pub fn router(app: App) -> (Router, Document) {
    let (api, mut document) = OpenApiRouter::with_openapi(document::base()).merge(api::routes()).split_for_parts();
    let roles = Arc::new(document::Roles::of(&mut document));
    document::complete(&mut document);
    let gate = Gate { store: app.store.clone(), access: app.access.clone(), roles };
    let served = document.clone();
    let metrics = app.metrics.http.clone();
    let docs = SwaggerUi::new("/docs").config(Config::from("/openapi.json"));
    let router = Router::new()
        .merge(api.route_layer(from_fn_with_state(gate, access::check)))
        .route("/openapi.json", get(async move || Json(served)))
        .route("/problems/{name}", get(problem::explain))
        .route("/livez", get(health::livez))
        .route("/readyz", get(health::readyz))
        .route("/metrics", get(health::metrics))
        .with_state(app)
        .merge(docs)
        .merge(console::routes())
        .layer(DefaultBodyLimit::max(BODY_BYTES_MAX))
        .layer(from_fn_with_state(metrics, passage::passage));
    (router, document)
}
