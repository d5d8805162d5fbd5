//! A driver on a bench: a gauge, a slide, and a chamber with valves or a regulator, which a test moves.

use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::{Arc, Condvar, Mutex};
use std::thread::JoinHandle;
use std::time::Duration;

use serde_json::{Value, json};

/// Time between two samples: the time limit of a read.
const TICK: Duration = Duration::from_millis(10);
/// Longest wait for something on the bench.
const LONG: Duration = Duration::from_secs(60);
/// The sensor at an empty chamber, MPa.
pub(crate) const ZERO_MPA: f64 = -0.000_37;
/// Change of a chamber in a tick: by the fill valve, by the regulator, and the part that the vent valve lets out.
const FILLED_MPA: f64 = 0.002;
const REGULATED_MPA: f64 = 0.000_5;
const VENTED: f64 = 0.1;

/// Lines of a driver of the bench.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Role {
    /// Strain with the way of a slide, and pressure.
    Board,
    /// Strain and pressure.
    Gauge,
    /// The way of the whisker's base.
    Stage,
}

/// The bench at a time.
#[derive(Debug)]
pub(crate) struct Bench {
    /// Change of the strain a millimetre, and the end of the converter.
    pub(crate) per_mm: f64,
    pub(crate) end: f64,
    /// The driver regulates, and knows no `valve`.
    pub(crate) regulates: bool,
    /// Step of the converter of the pressure, MPa, and whether no air comes.
    pub(crate) step_mpa: f64,
    pub(crate) is_shut: bool,
    pub(crate) base_mm: f64,
    /// Largest depth of a touch, with the tick at which it began.
    pub(crate) touch: Option<(f64, u64)>,
    pub(crate) pressure_mpa: f64,
    pub(crate) highest_mpa: f64,
    pub(crate) target_mpa: f64,
    /// Ticks for which a valve is still open.
    pub(crate) fill: u64,
    pub(crate) vent: u64,
    pub(crate) ticks: u64,
    /// Lines that the driver heard.
    pub(crate) heard: Vec<Value>,
}

impl Bench {
    pub(crate) fn new() -> Self {
        Self {
            per_mm: -0.004,
            end: 0.05,
            regulates: false,
            step_mpa: 0.0,
            is_shut: false,
            base_mm: 0.0,
            touch: None,
            pressure_mpa: 0.0,
            highest_mpa: 0.0,
            target_mpa: 0.0,
            fill: 0,
            vent: 0,
            ticks: 0,
            heard: Vec::new(),
        }
    }

    /// Begins a touch of a second and a half.
    pub(crate) fn touch(&mut self, depth_mm: f64) {
        self.touch = Some((depth_mm, self.ticks));
    }

    /// Whether the last touch is over, and its swing.
    pub(crate) fn is_free(&self) -> bool {
        self.touch.is_none_or(|(_, began)| self.ticks > began + 250)
    }

    /// Whether the chamber is empty, and both valves are closed.
    pub(crate) fn is_safe(&self) -> bool {
        self.fill == 0 && self.vent == 0 && self.pressure_mpa < 0.003
    }

    fn depth_mm(&self) -> f64 {
        let Some((depth_mm, began)) = self.touch else { return 0.0 };
        let at = (self.ticks - began) as f64;
        depth_mm * ((at - 30.0) / 40.0).min((180.0 - at) / 30.0).clamp(0.0, 1.0)
    }

    fn tick(&mut self) {
        self.ticks += 1;
        if self.regulates {
            let way_mpa = self.target_mpa - self.pressure_mpa;
            self.pressure_mpa += way_mpa.clamp(-REGULATED_MPA, REGULATED_MPA);
        }
        if self.fill > 0 {
            let filled_mpa = if self.is_shut { 0.0 } else { FILLED_MPA };
            (self.fill, self.pressure_mpa) = (self.fill - 1, self.pressure_mpa + filled_mpa);
        }
        if self.vent > 0 {
            (self.vent, self.pressure_mpa) = (self.vent - 1, self.pressure_mpa * (1.0 - VENTED));
        }
        self.highest_mpa = self.highest_mpa.max(self.pressure_mpa);
    }

    fn lines(&self, role: Role) -> Vec<Value> {
        let depth_mm = self.depth_mm();
        let way_mm = self.base_mm + depth_mm;
        if role == Role::Stage {
            return vec![json!({"type": "motion", "whisker": 0, "deflection_mm": way_mm})];
        }
        let noise = ((self.ticks * 7919) % 21) as f64 / 10.0 - 1.0;
        let strain = 0.001 + (self.per_mm * depth_mm + 1e-5 * noise).clamp(-self.end, self.end);
        let mut strain = json!({"type": "strain", "whisker": 0, "strain": strain});
        if role == Role::Board {
            strain["deflection_mm"] = json!(way_mm);
        }
        let mut lines = vec![strain];
        if self.ticks.is_multiple_of(5) {
            let mut pressure_mpa = self.pressure_mpa + ZERO_MPA;
            if self.step_mpa > 0.0 {
                pressure_mpa += 0.5 * self.step_mpa * noise;
                pressure_mpa = ((pressure_mpa / self.step_mpa).floor() + 0.5) * self.step_mpa;
            }
            lines.push(json!({"type": "pressure", "whisker": 0, "pressure_mpa": pressure_mpa}));
        }
        lines
    }

    fn hear(&mut self, line: Value) {
        match line["type"].as_str() {
            Some("set_pressure") => {
                self.target_mpa = (line["pressure_mpa"].as_f64().unwrap() - ZERO_MPA).max(0.0);
                if line["pressure_mpa"] == 0.0 {
                    self.target_mpa = 0.0;
                }
            }
            Some("valve") if !self.regulates => {
                let ticks = (line["for_ms"].as_f64().unwrap() / 10.0).ceil() as u64;
                (self.fill, self.vent) = match line["open"].as_str().unwrap() {
                    "FILL" => (ticks, 0),
                    "VENT" => (0, ticks),
                    _ => (0, 0),
                };
            }
            _ => {}
        }
        self.heard.push(line);
    }
}

/// The bench and its driver, which serves one connection after the other.
pub(crate) struct Driver {
    pub(crate) bench: Arc<(Mutex<Bench>, Condvar)>,
    pub(crate) address: String,
    _thread: JoinHandle<()>,
}

impl Driver {
    pub(crate) fn start(role: Role, bench: Bench) -> Self {
        Self::at(role, Arc::new((Mutex::new(bench), Condvar::new())))
    }

    /// Another driver of the same bench.
    pub(crate) fn beside(&self, role: Role) -> Self {
        Self::at(role, self.bench.clone())
    }

    fn at(role: Role, bench: Arc<(Mutex<Bench>, Condvar)>) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap().to_string();
        let shared = bench.clone();
        let thread = std::thread::spawn(move || {
            for stream in listener.incoming() {
                // The end of a connection is an error of its writer.
                let _ = serve(role, &stream.unwrap(), &shared);
            }
        });
        Self { bench, address, _thread: thread }
    }

    /// Changes the bench, and waits until its driver has said so.
    pub(crate) fn change(&self, change: impl FnOnce(&mut Bench)) {
        let mut bench = self.bench.0.lock().unwrap();
        change(&mut bench);
        let until = bench.ticks + 3;
        drop(bench);
        self.until(|bench| bench.ticks >= until);
    }

    /// Waits until the bench is like this.
    pub(crate) fn until(&self, is_so: impl Fn(&Bench) -> bool) {
        let (bench, ticked) = &*self.bench;
        let waited = ticked.wait_timeout_while(bench.lock().unwrap(), LONG, |bench| !is_so(bench)).unwrap();
        assert!(!waited.1.timed_out(), "{:?}", waited.0);
    }

    pub(crate) fn look<T>(&self, at: impl FnOnce(&Bench) -> T) -> T {
        at(&self.bench.0.lock().unwrap())
    }
}

fn serve(role: Role, mut stream: &TcpStream, shared: &(Mutex<Bench>, Condvar)) -> std::io::Result<()> {
    stream.set_read_timeout(Some(TICK))?;
    stream.set_nodelay(true)?;
    let (mut begun, mut buffer) = (Vec::new(), [0; 4096]);
    loop {
        match stream.read(&mut buffer) {
            Ok(0) => return Ok(()),
            Ok(read) => {
                begun.extend_from_slice(&buffer[..read]);
                while let Some(end) = begun.iter().position(|byte| *byte == b'\n') {
                    let line: Vec<u8> = begun.drain(..=end).collect();
                    shared.0.lock().unwrap().hear(serde_json::from_slice(&line).unwrap());
                }
                shared.1.notify_all();
            }
            Err(problem) if matches!(problem.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
                let lines = {
                    let mut bench = shared.0.lock().unwrap();
                    if role != Role::Stage {
                        bench.tick();
                    }
                    bench.lines(role)
                };
                for line in lines {
                    stream.write_all(format!("{line}\n").as_bytes())?;
                }
                shared.1.notify_all();
            }
            Err(problem) => return Err(problem),
        }
    }
}
