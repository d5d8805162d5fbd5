//! Options of the command line, and the parameters and names of ROS that replace them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::{Parser, ValueEnum};
use ros2_client::{ParameterValue, ServiceMapping};
use serde_json::Value;

use crate::bridge::Settings;
use crate::lifecycle::Activity;
use crate::link::AgentAddress;
use crate::mapping::{Definitions, Mapping};
use crate::node::NodeScope;
use crate::params;
use crate::remap::Names;
use crate::ros_args::RosArguments;
use crate::units::Pressures;

/// Greatest domain whose ports fit: 7400 + 250 x domain.
const DOMAIN_MAX: i64 = 232;
/// Shortest and longest token that the agent takes, in bytes.
const TOKEN_BYTES: std::ops::RangeInclusive<usize> = 16..=256;
/// Parameters that each node of ROS may be given.
const OF_EACH_NODE: [&str; 2] = ["use_sim_time", "start_type_description_service"];

/// Meaning of pressures in ROS messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Meaning {
    /// As sensor_msgs/FluidPressure defines it.
    Absolute,
    /// Above the atmosphere.
    Gauge,
}

/// A driver of the agent vibrissa-robot that is a ROS 2 node: contacts, strain and pressures in, setpoints, estimates
/// and health out. Arguments of ROS follow --ros-args: -r FROM:=TO, -p NAME:=VALUE, --params-file FILE, --log-level LEVEL
#[derive(Debug, Parser)]
#[command(version)]
pub struct Arguments {
    /// Meaning of pressures in ROS messages, readings and setpoints; there is no default, because a mistake is 0.1 MPa
    #[arg(long, value_enum)]
    pub pressures: Option<Meaning>,
    /// Pressure of the atmosphere, Pa, for absolute pressures
    #[arg(long, default_value_t = 101_325.0, value_parser = atmosphere)]
    pub atmosphere_pa: f64,
    /// Namespace of the node and its topics
    #[arg(long, default_value = "/vibrissa")]
    pub namespace: String,
    /// Name of the robot in /diagnostics
    #[arg(long, default_value = "")]
    pub robot: String,
    /// Where the agent listens: unix:PATH (its driver.unix) or tcp:IP:PORT (its driver.listen); without it the agent
    /// is at standard input and output
    #[arg(long)]
    pub agent: Option<AgentAddress>,
    /// File with the token of the agent's driver.token_file
    #[arg(long)]
    pub agent_token_file: Option<PathBuf>,
    /// File that names existing topics, and their values of whiskers; setpoints then go only to topics that it names
    #[arg(long)]
    pub mapping: Option<PathBuf>,
    /// Be a managed node, which does nothing until it is configured and activated
    #[arg(long)]
    pub lifecycle: bool,
    /// Domain of ROS
    #[arg(long, env = "ROS_DOMAIN_ID", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=DOMAIN_MAX))]
    pub domain: u16,
    /// Reach only programs of this machine; the same with ROS_LOCALHOST_ONLY=1, or ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST
    #[arg(long)]
    pub localhost: bool,
}

/// What the program does.
#[derive(Debug)]
pub struct Options {
    /// Settings of the bridge.
    pub settings: Settings,
    /// Place of the node.
    pub scope: NodeScope,
    /// The way to the agent.
    pub agent: AgentAddress,
    /// First line for the agent.
    pub token: Option<String>,
    /// Whether problems of single messages are logged.
    pub logs_warnings: bool,
    /// What the user should know.
    pub warnings: Vec<String>,
}

fn atmosphere(text: &str) -> Result<f64, String> {
    let pa: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if (30_000.0..=120_000.0).contains(&pa) { Ok(pa) } else { Err("must be 30000 to 120000 Pa".to_owned()) }
}

fn token(path: &Path) -> Result<String, String> {
    let text = std::fs::read_to_string(path).map_err(|problem| format!("cannot read {}: {problem}", path.display()))?;
    let token = text.trim();
    if TOKEN_BYTES.contains(&token.len()) && token.bytes().all(|byte| byte.is_ascii_graphic()) {
        return Ok(token.to_owned());
    }
    Err(format!("{} has no token of 16 to 256 printable characters", path.display()))
}

impl Arguments {
    /// Takes the parameters of ROS, which replace options; returns those that nobody here knows.
    fn take(&mut self, parameters: BTreeMap<String, Value>) -> Result<Vec<String>, String> {
        let mut unknown = Vec::new();
        for (name, value) in parameters {
            let text = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
            let taken = match name.as_str() {
                "pressures" => Meaning::from_str(&text, false).map(|meaning| self.pressures = Some(meaning)),
                "atmosphere_pa" => atmosphere(&text).map(|pa| self.atmosphere_pa = pa),
                "robot" => {
                    self.robot = text.clone();
                    Ok(())
                }
                "lifecycle" => match value.as_bool() {
                    Some(is_managed) => {
                        self.lifecycle = is_managed;
                        Ok(())
                    }
                    None => Err("must be true or false".to_owned()),
                },
                "agent" => text.parse().map(|agent| self.agent = Some(agent)),
                "agent_token_file" => {
                    self.agent_token_file = Some(PathBuf::from(&text));
                    Ok(())
                }
                "mapping" => {
                    self.mapping = Some(PathBuf::from(&text));
                    Ok(())
                }
                "use_sim_time" if value == Value::Bool(false) => Ok(()),
                _ => {
                    unknown.push(name.clone());
                    Ok(())
                }
            };
            taken.map_err(|problem| format!("the parameter {name} is {text}: {problem}"))?;
        }
        Ok(unknown)
    }
}

fn warning_of(parameter: &str) -> Option<String> {
    if parameter == OF_EACH_NODE[0] {
        return Some("use_sim_time has no effect: times are those of this machine's clock".to_owned());
    }
    let is_known = OF_EACH_NODE.contains(&parameter);
    (!is_known).then(|| format!("the parameter {parameter} is unknown and has no effect"))
}

impl Options {
    /// Joins the options and the words of ROS. Names and parameters of ROS replace options.
    ///
    /// # Errors
    /// A value is missing or invalid; the error is a text.
    pub fn new(mut arguments: Arguments, ros: &[String], environment: impl Fn(&str) -> String) -> Result<Self, String> {
        let ros = RosArguments::read(ros)?;
        let names = Names::new(&arguments.namespace, "vibrissa", ros.rules.clone())?;
        let unknown = arguments.take(params::of_node(&ros.parameters, &names.full())?)?;
        let pressures = match arguments.pressures {
            Some(Meaning::Absolute) => Pressures::Absolute(arguments.atmosphere_pa),
            Some(Meaning::Gauge) => Pressures::Gauge,
            None => {
                let remedy = "give --pressures absolute or --pressures gauge, or the parameter `pressures`";
                return Err(format!("the meaning of pressures is not stated: {remedy}"));
            }
        };
        let agent = arguments.agent.clone().unwrap_or(AgentAddress::Pipes);
        let token = arguments.agent_token_file.as_deref().map(token).transpose()?;
        if token.is_some() && agent == AgentAddress::Pipes {
            return Err("--agent-token-file needs --agent".to_owned());
        }
        let definitions = Definitions::new(&environment("AMENT_PREFIX_PATH"));
        let mapping = arguments.mapping.as_deref().map(|path| Mapping::read(path, &definitions)).transpose()?;
        let is_cyclone = environment("RMW_IMPLEMENTATION") == "rmw_cyclonedds_cpp";
        let is_local = arguments.localhost
            || environment("ROS_LOCALHOST_ONLY") == "1"
            || environment("ROS_AUTOMATIC_DISCOVERY_RANGE") == "LOCALHOST";
        let activity = if arguments.lifecycle { Activity::Idle } else { Activity::Active };
        let meaning = if pressures == Pressures::Gauge { "gauge" } else { "absolute" };
        let text = |value: &str| ParameterValue::String(value.to_owned());
        let parameters = vec![
            ("pressures", text(meaning)),
            ("atmosphere_pa", ParameterValue::Double(arguments.atmosphere_pa)),
            ("robot", text(&arguments.robot)),
            ("lifecycle", ParameterValue::Boolean(arguments.lifecycle)),
            ("agent", text(&agent.to_string())),
            ("mapping", text(&arguments.mapping.as_deref().map_or(String::new(), |path| path.display().to_string()))),
        ];
        Ok(Self {
            settings: Settings { robot: arguments.robot, pressures, activity, mapping },
            logs_warnings: ros.logs_warnings(names.full().trim_start_matches('/').replace('/', ".").as_str()),
            scope: NodeScope {
                domain: arguments.domain,
                is_local,
                names,
                services: if is_cyclone { ServiceMapping::Cyclone } else { ServiceMapping::Enhanced },
                parameters,
            },
            agent,
            token,
            warnings: unknown.iter().filter_map(|name| warning_of(name)).collect(),
        })
    }
}
