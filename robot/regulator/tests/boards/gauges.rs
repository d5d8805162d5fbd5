//! HX711 and ADS1115 beside the board, as their data sheets describe them.

use crate::{Lines, compiled, configure, list, of, run, save};

/// An HX711 at D8 and D9 of an Uno, with 0.4 of strain per volt; its bridge is read from 1.5 s on.
fn hx711(rate_hz: u32, gain: u32, per_v: f64) -> String {
    format!("50 !hx711 0 8 9 {rate_hz}\n")
        + &configure(100, 0, "\"strain_sensor\":\"HX711\",\"data_pin\":8,\"clock_pin\":9")
        + &configure(200, 0, &format!("\"gain\":{gain},\"strain_zero_v\":0,\"strain_per_v\":{per_v}"))
        + &save(300)
}

fn strains(lines: &Lines, from_ms: f64, to_ms: f64) -> Vec<f64> {
    let during = lines.iter().filter(|(ms, _, line)| (from_ms..to_ms).contains(ms) && line.contains("\"strain\""));
    during.flat_map(|(_, _, line)| list(line, "strain")).collect()
}

fn is_near(strains: &[f64], expected: f64, tolerance: f64) -> bool {
    !strains.is_empty() && strains.iter().all(|strain| (strain - expected).abs() <= tolerance)
}

#[test]
fn an_hx711_is_read_at_both_rates_with_each_gain_and_sign() {
    let Some(folder) = compiled("uno") else { return };
    for (rate_hz, gain, per_v) in [(80, 128, 0.4), (80, 64, -0.4), (80, 32, 0.1), (10, 128, -0.4)] {
        let script = hx711(rate_hz, gain, per_v)
            + "1500 !bridge 0 0.0123\n3000 !bridge 0 -0.0045\n4500 !bridge 0 0.00001\n6000 !end\n";
        let lines = run("uno", &folder, &script);
        for (from_ms, to_ms, volts) in
            [(1_800.0, 3_000.0, 0.0123), (3_300.0, 4_500.0, -0.0045), (4_800.0, 6_000.0, 1e-5)]
        {
            let seen = strains(&lines, from_ms, to_ms);
            // A line has seven places; a step of the converter is smaller.
            assert!(is_near(&seen, volts * per_v, 1.1e-7), "{rate_hz} Hz, gain {gain}, {volts} V: {seen:?}");
            let per_s = seen.len() as f64 * 1000.0 / (to_ms - from_ms);
            assert!((per_s / f64::from(rate_hz) - 1.0).abs() < 0.11, "{per_s} samples a second");
        }
        if rate_hz == 80 {
            let every = of(&lines, &["\"every_us\":12"]).len() + of(&lines, &["\"every_us\":13"]).len();
            assert!(every >= of(&lines, &["\"strain\""]).len() - 20, "{every}");
        }
        assert!(of(&lines, &["\"fault\""]).is_empty(), "{:?}", of(&lines, &["\"fault\""]));
    }
}

#[test]
fn the_end_of_the_scale_of_an_hx711_is_reported() {
    let Some(folder) = compiled("uno") else { return };
    for (volts, end_ms) in [(0.025, 15_000), (-0.025, 4_000)] {
        let orders = format!("2000 !bridge 0 {volts}\n4000 !bridge 0 0.001\n{end_ms} !end\n");
        let script = hx711(80, 128, 0.4) + &orders;
        let lines = run("uno", &folder, &script);
        let end = 2.5 / 128.0 * 0.4 * f64::signum(volts);
        assert!(is_near(&strains(&lines, 2_300.0, 4_000.0), end, 2e-7), "{:?}", strains(&lines, 2_300.0, 4_000.0));
        let faults = of(&lines, &["\"fault\""]);
        assert!(faults[0].contains("\"gauge\":\"SATURATED\""), "{faults:?}");
        // In order again after 10 s without a clipped sample.
        let is_over = faults.last().is_some_and(|line| line.contains("\"gauge\":\"OK\""));
        assert_eq!(is_over, end_ms == 15_000, "{faults:?}");
    }
}

#[test]
fn regress_a_clipped_sample_is_reported_although_its_line_leaves_no_room() {
    let Some(folder) = compiled("uno") else { return };
    // Two whiskers with a gauge and a slide have lines of 300 bytes.
    let mut script = "50 !volts 2 2.5\n50 !volts 3 2.5\n50 !volts 4 5.0\n".to_owned();
    for (slot, ms) in [(0, 200), (1, 400)] {
        let (fill, vent, whisker, strain) = (4 + 2 * slot, 5 + 2 * slot, 1 + slot, 2 + slot);
        for (later_ms, keys) in [
            (0, format!("\"whisker\":{whisker},\"fill_pin\":{fill},\"vent_pin\":{vent},\"pressure_pin\":\"A{slot}\"")),
            (50, format!("\"strain_sensor\":\"ANALOG\",\"strain_pin\":\"A{strain}\"")),
            (100, "\"strain_zero_v\":5.0,\"strain_per_v\":0.25,\"slide_pin\":\"A4\",\"slide_mm\":300".to_owned()),
        ] {
            script += &configure(ms + later_ms, slot, &keys);
        }
    }
    script += &(save(700) + "3000 !volts 2 0.0\n3000 !volts 3 0.0\n3060 !volts 2 2.5\n3060 !volts 3 2.5\n7000 !end\n");
    let lines = run("uno", &folder, &script);
    assert!(of(&lines, &["\"strain\"", "-1.0000000"]).len() >= 2, "the gauges are clipped");
    for whisker in [1, 2] {
        let whisker = format!("\"whisker\":{whisker},");
        assert!(!of(&lines, &["\"gauge\":\"SATURATED\"", &whisker]).is_empty(), "{whisker}");
    }
}

#[test]
fn an_hx711_that_does_not_answer_is_an_open_gauge() {
    let Some(folder) = compiled("uno") else { return };
    for level in [0, 1] {
        let lines = run("uno", &folder, &(hx711(80, 128, 0.4) + &format!("2000 !broken 0 {level}\n6000 !end\n")));
        assert!(strains(&lines, 2_200.0, 6_000.0).is_empty(), "{level}: {:?}", strains(&lines, 2_200.0, 6_000.0));
        let faults = of(&lines, &["\"fault\"", "\"gauge\":\"OPEN\""]);
        assert!((2..=3).contains(&faults.len()), "{level}: {faults:?}");
        assert!(of(&lines, &["\"pressure\""]).len() > 18, "the board goes on");
    }
}

/// An ADS1115 on an Uno whose first whisker reads `inputs`.
fn ads1115(inputs: &str, range: &str, per_v: f64) -> String {
    "50 !ads1115 0 72\n".to_owned()
        + &configure(100, 0, &format!("\"strain_sensor\":\"ADS1115\",\"address\":72,\"inputs\":\"{inputs}\""))
        + &configure(200, 0, &format!("\"range_v\":{range},\"strain_zero_v\":0,\"strain_per_v\":{per_v}"))
        + &save(300)
}

#[test]
fn an_ads1115_is_read_at_each_pair_range_and_sign() {
    let Some(folder) = compiled("uno") else { return };
    let volts: [f64; 4] = [1.2, 1.1, 0.2, 0.15];
    for (inputs, range, per_v, expected_v) in [
        ("0-1", "0.256", 0.01, 0.1),
        ("1-3", "1.024", -0.01, 0.95),
        ("0-3", "2.048", 0.01, 1.05),
        ("2-3", "0.512", 0.01, 0.05),
        ("0", "2.048", 0.01, 1.2),
        ("3", "4.096", -0.02, 0.15),
    ] {
        let mut script = ads1115(inputs, range, per_v);
        for (input, volts) in volts.iter().enumerate() {
            script += &format!("400 !input 0 {input} {volts}\n");
        }
        // The positive input falls: the sign changes with a pair.
        script += &format!("2500 !input 0 {} 0.0\n4500 !end\n", &inputs[..1]);
        let lines = run("uno", &folder, &script);
        let step = range.parse::<f64>().expect("a number") / 32_768.0 * per_v.abs() + 1e-7;
        let seen = strains(&lines, 700.0, 2_400.0);
        assert!(is_near(&seen, expected_v * per_v, step), "{inputs}: {seen:?}");
        assert!((165..=175).contains(&seen.len()), "{inputs}: {} samples", seen.len());
        let negative: usize = inputs.split('-').nth(1).and_then(|input| input.parse().ok()).unwrap_or(4);
        let low_v: f64 = volts.get(negative).map_or(0.0, |volts| -volts);
        let end_v = range.parse::<f64>().expect("a number");
        let seen = strains(&lines, 2_800.0, 4_500.0);
        assert!(is_near(&seen, low_v.max(-end_v) * per_v, step), "{inputs}: {seen:?}");
    }
}

#[test]
fn the_end_of_the_scale_of_an_ads1115_and_its_silence_are_reported() {
    let Some(folder) = compiled("uno") else { return };
    let script = ads1115("0-1", "0.256", 0.01) + "2000 !input 0 0 0.3\n4000 !input 0 0 0.1\n16000 !end\n";
    let lines = run("uno", &folder, &script);
    let end = strains(&lines, 2_300.0, 4_000.0);
    assert!(is_near(&end, 0.002_56, 2e-7), "{end:?}");
    let faults = of(&lines, &["\"fault\""]);
    assert!(faults[0].contains("\"gauge\":\"SATURATED\""), "{faults:?}");
    assert!(faults.last().is_some_and(|line| line.contains("\"gauge\":\"OK\"")), "{faults:?}");
    // Nothing has the address 73.
    let script = ads1115("0-1", "0.256", 0.01).replace("\"address\":72", "\"address\":73");
    let lines = run("uno", &folder, &(script + "5000 !end\n"));
    assert!(
        of(&lines, &["\"strain\""]).iter().all(|line| line.contains("\"t_ms\":1,") || line.contains("\"t_ms\":0,"))
    );
    assert!(of(&lines, &["\"gauge\":\"OPEN\""]).len() >= 2);
    assert!(of(&lines, &["\"pressure\""]).len() > 15, "the board goes on");
}

#[test]
fn a_slide_without_a_gauge_gives_motion() {
    let Some(folder) = compiled("uno") else { return };
    let script = "50 !volts 2 2.5\n".to_owned()
        + &configure(100, 0, "\"strain_sensor\":\"NONE\",\"slide_pin\":\"A2\",\"slide_mm\":40")
        + &save(200)
        + "2500 !end\n";
    let lines = run("uno", &folder, &script);
    let motion = of(&lines, &["\"motion\""]);
    assert!(motion.len() > 18, "{motion:?}");
    assert!(motion.iter().all(|line| list(line, "deflection_mm").iter().all(|mm| (mm - 20.0).abs() < 0.06)));
    assert!(motion.iter().all(|line| line.contains("\"every_us\":10000") && !line.contains("strain")));
}

#[test]
fn the_upper_inputs_of_a_mega_are_read() {
    let Some(folder) = compiled("mega") else { return };
    for (strain_pin, slide_pin) in [(8, 15), (15, 12), (7, 9)] {
        let script = format!("50 !volts {strain_pin} 3.0\n50 !volts {slide_pin} 2.5\n50 !volts 1 1.0\n")
            + &configure(100, 0, &format!("\"strain_sensor\":\"ANALOG\",\"strain_pin\":\"A{strain_pin}\""))
            + &configure(200, 0, "\"strain_zero_v\":2.5,\"strain_per_v\":0.006")
            + &configure(300, 0, &format!("\"slide_pin\":\"A{slide_pin}\",\"slide_mm\":40"))
            + &save(400)
            + &format!("1500 !volts {strain_pin} 3.5\n2500 !end\n");
        let lines = run("mega", &folder, &script);
        // A step of the converter is 0.00003.
        for (from_ms, to_ms, expected) in [(800.0, 1_500.0, 0.003), (1_800.0, 2_500.0, 0.006)] {
            let seen = strains(&lines, from_ms, to_ms);
            assert!(is_near(&seen, expected, 3.1e-5), "A{strain_pin} from {from_ms} ms: {seen:?}");
        }
        let during = lines.iter().filter(|(ms, _, line)| *ms > 800.0 && line.contains("\"deflection_mm\""));
        let way_mm: Vec<f64> = during.flat_map(|(_, _, line)| list(line, "deflection_mm")).collect();
        assert!(is_near(&way_mm, 20.0, 0.06), "A{slide_pin}: {way_mm:?}");
    }
}
