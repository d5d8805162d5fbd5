//! Access to metrics and readiness, and the listener for monitoring.

use std::net::{IpAddr, Ipv4Addr};
use std::sync::Arc;

use tokio::sync::watch;
use vibrissa_core::mechanics::Formulation;
use vibrissa_core::robot::Params;
use vibrissa_protocol::Name;
use vibrissa_simulator::fleet::now_us;
use vibrissa_store::{DatabaseAddress, Store};
use vibrissa_supervisor::action_notifier::ActionNotifier;
use vibrissa_supervisor::http::access::token::{NewToken, create};
use vibrissa_supervisor::http::access::{Access, AccessOptions, Role, Scope};
use vibrissa_supervisor::http::{App, serve};
use vibrissa_supervisor::metrics::Metrics;
use vibrissa_supervisor::readiness::Readiness;
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
        ("/docs/", 404),
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

/// The listener of this test is on loopback, but the rules depend on the address given to `Access::new`.
#[tokio::test]
async fn regress_beyond_loopback_metrics_and_readiness_need_a_token_for_all_fleets() {
    let folder = tempfile::tempdir().unwrap();
    let store = Store::open(&DatabaseAddress::Sqlite(folder.path().join("v.sqlite3")), "test").await.unwrap();
    store.prepare().await.unwrap();
    let (_stop, stopped) = watch::channel(false);
    let params = Arc::new(Params::nguyen_2021(Formulation::Published));
    let access = Access::new(&AccessOptions::default(), IpAddr::V4(Ipv4Addr::UNSPECIFIED));
    let (metrics, readiness) = (Metrics::new(false).unwrap(), Readiness::default());
    let app = App::new(store.clone(), metrics, readiness, access, ActionNotifier::default(), params, stopped.clone());
    let http = serve(&([127, 0, 0, 1], 0).into(), app, stopped).await.unwrap().address;

    let now_us = now_us() as i64;
    let token = async |name: &str, scope: Scope| {
        let (name, expires_us, created_by) = (name.to_owned(), now_us + 3_600_000_000, "test".to_owned());
        create(&store, &NewToken { name, role: Role::Viewer, scope, expires_us, created_by }, now_us).await.unwrap().0
    };
    let of_all = format!("Bearer {}", token("all", Scope::All).await);
    let fleet = Scope::Only([Name::new("f").unwrap()].into());
    let of_one = format!("Bearer {}", token("one", fleet).await);
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
