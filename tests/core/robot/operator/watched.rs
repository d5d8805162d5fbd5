//! Random actions, with invariants that are checked after each of them.

use std::collections::{BTreeMap, BTreeSet};

use rand::seq::IndexedRandom;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use vibrissa_core::policy::Mode;
use vibrissa_core::robot::effect::{AlarmKind, Command, Effect, Reason};
use vibrissa_core::robot::{Event, OperatorAction, Outcome, Scope};
use vibrissa_core::units::Millimetre;
use vibrissa_evaluation::World;
use vibrissa_protocol::ArrayType;
use vibrissa_simulator::Scenario;
use vibrissa_simulator::scenario::{Change, Event as Planned};

use super::{ask, at, commands, cut_world, ended, params, standing};

fn any_scenario(random: &mut ChaCha8Rng, seed: u64) -> Scenario {
    let count = random.random_range(2..=6);
    let lengths_mm: Vec<f64> = (0..count).map(|_| random.random_range(62.0..72.0)).collect();
    let array_type = if random.random_bool(0.8) { ArrayType::Type1 } else { ArrayType::Type2 };
    let mut scenario = crate::scenario(seed, array_type, &lengths_mm);
    for _ in 0..random.random_range(1..=5) {
        let whisker = random.random_range(0..count);
        let length_mm = lengths_mm[whisker] - random.random_range(2.5..16.0);
        let change = match random.random_range(0..10) {
            0 => Change::Leak { rate_mpa_per_s: 0.01 },
            1 => Change::GaugeShort,
            2 => Change::GaugeOk,
            3 => Change::Silent { for_s: 20.0 },
            _ => Change::Trim { length_mm },
        };
        let at = random.random_range(70..400);
        scenario.robots[0].events.push(Planned::at_contact(at, crate::name("left"), whisker as u16, change));
    }
    scenario
}

fn any_action(random: &mut ChaCha8Rng, world: &World) -> OperatorAction<'static> {
    let place = at(random.random_range(0..world.core.whisker_count() as u16 + 1));
    let scope = if random.random_bool(0.2) { Scope::Robot } else { Scope::Whisker(place) };
    let numbers: Vec<u32> = world.core.compensations().iter().map(|one| one.id()).collect();
    let compensation = numbers.choose(random).copied().unwrap_or(7);
    match random.random_range(0..20) {
        0..=6 => OperatorAction::Approve { compensation },
        7 | 8 => OperatorAction::Refuse { compensation },
        9 | 10 => OperatorAction::Setpoint { whisker: place, pressure_mpa: random.random_range(-0.01..0.25) },
        11 | 12 => OperatorAction::Hold(scope),
        13..=17 => OperatorAction::Release(scope),
        18 => OperatorAction::Replaced(place),
        _ => OperatorAction::Rebaseline(place),
    }
}

/// Rules for the effects, checked from the outside.
#[derive(Default)]
struct Watch {
    seen: usize,
    robot_held: bool,
    held: BTreeSet<usize>,
    /// Proposed, and neither approved nor over.
    waiting: BTreeSet<u32>,
    standing: BTreeSet<(usize, String)>,
    counts: BTreeMap<&'static str, usize>,
}

impl Watch {
    fn count(&mut self, what: &'static str) {
        *self.counts.entry(what).or_default() += 1;
    }

    /// Takes an accepted action, before its effects are checked.
    fn done(&mut self, action: &OperatorAction<'_>) {
        match *action {
            OperatorAction::Setpoint { whisker: place, .. } | OperatorAction::Hold(Scope::Whisker(place)) => {
                self.held.insert(usize::from(place.whisker));
            }
            OperatorAction::Hold(Scope::Robot) => self.robot_held = true,
            OperatorAction::Release(Scope::Robot) => self.robot_held = false,
            OperatorAction::Release(Scope::Whisker(place)) => {
                assert!(!self.robot_held, "a whisker of a held robot is not released");
                self.held.remove(&usize::from(place.whisker));
            }
            OperatorAction::Approve { .. }
            | OperatorAction::Refuse { .. }
            | OperatorAction::TouchTest(_)
            | OperatorAction::RefuseTouchTest(_)
            | OperatorAction::Retry(_)
            | OperatorAction::Replaced(_)
            | OperatorAction::Rebaseline(_) => {}
        }
    }

    fn look(&mut self, world: &World, mode: Mode, context: &str) {
        for (_, effect) in &world.effects[self.seen..] {
            match effect {
                Effect::Command(command) => self.check_command(command, context),
                Effect::Resend(command) => {
                    let held = self.robot_held || self.held.contains(&command.whisker);
                    assert!(!held || command.reason == Reason::Operator, "{context}: again to a held one: {command:?}");
                }
                Effect::Decided(decision) => {
                    assert_eq!(decision.proposed, decision.chosen.is_some() && mode == Mode::Advise, "{context}");
                    if decision.proposed {
                        self.waiting.insert(decision.compensation);
                    }
                }
                Effect::Approved { compensation } => {
                    assert!(self.waiting.remove(compensation), "{context}: {compensation} was not proposed");
                    self.count("approved");
                }
                Effect::Ended { compensation, .. } => drop(self.waiting.remove(compensation)),
                Effect::Alarm { whisker, kind } => {
                    assert!(
                        self.standing.insert((*whisker, format!("{kind:?}"))),
                        "{context}: {kind:?} stands already"
                    );
                    self.count("raised");
                }
                Effect::AlarmCleared { whisker, kind } => {
                    assert!(
                        self.standing.remove(&(*whisker, format!("{kind:?}"))),
                        "{context}: {kind:?} did not stand"
                    );
                    self.count("cleared");
                }
                _ => {}
            }
        }
        self.seen = world.effects.len();
        for index in 0..world.core.whisker_count() {
            let reported: BTreeSet<String> =
                self.standing.iter().filter(|one| one.0 == index).map(|one| one.1.clone()).collect();
            let known: BTreeSet<String> = standing(world, index).iter().map(|kind| format!("{kind:?}")).collect();
            assert_eq!(reported, known, "{context}: whisker {index}");
        }
    }

    fn check_command(&mut self, command: &Command, context: &str) {
        let held = self.robot_held || self.held.contains(&command.whisker);
        assert!(!held || command.reason == Reason::Operator, "{context}: to a held one: {command:?}");
        assert!(held || command.reason != Reason::Operator, "{context}: a manual setpoint holds: {command:?}");
        if let Some(id) = command.compensation {
            assert!(!self.waiting.contains(&id), "{context}: not approved: {command:?}");
        }
        self.count(match command.reason {
            Reason::Compensation(_) => "compensations",
            Reason::Release => "releases",
            Reason::Refinement => "refinements",
            Reason::Operator => "manual",
        });
    }
}

#[test]
fn brute_force_whatever_operators_do_holds_approvals_and_alarms_are_kept() {
    let mut counts: BTreeMap<&'static str, usize> = BTreeMap::new();
    for seed in 0..200 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let scenario = any_scenario(&mut random, seed);
        let mut mode = if random.random_bool(0.7) { Mode::Advise } else { Mode::Automatic };
        let mut world = World::new(&scenario, params(mode));
        world.params.refinement.first_look_contacts = 60;
        let mut watch = Watch::default();
        let mut now_s = random.random_range(0.0..3.0);
        while now_s < 14.0 {
            world.run_until_s(now_s);
            watch.look(&world, mode, &format!("seed {seed} at {now_s} s"));
            if random.random_bool(0.05) {
                mode = if mode == Mode::Advise { Mode::Automatic } else { Mode::Advise };
                world.params.policy.mode = mode;
                world.step(&Event::PolicyChanged);
            } else {
                let action = any_action(&mut random, &world);
                let before = world.core.clone();
                match ask(&mut world, action) {
                    Outcome::Taken => {
                        watch.done(&action);
                        watch.count("done");
                    }
                    Outcome::Refused(_) => {
                        assert_eq!(world.core, before, "seed {seed}: refused, and something has changed: {action:?}");
                        watch.count("refused");
                    }
                    other => panic!("{other:?}"),
                }
                watch.look(&world, mode, &format!("seed {seed} at {now_s} s after {action:?}"));
            }
            now_s += random.random_range(0.05..1.0);
        }
        for (what, count) in watch.counts {
            *counts.entry(what).or_default() += count;
        }
    }
    let least = [("done", 1000), ("refused", 500), ("approved", 50), ("manual", 100), ("releases", 50)];
    let more = [("compensations", 80), ("refinements", 20), ("raised", 200), ("cleared", 80)];
    for (what, least) in least.into_iter().chain(more) {
        assert!(counts.get(what).is_some_and(|&count| count >= least), "{what}: {counts:?}");
    }
}

/// Alarms and the other effects, without those that only a proposal has. An approval comes after the step that decided, and
/// the alarms of that step come before it: their order among the other effects is no difference.
fn without_proposals(world: &World) -> (Vec<Effect>, Vec<Effect>) {
    let mut effects: Vec<Effect> = world.effects.iter().map(|(_, effect)| effect.clone()).collect();
    effects.retain(|effect| {
        let proposed = matches!(
            effect,
            Effect::Alarm { kind: AlarmKind::Proposed, .. } | Effect::AlarmCleared { kind: AlarmKind::Proposed, .. }
        );
        !proposed && !matches!(effect, Effect::Approved { .. })
    });
    for effect in &mut effects {
        if let Effect::Decided(decision) = effect {
            decision.proposed = false;
        }
    }
    effects.into_iter().partition(|effect| matches!(effect, Effect::Alarm { .. } | Effect::AlarmCleared { .. }))
}

#[test]
fn property_approved_at_once_everything_goes_as_if_nobody_had_been_asked() {
    let (mut compared, mut refined) = (0, 0);
    for seed in 0..60 {
        let scenario = any_scenario(&mut ChaCha8Rng::seed_from_u64(1000 + seed), seed);
        let [automatic, advise] = [Mode::Automatic, Mode::Advise].map(|mode| {
            let mut world = World::new(&scenario, params(mode));
            world.approves_at_once = true;
            world.run_until_s(14.0);
            world
        });
        // A whisker that is released and taken again in one decision is released first if an approval comes in between.
        if !ended(&automatic).is_empty() {
            continue;
        }
        let setpoints = commands(&automatic);
        assert_eq!(without_proposals(&automatic), without_proposals(&advise), "seed {seed}");
        compared += usize::from(!setpoints.is_empty());
        refined += setpoints.iter().filter(|command| command.reason == Reason::Refinement).count();
    }
    assert!(compared >= 20 && refined >= 5, "{compared} compared, {refined} refinements");
}

#[test]
fn property_what_if_does_not_hang_on_the_mode() {
    let world = cut_world(Mode::Automatic, &[70.0, 66.0, 71.0, 65.0], &[]);
    let advise = params(Mode::Advise);
    for index in 0..4 {
        for length_mm in [48.0, 55.0, 60.0, 63.0] {
            let length = Millimetre::known(length_mm);
            let automatic = world.core.what_if(&world.params, index, length).expect("shorter");
            assert_eq!(automatic, world.core.what_if(&advise, index, length).expect("shorter"));
            assert!(!automatic.decisions.is_empty());
        }
    }
}
