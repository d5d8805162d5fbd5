//! A site of several fleets: a pattern means all its halls, in tokens, lists, live events, webhooks and actions on many.
//! Some fleets are called almost like a hall. Both databases answer alike.

use serde_json::{Value, json};
use vibrissa_edge::fleets::FleetPattern;
use vibrissa_protocol::Name;
use vibrissa_store::Supervisor;
use vibrissa_supervisor::http::access::token::{NewToken, create};
use vibrissa_supervisor::http::access::{Role, Scope};
use vibrissa_tests::actions::policy_body;
use vibrissa_tests::web::{Answer, open, send};

use crate::document::{Document, get_operations};
use crate::rows;
use crate::served::Served;

const HALLS: [&str; 2] = ["hall-1", "hall-2"];
const OTHERS: [&str; 4] = ["hall_1", "Hall-1", "whole-hall-1", "other"];
/// Lists whose rows come from actions, messages or roll-outs, of which the test makes none.
const EMPTY: [&str; 4] = ["/v1/quarantine", "/v1/rollouts", "/v1/bulk-actions", "/v1/timeline"];
/// Both ends of the statistics of alarms: without them they are those of a week until now.
const SPAN: &str = "from=2020-01-01T00:00:00Z&to=2100-01-01T00:00:00Z";

/// A service with robots, happenings and alarms in each fleet.
async fn site(served: Served) -> Served {
    for name in HALLS.into_iter().chain(OTHERS) {
        let fleet = Name::new(name).unwrap();
        let supervisor = Supervisor {
            id: name.into(),
            name: format!("supervisor of {name}"),
            fleets: vec![fleet.clone()],
            time_to_live: std::time::Duration::from_secs(600),
        };
        let mut writer = served.store.writer();
        writer.sign_in(&supervisor, &[]).await.unwrap();
        let lease = writer.acquire(&supervisor, &fleet).await.unwrap().unwrap();
        rows::robots(&mut writer, &lease).await;
        acknowledge(&served, name).await;
    }
    served
}

async fn sites() -> [Served; 2] {
    [site(Served::sqlite().await).await, site(Served::postgres().await).await]
}

/// Acknowledges an alarm of a fleet, which is an entry of the audit log and an event.
async fn acknowledge(served: &Served, fleet: &str) {
    let alarms = served.items(&format!("/v1/alarms?fleet={fleet}&state=UNACKNOWLEDGED")).await;
    let path = format!("/v1/alarms/{}/acknowledge", alarms[0]["alarm_id"]);
    let done = send(served.http, "POST", &path, &[], Some(&json!({ "reason": "seen" }))).await.unwrap();
    assert_eq!(done.status, 200, "{}", done.body);
}

/// A caller with a token for these fleets.
struct Caller<'a> {
    served: &'a Served,
    bearer: String,
}

impl<'a> Caller<'a> {
    async fn of(served: &'a Served, fleets: &[&str]) -> Self {
        let fleets = fleets.iter().map(|fleet| FleetPattern::new(fleet).unwrap());
        let new = NewToken {
            name: "site".to_owned(),
            role: Role::Admin,
            scope: Scope::of(fleets),
            expires_us: i64::MAX,
            created_by: "test".to_owned(),
        };
        let (token, _) = create(&served.store, &new, 0).await.unwrap();
        Self { served, bearer: format!("Bearer {token}") }
    }

    async fn send(&self, method: &str, path: &str, body: Option<&Value>) -> Answer {
        send(self.served.http, method, path, &[("Authorization", &self.bearer)], body).await.unwrap()
    }

    async fn json(&self, path: &str) -> Value {
        let answer = self.send("GET", path, None).await;
        assert_eq!(answer.status, 200, "{path}: {}", answer.body);
        answer.json()
    }
}

/// Paths of all GET routes that take fleets, and have an end.
fn paths(document: &Document) -> Vec<String> {
    let takes_fleets = |operation: &Value| {
        let parameters = operation["parameters"].as_array();
        parameters.is_some_and(|all| all.iter().any(|one| one["name"] == "fleet" && one["in"] == "query"))
    };
    let all = get_operations(&document.0).filter(|(path, operation)| takes_fleets(operation) && *path != "/v1/events");
    all.map(|(path, _)| path.to_owned()).collect()
}

/// Fleets of all rows, in order.
fn fleets_of(answer: &Value) -> Vec<&str> {
    let rows = ["items", "robots"].iter().filter_map(|name| answer[name].as_array()).flatten();
    let mut fleets: Vec<&str> = rows.filter_map(|row| row["fleet"].as_str()).collect();
    fleets.sort_unstable();
    fleets.dedup();
    fleets
}

#[tokio::test]
async fn a_pattern_selects_the_same_rows_in_every_list_and_in_tokens() {
    for served in sites().await {
        let (all, halls) = (Caller::of(&served, &["*"]).await, Caller::of(&served, &["hall-*"]).await);
        let (first, both) = (Caller::of(&served, &["hall-1"]).await, Caller::of(&served, &HALLS).await);
        let paths = paths(&Document::of(&served).await);
        assert!(paths.len() >= 20, "{paths:?}");
        for path in &paths {
            // An overview has the time from which changes count, a day ago if none is given.
            let more = if path == "/v1/overview" { "from=2020-01-01T00:00:00Z" } else { "limit=1000" };
            let more = if path == "/v1/board" { "by=hall" } else { more };
            let more = if path == "/v1/alarms/statistics" { SPAN } else { more };
            let more = if path.starts_with("/v1/errors/by") || path == "/v1/alarms/counts" { "robot=r1" } else { more };
            let whole = all.json(&format!("{path}?{more}")).await;
            let seen = halls.json(&format!("{path}?{more}")).await;
            let is_empty = EMPTY.contains(&path.as_str());
            let is_of_fleets = !fleets_of(&whole).is_empty();
            assert!(is_empty || whole != seen, "{path}: {seen}");
            assert!(!is_of_fleets || fleets_of(&seen) == HALLS, "{path}: {seen}");
            for asked in ["hall-*", "hall-1,hall-2", "*all-*2,hall-1,nowhere-*"] {
                assert_eq!(all.json(&format!("{path}?{more}&fleet={asked}")).await, seen, "{path} {asked}");
            }
            assert_eq!(both.json(&format!("{path}?{more}&fleet=*")).await, seen, "{path}");
            let one = all.json(&format!("{path}?{more}&fleet=hall-1")).await;
            assert_eq!(first.json(&format!("{path}?{more}&fleet=hall-*")).await, one, "{path}");
            assert!(!is_of_fleets || fleets_of(&one) == ["hall-1"], "{path}");
        }
        for (asked, expected) in [
            ("hall_*", &["hall_1"][..]),
            ("*all-1", &["Hall-1", "hall-1", "whole-hall-1"][..]),
            ("H*", &["Hall-1"][..]),
            ("*", &["Hall-1", "f", "g", "hall-1", "hall-2", "hall_1", "other", "whole-hall-1"][..]),
            ("nowhere*", &[][..]),
        ] {
            let answer = served.json(&format!("/v1/fleets?fleet={asked}")).await;
            assert_eq!(fleets_of(&answer), expected, "{asked}");
        }
        let csv = halls.send("GET", "/v1/robots?format=csv&fleet=*-1", None).await.body;
        assert!(csv.contains("hall-1,r1") && !csv.contains("hall-2") && !csv.contains("Hall"), "{csv}");
        assert_eq!(halls.json("/v1/me").await["fleets"], json!(["hall-*"]));
        assert_eq!(all.json("/v1/me").await["fleets"], Value::Null);
        assert_eq!(halls.send("GET", "/v1/fleets/hall-2", None).await.status, 200);
        for other in ["hall_1", "Hall-1", "other", "hall-*"] {
            assert_eq!(halls.send("GET", &format!("/v1/fleets/{other}"), None).await.status, 403, "{other}");
        }
    }
}

#[tokio::test]
async fn a_text_that_is_no_pattern_is_refused_with_the_rule() {
    let served = site(Served::sqlite().await).await;
    let many = vec!["a"; 101].join(",");
    for path in paths(&Document::of(&served).await).iter().map(String::as_str).chain(["/v1/events"]) {
        for (bad, rule) in [
            ("hall-%25", "1 to 8 '*'"),
            ("hall-?", "1 to 8 '*'"),
            ("*********", "1 to 8 '*'"),
            ("hall-1,", "1 to 8 '*'"),
            ("", "1 to 8 '*'"),
            (many.as_str(), "at most 100"),
        ] {
            let answer = served.get(&format!("{path}?fleet={bad}")).await;
            let error = answer.json()["errors"][0].clone();
            assert_eq!((answer.status, &error["field"]), (422, &json!("fleet")), "{path} {bad}: {}", answer.body);
            assert!(answer.body.contains(rule), "{path} {bad}: {}", answer.body);
        }
    }
}

#[tokio::test]
async fn live_events_are_those_of_the_halls() {
    for served in sites().await {
        let halls = Caller::of(&served, &["hall-*"]).await;
        let headers = [("Authorization", halls.bearer.as_str())];
        let (status, mut by_token) = open(served.http, "/v1/events", &headers).await.unwrap();
        let (asked, mut by_query) = open(served.http, "/v1/events?fleet=hall-*", &[]).await.unwrap();
        assert_eq!((status, asked), (200, 200));
        for fleet in OTHERS.into_iter().chain(HALLS) {
            acknowledge(&served, fleet).await;
        }
        for events in [&mut by_token, &mut by_query] {
            let mut fleets = Vec::new();
            while fleets.last() != Some(&json!("hall-2")) {
                let event = events.next().await.unwrap().unwrap();
                fleets.push(serde_json::from_str::<Value>(&event.data).unwrap()["data"]["fleet"].clone());
            }
            fleets.dedup();
            assert_eq!(fleets, HALLS);
        }
    }
}

#[tokio::test]
async fn webhooks_of_a_pattern_belong_to_those_who_may_see_all_its_fleets() {
    for served in sites().await {
        let (halls, first) = (Caller::of(&served, &["hall-*"]).await, Caller::of(&served, &["hall-1"]).await);
        let create = async |caller: &Caller<'_>, name: &str, fleets: Value| {
            let body = json!({ "name": name, "url": "https://hooks.example/", "fleets": fleets });
            caller.send("POST", "/v1/webhooks", Some(&body)).await
        };
        for given in [json!(null), json!(["*"]), json!(["hall*"]), json!(["hall-1", "*-2"]), json!(["other"])] {
            let answer = create(&halls, "too much", given.clone()).await;
            assert_eq!(answer.status, 403, "{given}: {}", answer.body);
            assert!(answer.body.contains("your token does not cover all fleets of this webhook"), "{}", answer.body);
        }
        let refused = create(&halls, "bad", json!(["hall-?"])).await;
        assert_eq!((refused.status, &refused.json()["errors"][0]["field"]), (422, &json!("fleets[0]")));
        assert_eq!(create(&first, "all halls", json!(["hall-*"])).await.status, 403);
        for (name, fleets) in [("all", json!(["hall-*"])), ("west", json!(["hall-w*"])), ("one", json!(["hall-1"]))] {
            let answer = create(&halls, name, fleets.clone()).await;
            assert_eq!((answer.status, &answer.json()["webhook"]["fleets"]), (201, &fleets), "{}", answer.body);
        }
        let names = async |caller: &Caller<'_>| {
            let list = caller.json("/v1/webhooks").await;
            list["items"].as_array().unwrap().iter().map(|one| one["name"].clone()).collect::<Vec<_>>()
        };
        assert_eq!(names(&halls).await, ["all", "one", "west"]);
        assert_eq!(names(&first).await, ["one"]);
        let everything = Caller::of(&served, &["*"]).await;
        assert_eq!(create(&everything, "every", json!(["*"])).await.json()["webhook"]["fleets"], Value::Null);
        // Patterns count as webhooks for all fleets. Three are there.
        for number in 3..50 {
            assert_eq!(create(&halls, &format!("p{number}"), json!([format!("hall-{number}*")])).await.status, 201);
        }
        for fleets in [json!(null), json!(["hall-*"])] {
            let full = create(&everything, "full", fleets).await;
            assert_eq!(full.status, 409, "{}", full.body);
            assert!(full.body.contains("50 for all fleets or patterns"), "{}", full.body);
        }
        assert_eq!(create(&halls, "a name", json!(["hall-1"])).await.status, 201);
    }
}

#[tokio::test]
async fn actions_on_many_take_a_pattern() {
    for served in sites().await {
        let (all, halls) = (Caller::of(&served, &["*"]).await, Caller::of(&served, &["hall-*"]).await);
        let subjects = async |caller: &Caller<'_>, path: &str, fleets: &str, more: Value| {
            let mut body = json!({ "dry_run": true, "filter": { "fleet": fleets } });
            body.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
            let answer = caller.send("POST", path, Some(&body)).await;
            assert_eq!(answer.status, 200, "{path}: {}", answer.body);
            answer.json()
        };
        let policy = json!({ "policy": policy_body(&vibrissa_core::policy::PolicyParams::default()) });
        for path in ["/v1/policies", "/v1/robots/hold", "/v1/whiskers/hold"] {
            let more = if path == "/v1/policies" { policy.clone() } else { json!({}) };
            let of_halls = subjects(&all, path, "hall-*", more.clone()).await;
            assert_eq!(fleets_of(&of_halls), HALLS, "{path}");
            assert_eq!(subjects(&all, path, "hall-1,hall-2", more.clone()).await, of_halls, "{path}");
            assert_eq!(subjects(&halls, path, "*", more).await, of_halls, "{path}");
        }
        let body = json!({ "dry_run": true, "which": { "filter": { "fleet": "*-2" } } });
        let alarms = all.send("POST", "/v1/alarms/acknowledge", Some(&body)).await;
        assert_eq!(fleets_of(&alarms.json()), ["hall-2"], "{}", alarms.body);
        let bad = json!({ "filter": { "fleet": "hall-?" } });
        let refused = all.send("POST", "/v1/robots/hold", Some(&bad)).await;
        assert_eq!((refused.status, &refused.json()["errors"][0]["field"]), (422, &json!("filter.fleet")));
    }
}
