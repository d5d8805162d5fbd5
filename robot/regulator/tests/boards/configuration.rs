//! The lines `configure` and `configuration`, and the record in the EEPROM.

use crate::{STEP_MPA, at, compiled, configure, held, of, order, run, save, set_pressure};

/// A second whisker on an Uno.
const SECOND: &str = "\"array\":\"right\",\"whisker\":7,\"fill_pin\":6,\"vent_pin\":7,\"pressure_pin\":\"A3\"";
const SECOND_GAUGE: &str = "\"strain_sensor\":\"ANALOG\",\"strain_pin\":\"A4\",\"strain_per_v\":-1.5e-3,\"rate_hz\":50";

fn opens(lines: &crate::Lines, from_ms: f64) -> usize {
    let is_open = |line: &str| line.starts_with("valves 1") || line.starts_with("valves 0 1");
    lines.iter().filter(|(ms, _, line)| *ms > from_ms && is_open(line)).count()
}

#[test]
fn a_configuration_survives_a_restart_and_can_be_read_back() {
    let Some(folder) = compiled("uno") else { return };
    let mut script = "50 !chamber 1 6 7 3\n".to_owned();
    script += &(configure(100, 1, SECOND) + &configure(200, 1, SECOND_GAUGE));
    script +=
        &configure(300, 0, "\"pressure_zero_v\":0.5,\"pressure_v_per_mpa\":20,\"limit_mpa\":0.15,\"slide_pin\":\"A2\"");
    script += &configure(400, 0, "\"slide_mm\":-12.5,\"array\":\"nose_1\"");
    script += &(save(500) + "1500 !restart\n1900 {\"type\":\"configuration\"}\n");
    script += &order(2_500, "right", 7, 0.06);
    let lines = run("uno", &folder, &(script + "5000 !pressures\n5000 !end\n"));
    assert_eq!(of(&lines, &["\"configured\"", "UNSAVED"]).len(), 4);
    assert_eq!(of(&lines, &["\"configured\"", "\"SAVED\""]).len(), 1);
    let hello = of(&lines, &["\"hello\""]);
    assert!(hello[1].contains("\"whiskers\":2,\"configuration\":\"STORED\""), "{hello:?}");
    let told = of(&lines, &["\"configuration\","]).join("\n");
    for expected in [
        "\"record\":\"STORED\",\"slots\":2,\"baud\":115200",
        "\"slot\":0,\"array\":\"nose_1\",\"whisker\":1,\"fill_pin\":4,\"vent_pin\":5,\"limit_mpa\":0.15",
        "\"pressure_pin\":\"A0\",\"pressure_zero_v\":0.5,\"pressure_v_per_mpa\":20,\"slide_pin\":\"A2\"",
        "\"slide_mm\":-12.5",
        "\"slot\":1,\"array\":\"right\",\"whisker\":7,\"fill_pin\":6,\"vent_pin\":7,\"limit_mpa\":0.2",
        "\"strain_zero_v\":2.5,\"strain_per_v\":-0.0015",
        "\"slot\":1,\"rate_hz\":50",
    ] {
        assert!(told.contains(expected), "{expected} is not in {told}");
    }
    // The second whisker has its own pins, and reads half as often.
    let pressures = lines.iter().rfind(|(_, _, line)| line.starts_with("pressures")).expect("pressures");
    let second: f64 = pressures.2.split(' ').nth(2).and_then(|mpa| mpa.parse().ok()).expect("a number");
    assert!((second - 0.06).abs() <= 1.3 * STEP_MPA, "{}", pressures.2);
    let strain = of(&lines, &["\"strain\"", "\"array\":\"right\""]);
    assert!(strain.last().is_some_and(|line| line.contains("\"every_us\":20000")), "{strain:?}");
}

#[test]
fn what_the_board_tells_can_be_sent_to_another_one() {
    let Some(folder) = compiled("uno") else { return };
    let ask = "900 {\"type\":\"configuration\"}\n1400 !end\n";
    let script = configure(100, 1, SECOND) + &configure(200, 1, SECOND_GAUGE) + &save(300) + ask;
    let told = |script: &str| -> Vec<String> {
        of(&run("uno", &folder, script), &["\"configuration\",\"slot\""]).iter().map(ToString::to_string).collect()
    };
    let first = told(&script);
    let mut copy = String::new();
    for (index, line) in first.iter().enumerate() {
        copy += &format!("{} {}\n", 50 + 30 * index, line.replace("configuration", "configure"));
    }
    assert_eq!(first, told(&(copy + &save(500) + ask)));
    assert!(first.len() > 8, "{first:?}");
}

#[test]
fn a_damaged_or_foreign_record_opens_no_valve_until_the_board_is_configured_anew() {
    let Some(folder) = compiled("uno") else { return };
    let stored = configure(100, 1, SECOND) + &configure(150, 1, SECOND_GAUGE) + &save(200);
    for (name, before) in [
        ("a byte has changed", stored.clone() + "900 !eeprom 30 77\n"),
        ("the write did not end", stored.clone() + "900 !eeprom 123 0\n900 !eeprom 124 0\n"),
        ("of another version", stored + "900 !eeprom 3 200\n"),
        ("of another program", "900 !eeprom 0 65\n".to_owned()),
    ] {
        let mut script = before + "1000 !restart\n";
        for ms in (1_400..5_000).step_by(500) {
            script += &set_pressure(ms, 0.08);
            script += &format!("{} {{\"type\":\"valve\",\"whisker\":1,\"open\":\"FILL\",\"for_ms\":900}}\n", ms + 100);
        }
        // The way back is the same for all.
        let is_last = name == "of another program";
        if is_last {
            script += "5200 {\"type\":\"configure\",\"defaults\":true}\n";
            script += &(save(5_300) + &held(6_000, 10_000, 0.08));
        }
        script += if is_last { "10000 !end\n" } else { "5200 !end\n" };
        let lines = run("uno", &folder, &script);
        let locked: Vec<_> = lines.iter().filter(|(ms, ..)| (1_000.0..5_200.0).contains(ms)).cloned().collect();
        assert_eq!(opens(&locked, 0.0), 0, "{name}");
        assert!(of(&locked, &["\"hello\"", "\"configuration\":\"BROKEN\""]).len() == 1, "{name}");
        assert!(!of(&locked, &["\"fault\"", "\"regulator\":\"FAULT\"", "\"problem\":\"the configuration"]).is_empty());
        assert!(of(&locked, &["\"pressure\""]).iter().all(|line| line.contains("\"FAULT\"")), "{name}");
        let expected = if is_last { 0.08 } else { 0.0 };
        assert!((at(&lines, 10_000.0).0 - expected).abs() <= 1.3 * STEP_MPA, "{name}: {:?}", at(&lines, 10_000.0));
    }
}

#[test]
fn refused_values_are_answered_and_change_nothing() {
    let Some(folder) = compiled("uno") else { return };
    let cases: &[(&str, &[&str])] = &[
        ("\"slot\":2,\"whisker\":1", &["the board has no such slot", "slot 0 or 1"]),
        ("\"slot\":0,\"limit_mpa\":0.3", &["\"key\":\"limit_mpa\"", "0.3 is not allowed", "from 0.01 to 0.2"]),
        ("\"slot\":0,\"limit_mpa\":\"0.1\"", &["\"key\":\"limit_mpa\""]),
        ("\"slot\":0,\"fill_pin\":1", &["\"key\":\"fill_pin\"", "a digital pin from 2 on"]),
        ("\"slot\":0,\"fill_pin\":13", &["\"key\":\"fill_pin\"", "it blinks"]),
        ("\"slot\":0,\"fill_pin\":20", &["\"key\":\"fill_pin\""]),
        ("\"slot\":0,\"pressure_pin\":\"A6\"", &["\"key\":\"pressure_pin\"", "A0 to A5"]),
        ("\"slot\":0,\"pressure_pin\":7", &["\"key\":\"pressure_pin\""]),
        ("\"slot\":0,\"array\":\"a name that is too long\"", &["\"key\":\"array\"", "1 to 16"]),
        ("\"slot\":0,\"array\":\"a/b\"", &["\"key\":\"array\""]),
        ("\"slot\":0,\"whisker\":-1", &["\"key\":\"whisker\""]),
        ("\"slot\":0,\"whisker\":65536", &["\"key\":\"whisker\"", "from 0 to 65535"]),
        ("\"slot\":0,\"strain_per_v\":0", &["\"key\":\"strain_per_v\"", "or its negative"]),
        ("\"slot\":0,\"strain_per_v\":1e9", &["\"key\":\"strain_per_v\""]),
        ("\"slot\":0,\"strain_per_v\":nan", &["\"key\":\"strain_per_v\"", "nan is not allowed"]),
        ("\"slot\":0,\"slide_mm\":301", &["\"key\":\"slide_mm\""]),
        ("\"slot\":0,\"rate_hz\":201", &["\"key\":\"rate_hz\"", "from 10 to 200"]),
        ("\"slot\":0,\"rate_hz\":12.5", &["\"key\":\"rate_hz\""]),
        ("\"slot\":0,\"strain_sensor\":\"HX710\"", &["\"key\":\"strain_sensor\"", "ANALOG, HX711, ADS1115"]),
        ("\"slot\":0,\"gain\":100", &["\"key\":\"gain\"", "128, 64 or 32"]),
        ("\"slot\":0,\"address\":76", &["\"key\":\"address\"", "from 72 to 75"]),
        ("\"slot\":0,\"inputs\":\"1-2\"", &["\"key\":\"inputs\""]),
        ("\"slot\":0,\"range_v\":6.144", &["\"key\":\"range_v\"", "4.096"]),
        ("\"slot\":0,\"pressure_v_per_mpa\":0.5", &["\"key\":\"pressure_v_per_mpa\""]),
        ("\"slot\":0,\"strain_per_volt\":0.1", &["\"key\":\"strain_per_volt\"", "no such key"]),
        ("\"slot\":0,\"pins\":{\"fill\":4}", &["\"key\":\"pins\""]),
        ("\"slot\":0,\"whisker\":5,\"limit_mpa\":9", &["\"key\":\"limit_mpa\""]),
        ("\"baud\":9600", &["baud has another value"]),
        ("\"slots\":0", &["the line has no slot"]),
    ];
    let mut script = String::new();
    for (index, (keys, _)) in cases.iter().enumerate() {
        script += &format!("{} {{\"type\":\"configure\",{keys}}}\n", 100 + 60 * index);
    }
    script += "2000 {\"type\":\"configuration\"}\n2300 !end\n";
    let lines = run("uno", &folder, &script);
    let errors = of(&lines, &["\"error\""]);
    assert_eq!(errors.len(), cases.len(), "{errors:#?}");
    for ((keys, parts), error) in cases.iter().zip(&errors) {
        assert!(parts.iter().all(|part| error.contains(part)), "{keys}: {error}");
        assert!(error.contains("\"problem\":\"") && error.contains("\"do\":\""), "{error}");
    }
    let told = of(&lines, &["\"configuration\","]).join("\n");
    assert!(
        told.contains("\"slot\":0,\"array\":\"left\",\"whisker\":1,\"fill_pin\":4,\"vent_pin\":5,\"limit_mpa\":0.2")
    );
    assert!(told.contains("\"record\":\"DEFAULT\"") && !told.contains("\"slot\":1"), "{told}");
}

#[test]
fn a_configuration_that_contradicts_itself_is_not_saved() {
    let Some(folder) = compiled("uno") else { return };
    for (keys, expected) in [
        ("\"slot\":1,\"whisker\":2", "\"slot\":1,\"key\":\"fill_pin\",\"problem\":\"the whisker needs this pin\""),
        ("\"slot\":0,\"vent_pin\":4", "\"slot\":0,\"key\":\"vent_pin\",\"problem\":\"the pin has another use, too\""),
        (
            "\"slot\":0,\"slide_pin\":\"A1\"",
            "\"slot\":0,\"key\":\"slide_pin\",\"problem\":\"the pin has another use, too\"",
        ),
        ("\"slot\":0,\"fill_pin\":\"A4\",\"strain_sensor\":\"ADS1115\"", "\"slot\":0,\"key\":\"fill_pin\""),
        ("\"slot\":0,\"strain_sensor\":\"HX711\"", "\"slot\":0,\"key\":\"data_pin\""),
        ("\"slot\":0,\"remove\":true", "no whisker is configured"),
        ("\"slot\":0,\"pressure_v_per_mpa\":20", "\"slot\":0,\"problem\":\"limit_mpa is above 4.9 V"),
        (
            "\"slot\":1,\"array\":\"left\",\"whisker\":1,\"fill_pin\":6,\"vent_pin\":7,\"pressure_pin\":\"A3\"",
            "\"slot\":1,\"problem\":\"two slots have the same array and whisker\"",
        ),
    ] {
        let script = format!("100 {{\"type\":\"configure\",{keys}}}\n") + &save(200) + "600 !restart\n900 !end\n";
        let lines = run("uno", &folder, &script);
        let errors = of(&lines, &["\"error\""]);
        assert!(errors.len() == 1 && errors[0].contains(expected), "{keys}: {errors:?}");
        assert!(of(&lines, &["\"hello\"", "\"DEFAULT\""]).len() == 2, "{keys}: nothing is stored");
    }
    let fast = "\"rate_hz\":200,\"slide_pin\":\"A2\",\"slide_mm\":20";
    let script = configure(100, 1, SECOND) + &configure(200, 1, SECOND_GAUGE) + &configure(300, 1, fast);
    let lines = run("uno", &folder, &(script + &configure(400, 0, fast) + &save(500) + "800 !end\n"));
    let errors = of(&lines, &["\"error\""]);
    assert!(errors.len() == 1 && errors[0].contains("the serial line carries 11520"), "{errors:?}");
}

#[test]
fn all_valves_are_closed_while_the_board_is_configured() {
    let Some(folder) = compiled("uno") else { return };
    // The chamber holds 0.05 MPa when the first line comes, and a pulse is under way.
    let mut script = held(300, 4_000, 0.05);
    script += "4800 {\"type\":\"valve\",\"whisker\":1,\"open\":\"VENT\",\"for_ms\":1000}\n";
    script += &configure(4_850, 0, "\"rate_hz\":50");
    for ms in (5_000..9_000).step_by(500) {
        script += &set_pressure(ms, 0.15);
    }
    // Nobody saves: a minute after the last line the board discards the changes. It has heard no order: it vents.
    let lines = run("uno", &folder, &(script + "64500 !pressures\n75000 !end\n"));
    let shut = lines.iter().find(|(ms, _, line)| *ms > 4_850.0 && line == "valves 0 0").expect("the pulse ends");
    assert!(shut.0 < 4_875.0, "{shut:?}");
    let meanwhile: Vec<_> = lines.iter().filter(|(ms, ..)| (4_875.0..64_800.0).contains(ms)).cloned().collect();
    assert_eq!(opens(&meanwhile, 0.0), 0);
    assert_eq!(of(&meanwhile, &["\"pressure\""]).len() + of(&meanwhile, &["\"strain\""]).len(), 0);
    assert_eq!(of(&lines, &["\"DISCARDED\""]).len(), 1);
    assert!(at(&lines, 75_000.0).0 < 2.0 * STEP_MPA, "{:?}", at(&lines, 75_000.0));
    let strain = of(&lines, &["\"strain\""]);
    assert!(strain.last().is_some_and(|line| line.contains("\"every_us\":10000")), "the change is discarded");
}

#[test]
fn a_line_that_lost_a_part_configures_nothing() {
    let Some(folder) = compiled("uno") else { return };
    let script = "500 {\"type\":\"configure\",\"slot\":0,\"limit_mpa\":0.1\n600 {\"type\":\"configur\",\"slot\":0}\n\
                  700 \"type\":\"configure\",\"save\":true}\n"
        .to_owned();
    let lines = run("uno", &folder, &(script + &held(1_000, 4_000, 0.08) + "4500 !end\n"));
    assert!(of(&lines, &["configured"]).is_empty() && of(&lines, &["\"error\""]).is_empty());
    assert!((at(&lines, 4_500.0).0 - 0.08).abs() <= 1.3 * STEP_MPA, "{:?}", at(&lines, 4_500.0));
}

#[test]
fn the_lines_of_the_document_configure_six_whiskers() {
    const DOCUMENT: &str = include_str!("../../../boards/README.md");
    let Some(folder) = compiled("mega") else { return };
    let lines = DOCUMENT.split("```text\n").nth(1).and_then(|rest| rest.split("```").next()).expect("lines");
    let script: String =
        lines.lines().enumerate().map(|(index, line)| format!("{} {line}\n", 100 + 60 * index)).collect();
    let lines = run("mega", &folder, &(script + "1500 !restart\n2500 !end\n"));
    assert!(of(&lines, &["\"error\""]).is_empty(), "{:?}", of(&lines, &["\"error\""]));
    assert_eq!(of(&lines, &["\"SAVED\""]).len(), 1);
    assert!(of(&lines, &["\"hello\"", "\"whiskers\":6,\"configuration\":\"STORED\""]).len() == 1);
}

#[test]
fn regress_a_restart_in_the_middle_of_a_line_does_not_spoil_hello() {
    const RESTARTS: usize = 30;
    for board in ["uno", "mega"] {
        let Some(folder) = compiled(board) else { return };
        let script: String = (1..=RESTARTS).map(|index| format!("{} !restart\n", 397 * index)).collect();
        let lines = run(board, &folder, &(script + "12500 !end\n"));
        let cut = lines.iter().filter(|(_, _, line)| line.starts_with('{') && !line.ends_with('}')).count();
        assert!(cut >= RESTARTS / 4, "only {cut} lines were cut");
        let hello = |line: &&str| line.starts_with("{\"type\":\"hello\"") && line.ends_with('}');
        assert_eq!(of(&lines, &["hello"]).into_iter().filter(hello).count(), RESTARTS + 1, "{board}");
    }
}
