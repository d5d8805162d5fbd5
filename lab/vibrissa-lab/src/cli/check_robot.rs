//! `vibrissa-lab check-robot`: checks whether a robot conforms to the contract.

use std::io::Write;
use std::net::{Ipv4Addr, SocketAddr};
use std::path::PathBuf;
use std::pin::pin;
use std::process::ExitCode;
use std::time::Duration;

use anyhow::{Context, bail};
use clap::Args;
use vibrissa_protocol::{BootId, Name};

use super::assistant::Helper;
use crate::check::{CheckOptions, Help, Outcome, Report, Timings, check, present_epoch, wait_for_robot};
use vibrissa::cli::config::BrokerOrPortArgs;
use vibrissa::cli::record::duration;
use vibrissa::cli::serve::{log, runtime};
use vibrissa::cli::stop::Stopped;
use vibrissa_host::random;
use vibrissa_program::signals::StopSignals;
use vibrissa_supervisor::broker::{Broker, BrokerError};
use vibrissa_supervisor::mqtt::{self, BrokerAddress, Connection, Relay};

/// Arguments of `vibrissa-lab check-robot`.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Without --broker (mqtt.url) the check starts the broker that is built into the supervisor, on 127.0.0.1 and \
--mqtt-port, and waits for the robot. Stop the supervisor first: it uses the same port. A robot that was connected to \
its broker connects to that of the check without a restart. With --broker the robot must be connected, unless --wait is \
given.

The check takes the place of the robot's supervisor: no supervisor may own the fleet meanwhile, not even a \
disconnected one. Somebody must touch whiskers during the check, otherwise contacts and receipts are not tested. \
Contacts of that time, and those that the robot had buffered, are partly receipted and not recorded.

Pressures stay within 0.01 MPa of one whisker's present setpoint, which is restored at the end and on Ctrl-C. One \
setpoint is 0.001 MPa above the limit of the factsheet, and the robot must refuse it; for limits below 0.2 MPa it is \
never above 0.2 MPa. It allows 0.002 MPa/s, and is withdrawn at once if the robot accepts it.

Epochs: until it restarts, a robot refuses messages with a lower epoch than the highest it has seen. The check uses \
the epoch of the last supervisor, which the broker retains, with higher versions; the next supervisor's epoch is \
higher, so that the robot obeys it at once. The broker of the check knows no supervisor: the epoch is then the present \
time, which is higher than that of every earlier supervisor. With a higher --epoch the robot must be restarted before \
it is supervised again.

With --assisted the check asks for help at the robot: to close the air supply of a whisker and open it again, to touch \
whiskers until the robot's memory of contacts is full (give it a small one for the check), to stop and start the robot's \
program, and to touch a whisker at one place. For a time (--silence) it says nothing to the robot, which must then behave \
as its factsheet states for the loss of its supervisor. It tells the robot other lengths of that whisker, and at the end \
none. The assistant is run as PROGRAM ACTION [ARRAY/NUMBER], beside the check; the actions are cut-power, close-supply, \
open-supply, touch, rest, stop, start and touch-place, where touch and touch-place last until rest.

The robot's packets pass a relay, which records its topics, if the check starts the broker, or with --relay. The relay \
changes nothing, and cannot see through TLS.

The rules are in docs/contract-rules.md. The exit code is 0 only if no rule was violated.")]
pub struct CheckRobotArgs {
    /// Name of the robot.
    #[arg(long, value_name = "NAME", value_parser = |text: &str| Name::robot(text))]
    robot: Name,
    /// Whisker to try setpoints on, as ARRAY/NUMBER; default: the first of the factsheet.
    #[arg(long, value_name = "WHISKER", value_parser = whisker)]
    whisker: Option<(Name, u16)>,
    /// Epoch of these setpoints; default: the last supervisor's, or the present time without --broker.
    #[arg(long, value_name = "NUMBER")]
    epoch: Option<u64>,
    /// Also check a restart: the check tells when to cut the robot's power.
    #[arg(long)]
    restart: bool,
    /// Also check what needs help at the robot, a restart included: the check tells what to do.
    #[arg(long)]
    assisted: bool,
    /// Run this program for each action in place of a person; implies --assisted.
    #[arg(long, value_name = "PROGRAM")]
    assistant: Option<PathBuf>,
    /// Time without a message after which the robot must have noticed the loss of its supervisor; default: 90s.
    #[arg(long, value_name = "TIME", value_parser = duration)]
    silence: Option<Duration>,
    /// How long to touch whiskers at most until the robot's memory of contacts is full; default: 5m.
    #[arg(long, value_name = "TIME", value_parser = duration)]
    fill: Option<Duration>,
    /// With --broker: listen here, and pass the robot on to the broker, to see its topics.
    #[arg(long, value_name = "IP:PORT")]
    relay: Option<SocketAddr>,
    /// How long to wait for the robot, such as 60s or 5m; default: 5m without --broker, otherwise not at all.
    #[arg(long, value_name = "TIME", value_parser = duration)]
    wait: Option<Duration>,
    /// Print the report as one JSON object.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    config: BrokerOrPortArgs,
}

impl CheckRobotArgs {
    fn help_at_robot(&self) -> Help {
        match (self.assisted || self.assistant.is_some(), self.restart) {
            (true, _) => Help::All,
            (false, true) => Help::Restart,
            (false, false) => Help::None,
        }
    }
}

fn whisker(text: &str) -> Result<(Name, u16), String> {
    let bad = || "must be ARRAY/NUMBER, such as left/0".to_owned();
    let (array, number) = text.split_once('/').ok_or_else(bad)?;
    Ok((Name::new(array).map_err(|problem| problem.to_string())?, number.parse().map_err(|_| bad())?))
}

/// Checks a robot, and prints the report.
///
/// # Errors
/// The broker cannot be reached or started, a supervisor owns the fleet, or the robot is not connected.
pub fn run(args: &CheckRobotArgs, out: &mut impl Write) -> anyhow::Result<ExitCode> {
    let config = args.config.read()?;
    let [fleet] = &config.fleets[..] else { bail!("exactly one fleet is required: --fleet NAME") };
    log(&config.log);
    if args.relay.is_some() && config.broker.is_none() {
        bail!("--relay requires --broker: the robot reaches the broker of the check through a relay anyway");
    }
    let defaults = Timings::default();
    let timings = Timings {
        silence: args.silence.unwrap_or(defaults.silence),
        fill: args.fill.unwrap_or(defaults.fill),
        ..defaults
    };
    let options = CheckOptions {
        fleet: fleet.clone(),
        robot: args.robot.clone(),
        whisker: args.whisker.clone(),
        epoch: args.epoch,
        help: args.help_at_robot(),
        relay: None,
        timings,
    };
    let helper = Helper::new(args.assistant.clone());
    let report = runtime()?.block_on(async {
        match (&config.broker, args.relay) {
            (Some(broker), Some(listen)) => through_relay(broker, listen, options, args.wait, &helper).await,
            (Some(broker), None) => checked(broker, &broker.to_string(), options, args.wait, &helper).await,
            (None, _) => on_own_broker(config.mqtt_port, options, args.wait, &helper).await,
        }
    })?;
    if args.json {
        serde_json::to_writer_pretty(&mut *out, &report)?;
        writeln!(out)?;
    } else {
        write!(out, "{report}")?;
    }
    out.flush()?;
    let is_whole = !report.is_interrupted;
    Ok(if is_whole && report.count(Outcome::Fail) == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Time limit for the robot to connect to the broker of the check.
const ARRIVAL: Duration = Duration::from_secs(300);

/// Checks a robot on a broker of its own, with the port and the address of the supervisor's embedded one. The robot reaches
/// it through a relay.
async fn on_own_broker(
    port: u16,
    options: CheckOptions,
    wait: Option<Duration>,
    helper: &Helper,
) -> anyhow::Result<Report> {
    let broker = Broker::start(0).await?;
    let server = broker.address();
    let listen = SocketAddr::from((Ipv4Addr::LOCALHOST, port));
    let relay = Relay::start(listen, (server.ip().to_string(), server.port())).await;
    let relay = relay
        .map_err(|problem| {
            let is_taken = problem.kind() == std::io::ErrorKind::AddrInUse;
            let start = || BrokerError::Start(format!("{listen}: {problem}"));
            if is_taken { BrokerError::PortTaken { port } } else { start() }
        })
        .context(
            "the check starts the supervisor's broker, unless --broker names another one; stop the supervisor of this \
             machine first",
        )?;
    let address = relay.address();
    eprintln!(
        "vibrissa: MQTT on {address}; the robot {}/{} must connect to this address now",
        options.fleet, options.robot
    );
    let epoch = options.epoch.or_else(|| Some(present_epoch()));
    let options = CheckOptions { epoch, relay: Some(relay.record()), ..options };
    let server = BrokerAddress::new(server.ip().to_string(), server.port());
    let report = checked(&server, &address.to_string(), options, Some(wait.unwrap_or(ARRIVAL)), helper).await;
    drop(relay);
    broker.stop().await;
    report
}

/// Checks a robot that reaches a broker through a relay.
async fn through_relay(
    broker: &BrokerAddress,
    listen: SocketAddr,
    options: CheckOptions,
    wait: Option<Duration>,
    helper: &Helper,
) -> anyhow::Result<Report> {
    let relay = Relay::start(listen, (broker.host.clone(), broker.port)).await;
    let relay = relay.with_context(|| format!("--relay: listening on {listen}"))?;
    let address = relay.address();
    eprintln!(
        "vibrissa: relay to the broker on {address}; the robot {}/{} must connect to this address now",
        options.fleet, options.robot
    );
    let options = CheckOptions { relay: Some(relay.record()), ..options };
    checked(broker, &address.to_string(), options, Some(wait.unwrap_or(ARRIVAL)), helper).await
}

/// Checks a robot at a broker. `address` is the one to which the robot must connect.
async fn checked(
    broker: &BrokerAddress,
    address: &str,
    options: CheckOptions,
    wait: Option<Duration>,
    helper: &Helper,
) -> anyhow::Result<Report> {
    let mark = format!("c{}", random::hex());
    let boot_id = BootId::new(&mark).context("creating the boot ID of the connection")?;
    let connection = Connection::new(broker.clone(), mqtt::prepare(broker)?, options.fleet.clone(), boot_id);
    let mut signals = StopSignals::install().context("waiting for SIGTERM")?;
    let mut stopped = pin!(signals.received());
    if let Some(limit) = wait {
        eprintln!("vibrissa: waiting up to {} s for {}", limit.as_secs_f64(), options.robot);
        tokio::select! {
            arrived = wait_for_robot(&connection, &options.robot, limit, address) => arrived?,
            () = &mut stopped => return Err(Stopped("the robot did not connect, and nothing was checked").into()),
        }
    }
    let stop = async {
        stopped.await;
        eprintln!("vibrissa: stopping; restoring the pressure first");
    };
    let (usual, most) = options.timings.expected(options.help);
    let robot = &options.robot;
    eprintln!("vibrissa: checking {robot}: takes about {} s, at most {} s", usual.as_secs(), most.as_secs());
    check(&connection, options, &mut |progress| helper.tell(&progress), stop).await
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_whisker_is_an_array_and_a_number() {
        assert_eq!(whisker("left/3"), Ok((Name::new("left").unwrap(), 3)));
        for bad in ["", "left", "left/", "/3", "left/-1", "left/65536", "left/1/2"] {
            assert!(whisker(bad).is_err(), "{bad}");
        }
    }
}
