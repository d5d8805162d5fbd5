//! The event stream follows the order of commits on both databases, even when transactions overlap.

use serde_json::{Value, json};
use sqlx::{Connection as _, PgConnection};
use vibrissa_tests::web::{Events, open, send};

use crate::served::Served;

async fn next(events: &mut Events) -> (String, Value) {
    let event = events.next().await.unwrap().expect("the stream must continue");
    (event.id, serde_json::from_str(&event.data).unwrap())
}

async fn acknowledged_is_followed(served: &Served) {
    let (status, mut events) = open(served.http, "/v1/events?fleet=f", &[]).await.unwrap();
    assert_eq!(status, 200);
    let alarms = served.items("/v1/alarms?fleet=f&standing=true").await;
    let path = format!("/v1/alarms/{}/acknowledge", alarms[0]["alarm_id"]);
    let done = send(served.http, "POST", &path, &[], Some(&json!({ "reason": "seen" }))).await.unwrap();
    assert_eq!(done.status, 200, "{}", done.body);
    let (id, change) = next(&mut events).await;
    assert_eq!([&change["type"], &change["data"]["robot"]], [&json!("ALARM_HANDLED"), &alarms[0]["robot"]]);
    let (_, mut again) = open(served.http, "/v1/events", &[("Last-Event-ID", &id)]).await.unwrap();
    let path = format!("/v1/alarms/{}/acknowledge", alarms[1]["alarm_id"]);
    assert_eq!(send(served.http, "POST", &path, &[], None).await.unwrap().status, 200);
    assert_eq!(next(&mut again).await, next(&mut events).await, "only later events must follow");
}

#[tokio::test]
async fn what_is_said_to_an_alarm_is_followed_on_sqlite() {
    acknowledged_is_followed(&Served::sqlite().await).await;
}

#[tokio::test]
async fn what_is_said_to_an_alarm_is_followed_on_postgres() {
    acknowledged_is_followed(&Served::postgres().await).await;
}

#[tokio::test]
async fn regress_a_transaction_that_is_overtaken_is_not_missed() {
    let served = Served::postgres().await;
    let url = served.url.clone().unwrap();
    let (_, mut events) = open(served.http, "/v1/events", &[]).await.unwrap();
    let insert = async |link: &mut PgConnection, number: i64| {
        const SQL: &str = "INSERT INTO events (recorded_us, version, fleet, kind, audience, data) \
             VALUES (1, 2, 'f', 'ACTION', 'PROGRAMS', $1)";
        sqlx::query(SQL).bind(json!({ "action": { "action_id": number } }).to_string()).execute(link).await.unwrap();
    };
    let mut slow = PgConnection::connect(&url).await.unwrap();
    let mut quick = PgConnection::connect(&url).await.unwrap();
    let mut overtaken = slow.begin().await.unwrap();
    insert(&mut overtaken, 1).await;
    insert(&mut quick, 2).await;
    overtaken.commit().await.unwrap();
    insert(&mut quick, 3).await;
    for number in [1, 2, 3] {
        assert_eq!(next(&mut events).await.1["data"]["action"]["action_id"], number);
    }
}
