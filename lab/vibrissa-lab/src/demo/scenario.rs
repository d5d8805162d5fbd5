//! The demo's fleet, its incidents and the expected reactions in one list, so that they stay consistent.

use vibrissa_core::policy::Case;
use vibrissa_protocol::{ArrayType, BadName, Name, OnSupervisorLoss};
use vibrissa_simulator::Scenario;
use vibrissa_simulator::scenario::{ArrayScenario, Behaviour, Change, Event, Noise, RobotScenario, WhiskerScenario};

/// Contacts of each whisker per second: time-lapse, so that the demo takes half a minute.
pub const CONTACTS_PER_SECOND: f64 = 60.0;
/// The robot that multiplies its readings.
pub const MULTIPLIES: &str = "crawler-2";
/// The fleet's name.
pub const FLEET: &str = "demo";

/// An incident of a whisker, and the expected reaction of the supervisor.
#[derive(Debug, Clone, Copy)]
pub struct Incident {
    /// Name of the robot.
    pub robot: &'static str,
    /// Name of the array.
    pub array: &'static str,
    /// Number of the whisker in its array.
    pub whisker: u16,
    /// Number of its contacts after which the incident happens.
    pub at_contact: u64,
    /// Kind of the incident.
    pub what: What,
}

/// Kind of an incident.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum What {
    /// A cut that must be compensated in this case, by one of these whiskers of the array.
    Trim {
        /// Remaining length, mm.
        length_mm: f64,
        /// Expected case of the compensation.
        case: Case,
        /// Numbers of the acceptable compensators.
        by: &'static [u16],
    },
    /// A cut that no whisker can compensate.
    TooShort {
        /// Remaining length, mm.
        length_mm: f64,
    },
    /// Gradual shortening by wear.
    Erosion {
        /// Rate, mm per contact.
        rate_mm_per_contact: f64,
        /// Length at which it ends, mm.
        until_length_mm: f64,
    },
}

/// All incidents of the demo.
pub const INCIDENTS: [Incident; 6] = [
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
        robot: "crawler-1",
        array: "tail",
        whisker: 0,
        at_contact: 480,
        what: What::TooShort { length_mm: 48.0 },
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
        what: What::Erosion { rate_mm_per_contact: 0.002, until_length_mm: 64.0 },
    },
    Incident {
        robot: "crawler-2",
        array: "nose",
        whisker: 2,
        at_contact: 480,
        what: What::Trim { length_mm: 48.0, case: Case::SelfCompensation, by: &[2] },
    },
];

/// Two robots. One has air alone, with a Type 1 array of six and a single whisker (Type 2). The other multiplies its readings,
/// and has three single whiskers.
///
/// # Errors
/// Never: the names are valid.
pub fn scenario(seed: u64) -> Result<Scenario, BadName> {
    let left = array("left", ArrayType::Type1, &[70.0, 68.0, 70.0, 65.0, 70.0, 68.0])?;
    let tail = array("tail", ArrayType::Type2, &[70.0])?;
    let nose = array("nose", ArrayType::Type2, &[70.0, 70.0, 70.0])?;
    Ok(Scenario {
        calibration: None,
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
        robots: vec![robot("crawler-1", vec![left, tail])?, robot("crawler-2", vec![nose])?],
    })
}

fn robot(name: &str, arrays: Vec<ArrayScenario>) -> Result<RobotScenario, BadName> {
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
        applies_gain: name == MULTIPLIES,
        arrays,
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
