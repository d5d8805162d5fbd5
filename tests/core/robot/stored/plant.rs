//! A simulated robot, its supervisor's operators, and the events of both.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use vibrissa_core::mechanics::{Formulation, Model};
use vibrissa_core::policy::Mode;
use vibrissa_core::robot::effect::{AlarmKind, Command, CommandKey, TestState};
use vibrissa_core::robot::event::{
    AirControl, ArrayKind, ArraySheet, Contact, ContactPlace, Distance, Factsheet, GaugeState, Link, MissedTouch,
    RegulatorState, Rejection, SetpointReport, Task, TestReport, TouchTests, WhiskerSheet, WhiskerStatus,
};
use vibrissa_core::robot::{OperatorAction, Params, Place, Robot, Scope, WhiskerView};
use vibrissa_core::units::{ContactRatio, Megapascal, Micros, Millimetre, Strain};

use super::{ARRAY, BOOTS, WHISKERS, YEAR_US};

/// An event that owns its content, to be played as often as needed.
#[derive(Debug, Clone)]
pub(super) enum Said {
    Connection(usize, Link),
    /// With the layout of this number.
    Factsheet(usize, usize),
    Contacts(usize, u64, Vec<Contact<'static>>, Vec<MissedTouch<'static>>),
    TouchTest((usize, CommandKey), TestReport, Micros),
    Status(usize, Micros, Vec<WhiskerStatus<'static>>),
    Setpoint(usize, Command, SetpointReport, Micros),
    Operator(OperatorAction<'static>),
    PolicyChanged(Mode),
    Tick,
}

/// A simulated robot, which does not always keep the contract.
pub(super) struct Plant {
    pub(super) random: ChaCha8Rng,
    pub(super) model: Model,
    pub(super) lengths_mm: [f64; WHISKERS as usize],
    pub(super) pressures: [Megapascal; WHISKERS as usize],
    pub(super) dead_gauge: Option<u16>,
    pub(super) boot: usize,
    pub(super) next: [u64; BOOTS.len()],
    pub(super) now: Micros,
    pub(super) under_way: Vec<Command>,
}

impl Plant {
    pub(super) fn new(seed: u64) -> Self {
        Self {
            random: ChaCha8Rng::seed_from_u64(seed),
            model: Model::nguyen_2021(Formulation::Published),
            lengths_mm: [70.0, 68.0, 66.0, 70.0],
            pressures: [Megapascal::known(0.1); WHISKERS as usize],
            dead_gauge: None,
            boot: 0,
            next: [0; BOOTS.len()],
            now: Micros(1_795_248_000_000_000),
            under_way: Vec::new(),
        }
    }

    pub(super) fn passes(&mut self, us: u64) {
        self.now = Micros(self.now.0 + us);
    }

    pub(super) fn next(&mut self, robot: &Robot) -> Said {
        self.passes(20_000);
        // Mostly a factsheet follows a birth at once.
        let is_known = robot.sequence(BOOTS[self.boot]).is_some();
        if !is_known && self.random.random_bool(0.5) {
            return Said::Factsheet(self.boot, 0);
        }
        match self.random.random_range(0..1000) {
            0..700 => self.contacts(),
            700..850 => self.status(),
            850..952 => {
                self.passes(250_000);
                Said::Tick
            }
            952..964 => self.answer(),
            964..970 => self.test_answer(robot),
            970..976 => {
                let whisker = self.random.random_range(0..usize::from(WHISKERS));
                self.lengths_mm[whisker] = (self.lengths_mm[whisker] - 6.0).max(40.0);
                self.contacts()
            }
            976..979 => {
                self.dead_gauge = (self.dead_gauge.is_none()).then(|| self.random.random_range(0..WHISKERS));
                self.contacts()
            }
            979..981 => {
                self.passes(20_000_000);
                Said::Tick
            }
            // Longer than a gap may stay open while a robot is heard.
            981..982 => {
                self.passes(400_000_000);
                self.contacts()
            }
            982..994 => Said::Operator(self.action(robot)),
            994..995 => {
                self.boot = (self.boot + 1).min(BOOTS.len() - 1);
                Said::Connection(self.boot, Link::Online)
            }
            995..996 => Said::Connection(self.boot, if self.random.random() { Link::Broken } else { Link::Offline }),
            996..998 => Said::Connection(self.boot, Link::Online),
            998..999 => {
                let mode = if self.random.random() { Mode::Advise } else { Mode::Automatic };
                Said::PolicyChanged(mode)
            }
            _ => Said::Factsheet(
                self.boot,
                if self.random.random_bool(0.3) { self.random.random_range(0..LAYOUTS) } else { 0 },
            ),
        }
    }

    pub(super) fn action(&mut self, robot: &Robot) -> OperatorAction<'static> {
        let whisker = Place { array: ARRAY, whisker: self.random.random_range(0..WHISKERS) };
        let proposed = robot.compensations().iter().find(|one| one.is_proposed()).map(|one| one.id());
        if let Some(failed) = Self::with_failed_setpoint(robot).filter(|_| self.random.random_bool(0.3)) {
            return OperatorAction::Retry(failed);
        }
        match (proposed, self.random.random_range(0..16)) {
            (Some(compensation), 0..8) => OperatorAction::Approve { compensation },
            (Some(compensation), 8..12) => OperatorAction::Refuse { compensation },
            (_, 0) => OperatorAction::Hold(Scope::Robot),
            (_, 1..4) => OperatorAction::Release(Scope::Robot),
            (_, 4..6) => OperatorAction::Hold(Scope::Whisker(whisker)),
            (_, 6..10) => OperatorAction::Release(Scope::Whisker(whisker)),
            (_, 10..12) => OperatorAction::Setpoint { whisker, pressure_mpa: self.random.random_range(0.0..0.2) },
            (_, 12) => OperatorAction::Replaced(whisker),
            (_, 13) => OperatorAction::TouchTest(whisker),
            (_, 14) => OperatorAction::RefuseTouchTest(Self::with_proposed_test(robot).unwrap_or(whisker)),
            (_, _) => OperatorAction::Rebaseline(whisker),
        }
    }

    fn with_failed_setpoint(robot: &Robot) -> Option<Place<'static>> {
        let mut views = (0..robot.whisker_count()).filter_map(|index| robot.whisker(index));
        let has_failed =
            |view: &WhiskerView<'_>| view.standing.kinds().any(|kind| kind == AlarmKind::SetpointFailed) && !view.held;
        let failed = views.find(|view| !robot.is_held() && has_failed(view));
        failed.map(|view| Place { array: ARRAY, whisker: view.sheet.number })
    }

    fn with_proposed_test(robot: &Robot) -> Option<Place<'static>> {
        let mut views = (0..robot.whisker_count()).filter_map(|index| robot.whisker(index));
        let proposed = views.find(|view| view.touch_test.is_some_and(|(_, state)| state == TestState::Proposed));
        proposed.map(|view| Place { array: ARRAY, whisker: view.sheet.number })
    }

    pub(super) fn contacts(&mut self) -> Said {
        let count = self.random.random_range(1..8);
        let contacts = (0..count).map(|_| self.contact()).collect();
        // Sometimes of an older boot, a duplicate, or with a gap.
        let is_another = self.random.random_bool(0.02);
        let boot = if is_another { self.random.random_range(0..=self.boot + 1) % BOOTS.len() } else { self.boot };
        let seq = match self.random.random_range(0..40) {
            0 => self.next[boot].saturating_sub(self.random.random_range(1..6)),
            1 => self.next[boot] + 2,
            _ => self.next[boot],
        };
        self.next[boot] = self.next[boot].max(seq + 1);
        let missed = if self.random.random_bool(0.02) { vec![self.missed()] } else { Vec::new() };
        Said::Contacts(boot, seq, contacts, missed)
    }

    pub(super) fn contact(&mut self) -> Contact<'static> {
        self.passes(2_000);
        let whisker = self.random.random_range(0..WHISKERS);
        let at = usize::from(whisker);
        let ratio = ContactRatio::known(self.random.random_range(0.5..=1.0));
        let is_test = self.random.random_bool(0.02);
        let deflection_mm: f64 = self.random.random_range(0.5..5.0);
        let pressure = self.pressures[at];
        let length = Millimetre::known(self.lengths_mm[at]);
        let per_mm = self.model.sensitivity_per_mm(ratio, length, &self.model.morphology(pressure)).unwrap();
        let noise: f64 = 1.0 + self.random.random_range(-0.05..0.05);
        let strain = if self.dead_gauge == Some(whisker) { 0.0 } else { per_mm * deflection_mm * noise };
        Contact {
            array: ARRAY,
            whisker: if self.random.random_bool(0.002) { 99 } else { whisker },
            robot_time: self.time(),
            place: if is_test || whisker == STATES_DISTANCES {
                ContactPlace::Distance(Distance { at: Millimetre::known(ratio.a() * length.mm()), sd_mm: 0.5 })
            } else {
                ContactPlace::Ratio { ratio, sd: None }
            },
            deflection: Millimetre::known(deflection_mm),
            strain: Strain::known(strain),
            pressure,
            is_test,
            angle_is_stated: false,
            saturated: false,
            temperature_c: Some(20.0 + f64::from(self.boot as u32)),
        }
    }

    /// A touch beyond the tip, or where the robot was wrong.
    fn missed(&mut self) -> MissedTouch<'static> {
        let whisker = self.random.random_range(0..WHISKERS);
        let length_mm = self.lengths_mm[usize::from(whisker)];
        let at_mm = if self.random.random_bool(0.9) { length_mm + 2.0 } else { 0.7 * length_mm };
        let at = Distance { at: Millimetre::known(at_mm), sd_mm: 0.5 };
        MissedTouch { array: ARRAY, whisker, robot_time: self.time(), at }
    }

    /// An answer to a touch test under way.
    fn test_answer(&mut self, robot: &Robot) -> Said {
        let Some((test, _)) = robot.tests_under_way().next() else { return Said::Tick };
        let report = match self.random.random_range(0..8) {
            0..2 => TestReport::Accepted,
            2..4 => TestReport::Running,
            4..6 => TestReport::Done,
            6 => TestReport::Failed,
            _ => TestReport::Rejected(Rejection::NotReady),
        };
        Said::TouchTest((self.boot, test), report, self.now)
    }

    pub(super) fn status(&mut self) -> Said {
        self.passes(500_000);
        let strange = self.random.random_range(0..200);
        let whiskers = (0..WHISKERS).map(|whisker| {
            let setpoint = self.pressures[usize::from(whisker)];
            let is_strange = strange == u32::from(whisker);
            WhiskerStatus {
                array: ARRAY,
                whisker,
                pressure: if strange == 10 { Megapascal::known(0.07) } else { setpoint },
                setpoint: if is_strange { Megapascal::known(0.13) } else { setpoint },
                regulator: match strange {
                    11 => RegulatorState::Leak,
                    12 => RegulatorState::Filling,
                    13 => RegulatorState::Venting,
                    14 => RegulatorState::SupplyLow,
                    15 => RegulatorState::Fault,
                    _ => RegulatorState::Ok,
                },
                gauge: if strange == 16 { GaugeState::Saturated } else { GaugeState::Ok },
            }
        });
        let whiskers = whiskers.collect();
        Said::Status(self.boot, self.time(), whiskers)
    }

    /// Time of the robot; sometimes a wrong one.
    pub(super) fn time(&mut self) -> Micros {
        match self.random.random_range(0..200) {
            0 => Micros(self.now.0 + YEAR_US),
            1 => Micros(self.now.0 - YEAR_US),
            2 => Micros(self.now.0 + 23_000_000),
            _ => self.now,
        }
    }

    pub(super) fn answer(&mut self) -> Said {
        if self.under_way.is_empty() {
            return Said::Tick;
        }
        let report = match self.random.random_range(0..24) {
            0 => SetpointReport::Failed,
            1 => SetpointReport::Superseded,
            2 => SetpointReport::Rejected(Rejection::Stale),
            3 => SetpointReport::Rejected(Rejection::Expired),
            4 => SetpointReport::Rejected(Rejection::OutOfRange),
            5 => SetpointReport::Rejected(Rejection::UnknownWhisker),
            6 => SetpointReport::Rejected(Rejection::WrongBoot),
            7 => SetpointReport::Rejected(Rejection::NotReady),
            12 => SetpointReport::Rejected(Rejection::InTask),
            // These are followed by another report.
            8..10 => return Said::Setpoint(self.boot, self.under_way[0].clone(), SetpointReport::Received, self.now),
            10..12 => return Said::Setpoint(self.boot, self.under_way[0].clone(), SetpointReport::Applying, self.now),
            _ => {
                let command = &self.under_way[0];
                self.pressures[command.whisker] = command.pressure;
                SetpointReport::Applied(command.pressure)
            }
        };
        Said::Setpoint(self.boot, self.under_way.remove(0), report, self.now)
    }
}

/// The whisker whose contacts state distances. It is due for touch tests.
const STATES_DISTANCES: u16 = 2;

pub(super) fn params(mode: Mode) -> Params {
    let mut params = Params::nguyen_2021(Formulation::Published);
    params.detection.cold_start_contacts = 60;
    params.refinement.first_look_contacts = 60;
    params.policy.mode = mode;
    params.touch_tests.after_pause = Micros::from_s(60.0);
    params.touch_tests.every = Micros::from_s(30.0);
    params
}

pub(super) const LAYOUTS: usize = 4;
/// A layout with whiskers for themselves, distances, tests over the tip, gauges of a known range, and no air.
pub(super) const OF_OTHER_KINDS: usize = LAYOUTS;

/// Layout 0; with other neighbours; with another whisker in the place of one; and without the last whisker.
pub(super) fn factsheet(layout: usize) -> Factsheet {
    let whiskers = if layout == 3 { WHISKERS - 1 } else { WHISKERS };
    let whisker = |number: u16| WhiskerSheet {
        number,
        x_mm: 25.0 * f64::from(number),
        y_mm: 0.0,
        model: "nguyen-2021".into(),
        length: Millimetre::known(if layout == 2 { 69.0 } else { [70.0, 68.0, 66.0, 70.0][usize::from(number)] }),
        pressure: Megapascal::known(0.1),
        pressure_max: Megapascal::EXAMINED_MAX,
        length_tolerance_mm: if layout == OF_OTHER_KINDS { 2.0 } else { 0.5 },
        strain_max: (layout == OF_OTHER_KINDS).then_some(0.02),
        neighbours: (0..whiskers)
            .filter(|other| other.abs_diff(number) == 1 || (layout == 1 && other.abs_diff(number) == 3))
            .collect(),
    };
    let whiskers = (0..whiskers).map(whisker).collect();
    let is_other = layout == OF_OTHER_KINDS;
    let (kind, task) = if is_other { (ArrayKind::Type2, Task::Distance) } else { (ArrayKind::Type1, Task::Ratio) };
    Factsheet {
        arrays: vec![ArraySheet { name: ARRAY.to_owned(), kind, task, whiskers }],
        touch_tests: TouchTests { tip: is_other, wall: !is_other && layout != 1 },
        applies_gain: layout == 2,
        air_control: match layout {
            2 => AirControl::VentOnly,
            OF_OTHER_KINDS => AirControl::None,
            _ => AirControl::FillAndVent,
        },
    }
}
