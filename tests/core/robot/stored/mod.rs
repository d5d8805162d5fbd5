//! The stored parts of a robot are complete: every change of them is marked, and a restored robot goes on alike.
//!
//! The robots of these tests live through every kind of event that [`kinds`] lists. The list is closed: a new variant
//! of an event, an action or a report does not compile before it is listed, and a listed one must be played.

mod fixtures;
mod kinds;
mod life;
mod plant;
mod rare;
mod version_4;

use std::collections::BTreeMap;

use vibrissa_core::robot::Robot;
use vibrissa_core::robot::effect::Effect;

use kinds::{EFFECTS, KINDS, effect_of};
use life::{Life, Store};
use plant::Said;

const ARRAY: &str = "left";
const WHISKERS: u16 = 4;
/// A boot that others have followed does not come back.
const BOOTS: [&str; 16] =
    ["b0", "b1", "b2", "b3", "b4", "b5", "b6", "b7", "b8", "b9", "b10", "b11", "b12", "b13", "b14", "b15"];
const YEAR_US: u64 = 365 * 86_400 * 1_000_000;

/// Splits the file into parts, each after its length in four bytes.
fn parts_of(mut bytes: &[u8]) -> Vec<Vec<u8>> {
    let mut parts = Vec::new();
    while let Some((length, rest)) = bytes.split_first_chunk() {
        let (part, rest) = rest.split_at(u32::from_le_bytes(*length) as usize);
        parts.push(part.to_vec());
        bytes = rest;
    }
    parts
}

/// Lives in which whiskers are cut and served, gauges fail, messages are missed and come again, robots start anew,
/// operators act and policies change.
#[test]
fn property_every_change_is_marked_and_what_was_stored_goes_on_as_it_did() {
    let (mut kinds, mut effects, mut written) = (BTreeMap::new(), BTreeMap::new(), [0; 2]);
    for seed in 0..16 {
        let life = Life::new(seed, 2500);
        life.kinds.iter().for_each(|(kind, count)| *kinds.entry(*kind).or_insert(0) += count);
        life.steps
            .iter()
            .flat_map(|step| &step.effects)
            .for_each(|one| *effects.entry(effect_of(one)).or_insert(0) += 1);
        written = [written[0] + life.written[0], written[1] + life.written[1]];
        for from in [1, 200 + 37 * seed as usize, 2200] {
            life.again_from(from);
        }
    }
    for kind in KINDS {
        assert!(kinds.contains_key(kind), "no life has an event {kind:?} that is taken: {kinds:?}");
    }
    for effect in EFFECTS.iter().filter(|effect| **effect != effect_of(&Effect::AskForFactsheet)) {
        assert!(effects.contains_key(effect), "no life has an effect {effect:?}: {effects:?}");
    }
    let [all, unchanged] = written;
    assert!(50 * unchanged < all, "{unchanged} of {all} parts were written although they had not changed");
}

/// A robot that evaluates its whiskers only when a deadline has passed has the same effects as a restored one, which
/// evaluates all of them at its first tick.
#[test]
fn property_a_tick_with_nothing_to_do_says_what_a_full_look_says() {
    for seed in 100..106 {
        let life = Life::new(seed, 600);
        for at in (1..life.events.len()).filter(|&at| matches!(life.events[at].2, Said::Tick)) {
            let Store { head, whiskers } = &life.stored[at - 1];
            let mut robot = Robot::restore(head, whiskers).unwrap();
            assert_eq!(life.play(&mut robot, at), life.steps[at], "seed {seed}, event {at}");
        }
    }
}
