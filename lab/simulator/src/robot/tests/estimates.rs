//! Estimates: their order, and contacts of a robot that divides by the estimated length.

use vibrissa_protocol::{Estimate, WhiskerCondition, WhiskerEstimate};

use super::*;
use crate::places::Places;

fn estimate(bench: &mut Bench, (epoch, version): (u64, u64), lengths_mm: &[(u16, f64)]) {
    let entry = |&(whisker, length_mm): &(u16, f64)| WhiskerEstimate {
        array: left(),
        whisker,
        length_mm,
        length_low_mm: length_mm - 0.5,
        length_high_mm: length_mm + 0.5,
        condition: WhiskerCondition::Trimmed,
        pressure_mpa: 0.1,
        gain: Vec::new(),
        reading_gain: None,
        response: Vec::new(),
    };
    let whiskers = lengths_mm.iter().map(entry).collect();
    let timestamp = Timestamp(bench.now_us);
    let estimate = Estimate { boot_id: supervisor(), seq: version, epoch, version, timestamp, whiskers };
    bench.send(RobotTopic::Estimate, &encode(&estimate));
}

fn lengths_mm(bench: &Bench) -> Vec<Option<f64>> {
    bench.robot.whiskers().iter().map(Whisker::estimated_length_mm).collect()
}

#[test]
fn the_newest_estimate_counts_until_the_restart() {
    let mut bench = Bench::connected(|_| {});
    assert_eq!(lengths_mm(&bench), [None, None], "the factory length is no estimate");
    estimate(&mut bench, (5, 3), &[(0, 66.0), (1, 60.0)]);
    assert_eq!(lengths_mm(&bench), [Some(66.0), Some(60.0)]);
    for older in [(5, 3), (5, 2), (4, 9)] {
        estimate(&mut bench, older, &[(0, 50.0), (1, 50.0)]);
        assert_eq!(lengths_mm(&bench), [Some(66.0), Some(60.0)], "{older:?}");
    }
    // A whisker that is not listed has no estimate any more.
    estimate(&mut bench, (5, 4), &[(0, 65.0)]);
    assert_eq!(lengths_mm(&bench), [Some(65.0), None]);
    estimate(&mut bench, (6, 0), &[(0, 64.0), (7, 1.0)]);
    assert_eq!(lengths_mm(&bench), [Some(64.0), None]);

    bench.robot.restart_soon();
    bench.run(1.0);
    assert_eq!((bench.restarts, lengths_mm(&bench)), (1, vec![None, None]));
    // After a restart it takes what the broker has retained, even if that is older.
    estimate(&mut bench, (5, 3), &[(0, 66.0)]);
    assert_eq!(lengths_mm(&bench), [Some(66.0), None]);
}

#[test]
fn a_robot_divides_by_the_estimated_length_and_sends_distances_before_it_knows_one() {
    let contacts = |places| {
        let mut bench = Bench::connected(|scenario| scenario.behaviour.places = places);
        bench.run(30.0);
        estimate(&mut bench, (5, 3), &[(0, 60.0)]);
        bench.run(30.0);
        bench.contacts().into_iter().flat_map(|message| message.contacts).collect::<Vec<_>>()
    };
    let (estimated, measured) = (contacts(Places::EstimatedRatio), contacts(Places::Distance));
    assert_eq!(estimated.len(), measured.len(), "the same touches");
    let (mut ratios, mut beyond) = (0, 0);
    for (contact, measurement) in estimated.iter().zip(&measured) {
        let distance_mm = measurement.distance_mm.unwrap();
        if contact.whisker != 0 || contact.t_us < START + 30 * S {
            assert_eq!(contact, measurement, "no estimate yet");
        } else if distance_mm <= 60.0 {
            let ratio = contact.ratio.expect("a ratio");
            assert!((ratio - distance_mm / 60.0).abs() < 1e-4 && contact.distance_mm.is_none(), "{contact:?}");
            ratios += 1;
        } else {
            assert_eq!(contact, measurement, "beyond the estimated length");
            beyond += 1;
        }
    }
    assert!(ratios > 20 && beyond > 3, "{ratios} {beyond}");
}
