//! Alarms: guidance, order, storms, counts and search, on both databases.

use serde_json::{Value, json};
use vibrissa_core::robot::effect::AlarmKind;
use vibrissa_edge::words::{Word, Words};
use vibrissa_protocol::Name;
use vibrissa_store::batch::{Record, RobotAlarmRow};
use vibrissa_store::{Batch, Store, Supervisor};
use vibrissa_tests::web::ask;

use crate::rows::START_US;
use crate::served::Served;

/// Alarms of one kind about robots of fleet `h`, one each, with this pause between them.
pub(crate) async fn storm(store: &Store, robots: usize, kind: &'static str, pause_us: i64) {
    let fleet = Name::new("h").unwrap();
    let supervisor = Supervisor {
        id: "h".into(),
        name: "supervisor h".to_owned(),
        fleets: vec![fleet.clone()],
        time_to_live: std::time::Duration::from_secs(600),
    };
    let mut writer = store.writer();
    writer.sign_in(&supervisor, &[]).await.unwrap();
    let lease = writer.acquire(&supervisor, &fleet).await.unwrap().unwrap();
    let mut records = Vec::new();
    for number in 0..robots {
        let robot_id =
            writer.register(&lease, (&format!("robot-{number}"), "b"), 1_000_000).await.unwrap().unwrap().robot_id;
        let raised_us = START_US + 100_000_000 + number as i64 * pause_us;
        records.push(Record::RobotAlarm(RobotAlarmRow { robot_id, raised_us, kind }));
    }
    writer.commit(&lease, &Batch { records, ..Batch::default() }).await.unwrap();
}

fn texts(items: &[Value], field: &str) -> Vec<String> {
    items.iter().map(|item| item[field].as_str().unwrap_or_default().to_owned()).collect()
}

async fn both() -> [Served; 2] {
    [Served::sqlite().await, Served::postgres().await]
}

#[tokio::test]
async fn each_alarm_has_a_level_a_hint_causes_and_a_runbook_that_is_served() {
    for served in both().await {
        let alarms = served.items("/v1/alarms?sort=urgency").await;
        let kinds = texts(&alarms, "kind");
        for kind in ["UNCOMPENSATED", "ROBOT_SILENT", "LEAK"] {
            assert!(kinds.contains(&kind.to_owned()), "{kinds:?}");
        }
        for alarm in &alarms {
            assert_eq!(alarm["level"], "URGENT", "{alarm}");
            assert!(alarm["hint"].as_str().unwrap().ends_with('.') && alarm["causes"].as_array().unwrap().len() > 1);
            let runbook = served.get(alarm["runbook_url"].as_str().unwrap()).await;
            assert_eq!((runbook.status, runbook.body.starts_with("# ")), (200, true), "{alarm}");
        }
        let robot = alarms.iter().find(|alarm| alarm["kind"] == "ROBOT_SILENT").unwrap();
        assert_eq!([&robot["array"], &robot["whisker"]], [&Value::Null, &Value::Null]);
        assert_eq!(served.get("/runbooks/no.md").await.status, 404);
        assert_eq!(served.get("/runbooks").await.headers["location"], "/runbooks/README.md");
        let browser = ("accept", "text/html,*/*;q=0.8");
        let page = ask(served.http, "GET", "/runbooks/README.md", &[browser]).await.unwrap();
        assert_eq!(page.headers["content-type"], "text/html; charset=utf-8");
        assert!(page.body.contains("<a href=\"VibrissaWhiskerUncompensated.md\">"), "{}", page.body);
        // The most urgent kind first: trimmed and uncompensated, then a silent robot, then a leak.
        let mut order = kinds;
        order.dedup();
        assert_eq!(order, ["UNCOMPENSATED", "ROBOT_SILENT", "LEAK"]);
    }
}

#[tokio::test]
async fn alarms_of_one_kind_that_come_together_are_one_row_and_others_stay_by_array() {
    for served in both().await {
        storm(&served.store, 120, "ROBOT_SILENT", 1_000_000).await;
        let rows = served.all("/v1/alarms/folded?limit=3").await;
        assert_eq!(rows, served.items("/v1/alarms/folded").await);
        let storms: Vec<&Value> = rows.iter().filter(|row| row["fold"]["alarms"] != 1).collect();
        let [folded] = storms[..] else { panic!("one storm: {storms:?}") };
        assert_eq!([&folded["fleet"], &folded["kind"]], ["h", "ROBOT_SILENT"]);
        let fold = &folded["fold"];
        assert_eq!([&fold["alarms"], &fold["robots"], &fold["unacknowledged"]], [&json!(120); 3]);
        let (from, to) = (fold["first_raised_at"].as_str().unwrap(), fold["last_raised_at"].as_str().unwrap());
        let members =
            served.items(&format!("/v1/alarms?standing=true&fleet=h&kind=ROBOT_SILENT&from={from}&limit=1000")).await;
        assert_eq!(members.len(), 120);
        assert!(members.iter().all(|one| one["raised_at"].as_str().unwrap() <= to));
        // All other standing alarms are there, each array in one place.
        let standing = served.items("/v1/alarms?standing=true&limit=1000").await;
        let of_others = standing.iter().filter(|alarm| alarm["fleet"] != "h").count();
        assert_eq!(rows.len(), of_others + 1);
        let mut places: Vec<String> =
            rows.iter().map(|row| format!("{} {} {}", row["fleet"], row["robot"], row["array"])).collect();
        places.dedup();
        let count = places.len();
        places.sort();
        places.dedup();
        assert_eq!(places.len(), count, "an array is interrupted: {places:?}");
        // Filters apply before the folding.
        let filtered = served.items("/v1/alarms/folded?robot=robot-7").await;
        assert_eq!((filtered.len(), &filtered[0]["fold"]["alarms"]), (1, &json!(1)));
    }
}

#[tokio::test]
async fn alarms_with_long_pauses_between_them_are_no_storm() {
    for served in both().await {
        storm(&served.store, 12, "ROBOT_SILENT", 301_000_000).await;
        let rows = served.items("/v1/alarms/folded?fleet=h").await;
        assert_eq!(rows.len(), 12);
        assert!(rows.iter().all(|row| row["fold"]["alarms"] == 1));
    }
}

#[tokio::test]
async fn counts_and_searches_are_those_of_the_list() {
    for served in both().await {
        storm(&served.store, 30, "ROBOT_SILENT", 1_000_000).await;
        let standing = served.items("/v1/alarms?standing=true&limit=1000").await;
        let counts = served.items("/v1/alarms/counts").await;
        let sum: i64 = counts.iter().map(|count| count["alarms"].as_i64().unwrap()).sum();
        assert_eq!(sum as usize, standing.len());
        for count in &counts {
            let is_of = |alarm: &&Value| alarm["fleet"] == count["fleet"] && alarm["kind"] == count["kind"];
            assert_eq!(count["alarms"], standing.iter().filter(is_of).count(), "{count}");
            assert_eq!(count["level"], "URGENT");
        }
        // Words of a search may be anywhere: in a name, in the kind, in the words for the kind.
        let label = AlarmKind::RobotSilent.label().unwrap();
        for (q, expected) in [
            ("ROBOT-12", 1),
            ("robot-1", 11),
            ("robot-2 silent", 11),
            ("uncompensated%", 0),
            ("left", standing.len() - 34),
        ] {
            let q = q.replace('%', "%25").replace(' ', "+");
            let found = served.items(&format!("/v1/alarms?standing=true&limit=1000&q={q}")).await;
            assert_eq!(found.len(), expected, "{q} of {label}: {:?}", texts(&found, "robot"));
        }
        assert_eq!(served.items("/v1/alarms?level=CRITICAL").await, Vec::<Value>::new());
        assert_eq!(served.get("/v1/alarms?level=FATAL").await.status, 422);
        let many = "w+".repeat(20);
        assert_eq!(served.get(&format!("/v1/alarms?q={many}")).await.status, 422);
        assert!(AlarmKind::all().len() > 10 && AlarmKind::RobotSilent.word() == "ROBOT_SILENT");
    }
}
