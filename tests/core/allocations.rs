//! Ordinary events allocate no memory. A separate test target, because it replaces the allocator by a counting one.

use allocation_counter::measure;
use vibrissa_evaluation::crowd::{Buffers, Crowd};

/// A robot with learned baselines, and buffers for reuse.
fn learned() -> (Crowd, Buffers) {
    let (mut crowd, mut buffers) = (Crowd::new(1, 24), Buffers::default());
    crowd.learn(400, &|| ());
    crowd.contacts(0, 20, &mut buffers);
    crowd.status(0, &mut buffers);
    (crowd, buffers)
}

/// Steps with further effects, such as an alarm, may allocate.
#[test]
fn property_an_ordinary_contact_allocates_nothing() {
    let (mut crowd, mut buffers) = learned();
    for contacts in [1, 20] {
        for step in 0..1000 {
            let allocated = measure(|| {
                crowd.contacts(0, contacts, &mut buffers);
            });
            let is_ordinary = buffers.effects.len() == contacts;
            assert!(!is_ordinary || allocated.count_total == 0, "step {step} of {contacts}: {allocated:?}");
        }
    }
}

#[test]
fn property_an_ordinary_status_and_a_tick_allocate_nothing() {
    let (mut crowd, mut buffers) = learned();
    for step in 0..1000 {
        let allocated = measure(|| {
            crowd.status(0, &mut buffers);
            crowd.tick(0, &mut buffers);
        });
        assert!(!buffers.effects.is_empty() || allocated.count_total == 0, "step {step}: {allocated:?}");
    }
}

/// Checks the counter itself: creating a robot allocates.
#[test]
fn a_new_robot_allocates() {
    assert!(measure(|| drop(Crowd::new(1, 24))).count_total > 20);
}
