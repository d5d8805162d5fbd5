//! The scenarios of the robots: many contacts, and a steady rate of trims, so that setpoints are pending at any time.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use vibrissa_protocol::{ArrayType, Name, OnSupervisorLoss};
use vibrissa_simulator::Scenario;
use vibrissa_simulator::scenario::{
    ArrayScenario, Behaviour, Change, Event, Misbehaviour, Noise, RobotScenario, WhiskerScenario,
};

use crate::plan::Control;

/// Name of the fleet. Below, the name of each robot's only array.
pub const FLEET: &str = "f";
const ARRAY: &str = "left";
/// Number of whiskers of a robot.
pub const WHISKERS: u16 = 2;
/// Contacts per message: one message in 0.2 s from each robot at 20 contacts per second.
const CONTACTS_PER_MESSAGE: usize = 4;
/// Number of messages that a robot keeps without a receipt, enough for more than an hour. Faults last only seconds.
const KEPT_MESSAGES: usize = 20_000;
/// Seconds before the first trim, in which whiskers are learned.
const FIRST_TRIM_S: f64 = 4.0;
/// Smallest time between two trims of a robot, in seconds.
const TRIMS_APART_S: f64 = 4.0;
/// Smallest mean time between two trims of a robot, in seconds.
const TRIMS_MEAN_S: f64 = 30.0;
/// Largest mean number of trims of a robot in a run; more would make its whiskers too short. A long run has longer
/// pauses between trims.
const TRIMS: f64 = 6.0;
/// The shortest length after a cut, and the loss of length by a cut, in mm.
const SHORTEST_MM: f64 = 58.0;
const CUT_MM: std::ops::Range<f64> = 1.5..4.0;

/// Splits the robots into one scenario per link between robots and broker. `links` has the fleet of each.
pub fn scenarios(
    seed: u64,
    seconds: f64,
    names: &[Name],
    rate: f64,
    control: Control,
    links: &[Name],
) -> Vec<Scenario> {
    let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0x7269_6d73);
    let mut groups: Vec<Vec<RobotScenario>> = vec![Vec::new(); links.len()];
    for (number, name) in names.iter().enumerate() {
        let mut robot = robot(number, name, seconds, &mut random);
        // The database accepts the number of a trim only once, which would hide duplicate contacts.
        if control == Control::NoFence {
            robot.events.clear();
        }
        groups[number % links.len()].push(robot);
    }
    let behaviour = Behaviour {
        contacts_per_second: rate / names.len() as f64 / f64::from(WHISKERS),
        contacts_per_message: CONTACTS_PER_MESSAGE,
        message_after_s: 0.5,
        kept_messages: KEPT_MESSAGES,
        journal: true,
        misbehaviour: match control {
            Control::NoRobotBuffer => Some(Misbehaviour::SendsOnce),
            Control::RobotIgnoresEpochs => Some(Misbehaviour::TakesAnySetpoint),
            Control::None
            | Control::ReceiptBeforeCommit
            | Control::NoFence
            | Control::Asynchronous
            | Control::OffsetBeforeState => None,
        },
        ..Behaviour::default()
    };
    let scenario = |(robots, fleet): (_, &Name)| Scenario {
        calibration: None,
        seed,
        fleet: fleet.clone(),
        behaviour: behaviour.clone(),
        noise: Noise::default(),
        calibration_error: 0.03,
        robots,
    };
    groups.into_iter().zip(links).map(scenario).collect()
}

/// The name of a robot by its number.
pub fn robot_name(number: usize) -> Name {
    Name::robot(&format!("r{number:03}")).expect("a name")
}

fn robot(number: usize, name: &Name, seconds: f64, random: &mut ChaCha8Rng) -> RobotScenario {
    let whisker = |whisker| WhiskerScenario {
        whisker,
        x_mm: 25.0 * f64::from(whisker),
        neighbours: (0..WHISKERS).filter(|&other| other != whisker).collect(),
        ..WhiskerScenario::default()
    };
    // In every second robot a neighbour may compensate a whisker; in the others only the whisker itself.
    let array_type = if number.is_multiple_of(2) { ArrayType::Type1 } else { ArrayType::Type2 };
    RobotScenario {
        robot: name.clone(),
        model: "chaos".to_owned(),
        on_supervisor_loss: OnSupervisorLoss::Hold,
        applies_gain: false,
        arrays: vec![ArrayScenario { array: array(), array_type, whiskers: (0..WHISKERS).map(whisker).collect() }],
        events: trims(seconds, random),
    }
}

/// Trims at random times until the end; each cut makes its whisker shorter.
fn trims(seconds: f64, random: &mut ChaCha8Rng) -> Vec<Event> {
    let mean_s = TRIMS_MEAN_S.max(seconds / TRIMS);
    let mut lengths_mm = [70.0; WHISKERS as usize];
    let mut events = Vec::new();
    let mut at_s = FIRST_TRIM_S + random.random_range(0.0..mean_s);
    while at_s < seconds {
        let first = random.random_range(0..WHISKERS);
        let cut_mm = random.random_range(CUT_MM);
        let is_long_enough = |whisker: &u16| lengths_mm[usize::from(*whisker)] - cut_mm >= SHORTEST_MM;
        let Some(whisker) = (0..WHISKERS).map(|next| (first + next) % WHISKERS).find(is_long_enough) else { break };
        let length_mm = &mut lengths_mm[usize::from(whisker)];
        *length_mm -= cut_mm;
        events.push(Event::whisker_at_s(at_s, array(), whisker, Change::Trim { length_mm: *length_mm }));
        at_s += TRIMS_APART_S + random.random_range(0.0..2.0 * (mean_s - TRIMS_APART_S));
    }
    events
}

/// Name of the fleet.
pub fn fleet() -> Name {
    Name::new(FLEET).expect("a name")
}

fn array() -> Name {
    Name::new(ARRAY).expect("a name")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names() -> Vec<Name> {
        (0..100).map(robot_name).collect()
    }

    #[test]
    fn robots_are_spread_over_links_and_make_the_rate_together() {
        let scenarios = scenarios(1, 60.0, &names(), 2000.0, Control::None, &[fleet(), fleet(), fleet(), fleet()]);
        assert_eq!(scenarios.len(), 4);
        let robots: usize = scenarios.iter().map(|scenario| scenario.robots.len()).sum();
        assert_eq!(robots, 100);
        let per_whisker = scenarios[0].behaviour.contacts_per_second;
        assert_eq!(per_whisker * f64::from(WHISKERS) * 100.0, 2000.0);
        scenarios.iter().for_each(|scenario| scenario.check().unwrap());
    }

    #[test]
    fn trims_come_all_the_time_and_some_robots_have_two() {
        let scenarios = scenarios(1, 60.0, &names(), 2000.0, Control::None, &[fleet()]);
        let events: Vec<usize> = scenarios[0].robots.iter().map(|robot| robot.events.len()).collect();
        assert!(events.iter().filter(|&&count| count >= 2).count() > 10, "{events:?}");
        let mut at_s: Vec<f64> =
            scenarios[0].robots.iter().flat_map(|robot| &robot.events).filter_map(|event| event.at_s).collect();
        at_s.sort_by(f64::total_cmp);
        assert!(at_s.windows(2).all(|pair| pair[1] - pair[0] < 5.0), "{at_s:?}");
    }

    #[test]
    fn trims_go_on_to_the_end_of_a_long_run() {
        for seconds in [600.0, 36_000.0] {
            let scenarios = scenarios(1, seconds, &names(), 2000.0, Control::None, &[fleet()]);
            let events = scenarios[0].robots.iter().flat_map(|robot| &robot.events);
            let last_s = events.filter_map(|event| event.at_s).fold(0.0, f64::max);
            assert!(last_s > 0.95 * seconds, "the last trim of {seconds} s is at {last_s} s");
            scenarios.iter().for_each(|scenario| scenario.check().unwrap());
        }
    }
}
