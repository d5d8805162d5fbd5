//! Short lives that lead to states which the random ones seldom or never reach.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use vibrissa_core::mechanics::{Formulation, Model};
use vibrissa_core::policy::Mode;
use vibrissa_core::robot::effect::Effect;
use vibrissa_core::robot::event::{
    Contact, ContactPlace, Distance, GaugeState, Link, RegulatorState, SetpointReport, WhiskerStatus,
};
use vibrissa_core::robot::{Event, Numbers, OperatorAction, Params, Place, Robot};
use vibrissa_core::units::{ContactRatio, Megapascal, Micros, Millimetre, Strain};

use super::life::Store;
use super::plant::{OF_OTHER_KINDS, factsheet, params};
use super::{ARRAY, BOOTS, WHISKERS};
use crate::nuisances::rig::{ARRAY as OF_RIG, Rig, Tests};

/// Length of the first whisker.
const LENGTH_MM: f64 = 70.0;

/// The pressure in the factsheet.
fn nominal() -> Megapascal {
    Megapascal::known(0.1)
}

/// A robot whose every message is chosen. A second passes before each.
struct Script {
    robot: Robot,
    params: Params,
    now: Micros,
    seq: u64,
    random: ChaCha8Rng,
}

impl Script {
    /// Born, with the layout of this number, and heard.
    fn born(layout: usize, mode: Mode) -> Self {
        let mut one = Self {
            robot: Robot::new(1, Numbers::default()),
            params: params(mode),
            now: Micros(1_795_248_000_000_000),
            seq: 0,
            random: ChaCha8Rng::seed_from_u64(1),
        };
        one.step(&Event::Connection { boot_id: BOOTS[0], link: Link::Online });
        one.step(&Event::Factsheet { boot_id: BOOTS[0], factsheet: &factsheet(layout) });
        (0..3).for_each(|_| one.status(|_| ()));
        one
    }

    fn step(&mut self, event: &Event<'_>) -> Vec<Effect> {
        let mut effects = Vec::new();
        self.now = self.now.after(Micros::from_s(1.0));
        self.robot.step(&self.params, self.now, event, &mut effects);
        effects
    }

    /// A status with everything in order, but for the change to the first whisker.
    fn status(&mut self, change: impl Fn(&mut WhiskerStatus<'static>)) {
        let in_order = |whisker| WhiskerStatus {
            array: ARRAY,
            whisker,
            pressure: nominal(),
            setpoint: nominal(),
            regulator: RegulatorState::Ok,
            gauge: GaugeState::Ok,
        };
        let mut whiskers: Vec<_> = (0..WHISKERS).map(in_order).collect();
        change(&mut whiskers[0]);
        let robot_time = self.now;
        self.step(&Event::Status { boot_id: BOOTS[0], robot_time, whiskers: &whiskers });
    }

    /// A message with one contact of the first whisker up to a contact ratio; `place` and `gauge` are its robot's
    /// readings of the true contact ratio and strain.
    fn touched(&mut self, up_to: f64, place: impl Fn(ContactRatio) -> ContactPlace, gauge: impl Fn(f64) -> f64) {
        let ratio = ContactRatio::known(self.random.random_range(0.5..=up_to));
        let deflection_mm: f64 = self.random.random_range(0.5..5.0);
        let model = Model::nguyen_2021(Formulation::Published);
        let per_mm =
            model.sensitivity_per_mm(ratio, Millimetre::known(LENGTH_MM), &model.morphology(nominal())).unwrap();
        let noise: f64 = 1.0 + self.random.random_range(-0.03..0.03);
        let contact = Contact {
            array: ARRAY,
            whisker: 0,
            robot_time: self.now,
            place: place(ratio),
            deflection: Millimetre::known(deflection_mm),
            strain: Strain::known(gauge(per_mm * deflection_mm * noise)),
            pressure: nominal(),
            is_test: false,
            angle_is_stated: false,
            saturated: false,
            temperature_c: None,
        };
        self.numbered(self.seq, &[contact]);
        self.seq += 1;
    }

    fn numbered(&mut self, seq: u64, contacts: &[Contact<'_>]) {
        self.step(&Event::Contacts { boot_id: BOOTS[0], seq, contacts, missed: &[] });
    }

    fn stored(&self) -> Store {
        Store::all_of(&self.robot)
    }
}

fn first() -> Place<'static> {
    Place { array: ARRAY, whisker: 0 }
}

/// Whiskers for themselves that compare readings at distances, no air, gauges of a known range, and only tests over the tip.
fn of_other_kinds() -> Store {
    let mut one = Script::born(OF_OTHER_KINDS, Mode::Automatic);
    one.step(&Event::Operator(&OperatorAction::TouchTest(first())));
    (0..3).for_each(|_| one.touched(1.0, |ratio| ContactPlace::Ratio { ratio, sd: None }, |strain| strain));
    one.stored()
}

fn with_a_received_setpoint() -> Store {
    let mut one = Script::born(0, Mode::Automatic);
    let by_hand = OperatorAction::Setpoint { whisker: first(), pressure_mpa: 0.05 };
    let mut effects = one.step(&Event::Operator(&by_hand));
    effects.extend(one.step(&Event::Tick));
    let command = |effect: &Effect| if let Effect::Command(command) = effect { Some(command.key) } else { None };
    let command = effects.iter().find_map(command).unwrap();
    let (report, robot_time) = (SetpointReport::Received, one.now);
    one.step(&Event::Setpoint { boot_id: BOOTS[0], command, report, robot_time });
    one.stored()
}

/// Replaced boots come back.
fn of_two_robots() -> Store {
    let mut one = Script::born(0, Mode::Automatic);
    one.step(&Event::Connection { boot_id: BOOTS[1], link: Link::Online });
    one.step(&Event::Factsheet { boot_id: BOOTS[1], factsheet: &factsheet(0) });
    for _ in 0..3 {
        one.step(&Event::Connection { boot_id: BOOTS[0], link: Link::Online });
    }
    one.stored()
}

/// Restored by a supervisor that does not know of the last setpoint.
fn with_a_stray_pressure() -> Store {
    let mut one = Script::born(0, Mode::Automatic);
    let Store { head, whiskers } = one.stored();
    one.robot = Robot::from_bytes(&head, &whiskers, 2, one.now).unwrap();
    let stray = Megapascal::known(0.13);
    one.status(|whisker| (whisker.pressure, whisker.setpoint) = (stray, stray));
    one.stored()
}

/// The robot vents a whisker again and again.
fn vented() -> Store {
    let mut one = Script::born(0, Mode::Automatic);
    for _ in 0..3 {
        one.status(|whisker| (whisker.pressure, whisker.setpoint) = (Megapascal::ZERO, Megapascal::ZERO));
        one.status(|_| ());
    }
    for _ in 0..30 {
        one.status(|whisker| (whisker.pressure, whisker.setpoint) = (Megapascal::ZERO, Megapascal::ZERO));
    }
    one.stored()
}

fn with_a_reported(gauge: GaugeState) -> Store {
    let mut one = Script::born(0, Mode::Automatic);
    one.status(|whisker| whisker.gauge = gauge);
    one.stored()
}

/// Contacts show that the gauge does not follow the strain.
fn with_a_gauge_that(reads: impl Fn(f64) -> f64) -> Store {
    let mut one = Script::born(0, Mode::Automatic);
    let place = |ratio| ContactPlace::Ratio { ratio, sd: None };
    (0..300).for_each(|_| one.touched(1.0, place, |strain| strain));
    (0..30).for_each(|_| one.touched(1.0, place, &reads));
    one.stored()
}

/// So many messages are missing that further ones are not taken.
fn with_too_many_gaps() -> Store {
    let mut one = Script::born(0, Mode::Automatic);
    (0..70).for_each(|gap| one.numbered(2 * gap, &[]));
    one.stored()
}

/// Touches near the tip fail to come, and an operator refuses the test that is proposed.
fn with_a_refused_test() -> Store {
    let mut one = Script::born(0, Mode::Advise);
    let distance = |ratio: ContactRatio| {
        ContactPlace::Distance(Distance { at: Millimetre::known(LENGTH_MM * ratio.a()), sd_mm: 0.5 })
    };
    (0..800).for_each(|_| one.touched(1.0, distance, |strain| strain));
    (0..400).for_each(|_| one.touched(0.8, distance, |strain| strain));
    one.step(&Event::Operator(&OperatorAction::RefuseTouchTest(first())));
    one.stored()
}

fn rig(rounds: u64, mut wears: impl FnMut(&mut Rig)) -> Store {
    let mut rig = Rig::new(1, 3);
    rig.run(600);
    rig.run_with(rounds, |rig| wears(rig));
    Store::all_of(&rig.core)
}

/// A robot that never answers the request of a test after a change of sensitivity.
fn with_a_test_of_a_change() -> Store {
    let mut rig = Rig::with_tests(1, 1, Tests::Ignores);
    rig.params.touch_tests.zero_sd_mm = 0.0;
    rig.run(600);
    rig.whiskers[0].gain = 1.06;
    while rig.view(0).touch_test.is_none() {
        assert!(rig.rounds < 2000, "no test was requested");
        rig.run(1);
    }
    Store::all_of(&rig.core)
}

/// A robot whose millimetres are right has measured a length.
fn measured() -> Store {
    let mut rig = Rig::with_tests(1, 1, Tests::Does);
    rig.params.touch_tests.zero_sd_mm = 0.0;
    rig.states_distance = true;
    rig.run(600);
    rig.whiskers[0].length_mm = 64.0;
    let asked = OperatorAction::TouchTest(Place { array: OF_RIG, whisker: 0 });
    rig.step(&Event::Operator(&asked));
    rig.run(100);
    assert_eq!(rig.trims().len(), 1);
    Store::all_of(&rig.core)
}

fn leaking() -> Store {
    let mut rig = Rig::new(1, 1);
    for second in 0..300 {
        let mpa = 0.1 - 0.001 * f64::from(second % 10);
        rig.whiskers[0].read = Some(Megapascal::known(mpa));
        rig.wait_1_s();
    }
    Store::all_of(&rig.core)
}

/// The cables of two whiskers are exchanged.
fn exchanged() -> Store {
    let mut rig = Rig::new(1, 3);
    rig.whiskers[0].gain = 0.8;
    rig.run(800);
    rig.whiskers.swap(0, 1);
    rig.run(100);
    Store::all_of(&rig.core)
}

/// A new whisker is put in the place of a cut one.
fn replaced() -> Store {
    let mut rig = Rig::new(1, 3);
    rig.run(800);
    rig.whiskers[0].length_mm = 64.0;
    rig.run(1200);
    rig.whiskers[0].length_mm = 70.0;
    rig.run(100);
    Store::all_of(&rig.core)
}

/// Every other contact reads too much, for so many rounds.
fn misfitting(rounds: u64) -> Store {
    rig(rounds, |rig| rig.whiskers[0].gain = if rig.rounds.is_multiple_of(2) { 1.9 } else { 1.0 })
}

pub(super) fn stores() -> Vec<Store> {
    vec![
        of_other_kinds(),
        with_a_received_setpoint(),
        of_two_robots(),
        with_a_stray_pressure(),
        vented(),
        with_a_reported(GaugeState::Open),
        with_a_reported(GaugeState::Short),
        with_a_gauge_that(|_| 0.9),
        with_a_gauge_that(|strain| strain.min(0.002)),
        with_too_many_gaps(),
        with_a_refused_test(),
        with_a_test_of_a_change(),
        rig(900, |rig| rig.whiskers[0].length_mm -= 0.005),
        rig(900, |rig| rig.whiskers[0].length_mm = 64.0),
        rig(400, |rig| rig.whiskers.iter_mut().for_each(|one| one.gain = 0.93)),
        rig(300, |rig| rig.whiskers[0].gain = 0.5),
        rig(1500, |rig| rig.whiskers[0].baseline_strain += 1e-6),
        leaking(),
        measured(),
        with_a_gauge_that(|strain| -strain),
        exchanged(),
        replaced(),
        misfitting(60),
        misfitting(200),
    ]
}
