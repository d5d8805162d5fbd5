//! The state file keeps the condition of whiskers across processes.

use std::path::Path;

use vibrissa_protocol::{Gauge, Name};
use vibrissa_simulator::state::EVERY;
use vibrissa_simulator::{Broker, CannotStart, Fleet, Robot, Scenario};
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::wait::{PATIENCE, until_true};

const EVENTS: &str = r#"
[[robots.events]]
at_contact = 10
array = "left"
whisker = 0
change = { kind = "TRIM", length_mm = 61.0 }
[[robots.events]]
at_s = 0.2
array = "left"
whisker = 1
change = { kind = "ERODE", rate_mm_per_contact = 0.01, until_length_mm = 60.0 }
[[robots.events]]
at_s = 0.2
array = "left"
whisker = 1
change = { kind = "GAUGE_SHORT" }
"#;

fn scenario(events: &str) -> Scenario {
    Scenario::from_toml_str(&format!("{}{events}", super::SCENARIO)).unwrap()
}

fn resume(broker: &Mosquitto, scenario: &Scenario, file: &Path) -> Result<Fleet, CannotStart> {
    Fleet::resume(scenario, &Broker::new("127.0.0.1", broker.port()), file)
}

/// True state of both whiskers.
#[derive(Debug, PartialEq)]
struct Truth {
    lengths_mm: [f64; 2],
    changes: [usize; 2],
    contacts: [u64; 2],
    gauges: [Gauge; 2],
    /// Strain per mm of deflection of the uncut whisker, which differs between whiskers.
    whole: [f64; 2],
}

fn truth(fleet: &Fleet) -> Truth {
    fleet.robots()[0].with(|robot: &mut Robot| {
        let array = Name::new("left").unwrap();
        let plant = |number| robot.whisker(&array, number).unwrap().plant();
        let both = [plant(0), plant(1)];
        Truth {
            lengths_mm: both.map(|plant| plant.length_mm()),
            changes: both.map(|plant| plant.changes().len()),
            contacts: both.map(|plant| plant.contacts()),
            gauges: both.map(|plant| plant.gauge()),
            whole: both.map(|plant| plant.whole_sensitivity_per_mm(0.8).unwrap()),
        }
    })
}

fn boot(fleet: &Fleet) -> String {
    fleet.robots()[0].with(|robot| robot.boot_id().to_string())
}

#[tokio::test]
async fn regress_a_simulator_that_ends_in_good_order_goes_on_where_it_was() {
    let (broker, folder) = (Mosquitto::start(), tempfile::tempdir().unwrap());
    let (file, scenario) = (folder.path().join("state.json"), scenario(EVENTS));
    let fleet = resume(&broker, &scenario, &file).unwrap();
    until_true("a cut, wear and a fault", async || {
        let truth = truth(&fleet);
        truth.changes == [1, 1] && truth.lengths_mm[1] < 69.9
    })
    .await;
    fleet.rest();
    let (before, boot_before) = (truth(&fleet), boot(&fleet));
    assert_eq!((before.lengths_mm[0], before.gauges[1]), (61.0, Gauge::Short));
    fleet.stop().await;

    let fleet = resume(&broker, &scenario, &file).unwrap();
    fleet.rest();
    assert_eq!(truth(&fleet), before);
    assert_ne!(boot(&fleet), boot_before);
    fleet.stop().await;
}

/// A dropped fleet writes nothing, like a killed process.
#[tokio::test]
async fn regress_a_simulator_that_is_killed_remembers_its_cuts() {
    let (broker, folder) = (Mosquitto::start(), tempfile::tempdir().unwrap());
    let (file, scenario) = (folder.path().join("state.json"), scenario(EVENTS));
    let fleet = resume(&broker, &scenario, &file).unwrap();
    until_true("the cut in the file", async || std::fs::read_to_string(&file).unwrap().contains("\"length_mm\": 61.0"))
        .await;
    let (before, boot_before) = (truth(&fleet), boot(&fleet));
    drop(fleet);

    let fleet = resume(&broker, &scenario, &file).unwrap();
    let after = truth(&fleet);
    assert_eq!((after.lengths_mm[0], after.changes[0]), (61.0, 1));
    assert_eq!(after.whole, before.whole);
    assert!(after.contacts[0] >= 10, "the cut must come after 10 contacts");
    assert_ne!(boot(&fleet), boot_before);
    until_true("further contacts", async || truth(&fleet).contacts[0] > after.contacts[0]).await;
    assert_eq!(truth(&fleet).changes[0], 1, "the cut must not happen again");
    drop(fleet);
}

#[tokio::test]
async fn wear_is_written_now_and_then() {
    let (broker, folder) = (Mosquitto::start(), tempfile::tempdir().unwrap());
    let file = folder.path().join("state.json");
    let fleet = resume(&broker, &scenario(""), &file).unwrap();
    let first = std::fs::read_to_string(&file).unwrap();
    assert!(EVERY < PATIENCE);
    until_true("a file with contacts", async || std::fs::read_to_string(&file).unwrap() != first).await;
    let value: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(&file).unwrap()).unwrap();
    assert!(value["robots"][0]["whiskers"][0]["plant"]["contacts"].as_u64().unwrap() > 0, "{value}");
    drop(fleet);
}

/// The reason why a fleet does not start. Checks that the file has not changed.
fn refused(broker: &Mosquitto, scenario: &Scenario, file: &Path) -> String {
    let before = std::fs::read(file).ok();
    let problem = resume(broker, scenario, file).expect_err("it must not start").to_string();
    assert!(problem.contains(&file.display().to_string()), "{problem}");
    assert_eq!(std::fs::read(file).ok(), before);
    problem
}

#[tokio::test]
async fn a_file_of_another_scenario_or_version_or_that_is_damaged_is_refused_with_what_to_do() {
    let (broker, folder) = (Mosquitto::start(), tempfile::tempdir().unwrap());
    let (file, plain) = (folder.path().join("state.json"), scenario(""));
    resume(&broker, &plain, &file).unwrap().stop().await;
    let good = std::fs::read_to_string(&file).unwrap();

    let longer = Scenario { robots: scenario(EVENTS).robots, ..plain.clone() };
    for other in
        [Scenario { seed: 2, ..plain.clone() }, Scenario { fleet: Name::new("g").unwrap(), ..plain.clone() }, longer]
    {
        let problem = refused(&broker, &other, &file);
        assert!(problem.contains("another scenario") && problem.contains("--state-file"), "{problem}");
    }
    for (damage, words) in [
        (good.replace("\"version\": 1", "\"version\": 2"), ["version 2", "reads version 1"]),
        (good[..good.len() / 2].to_owned(), ["damaged", "EOF"]),
        (good.replace("\"contacts\"", "\"touches\""), ["damaged", "touches"]),
        (good.replace("\"length_mm\": 70.0", "\"length_mm\": 71.0"), ["damaged", "length_mm is 71"]),
        (good.replace("\"boots\": 0", "\"boots\": -1"), ["damaged", "-1"]),
        (String::new(), ["damaged", "remove it"]),
    ] {
        assert_ne!(damage, good, "{words:?}");
        std::fs::write(&file, damage).unwrap();
        let problem = refused(&broker, &plain, &file);
        assert!(words.iter().all(|word| problem.contains(word)), "{words:?}: {problem}");
    }
    // Noise and pace may differ, because they do not change the whiskers.
    std::fs::write(&file, good).unwrap();
    let mut quicker = plain;
    quicker.behaviour.contacts_per_second = 100.0;
    quicker.noise.strain_relative = 0.01;
    resume(&broker, &quicker, &file).unwrap().stop().await;
}

#[tokio::test]
async fn a_file_that_cannot_be_written_is_told_at_the_start() {
    let (broker, folder) = (Mosquitto::start(), tempfile::tempdir().unwrap());
    let file = folder.path().join("gone").join("state.json");
    let problem = refused(&broker, &scenario(""), &file);
    assert!(problem.contains("cannot write"), "{problem}");
}
