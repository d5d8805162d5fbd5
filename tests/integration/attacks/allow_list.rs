//! Fleets with a list of allowed robots.

use std::fs;

use serde_json::{Value, json};
use vibrissa_protocol::ArrayType;
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::until_true;

use crate::with_limits::{DatabaseKind, Supervised};

const PATH: &str = "/v1/fleets/f/allowed-robots";

async fn robot(supervised: &Supervised, name: &str) -> HandRobot {
    let mut robot = HandRobot::connect(supervised.port(), name, array(ArrayType::Type2, &[70.0])).await;
    robot.birth().await;
    robot
}

/// Sends contacts until this many more messages were refused because their robot is not on the list.
async fn is_refused(supervised: &Supervised, robot: &mut HandRobot) {
    let before = supervised.refused("not_allowed").await;
    until_true("it is refused", async || {
        robot.touch(0, 1).await;
        supervised.refused("not_allowed").await >= before + 3.0
    })
    .await;
}

/// Waits until the supervisor accepts the robot. It repeats only messages that the robot would send anyway.
async fn is_taken(robot: &mut HandRobot) {
    robot.settle().await;
}

#[tokio::test]
async fn a_file_says_who_is_allowed_and_is_read_again_when_it_changes() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("robots");
    let write = |text: &str| {
        let new = file.with_extension("new");
        fs::write(&new, text).unwrap();
        fs::rename(&new, &file).unwrap();
    };
    write("# robots of the test\nf/honest\ng/stranger\n");
    let argument = format!("--limits-robots-file={}", file.display());
    let supervised = Supervised::start_in(folder, DatabaseKind::Sqlite, &[&argument]).await;
    let mut honest = HandRobot::born(supervised.port(), "honest", array(ArrayType::Type2, &[70.0])).await;
    let mut stranger = robot(&supervised, "stranger").await;
    is_refused(&supervised, &mut stranger).await;
    assert_eq!(supervised.robots().await, ["honest"]);
    let list = supervised.ask("GET", PATH, &[], None).await.json();
    assert_eq!((&list["in_file"], &list["robots"]), (&json!(["honest"]), &Value::Null));

    // An invalid file leaves the list in force.
    write("f/honest\nf/stranger\nnonsense\n");
    until_true("the log has the error", async || {
        let log = fs::read_to_string(supervised.folder.path().join("log")).unwrap();
        log.contains("line 3: must be FLEET/ROBOT")
    })
    .await;
    is_refused(&supervised, &mut stranger).await;
    fs::remove_file(&file).unwrap();
    is_refused(&supervised, &mut stranger).await;
    honest.touch(0, 20).await;
    honest.receipted().await;

    write("f/honest\nf/stranger\n");
    until_true("the file is read again", async || {
        let list = supervised.ask("GET", PATH, &[], None).await.json();
        list["in_file"] == json!(["honest", "stranger"])
    })
    .await;
    is_taken(&mut stranger).await;
    assert_eq!(supervised.robots().await, ["honest", "stranger"]);
}

async fn set(supervised: &Supervised, method: &str, body: &Value) {
    let tag = supervised.ask("GET", PATH, &[], None).await.headers["etag"].clone();
    let answer = supervised.ask(method, PATH, &[("If-Match", &tag)], Some(body)).await;
    assert_eq!((answer.status, &answer.json()["state"]), (200, &json!("DONE")), "{}", answer.body);
    // The list that was read is no longer in force, so its tag does not match.
    let answer = supervised.ask(method, PATH, &[("If-Match", &tag)], Some(body)).await;
    assert_eq!(answer.status, 412, "{}", answer.body);
}

async fn a_list_is_set_over_http(kind: DatabaseKind) {
    let supervised = Supervised::start(kind, &[]).await;
    let mut honest = HandRobot::born(supervised.port(), "honest", array(ArrayType::Type2, &[70.0])).await;
    let mut known = HandRobot::born(supervised.port(), "known", array(ArrayType::Type2, &[70.0])).await;
    assert_eq!(supervised.ask("PUT", PATH, &[], Some(&json!({ "robots": [] }))).await.status, 428);
    for robots in [json!(["a b"]), json!(["supervisor"]), json!("honest")] {
        let answer = supervised.ask("PUT", PATH, &[("If-Match", "*")], Some(&json!({ "robots": robots }))).await;
        assert_eq!(answer.status, 422, "{}", answer.body);
    }
    set(&supervised, "PUT", &json!({ "robots": ["honest"], "reason": "strangers" })).await;
    let mut stranger = robot(&supervised, "stranger").await;
    is_refused(&supervised, &mut stranger).await;
    // A robot that was known before is refused, too.
    is_refused(&supervised, &mut known).await;
    honest.touch(0, 20).await;
    honest.receipted().await;
    assert_eq!(supervised.robots().await, ["honest", "known"]);
    let presence = async |robot: &str| {
        let path = format!("/v1/fleets/f/robots/{robot}");
        supervised.ask("GET", &path, &[], None).await.json()["connection"].as_str().unwrap().to_owned()
    };
    // It is connected still, but nothing of it is heard.
    until_true("an excluded robot is not there", async || presence("known").await == "OFFLINE").await;
    assert_eq!(presence("honest").await, "ONLINE");
    until_true("who was turned away is shown", async || {
        let list = supervised.ask("GET", PATH, &[], None).await.json();
        let names: Vec<&str> =
            list["turned_away"].as_array().unwrap().iter().map(|one| one["robot"].as_str().unwrap()).collect();
        assert_eq!((&list["robots"], &list["reason"]), (&json!(["honest"]), &json!("strangers")));
        names.contains(&"stranger") && names.contains(&"known")
    })
    .await;

    set(&supervised, "PUT", &json!({ "robots": ["stranger", "honest"] })).await;
    is_taken(&mut stranger).await;
    is_refused(&supervised, &mut known).await;
    set(&supervised, "DELETE", &json!({ "reason": "all are friends" })).await;
    is_taken(&mut known).await;
    until_true("it is there again", async || presence("known").await == "ONLINE").await;
    until_true("the list of refused robots is empty", async || {
        let list = supervised.ask("GET", PATH, &[], None).await.json();
        list["turned_away"] == json!([]) && list["robots"].is_null() && list["version"] == 3
    })
    .await;
    let audit = supervised.ask("GET", "/v1/audit", &[], None).await.json();
    let kinds = audit["items"].as_array().unwrap().iter().filter(|one| one["kind"] == "ALLOWED_ROBOTS").count();
    assert_eq!(kinds, 3, "{audit}");
}

#[tokio::test]
async fn a_list_is_set_over_http_on_sqlite() {
    a_list_is_set_over_http(DatabaseKind::Sqlite).await;
}

#[tokio::test]
async fn a_list_is_set_over_http_on_postgres() {
    a_list_is_set_over_http(DatabaseKind::Postgres).await;
}
