//! Serves HTTP from a private database, without a broker.

use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::sync::Arc;

use serde_json::Value;
use tempfile::TempDir;
use tokio::sync::watch;
use vibrissa_core::mechanics::Formulation;
use vibrissa_core::robot::Params;
use vibrissa_store::{DatabaseAddress, Store};
use vibrissa_supervisor::action_notifier::ActionNotifier;
use vibrissa_supervisor::http::{
    App, HttpOptions,
    access::{Access, AccessOptions},
    serve,
    streams::StreamOptions,
};
use vibrissa_supervisor::metrics::Metrics;
use vibrissa_supervisor::readiness::Readiness;
use vibrissa_tests::postgres::Postgres;
use vibrissa_tests::wait::until;
use vibrissa_tests::web::{Answer, ask};

use crate::rows::{self, Written};

/// A running HTTP server, stopped on drop.
pub(crate) struct Served {
    pub(crate) store: Store,
    pub(crate) http: SocketAddr,
    /// URL of the database if it is a server.
    pub(crate) url: Option<String>,
    /// Address of the database.
    pub(crate) database: DatabaseAddress,
    /// Rows in the database.
    pub(crate) written: Written,
    _stop: watch::Sender<bool>,
    _server: Option<Postgres>,
    _folder: Option<TempDir>,
}

impl Served {
    /// Serves the rows of two fleets from SQLite.
    pub(crate) async fn sqlite() -> Self {
        let folder = tempfile::tempdir().unwrap();
        Self::over(
            DatabaseAddress::Sqlite(folder.path().join("v.sqlite3")),
            None,
            Some(folder),
            &AccessOptions::default(),
            StreamOptions::default(),
        )
        .await
    }

    /// Serves the same rows from PostgreSQL.
    pub(crate) async fn postgres() -> Self {
        let server = Postgres::start().await;
        let address = Postgres::url(server.port()).parse().unwrap();
        Self::over(address, Some(server), None, &AccessOptions::default(), StreamOptions::default()).await
    }

    /// Serves the same rows with access control.
    pub(crate) async fn to(access: &AccessOptions) -> Self {
        Self::streaming(access, StreamOptions::default()).await
    }

    /// Serves the same rows with access control and other limits of event streams.
    pub(crate) async fn streaming(access: &AccessOptions, streams: StreamOptions) -> Self {
        let folder = tempfile::tempdir().unwrap();
        Self::over(DatabaseAddress::Sqlite(folder.path().join("v.sqlite3")), None, Some(folder), access, streams).await
    }

    /// Serves the same rows from PostgreSQL with access control and other limits of event streams.
    pub(crate) async fn streaming_from_postgres(access: &AccessOptions, streams: StreamOptions) -> Self {
        let server = Postgres::start().await;
        Self::over(Postgres::url(server.port()).parse().unwrap(), Some(server), None, access, streams).await
    }

    async fn over(
        address: DatabaseAddress,
        server: Option<Postgres>,
        folder: Option<TempDir>,
        access: &AccessOptions,
        streams: StreamOptions,
    ) -> Self {
        let url = server.as_ref().map(|server| Postgres::url(server.port()));
        let store = Store::open(&address, "test").await.unwrap();
        store.prepare().await.unwrap();
        let written = rows::write(&store).await;
        let (http, stop) = listen(&store, access, streams).await;
        Self { store, http, url, database: address, written, _stop: stop, _server: server, _folder: folder }
    }

    /// Another server of the same database. It stops with the sender.
    pub(crate) async fn another(&self, access: &AccessOptions) -> (SocketAddr, watch::Sender<bool>) {
        let store = Store::open(&self.database, "another").await.unwrap();
        listen(&store, access, StreamOptions::default()).await
    }

    /// The answer to a GET. Status 429 (too many requests) is retried.
    pub(crate) async fn get(&self, path: &str) -> Answer {
        let asked =
            async || Some(ask(self.http, "GET", path, &[]).await.unwrap()).filter(|answer| answer.status != 429);
        until("an answer", asked).await
    }

    /// The JSON of a successful answer.
    pub(crate) async fn json(&self, path: &str) -> Value {
        let answer = self.get(path).await;
        assert_eq!(answer.status, 200, "{path}: {}", answer.body);
        answer.json()
    }

    /// The items of a successful answer.
    pub(crate) async fn items(&self, path: &str) -> Vec<Value> {
        self.json(path).await["items"].as_array().unwrap().clone()
    }

    /// The items of all pages.
    pub(crate) async fn all(&self, path: &str) -> Vec<Value> {
        let mut items = Vec::new();
        let mut cursor = String::new();
        loop {
            let page = self.json(&format!("{path}{cursor}")).await;
            items.extend(page["items"].as_array().unwrap().iter().cloned());
            match page["next_cursor"].as_str() {
                Some(next) => cursor = format!("&cursor={next}"),
                None => return items,
            }
        }
    }
}

/// Serves a database without a broker.
async fn listen(store: &Store, access: &AccessOptions, streams: StreamOptions) -> (SocketAddr, watch::Sender<bool>) {
    let (stop, stopped) = watch::channel(false);
    let (metrics, params) = (Metrics::new(false).unwrap(), Arc::new(Params::nguyen_2021(Formulation::Published)));
    let public_url = access.oidc.as_ref().and_then(|oidc| oidc.sign_in.as_ref()).map(|sign_in| &sign_in.public_url);
    let base_path = public_url
        .map_or_else(String::new, |url| url.parse::<url::Url>().unwrap().path().trim_end_matches('/').to_owned());
    let access = Access::new(access, IpAddr::V4(Ipv4Addr::LOCALHOST));
    let (readiness, action_notifier) = (Readiness::default(), ActionNotifier::default());
    let app = App::new(store.clone(), metrics, readiness, access, action_notifier, params, stopped.clone());
    let app = app.with_streams(streams);
    let options = HttpOptions { base_path, ..([127, 0, 0, 1], 0).into() };
    let http = serve(&options, app, stopped).await.unwrap().address;
    (http, stop)
}
