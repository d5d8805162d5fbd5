//! The board on pins that a test reads and a chamber that it simulates.

use std::cell::Cell;
use std::convert::Infallible;
use std::rc::Rc;

use embedded_hal::digital::{ErrorType, OutputPin};
use vibrissa_board::{Board, Lines, Readings};

const STEP_MPA: f32 = 5.0 / 4096.0 / 4.0;

#[derive(Clone, Default)]
struct Pin(Rc<Cell<bool>>);

impl ErrorType for Pin {
    type Error = Infallible;
}

impl OutputPin for Pin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.0.set(false);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.0.set(true);
        Ok(())
    }
}

struct Bench {
    board: Board<Pin, Pin>,
    fill: Pin,
    vent: Pin,
    lines: Lines<512>,
    said: String,
    now_us: u64,
    mpa: f32,
    strain: f32,
    strain_at_end: bool,
    way_mm: Option<f32>,
    /// Most bytes that somebody takes at once.
    takes: usize,
}

impl Bench {
    fn new() -> Bench {
        let (fill, vent) = (Pin::default(), Pin::default());
        let board = Board::new(fill.clone(), vent.clone(), "left", 1, 0.2).unwrap();
        Bench {
            board,
            fill,
            vent,
            lines: Lines::default(),
            said: String::new(),
            now_us: 0,
            mpa: 0.0,
            strain: 0.000_1,
            strain_at_end: false,
            way_mm: None,
            takes: usize::MAX,
        }
    }

    fn say(&mut self, line: &str) {
        for byte in line.bytes().chain([b'\n']) {
            self.board.receive(self.now_us, byte);
        }
    }

    fn run(&mut self, seconds: f32) {
        for _ in 0..(seconds * 1000.0) as u32 {
            self.now_us += 1_000;
            assert!(!(self.fill.0.get() && self.vent.0.get()), "both valves are open");
            if self.fill.0.get() {
                self.mpa += (0.25 - self.mpa) * 0.001;
            }
            if self.vent.0.get() {
                self.mpa -= self.mpa * 0.001;
            }
            let pressure_mpa = ((self.mpa / STEP_MPA).floor() + 0.5) * STEP_MPA;
            let (strain, strain_at_end) = (self.strain, self.strain_at_end);
            let readings =
                Readings { pressure_mpa, supply_mpa: None, strain, strain_at_end, deflection_mm: self.way_mm };
            self.board.step(self.now_us, readings, &mut self.lines).unwrap();
            let waiting = self.lines.waiting();
            let taken = waiting.len().min(self.takes);
            self.said.push_str(std::str::from_utf8(&waiting[..taken]).unwrap());
            self.lines.sent(taken);
        }
    }
}

#[test]
fn it_says_hello_and_reports_at_its_rates() {
    let mut bench = Bench::new();
    bench.run(2.0);
    let lines: Vec<&str> = bench.said.lines().collect();
    assert_eq!(lines[0], "", "ends a line that a restart has cut");
    assert_eq!(lines[1], "{\"type\":\"hello\",\"version\":1,\"name\":\"vibrissa-board\"}");
    assert!((8..=9).contains(&lines.iter().filter(|line| line.contains("\"type\":\"pressure\"")).count()));
    let strains: Vec<&&str> = lines.iter().filter(|line| line.contains("\"type\":\"strain\"")).collect();
    assert!((19..=20).contains(&strains.len()), "{}", strains.len());
    assert!(strains[0].ends_with("\"every_us\":10000,\"strain\":[0.000100,0.000100,0.000100,0.000100,0.000100,0.000100,0.000100,0.000100,0.000100,0.000100]}"));
}

#[test]
fn it_holds_a_setpoint_and_vents_when_the_lines_stop() {
    let mut bench = Bench::new();
    for _ in 0..5 {
        bench
            .say(r#"{ "type" : "set_pressure", "array":"left","whisker":1,"pressure_mpa":0.08,"slew_mpa_per_s":0.05}"#);
        bench.run(2.0);
    }
    assert!((bench.mpa - 0.08).abs() < 0.001_22, "{}", bench.mpa);
    bench.run(2.9);
    assert!((bench.mpa - 0.08).abs() < 0.001_22, "it vents too early: {}", bench.mpa);
    bench.run(10.0);
    assert!(bench.mpa < 0.002, "{}", bench.mpa);
}

#[test]
fn regress_lines_that_are_no_orders_for_it_do_not_keep_it_from_venting() {
    for line in [
        r#"{"type":"estimate","array":"left","whisker":1,"length_mm":60.2}"#,
        r#"{"type":"hello","version":1,"whiskers":[]}"#,
        r#"{"type":"set_pressure","array":"left","whisker":2,"pressure_mpa":0.08}"#,
        r#"{"type":"set_pressure","array":"left","whisker":1,"pressure_mpa":0.9}"#,
        r#"{"type":"set_pressure","array":"left","whisker":1,"pressure_mpa":0.0"#,
        r#"{"type":"valve","array":"left","whisker":1,"open":"AJAR","for_ms":10}"#,
        r#"{"type":"pressure","whisker":1,"pressure_mpa":0.08}"#,
        &"x".repeat(1_000),
    ] {
        let mut bench = Bench::new();
        for _ in 0..3 {
            bench
                .say(r#"{"type":"set_pressure","array":"left","whisker":1,"pressure_mpa":0.08,"slew_mpa_per_s":0.05}"#);
            bench.run(2.0);
        }
        for _ in 0..13 {
            bench.say(line);
            bench.run(1.0);
        }
        assert!(bench.mpa < 0.002, "{line}: {}", bench.mpa);
    }
}

#[test]
fn regress_an_order_above_the_limit_by_the_zero_of_the_sensor_is_obeyed_as_the_limit() {
    let mut bench = Bench::new();
    let mut highest_mpa = 0.0f32;
    for _ in 0..10 {
        bench.say(r#"{"type":"set_pressure","array":"left","whisker":1,"pressure_mpa":0.2008,"slew_mpa_per_s":0}"#);
        bench.run(2.0);
        highest_mpa = highest_mpa.max(bench.mpa);
    }
    assert!((bench.mpa - 0.2).abs() < 0.001_22 && highest_mpa < 0.2 + 0.001_22, "{} {highest_mpa}", bench.mpa);
}

#[test]
fn it_ignores_what_is_wrong_or_for_others() {
    let mut bench = Bench::new();
    bench.run(0.5);
    for line in [
        r#"{"type":"set_pressure","pressure_mpa":0.9}"#,
        r#"{"type":"set_pressure","pressure_mpa":"0.1"}"#,
        r#"{"type":"set_pressure","pressure_mpa":NaN}"#,
        r#"{"type":"set_pressure","whisker":2,"pressure_mpa":0.1}"#,
        r#"{"type":"set_pressure","array":"right","pressure_mpa":0.1}"#,
        r#"{"type":"valve","open":"FILL","for_ms":1001}"#,
        r#"{"pressure_mpa":0.1}"#,
        "\u{fffd}",
        "",
    ] {
        bench.say(line);
        bench.run(0.2);
        assert!(bench.mpa == 0.0, "{line}");
    }
    bench.say(&"x".repeat(1_000));
    bench.say(r#"{"type":"valve","open":"FILL","for_ms":50}"#);
    bench.run(0.2);
    assert!((bench.mpa - 0.0122).abs() < 0.0005, "a line after one that is too long is read: {}", bench.mpa);
}

#[test]
fn a_strain_that_cannot_be_read_is_left_out() {
    let mut bench = Bench::new();
    bench.strain = f32::NAN;
    bench.run(0.3);
    assert!(!bench.said.contains("\"strain\""), "{}", bench.said);
    bench.strain = 0.000_1;
    bench.run(0.3);
    assert!(bench.said.contains("\"strain\":[0.000100") && !bench.said.contains("NaN"), "{}", bench.said);
}

#[test]
fn regress_no_line_has_samples_from_before_and_after_a_gap() {
    for is_away in [false, true] {
        let mut bench = Bench::new();
        bench.run(0.3);
        bench.strain = 0.000_2;
        bench.run(0.055);
        if is_away {
            bench.now_us += 1_000_000;
        } else {
            bench.strain = f32::NAN;
            bench.run(1.0);
        }
        bench.strain = 0.000_3;
        bench.run(0.3);
        let begun_ms = bench.now_us / 1000 - 300;
        let lines: Vec<&str> = bench.said.lines().filter(|line| line.contains("0.000300")).collect();
        assert!((2..=3).contains(&lines.len()), "{lines:?}");
        assert!(lines.iter().all(|line| !line.contains("0.000200")), "{lines:?}");
        // The samples are 10 ms apart from the first one on.
        for (index, line) in lines.iter().enumerate() {
            let ms = line.split("\"t_ms\":").nth(1).and_then(|rest| rest.split(',').next()).unwrap();
            let late_ms = ms.parse::<u64>().unwrap() - begun_ms - 100 * index as u64;
            assert!(late_ms <= 2, "{late_ms} ms: {lines:?}");
        }
    }
}

#[test]
fn the_way_of_a_slide_is_in_the_lines_of_strain() {
    let mut bench = Bench::new();
    bench.run(0.3);
    assert!(bench.said.contains("\"strain\"") && !bench.said.contains("deflection_mm"), "{}", bench.said);
    bench.way_mm = Some(-3.456);
    bench.run(0.3);
    assert!(
        bench.said.contains("],\"deflection_mm\":[-3.46,-3.46,-3.46,-3.46,-3.46,-3.46,-3.46,-3.46,-3.46,-3.46]}"),
        "{}",
        bench.said
    );
    bench.way_mm = Some(f32::NAN);
    bench.said.clear();
    bench.run(0.5);
    assert!(!bench.said.contains("\"strain\"") && !bench.said.contains("NaN"), "{}", bench.said);
}

#[test]
fn regress_an_order_above_the_limit_is_refused_with_a_reason() {
    let mut bench = Bench::new();
    for (mpa, answers) in [("0.2100", 0), ("0.2200", 1), ("0.9", 2)] {
        bench.say(&format!(r#"{{"type":"set_pressure","array":"left","whisker":1,"pressure_mpa":{mpa}}}"#));
        bench.run(1.0);
        let refusals =
            bench.said.matches(r#"{"type":"error","array":"left","whisker":1,"problem":"the pressure is above "#);
        assert_eq!(refusals.count(), answers, "{mpa}");
    }
}

#[test]
fn regress_the_condition_of_the_gauge_is_told_repeated_and_taken_back() {
    let faults = |bench: &mut Bench, seconds: f32| {
        bench.said.clear();
        bench.run(seconds);
        let faults = bench.said.lines().filter(|line| line.contains("\"type\":\"fault\""));
        faults.map(|line| line.split("\"gauge\":").nth(1).unwrap().to_owned()).collect::<Vec<_>>()
    };
    let mut bench = Bench::new();
    assert_eq!(faults(&mut bench, 3.0), [""; 0]);
    bench.strain_at_end = true;
    assert_eq!(faults(&mut bench, 4.1), ["\"SATURATED\"}"; 3]);
    bench.strain = f32::NAN;
    assert_eq!(faults(&mut bench, 2.1), ["\"OPEN\"}"; 2]);
    (bench.strain, bench.strain_at_end) = (0.000_1, false);
    assert_eq!(faults(&mut bench, 9.8).last().unwrap(), "\"OPEN\"}");
    assert_eq!(faults(&mut bench, 0.4).last().unwrap(), "\"OK\"}");
    assert_eq!(faults(&mut bench, 5.0), [""; 0]);
    // A single reading, of which no sample is sent.
    bench.strain_at_end = true;
    bench.run(0.001);
    bench.strain_at_end = false;
    assert_eq!(bench.said.lines().last().unwrap().split("\"gauge\":").nth(1), Some("\"SATURATED\"}"), "{}", bench.said);
}

#[test]
fn regress_who_comes_late_hears_no_old_lines() {
    for takes in [0, 3] {
        let mut bench = Bench::new();
        bench.takes = takes;
        bench.run(0.001);
        bench.takes = 0;
        bench.run(60.0);
        bench.takes = usize::MAX;
        let begun_ms = bench.now_us / 1000;
        bench.run(1.0);
        let mut lines = bench.said.lines();
        if takes > 0 {
            let cut = lines.by_ref().take(2).collect::<Vec<_>>();
            assert_eq!(cut, ["", "{\""], "the line that was cut ends");
        }
        let hello = lines.by_ref().find(|line| !line.is_empty()).unwrap();
        assert!(hello.contains("\"type\":\"hello\""), "{hello}");
        for line in lines {
            assert!(line.starts_with("{\"type\":") && line.ends_with('}'), "{line}");
            let ms: u64 = line.split("\"t_ms\":").nth(1).unwrap().split(',').next().unwrap().parse().unwrap();
            assert!(ms + 700 >= begun_ms, "{ms} {begun_ms}: {line}");
        }
    }
}
