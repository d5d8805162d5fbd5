//! The paper's compensation experiment on simulated plants that deviate from the model.
//!
//! A plant is one batch of rubber: k2's three parameters and the elongation gain each deviate by up to 10 %, and
//! every second plant follows the other formulation. On each plant, compensators of several lengths serve one
//! target, as in the paper's Fig. 9 and 10, and a whisker is trimmed to several lengths and serves itself. The core
//! learns everything as in service: from noisy contacts, through a cold start, a cut that it detects itself, and a
//! dithering regulator. The plant itself, without noise, gives the true result.

mod noise_limit;
pub mod reading;
mod summary;
mod truth;
pub mod weakened;

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use vibrissa_core::mechanics::{CONTACT_RATIOS, ErrorProfile, Formulation, Objective, Offset, UsualContacts};
use vibrissa_core::policy::{Fitness, propose};
use vibrissa_core::robot::Params;
use vibrissa_core::robot::effect::{CandidateRecord, Command, Effect, Refinement};
use vibrissa_core::units::{Megapascal, Millimetre};
use vibrissa_protocol::{ArrayType, Name, OnSupervisorLoss};
use vibrissa_simulator::Scenario;
use vibrissa_simulator::scenario::{
    ArrayScenario, Behaviour, Change, Event, Noise, RobotScenario, Rubber, TrueFormulation, WhiskerScenario,
};

pub use summary::{Summary, example, served_in, summary};
pub use truth::Truth;

use crate::World;

/// Initial pressure of both whiskers, as in the paper, MPa.
pub const START_MPA: f64 = 0.1;
/// Largest relative deviation of a plant's parameters.
pub const PLANT_ERROR: f64 = 0.1;
/// Contacts of each whisker before the cut.
pub const WHOLE_CONTACTS: u64 = 3000;
/// Contacts of each whisker after the cut.
pub const CONTACTS_AFTER: u64 = 8000;
/// Remaining length of a target that a neighbour shall serve, in mm: too short to serve itself.
const CUT_MM: f64 = 45.0;
const CONTACTS_PER_SECOND: f64 = 100.0;

/// One of the paper's experiments.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Case {
    /// Case 1: compensators of 65 to 69 mm for a target of 70 mm.
    Shorter,
    /// Case 1, special: a whisker of 70 mm trimmed to 65 to 69 mm serves itself.
    Itself,
    /// Case 2: compensators of 66 to 70 mm for a target of 65 mm.
    Longer,
}

/// All experiments, in order.
pub const CASES: [Case; 3] = [Case::Shorter, Case::Itself, Case::Longer];

impl Case {
    /// Length of the target, mm.
    #[must_use]
    pub fn target_mm(self) -> f64 {
        match self {
            Self::Shorter | Self::Itself => 70.0,
            Self::Longer => 65.0,
        }
    }

    /// Lengths of the compensators, mm.
    #[must_use]
    pub fn lengths_mm(self) -> [f64; 5] {
        match self {
            Self::Shorter | Self::Itself => [65.0, 66.0, 67.0, 68.0, 69.0],
            Self::Longer => [66.0, 67.0, 68.0, 69.0, 70.0],
        }
    }

    /// Highest permitted pressure, MPa.
    fn highest_mpa(self) -> f64 {
        match self {
            Self::Itself => START_MPA,
            Self::Shorter | Self::Longer => Megapascal::EXAMINED_MAX.mpa(),
        }
    }
}

/// One compensation on one plant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trial {
    /// Experiment that the trial belongs to.
    pub case: Case,
    /// Length of the compensator, mm.
    pub length_mm: f64,
    /// Number of the plant.
    pub plant: usize,
    /// Rubber of the plant.
    pub rubber: Rubber,
    /// Seed of its contacts and noise.
    pub seed: u64,
}

/// Eq. 35 on the plant itself: by contact ratio, and the mean.
pub type TrueError = ErrorProfile;

/// Result of a trial in which the target was served.
#[derive(Debug, Clone)]
pub struct Served {
    /// The trial with this result.
    pub trial: Trial,
    /// Chosen candidate of the first decision.
    pub chosen: CandidateRecord,
    /// Setpoint by eq. 34, as the core decided it: pressure in MPa, and its error on the plant.
    pub tip: (f64, TrueError),
    /// Setpoint with the least mean error by the model, from the core's knowledge at that time.
    pub mean: (f64, TrueError),
    /// Pressure that was held at the end, with its error on the plant.
    pub closed: (f64, TrueError),
    /// Error at that pressure with the last published gain.
    pub with_gain: TrueError,
    /// Best single pressure on this plant, by brute force.
    pub best: (f64, TrueError),
    /// Number of setpoints sent.
    pub setpoints: usize,
    /// All reviews of the setpoint.
    pub looks: Vec<Refinement>,
    /// Number of contacts at the last pressure when the last gain was published; 0 if the gain that came with the
    /// pressure was never replaced.
    pub gain_contacts: u32,
    /// The last published gain, at [`CONTACT_RATIOS`].
    pub gain: [f64; CONTACT_RATIOS.len()],
}

/// Result of a trial.
#[derive(Debug, Clone)]
pub enum Outcome {
    /// A compensator served the target.
    Served(Box<Served>),
    /// No compensator served the target.
    Unserved(Trial),
}

/// The plants of a seed; every second one has the other formulation.
#[must_use]
pub fn plants(seed: u64, count: usize) -> Vec<Rubber> {
    let mut stream = ChaCha8Rng::seed_from_u64(seed);
    let mut factor = || 1.0 + stream.random_range(-PLANT_ERROR..=PLANT_ERROR);
    (0..count)
        .map(|plant| Rubber {
            c: factor(),
            a: factor(),
            b: factor(),
            elongation: factor(),
            formulation: if plant % 2 == 0 { TrueFormulation::Published } else { TrueFormulation::Consistent },
        })
        .collect()
}

/// The trials: each length of each case on each plant.
#[must_use]
pub fn trials(seed: u64, count: usize) -> Vec<Trial> {
    let plants = plants(seed, count);
    let mut trials = Vec::new();
    for case in CASES {
        for (plant, rubber) in plants.iter().enumerate() {
            for length_mm in case.lengths_mm() {
                let number = trials.len() as u64;
                let seed = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(number);
                trials.push(Trial { case, length_mm, plant, rubber: *rubber, seed });
            }
        }
    }
    trials
}

/// Runs the trials on all processors; the results are in the order of the trials.
pub fn evaluate(trials: &[Trial], done: &(dyn Fn() + Sync)) -> Vec<Outcome> {
    trials
        .par_iter()
        .map(|trial| {
            let outcome = run(trial);
            done();
            outcome
        })
        .collect()
}

/// Runs one trial.
#[must_use]
pub fn run(trial: &Trial) -> Outcome {
    let mut params = Params::nguyen_2021(Formulation::Published);
    // Any candidate with a solution is tried.
    params.policy.predicted_error_max = f64::INFINITY;
    let mut world = World::new(&scenario(trial), params);
    let whole_s = WHOLE_CONTACTS as f64 / CONTACTS_PER_SECOND;
    world.run_until_s(whole_s - 0.1);
    let target_offset = world.core.whisker(0).map_or(Offset::NONE, |whisker| whisker.offset);
    let end_s = whole_s + CONTACTS_AFTER as f64 / CONTACTS_PER_SECOND;
    let mut now_s = whole_s;
    while world.core.compensations().is_empty() && now_s < end_s {
        now_s += 0.05;
        world.run_until_s(now_s);
    }
    let Some(index) = world.core.compensations().first().map(vibrissa_core::robot::Compensation::compensator) else {
        return Outcome::Unserved(*trial);
    };
    let mean_mpa = mean_setpoint_mpa(trial, &world, index, target_offset);
    world.run_until_s(end_s);
    served(trial, &world, mean_mpa).map_or(Outcome::Unserved(*trial), |served| Outcome::Served(Box::new(served)))
}

/// The setpoint with the other objective, which the core does not use here.
fn mean_setpoint_mpa(trial: &Trial, world: &World, index: usize, target_offset: Offset) -> Option<f64> {
    let one = world.core.whisker(index)?;
    let model = world.params.model(&one.sheet.model)?;
    let target = vibrissa_core::mechanics::Target {
        length: Millimetre::known(trial.case.target_mm()),
        pressure: Megapascal::known(START_MPA),
    };
    let fitness = Fitness {
        model,
        length: one.length.length,
        pressure: Megapascal::known(START_MPA),
        pressures: (Megapascal::ZERO, one.sheet.pressure_max),
        offset: one.offset,
        own: Default::default(),
        objective: Objective::Mean,
        usual: UsualContacts::UNKNOWN,
    };
    let proposal = propose(&world.params.policy, model, target, target_offset, &fitness, trial.case == Case::Itself);
    proposal.setpoint.map(|setpoint| setpoint.pressure.mpa())
}

fn served(trial: &Trial, world: &World, mean_mpa: Option<f64>) -> Option<Served> {
    let chosen = world
        .picked(|effect| match effect {
            Effect::Decided(decision) => Some(decision.chosen.map(|at| decision.candidates[at])),
            _ => None,
        })
        .into_iter()
        .flatten()
        .next()?;
    let sent: Vec<Command> = world.picked(|effect| match effect {
        Effect::Command(command) => Some((**command).clone()),
        _ => None,
    });
    let looks: Vec<Refinement> = world.picked(|effect| match effect {
        Effect::Refined(look) => Some((**look).clone()),
        _ => None,
    });
    let last = sent.last()?;
    let truth = Truth::new(trial);
    let at = |mpa: f64| (mpa, truth.error(mpa, None));
    let gain = last.gain?;
    let gains = looks.iter().filter(|look| look.gain_published && look.pressure_from == last.pressure);
    let (tip_mpa, held_mpa) = (chosen.pressure?.mpa(), last.pressure.mpa());
    Some(Served {
        trial: *trial,
        chosen,
        tip: at(tip_mpa),
        mean: at(mean_mpa?),
        closed: at(held_mpa),
        with_gain: truth.error(held_mpa, Some(&gain)),
        best: at(truth.best_mpa()),
        setpoints: sent.len(),
        gain_contacts: gains.map(|look| look.contacts).max().unwrap_or(0),
        looks,
        gain,
    })
}

/// One array: target and compensator of one rubber, or the one whisker that serves itself.
#[must_use]
pub fn scenario(trial: &Trial) -> Scenario {
    let target_mm = trial.case.target_mm();
    let whisker = |whisker: u16, length_mm: f64, neighbours: &[u16]| WhiskerScenario {
        whisker,
        x_mm: 25.0 * f64::from(whisker),
        length_mm,
        pressure_mpa: START_MPA,
        neighbours: neighbours.to_vec(),
        rubber: Some(trial.rubber),
        ..WhiskerScenario::default()
    };
    let (array_type, whiskers, cut_mm) = match trial.case {
        Case::Itself => (ArrayType::Type2, vec![whisker(0, target_mm, &[])], trial.length_mm),
        Case::Shorter | Case::Longer => {
            (ArrayType::Type1, vec![whisker(0, target_mm, &[1]), whisker(1, trial.length_mm, &[0])], CUT_MM)
        }
    };
    let name = |text: &str| Name::new(text).expect("a name");
    let cut = Event::at_contact(WHOLE_CONTACTS, name("a"), 0, Change::Trim { length_mm: cut_mm });
    Scenario {
        calibration: None,
        seed: trial.seed,
        fleet: name("f"),
        behaviour: Behaviour {
            contacts_per_second: CONTACTS_PER_SECOND,
            contacts_per_message: 20,
            ..Behaviour::default()
        },
        noise: Noise::default(),
        calibration_error: 0.0,
        robots: vec![RobotScenario {
            robot: name("r"),
            model: "evaluation".to_owned(),
            on_supervisor_loss: OnSupervisorLoss::Hold,
            applies_gain: false,
            arrays: vec![ArrayScenario { array: name("a"), array_type, whiskers }],
            events: vec![cut],
        }],
    }
}

impl Outcome {
    /// The trial of this outcome.
    #[must_use]
    pub fn trial(&self) -> &Trial {
        match self {
            Self::Served(served) => &served.trial,
            Self::Unserved(trial) => trial,
        }
    }
}
