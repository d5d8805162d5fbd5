//! Numbers that are within their units' ranges, and far from anything that a whisker does: nothing that is learned
//! becomes infinite or no number.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use vibrissa_core::robot::effect::{ContactUse, Effect};

use crate::by_hand::ByHand;

/// Each alone made the length of a whisker of 69.3 mm no number, in this order.
const POISON: [(f64, f64, f64); 3] = [(5e-324, 1e-9, -0.0117), (0.85, 1000.0, 5e-324), (0.45, 999.999, 1.0)];
const PLAIN: (f64, f64, f64) = (0.85, 2.4, 0.0117);

/// Everything that is known of the robot, and all that came of it, is finite.
fn assert_finite(one: &ByHand, what: &str) {
    let view = one.robot.whisker(0).unwrap();
    let numbers = [view.length.length.mm(), view.length.sd_mm];
    assert!(numbers.iter().all(|number| number.is_finite()), "{what}: {numbers:?}");
    let text = format!("{:?}", one.robot);
    let odd = ["NaN", "inf,", "inf]", "inf}", "inf)", "inf "].iter().find_map(|odd| text.find(odd));
    assert!(odd.is_none(), "{what}: {}", &text[odd.unwrap_or(0).saturating_sub(200)..][..300]);
    for effect in &one.effects {
        if let Effect::Contact(contact) = effect {
            let numbers = [contact.residual, contact.standardised, Some(contact.length.sd_mm)];
            assert!(numbers.iter().flatten().all(|number| number.is_finite()), "{what}: {contact:?}");
        }
    }
}

#[test]
fn regress_three_contacts_within_the_ranges_leave_the_length_a_number() {
    for learned in [0, 30, 200] {
        let mut one = ByHand::born(69.3);
        for _ in 0..learned {
            one.passes_s(0.1);
            one.touched(&[(PLAIN, 0)]);
        }
        for (at, poison) in POISON.iter().enumerate() {
            one.passes_s(0.1);
            one.touched(&[(*poison, 0)]);
            assert_finite(&one, &format!("{learned} contacts, then up to {at}"));
        }
        let length_mm = one.robot.whisker(0).unwrap().length.length.mm();
        assert!((length_mm - 69.3).abs() < 1.0, "{length_mm}");
    }
}

/// A gauge whose wires are exchanged answers every touch with the opposite sign.
#[test]
fn regress_negative_strains_are_called_negative_and_not_weak() {
    for learned in [0, 200] {
        let mut one = ByHand::born(69.3);
        for _ in 0..learned {
            one.passes_s(0.1);
            one.touched(&[(PLAIN, 0)]);
        }
        one.effects.clear();
        for strain in [-PLAIN.2, -2.0 * PLAIN.2] {
            one.passes_s(0.1);
            one.touched(&[((PLAIN.0, PLAIN.1, strain), 0)]);
        }
        let uses: Vec<ContactUse> = (one.effects.iter())
            .filter_map(|effect| if let Effect::Contact(contact) = effect { Some(contact.used) } else { None })
            .collect();
        assert_eq!(uses, [ContactUse::NegativeStrain; 2], "after {learned} contacts");
    }
}

/// Where the converter ends, the strain says only that it would have been larger.
#[test]
fn contacts_beyond_the_range_of_the_gauge_have_a_use_of_their_own_and_change_nothing() {
    let mut one = ByHand::born(69.3);
    for _ in 0..200 {
        one.passes_s(0.1);
        one.touched(&[(PLAIN, 0)]);
    }
    let known = |one: &ByHand| one.robot.whisker(0).map(|view| (view.length, view.condition));
    let before = known(&one);
    one.effects.clear();
    one.saturated = true;
    for _ in 0..50 {
        one.passes_s(0.1);
        one.touched(&[((PLAIN.0, 3.0 * PLAIN.1, PLAIN.2), 0)]);
    }
    let of_contact = |effect: &Effect| if let Effect::Contact(contact) = effect { Some(contact.used) } else { None };
    let uses: Vec<Option<ContactUse>> = one.effects.iter().map(of_contact).collect();
    assert_eq!(uses, [Some(ContactUse::Saturated); 50], "and no fault, trim or alarm");
    assert_eq!(known(&one), before);
}

fn extreme(random: &mut ChaCha8Rng, most: f64) -> f64 {
    match random.random_range(0..8) {
        0 => f64::from_bits(1),
        1 => f64::MIN_POSITIVE,
        2 => most,
        3 => most * (1.0 - f64::EPSILON),
        4 => 1e-9,
        5 => 10_f64.powf(random.random_range(-320.0..0.0)) * most,
        _ => random.random_range(0.0..1.0) * most,
    }
}

#[test]
fn property_no_sequence_of_extreme_contacts_makes_anything_infinite() {
    for seed in 0..60 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut one = ByHand::born([69.3, 70.0, 1.0, 1000.0, 40.0][seed as usize % 5]);
        let plain_share = f64::from(seed as u32 % 3) * 0.45;
        for _ in 0..600 {
            one.passes_s(0.2);
            let contact = if random.random_bool(plain_share) {
                let noise = random.random_range(0.9..1.1);
                (PLAIN.0, PLAIN.1, PLAIN.2 * noise)
            } else {
                let sign = if random.random_bool(0.2) { -1.0 } else { 1.0 };
                let ratio = extreme(&mut random, 1.0).max(f64::from_bits(1));
                (ratio, extreme(&mut random, 1000.0), sign * extreme(&mut random, 1.0))
            };
            one.touched(&[(contact, 0)]);
        }
        assert_finite(&one, &format!("seed {seed}"));
    }
}
