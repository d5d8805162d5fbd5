//! Management over REST: roles, secrets, tests, refused targets, and the audit log.

use serde_json::{Value, json};
use vibrissa_edge::clock::wall_clock;
use vibrissa_supervisor::http::access::token::{self, NewToken};
use vibrissa_supervisor::http::access::{Role, Scope};
use vibrissa_supervisor::service::Service;
use vibrissa_tests::web::{Answer, send};

use crate::delivery::is_genuine;
use crate::receiver::{Manner, Receiver};
use crate::stage::{FAST, Stage, call, hook, shown, taken};

#[tokio::test]
async fn private_addresses_are_refused_unless_they_are_allowed() {
    let stage = Stage::sqlite().await;
    let service = stage.with("a", FAST, &["hooks.lan"]).await;
    let create = async |url: &str| {
        let body = json!({ "name": url, "url": url });
        let answer = call(&service, "POST", "/v1/webhooks", Some(body)).await;
        (answer.status, answer.json())
    };
    for url in [
        "http://127.0.0.1:8080/v1/whiskers",
        "http://169.254.169.254/latest/meta-data",
        "http://[::1]/",
        "http://10.1.2.3/",
        "http://[::ffff:192.168.1.1]/",
        "http://0x7f000001/",
        "ftp://hooks.example/",
        "file:///etc/passwd",
        "https://user:hunter2@hooks.example/",
        "hooks",
    ] {
        let (status, created) = create(url).await;
        assert_eq!((status, &created["errors"][0]["field"]), (422, &json!("url")), "{url}: {created}");
        assert!(!created.to_string().contains("hunter2"), "{created}");
    }
    // A name is checked when it is resolved.
    let (status, created) = create("http://localhost:1/").await;
    assert_eq!(status, 201, "{created}");
    let path = format!("/v1/webhooks/{}/test", created["webhook"]["webhook_id"]);
    let answer = call(&service, "POST", &path, None).await.json();
    assert_eq!((&answer["delivered"], &answer["status"]), (&json!(false), &Value::Null));
    assert!(answer["problem"].as_str().unwrap().contains("webhooks.allowed_hosts"), "{answer}");
    service.stop().await;
}

#[tokio::test]
async fn a_secret_is_shown_once_and_two_are_valid_during_a_change() {
    let stage = Stage::sqlite().await;
    let receiver = Receiver::start(Manner::Status(200)).await;
    let service = stage.supervisor("a", FAST).await;
    stage.robot().await;
    let (webhook_id, old) = hook(&service, &receiver, json!({})).await;
    let renew = async |overlap_s: i64| {
        let path = format!("/v1/webhooks/{webhook_id}/secret");
        let answer = call(&service, "POST", &path, Some(json!({ "overlap_s": overlap_s }))).await;
        assert_eq!(answer.status, 200, "{}", answer.body);
        answer.json()["secret"].as_str().unwrap().to_owned()
    };
    let new = renew(3600).await;
    let mut raw = stage.raw().await;
    raw.trim(1).await;
    taken(&receiver, 1).await;
    let request = &receiver.requests()[0];
    assert!(is_genuine(&old, request) && is_genuine(&new, request) && old != new);
    let newest = renew(0).await;
    raw.trim(2).await;
    taken(&receiver, 2).await;
    let request = &receiver.requests()[1];
    assert!(is_genuine(&newest, request) && !is_genuine(&new, request) && !is_genuine(&old, request));
    for path in ["/v1/webhooks".to_owned(), format!("/v1/webhooks/{webhook_id}"), "/v1/audit".to_owned()] {
        let body = call(&service, "GET", &path, None).await.body;
        assert!(!body.contains("whsec_") && !body.contains(old.trim_start_matches("whsec_")), "{body}");
    }
    let audit = call(&service, "GET", "/v1/audit", None).await.body;
    assert!(
        audit.contains("WEBHOOK_CREATE") && audit.contains("WEBHOOK_SECRET") && !audit.contains("confidential"),
        "{audit}"
    );
    service.stop().await;
}

async fn bearer(service: &Service, role: Role, scope: Scope) -> String {
    let new = NewToken { name: format!("{role:?}"), role, scope, expires_us: i64::MAX, created_by: "test".to_owned() };
    token::create(&service.store, &new, wall_clock().0 as i64).await.unwrap().0
}

async fn as_role(service: &Service, token: &str, method: &str, path: &str, body: Option<&Value>) -> Answer {
    send(service.http, method, path, &[("Authorization", &format!("Bearer {token}"))], body).await.unwrap()
}

#[tokio::test]
async fn admins_manage_operators_test_and_viewers_see_nothing() {
    let stage = Stage::sqlite().await;
    let receiver = Receiver::start(Manner::Status(200)).await;
    let service = stage.supervisor("a", FAST).await;
    let [viewer, operator, engineer, admin] = [
        bearer(&service, Role::Viewer, Scope::All).await,
        bearer(&service, Role::Operator, Scope::All).await,
        bearer(&service, Role::Engineer, Scope::All).await,
        bearer(&service, Role::Admin, Scope::All).await,
    ];
    let only = Scope::of(["f".parse().unwrap()]);
    let of_fleet = bearer(&service, Role::Admin, only).await;
    let body = json!({ "name": "all", "url": receiver.url() });
    for token in [&viewer, &operator, &engineer] {
        assert_eq!(as_role(&service, token, "POST", "/v1/webhooks", Some(&body)).await.status, 403);
    }
    assert_eq!(as_role(&service, &of_fleet, "POST", "/v1/webhooks", Some(&body)).await.status, 403, "all fleets");
    assert_eq!(as_role(&service, &admin, "POST", "/v1/webhooks", Some(&body)).await.status, 201);
    let body = json!({ "name": "own", "url": receiver.url(), "fleets": ["f"] });
    assert_eq!(as_role(&service, &of_fleet, "POST", "/v1/webhooks", Some(&body)).await.status, 201);
    let taken_name = as_role(&service, &admin, "POST", "/v1/webhooks", Some(&body)).await;
    assert_eq!((taken_name.status, &taken_name.json()["errors"][0]["field"]), (422, &json!("name")));
    assert_eq!(as_role(&service, &viewer, "GET", "/v1/webhooks", None).await.status, 403);
    let urls = async |token: &str| -> Vec<String> {
        let list = as_role(&service, token, "GET", "/v1/webhooks", None).await.json();
        list["items"].as_array().unwrap().iter().map(|one| one["url"].as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(urls(&admin).await, [receiver.url(), receiver.url()]);
    assert_eq!(urls(&of_fleet).await, [receiver.url()], "only webhooks of its fleets");
    assert!(urls(&operator).await.iter().all(|url| url.ends_with("/\u{2026}") && !url.contains("hook")));
    assert_eq!(as_role(&service, &of_fleet, "GET", "/v1/webhooks/1", None).await.status, 404);
    let test = as_role(&service, &operator, "POST", "/v1/webhooks/2/test", None).await.json();
    assert_eq!((&test["delivered"], &test["status"]), (&json!(true), &json!(200)));
    let request = &receiver.requests()[0];
    assert_eq!((request.kind().as_str(), request.json()["data"]["fleet"].clone()), ("TEST", Value::Null));
    assert_eq!(as_role(&service, &operator, "DELETE", "/v1/webhooks/2", None).await.status, 403);
    assert_eq!(as_role(&service, &admin, "DELETE", "/v1/webhooks/2", None).await.status, 200);
    assert_eq!(as_role(&service, &admin, "GET", "/v1/webhooks/2", None).await.status, 404);
    let audit = as_role(&service, &admin, "GET", "/v1/audit", None).await.json();
    let kinds: Vec<&str> = audit["items"].as_array().unwrap().iter().filter_map(|one| one["kind"].as_str()).collect();
    for kind in ["WEBHOOK_CREATE", "WEBHOOK_TEST", "WEBHOOK_REMOVE"] {
        assert!(kinds.contains(&kind), "{kinds:?}");
    }
    service.stop().await;
}

#[tokio::test]
async fn a_webhook_of_a_pattern_gets_the_events_of_fleets_that_match() {
    let stage = Stage::sqlite().await;
    let receiver = Receiver::start(Manner::Status(200)).await;
    let service = stage.supervisor("a", FAST).await;
    stage.robot().await;
    let (others, _) = hook(&service, &receiver, json!({ "name": "others", "fleets": ["f-*", "F*", "other"] })).await;
    let (halls, _) = hook(&service, &receiver, json!({ "fleets": ["hall-*", "*f"] })).await;
    stage.raw().await.trim(1).await;
    taken(&receiver, 1).await;
    assert!(receiver.requests()[0].headers["webhook-id"].starts_with(&format!("vibrissa-{halls}-")));
    let state = shown(&service, others).await;
    assert_eq!((&state["waiting"], &state["delivered"]), (&json!(0), &json!(0)), "{state}");
    service.stop().await;
}

/// The webhook was deleted although the request was refused, and no action said so.
#[tokio::test]
async fn regress_a_key_of_another_request_deletes_no_webhook() {
    let stage = Stage::sqlite().await;
    let receiver = Receiver::start(Manner::Status(200)).await;
    let service = stage.supervisor("a", FAST).await;
    stage.robot().await;
    let key = [("Idempotency-Key", "k")];
    let body = json!({ "name": "tickets", "url": receiver.url() });
    let made = send(service.http, "POST", "/v1/webhooks", &key, Some(&body)).await.unwrap();
    let path = format!("/v1/webhooks/{}", made.json()["webhook"]["webhook_id"]);
    let refused = send(service.http, "DELETE", &path, &key, None).await.unwrap();
    assert_eq!(refused.json()["type"], "/problems/key-reused", "{}", refused.body);
    assert_eq!(call(&service, "GET", &path, None).await.status, 200);
    assert_eq!(call(&service, "DELETE", &path, None).await.status, 200);
    assert_eq!(call(&service, "GET", &path, None).await.status, 404);
    service.stop().await;
}

#[tokio::test]
async fn a_disabled_webhook_keeps_its_place_and_a_repeated_request_creates_nothing() {
    let stage = Stage::sqlite().await;
    let receiver = Receiver::start(Manner::Status(200)).await;
    let service = stage.supervisor("a", FAST).await;
    stage.robot().await;
    let body = json!({ "name": "tickets", "url": receiver.url(), "enabled": false });
    let key = [("Idempotency-Key", "k")];
    let first = send(service.http, "POST", "/v1/webhooks", &key, Some(&body)).await.unwrap();
    let again = send(service.http, "POST", "/v1/webhooks", &key, Some(&body)).await.unwrap();
    assert_eq!((first.status, again.status), (201, 201), "{}", again.body);
    assert!(first.json()["secret"].is_string() && again.json()["secret"].is_null());
    assert_eq!(first.json()["webhook"]["webhook_id"], again.json()["webhook"]["webhook_id"]);
    stage.raw().await.trim(1).await;
    assert_eq!(
        (&shown(&service, 1).await["state"], &shown(&service, 1).await["waiting"]),
        (&json!("DISABLED"), &json!(1))
    );
    let body = json!({ "name": "tickets", "url": receiver.url() });
    assert_eq!(call(&service, "PUT", "/v1/webhooks/1", Some(body)).await.status, 200);
    taken(&receiver, 1).await;
    service.stop().await;
}
