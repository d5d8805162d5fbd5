use super::*;
use crate::robot::event::GaugeState;

const LEAK: Option<Fault> = Some(Fault::Leak);
const REGULATOR: Option<Fault> = Some(Fault::Regulator);
const SUPPLY: Option<Fault> = Some(Fault::SupplyLow);
const GAUGE: Option<Fault> = Some(Fault::Gauge(GaugeState::Open));
const START: Micros = Micros(1_795_260_000_000_000);

/// The fault and the alarm after each step of `step_s`, from a steady start without a fault.
fn history(present: impl Iterator<Item = Option<Fault>>, step_s: f64) -> Vec<Flapping<Fault>> {
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
            assert!(all[steps / 2..].iter().all(|one| one.alarm.is_some() && one.reported == one.alarm));
            let changes = all.windows(2).filter(|two| two[0].reported != two[1].reported).count();
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

/// A day of a fault that comes and goes, with a status every 10 s. Returns how often the fault and the alarm change.
fn day(is_leaking: impl FnMut(u64) -> bool) -> (usize, usize) {
    let all = history((0..86_400).step_by(10).map(is_leaking).map(|is| LEAK.filter(|_| is)), 10.0);
    let changes =
        |of: fn(&Flapping<Fault>) -> Option<Fault>| all.windows(2).filter(|two| of(&two[0]) != of(&two[1])).count();
    (changes(|one| one.reported), changes(|one| one.alarm))
}

#[test]
fn regress_a_fault_that_flaps_slowly_gives_a_few_rows_a_day() {
    for half_period_s in [610, 900, 1800, 3600, 7190, 7200, 7210, 14_400] {
        let (changes, alarms) = day(|second| second / half_period_s % 2 == 1);
        assert!(changes <= 12 && alarms <= 12, "{half_period_s} s: {changes} changes, {alarms} of the alarm");
    }
    // A burst of quick changes, then a steady time that just ends the latch.
    for (burst_s, pause_s) in [(20, 610), (60, 700), (200, 1200), (200, 7100)] {
        let (changes, alarms) = day(|second| second % (burst_s + pause_s) < burst_s && second / 10 % 2 == 1);
        assert!(changes <= 36 && alarms <= 36, "{burst_s} s of {pause_s} s: {changes} and {alarms}");
    }
}

#[test]
fn property_no_pattern_of_a_fault_gives_many_rows_a_day() {
    for seed in 1..200_u64 {
        let (mut random, mut is, mut until) = (seed, false, 0);
        let (changes, alarms) = day(|second| {
            if second >= until {
                random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                // Pauses from 10 s to 3 h, the short ones as likely as the long ones.
                until = second + (10.0 * 1080_f64.powf((random >> 33) as f64 / f64::from(1_u32 << 31))) as u64;
                is = !is;
            }
            is
        });
        assert!(changes <= 72 && alarms <= 72, "seed {seed}: {changes} changes, {alarms} of the alarm");
    }
}

#[test]
fn the_stored_byte_has_both_numbers() {
    for changes in [Changes::default(), Changes { quick: 6, slow: 1 }, Changes { quick: 15, slow: 15 }] {
        let bytes = borsh::to_vec(&changes).expect("a byte");
        assert_eq!((bytes.len(), borsh::from_slice::<Changes>(&bytes).expect("a byte")), (1, changes));
    }
}

#[test]
fn a_lasting_fault_is_raised_within_the_on_delay_and_a_short_one_is_not() {
    let short = history([LEAK, LEAK, None].into_iter().chain([None; 40]), 0.4);
    assert!(short.iter().all(|one| one.alarm.is_none()));
    assert_eq!(short[1].reported, LEAK, "it counts at once");
    let lasting = history([LEAK; 10].into_iter(), 0.4);
    let alarms: Vec<bool> = lasting.iter().map(|one| one.alarm == LEAK).collect();
    assert_eq!(alarms, [false, false, false, true, true, true, true, true, true, true]);
    // Two short ones in a row are a fault that flaps.
    assert_eq!(history([LEAK, None, LEAK].into_iter(), 0.4)[2].alarm, LEAK);
}

#[test]
fn a_repaired_fault_ends_at_once_and_its_alarm_after_the_off_delay() {
    let all = history([LEAK; 60].into_iter().chain([None; 30]), 1.0);
    assert_eq!((all[59].reported, all[60].reported), (LEAK, None));
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
                assert_eq!(worst(one.reported, present), one.reported, "{present:?} counts at once: {one:?}");
            }
            // As long as one change that follows another quickly: as many as latch it.
            let last = present[6];
            let steady_steps = (params.steady_after.as_s() / step_s) as usize + 2;
            present.extend(std::iter::repeat_n(last, if step_s < 1.0 { 0 } else { steady_steps }));
            let end = history(present.iter().copied(), step_s).pop().expect("steps");
            if step_s >= 1.0 {
                assert_eq!((end.reported, end.alarm), (last, last), "{code} at {step_s} s");
                let then = START.after(Micros::from_s(present.len() as f64 * step_s)).after(params.forgotten_after);
                assert!(end.is_over(&params, then));
            }
        }
    }
}
