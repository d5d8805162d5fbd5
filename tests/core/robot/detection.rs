//! The detector against what theory allows: everything learned as in the service.

use vibrissa_evaluation::detection::{Plan, evaluate};

/// Enough for standard errors of a few percent; `vibrissa-lab evaluate detection` runs more.
fn plan() -> Plan {
    Plan { cuts: 150, healthy_whiskers: 60, healthy_contacts: 20_000, changes_at: vec![2000], ..Plan::default() }
}

#[test]
fn property_the_delay_is_near_that_of_a_cusum_that_is_told_the_size() {
    let found = evaluate(&Plan { healthy_whiskers: 1, sizes_mm: vec![0.5, 1.0, 2.0, 5.0, 10.0], ..plan() }, &|| ());
    for delay in &found.delays {
        let slack = 3.0 * delay.alarm_error / delay.oracle;
        if delay.size_mm <= 2.0 {
            assert!(delay.ratio() <= 1.25 + slack, "{delay:#?}");
        } else if delay.size_mm <= 5.0 {
            assert!(delay.ratio() <= 1.3 + slack, "{delay:#?}");
        } else {
            assert!(delay.alarm <= delay.oracle + 2.0, "{delay:#?}");
        }
        assert!(delay.ratio() > 0.9, "nothing is sooner than the oracle: {delay:#?}");
    }
}

#[test]
fn property_outliers_delay_an_alarm_little() {
    let found =
        evaluate(&Plan { healthy_whiskers: 1, sizes_mm: vec![0.5, 1.0, 2.0], outliers: 0.02, ..plan() }, &|| ());
    for delay in &found.delays {
        assert!(delay.ratio() <= 1.6, "{delay:#?}");
    }
}

/// At a stated 5000 some hundred alarms come, so that the mean is known to a tenth.
#[test]
fn property_false_alarms_are_no_more_frequent_than_stated() {
    for (outliers, share) in [(0.0, 1.0), (0.02, 0.85)] {
        let few = Plan { cuts: 0, outliers, contacts_between_false_alarms: 5000.0, ..plan() };
        let healthy = evaluate(&few, &|| ()).healthy;
        assert!(healthy.alarms > 30, "{healthy:?}");
        assert!(healthy.between_false_alarms() >= share * 5000.0, "{healthy:?}");
    }
}

/// Consistency of the filter: squared standardised innovations of healthy whiskers have a mean of one (0.995
/// cut at 9), and the lengths after a cut lie in their intervals as often as these say.
#[test]
fn property_the_filter_knows_how_much_it_knows() {
    let found = evaluate(&Plan { cuts: 400, healthy_whiskers: 20, sizes_mm: vec![2.0, 5.0], ..plan() }, &|| ());
    assert!((found.healthy.mean_square - 0.995).abs() < 0.02, "{:?}", found.healthy);
    for delay in &found.delays {
        assert!(delay.called_share > 0.97, "{delay:#?}");
        assert!((0.92..=0.98).contains(&delay.covered), "95 % to within two standard errors: {delay:#?}");
    }
}
