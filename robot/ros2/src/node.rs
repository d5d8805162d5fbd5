//! The ROS 2 node: its topics, and the threads that wait for messages.

use std::collections::BTreeMap;
use std::net::{IpAddr, Ipv4Addr};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::SyncSender;
use std::thread;
use std::time::Duration;

use futures::executor::block_on;
use ros2_client::qos::{Durability, History, WhenFull};
use ros2_client::{
    Context, MessageTypeName, Name, Node, NodeName, NodeOptions, ParameterValue, Publisher, QosProfile, ServiceMapping,
    Subscription,
};
use rustdds::{DomainParticipant, DomainParticipantBuilder, Topic};
use serde::Serialize;

use crate::actions::TouchTestServer;
use crate::bridge::Input;
use crate::managed::ManagedNode;
use crate::mapping::{Mapping, MessageSeed, SetpointType};
use crate::messages::{DiagnosticArray, Estimate, Float32, Float64, FluidPressure};
use crate::remap::Names;
use crate::subscriptions::Subscriptions;

/// Contacts that wait for the bridge.
const CONTACTS_DEPTH: usize = 100;
/// Readings of a whisker that wait: only the newest ones matter.
const PRESSURES_DEPTH: usize = 5;
/// Messages of strain of a whisker that wait: none should be lost.
const STRAINS_DEPTH: usize = 50;
/// Messages of a mapped topic that wait: it may have strain.
const MAPPED_DEPTH: usize = 50;
const FAULTS_DEPTH: usize = 10;
const REPORTS_DEPTH: usize = 10;
/// Longest wait for a subscriber that does not confirm. Then the message is dropped, and the next one follows.
pub(crate) const PUBLISH_WAIT: Duration = Duration::from_millis(20);

/// Where the node is.
#[derive(Debug, Clone)]
pub struct NodeScope {
    /// Domain, as of `ROS_DOMAIN_ID`.
    pub domain: u16,
    /// Whether it only reaches programs of this machine.
    pub is_local: bool,
    /// Name and namespace of the node, and rules for its topics.
    pub names: Names,
    /// How services are carried: Cyclone DDS has a way of its own.
    pub services: ServiceMapping,
    /// Values that the node's parameter services tell.
    pub parameters: Vec<(&'static str, ParameterValue)>,
}

/// The node.
pub struct RosNode {
    node: Node,
    participant: DomainParticipant,
    scope: NodeScope,
    reports: Publisher<DiagnosticArray>,
    /// Topics of setpoints; `None` for a whisker that a mapping leaves without.
    setpoints: Vec<Option<SetpointTopic>>,
    estimates: Vec<Publisher<Estimate>>,
    /// Topics of the whiskers, and the publishers of their factors: only robots that apply gains have them.
    whiskers: Vec<String>,
    gains: BTreeMap<usize, Publisher<Float64>>,
    inputs: SyncSender<Input>,
    shed: Arc<AtomicU64>,
}

/// A topic that takes setpoints.
enum SetpointTopic {
    FluidPressure(Publisher<FluidPressure>),
    Float64(Publisher<Float64>),
    Float32(Publisher<Float32>),
}

/// Sensor data: the newest messages, without repetition.
fn sensor_data(depth: usize) -> QosProfile {
    QosProfile::subscription_default().reliability_best_effort().history(History::KeepLast { depth })
}

fn reliable(durability: Durability, depth: usize) -> QosProfile {
    QosProfile::publisher_default()
        .reliability_reliable(WhenFull::Wait(PUBLISH_WAIT))
        .durability(durability)
        .history(History::KeepLast { depth })
}

fn failed(problem: impl std::fmt::Debug) -> String {
    format!("DDS: {problem:?}")
}

impl RosNode {
    /// Joins a domain. Messages become inputs; those that come too fast are counted as shed.
    ///
    /// # Errors
    /// A name is invalid, or the network is not available.
    pub fn join(scope: NodeScope, inputs: SyncSender<Input>) -> Result<Self, String> {
        let mut participant = DomainParticipantBuilder::new(scope.domain);
        if scope.is_local {
            participant = participant.with_only_networks([IpAddr::V4(Ipv4Addr::LOCALHOST)]);
        }
        let participant = participant.build().map_err(failed)?;
        let context = Context::from_domain_participant(participant.clone()).map_err(failed)?;
        let name = NodeName::new(scope.names.namespace(), scope.names.node())
            .map_err(|problem| format!("the node {}: {problem}", scope.names.full()))?;
        // The library carries parameter services in one way only.
        let has_services = scope.services == ServiceMapping::Enhanced;
        let mut options = NodeOptions::new().enable_rosout(false).start_parameter_services(has_services);
        options = scope
            .parameters
            .iter()
            .fold(options, |options, (name, value)| options.declare_parameter(name, value.clone()));
        // The library asks about the first values, too.
        let fixed = scope.parameters.clone();
        let takes = move |name: &str, value: &ParameterValue| {
            let is_same = fixed.iter().any(|(known, first)| *known == name && first == value);
            if is_same { Ok(()) } else { Err(format!("{name} is fixed at the start of the program")) }
        };
        let mut node = context.new_node(name, options.parameter_validator(Box::new(takes))).map_err(failed)?;
        let spinner = node.spinner().map_err(failed)?;
        thread::spawn(move || block_on(spinner.spin()));
        let qos = reliable(Durability::Volatile, REPORTS_DEPTH);
        let topic = topic_of(&node, &scope.names, "/diagnostics", ("diagnostic_msgs", "DiagnosticArray"), &qos)?;
        let reports = node.create_publisher(&topic, None).map_err(failed)?;
        Ok(Self {
            node,
            participant,
            scope,
            reports,
            setpoints: Vec::new(),
            estimates: Vec::new(),
            whiskers: Vec::new(),
            gains: BTreeMap::new(),
            inputs,
            shed: Arc::default(),
        })
    }

    /// Opens the topics of the robot and of its whiskers, whose names are relative, and those of the mapping. Returns the
    /// action of touch tests.
    ///
    /// # Errors
    /// A name is invalid, or DDS refuses a topic.
    pub fn open(&mut self, whiskers: Vec<String>, mapping: Option<&Mapping>) -> Result<TouchTestServer, String> {
        let faults = QosProfile::subscription_default()
            .reliability_reliable(WhenFull::Wait(PUBLISH_WAIT))
            .history(History::KeepLast { depth: FAULTS_DEPTH });
        let mut read = Subscriptions {
            contacts: self.subscribe("contacts", ("vibrissa_msgs", "Contact"), &sensor_data(CONTACTS_DEPTH))?,
            faults: self.subscribe("faults", ("vibrissa_msgs", "Fault"), &faults)?,
            pressures: Vec::new(),
            strains: Vec::new(),
            mapped: Vec::new(),
        };
        for topic in mapping.into_iter().flat_map(|mapping| &mapping.topics) {
            let kind = topic.package_and_name().ok_or_else(|| format!("{} is no type", topic.kind))?;
            let subscription = self.subscribe(&topic.topic, kind, &sensor_data(MAPPED_DEPTH))?;
            read.mapped.push((subscription, MessageSeed(Arc::clone(&topic.layout))));
        }
        for (index, at) in whiskers.iter().enumerate() {
            let pressures = sensor_data(PRESSURES_DEPTH);
            read.pressures.push(self.subscribe(
                &format!("{at}/pressure"),
                ("sensor_msgs", "FluidPressure"),
                &pressures,
            )?);
            let strains = sensor_data(STRAINS_DEPTH);
            read.strains.push(self.subscribe(&format!("{at}/strain"), ("vibrissa_msgs", "Strain"), &strains)?);
            let setpoints = self.setpoint_topic(index, at, mapping)?;
            self.setpoints.push(setpoints);
            let estimates = self.publisher(&format!("{at}/estimate"), ("vibrissa_msgs", "Estimate"))?;
            self.estimates.push(estimates);
        }
        self.whiskers = whiskers;
        read.listen(self.inputs.clone(), Arc::clone(&self.shed));
        let action = self.scope.names.service("touch_test")?;
        TouchTestServer::open(&mut self.node, self.participant.clone(), self.scope.services, &action)
    }

    /// The topic that takes the setpoints of a whisker: its own, or that of the mapping.
    fn setpoint_topic(
        &mut self,
        index: usize,
        at: &str,
        mapping: Option<&Mapping>,
    ) -> Result<Option<SetpointTopic>, String> {
        let Some(mapping) = mapping else {
            let own = self.volatile(&format!("{at}/setpoint"), ("sensor_msgs", "FluidPressure"))?;
            return Ok(Some(SetpointTopic::FluidPressure(own)));
        };
        let Some(mapped) = mapping.setpoint_of(index) else { return Ok(None) };
        let kind = mapped.written.name();
        Ok(Some(match mapped.written {
            SetpointType::FluidPressure => SetpointTopic::FluidPressure(self.volatile(&mapped.topic, kind)?),
            SetpointType::Float64 => SetpointTopic::Float64(self.volatile(&mapped.topic, kind)?),
            SetpointType::Float32 => SetpointTopic::Float32(self.volatile(&mapped.topic, kind)?),
        }))
    }

    /// Opens the services of a managed node.
    ///
    /// # Errors
    /// DDS refuses a topic.
    pub fn manage(&mut self) -> Result<ManagedNode, String> {
        ManagedNode::open(&mut self.node, &self.scope.names, self.scope.services)
    }

    fn subscribe<M: 'static>(
        &mut self,
        name: &str,
        kind: (&str, &str),
        qos: &QosProfile,
    ) -> Result<Subscription<M>, String> {
        let topic = topic_of(&self.node, &self.scope.names, name, kind, qos)?;
        self.node.create_subscription(&topic, None).map_err(failed)
    }

    /// A publisher whose newest message is also for subscribers that start later.
    fn publisher<M: Serialize>(&mut self, name: &str, kind: (&str, &str)) -> Result<Publisher<M>, String> {
        self.reliable_publisher(Durability::TransientLocal, name, kind)
    }

    /// A publisher of setpoints, which are repeated each second. A valve node that starts later gets no old one.
    fn volatile<M: Serialize>(&mut self, name: &str, kind: (&str, &str)) -> Result<Publisher<M>, String> {
        self.reliable_publisher(Durability::Volatile, name, kind)
    }

    fn reliable_publisher<M: Serialize>(
        &mut self,
        durability: Durability,
        name: &str,
        kind: (&str, &str),
    ) -> Result<Publisher<M>, String> {
        let qos = reliable(durability, 1);
        let topic = topic_of(&self.node, &self.scope.names, name, kind, &qos)?;
        self.node.create_publisher(&topic, None).map_err(failed)
    }

    /// Messages that were dropped since the last call.
    pub fn take_shed(&self) -> u64 {
        self.shed.swap(0, Ordering::Relaxed)
    }

    /// Publishes the setpoint of a whisker.
    ///
    /// # Errors
    /// Subscribers do not confirm it in time.
    pub fn publish_setpoint(&self, index: usize, setpoint: FluidPressure) -> Result<(), String> {
        let topic = self.setpoints.get(index).and_then(Option::as_ref).ok_or("the whisker has no topic")?;
        let data = setpoint.fluid_pressure;
        let published = match topic {
            SetpointTopic::FluidPressure(topic) => topic.publish(setpoint).map_err(|problem| problem.forget_data()),
            SetpointTopic::Float64(topic) => topic.publish(Float64 { data }).map_err(|problem| problem.forget_data()),
            SetpointTopic::Float32(topic) => {
                topic.publish(Float32 { data: data as f32 }).map_err(|problem| problem.forget_data())
            }
        };
        published.map_err(|problem| format!("setpoint: {problem}"))
    }

    /// Publishes the estimate of a whisker.
    ///
    /// # Errors
    /// Subscribers do not confirm it in time.
    pub fn publish_estimate(&self, index: usize, estimate: Estimate) -> Result<(), String> {
        let publisher = self.estimates.get(index).ok_or("the whisker has no topic")?;
        publisher.publish(estimate).map_err(|problem| format!("estimate: {}", problem.forget_data()))
    }

    /// Publishes the factor on a whisker's readings.
    ///
    /// # Errors
    /// DDS refuses the topic, or subscribers do not confirm it in time.
    pub fn publish_gain(&mut self, index: usize, factor: Float64) -> Result<(), String> {
        if !self.gains.contains_key(&index) {
            let whisker = self.whiskers.get(index).ok_or("the whisker has no topic")?;
            let name = format!("{whisker}/reading_gain");
            let publisher = self.publisher(&name, ("std_msgs", "Float64"))?;
            self.gains.insert(index, publisher);
        }
        let publisher = self.gains.get(&index).ok_or("the whisker has no topic")?;
        publisher.publish(factor).map_err(|problem| format!("reading_gain: {}", problem.forget_data()))
    }

    /// Publishes a report.
    ///
    /// # Errors
    /// Subscribers do not confirm it in time.
    pub fn publish_report(&self, report: DiagnosticArray) -> Result<(), String> {
        self.reports.publish(report).map_err(|problem| format!("diagnostics: {}", problem.forget_data()))
    }
}

fn topic_of(node: &Node, names: &Names, name: &str, kind: (&str, &str), qos: &QosProfile) -> Result<Topic, String> {
    let full = names.topic(name)?;
    let parsed = Name::parse(&full).map_err(|problem| format!("{full} is no name of ROS: {problem}"))?;
    node.create_topic(&parsed, MessageTypeName::new(kind.0, kind.1), qos).map_err(failed)
}
