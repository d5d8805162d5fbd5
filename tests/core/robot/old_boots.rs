//! A boot that others have followed stays old.

use vibrissa_core::robot::Outcome;

use crate::by_hand::ByHand;

const PLAIN: (f64, f64, f64) = (0.85, 2.4, 0.0117);

#[test]
fn a_boot_that_others_have_followed_is_not_taken_again_however_many_there_were() {
    for newer in 1..=20 {
        let mut one = ByHand::born(70.0);
        one.touched(&[(PLAIN, 0); 3]);
        for boot in 0..newer {
            assert_eq!(one.boots(&format!("newer-{boot}"), 70.0), [Outcome::Taken; 2]);
        }
        let contacts = one.robot.whisker(0).unwrap().contacts;
        assert_eq!(one.boots("b1", 70.0), [Outcome::OldBoot; 2], "after {newer}");
        assert_eq!(one.robot.connection_state().0, Some(format!("newer-{}", newer - 1).as_str()));
        // Said by the newest, so that it is taken.
        assert_eq!(one.touched(&[(PLAIN, 0)]), Outcome::Taken);
        assert_eq!(one.robot.whisker(0).unwrap().contacts, contacts + 1);
    }
}

#[test]
fn a_boot_that_connects_again_is_still_the_newest() {
    let mut one = ByHand::born(70.0);
    assert_eq!(one.boots("b2", 70.0), [Outcome::Taken; 2]);
    for _ in 0..5 {
        // The factsheet says nothing new.
        assert_eq!(one.boots("b2", 70.0), [Outcome::Taken, Outcome::Duplicate]);
    }
    assert_eq!(one.touched(&[(PLAIN, 0)]), Outcome::Taken);
}
