//! Access without a token, limits on streams, and the actors in the audit log.

use serde_json::json;
use vibrissa_core::policy::{Mode, PolicyParams};
use vibrissa_tests::actions::policy_body;
use vibrissa_tests::wait::until;
use vibrissa_tests::web::{open, send};

use crate::started::{EmptyDatabase, ROOT};

const OPEN: [&str; 2] = ["--http", "127.0.0.1:0"];

#[tokio::test]
async fn regress_without_tokens_what_comes_through_a_proxy_is_refused() {
    let place = EmptyDatabase::sqlite();
    let started = place.start(&OPEN);
    assert_eq!(started.get("/v1/fleets", &[]).await.status, 200);
    for (name, value) in [
        ("Via", "1.1 proxy"),
        ("Forwarded", "for=192.0.2.1"),
        ("X-Forwarded-For", "192.0.2.1"),
        ("X-Forwarded-Proto", "https"),
        ("X-Forwarded-Host", "vibrissa.example"),
        ("X-Real-IP", "192.0.2.1"),
    ] {
        let answer = started.get("/v1/fleets", &[(name, value)]).await;
        assert_eq!(answer.status, 401, "{name}: {}", answer.body);
        assert!(answer.body.contains("proxy") && answer.body.contains("http.token_file"), "{}", answer.body);
    }
    // The default request of nginx as a proxy.
    let answer = raw_status(started.http, "GET /v1/fleets HTTP/1.0\r\nHost: localhost\r\n\r\n").await;
    assert_eq!(answer, "HTTP/1.0 401 Unauthorized");
    assert!(started.log().contains("needs no token"), "{}", started.log());
}

#[tokio::test]
async fn a_proxy_may_pass_on_requests_with_tokens() {
    let place = EmptyDatabase::sqlite();
    let started = place.start_closed(&[]);
    let bearer = format!("Bearer {ROOT}");
    let through = [("Authorization", bearer.as_str()), ("Via", "1.1 proxy"), ("X-Forwarded-For", "192.0.2.1")];
    assert_eq!(started.get("/v1/fleets", &through).await.status, 200);
    assert!(!started.log().contains("needs no token"), "{}", started.log());
}

async fn raw_status(http: std::net::SocketAddr, request: &str) -> String {
    use tokio::io::{AsyncReadExt, AsyncWriteExt};
    let mut stream = tokio::net::TcpStream::connect(http).await.unwrap();
    stream.write_all(request.as_bytes()).await.unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).await.unwrap();
    answer.lines().next().unwrap_or_default().to_owned()
}

#[tokio::test]
async fn regress_another_sites_page_reads_nothing_and_does_not_use_up_the_rate_limit() {
    let place = EmptyDatabase::sqlite();
    let started = place.start(&OPEN);
    let from = |site: &str| format!("GET /v1/fleets HTTP/1.1\r\nSec-Fetch-Site: {site}\r\nSec-Fetch-Mode: no-cors\r\n");
    // More requests than the burst that one caller may send.
    let foreign: Vec<String> = (0..1500).map(|n| from(if n % 2 == 0 { "cross-site" } else { "same-site" })).collect();
    let statuses = started.statuses(&foreign).await;
    assert_eq!((statuses.len(), statuses.iter().filter(|&&status| status == 403).count()), (1500, 1500));
    let own: Vec<String> = (0..900).map(|_| from("same-origin")).collect();
    let statuses = started.statuses(&own).await;
    assert_eq!((statuses.len(), statuses.iter().filter(|&&status| status == 200).count()), (900, 900));
    let navigates = [("Sec-Fetch-Site", "cross-site"), ("Sec-Fetch-Mode", "navigate"), ("Sec-Fetch-Dest", "document")];
    assert_eq!(started.get("/", &navigates).await.status, 200, "a link may lead to the console");
    for path in ["/v1/fleets", "/v1/events", "/metrics", "/readyz", "/openapi.json"] {
        assert_eq!(started.get(path, &navigates).await.status, 403, "{path}");
    }
}

#[tokio::test]
async fn regress_one_caller_cannot_take_all_streams() {
    let place = EmptyDatabase::sqlite();
    let (one, other) = (place.token("viewer", &["--all-fleets"]), place.token("viewer", &["--all-fleets"]));
    let started = place.start_closed(&[]);
    let [one, other] = [one, other].map(|token| format!("Bearer {token}"));
    let stream = async |bearer: &str| open(started.http, "/v1/events", &[("Authorization", bearer)]).await.unwrap();
    let mut streams = Vec::new();
    for _ in 0..10 {
        let (status, events) = stream(&one).await;
        assert_eq!(status, 200);
        streams.push(events);
    }
    assert_eq!(stream(&one).await.0, 429);
    let refused = started.get("/v1/events", &[("Authorization", &one)]).await;
    let problem = refused.json();
    assert_eq!((refused.status, &problem["type"]), (429, &json!("/problems/too-many-requests")), "{problem}");
    assert!(problem["detail"].as_str().unwrap().contains("10 open streams"), "{problem}");
    assert_eq!(refused.headers["retry-after"], "1");
    assert_eq!(stream(&other).await.0, 200, "another token of the same name must have its own limit");
    streams.pop();
    until("the place of the stream that was closed", async || Some(stream(&one).await).filter(|found| found.0 == 200))
        .await;
}

/// Two operators with tokens of the default name, one for each fleet, use the same key.
async fn tokens_are_actors_of_their_own(place: &EmptyDatabase) {
    let tokens = ["a", "b"].map(|fleet| (fleet, place.token("engineer", &["--fleet", fleet])));
    let started = place.start_closed(&["--fleets", "a,b"]);
    started.owns(&["a", "b"]).await;
    let policy = policy_body(&PolicyParams { mode: Mode::Advise, ..PolicyParams::default() });
    for (fleet, token) in &tokens {
        let bearer = format!("Bearer {token}");
        let headers = [("Authorization", bearer.as_str()), ("If-Match", "*"), ("Idempotency-Key", "monday")];
        let path = format!("/v1/fleets/{fleet}/policy");
        let done = send(started.http, "PUT", &path, &headers, Some(&policy)).await.unwrap();
        assert_eq!(done.status, 200, "{fleet}: {}", done.body);
        let actor = format!("token:engineer#{}", token.split('_').nth(1).unwrap());
        assert_eq!(done.json()["actor"], actor);
        let bearer = format!("Bearer {ROOT}");
        let listed = started.get(&format!("/v1/audit?fleet={fleet}"), &[("Authorization", &bearer)]).await.json();
        let actors: Vec<_> = listed["items"].as_array().unwrap().iter().map(|item| &item["actor"]).collect();
        assert_eq!(actors, [&json!(actor)]);
    }
}

#[tokio::test]
async fn regress_two_tokens_of_one_name_are_two_actors_on_sqlite() {
    tokens_are_actors_of_their_own(&EmptyDatabase::sqlite()).await;
}

#[tokio::test]
async fn regress_two_tokens_of_one_name_are_two_actors_on_postgres() {
    tokens_are_actors_of_their_own(&EmptyDatabase::postgres().await).await;
}
