use super::*;
use crate::robot::event::GaugeState;

const LEAK: Option<Fault> = Some(Fault::Leak);
const REGULATOR: Option<Fault> = Some(Fault::Regulator);
const SUPPLY: Option<Fault> = Some(Fault::SupplyLow);
const GAUGE: Option<Fault> = Some(Fault::Gauge(GaugeState::Open));
const START: Micros = Micros(1_795_260_000_000_000);

/// The fault and the alarm after each step of `step_s`, from a steady start without a fault.
fn history(present: impl Iterator<Item = Option<Fault>>, step_s: f64) -> Vec<Flapping> {
    let (params, mut flapping, mut now) = (FlappingParams::default(), Flapping::steady(None), START);
    let each = present.map(|present| {
        flapping.observe(&params, now, present);
        now = now.after(Micros::from_s(step_s));
        flapping
    });
    each.collect()
}

/// How often a value becomes another one that is not `None`, from `None` on.
fn raised(values: impl Iterator<Item = Option<Fault>>) -> usize {
    let mut before = None;
    values.filter(|&value| std::mem::replace(&mut before, value) != value && value.is_some()).count()
}

#[test]
fn regress_a_fault_that_flaps_for_ten_minutes_is_one_alarm_and_a_few_changes() {
    let latch = usize::from(FlappingParams::default().latch_changes);
    for (other, most) in [(None, 1), (SUPPLY, 2), (GAUGE, 2), (REGULATOR, 2)] {
        for step_s in [0.05, 0.3, 1.0, 2.0, 5.0, 10.0, 14.0] {
            let steps = (600.0 / step_s) as usize;
            let all = history([LEAK, other].into_iter().cycle().take(steps), step_s);
            assert!(raised(all.iter().map(|one| one.alarm)) <= most, "{other:?}, {step_s} s");
            assert!(all[steps / 2..].iter().all(|one| one.alarm.is_some() && one.told == one.alarm));
            let changes = all.windows(2).filter(|two| two[0].told != two[1].told).count();
            assert!(changes < latch, "{other:?}, {step_s} s: {changes} changes");
        }
    }
    // Slower than the off-delay: an alarm each time until it is latched.
    for step_s in [16, 60, 590] {
        let by_second = [LEAK, None].into_iter().flat_map(|one| std::iter::repeat_n(one, step_s));
        let all = history(by_second.cycle().take(200 * step_s), 1.0);
        assert_eq!(raised(all.iter().map(|one| one.alarm)), latch / 2, "{step_s} s");
    }
}

#[test]
fn a_lasting_fault_is_raised_within_the_on_delay_and_a_short_one_is_not() {
    let short = history([LEAK, LEAK, None].into_iter().chain([None; 40]), 0.4);
    assert!(short.iter().all(|one| one.alarm.is_none()));
    assert_eq!(short[1].told, LEAK, "it counts at once");
    let lasting = history([LEAK; 10].into_iter(), 0.4);
    let alarms: Vec<bool> = lasting.iter().map(|one| one.alarm == LEAK).collect();
    assert_eq!(alarms, [false, false, false, true, true, true, true, true, true, true]);
    // Two short ones in a row are a fault that flaps.
    assert_eq!(history([LEAK, None, LEAK].into_iter(), 0.4)[2].alarm, LEAK);
}

#[test]
fn a_repaired_fault_ends_at_once_and_its_alarm_after_the_off_delay() {
    let all = history([LEAK; 60].into_iter().chain([None; 30]), 1.0);
    assert_eq!((all[59].told, all[60].told), (LEAK, None));
    assert_eq!((all[74].alarm, all[75].alarm), (LEAK, None));
}

/// All sequences of three states in 7 steps, at several paces, from a fault or none.
#[test]
fn brute_force_a_fault_counts_at_once_and_everything_is_as_present_once_it_is_steady() {
    let params = FlappingParams::default();
    let states = [None, LEAK, SUPPLY];
    for code in 0..3_usize.pow(7) {
        let sequence = (0..7).map(|at| states[code / 3_usize.pow(at) % 3]);
        for step_s in [0.1, 0.9, 3.0, 20.0, 300.0] {
            let mut present: Vec<Option<Fault>> = sequence.clone().collect();
            let all = history(present.iter().copied(), step_s);
            for (one, &present) in all.iter().zip(&present) {
                assert_eq!(worst(one.told, present), one.told, "{present:?} counts at once: {one:?}");
            }
            // As long as one change that follows another quickly: as many as latch it.
            let last = present[6];
            let steady_steps = (params.steady_after.as_s() / step_s) as usize + 2;
            present.extend(std::iter::repeat_n(last, if step_s < 1.0 { 0 } else { steady_steps }));
            let end = history(present.iter().copied(), step_s).pop().expect("steps");
            if step_s >= 1.0 {
                assert_eq!((end.told, end.alarm), (last, last), "{code} at {step_s} s");
                assert!(end.is_over(&params, START.after(Micros::from_s(present.len() as f64 * step_s))));
            }
        }
    }
}
