//! A desk: whiskers on a slide before their rods, their chambers and gauges at the pins of a board, and the agent
//! behind it.

use std::path::Path;

use vibrissa_core::mechanics::{Formulation, Model};
use vibrissa_core::units::{ContactRatio, Megapascal, Millimetre};
use vibrissa_evaluation::world::{Peer, START_US};
use vibrissa_protocol::{BootId, Contact, Message, Name, RobotTopic, decode};
use vibrissa_robot::agent::snapshot::Snapshot;
use vibrissa_robot::clock::RobotClock;
use vibrissa_robot::contract::{Moment, Now, Outgoing};
use vibrissa_robot::store::Stored;
use vibrissa_robot::{Agent, Config, Input, Output};
use vibrissa_simulator::scenario::Rubber;

use crate::microcontroller::Microcontroller;

/// Length of the whole whiskers and of a cut one, mm, and their nominal pressure, MPa.
pub(crate) const WHOLE_MM: f64 = 70.0;
pub(crate) const CUT_MM: f64 = 62.0;
pub(crate) const NOMINAL_MPA: f64 = 0.1;
/// The slide goes forwards in the first half of a cycle, and back in the second one. s, mm.
pub(crate) const CYCLE_S: f64 = 0.6;
const WAY_MM: f64 = 6.0;
/// Deflections at which the whiskers slip off their rods, mm.
const SLIP_MM: (f64, f64) = (1.6, 2.2);
/// Time in which a whisker that slipped off comes to rest, s.
const FREE_S: f64 = 0.01;
/// Travel of the slide's potentiometer, mm, and its way at the begin of a cycle.
const TRAVEL_MM: f64 = 40.0;
const BEGIN_MM: f64 = 8.0;
/// Time between two values of the pins, and between two exchanges of lines.
const PIN_MS: f64 = 2.0;
const STEP_US: u64 = 10_000;
/// Time at which the board is configured, ms: the begin of a cycle.
const CONFIGURED_MS: f64 = 3_000.0;
/// Pause of the agent's program after each line to a serial device.
const LINE_MS: f64 = 20.0;
/// Noise of an amplifier in V, and of a converter in strain: more than a step.
const NOISE_V: f64 = 0.006;
const NOISE_STRAIN: f64 = 8e-6;

/// Gauge of a whisker, and its pins.
#[derive(Debug, Clone, Copy)]
enum Sensor {
    Analog(u8),
    Hx711 { device: u8, data: u8 },
    Ads1115(u8),
}

/// A whisker as it is wired.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Wired {
    /// 1, or -1 if a touch lowers the strain.
    pub(crate) polarity: f64,
    /// `strain_per_v` of its amplifier.
    pub(crate) strain_per_v: f64,
}

/// How the agent meets its board.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Begin {
    /// `uno` or `mega`.
    pub(crate) board: &'static str,
    /// Part of a cycle of the slide at which the agent starts, from 0 to 1. The first whisker is touched from 0.03 to 0.18.
    pub(crate) phase: f64,
    /// Time for which the slide stands still then, s.
    pub(crate) hold_s: f64,
    /// Time for which no line of the board arrives then, s.
    pub(crate) gap_s: f64,
    /// Whether somebody has calibrated the board: the agent knows the way in which touches move the strain.
    pub(crate) is_calibrated: bool,
}

impl Begin {
    /// An agent that starts in a phase of the touches.
    pub(crate) fn at(board: &'static str, phase: f64) -> Self {
        Self { board, phase, hold_s: 0.0, gap_s: 0.0, is_calibrated: true }
    }
}

/// A whisker.
struct Whisker {
    wired: Wired,
    sensor: Sensor,
    /// Way of the slide at which it meets its rod, mm.
    meets_mm: f64,
    length_mm: f64,
    /// Distance of the rod from the base, mm. A whisker that is shorter passes it.
    rod_mm: f64,
    model: Model,
}

/// The robot on the desk.
pub(crate) struct Desk {
    fleet: Name,
    name: Name,
    board: Microcontroller,
    agent: Agent,
    clock: RobotClock,
    /// By how much the system's clock was set, in microseconds.
    pub(crate) clock_step_us: i64,
    now_us: u64,
    /// Time of the board at the agent's start, ms.
    started_ms: f64,
    /// Time for which the slide stands still then, ms.
    hold_ms: f64,
    /// Until when no line of the board arrives.
    gap_until_us: u64,
    /// Time from which on the next line may go to the board, ms.
    line_ms: f64,
    /// Analog input of the slide.
    slide: u8,
    whiskers: Vec<Whisker>,
    /// True pressures of the chambers, MPa.
    pub(crate) pressures_mpa: Vec<f64>,
    /// The lowest ones since all chambers were filled for the first time.
    pub(crate) lowest_mpa: Option<Vec<f64>>,
    pub(crate) contacts: Vec<Contact>,
    pub(crate) warnings: Vec<String>,
    /// Times that the agent gave the board up.
    pub(crate) restarts: usize,
}

/// Pins of a whisker: fill, vent, pressure, and its gauge.
fn layout(board: &str, count: usize) -> Vec<([u8; 3], Sensor)> {
    let (fill, vent) = ([4, 6, 8, 10, 22, 24], [5, 7, 9, 11, 23, 25]);
    let pressure = if board == "uno" { [0, 3, 0, 0, 0, 0] } else { [0, 1, 2, 3, 4, 5] };
    let few = if board == "uno" { [1, 4, 0] } else { [3, 4, 5] };
    let many = [
        Sensor::Analog(8),
        Sensor::Hx711 { device: 0, data: 30 },
        Sensor::Hx711 { device: 1, data: 32 },
        Sensor::Ads1115(0),
        Sensor::Analog(9),
        Sensor::Analog(10),
    ];
    let sensor = |at: usize| if count > 3 { many[at] } else { Sensor::Analog(few[at]) };
    (0..count).map(|at| ([fill[at], vent[at], pressure[at]], sensor(at))).collect()
}

/// A number from -1 to 1 that looks random.
fn noise(index: u64) -> f64 {
    let mixed = (index ^ (index >> 7)).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40;
    mixed as f64 / f64::from(1 << 23) - 1.0
}

impl Desk {
    /// Wires and configures a board. None if a program is missing.
    pub(crate) fn wire(wired: &[Wired], begin: Begin) -> Option<Self> {
        let kind = begin.board;
        let mut board = Microcontroller::start(kind)?;
        let layout = layout(kind, wired.len());
        configure(&mut board, kind, wired, &layout);
        let config = Config::from_toml_str(&agent_toml(wired, begin.is_calibrated), Path::new("")).unwrap();
        let now = Now::of_us(START_US);
        let (agent, _) = Agent::new(&config, BootId::new("b1").unwrap(), Stored::default(), now);
        let whisker = |(at, (wired, &(_, sensor))): (usize, (&Wired, &([u8; 3], Sensor)))| Whisker {
            wired: *wired,
            sensor,
            meets_mm: 0.4 + 0.4 * at as f64,
            length_mm: WHOLE_MM,
            rod_mm: WHOLE_MM,
            model: Rubber { c: 1.03, ..Rubber::default() }.model(&Model::nguyen_2021(Formulation::Consistent)).unwrap(),
        };
        let mut desk = Self {
            fleet: config.fleet.clone(),
            name: config.robot.clone(),
            board,
            agent,
            clock: RobotClock::new(now.at, START_US),
            clock_step_us: 0,
            now_us: START_US,
            started_ms: CONFIGURED_MS + begin.phase * CYCLE_S * 1e3,
            hold_ms: begin.hold_s * 1e3,
            gap_until_us: START_US + (begin.gap_s * 1e6) as u64,
            line_ms: 0.0,
            slide: if kind == "uno" { 2 } else { 6 },
            whiskers: wired.iter().zip(&layout).enumerate().map(whisker).collect(),
            pressures_mpa: vec![0.0; wired.len()],
            lowest_mpa: None,
            contacts: Vec::new(),
            warnings: Vec::new(),
            restarts: 0,
        };
        let mut ms = 0.0;
        while ms < desk.started_ms {
            desk.move_pins(ms);
            ms += PIN_MS;
        }
        desk.board.run_to(desk.started_ms);
        Some(desk)
    }

    /// Cuts a whisker, which then passes its rod.
    pub(crate) fn cut(&mut self, at: usize) {
        self.whiskers[at].length_mm = CUT_MM;
    }

    /// Moves the rod of a whisker to its tip.
    pub(crate) fn move_rod(&mut self, at: usize) {
        self.whiskers[at].rod_mm = self.whiskers[at].length_mm;
    }

    /// Loses the lines of the board for a time.
    pub(crate) fn lose_lines(&mut self, seconds: f64) {
        self.gap_until_us = self.now_us + (seconds * 1e6) as u64;
    }

    /// Restarts the board, as a fault of its supply would.
    pub(crate) fn restart_board(&mut self) {
        self.board.at(self.board_ms(), "!restart");
    }

    /// What `vibrissa-robot monitor` shows.
    pub(crate) fn snapshot(&mut self) -> Snapshot {
        let now = self.now();
        self.agent.snapshot(now)
    }

    /// Strain per mm of a touch at the tip, of a whisker of this length at this pressure.
    pub(crate) fn per_mm(&self, at: usize, length_mm: f64, mpa: f64) -> f64 {
        let model = &self.whiskers[at].model;
        let morphology = model.morphology(Megapascal::known(mpa.clamp(0.0, 0.2)));
        model.sensitivity_per_mm(ContactRatio::TIP, Millimetre::known(length_mm), &morphology).unwrap()
    }

    fn board_ms(&self) -> f64 {
        self.started_ms + (self.now_us - START_US) as f64 / 1e3
    }

    fn now(&mut self) -> Now {
        self.clock.now(Moment::of_us(self.now_us), self.now_us.saturating_add_signed(self.clock_step_us))
    }

    /// Sets the voltages of gauges and slide at a time of the board.
    fn move_pins(&mut self, ms: f64) {
        // The slide stands still for a time after the agent's start.
        let moved_ms = ms.min(self.started_ms).max(ms - self.hold_ms);
        let cycles = moved_ms / 1e3 / CYCLE_S;
        let (cycle, part) = (cycles.floor(), cycles.fract());
        let is_forth = part < 0.5;
        let way_mm = 2.0 * WAY_MM * if is_forth { part } else { 1.0 - part };
        let slip_mm = SLIP_MM.0 + (SLIP_MM.1 - SLIP_MM.0) * 0.5 * (1.0 + noise(cycle as u64));
        let (slide, mm) = (self.slide, BEGIN_MM + way_mm);
        self.board.at(ms, &format!("!volts {slide} {:.4}", 5.0 * mm / TRAVEL_MM));
        for at in 0..self.whiskers.len() {
            let one = &self.whiskers[at];
            let beyond_mm = way_mm - one.meets_mm;
            let free_mm = FREE_S * 2.0 * WAY_MM / CYCLE_S;
            // Somebody lifts the rods on the way back.
            let deflection_mm = if !is_forth || beyond_mm < 0.0 || one.rod_mm > one.length_mm {
                0.0
            } else if beyond_mm <= slip_mm {
                beyond_mm
            } else {
                slip_mm * (1.0 - (beyond_mm - slip_mm) / free_mm).max(0.0)
            };
            let strain = one.wired.polarity * deflection_mm * self.per_mm(at, one.length_mm, self.pressures_mpa[at]);
            let random = noise((ms / PIN_MS) as u64 * 8 + at as u64);
            let order = match one.sensor {
                Sensor::Analog(pin) => {
                    let volts = 2.5 + strain / one.wired.strain_per_v + NOISE_V * random;
                    format!("!volts {pin} {:.4}", volts.clamp(0.0, 5.0))
                }
                Sensor::Hx711 { device, .. } => {
                    format!("!bridge {device} {:.7}", (strain + NOISE_STRAIN * random) / 0.4)
                }
                Sensor::Ads1115(input) => {
                    let volts = 2.0 + (strain + NOISE_STRAIN * random) / one.wired.strain_per_v;
                    format!("!input 0 {input} {:.5}", volts.clamp(0.0, 5.0))
                }
            };
            self.board.at(ms, &order);
        }
    }

    /// The next 10 ms.
    fn step(&mut self, said: &mut Vec<Outgoing>) {
        let from_ms = self.board_ms();
        let pins = (STEP_US as f64 / 1e3 / PIN_MS) as u64;
        (0..pins).for_each(|pin| self.move_pins(from_ms + pin as f64 * PIN_MS));
        self.now_us += STEP_US;
        let (lines, pressures_mpa) = self.board.run_to(self.board_ms());
        self.pressures_mpa.copy_from_slice(&pressures_mpa[..self.whiskers.len()]);
        let is_filled = self.pressures_mpa.iter().all(|mpa| *mpa > 0.9 * NOMINAL_MPA);
        if self.lowest_mpa.is_none() && is_filled {
            self.lowest_mpa = Some(self.pressures_mpa.clone());
        }
        if let Some(lowest_mpa) = &mut self.lowest_mpa {
            lowest_mpa.iter_mut().zip(&self.pressures_mpa).for_each(|(lowest, mpa)| *lowest = lowest.min(*mpa));
        }
        let is_lost = self.now_us <= self.gap_until_us;
        for line in lines.into_iter().filter(|_| !is_lost) {
            self.input(Input::Line(0, Some(line.as_bytes())), said);
        }
        if self.agent.next_deadline() <= Moment::of_us(self.now_us) {
            self.input(Input::Tick, said);
        }
    }

    fn input(&mut self, input: Input<'_>, said: &mut Vec<Outgoing>) {
        let now = self.now();
        for output in self.agent.step(now, input) {
            match output {
                Output::Publish(topic, payload) => {
                    if let Ok(Message::Contacts(message)) = decode(&topic.of(&self.fleet, &self.name), &payload) {
                        self.contacts.extend(message.contacts);
                    }
                    said.push(Outgoing::Publish { topic, payload });
                }
                Output::Tell(_, line) => {
                    let (ms, line) = (self.line_ms.max(self.board_ms()), String::from_utf8(line.line()).unwrap());
                    self.board.at(ms, line.trim_end());
                    self.line_ms = ms + LINE_MS;
                }
                Output::Warn(text) => self.warnings.push(text),
                Output::RestartDriver(_, why) => {
                    self.warnings.push(why);
                    self.restarts += 1;
                }
                Output::Reconnect => said.push(Outgoing::Restart),
                Output::Store(_) => {}
                other @ (Output::Spool(_) | Output::TakeBack) => panic!("no disk is configured: {other:?}"),
            }
        }
    }
}

impl Peer for Desk {
    fn fleet(&self) -> &Name {
        &self.fleet
    }

    fn name(&self) -> &Name {
        &self.name
    }

    fn connected(&mut self, _: u64) -> Vec<Outgoing> {
        let mut said = Vec::new();
        self.input(Input::Connected, &mut said);
        self.input(Input::DriverStarted(0), &mut said);
        said
    }

    fn next_deadline(&self) -> u64 {
        self.now_us + STEP_US
    }

    fn poll(&mut self, now_us: u64) -> Vec<Outgoing> {
        let mut said = Vec::new();
        while self.now_us + STEP_US <= now_us {
            self.step(&mut said);
        }
        said
    }

    fn receive(&mut self, topic: RobotTopic, payload: &[u8], _: u64) -> Vec<Outgoing> {
        let mut said = Vec::new();
        self.input(Input::Message(topic, payload), &mut said);
        said
    }
}

/// `agent.toml` as in docs/first-robot.md, with the sign that `vibrissa-robot calibrate` writes.
fn agent_toml(wired: &[Wired], is_calibrated: bool) -> String {
    let mut text = "fleet = \"desk\"\nrobot = \"first\"\non_supervisor_loss = \"HOLD\"\n[broker]\n\
                    url = \"mqtt://127.0.0.1:1883\"\n[driver]\nserial = \"board\"\n[[arrays]]\narray = \"nose\"\n\
                    type = \"TYPE_2\"\n"
        .to_owned();
    for (number, one) in wired.iter().enumerate() {
        let sign = if one.polarity > 0.0 { "RISES" } else { "FALLS" };
        let sign = if is_calibrated { format!("segmenter.sign = \"{sign}\"\n") } else { String::new() };
        text += &format!(
            "[[arrays.whiskers]]\nwhisker = {number}\nlength_mm = {WHOLE_MM:.1}\npressure_mpa = {NOMINAL_MPA}\n\
             pressure_max_mpa = 0.2\nplace = \"TIP\"\n{sign}"
        );
    }
    text
}

/// Wires the simulated pins, and sends the lines of robot/boards/README.md.
fn configure(board: &mut Microcontroller, kind: &str, wired: &[Wired], layout: &[([u8; 3], Sensor)]) {
    let slide = if kind == "uno" { "A2" } else { "A6" };
    for (slot, (one, ([fill, vent, pressure], sensor))) in wired.iter().zip(layout).enumerate() {
        board.at(10.0, &format!("!chamber {slot} {fill} {vent} {pressure}"));
        let keys = |ms: f64, keys: &str| {
            let line = format!(r#"{{"type":"configure","slot":{slot},{keys}}}"#);
            assert!(line.len() < 200, "{line}");
            // A person waits for the answer before the next line.
            (ms + 80.0 * slot as f64, line)
        };
        let per_v = one.strain_per_v;
        let gauge = match sensor {
            Sensor::Analog(pin) => {
                format!(r#""strain_sensor":"ANALOG","strain_pin":"A{pin}","strain_zero_v":2.5,"strain_per_v":{per_v}"#)
            }
            Sensor::Hx711 { device, data } => {
                let clock = data + 1;
                board.at(10.0, &format!("!hx711 {device} {data} {clock} 80"));
                let pins = format!(r#""strain_sensor":"HX711","data_pin":{data},"clock_pin":{clock},"gain":64"#);
                format!(r#"{pins},"strain_zero_v":0,"strain_per_v":0.4"#)
            }
            Sensor::Ads1115(input) => {
                let pins = format!(r#""strain_sensor":"ADS1115","inputs":"{input}""#);
                format!(r#"{pins},"strain_zero_v":2,"strain_per_v":{per_v}"#)
            }
        };
        let named = format!(r#""array":"nose","whisker":{slot},"fill_pin":{fill},"vent_pin":{vent}"#);
        let lines = [
            keys(200.0, &format!(r#"{named},"pressure_pin":"A{pressure}""#)),
            keys(750.0, &gauge),
            keys(1_300.0, &format!(r#""slide_pin":"{slide}","slide_mm":{TRAVEL_MM}"#)),
        ];
        lines.iter().for_each(|(ms, line)| board.at(*ms, line));
    }
    if layout.iter().any(|(_, sensor)| matches!(sensor, Sensor::Ads1115(_))) {
        board.at(10.0, "!ads1115 0 72");
    }
    if wired.len() > 2 {
        board.at(1_850.0, r#"{"type":"configure","baud":250000}"#);
    }
    board.at(1_950.0, r#"{"type":"configure","save":true}"#);
}
