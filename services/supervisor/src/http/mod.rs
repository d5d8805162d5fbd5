//! HTTP: the operators' console, the API under `/v1`, its documentation, liveness and readiness.
//!
//! `server` accepts and limits connections. A request passes `passage` (request ID, log span, time limit), then
//! `access` (no requests of other sites; authentication and authorisation), then its handler in `api`, which parses it
//! with `extract` and calls the store or the engine. Errors are a `Problem`. The OpenAPI document is generated from the
//! handlers (`document`).

mod accept;
pub mod access;
mod ambiguity;
pub mod api;
pub mod asking;
pub mod client_address;
mod completion;
mod console;
pub mod csv_rows;
pub mod document;
pub mod extract;
mod fleets;
mod further_routes;
mod headers;
mod health;
pub mod labels;
pub mod listing;
pub mod moment;
pub mod number;
pub mod page;
pub mod passage;
pub mod places;
pub mod problem;
pub mod runbooks;
pub mod search;
pub mod server;
pub mod streams;
pub mod version;
pub mod words;

use std::net::{AddrParseError, SocketAddr};
use std::str::FromStr;
use std::sync::Arc;

use axum::Router;
use axum::body::Bytes;
use axum::extract::{DefaultBodyLimit, FromRef};
use axum::http::header;
use axum::middleware::{from_fn, from_fn_with_state, map_response};
use axum::response::IntoResponse;
use axum::routing::get;
use tokio::net::{TcpListener, TcpSocket};
use tokio::sync::watch;
use tokio::task::JoinHandle;
use utoipa::openapi::OpenApi as Document;
use utoipa_axum::router::OpenApiRouter;
use vibrissa_core::robot::Params;
use vibrissa_host::task;
use vibrissa_protocol::{Name, plain};

use crate::action_notifier::ActionNotifier;
use crate::engine::rollout;
use crate::metrics::Metrics;
use crate::params;
use crate::readiness::Readiness;
use crate::robots_file::RobotsFile;
use crate::trace::Traces;
use crate::webhooks::{Pace, WebhookOptions, Webhooks};
use access::{Access, Gate, guests, origin};
use client_address::{Network, TrustedProxies};
pub use further_routes::FurtherRoutes;
use places::{PlaceLimits, Places};
use server::{Limits, Server};
use streams::{StreamOptions, Streams};
use vibrissa_edge::guidance::RUNBOOKS;
use vibrissa_store::{Store, StoreError};

/// State shared by the handlers.
#[derive(Debug, Clone)]
pub struct App {
    /// Database of the service.
    pub store: Store,
    /// Metrics of the service.
    pub metrics: Metrics,
    /// Readiness: the fleets owned here, and the reasons why the service is not ready.
    pub readiness: Readiness,
    /// Decides who is let in.
    pub access: Access,
    /// The open event streams, and their limits.
    pub streams: Streams,
    /// Becomes true when the service stops.
    pub stop: watch::Receiver<bool>,
    /// Parameters of the core, from the configuration.
    pub params: Arc<Params>,
    /// Passes actions to engines, and their answers back.
    pub action_notifier: ActionNotifier,
    /// Exporter of request traces, if configured.
    pub traces: Option<Traces>,
    /// Allow list of robots from a file, if configured.
    pub robots_file: Option<watch::Receiver<Arc<RobotsFile>>>,
    /// Sends tests to webhooks.
    pub webhooks: Webhooks,
    /// Places of tests of webhooks, each of which holds a thread until its target answers.
    pub webhook_tests: Places,
    /// Where the runbooks are, without a slash at the end.
    pub runbooks_url: Arc<str>,
    /// Path below which browsers reach this service, without a slash at the end; mostly empty.
    pub base_path: Arc<str>,
    /// Routes beside those of the API.
    pub further_routes: FurtherRoutes,
}

/// Tests of webhooks at the same time.
const WEBHOOK_TESTS: PlaceLimits = PlaceLimits { total_max: 16, per_fleet_max: 4, per_caller_max: 2 };

impl FromRef<App> for Readiness {
    fn from_ref(app: &App) -> Self {
        app.readiness.clone()
    }
}

impl App {
    /// State of the handlers. Event streams may stay open until `stop` becomes true.
    #[must_use]
    pub fn new(
        store: Store,
        metrics: Metrics,
        readiness: Readiness,
        access: Access,
        action_notifier: ActionNotifier,
        params: Arc<Params>,
        stop: watch::Receiver<bool>,
    ) -> Self {
        let streams = Streams::new(StreamOptions::default());
        let delivery = (WebhookOptions::default().sender(), Pace::default());
        let webhooks = Webhooks::new(delivery, store.clone(), metrics.clone(), "http".into());
        let webhook_tests = Places::new("tests of webhooks", WEBHOOK_TESTS);
        Self {
            store,
            metrics,
            readiness,
            access,
            streams,
            stop,
            params,
            action_notifier,
            traces: None,
            robots_file: None,
            webhooks,
            webhook_tests,
            runbooks_url: RUNBOOKS.into(),
            base_path: "".into(),
            further_routes: FurtherRoutes::default(),
        }
    }

    /// Adds traces of requests, if there is a collector.
    #[must_use]
    pub fn traced(self, traces: Option<Traces>) -> Self {
        Self { traces, ..self }
    }

    /// Replaces the path below which browsers reach this service, and the place of the runbooks, if another is configured.
    #[must_use]
    pub fn reached_at(self, base_path: &str, runbooks_url: Option<&str>) -> Self {
        let runbooks_url = match runbooks_url {
            Some(url) => url.trim_end_matches('/').into(),
            None => format!("{base_path}{}", RUNBOOKS).into(),
        };
        Self { runbooks_url, base_path: base_path.into(), ..self }
    }

    /// Adds routes beside those of the API.
    #[must_use]
    pub fn with_routes(self, further_routes: FurtherRoutes) -> Self {
        Self { further_routes, ..self }
    }

    /// Replaces the limits of event streams.
    #[must_use]
    pub fn with_streams(self, options: StreamOptions) -> Self {
        Self { streams: Streams::new(options), ..self }
    }

    /// Adds the allow list of a file.
    #[must_use]
    pub fn allowing(self, robots_file: Option<watch::Receiver<Arc<RobotsFile>>>) -> Self {
        Self { robots_file, ..self }
    }

    /// Replaces the sender of webhooks.
    #[must_use]
    pub fn delivering(self, webhooks: Webhooks) -> Self {
        Self { webhooks, ..self }
    }
}

impl App {
    /// Parameters of a robot: those of the configuration, overridden by its fleet's policy and activated calibrations, and by
    /// a roll-out that has changed this robot.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn params_of(&self, fleet: &Name, robot: &Name) -> Result<Arc<Params>, StoreError> {
        let policy = self.store.policy(fleet.as_str()).await?;
        let params = params::with_policy(self.params.clone(), policy.as_ref());
        let params = params::with_calibrations(params, &self.store.active_calibrations(fleet.as_str()).await?).0;
        let open = self.store.open_rollout(fleet.as_str()).await?;
        Ok(open.map_or(params.clone(), |open| rollout::params_of(open, params, robot)))
    }
}

/// Size limit of a request's body in bytes, unless a route sets another.
const BODY_BYTES_MAX: usize = 64 * 1024;

/// Failure to listen for HTTP.
#[derive(Debug, thiserror::Error)]
#[error("cannot listen for HTTP on {address}: {}; choose another address with {flag}", plain::io(source))]
pub struct ListenError {
    address: SocketAddr,
    source: std::io::Error,
    flag: &'static str,
}

/// Addresses and connection limits of the HTTP service.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HttpOptions {
    /// Main listener; port 0 takes any free port.
    pub listen: SocketAddr,
    /// Optional listener for the monitoring routes only, without tokens.
    pub monitoring_listen: Option<SocketAddr>,
    /// Connection limits of the main listener.
    pub limits: Limits,
    /// Address of the runbooks; `None` for those of this service.
    pub runbooks_url: Option<String>,
    /// Path below which browsers reach this service through a proxy, without a slash at the end; empty without one.
    pub base_path: String,
    /// Proxies whose `X-Forwarded-For` names the client.
    pub trusted_proxies: Vec<Network>,
}

impl From<SocketAddr> for HttpOptions {
    fn from(listen: SocketAddr) -> Self {
        let (limits, trusted_proxies) = (Limits::default(), Vec::new());
        let base_path = String::new();
        Self { listen, monitoring_listen: None, limits, runbooks_url: None, base_path, trusted_proxies }
    }
}

impl From<([u8; 4], u16)> for HttpOptions {
    fn from(listen: ([u8; 4], u16)) -> Self {
        SocketAddr::from(listen).into()
    }
}

impl FromStr for HttpOptions {
    type Err = AddrParseError;

    fn from_str(text: &str) -> Result<Self, AddrParseError> {
        text.parse::<SocketAddr>().map(Self::from)
    }
}

/// The running HTTP service.
#[derive(Debug)]
pub struct Serving {
    /// Address of the main listener, with the real port if port 0 was configured.
    pub address: SocketAddr,
    /// Address of the monitoring listener, if configured.
    pub monitoring: Option<SocketAddr>,
    /// Ends when the service has stopped and the requests under way are answered.
    pub task: JoinHandle<()>,
}

/// Connection limits of the monitoring listener: enough for a few Prometheus servers and health checks.
const MONITORING_LIMITS: Limits = Limits { connections_max: 64, connections_per_address_max: 32 };

/// Serves HTTP until `stop` becomes true.
///
/// # Errors
/// An address is in use or cannot be bound.
pub async fn serve(options: &HttpOptions, app: App, stop: watch::Receiver<bool>) -> Result<Serving, ListenError> {
    let mut app = app.reached_at(&options.base_path, options.runbooks_url.as_deref());
    app.access = app.access.behind(TrustedProxies::new(&options.trusted_proxies));
    let limits = server::possible(options.limits, server::descriptors::raise_limit());
    let monitored = match options.monitoring_listen {
        Some(address) => {
            let (listener, bound) = listen(address, "--http-monitoring-listen")?;
            let metrics = app.metrics.http.connections("monitoring");
            let (router, limits, stop) = (monitoring(app.clone()), MONITORING_LIMITS, stop.clone());
            Some((bound, Server { name: "monitoring", listener, router, limits, metrics, stop }))
        }
        None => None,
    };
    let (listener, address) = listen(options.listen, "--http")?;
    let metrics = app.metrics.http.connections("main");
    let (router, _) = router(app);
    let server = Server { name: "main", listener, router, limits, metrics, stop };
    let (monitoring, monitored) = monitored.unzip();
    let task = task::spawn(async move {
        // Both must be awaited: a dropped server closes its connections.
        tokio::join!(server.run(), async {
            if let Some(server) = monitored {
                server.run().await;
            }
        });
    });
    Ok(Serving { address, monitoring, task })
}

/// Length of the accept queue. While it is full, a new client waits a second. Linux allows no more by default.
const BACKLOG: u32 = 4096;

fn listen(address: SocketAddr, flag: &'static str) -> Result<(TcpListener, SocketAddr), ListenError> {
    let failed = |source| ListenError { address, source, flag };
    let socket = if address.is_ipv4() { TcpSocket::new_v4() } else { TcpSocket::new_v6() }.map_err(failed)?;
    // Without this option the port cannot be bound for a minute after a restart.
    socket.set_reuseaddr(true).map_err(failed)?;
    socket.bind(address).map_err(failed)?;
    let listener = socket.listen(BACKLOG).map_err(failed)?;
    let bound = listener.local_addr().map_err(failed)?;
    Ok((listener, bound))
}

/// The complete router, and the OpenAPI document of the routes under `/v1` and of the further ones.
pub fn router(app: App) -> (Router, Document) {
    let routes = OpenApiRouter::with_openapi(document::base()).merge(api::routes()).merge(app.further_routes.router());
    let (api, mut document) = routes.split_for_parts();
    let roles = Arc::new(document::Roles::of(&mut document));
    completion::complete(&mut document, app.access.is_open());
    let gate = Gate { store: app.store.clone(), access: app.access.clone(), roles };
    // Serialised once: all requests share the bytes.
    let served = Bytes::from(document.to_json().unwrap_or_default());
    let router = Router::new()
        .merge(api.route_layer(from_fn_with_state(gate.clone(), access::check)))
        .merge(health::routes().route_layer(from_fn_with_state(gate, access::monitoring::check)))
        .route(
            "/openapi.json",
            get(async move || ([(header::CONTENT_TYPE, "application/json")], served).into_response()),
        )
        .route("/problems/{name}", get(problem::explain))
        .merge(runbooks::routes())
        .merge(access::oidc_routes().route_layer(from_fn_with_state(app.access.clone(), guests::limit_sign_ins)))
        .route("/livez", get(health::livez))
        .with_state(app.clone())
        .merge(console::routes());
    (around(router, &app), document)
}

/// The routes of the monitoring listener, without tokens.
fn monitoring(app: App) -> Router {
    let router = health::routes().route("/livez", get(health::livez)).with_state(app.clone());
    around(router, &app)
}

/// Adds the layers common to all requests and answers.
fn around(router: Router, app: &App) -> Router {
    router
        .layer(DefaultBodyLimit::max(BODY_BYTES_MAX))
        .layer(from_fn(origin::refuse_other_sites))
        .layer(from_fn(ambiguity::refuse))
        .layer(from_fn_with_state(
            (app.metrics.http.clone(), app.traces.clone(), app.base_path.clone()),
            passage::passage,
        ))
        .layer(map_response(headers::of_all))
        // Without it each connection would rebuild the routes.
        .with_state(())
}
