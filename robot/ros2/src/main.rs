//! The program: for the agent a driver, on standard input and output or on a socket; for ROS 2 a node.

use std::process::ExitCode;
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::time::{Duration, Instant};

use clap::Parser;
use ros2_client::builtin_interfaces::Time;
use vibrissa_ros2::actions::TouchTestServer;
use vibrissa_ros2::bridge::{Bridge, Input, Output};
use vibrissa_ros2::lifecycle::Activity;
use vibrissa_ros2::link::AgentLink;
use vibrissa_ros2::log::Limited;
use vibrissa_ros2::managed::ManagedNode;
use vibrissa_ros2::names::topics;
use vibrissa_ros2::node::RosNode;
use vibrissa_ros2::options::{Arguments, Options};
use vibrissa_ros2::ros_args::split;
use vibrissa_ros2::touch::TouchTests;

/// Inputs that may wait. Beyond that, messages from ROS are shed, and lines of the agent wait at their source.
const WAITING_MAX: usize = 1024;
/// Interval of the work that no input starts: life cycle, touch tests, count of shed messages, time limits.
const TICK: Duration = Duration::from_millis(50);

/// Logs problems that the program survives on standard error, which the agent or the launch file records.
struct Log {
    is_on: bool,
    limited: Limited,
}

impl Log {
    fn problem(&mut self, now_s: f64, done: Result<(), String>) {
        let Some(problem) = done.err().filter(|_| self.is_on) else { return };
        if let Some(line) = self.limited.line(now_s, &problem) {
            eprintln!("vibrissa-ros2: {line}");
        }
    }
}

fn run(options: Options) -> Result<(), String> {
    let mut log = Log { is_on: options.logs_warnings, limited: Limited::default() };
    for warning in options.warnings {
        log.problem(0.0, Err(warning));
    }
    let (inputs, receive) = sync_channel(WAITING_MAX);
    let mut node = RosNode::join(options.scope, inputs.clone())?;
    let is_managed = options.settings.activity == Activity::Idle;
    let mut managed = is_managed.then(|| node.manage()).transpose()?;
    let (end_sender, end_receiver) = sync_channel(1);
    let agent = AgentLink::open(options.agent, options.token, inputs, end_sender);
    let mut bridge = Bridge::new(options.settings);
    let mut tests: Option<TouchTests<TouchTestServer>> = None;
    let mut outputs = Vec::new();
    let begun = Instant::now();
    let mut ticked_at = begun;
    loop {
        let now_s = begun.elapsed().as_secs_f64();
        for output in outputs.drain(..) {
            match output {
                Output::Line(line) => agent.say(&line)?,
                Output::Open(whiskers) => {
                    tests = Some(TouchTests::new(node.open(topics(&whiskers)?, bridge.mapping())?));
                }
                Output::Test(goal) => {
                    if let Some(tests) = &mut tests {
                        tests.begin(now_s, goal);
                    }
                }
                // A subscriber that does not confirm must not stop the others.
                Output::Setpoint(index, setpoint) => log.problem(now_s, node.publish_setpoint(index, setpoint)),
                Output::ReadingGain(index, factor) => log.problem(now_s, node.publish_gain(index, factor)),
                Output::Estimate(index, estimate) => log.problem(now_s, node.publish_estimate(index, estimate)),
                Output::Report(report) => log.problem(now_s, node.publish_report(report)),
                Output::Log(problem) => log.problem(now_s, Err(problem)),
                Output::Stop(reason) => return Err(reason),
            }
        }
        // Standard input has ended. If it had no line, there never was an agent.
        match end_receiver.try_recv() {
            Ok(true) => return Ok(()),
            Ok(false) => {
                return Err("no agent is at standard input: give --agent, or let the agent start this".to_owned());
            }
            Err(_) => {}
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
            if let Some(activity) = managed.as_mut().and_then(ManagedNode::step) {
                outputs.extend(bridge.step(now_s, Time::now(), Input::Activity(activity)));
            }
            for input in tests.iter_mut().flat_map(|tests| tests.step(now_s)) {
                outputs.extend(bridge.step(now_s, Time::now(), input));
            }
            outputs.extend(bridge.step(now_s, Time::now(), Input::Shed(node.take_shed())));
            outputs.extend(bridge.step(now_s, Time::now(), Input::Tick));
        }
    }
}

fn main() -> ExitCode {
    let (own, ros) = split(std::env::args());
    let options = Options::new(Arguments::parse_from(own), &ros, |name| std::env::var(name).unwrap_or_default());
    match options.and_then(run) {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            eprintln!("vibrissa-ros2: {problem}");
            ExitCode::FAILURE
        }
    }
}
