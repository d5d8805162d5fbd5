//! The robots of a run: arrays of two whiskers, some of which are cut.

use rand::{Rng as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use vibrissa_protocol::{ArrayType, Name, OnSupervisorLoss};
use vibrissa_simulator::Scenario;
use vibrissa_simulator::scenario::{ArrayScenario, Behaviour, Change, Event, Noise, RobotScenario, WhiskerScenario};

use crate::plan::Plan;

/// Array and number of a whisker, after its robot.
pub type WhiskerName = (String, String, i64);

/// Begin of the names of the robots.
pub const ROBOTS: char = 'r';
/// Name of each robot's only array.
const ARRAY: &str = "left";
/// Number of whiskers of a robot.
const WHISKERS: u16 = 2;
/// Messages that a robot keeps without a receipt: more than it makes in a run.
const KEPT_MESSAGES: usize = 20_000;
/// Length of a whisker after a cut, mm.
const LENGTHS_MM: std::ops::Range<f64> = 58.0..67.0;

/// Name of a fleet by its number.
///
/// # Panics
/// Never: the name is short.
#[must_use]
pub fn fleet(number: usize) -> Name {
    Name::new(&format!("fleet-{number}")).expect("a name")
}

/// The scenarios of the fleets, and the whiskers that are cut.
///
/// # Panics
/// Never: the names are short.
#[must_use]
pub fn scenarios(plan: &Plan) -> (Vec<Scenario>, Vec<WhiskerName>) {
    let mut random = ChaCha8Rng::seed_from_u64(plan.seed ^ 0x7269_6d73);
    let mut robots: Vec<Vec<RobotScenario>> = vec![Vec::new(); plan.fleets];
    let mut cut = Vec::new();
    for number in 0..plan.robots {
        let name = Name::robot(&format!("{ROBOTS}{number:03}")).expect("a name");
        let array = Name::new(ARRAY).expect("a name");
        let mut events = Vec::new();
        for whisker in 0..WHISKERS {
            if random.random_bool(0.4) {
                let at_s = random.random_range(10.0..plan.length.as_secs_f64());
                let change = Change::Trim { length_mm: random.random_range(LENGTHS_MM) };
                events.push(Event::whisker_at_s(at_s, array.clone(), whisker, change));
                cut.push((name.to_string(), ARRAY.to_owned(), i64::from(whisker)));
            }
        }
        let whisker = |whisker| WhiskerScenario {
            whisker,
            x_mm: 25.0 * f64::from(whisker),
            neighbours: (0..WHISKERS).filter(|&other| other != whisker).collect(),
            ..WhiskerScenario::default()
        };
        let whiskers = (0..WHISKERS).map(whisker).collect();
        let array_type = if number.is_multiple_of(2) { ArrayType::Type1 } else { ArrayType::Type2 };
        robots[number % plan.fleets].push(RobotScenario {
            robot: name,
            model: "simulated".to_owned(),
            on_supervisor_loss: OnSupervisorLoss::Hold,
            applies_gain: random.random_bool(0.5),
            arrays: vec![ArrayScenario { array, array_type, whiskers }],
            events,
        });
    }
    let behaviour = Behaviour {
        contacts_per_second: plan.contacts_per_second,
        kept_messages: KEPT_MESSAGES,
        journal: true,
        misbehaviour: plan.misbehaviour,
        ..Behaviour::default()
    };
    let scenario = |(number, robots)| Scenario {
        seed: plan.seed,
        fleet: fleet(number),
        behaviour: behaviour.clone(),
        noise: Noise::default(),
        calibration_error: 0.03,
        calibration: None,
        robots,
    };
    (robots.into_iter().enumerate().map(scenario).collect(), cut)
}
