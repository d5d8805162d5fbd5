//! Parameters of the core: models, noise, limits.

use std::sync::Arc;

use crate::detection::DetectionParams;
use crate::estimation::filter::FilterParams;
use crate::estimation::{LeakParams, SensorNoise};
use crate::mechanics::{Formulation, Model};
use crate::policy::PolicyParams;
use crate::units::Micros;

/// The parameters of [`super::Robot::step`].
#[derive(Debug, Clone)]
pub struct Params {
    /// The whisker models that factsheets may name; robots share their names.
    pub models: Vec<(Arc<String>, Model)>,
    /// Stated noise of the robots' readings.
    pub noise: SensorNoise,
    /// Prior and process noise of the length filter.
    pub filter: FilterParams,
    /// Parameters of the detector.
    pub detection: DetectionParams,
    /// Parameters of the compensation policy.
    pub policy: PolicyParams,
    /// Parameters of setpoints.
    pub command: CommandParams,
    /// Limits for faults.
    pub health: HealthParams,
    /// Measurement of the compensation error.
    pub measurement: MeasurementParams,
    /// Refinement of setpoints.
    pub refinement: RefinementParams,
    /// Touch tests and the suspicion of a lost reach.
    pub touch_tests: TouchTestParams,
}

/// Parameters of setpoints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CommandParams {
    /// Slew that the robot shall keep, MPa per second.
    pub slew_mpa_per_s: f64,
    /// A setpoint expires this long after it was issued, by the robot's clock and by ours, on top of its slewing time.
    pub time_to_live: Micros,
    /// An unanswered setpoint is sent again after this.
    pub resend_after: Micros,
    /// New setpoints for one purpose after expiry, refusal or failure; then an alarm is raised.
    pub attempts: u8,
    /// Pause before the first try after the alarm; each further one is twice as long ...
    pub retry_after: Micros,
    /// ... up to this.
    pub retry_after_max: Micros,
}

/// Limits for faults.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HealthParams {
    /// A whisker is stale when neither a contact nor a status was received for this long.
    pub stale_after: Micros,
    /// A pressure this far from the setpoint is not settled, MPa: above a regulator's dither.
    pub settled_within_mpa: f64,
    /// A pressure this far from the setpoint is not held, MPa: above the dead band of on/off valves.
    pub held_within_mpa: f64,
    /// A pressure that is not held for this long, with nothing under way, is a leak.
    pub unheld_after: Micros,
    /// Detection of leaks while pressures are held.
    pub leak: LeakParams,
    /// Faults that come and go, and the delays of their alarms.
    pub flapping: FlappingParams,
    /// Contacts in a row that make a gauge fault, and twice as many good ones end it.
    pub gauge_contacts: u8,
    /// A gauge's baseline further off than this raises an alarm, m/m: twenty times the noise floor.
    pub baseline_strain_max: f64,
    /// A trim is acted on when the length's standard deviation is down to this, mm ...
    pub length_sd_max_mm: f64,
    /// ... or after this many further contacts.
    pub length_contacts_max: u32,
}

/// Faults that come and go, and the delays of their alarms, as ISA-18.2 calls them. The delays concern people: a fault counts
/// for the policy at once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FlappingParams {
    /// A fault that lasts less than this raises no alarm, unless it comes again.
    pub alarm_on_delay: Micros,
    /// The alarm is cleared once the fault has been away for this long: longer than the 10 s between two statuses.
    pub alarm_off_delay: Micros,
    /// Number of quick changes, or of slow ones, from which on a fault is latched; at most 15.
    pub latch_changes: u8,
    /// A fault that has not changed for this long is steady: no longer latched, and its next change the first one. At least
    /// as long as both delays.
    pub steady_after: Micros,
    /// After this time without a change the slow changes before are forgotten, and a fault is not latched any more.
    pub forgotten_after: Micros,
}

impl Default for FlappingParams {
    fn default() -> Self {
        Self {
            alarm_on_delay: Micros::from_s(1.0),
            alarm_off_delay: Micros::from_s(15.0),
            latch_changes: 6,
            steady_after: Micros::from_s(600.0),
            forgotten_after: Micros::from_s(2.0 * 3600.0),
        }
    }
}

/// Touch tests and the suspicion of a lost reach.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TouchTestParams {
    /// Requested tests per hour and robot; 0 for none.
    pub per_hour: u16,
    /// Contacts between two suspicions of a lost reach of a sound whisker with steady habits, on average at least.
    pub contacts_between_false_alarms: f64,
    /// Longest time that a robot may take for a contact of a test.
    pub contact_time: Micros,
    /// Pause after a test that the robot could not do, or after tests that decided nothing.
    pub pause: Micros,
    /// Tests of a measurement that follow each other without a pause.
    pub in_a_row: u8,
    /// A whisker whose contacts state no ratio to the present length is tested after a pause of its contacts as long as
    /// this, and after each restart of its robot; 0 for never.
    pub after_pause: Micros,
    /// Such a whisker is tested when this time has passed since its last test; 0 for never.
    pub every: Micros,
    /// The same for a whisker whose contacts state no place, where `every` is 0; 0 for never.
    pub every_without_place: Micros,
    /// Standard deviation of the error that all distances of a robot share, mm, before a test has measured it; 0 if the
    /// robots' distances are known to be right.
    pub zero_sd_mm: f64,
}

impl Default for TouchTestParams {
    fn default() -> Self {
        Self {
            per_hour: 30,
            contacts_between_false_alarms: 1e5,
            contact_time: Micros::from_s(10.0),
            pause: Micros::from_s(600.0),
            in_a_row: 3,
            after_pause: Micros(0),
            every: Micros(0),
            every_without_place: Micros::from_s(3600.0),
            zero_sd_mm: 1.5,
        }
    }
}

/// Measurement of the compensation error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasurementParams {
    /// A bin with fewer contacts is not measured.
    pub bin_contacts_min: u32,
    /// The error is stated anew after this many contacts of the compensator.
    pub every_contacts: u32,
}

/// Parameters of the refinement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RefinementParams {
    /// The first evaluation comes after this many contacts at a pressure, the second one after 8/3 of them, and each further
    /// one after twice as many.
    pub first_look_contacts: u32,
    /// Moves of pressure in one compensation.
    pub steps_max: u8,
    /// Expected gain in mean error (Eq. 35) below which a setpoint stays, as a ratio.
    pub margin: f64,
    /// Moves up to this are lost in a regulator's dither, MPa.
    pub dither_mpa: f64,
    /// Share of the open cases that must be better at the new pressure.
    pub confidence: f64,
    /// A gain stays while the mean error with it is below this, as a ratio.
    pub gain_margin: f64,
    /// An eroding whisker gets a setpoint, and each new one, after it has lost this much, mm.
    pub erosion_step_mm: f64,
    /// ... and after this many contacts at the last one.
    pub erosion_contacts_min: u32,
}

impl Params {
    /// Defaults, with the paper's whisker as the only model.
    #[must_use]
    pub fn nguyen_2021(formulation: Formulation) -> Self {
        Self {
            models: vec![(Arc::new("nguyen-2021".to_owned()), Model::nguyen_2021(formulation))],
            noise: SensorNoise::default(),
            filter: FilterParams::default(),
            detection: DetectionParams::default(),
            policy: PolicyParams::default(),
            command: CommandParams::default(),
            health: HealthParams::default(),
            measurement: MeasurementParams::default(),
            refinement: RefinementParams::default(),
            touch_tests: TouchTestParams::default(),
        }
    }

    /// The names of its models, to be shared.
    pub(super) fn model_names(&self) -> Vec<Arc<String>> {
        self.models.iter().map(|(name, _)| Arc::clone(name)).collect()
    }

    /// The model of that name.
    #[must_use]
    pub fn model(&self, name: &str) -> Option<&Model> {
        self.models.iter().find(|(known, _)| known.as_str() == name).map(|(_, model)| model)
    }
}

impl Default for CommandParams {
    fn default() -> Self {
        Self {
            slew_mpa_per_s: 0.02,
            time_to_live: Micros::from_s(10.0),
            resend_after: Micros::from_s(2.0),
            attempts: 3,
            retry_after: Micros::from_s(30.0),
            retry_after_max: Micros::from_s(3600.0),
        }
    }
}

impl Default for HealthParams {
    fn default() -> Self {
        Self {
            stale_after: Micros::from_s(15.0),
            settled_within_mpa: 0.004,
            held_within_mpa: 0.010,
            unheld_after: Micros::from_s(4.0),
            leak: LeakParams::default(),
            flapping: FlappingParams::default(),
            gauge_contacts: 5,
            baseline_strain_max: 1e-4,
            length_sd_max_mm: 0.3,
            length_contacts_max: 25,
        }
    }
}

impl Default for MeasurementParams {
    fn default() -> Self {
        Self { bin_contacts_min: 10, every_contacts: 100 }
    }
}

impl Default for RefinementParams {
    fn default() -> Self {
        Self {
            first_look_contacts: 300,
            steps_max: 3,
            margin: 0.005,
            dither_mpa: 0.0012,
            confidence: 0.95,
            gain_margin: 0.01,
            erosion_step_mm: 0.4,
            erosion_contacts_min: 40,
        }
    }
}

impl RefinementParams {
    /// Contacts at a pressure after which the evaluation after this one is due.
    pub(in crate::robot) fn next_look(&self, contacts: u32) -> u32 {
        if contacts / 2 < self.first_look_contacts {
            contacts.saturating_mul(8) / 3
        } else {
            contacts.saturating_mul(2)
        }
    }
}
