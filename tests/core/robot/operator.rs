//! Operators' actions and their consequences, in worlds whose truth is known.

use std::collections::{BTreeMap, BTreeSet};

use rand::seq::IndexedRandom;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use vibrissa_core::mechanics::Formulation;
use vibrissa_core::policy::{Mode, Refused};
use vibrissa_core::robot::effect::{AlarmKind, Command, Condition, Decision, Effect, EndReason, Reason};
use vibrissa_core::robot::event::Link;
use vibrissa_core::robot::{ActionProblem, Event, OperatorAction, Outcome, Params, Place, Scope};
use vibrissa_core::units::{Megapascal, Millimetre};
use vibrissa_evaluation::World;
use vibrissa_protocol::ArrayType;
use vibrissa_simulator::Scenario;
use vibrissa_simulator::scenario::{Change, Event as Planned};

fn at(whisker: u16) -> Place<'static> {
    Place { array: "left", whisker }
}

fn ask(world: &mut World, action: OperatorAction<'_>) -> Outcome {
    world.step(&Event::Operator(&action))
}

fn params(mode: Mode) -> Params {
    let mut params = Params::nguyen_2021(Formulation::Published);
    params.detection.cold_start_contacts = 60;
    params.policy.mode = mode;
    params
}

/// Whiskers of these lengths, cut at the 100th contact.
fn cut_world(mode: Mode, lengths_mm: &[f64], cuts: &[(u16, f64)]) -> World {
    let mut scenario = super::scenario(71, ArrayType::Type1, lengths_mm);
    for &(whisker, length_mm) in cuts {
        let change = Change::Trim { length_mm };
        scenario.robots[0].events.push(Planned::at_contact(100, super::name("left"), whisker, change));
    }
    let mut world = World::new(&scenario, params(mode));
    world.run_until_s(10.0);
    world
}

fn commands(world: &World) -> Vec<Command> {
    world.picked(|effect| if let Effect::Command(command) = effect { Some((**command).clone()) } else { None })
}

fn decisions(world: &World) -> Vec<Decision> {
    world.picked(|effect| if let Effect::Decided(decision) = effect { Some((**decision).clone()) } else { None })
}

fn ended(world: &World) -> Vec<EndReason> {
    world.picked(|effect| if let Effect::Ended { reason, .. } = effect { Some(*reason) } else { None })
}

/// The alarms that stand for a whisker.
fn standing(world: &World, index: usize) -> Vec<AlarmKind> {
    world.core.whisker(index).expect("there").standing.kinds().collect()
}

/// The only compensation that waits for approval: its number and compensator.
fn proposal(world: &World) -> (u32, usize) {
    let waiting: Vec<_> = world.core.compensations().iter().filter(|one| one.is_proposed()).collect();
    assert_eq!(waiting.len(), 1, "{waiting:?}");
    (waiting[0].id(), waiting[0].compensator())
}

fn any_scenario(random: &mut ChaCha8Rng, seed: u64) -> Scenario {
    let count = random.random_range(2..=6);
    let lengths_mm: Vec<f64> = (0..count).map(|_| random.random_range(62.0..72.0)).collect();
    let array_type = if random.random_bool(0.8) { ArrayType::Type1 } else { ArrayType::Type2 };
    let mut scenario = super::scenario(seed, array_type, &lengths_mm);
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
        scenario.robots[0].events.push(Planned::at_contact(at, super::name("left"), whisker as u16, change));
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
            | OperatorAction::Replaced(_)
            | OperatorAction::Rebaseline(_) => {}
        }
    }

    fn look(&mut self, world: &World, mode: Mode, context: &str) {
        for (_, effect) in &world.effects[self.seen..] {
            match effect {
                Effect::Command(command) => self.told(command, context),
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
            let told: BTreeSet<String> =
                self.standing.iter().filter(|one| one.0 == index).map(|one| one.1.clone()).collect();
            let known: BTreeSet<String> = standing(world, index).iter().map(|kind| format!("{kind:?}")).collect();
            assert_eq!(told, known, "{context}: whisker {index}");
        }
    }

    fn told(&mut self, command: &Command, context: &str) {
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

/// The effects, without those that only a proposal has.
fn without_proposals(world: &World) -> Vec<Effect> {
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
    effects
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

#[test]
fn a_proposal_waits_and_is_carried_out_once_it_is_approved() {
    let mut world = cut_world(Mode::Advise, &[70.0, 66.0], &[(0, 54.0)]);
    let (id, compensator) = proposal(&world);
    assert_eq!(compensator, 1);
    assert_eq!(commands(&world), [], "nothing is sent");
    assert_eq!(standing(&world, 0), [AlarmKind::Proposed]);
    // No approval is needed any more, but one was requested before.
    world.params.policy.mode = Mode::Automatic;
    world.step(&Event::PolicyChanged);
    world.run_until_s(12.0);
    assert_eq!((proposal(&world), commands(&world)), ((id, 1), Vec::new()));
    assert_eq!(ask(&mut world, OperatorAction::Approve { compensation: id }), Outcome::Taken);
    let sent = commands(&world);
    assert_eq!(sent.iter().map(|one| (one.whisker, one.compensation)).collect::<Vec<_>>(), [(1, Some(id))]);
    assert_eq!(standing(&world, 0), []);
    let again = ask(&mut world, OperatorAction::Approve { compensation: id });
    assert_eq!(again, Outcome::Refused(ActionProblem::NotProposed));
    let refused = ask(&mut world, OperatorAction::Refuse { compensation: id });
    assert_eq!(refused, Outcome::Refused(ActionProblem::NotProposed), "it runs");
    world.run_until_s(17.0);
    assert_eq!(world.core.whisker(1).unwrap().setpoint, sent[0].pressure);
}

#[test]
fn refused_the_next_best_is_proposed_and_then_none() {
    let mut world = cut_world(Mode::Advise, &[66.0, 70.0, 65.0], &[(1, 54.0)]);
    let (first, one) = proposal(&world);
    assert_eq!(ask(&mut world, OperatorAction::Refuse { compensation: first }), Outcome::Taken);
    let (second, other) = proposal(&world);
    assert_ne!(one, other);
    let decision = decisions(&world).pop().unwrap();
    let refused = decision.candidates.iter().find(|candidate| candidate.whisker == one).unwrap();
    assert_eq!(refused.refused, Some(Refused::Operator));
    assert_eq!(ask(&mut world, OperatorAction::Refuse { compensation: second }), Outcome::Taken);
    assert_eq!(world.core.compensations(), []);
    assert_eq!(standing(&world, 1), [AlarmKind::Uncompensated]);
    assert_eq!(ended(&world), [EndReason::Refused, EndReason::Refused]);
    world.run_until_s(12.0);
    assert_eq!((world.core.compensations(), commands(&world)), (&[][..], Vec::new()), "nothing by itself");
    // Another policy: the same may be proposed again.
    world.step(&Event::PolicyChanged);
    assert_eq!(proposal(&world).1, one);
    assert_eq!(standing(&world, 1), [AlarmKind::Proposed]);
}

#[test]
fn refused_a_compensator_is_proposed_again_for_a_target_that_is_trimmed_again() {
    let mut scenario = super::scenario(72, ArrayType::Type2, &[70.0]);
    for (contact, length_mm) in [(100, 66.0), (500, 62.0)] {
        let change = Change::Trim { length_mm };
        scenario.robots[0].events.push(Planned::at_contact(contact, super::name("left"), 0, change));
    }
    let mut world = World::new(&scenario, params(Mode::Advise));
    world.run_until_s(9.0);
    let (id, _) = proposal(&world);
    ask(&mut world, OperatorAction::Refuse { compensation: id });
    assert_eq!(standing(&world, 0), [AlarmKind::Uncompensated]);
    world.run_until_s(20.0);
    assert!(proposal(&world).0 > id);
    assert_eq!(standing(&world, 0), [AlarmKind::Proposed]);
}

#[test]
fn a_manual_setpoint_ends_what_it_serves_in_and_holds_until_released() {
    let mut world = cut_world(Mode::Automatic, &[70.0, 66.0], &[(0, 54.0)]);
    let nominal = world.core.whisker(1).unwrap().sheet.pressure;
    let set = |pressure_mpa| OperatorAction::Setpoint { whisker: at(1), pressure_mpa };
    for pressure_mpa in [-0.001, 0.2001, f64::NAN, f64::INFINITY] {
        let refused = ask(&mut world, set(pressure_mpa));
        let Outcome::Refused(problem @ ActionProblem::PressureOutOfRange { .. }) = refused else {
            panic!("{pressure_mpa}: {refused:?}")
        };
        assert!(problem.to_string().contains("0 to 0.2 MPa"), "{problem}");
    }
    assert_eq!(ended(&world), []);
    world.effects.clear();
    assert_eq!(ask(&mut world, set(0.05)), Outcome::Taken);
    assert_eq!(ended(&world), [EndReason::Operator]);
    let sent: Vec<_> = commands(&world).iter().map(|one| (one.whisker, one.pressure.mpa(), one.reason)).collect();
    assert_eq!(sent, [(1, 0.05, Reason::Operator)]);
    assert!(world.core.whisker(1).unwrap().held);
    world.run_until_s(20.0);
    let mut expected = Megapascal::known(0.05);
    assert_eq!((world.core.whisker(1).unwrap().setpoint, commands(&world).len()), (expected, 1));
    assert_eq!(standing(&world, 0), [AlarmKind::Uncompensated], "nobody else can serve it");
    assert_eq!(ask(&mut world, OperatorAction::Release(Scope::Whisker(at(1)))), Outcome::Taken);
    expected = commands(&world)[1].pressure;
    assert_ne!(expected, nominal, "it serves again at once");
    assert_eq!(commands(&world)[1].reason, Reason::Compensation(vibrissa_core::policy::Case::ShorterForLonger));
    assert_eq!(standing(&world, 0), []);
}

#[test]
fn a_manual_setpoint_is_neither_taken_while_offline_nor_sent_after_a_restart() {
    let mut world = cut_world(Mode::Automatic, &[70.0, 66.0], &[]);
    let boot_id = world.core.connection_state().0.unwrap().to_owned();
    let set = OperatorAction::Setpoint { whisker: at(1), pressure_mpa: 0.12 };
    world.step(&Event::Connection { boot_id: &boot_id, link: Link::Broken });
    assert_eq!(ask(&mut world, set), Outcome::Refused(ActionProblem::RobotOffline));
    assert_eq!(standing(&world, 1).len(), 1, "stale");
    world.step(&Event::Connection { boot_id: &boot_id, link: Link::Online });
    // Straight to the core: it is on its way, and no answer comes.
    let now = world.core.whisker(1).unwrap().heard.unwrap();
    let mut effects = Vec::new();
    world.core.step(&world.params, now, &Event::Operator(&set), &mut effects);
    assert!(effects.iter().any(|effect| matches!(effect, Effect::Command(_))), "{effects:?}");
    world.effects.clear();
    world.step(&Event::Connection { boot_id: &boot_id, link: Link::Offline });
    world.step(&Event::Connection { boot_id: "another", link: Link::Online });
    for _ in 0..3 {
        world.silent_for_s(15.0);
    }
    assert_eq!(commands(&world), []);
    assert!(world.core.whisker(1).unwrap().held, "the hold stays");
}

#[test]
fn a_held_whisker_goes_on_serving_and_being_measured_and_is_refined_once_released() {
    let mut world = cut_world(Mode::Automatic, &[70.0, 66.0], &[(0, 54.0)]);
    world.run_until_s(14.0);
    ask(&mut world, OperatorAction::Hold(Scope::Robot));
    let one = ask(&mut world, OperatorAction::Release(Scope::Whisker(at(1))));
    assert_eq!(one, Outcome::Refused(ActionProblem::RobotHeld));
    world.effects.clear();
    world.run_until_s(60.0);
    let measured = world.picked(|effect| matches!(effect, Effect::Error(_)).then_some(())).len();
    assert!(measured >= 5, "{measured}");
    assert_eq!((commands(&world), ended(&world)), (Vec::new(), Vec::new()));
    assert!(world.picked(|effect| matches!(effect, Effect::Refined(_)).then_some(())).is_empty());
    ask(&mut world, OperatorAction::Release(Scope::Robot));
    world.run_until_s(61.0);
    assert_eq!(world.picked(|effect| matches!(effect, Effect::Refined(_)).then_some(())).len(), 1);
}

#[test]
fn a_held_target_is_decided_on_when_it_is_released() {
    let mut scenario = super::scenario(73, ArrayType::Type1, &[70.0, 66.0]);
    let change = Change::Trim { length_mm: 54.0 };
    scenario.robots[0].events.push(Planned::at_contact(100, super::name("left"), 0, change));
    let mut world = World::new(&scenario, params(Mode::Automatic));
    world.run_until_s(1.0);
    ask(&mut world, OperatorAction::Hold(Scope::Whisker(at(0))));
    world.run_until_s(10.0);
    assert_eq!(world.core.whisker(0).unwrap().condition, Condition::Trimmed, "detection goes on");
    assert_eq!((decisions(&world), commands(&world)), (Vec::new(), Vec::new()));
    ask(&mut world, OperatorAction::Release(Scope::Whisker(at(0))));
    assert_eq!(decisions(&world).len(), 1);
    assert_eq!(commands(&world).len(), 1);
}

/// A whisker whose gauge reads differently from the 150th contact on, for which a person says so or not.
fn glued_anew(told: bool) -> World {
    let mut scenario = super::scenario(74, ArrayType::Type2, &[70.0]);
    let change = Change::Temperature { sensitivity_factor: 1.25, temperature_c: 20.0 };
    let mut glued = Planned::at_contact(150, super::name("left"), 0, change);
    (glued.at_s, glued.at_contact, glued.whisker) = (Some(3.0), None, None);
    scenario.robots[0].events.push(glued);
    let mut world = World::new(&scenario, params(Mode::Automatic));
    world.run_until_s(3.0);
    if told {
        ask(&mut world, OperatorAction::Rebaseline(at(0)));
        assert_eq!(world.core.whisker(0).unwrap().condition, Condition::Learning);
    }
    world.run_until_s(20.0);
    world
}

#[test]
fn a_gauge_that_was_glued_anew_is_no_cut_where_a_person_says_so() {
    let trims = |world: &World| world.picked(|effect| matches!(effect, Effect::Trim(_)).then_some(())).len();
    assert_eq!(trims(&glued_anew(false)), 1, "it looks like one");
    let world = glued_anew(true);
    let view = world.core.whisker(0).unwrap();
    assert_eq!((trims(&world), view.condition), (0, Condition::Healthy));
    assert!((view.length.length.mm() - 70.0).abs() < 0.3, "{:?}", view.length);
    assert!((view.offset.level - 1.25_f64.ln()).abs() < 0.06, "{:?}", view.offset);
}

#[test]
fn a_trimmed_whisker_that_is_learned_anew_stays_trimmed_and_served() {
    let mut world = cut_world(Mode::Automatic, &[70.0, 66.0], &[(0, 54.0)]);
    let before = (world.core.whisker(0).unwrap().length, world.core.compensations()[0].id());
    world.effects.clear();
    for whisker in [0, 1] {
        assert_eq!(ask(&mut world, OperatorAction::Rebaseline(at(whisker))), Outcome::Taken);
    }
    let views = [0, 1].map(|index| world.core.whisker(index).unwrap());
    assert_eq!(views.map(|view| view.condition), [Condition::Trimmed, Condition::Learning]);
    assert_eq!((views[0].length, world.core.compensations()[0].id()), before);
    world.run_until_s(40.0);
    assert_eq!(ended(&world), []);
    assert_eq!(world.core.whisker(1).unwrap().condition, Condition::Healthy);
    assert!(!world.picked(|effect| matches!(effect, Effect::Error(_)).then_some(())).is_empty(), "measured again");
    assert!((world.core.whisker(0).unwrap().length.length.mm() - 54.0).abs() < 1.5);
}
