//! The program: a driver on standard input and output, and a ROS 2 node.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::process::ExitCode;
use std::sync::mpsc::{RecvTimeoutError, SyncSender, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

use clap::{Parser, ValueEnum};
use ros2_client::builtin_interfaces::Time;
use vibrissa_ros2::bridge::{Bridge, Input, Output, Settings};
use vibrissa_ros2::log::Limited;
use vibrissa_ros2::names::topics;
use vibrissa_ros2::node::{NodeScope, RosNode};
use vibrissa_ros2::units::Pressures;
use vibrissa_ros2::words::{LINE_MAX, ToAgent};

/// Inputs that wait; beyond that, messages from ROS are shed.
const WAITING_MAX: usize = 1024;
const TICK: Duration = Duration::from_millis(50);
/// Greatest domain whose ports fit: 7400 + 250 x domain.
const DOMAIN_MAX: i64 = 232;

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Meaning {
    /// As sensor_msgs/FluidPressure defines it.
    Absolute,
    /// Above the atmosphere.
    Gauge,
}

/// A driver of the agent vibrissa-robot that is a ROS 2 node: contacts and pressures in, setpoints and health out
#[derive(Debug, Parser)]
#[command(version)]
struct Arguments {
    /// Meaning of pressures in ROS messages, readings and setpoints; there is no default, because a mistake is 0.1 MPa
    #[arg(long, value_enum)]
    pressures: Meaning,
    /// Pressure of the atmosphere, Pa, for absolute pressures
    #[arg(long, default_value_t = 101_325.0, value_parser = atmosphere)]
    atmosphere_pa: f64,
    /// Namespace of the node and its topics
    #[arg(long, default_value = "/vibrissa")]
    namespace: String,
    /// Name of the robot in /diagnostics
    #[arg(long, default_value = "")]
    robot: String,
    /// Domain of ROS
    #[arg(long, env = "ROS_DOMAIN_ID", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=DOMAIN_MAX))]
    domain: u16,
    /// Reach only programs of this machine; the same with ROS_LOCALHOST_ONLY=1, or ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST
    #[arg(long)]
    localhost: bool,
}

fn atmosphere(text: &str) -> Result<f64, String> {
    let pa: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if (30_000.0..=120_000.0).contains(&pa) { Ok(pa) } else { Err("must be 30000 to 120000 Pa".to_owned()) }
}

fn is_local(arguments: &Arguments) -> bool {
    let is = |name: &str, value: &str| std::env::var(name).is_ok_and(|given| given == value);
    arguments.localhost || is("ROS_LOCALHOST_ONLY", "1") || is("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
}

/// Reads lines of the agent until it closes the pipe. A line that is too long is refused, and the next one is read.
fn read_lines(inputs: &SyncSender<Input>) {
    let mut reader = BufReader::new(io::stdin().lock());
    loop {
        let mut bytes = Vec::new();
        let got = reader.by_ref().take(LINE_MAX as u64 + 1).read_until(b'\n', &mut bytes);
        if !got.is_ok_and(|count| count > 0) {
            return;
        }
        let is_whole = bytes.ends_with(b"\n");
        if !is_whole && bytes.len() > LINE_MAX && reader.skip_until(b'\n').is_err() {
            return;
        }
        let line = String::from_utf8(bytes).map_err(|_| "the agent sent a line that is not UTF-8".to_owned());
        if inputs.send(Input::Line(line)).is_err() {
            return;
        }
    }
}

fn say(line: &ToAgent) -> Result<(), String> {
    let mut text = serde_json::to_string(line).map_err(|problem| problem.to_string())?;
    text.push('\n');
    let mut output = io::stdout().lock();
    output
        .write_all(text.as_bytes())
        .and_then(|()| output.flush())
        .map_err(|problem| format!("the agent is gone: {problem}"))
}

fn run(arguments: &Arguments) -> Result<(), String> {
    let pressures = match arguments.pressures {
        Meaning::Absolute => Pressures::Absolute(arguments.atmosphere_pa),
        Meaning::Gauge => Pressures::Gauge,
    };
    let (inputs, receive) = sync_channel(WAITING_MAX);
    let place =
        NodeScope { domain: arguments.domain, is_local: is_local(arguments), namespace: arguments.namespace.clone() };
    let mut node = RosNode::join(&place, inputs.clone())?;
    let (ended, has_ended) = sync_channel::<()>(1);
    thread::spawn(move || {
        read_lines(&inputs);
        drop(ended);
    });
    let (mut bridge, hello) = Bridge::new(Settings { robot: arguments.robot.clone(), pressures });
    let mut outputs = vec![hello];
    let (begun, mut limited) = (Instant::now(), Limited::default());
    let mut ticked_at = begun;
    loop {
        let now_s = begun.elapsed().as_secs_f64();
        for output in outputs.drain(..) {
            match output {
                Output::Line(line) => say(&line)?,
                Output::Open(whiskers) => node.open(&topics(&arguments.namespace, &whiskers)?)?,
                // A subscriber that does not confirm must not stop the others.
                Output::Setpoint(index, setpoint) => log(&mut limited, now_s, node.publish_setpoint(index, setpoint)),
                Output::ReadingGain(index, factor) => log(&mut limited, now_s, node.publish_gain(index, factor)),
                Output::Report(report) => log(&mut limited, now_s, node.publish_report(report)),
                Output::Log(problem) => log(&mut limited, now_s, Err(problem)),
                Output::Stop(reason) => return Err(reason),
            }
        }
        if has_ended.try_recv() == Err(std::sync::mpsc::TryRecvError::Disconnected) {
            return Ok(());
        }
        let input = match receive.recv_timeout(TICK.saturating_sub(ticked_at.elapsed())) {
            Ok(input) => input,
            Err(RecvTimeoutError::Timeout) => Input::Tick,
            Err(RecvTimeoutError::Disconnected) => return Ok(()),
        };
        outputs = bridge.step(begun.elapsed().as_secs_f64(), Time::now(), input);
        if ticked_at.elapsed() >= TICK {
            ticked_at = Instant::now();
            let now_s = begun.elapsed().as_secs_f64();
            outputs.extend(bridge.step(now_s, Time::now(), Input::Shed(node.take_shed())));
            outputs.extend(bridge.step(now_s, Time::now(), Input::Tick));
        }
    }
}

/// Logs a problem, which appears in the agent's log.
fn log(limited: &mut Limited, now_s: f64, done: Result<(), String>) {
    if let Some(line) = done.err().and_then(|problem| limited.line(now_s, &problem)) {
        eprintln!("vibrissa-ros2: {line}");
    }
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            eprintln!("vibrissa-ros2: {problem}");
            ExitCode::FAILURE
        }
    }
}
