//! One life of a robot with a checkpoint after every step, and parts of it played again from what was stored.

use std::collections::BTreeMap;

use vibrissa_core::policy::Mode;
use vibrissa_core::robot::effect::Effect;
use vibrissa_core::robot::event::Link;
use vibrissa_core::robot::{Event, Numbers, Outcome, Params, Robot};
use vibrissa_core::units::Micros;

use super::BOOTS;
use super::kinds::kind_of;
use super::plant::{Plant, Said, factsheet, params};

/// The result of a step.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Step {
    pub(super) outcome: Outcome,
    /// Without requests for the factsheet: when the last one was made is not stored.
    pub(super) effects: Vec<Effect>,
}

/// Steps a robot; `kind` is called with the name of the event's kind.
pub(super) fn step(
    robot: &mut Robot,
    params: &Params,
    now: Micros,
    said: &Said,
    kind: &mut impl FnMut(&'static str),
) -> Step {
    let mut effects = Vec::new();
    let mut tell = |event: &Event<'_>| {
        let outcome = robot.step(params, now, event, &mut effects);
        if outcome == Outcome::Taken {
            kind(kind_of(event));
        }
        outcome
    };
    let outcome = match said {
        Said::Connection(boot, link) => tell(&Event::Connection { boot_id: BOOTS[*boot], link: *link }),
        Said::Factsheet(boot, layout) => {
            tell(&Event::Factsheet { boot_id: BOOTS[*boot], factsheet: &factsheet(*layout) })
        }
        Said::Contacts(boot, seq, contacts, missed) => {
            tell(&Event::Contacts { boot_id: BOOTS[*boot], seq: *seq, contacts, missed })
        }
        Said::TouchTest(test, report, robot_time) => {
            let (boot_id, test, report, robot_time) = (BOOTS[test.0], test.1, *report, *robot_time);
            tell(&Event::TouchTest { boot_id, test, report, robot_time })
        }
        Said::Status(boot, robot_time, whiskers) => {
            tell(&Event::Status { boot_id: BOOTS[*boot], robot_time: *robot_time, whiskers })
        }
        Said::Setpoint(boot, command, report, robot_time) => {
            let (boot_id, report, robot_time) = (BOOTS[*boot], *report, *robot_time);
            tell(&Event::Setpoint { boot_id, command: command.key, report, robot_time })
        }
        Said::Operator(action) => tell(&Event::Operator(action)),
        Said::PolicyChanged(_) => tell(&Event::PolicyChanged),
        Said::Tick => tell(&Event::Tick),
    };
    effects.retain(|effect| *effect != Effect::AskForFactsheet);
    Step { outcome, effects }
}

/// The parts that a store has: it writes the marked ones.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Store {
    pub(super) head: Vec<u8>,
    pub(super) whiskers: Vec<Vec<u8>>,
}

impl Store {
    /// Returns how many parts were written.
    pub(super) fn write(&mut self, robot: &mut Robot) -> usize {
        let changed = robot.has_changed();
        let (mut indices, head) = (Vec::new(), robot.take_changed());
        robot.take_changed_whiskers(|index| indices.push(index));
        assert_eq!(changed, head || !indices.is_empty());
        assert!(!robot.has_changed());
        if head {
            self.head = robot.to_bytes().unwrap();
        }
        self.whiskers.resize(robot.whisker_count(), Vec::new());
        for &index in &indices {
            self.whiskers[index] = robot.whisker_to_bytes(index).unwrap();
        }
        usize::from(head) + indices.len()
    }

    pub(super) fn parts_other_than(&self, before: &Self) -> usize {
        let is_other = |&index: &usize| before.whiskers.get(index) != Some(&self.whiskers[index]);
        usize::from(self.head != before.head) + (0..self.whiskers.len()).filter(is_other).count()
    }

    pub(super) fn all_of(robot: &Robot) -> Self {
        let whiskers = (0..robot.whisker_count()).map(|index| robot.whisker_to_bytes(index).unwrap()).collect();
        Self { head: robot.to_bytes().unwrap(), whiskers }
    }

    /// The first difference from another: the whisker, or none for the head, and the byte.
    pub(super) fn first_difference(&self, other: &Self) -> Option<(Option<usize>, usize)> {
        let byte = |one: &[u8], other: &[u8]| {
            let differs = one.iter().zip(other).position(|(one, other)| one != other);
            differs.or((one.len() != other.len()).then_some(one.len().min(other.len())))
        };
        let whiskers = self.whiskers.iter().zip(&other.whiskers).enumerate();
        let of_head = byte(&self.head, &other.head).map(|at| (None, at));
        of_head.or(whiskers.filter_map(|(index, (one, other))| Some((Some(index), byte(one, other)?))).next())
    }
}

/// One life of a robot, with a checkpoint after every step.
pub(super) struct Life {
    /// For [`Mode::Automatic`] and [`Mode::Advise`].
    pub(super) params: [Params; 2],
    /// Events, each with its time and the mode from then on.
    pub(super) events: Vec<(Micros, Mode, Said)>,
    pub(super) steps: Vec<Step>,
    /// After each event.
    pub(super) stored: Vec<Store>,
    /// How often each kind of event was taken.
    pub(super) kinds: BTreeMap<&'static str, usize>,
    /// Parts that were written, and those of them that had not changed.
    pub(super) written: [usize; 2],
}

impl Life {
    pub(super) fn new(seed: u64, events: usize) -> Self {
        let mut plant = Plant::new(seed);
        let mut robot = Robot::new(1, Numbers::default());
        let mut life = Self {
            params: [Mode::Automatic, Mode::Advise].map(params),
            events: Vec::new(),
            steps: Vec::new(),
            stored: Vec::new(),
            kinds: BTreeMap::new(),
            written: [0; 2],
        };
        let mut store = Store::default();
        let mut mode = if seed.is_multiple_of(2) { Mode::Automatic } else { Mode::Advise };
        let born = [Said::Connection(0, Link::Online), Said::Factsheet(0, 0)];
        for at in 0..events {
            let said = born.get(at).cloned().unwrap_or_else(|| plant.next(&robot));
            if let Said::PolicyChanged(next) = said {
                mode = next;
            }
            let mut kind = |name| *life.kinds.entry(name).or_default() += 1;
            let step = step(&mut robot, &life.params[usize::from(mode == Mode::Advise)], plant.now, &said, &mut kind);
            plant.under_way.extend(step.effects.iter().filter_map(|effect| match effect {
                Effect::Command(command) => Some((**command).clone()),
                _ => None,
            }));
            let before = store.clone();
            let written = store.write(&mut robot);
            let unmarked = store.first_difference(&Store::all_of(&robot));
            assert_eq!(unmarked, None, "seed {seed}: a change by event {at} is not marked: {said:?}");
            life.written[0] += written;
            life.written[1] += written - store.parts_other_than(&before);
            life.events.push((plant.now, mode, said));
            life.steps.push(step);
            life.stored.push(store.clone());
        }
        life
    }

    /// Plays event `at` to a robot.
    pub(super) fn play(&self, robot: &mut Robot, at: usize) -> Step {
        let (now, mode, said) = &self.events[at];
        step(robot, &self.params[usize::from(*mode == Mode::Advise)], *now, said, &mut |_| ())
    }

    /// Restores the robot after event `from`, and plays all later events again.
    pub(super) fn again_from(&self, from: usize) {
        let Store { head, whiskers } = &self.stored[from];
        let mut robot = Robot::restore(head, whiskers).unwrap();
        assert_eq!(Store::all_of(&robot), self.stored[from]);
        for at in from + 1..self.events.len() {
            let said = &self.events[at].2;
            assert_eq!(self.play(&mut robot, at), self.steps[at], "from {from}, event {at}: {said:?}");
            let differs = Store::all_of(&robot).first_difference(&self.stored[at]);
            assert_eq!(differs, None, "from {from}, event {at}: {said:?}");
        }
    }
}
