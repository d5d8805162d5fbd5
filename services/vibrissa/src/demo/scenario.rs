//! The demo's fleet and what is expected of its supervision, in one list, so that neither drifts from the other.

use vibrissa_core::policy::Case;
use vibrissa_protocol::{ArrayType, BadName, Name, OnSupervisorLoss};
use vibrissa_simulator::Scenario;
use vibrissa_simulator::scenario::{ArrayScenario, Behaviour, Change, Event, Noise, RobotScenario, WhiskerScenario};

/// Contacts of each whisker per second: time-lapse, so that the demo takes half a minute.
pub const CONTACTS_PER_SECOND: f64 = 60.0;
/// The fleet's name.
pub const FLEET: &str = "demo";

/// Something that happens to a whisker, and what the supervisor is to make of it.
#[derive(Debug, Clone, Copy)]
pub struct Incident {
    /// Robot.
    pub robot: &'static str,
    /// Array.
    pub array: &'static str,
    /// Whisker.
    pub whisker: u16,
    /// After how many of its contacts.
    pub at_contact: u64,
    /// What happens.
    pub what: What,
}

/// What happens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum What {
    /// A cut that shall be compensated in this way, by that whisker of the array.
    Trim {
        /// What is left.
        length_mm: f64,
        /// How.
        case: Case,
        /// By one of these.
        by: &'static [u16],
    },
    /// A cut that nobody can compensate.
    TooShort {
        /// What is left.
        length_mm: f64,
    },
    /// Erosion.
    Erosion {
        /// How fast.
        rate_mm_per_contact: f64,
        /// Where it ends.
        until_length_mm: f64,
    },
}

/// Everything that happens in the demo.
pub const INCIDENTS: [Incident; 5] = [
    Incident {
        robot: "crawler-1",
        array: "left",
        whisker: 2,
        at_contact: 300,
        what: What::Trim { length_mm: 65.0, case: Case::SelfCompensation, by: &[2] },
    },
    Incident {
        robot: "crawler-1",
        array: "left",
        whisker: 4,
        at_contact: 420,
        what: What::Trim { length_mm: 56.0, case: Case::ShorterForLonger, by: &[3, 5] },
    },
    Incident {
        robot: "crawler-2",
        array: "nose",
        whisker: 0,
        at_contact: 360,
        what: What::Trim { length_mm: 66.0, case: Case::SelfCompensation, by: &[0] },
    },
    Incident {
        robot: "crawler-2",
        array: "nose",
        whisker: 1,
        at_contact: 300,
        what: What::Erosion { rate_mm_per_contact: 0.003, until_length_mm: 64.0 },
    },
    Incident {
        robot: "crawler-2",
        array: "nose",
        whisker: 2,
        at_contact: 480,
        what: What::TooShort { length_mm: 48.0 },
    },
];

/// A Type 1 array of six and three single whiskers (Type 2).
///
/// # Errors
/// Never: the names are good ones.
pub fn scenario(seed: u64) -> Result<Scenario, BadName> {
    let left = array("left", ArrayType::Type1, &[70.0, 68.0, 70.0, 65.0, 70.0, 68.0])?;
    let nose = array("nose", ArrayType::Type2, &[70.0, 70.0, 70.0])?;
    Ok(Scenario {
        seed,
        fleet: Name::new(FLEET)?,
        behaviour: Behaviour {
            contacts_per_second: CONTACTS_PER_SECOND,
            contacts_per_message: 6,
            message_after_s: 0.2,
            ..Behaviour::default()
        },
        noise: Noise::default(),
        calibration_error: 0.03,
        robots: vec![robot("crawler-1", left)?, robot("crawler-2", nose)?],
    })
}

fn robot(name: &str, array: ArrayScenario) -> Result<RobotScenario, BadName> {
    let mut events = Vec::new();
    for incident in INCIDENTS.iter().filter(|incident| incident.robot == name) {
        let change = match incident.what {
            What::Trim { length_mm, .. } | What::TooShort { length_mm } => Change::Trim { length_mm },
            What::Erosion { rate_mm_per_contact, until_length_mm } => {
                Change::Erode { rate_mm_per_contact, until_length_mm }
            }
        };
        events.push(Event::at_contact(incident.at_contact, Name::new(incident.array)?, incident.whisker, change));
    }
    Ok(RobotScenario {
        robot: Name::robot(name)?,
        model: "crawler".to_owned(),
        on_supervisor_loss: OnSupervisorLoss::Hold,
        arrays: vec![array],
        events,
    })
}

fn array(name: &str, array_type: ArrayType, lengths_mm: &[f64]) -> Result<ArrayScenario, BadName> {
    let count = lengths_mm.len() as u16;
    let neighbours = |whisker: u16| match array_type {
        ArrayType::Type1 => {
            [whisker.checked_sub(1), Some(whisker + 1).filter(|&right| right < count)].into_iter().flatten().collect()
        }
        ArrayType::Type2 => Vec::new(),
    };
    let whiskers = lengths_mm.iter().zip(0..).map(|(&length_mm, whisker)| WhiskerScenario {
        whisker,
        x_mm: 25.0 * f64::from(whisker),
        length_mm,
        neighbours: neighbours(whisker),
        ..WhiskerScenario::default()
    });
    Ok(ArrayScenario { array: Name::new(name)?, array_type, whiskers: whiskers.collect() })
}
