//! The core is a function of its inputs.

use std::process::Command;

use vibrissa_core::mechanics::Formulation;
use vibrissa_core::robot::{Params, Robot};
use vibrissa_core::units::Micros;
use vibrissa_evaluation::World;
use vibrissa_protocol::ArrayType;
use vibrissa_simulator::scenario::{Change, Event, Scenario};

fn eventful() -> Scenario {
    let mut scenario = super::scenario(3, ArrayType::Type1, &[70.0, 66.0, 70.0, 68.0]);
    let cut = |at, whisker, length_mm| Event::at_contact(at, super::name("left"), whisker, Change::Trim { length_mm });
    scenario.robots[0].events.extend([cut(300, 0, 64.0), cut(500, 2, 55.0), cut(900, 0, 61.0)]);
    scenario
}

fn params() -> Params {
    Params::nguyen_2021(Formulation::Published)
}

#[test]
fn property_the_same_events_give_the_same_effects() {
    let [one, other] = [(); 2].map(|()| {
        let mut world = World::new(&eventful(), params());
        world.run_until_s(30.0);
        world
    });
    assert!(one.effects.len() > 20);
    assert_eq!(one.effects, other.effects);
    assert_eq!(one.core.to_bytes(), other.core.to_bytes());
}

#[test]
fn bytes_of_another_version_are_refused_by_name() {
    let mut world = World::new(&eventful(), params());
    world.run_until_s(1.0);
    let head = world.core.to_bytes().unwrap();
    let problem = Robot::from_bytes(&head[..head.len() - 1], &[], 1, Micros::default()).unwrap_err();
    assert!(problem.to_string().contains("not of this version"), "{problem}");
    let problem = Robot::from_bytes(&head, &[vec![1, 2, 3]], 1, Micros::default()).unwrap_err();
    assert!(problem.to_string().contains("whisker index 0"), "{problem}");
}

/// The names of the packages that a package of the workspace is built from.
fn packages(package: &str, edges: &str) -> Vec<String> {
    let tree = Command::new(env!("CARGO"))
        .args(["tree", "-p", package, "-e", edges, "--prefix", "none", "--locked", "--offline"])
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
        .output()
        .unwrap();
    assert!(tree.status.success(), "{}", String::from_utf8_lossy(&tree.stderr));
    let tree = String::from_utf8(tree.stdout).unwrap();
    let names: Vec<String> = tree.lines().filter_map(|line| line.split(' ').next()).map(str::to_owned).collect();
    assert!(names.iter().any(|name| name == "nalgebra"), "{tree}");
    names
}

/// Clippy bans impure items of the standard library (services/core/clippy.toml); this test bans impure crates.
#[test]
fn property_the_core_depends_on_nothing_impure() {
    let banned =
        ["serde", "serde_json", "tokio", "sqlx", "rand", "getrandom", "chrono", "time", "tracing", "log", "prometheus"];
    for name in packages("vibrissa-core", "normal") {
        assert!(!banned.contains(&name.as_str()), "the core depends on {name}");
    }
}

/// A change of the core is tested without building the service.
#[test]
fn the_tests_of_the_core_need_no_database_and_no_web_server() {
    for name in packages("vibrissa-core-tests", "all") {
        assert!(!["vibrissa", "sqlx", "axum", "hyper"].contains(&name.as_str()), "these tests depend on {name}");
    }
}
