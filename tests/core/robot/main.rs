//! The core against simulated robots whose truth is known.

mod air_patterns;
mod arrival;
mod assignment;
mod by_hand;
mod clocks;
mod closed_loop;
mod detection;
mod duplicates;
mod erosion;
mod factsheet;
mod false_alarms;
mod faults;
mod flapping;
mod gains;
mod health;
mod late_status;
mod leak;
mod located;
mod nuisances;
mod odd_values;
mod old_boots;
mod operator;
mod places;
mod planned_tests;
mod policy;
mod purity;
mod reality;
mod repeats;
mod replaced;
mod retries;
mod silence;
mod stored;
mod taken_up;
mod touch_tests;
mod trend;
mod trims;
mod what_if;

use vibrissa_protocol::{ArrayType, Name};
use vibrissa_simulator::scenario::{ArrayScenario, Behaviour, Noise, RobotScenario, Scenario, WhiskerScenario};

/// One array of whiskers of these lengths, each the neighbour of those beside it.
fn scenario(seed: u64, array_type: ArrayType, lengths_mm: &[f64]) -> Scenario {
    let last = lengths_mm.len() as u16 - 1;
    let whiskers = lengths_mm.iter().zip(0_u16..).map(|(&length_mm, whisker)| WhiskerScenario {
        whisker,
        x_mm: 25.0 * f64::from(whisker),
        length_mm,
        neighbours: [whisker.checked_sub(1), (whisker < last).then(|| whisker + 1)].into_iter().flatten().collect(),
        ..WhiskerScenario::default()
    });
    let array = ArrayScenario { array: name("left"), array_type, whiskers: whiskers.collect() };
    Scenario {
        calibration: None,
        seed,
        fleet: name("f"),
        behaviour: Behaviour { contacts_per_second: 50.0, contacts_per_message: 20, ..Behaviour::default() },
        noise: Noise::default(),
        calibration_error: 0.03,
        robots: vec![RobotScenario {
            robot: name("r"),
            model: "m".to_owned(),
            on_supervisor_loss: vibrissa_protocol::OnSupervisorLoss::Hold,
            applies_gain: false,
            arrays: vec![array],
            events: Vec::new(),
        }],
    }
}

fn name(text: &str) -> Name {
    Name::new(text).expect("a name")
}
