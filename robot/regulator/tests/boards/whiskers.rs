//! Several whiskers of one board.

use crate::{Lines, STEP_MPA, compiled, configure, of, order, run, save};

/// Array, whisker, setpoint in MPa, and pins of six whiskers on a Mega: fill, vent, pressure. The simulator has the
/// analog inputs A0 to A7.
pub(crate) const SIX: [(&str, u16, f64, [u8; 3]); 6] = [
    ("left", 0, 0.03, [4, 5, 0]),
    ("left", 1, 0.05, [6, 7, 1]),
    ("left", 2, 0.07, [8, 9, 2]),
    ("right", 0, 0.09, [10, 11, 3]),
    ("right", 1, 0.11, [22, 23, 4]),
    ("right", 2, 0.13, [24, 25, 5]),
];

/// Six whiskers: two with an analog gauge, two with an HX711, two with an ADS1115. Ready at 1.5 s.
fn six() -> String {
    let mut script = String::new();
    for (slot, (array, whisker, _, [fill, vent, pressure])) in SIX.iter().enumerate() {
        script += &format!("50 !chamber {slot} {fill} {vent} {pressure}\n");
        let gauge = match slot {
            0 => "\"strain_pin\":\"A6\"",
            1 => "\"strain_sensor\":\"ANALOG\",\"strain_pin\":\"A7\"",
            2 => "\"strain_sensor\":\"HX711\",\"data_pin\":30,\"clock_pin\":31",
            3 => "\"strain_sensor\":\"HX711\",\"data_pin\":32,\"clock_pin\":33",
            4 => "\"strain_sensor\":\"ADS1115\",\"inputs\":\"0\"",
            _ => "\"strain_sensor\":\"ADS1115\",\"inputs\":\"1\"",
        };
        let keys = format!(
            "\"array\":\"{array}\",\"whisker\":{whisker},\"fill_pin\":{fill},\"vent_pin\":{vent},\
             \"pressure_pin\":\"A{pressure}\",{gauge}"
        );
        script += &configure(100 + 100 * slot as u32, slot as u8, &keys);
    }
    for slot in [2, 3] {
        script += &configure(700 + 50 * u32::from(slot), slot, "\"strain_zero_v\":0,\"strain_per_v\":0.4");
    }
    script += "50 !volts 6 2.6\n50 !volts 7 2.4\n50 !hx711 0 30 31 80\n50 !bridge 0 0.001\n50 !hx711 1 32 33 10\n";
    script += "50 !bridge 1 -0.002\n50 !ads1115 0 72\n50 !input 0 0 2.75\n50 !input 0 1 2.25\n";
    sorted(script + "900 {\"type\":\"configure\",\"baud\":250000}\n" + &save(1_000))
}

/// The script in the order of its times.
pub(crate) fn sorted(script: String) -> String {
    let mut lines: Vec<&str> = script.lines().collect();
    lines.sort_by_key(|line| line.split(' ').next().and_then(|ms| ms.parse::<u32>().ok()));
    lines.join("\n") + "\n"
}

/// The true pressures at each `!pressures`.
fn pressures(lines: &Lines) -> Vec<Vec<f64>> {
    let numbers = |line: &str| line.split(' ').skip(1).filter_map(|number| number.parse().ok()).collect();
    lines.iter().filter(|(_, _, line)| line.starts_with("pressures")).map(|(_, _, line)| numbers(line)).collect()
}

#[test]
fn six_whiskers_of_a_mega_are_regulated_each_by_itself() {
    let Some(folder) = compiled("mega") else { return };
    let mut script = six();
    for (slot, (array, whisker, mpa, _)) in SIX.iter().enumerate() {
        // The fourth one hears nothing after 8 s, and the sensor of the first one breaks at 16 s.
        let last_ms = if slot == 3 { 8_000 } else { 20_000 };
        for ms in (1_600..last_ms).step_by(2_000) {
            script += &order(ms + 20 * slot as u32, array, *whisker, *mpa);
        }
    }
    script += "7900 !pressures\n12500 !pressures\n15900 !pressures\n16000 !sensor 0\n20000 !pressures\n20000 !end\n";
    let lines = run("mega", &folder, &sorted(script));
    let seen = pressures(&lines);
    for (moment, is_silent, is_broken) in [(0, false, false), (1, false, false), (2, true, false), (3, true, true)] {
        for (slot, (array, whisker, mpa, _)) in SIX.iter().enumerate() {
            let expected = if (slot == 3 && is_silent) || (slot == 0 && is_broken) { 0.0 } else { *mpa };
            let steps = (seen[moment][slot] - expected).abs() / STEP_MPA;
            assert!(steps <= 1.3, "moment {moment}, {array}/{whisker}: {steps} steps from {expected}: {seen:?}");
        }
    }
    let last = |array: &str, whisker: u16| {
        let parts = ["\"pressure\"".to_owned(), format!("\"array\":\"{array}\""), format!("\"whisker\":{whisker},")];
        of(&lines, &parts.each_ref().map(String::as_str)).pop().expect("a line of pressure").to_owned()
    };
    for (slot, (array, whisker, ..)) in SIX.iter().enumerate() {
        let word = if slot == 0 { "FAULT" } else { "OK" };
        assert!(last(array, *whisker).contains(&format!("\"regulator\":\"{word}\"")), "{}", last(array, *whisker));
    }
}

#[test]
fn each_whisker_has_its_own_lines_of_strain_at_its_rate() {
    let Some(folder) = compiled("mega") else { return };
    let lines = run("mega", &folder, &(six() + "6000 !end\n"));
    let strains = [0.000_2, -0.000_2, 0.000_4, -0.000_8, 0.000_5, -0.000_5];
    // Lines in the 4.6 s since the gauges have settled: an HX711 of 10 Hz has a line for each sample.
    let rates = [100.0, 100.0, 80.0, 10.0, 100.0, 100.0];
    for (slot, (array, whisker, ..)) in SIX.iter().enumerate() {
        let head = format!("{{\"type\":\"strain\",\"array\":\"{array}\",\"whisker\":{whisker},");
        let mut samples = Vec::new();
        for (ms, _, line) in &lines {
            if *ms > 2_000.0 && line.starts_with(&head) {
                samples.extend(list_of(line));
            }
        }
        let rate = samples.len() as f64 / 4.0;
        assert!((rate / rates[slot] - 1.0).abs() < 0.05, "{array}/{whisker}: {rate} a second");
        for sample in samples {
            assert!((sample - strains[slot]).abs() < 0.000_011, "{array}/{whisker}: {sample}");
        }
    }
    let load =
        lines.iter().filter(|(_, _, line)| line.starts_with('{')).map(|(_, _, line)| line.len() + 1).sum::<usize>();
    println!("six whiskers: {} bytes a second", load / 6);
    // The samples are 10 ms apart, and lines are spread over the time between.
    for (array, whisker) in [("left", 0), ("left", 1), ("right", 1), ("right", 2)] {
        let head = format!("{{\"type\":\"strain\",\"array\":\"{array}\",\"whisker\":{whisker},\"t_ms\":");
        let times: Vec<f64> = lines.iter().filter_map(|(_, _, line)| time_of(line, &head)).collect();
        for pair in times.windows(2) {
            let samples = ((pair[1] - pair[0]) / 10.0).round();
            assert!((pair[1] - pair[0] - 10.0 * samples).abs() <= 5.0, "{array}/{whisker}: {pair:?}");
        }
    }
}

#[test]
fn six_whiskers_with_slides_lose_no_sample_and_end_their_pulses_in_time() {
    let Some(folder) = compiled("mega") else { return };
    let mut script = "50 !volts 6 2.6\n50 !volts 7 1\n60 {\"type\":\"configure\",\"baud\":250000}\n".to_owned();
    for (slot, (array, whisker, _, [fill, vent, pressure])) in SIX.iter().enumerate() {
        let (index, ms) = (slot as u8, 100 + 100 * slot as u32);
        script += &format!("50 !chamber {slot} {fill} {vent} {pressure}\n");
        let keys = format!(
            "\"array\":\"{array}\",\"whisker\":{whisker},\"fill_pin\":{fill},\"vent_pin\":{vent},\
             \"pressure_pin\":\"A{pressure}\",\"slide_pin\":\"A7\""
        );
        script += &configure(ms, index, &keys);
        let strain_pin = [6, 8, 9, 10, 11, 12][slot];
        let keys = format!("\"strain_sensor\":\"ANALOG\",\"strain_pin\":\"A{strain_pin}\",\"slide_mm\":40");
        script += &configure(ms + 50, index, &keys);
        for pulse in 0..4 {
            let open = if pulse % 2 == 0 { "FILL" } else { "VENT" };
            script += &format!(
                "{} {{\"type\":\"valve\",\"array\":\"{array}\",\"whisker\":{whisker},\"open\":\"{open}\",\
                 \"for_ms\":100}}\n",
                2_000 + 1_500 * pulse + 37 * slot
            );
        }
    }
    // Telling the configuration takes 60 lines, and holds up nothing.
    for ms in (2_020..6_000).step_by(1_500) {
        script += &format!("{ms} {{\"type\":\"configuration\"}}\n");
    }
    let lines = run("mega", &folder, &sorted(script + &save(900) + "8000 !end\n"));
    for (array, whisker, ..) in SIX {
        let head = format!("{{\"type\":\"strain\",\"array\":\"{array}\",\"whisker\":{whisker},");
        let of_whisker = lines.iter().filter(|(ms, _, line)| *ms > 2_000.0 && line.starts_with(&head));
        let samples: usize = of_whisker.map(|(_, _, line)| crate::list(line, "deflection_mm").len()).sum();
        assert!((590..=610).contains(&samples), "{array}/{whisker}: {samples} samples in 6 s");
    }
    let sent: usize =
        lines.iter().filter(|(ms, _, line)| *ms > 2_000.0 && line.starts_with('{')).map(|l| l.2.len()).sum();
    println!("six whiskers with slides: {} bytes a second", sent / 6);
    let mut opened = [None; 6];
    let mut pulses = 0;
    for (ms, _, line) in lines.iter().filter(|(_, _, line)| line.starts_with("valves")) {
        let number = line.split(" of ").nth(1).map_or(0, |number| number.parse::<usize>().expect("a chamber"));
        if line.starts_with("valves 1 0") || line.starts_with("valves 0 1") {
            opened[number] = Some(*ms);
        } else if let Some(from_ms) = opened[number].take() {
            assert!((99.5..103.0).contains(&(ms - from_ms)), "{} ms", ms - from_ms);
            pulses += 1;
        }
    }
    assert_eq!(pulses, 24);
    assert_eq!(of(&lines, &["\"configuration\",\"slot\":5,\"rate_hz\":100}"]).len(), 3);
}

fn time_of(line: &str, head: &str) -> Option<f64> {
    line.strip_prefix(head)?.split(',').next()?.parse().ok()
}

fn list_of(line: &str) -> Vec<f64> {
    crate::list(line, "strain")
}

#[test]
fn an_uno_serves_two_whiskers_with_slides_and_has_memory_left() {
    let Some(folder) = compiled("uno") else { return };
    let keys = |whisker: u8, fill: u8, vent: u8, pressure: u8, strain: u8, mm: i32| {
        format!(
            "\"array\":\"front-left-array\",\"whisker\":{whisker},\"fill_pin\":{fill},\"vent_pin\":{vent},\
             \"pressure_pin\":\"A{pressure}\",\"strain_sensor\":\"ANALOG\",\"strain_pin\":\"A{strain}\",\
             \"slide_mm\":{mm}"
        )
    };
    let mut script = "50 !chamber 1 6 7 3\n50 !volts 1 2.6\n50 !volts 4 2.4\n50 !volts 2 1.0\n".to_owned();
    script += &configure(100, 0, &keys(3, 4, 5, 0, 1, 50));
    script += &configure(200, 1, &keys(4, 6, 7, 3, 4, -50));
    script += &configure(300, 0, "\"slide_pin\":\"A2\"");
    script += &configure(350, 1, "\"slide_pin\":\"A2\"");
    // A refused line needs the most memory.
    script += &configure(400, 1, "\"limit_mpa\":0.9");
    script += &save(500);
    script += "1200 {\"type\":\"configuration\"}\n";
    for ms in (1_600..12_000).step_by(2_000) {
        script += &order(ms, "front-left-array", 3, 0.08);
        script += &order(ms + 30, "front-left-array", 4, 0.05);
        // Without a whisker it is for neither of the two.
        script += &format!("{} {{\"type\":\"set_pressure\",\"pressure_mpa\":0.15,\"slew_mpa_per_s\":0}}\n", ms + 60);
    }
    let lines = run("uno", &folder, &(script + "12000 !pressures\n12000 !stack\n12000 !end\n"));
    let seen = pressures(&lines);
    assert!((seen[0][0] - 0.08).abs() <= 1.3 * STEP_MPA && (seen[0][1] - 0.05).abs() <= 1.3 * STEP_MPA, "{seen:?}");
    let stack = lines.iter().find_map(|(_, _, line)| line.strip_prefix("stack ")?.parse::<i32>().ok());
    println!("Uno: at least {stack:?} bytes between variables and stack");
    assert!(stack.is_some_and(|bytes| bytes >= 128), "{stack:?}");
    for (whisker, strain, way) in [(3, 0.000_2, 10.0), (4, -0.000_2, -10.0)] {
        let lines = of(&lines, &["\"strain\"", &format!("\"whisker\":{whisker},")]);
        // 11.4 s with 100 samples a second: none is left out.
        let samples: usize = lines.iter().map(|line| list_of(line).len()).sum();
        assert!((1_130..=1_150).contains(&samples), "whisker {whisker}: {samples} samples");
        let line = lines.last().expect("lines of strain");
        assert!(list_of(line).iter().all(|seen| (seen - strain).abs() < 0.000_011), "{line}");
        assert!(crate::list(line, "deflection_mm").iter().all(|seen: &f64| (seen - way).abs() < 0.06), "{line}");
        assert_eq!(list_of(line).len(), crate::list(line, "deflection_mm").len());
    }
}
