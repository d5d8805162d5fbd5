//! Messages of the load's robots other than contacts: births, factsheets, statuses, answers.

use vibrissa_protocol::{
    ArrayFacts, ArrayType, BootId, Connection, ConnectionState, Factsheet, Gauge, Name, OnSupervisorLoss, Regulator,
    Setpoint, SetpointOutcome, SetpointState, Status, Timestamp, WhiskerFacts, WhiskerStatus, encode,
};

use rand::Rng;
use rand_chacha::ChaCha8Rng;

use vibrissa_robot::contract::births::DELAY_MAX_US;

use super::cuts::Cuts;
use super::kept::Outbox;
use super::plan::LoadPlan;
use crate::random::{Purpose, stream};
use crate::scenario::WhiskerScenario;

/// One robot of the load.
#[derive(Debug)]
pub struct Robot {
    /// Number of the robot in the fleet.
    pub number: usize,
    /// Topic of the robot without the last level: `whisker/v1/fleet/r000000/`.
    pub level: String,
    /// Contacts messages without a receipt.
    pub outbox: Outbox,
    /// Cut whiskers of the robot.
    pub cuts: Cuts,
    /// Time of the next status, in microseconds since 1970 UTC.
    pub status_at_us: u64,
    boot_id: BootId,
    arrays: Vec<Name>,
    pressures_mpa: Vec<f64>,
    array_whiskers: usize,
    /// Time of the answer to a request for births, if one waits for it.
    birth_at_us: Option<u64>,
    delays: ChaCha8Rng,
    connection_seq: u64,
    status_seq: u64,
    factsheet_seq: u64,
    answer_seq: u64,
}

impl Robot {
    /// A robot that has not sent anything yet.
    #[must_use]
    pub fn new(plan: &LoadPlan, number: usize, boot_id: &BootId) -> Self {
        let arrays = plan.whiskers.div_ceil(plan.array_whiskers);
        let array = |index| Name::new(&plan.place(index * plan.array_whiskers).0).expect("a letter and digits");
        Self {
            number,
            level: format!("whisker/v1/{}/{}/", plan.fleet, plan.robot(number)),
            outbox: Outbox::default(),
            cuts: Cuts::default(),
            status_at_us: 0,
            boot_id: boot_id.clone(),
            arrays: (0..arrays).map(array).collect(),
            pressures_mpa: vec![WhiskerScenario::default().pressure_mpa; plan.whiskers],
            array_whiskers: plan.array_whiskers,
            birth_at_us: None,
            delays: stream(0, plan.robot(number).as_str(), "", 0, Purpose::Birth),
            connection_seq: 0,
            status_seq: 0,
            factsheet_seq: 0,
            answer_seq: 0,
        }
    }

    /// The encoded birth or farewell.
    #[must_use]
    pub fn connection(&mut self, now_us: u64, state: ConnectionState) -> Vec<u8> {
        let seq = take(&mut self.connection_seq);
        encode(&Connection { boot_id: self.boot_id.clone(), seq, timestamp: Timestamp(now_us), state })
    }

    /// Handles a request for births: the answer is due at a random time, and serves all requests before it.
    pub fn birth_requested(&mut self, now_us: u64) {
        let delay_us = self.delays.random_range(0..DELAY_MAX_US);
        self.birth_at_us.get_or_insert(now_us + delay_us);
    }

    /// True once if a birth is due.
    pub fn takes_birth(&mut self, now_us: u64) -> bool {
        self.birth_at_us.take_if(|at_us| *at_us <= now_us).is_some()
    }

    /// The encoded factsheet.
    #[must_use]
    pub fn factsheet(&mut self, now_us: u64) -> Vec<u8> {
        let whiskers = self.pressures_mpa.len();
        let array = |(index, array): (usize, &Name)| {
            let count = (whiskers - index * self.array_whiskers).min(self.array_whiskers);
            // A whisker without neighbours can only compensate for itself.
            let array_type = if count > 1 { ArrayType::Type1 } else { ArrayType::Type2 };
            let whiskers = (0..count).map(|number| whisker_facts(number as u16, count as u16)).collect();
            ArrayFacts { array: array.clone(), array_type, task: None, whiskers }
        };
        encode(&Factsheet {
            boot_id: self.boot_id.clone(),
            seq: take(&mut self.factsheet_seq),
            timestamp: Timestamp(now_us),
            model: "load".to_owned(),
            on_supervisor_loss: OnSupervisorLoss::Hold,
            arrays: self.arrays.iter().enumerate().map(array).collect(),
            touch_tests: Vec::new(),
            applies_gain: false,
            air_control: None,
            software: Vec::new(),
        })
    }

    /// The encoded status; all chambers are in order.
    #[must_use]
    pub fn status(&mut self, now_us: u64) -> Vec<u8> {
        let status = |(whisker, &pressure_mpa): (usize, &f64)| WhiskerStatus {
            array: self.arrays[whisker / self.array_whiskers].clone(),
            whisker: (whisker % self.array_whiskers) as u16,
            pressure_mpa,
            setpoint_mpa: pressure_mpa,
            regulator: Regulator::Ok,
            gauge: Gauge::Ok,
            segmenter: None,
        };
        encode(&Status {
            boot_id: self.boot_id.clone(),
            seq: take(&mut self.status_seq),
            t_us: now_us,
            whiskers: self.pressures_mpa.iter().enumerate().map(status).collect(),
            contacts_dropped: None,
        })
    }

    /// Applies a setpoint at once; returns the whisker and the encoded answers. `None` if the setpoint is for
    /// another boot or for an unknown whisker.
    pub fn apply(&mut self, setpoint: &Setpoint, now_us: u64) -> Option<(usize, [Vec<u8>; 3])> {
        let array = self.arrays.iter().position(|array| *array == setpoint.array)?;
        let whisker = array * self.array_whiskers + usize::from(setpoint.whisker);
        if setpoint.robot_boot_id != self.boot_id || whisker >= self.pressures_mpa.len() {
            return None;
        }
        self.pressures_mpa[whisker] = setpoint.pressure_mpa;
        let outcomes = [SetpointOutcome::Received, SetpointOutcome::Applying, SetpointOutcome::Applied];
        let answers = outcomes.map(|state| {
            encode(&SetpointState {
                boot_id: self.boot_id.clone(),
                seq: take(&mut self.answer_seq),
                command_id: setpoint.command_id.clone(),
                state,
                t_us: now_us,
                pressure_mpa: Some(setpoint.pressure_mpa),
                error: None,
            })
        });
        Some((whisker, answers))
    }
}

fn whisker_facts(number: u16, count: u16) -> WhiskerFacts {
    let WhiskerScenario { length_mm, pressure_mpa, pressure_max_mpa, .. } = WhiskerScenario::default();
    let neighbours = [number.checked_sub(1), Some(number + 1).filter(|&next| next < count)];
    WhiskerFacts {
        whisker: number,
        x_mm: 25.0 * f64::from(number),
        y_mm: 0.0,
        model: "nguyen-2021".to_owned(),
        length_mm,
        pressure_mpa,
        pressure_max_mpa,
        neighbours: neighbours.into_iter().flatten().collect(),
        place: None,
        length_tolerance_mm: None,
        strain_max: None,
    }
}

fn take(counter: &mut u64) -> u64 {
    let seq = *counter;
    *counter += 1;
    seq
}
