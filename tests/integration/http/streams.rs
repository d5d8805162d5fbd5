//! An event stream checks the current rights of its token, on both databases.

use std::time::Duration;

use serde_json::Value;
use sqlx::{Connection as _, PgConnection};
use tokio::time::timeout;
use vibrissa_simulator::clock::now_us;
use vibrissa_store::secret::Secret;
use vibrissa_supervisor::http::access::token::{NewToken, create};
use vibrissa_supervisor::http::access::{AccessOptions, Role, Scope};
use vibrissa_supervisor::http::streams::StreamOptions;
use vibrissa_tests::wait::PATIENCE;
use vibrissa_tests::web::{Events, open, send};

use crate::served::Served;

const ROOT: &str = "a-token-of-more-than-32-characters-for-the-test";

fn closed() -> AccessOptions {
    AccessOptions { token: Some(Secret::new(ROOT)), oidc: None }
}

/// The caller's rights are checked before each event.
pub(crate) fn checked_always() -> StreamOptions {
    StreamOptions { check_every: Duration::ZERO, ..StreamOptions::default() }
}

async fn token(served: &Served, good_for_us: i64) -> (String, String) {
    let now_us = now_us() as i64;
    let new = NewToken {
        name: "follower".to_owned(),
        role: Role::Viewer,
        scope: Scope::All,
        expires_us: now_us + good_for_us,
        created_by: "test".to_owned(),
    };
    let (token, row) = create(&served.store, &new, now_us).await.unwrap();
    (format!("Bearer {token}"), row.token_id)
}

/// Headers that close the connection when the stream ends.
pub(crate) fn until_the_end(bearer: &str) -> [(&str, &str); 2] {
    [("Authorization", bearer), ("Connection", "close")]
}

async fn follow(served: &Served, bearer: &str) -> Events {
    let (status, events) = open(served.http, "/v1/events", &until_the_end(bearer)).await.unwrap();
    assert_eq!(status, 200);
    events
}

/// Waits until the stream has ended and ignores its events.
pub(crate) async fn ended(events: &mut Events) {
    let end = async { while events.next().await.unwrap().is_some() {} };
    timeout(PATIENCE, end).await.expect("the stream must end");
}

/// Causes an event.
async fn acknowledge(served: &Served, number: usize) {
    let root = format!("Bearer {ROOT}");
    let headers = [("Authorization", root.as_str())];
    let alarms = send(served.http, "GET", "/v1/alarms?fleet=f&standing=true", &headers, None).await.unwrap().json();
    let path = format!("/v1/alarms/{}/acknowledge", alarms["items"][number]["alarm_id"]);
    let done = send(served.http, "POST", &path, &headers, None).await.unwrap();
    assert_eq!(done.status, 200, "{}", done.body);
}

async fn streams_end_with_their_tokens(served: &Served) {
    const HOUR_US: i64 = 3_600_000_000;
    let (revoked, id) = token(served, HOUR_US).await;
    let (good, _) = token(served, HOUR_US).await;
    let (expiring, _) = token(served, 3_000_000).await;
    let mut of_expiring = follow(served, &expiring).await;
    let (mut of_revoked, mut of_good) = (follow(served, &revoked).await, follow(served, &good).await);
    acknowledge(served, 0).await;
    assert!(of_revoked.next().await.unwrap().is_some(), "the stream must continue while the token is valid");
    assert!(of_good.next().await.unwrap().is_some());
    assert!(served.store.revoke_token(&id, now_us() as i64).await.unwrap());
    ended(&mut of_revoked).await;
    ended(&mut of_expiring).await;
    acknowledge(served, 1).await;
    let next = timeout(PATIENCE, of_good.next()).await.expect("an event").unwrap();
    assert!(next.is_some(), "the stream of another token must continue");
}

#[tokio::test]
async fn regress_streams_end_with_their_tokens_on_sqlite() {
    streams_end_with_their_tokens(&Served::streaming(&closed(), checked_always()).await).await;
}

#[tokio::test]
async fn regress_streams_end_with_their_tokens_on_postgres() {
    streams_end_with_their_tokens(&Served::streaming_from_postgres(&closed(), checked_always()).await).await;
}

#[tokio::test]
async fn regress_a_stream_shows_the_fleets_that_its_token_has_now() {
    let served = Served::streaming_from_postgres(&closed(), checked_always()).await;
    let (bearer, id) = token(&served, 3_600_000_000).await;
    let mut events = follow(&served, &bearer).await;
    let mut link = PgConnection::connect(served.url.as_ref().unwrap()).await.unwrap();
    sqlx::query("UPDATE api_tokens SET fleets = 'g' WHERE token_id = $1").bind(id).execute(&mut link).await.unwrap();
    for (fleet, number) in [("f", 1_i64), ("g", 2)] {
        const SQL: &str = "INSERT INTO events (recorded_us, version, fleet, kind, audience, data) \
             VALUES (1, 2, $1, 'ACTION', 'PROGRAMS', $2)";
        sqlx::query(SQL)
            .bind(fleet)
            .bind(format!(r#"{{"action":{{"action_id":{number}}}}}"#))
            .execute(&mut link)
            .await
            .unwrap();
    }
    let event = timeout(PATIENCE, events.next()).await.expect("an event").unwrap().expect("the stream must continue");
    let change: Value = serde_json::from_str(&event.data).unwrap();
    let data = &change["data"];
    assert_eq!((&data["fleet"], &data["action"]["action_id"]), (&Value::from("g"), &Value::from(2)));
}
