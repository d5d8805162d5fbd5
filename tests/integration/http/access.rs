//! Authentication and roles of all routes.

use std::collections::BTreeSet;

use futures_util::future::join_all;
use serde_json::{Value, json};
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::TcpSocket;
use vibrissa_simulator::clock::now_us;
use vibrissa_store::secret::Secret;
use vibrissa_supervisor::http::access::token::{NewToken, create};
use vibrissa_supervisor::http::access::{AccessOptions, Role, Scope};
use vibrissa_tests::web::{Answer, ask, open, send};

use crate::served::Served;

const HOUR_US: i64 = 3_600_000_000;
const ROOT: &str = "a-token-of-more-than-32-characters-for-the-test";

async fn closed() -> Served {
    Served::to(&AccessOptions { token: Some(Secret::new(ROOT)), oidc: None }).await
}

async fn token(served: &Served, role: Role, fleets: Option<&[&str]>, good_for_us: i64) -> String {
    let scope = fleets.map_or(Scope::All, |fleets| Scope::of(fleets.iter().map(|fleet| fleet.parse().unwrap())));
    let now_us = now_us() as i64;
    let new = NewToken {
        name: format!("{}-{fleets:?}", role.word()),
        role,
        scope,
        expires_us: now_us + good_for_us,
        created_by: "test".to_owned(),
    };
    create(&served.store, &new, now_us).await.unwrap().0
}

async fn asked(served: &Served, method: &str, path: &str, token: Option<&str>) -> Answer {
    let bearer = token.map(|token| format!("Bearer {token}"));
    let headers: Vec<(&str, &str)> = bearer.iter().map(|bearer| ("Authorization", bearer.as_str())).collect();
    send(served.http, method, path, &headers, None).await.unwrap()
}

/// Fills each parameter of a path for fleet `f`. No robot is named, because the request would wait for an engine, which
/// does not run here.
fn filled(path: &str) -> String {
    let values = [
        ("{fleet}", "f"),
        ("{robot}", "nobody"),
        ("{array}", "left"),
        ("{whisker}", "0"),
        ("{compensation_id}", "1"),
        ("{alarm_id}", "0"),
        ("{action_id}", "1"),
        ("{rollout_id}", "1"),
        ("{key}", "hall"),
        ("{trim_id}", "1"),
        ("{health_change_id}", "1"),
        ("{test_id}", "t"),
        ("{calibration_id}", "1"),
        ("{command_id}", "x"),
        ("{webhook_id}", "1"),
        ("{maintenance_id}", "1"),
    ];
    values.into_iter().fold(path.to_owned(), |path, (part, value)| path.replace(part, value))
}

/// Every route of the OpenAPI document with the role that it requires according to the document.
async fn routes(served: &Served) -> Vec<(String, String, Role)> {
    let document: Value = asked(served, "GET", "/openapi.json", None).await.json();
    let mut routes = Vec::new();
    for (path, methods) in document["paths"].as_object().unwrap() {
        for (method, operation) in methods.as_object().unwrap().iter().filter(|(method, _)| *method != "parameters") {
            let role = Role::of_word(operation["x-required-role"].as_str().unwrap()).unwrap();
            routes.push((method.to_ascii_uppercase(), path.clone(), role));
        }
    }
    assert!(routes.len() > 40, "{}", routes.len());
    routes
}

/// The role that a route should require, derived from its method and path.
fn expected(method: &str, path: &str) -> Role {
    let is_admins = |path: &str| !path.contains("dead-letters") && !path.ends_with("/test");
    match (method, path) {
        // A webhook sends data to other programs, and its URL may be confidential.
        ("GET", path) if path.contains("webhooks") => Role::Operator,
        (_, path) if path.contains("webhooks") && is_admins(path) => Role::Admin,
        ("GET", _) => Role::Viewer,
        (_, path) if path.contains("/labels/") || path.contains("/notes/") => Role::Operator,
        // Who owns what is a matter of the deployment.
        ("PUT" | "DELETE", _) => Role::Engineer,
        (_, path) if ["calibrations", "rollouts", "policies"].iter().any(|part| path.contains(part)) => Role::Engineer,
        _ => Role::Operator,
    }
}

#[tokio::test]
async fn every_route_for_every_role_in_every_fleet() {
    let served = closed().await;
    let mut callers: Vec<(Option<Role>, bool, Option<String>)> = vec![(None, false, None)];
    for role in Role::ALL {
        for (covers, fleets) in [(true, None), (true, Some(&["g", "f"][..])), (false, Some(&["g"][..]))] {
            callers.push((Some(role), covers, Some(token(&served, role, fleets, HOUR_US).await)));
        }
    }
    callers.push((Some(Role::Admin), true, Some(ROOT.to_owned())));
    for (method, path, declared) in routes(&served).await {
        assert_eq!(declared, expected(&method, &path), "{method} {path}");
        let is_of_fleet = path.contains("{fleet}");
        let filled = filled(&path);
        for (role, covers, token) in &callers {
            // A stream does not end, so only its status is read.
            let status = if path == "/v1/events" {
                let bearer = token.as_ref().map(|token| format!("Bearer {token}")).unwrap_or_default();
                open(served.http, &filled, &[("Authorization", &bearer)]).await.unwrap().0
            } else {
                asked(&served, &method, &filled, token.as_deref()).await.status
            };
            let what = format!("{method} {filled} as {role:?}, covered: {covers}: {status}");
            match role {
                None => assert_eq!(status, 401, "{what}"),
                Some(role) if *role < declared => assert_eq!(status, 403, "{what}"),
                Some(_) if is_of_fleet && !covers => assert_eq!(status, 403, "{what}"),
                Some(_) => assert!(!matches!(status, 401 | 403 | 500), "{what}"),
            }
        }
    }
}

#[tokio::test]
async fn a_caller_learns_name_role_fleets_and_expiry() {
    let open = Served::sqlite().await;
    let me = open.json("/v1/me").await;
    let local = json!({ "name": "local", "actor": "local", "role": "ADMIN", "fleets": null,
        "authentication": "LOOPBACK", "expires_at": null });
    assert_eq!(me, local);
    let served = closed().await;
    let root = asked(&served, "GET", "/v1/me", Some(ROOT)).await.json();
    assert_eq!([&root["actor"], &root["authentication"]], ["token_file", "TOKEN_FILE"]);
    let viewer = token(&served, Role::Viewer, Some(&["g", "f"]), HOUR_US).await;
    let me = asked(&served, "GET", "/v1/me", Some(&viewer)).await.json();
    let row = served.store.tokens(now_us() as i64).await.unwrap().remove(0);
    assert_eq!(me["name"], row.name);
    assert_eq!(me["actor"], format!("token:{}#{}", row.name, row.token_id));
    assert_eq!(me["expires_at"], vibrissa_store::time::Time(row.expires_us).to_string());
    assert_eq!([&me["role"], &me["authentication"]], ["VIEWER", "TOKEN"]);
    assert_eq!(me["fleets"], json!(["f", "g"]));
    let endless = token(&served, Role::Viewer, None, 9000 * 365 * 24 * HOUR_US).await;
    let me = asked(&served, "GET", "/v1/me", Some(&endless)).await.json();
    assert_eq!([&me["fleets"], &me["expires_at"]], [&Value::Null, &Value::Null]);
}

#[tokio::test]
async fn only_good_tokens_open() {
    let served = closed().await;
    let good = token(&served, Role::Viewer, None, HOUR_US).await;
    assert_eq!(asked(&served, "GET", "/v1/whiskers", Some(&good)).await.status, 200);
    let expired = token(&served, Role::Admin, None, -1).await;
    let revoked = token(&served, Role::Admin, None, HOUR_US).await;
    let id = revoked.split('_').nth(1).unwrap();
    assert!(served.store.revoke_token(id, now_us() as i64).await.unwrap());
    assert!(!served.store.revoke_token(id, now_us() as i64).await.unwrap(), "once");
    let mut forged = good.clone();
    let last = forged.pop().unwrap();
    forged.push(if last == 'A' { 'Q' } else { 'A' });
    let (id, secret) = (good.split('_').nth(1).unwrap(), revoked.splitn(3, '_').nth(2).unwrap());
    let mixed = format!("vbr_{id}_{secret}");
    for bad in [&expired, &revoked, &forged, &mixed, "vbr_", "vbr__", "x", &ROOT[1..], "eyJhbGciOiJub25lIn0.e30."] {
        let answer = asked(&served, "GET", "/v1/whiskers", Some(bad)).await;
        assert_eq!(
            (answer.status, answer.headers.get("www-authenticate").map(String::as_str)),
            (401, Some("Bearer")),
            "{bad}"
        );
        assert_eq!(answer.json()["type"], "/problems/unauthenticated");
    }
    let secrets: Vec<Vec<u8>> =
        served.store.tokens(now_us() as i64).await.unwrap().into_iter().map(|row| row.secret_hash).collect();
    assert!(secrets.iter().all(|hash| hash.len() == 32 && !good.as_bytes().windows(32).any(|part| part == hash)));
}

#[tokio::test]
async fn without_tokens_only_this_machine_is_answered_and_no_other_sites_page() {
    let served = Served::sqlite().await;
    let status = async |method: &str, headers: &[(&str, &str)]| {
        let path = if method == "GET" { "/v1/whiskers" } else { "/v1/fleets/f/robots/nobody/hold" };
        send(served.http, method, path, headers, None).await.unwrap().status
    };
    for host in ["localhost:8080", "127.0.0.1", "[::1]:9", "127.9.9.9:1"] {
        assert_eq!(status("GET", &[("Host", host)]).await, 200, "{host}");
    }
    for host in ["evil.example", "localhost.evil.example:80", "192.0.2.1:8080", ""] {
        assert_eq!(status("GET", &[("Host", host)]).await, 403, "{host}");
    }
    assert_eq!(status("GET", &[("X-Forwarded-For", "192.0.2.1")]).await, 401);
    assert_eq!(status("POST", &[]).await, 404);
    assert_eq!(status("POST", &[("Origin", "https://evil.example")]).await, 403);
    assert_eq!(status("POST", &[("Sec-Fetch-Site", "cross-site")]).await, 403);
    let own = format!("http://{}", served.http);
    assert_eq!(status("POST", &[("Origin", &own), ("Sec-Fetch-Site", "same-origin")]).await, 404);
}

#[tokio::test]
async fn requests_keep_a_good_name_and_get_one_instead_of_a_bad_one() {
    let served = Served::sqlite().await;
    let named = async |name: &str| {
        let answer = send(served.http, "GET", "/v1/nothing", &[("X-Request-Id", name)], None).await.unwrap();
        assert_eq!(answer.json()["request_id"], json!(answer.headers["x-request-id"]));
        answer.headers["x-request-id"].clone()
    };
    assert_eq!(named("q-17").await, "q-17");
    let long = "x".repeat(129);
    for bad in ["a b", &long] {
        let given = named(bad).await;
        assert!(given != *bad && given.len() == 32, "{given}");
    }
}

#[tokio::test]
async fn bodies_are_of_the_right_kind_and_size_and_name_what_is_wrong() {
    let served = Served::sqlite().await;
    let path = "/v1/fleets/f/robots/r1/arrays/left/whiskers/0/setpoint";
    let problem = async |body: Value| {
        let answer = send(served.http, "POST", path, &[], Some(&body)).await.unwrap();
        let answered = answer.json();
        assert_eq!(answer.headers["content-type"], "application/problem+json");
        (answer.status, answered["errors"][0]["field"].as_str().unwrap_or_default().to_owned())
    };
    assert_eq!(problem(json!({})).await, (422, "pressure_mpa".to_owned()));
    assert_eq!(problem(json!({ "pressure_mpa": "0.1" })).await, (422, "pressure_mpa".to_owned()));
    assert_eq!(problem(json!({ "pressure_mpa": 0.1, "now": true })).await, (422, "now".to_owned()));
    assert_eq!(problem(json!({ "pressure_mpa": 0.1, "reason": "x".repeat(1001) })).await, (422, "reason".to_owned()));
    assert_eq!(problem(json!({ "pressure_mpa": 0.1, "reason": "x".repeat(70_000) })).await.0, 413);
    let plain = send(served.http, "POST", path, &[("Content-Type", "text/plain")], None).await.unwrap();
    assert_eq!(plain.status, 415, "{}", plain.body);
    let body = json!({ "pressure_mpa": 0.1 });
    let key = send(served.http, "POST", path, &[("Idempotency-Key", "a b")], Some(&body)).await.unwrap();
    assert_eq!(key.json()["errors"][0]["field"], "Idempotency-Key");
}

/// Words of the program's libraries, which only their authors understand.
const JARGON: [&str; 10] =
    ["u16", "u32", "i64", "f64", "serde", "invalid type", "invalid digit", "unknown variant", "struct ", "EOF"];

#[tokio::test]
async fn wrong_values_of_paths_queries_and_bodies_are_explained_in_plain_words() {
    let served = Served::sqlite().await;
    let whisker = "/v1/fleets/f/robots/r1/arrays/left/whiskers";
    let (bad_number, setpoint) = (format!("{whisker}/abc"), format!("{whisker}/0/setpoint"));
    for (method, path, body, field, said) in [
        ("GET", bad_number.as_str(), None, "whisker", "\"abc\" was given"),
        ("GET", "/v1/whiskers?limit=many", None, "limit", "number"),
        ("GET", "/v1/whiskers?condition=TRIM", None, "condition", "allowed are"),
        ("GET", "/v1/whiskers?colour=red", None, "colour", "the fields are"),
        ("POST", &setpoint, Some(json!({})), "pressure_mpa", "required"),
        ("POST", &setpoint, Some(json!({ "pressure_mpa": "0.1" })), "pressure_mpa", "was given"),
        ("POST", &setpoint, Some(json!("0.1")), "", "was given"),
    ] {
        let answer = send(served.http, method, path, &[], body.as_ref()).await.unwrap();
        let error = answer.json()["errors"][0].clone();
        assert_eq!((answer.status, &error["field"]), (422, &json!(field)), "{path}: {}", answer.body);
        assert!(answer.body.contains(&said.replace('"', "\\\"")), "{path}: {}", answer.body);
        // The number of the request is random, and its hexadecimal digits can read "f64".
        let explained = answer.body.replace(answer.json()["request_id"].as_str().unwrap(), "");
        assert!(!JARGON.iter().any(|word| explained.contains(word)), "{path}: {}", answer.body);
    }
}

#[tokio::test]
async fn regress_a_flood_of_wrong_tokens_keeps_no_right_one_out() {
    let served = closed().await;
    let old = token(&served, Role::Viewer, None, HOUR_US).await;
    assert_eq!(asked(&served, "GET", "/v1/me", Some(&old)).await.status, 200);
    let mut statuses = BTreeSet::new();
    for _ in 0..30 {
        let wrong = (0..50).map(|_| asked(&served, "GET", "/v1/me", Some("vbr_0123456789ab_wrong")));
        statuses.extend(join_all(wrong).await.into_iter().map(|answer| answer.status));
    }
    // A slow machine does not reach the limit, which has a test of its own.
    assert!(statuses.is_subset(&BTreeSet::from([401, 429])), "{statuses:?}");
    let new = token(&served, Role::Viewer, None, HOUR_US).await;
    for right in [&old, &new, ROOT] {
        assert_eq!(asked(&served, "GET", "/v1/me", Some(right)).await.status, 200);
    }
}

#[tokio::test]
async fn regress_requests_with_two_meanings_are_refused() {
    let served = Served::sqlite().await;
    let own = served.http.to_string();
    let status =
        async |target: &str, headers: &[(&str, &str)]| ask(served.http, "GET", target, headers).await.unwrap().status;
    let absolute = |host: &str| format!("http://{host}/v1/me");
    assert_eq!(status(&absolute(&own), &[("Host", &own)]).await, 200);
    assert_eq!(status(&absolute("evil.example"), &[("Host", &own)]).await, 400);
    assert_eq!(status(&absolute(&own), &[("Host", "evil.example")]).await, 400);
    assert_eq!(status("/v1/me", &[("Host", &own), ("Host", "evil.example")]).await, 400);
    assert_eq!(status("/livez", &[("Host", &own), ("Host", &own)]).await, 400);
    assert_eq!(status("/v1/me", &[("Authorization", "Bearer a"), ("Authorization", "Bearer b")]).await, 400);
}

/// Status of a request to sign in, from an address of this machine.
async fn sign_in_from(served: &Served, last: u8) -> u16 {
    let socket = TcpSocket::new_v4().unwrap();
    socket.bind(([127, 0, 0, last], 0).into()).unwrap();
    let mut stream = socket.connect(served.http).await.unwrap();
    let request = "GET /auth/sign-in HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";
    stream.write_all(request.as_bytes()).await.unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).await.unwrap();
    answer.split(' ').nth(1).unwrap().parse().unwrap()
}

#[tokio::test]
async fn regress_a_flood_of_sign_ins_from_one_address_locks_nobody_else_out() {
    let served = Served::sqlite().await;
    let mut flood = Vec::new();
    for _ in 0..500 {
        flood.push(sign_in_from(&served, 2).await);
    }
    assert!(flood.contains(&429) && flood[0] == 404, "without a provider there is no sign-in");
    for _ in 0..20 {
        assert_eq!(sign_in_from(&served, 3).await, 404);
    }
}
