//! Access to metrics and readiness, and the listener for monitoring.

use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::time::{Duration, Instant};

use tokio::sync::watch;
use vibrissa_core::mechanics::Formulation;
use vibrissa_core::robot::Params;
use vibrissa_simulator::clock::now_us;
use vibrissa_store::{DatabaseAddress, Store};
use vibrissa_supervisor::action_notifier::ActionNotifier;
use vibrissa_supervisor::http::access::token::{NewToken, create};
use vibrissa_supervisor::http::access::{Access, AccessOptions, Role, Scope};
use vibrissa_supervisor::http::{App, serve};
use vibrissa_supervisor::metrics::Metrics;
use vibrissa_supervisor::readiness::Readiness;
use vibrissa_tests::postgres::Postgres;
use vibrissa_tests::proxy::Proxy;
use vibrissa_tests::wait::until_true;
use vibrissa_tests::web::{ask, try_get};

use crate::http_program::HttpProgram;

#[tokio::test]
async fn the_listener_for_monitoring_serves_nothing_else() {
    let program = HttpProgram::start(&[]);
    // A request of a Prometheus on another host, through a proxy and under any name.
    let headers = [("Host", "supervisor-1:9464"), ("X-Forwarded-For", "192.0.2.1")];
    until_true("ready", async || try_get(program.monitoring, "/readyz").await.unwrap().0 == 200).await;
    for (path, status) in [
        ("/livez", 200),
        ("/readyz", 200),
        ("/metrics", 200),
        ("/", 404),
        ("/console/main.js", 404),
        ("/openapi.json", 404),
        ("/v1/whiskers", 404),
        ("/v1/events", 404),
    ] {
        assert_eq!(ask(program.monitoring, "GET", path, &headers).await.unwrap().status, status, "{path}");
    }
}

#[tokio::test]
async fn regress_whoever_comes_through_a_proxy_to_loopback_needs_a_token() {
    let program = HttpProgram::start(&[]);
    for path in ["/readyz", "/metrics"] {
        until_true(path, async || try_get(program.http, path).await.unwrap().0 == 200).await;
        for headers in [("X-Forwarded-For", "192.0.2.1"), ("Forwarded", "for=192.0.2.1"), ("Host", "evil.example")] {
            let status = ask(program.http, "GET", path, &[headers]).await.unwrap().status;
            assert!(matches!(status, 401 | 403), "{path} with {headers:?}: {status}");
        }
    }
    let through_proxy = ask(program.http, "GET", "/livez", &[("X-Forwarded-For", "192.0.2.1")]).await.unwrap();
    assert_eq!(through_proxy.status, 200, "liveness must be public");
}

/// Serves with the rules of a listener beyond loopback.
async fn beyond_loopback(store: &Store, readiness: Readiness) -> (SocketAddr, watch::Sender<bool>) {
    let (stop, stopped) = watch::channel(false);
    let params = Arc::new(Params::nguyen_2021(Formulation::Published));
    let access = Access::new(&AccessOptions::default(), IpAddr::V4(Ipv4Addr::UNSPECIFIED));
    let (metrics, notifier) = (Metrics::new(false).unwrap(), ActionNotifier::default());
    let app = App::new(store.clone(), metrics, readiness, access, notifier, params, stopped.clone());
    (serve(&([127, 0, 0, 1], 0).into(), app, stopped).await.unwrap().address, stop)
}

/// The header of a new token.
async fn token(store: &Store, name: &str, scope: Scope) -> String {
    let now_us = now_us() as i64;
    let (name, expires_us, created_by) = (name.to_owned(), now_us + 3_600_000_000, "test".to_owned());
    let new = NewToken { name, role: Role::Viewer, scope, expires_us, created_by };
    format!("Bearer {}", create(store, &new, now_us).await.unwrap().0)
}

/// The listener of this test is on loopback, but the rules depend on the address given to `Access::new`.
#[tokio::test]
async fn regress_beyond_loopback_metrics_and_readiness_need_a_token_for_all_fleets() {
    let folder = tempfile::tempdir().unwrap();
    let store = Store::open(&DatabaseAddress::Sqlite(folder.path().join("v.sqlite3")), "test").await.unwrap();
    store.prepare().await.unwrap();
    let (http, _stop) = beyond_loopback(&store, Readiness::default()).await;
    let of_all = token(&store, "all", Scope::All).await;
    let of_one = token(&store, "one", Scope::of(["f".parse().unwrap()])).await;
    for path in ["/readyz", "/metrics"] {
        let status =
            async |headers: &[(&str, &str)]| ask(http, "GET", path, headers).await.map(|answer| answer.status).unwrap();
        assert_eq!(status(&[]).await, 401, "{path}");
        assert_eq!(status(&[("Authorization", "Bearer vbr_000000000000_AAAA")]).await, 401, "{path}");
        assert_eq!(status(&[("Authorization", &of_one)]).await, 403, "{path}: it includes other fleets");
        assert_eq!(status(&[("Authorization", &of_all)]).await, 200, "{path}");
    }
    assert_eq!(try_get(http, "/livez").await.unwrap().0, 200);
}

/// `/readyz` is what an orchestrator asks while the database hangs.
#[tokio::test]
async fn regress_beyond_loopback_readiness_is_told_while_the_database_hangs() {
    let server = Postgres::start().await;
    let proxy = Proxy::to(server.port()).await;
    let database: DatabaseAddress = Postgres::url(proxy.port()).parse().unwrap();
    let store = Store::open(&database, "test").await.unwrap();
    store.prepare().await.unwrap();
    let readiness = Readiness::default();
    let (http, _stop) = beyond_loopback(&store, readiness.clone()).await;
    let (known, unknown) = (token(&store, "known", Scope::All).await, token(&store, "unknown", Scope::All).await);
    let readyz = async |token: &str| {
        let answer = ask(http, "GET", "/readyz", &[("Authorization", token)]).await.unwrap();
        (answer.status, answer.body)
    };
    assert_eq!(readyz(&known).await.0, 200);
    proxy.stall(true);
    readiness.set("database", Some("it does not answer".to_owned()));
    // Also after the time for which a caller is not looked up again.
    let begun = Instant::now();
    until_true("more than five seconds", async || {
        let (status, body) = readyz(&known).await;
        assert!(status == 503 && body.contains("it does not answer"), "{status} {body}");
        begun.elapsed() > Duration::from_secs(6)
    })
    .await;
    let (status, body) = readyz(&unknown).await;
    assert!(status == 401 && body.contains("cannot be checked now"), "{status} {body}");
    proxy.stall(false);
    until_true("an answer to the other token", async || readyz(&unknown).await.1.contains("it does not answer")).await;
}
