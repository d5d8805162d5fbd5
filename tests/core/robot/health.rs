//! Everything by its name, and nothing else a trim: a small version of `vibrissa-lab evaluate health`.

use vibrissa_evaluation::health::{Class, Plan, evaluate};

const SEED: u64 = 1;

/// At least 98 of 100 cases of each of these are called by their name alone.
const RIGHT_AT_LEAST: f64 = 0.98;

/// Classes in which every result must be right; other tests check the others.
const CLASSES: [Class; 8] = [
    Class::Healthy,
    Class::BaselineDrift,
    Class::Erosion,
    Class::Leak,
    Class::GaugeOpen,
    Class::GaugeShort,
    Class::GaugeSaturated,
    Class::Silent,
];

fn assert_right(class: Class, cases: u32) {
    assert!(CLASSES.contains(&class));
    assert_mostly_right(class, cases, RIGHT_AT_LEAST, 0);
}

fn assert_mostly_right(class: Class, cases: u32, right_at_least: f64, wrong_trims_most: u32) {
    let report = evaluate(&Plan { seed: SEED, cases, classes: vec![class] }, || {});
    let wrong: Vec<_> = report.outcomes.iter().filter(|outcome| !outcome.is_right()).collect();
    assert!(report.right() >= right_at_least, "{:.3}: {wrong:#?}", report.right());
    assert!(report.wrong_trims() <= wrong_trims_most, "{wrong:#?}");
}

#[test]
fn property_whiskers_to_which_nothing_happens_are_called_nothing() {
    assert_right(Class::Healthy, 30);
}

/// A cut of one millimetre under twice the noise may take longer than the case lasts.
#[test]
fn property_cuts_are_called_trims() {
    assert_mostly_right(Class::Trim, 60, 0.95, 0);
}

#[test]
fn property_erosion_is_called_erosion_and_nothing_else() {
    assert_right(Class::Erosion, 60);
}

#[test]
fn property_drifting_baselines_are_called_so_and_are_no_cuts() {
    assert_right(Class::BaselineDrift, 60);
}

/// Right means that every whisker of the array is called nothing else: a warming room is seen by one of them first. In 300
/// cases four of 1,800 whiskers were called trimmed.
#[test]
fn property_what_the_whole_array_feels_is_called_its_shift() {
    assert_mostly_right(Class::ArrayShift, 60, 0.93, 2);
}

#[test]
fn property_leaks_that_the_robot_does_not_notice_are_called_leaks() {
    assert_right(Class::Leak, 40);
}

#[test]
fn property_open_gauges_are_called_open() {
    assert_right(Class::GaugeOpen, 60);
}

#[test]
fn property_shorted_gauges_are_called_short() {
    assert_right(Class::GaugeShort, 60);
}

#[test]
fn property_gauges_with_a_ceiling_are_called_saturated_however_few_contacts_reach_it() {
    assert_right(Class::GaugeSaturated, 60);
}

#[test]
fn property_silent_whiskers_of_a_robot_that_is_online_are_called_stale() {
    assert_right(Class::Silent, 60);
}

#[test]
fn property_the_same_seed_gives_the_same_report_however_many_threads_there_are() {
    let plan = Plan { seed: 9, cases: 2, classes: Class::ALL.to_vec() };
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(alone.install(|| evaluate(&plan, || {})), evaluate(&plan, || {}));
}
