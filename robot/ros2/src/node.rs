//! The ROS 2 node: its topics, and the threads that wait for messages.

use std::collections::BTreeMap;
use std::net::{IpAddr, Ipv4Addr};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{SyncSender, TrySendError};
use std::thread;
use std::time::Duration;

use futures::StreamExt;
use futures::executor::block_on;
use futures::stream::{LocalBoxStream, select_all};
use ros2_client::qos::{Durability, History, WhenFull};
use ros2_client::{
    Context, CreateError, MessageTypeName, Name, Node, NodeName, NodeOptions, Publisher, QosProfile, Subscription,
};
use rustdds::DomainParticipantBuilder;
use serde::de::DeserializeOwned;

use crate::bridge::Input;
use crate::messages::{Contact, DiagnosticArray, Float64, FluidPressure};
use crate::names::WhiskerTopics;

/// Contacts that wait for the bridge.
const CONTACTS_DEPTH: usize = 100;
/// Readings of a whisker that wait: only the newest ones matter.
const PRESSURES_DEPTH: usize = 5;
const REPORTS_DEPTH: usize = 10;
/// Longest wait for a subscriber that does not confirm. Then the message is dropped, and the next one follows.
const PUBLISH_WAIT: Duration = Duration::from_millis(20);

/// Where the node is.
#[derive(Debug, Clone)]
pub struct NodeScope {
    /// Domain, as of `ROS_DOMAIN_ID`.
    pub domain: u16,
    /// Whether it only reaches programs of this machine.
    pub is_local: bool,
    /// Namespace of the node and its topics, such as `/crawler`.
    pub namespace: String,
}

/// The node.
pub struct RosNode {
    node: Node,
    namespace: String,
    reports: Publisher<DiagnosticArray>,
    setpoints: Vec<Publisher<FluidPressure>>,
    /// Topics of the whiskers, and the publishers of their factors: only robots that apply gains have them.
    whiskers: Vec<WhiskerTopics>,
    gains: BTreeMap<usize, Publisher<Float64>>,
    inputs: SyncSender<Input>,
    shed: Arc<AtomicU64>,
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

fn named(namespace: &str, name: &str) -> Result<Name, String> {
    Name::new(namespace, name).map_err(|problem| format!("{namespace}/{name} is no ROS name: {problem:?}"))
}

fn failed(problem: impl std::fmt::Debug) -> String {
    format!("DDS: {problem:?}")
}

impl RosNode {
    /// Joins a domain. Messages become inputs; those that come too fast are counted as shed.
    ///
    /// # Errors
    /// The namespace is invalid, or the network is not available.
    pub fn join(place: &NodeScope, inputs: SyncSender<Input>) -> Result<Self, String> {
        let mut participant = DomainParticipantBuilder::new(place.domain);
        if place.is_local {
            participant = participant.with_only_networks([IpAddr::V4(Ipv4Addr::LOCALHOST)]);
        }
        let context = Context::from_domain_participant(participant.build().map_err(failed)?).map_err(failed)?;
        let name = NodeName::new(&place.namespace, "vibrissa")
            .map_err(|problem| format!("--namespace {}: {problem:?}", place.namespace))?;
        let options = NodeOptions::new().enable_rosout(false).start_parameter_services(false);
        let mut node = context.new_node(name, options).map_err(failed)?;
        let spinner = node.spinner().map_err(failed)?;
        thread::spawn(move || block_on(spinner.spin()));
        let topic = node.create_topic(
            &named("/", "diagnostics")?,
            MessageTypeName::new("diagnostic_msgs", "DiagnosticArray"),
            &reliable(Durability::Volatile, REPORTS_DEPTH),
        );
        let reports = node.create_publisher(&topic.map_err(failed)?, None).map_err(failed)?;
        let shed = Arc::new(AtomicU64::new(0));
        let namespace = place.namespace.clone();
        let (setpoints, whiskers, gains) = (Vec::new(), Vec::new(), BTreeMap::new());
        Ok(Self { node, namespace, reports, setpoints, whiskers, gains, inputs, shed })
    }

    /// Opens the topics of the whiskers.
    ///
    /// # Errors
    /// A name is invalid, or DDS refuses a topic.
    pub fn open(&mut self, whiskers: &[WhiskerTopics]) -> Result<(), String> {
        let namespace = self.namespace.clone();
        let contacts: Subscription<Contact> =
            self.subscribe(&namespace, "contacts", "vibrissa_msgs", "Contact", CONTACTS_DEPTH)?;
        let mut pressures = Vec::new();
        for whisker in whiskers {
            let at = &whisker.namespace;
            let readings: Subscription<FluidPressure> =
                self.subscribe(at, "pressure", "sensor_msgs", "FluidPressure", PRESSURES_DEPTH)?;
            pressures.push(readings);
            let topic = self.node.create_topic(
                &named(at, "setpoint")?,
                MessageTypeName::new("sensor_msgs", "FluidPressure"),
                &reliable(Durability::TransientLocal, 1),
            );
            let setpoints = self.node.create_publisher(&topic.map_err(failed)?, None).map_err(failed)?;
            self.setpoints.push(setpoints);
        }
        self.whiskers = whiskers.to_vec();
        let (inputs, shed) = (self.inputs.clone(), Arc::clone(&self.shed));
        thread::spawn(move || listen(&contacts, &pressures, &inputs, &shed));
        Ok(())
    }

    fn subscribe<M: DeserializeOwned + 'static>(
        &mut self,
        namespace: &str,
        name: &str,
        package: &str,
        kind: &str,
        depth: usize,
    ) -> Result<Subscription<M>, String> {
        let kind = MessageTypeName::new(package, kind);
        let topic = self.node.create_topic(&named(namespace, name)?, kind, &sensor_data(depth));
        let created: Result<_, CreateError> = topic.and_then(|topic| self.node.create_subscription(&topic, None));
        created.map_err(failed)
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
        let publisher = self.setpoints.get(index).ok_or("the whisker has no topic")?;
        publisher.publish(setpoint).map_err(|problem| format!("setpoint: {}", problem.forget_data()))
    }

    /// Publishes the factor on a whisker's readings.
    ///
    /// # Errors
    /// DDS refuses the topic, or subscribers do not confirm it in time.
    pub fn publish_gain(&mut self, index: usize, factor: Float64) -> Result<(), String> {
        if !self.gains.contains_key(&index) {
            let whisker = self.whiskers.get(index).ok_or("the whisker has no topic")?;
            let topic = self.node.create_topic(
                &named(&whisker.namespace, "reading_gain")?,
                MessageTypeName::new("std_msgs", "Float64"),
                &reliable(Durability::TransientLocal, 1),
            );
            let publisher = self.node.create_publisher(&topic.map_err(failed)?, None).map_err(failed)?;
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

/// Messages of a topic as inputs.
fn inputs_of<'a, M: DeserializeOwned + 'static>(
    topic: &'a Subscription<M>,
    input: impl Fn(Result<M, String>) -> Input + 'a,
) -> LocalBoxStream<'a, Input> {
    let messages = topic.async_stream();
    messages.map(move |got| input(got.map(|(message, _)| message).map_err(|problem| problem.to_string()))).boxed_local()
}

/// Hands messages to the bridge until it ends. While it is busy, messages are shed: newer ones follow.
fn listen(
    contacts: &Subscription<Contact>,
    pressures: &[Subscription<FluidPressure>],
    inputs: &SyncSender<Input>,
    shed: &AtomicU64,
) {
    let mut streams = vec![inputs_of(contacts, Input::Contact)];
    for (index, readings) in pressures.iter().enumerate() {
        streams.push(inputs_of(readings, move |reading| Input::Pressure(index, reading)));
    }
    let mut all = select_all(streams);
    block_on(async {
        while let Some(input) = all.next().await {
            match inputs.try_send(input) {
                Ok(()) => {}
                Err(TrySendError::Full(_)) => {
                    shed.fetch_add(1, Ordering::Relaxed);
                }
                Err(TrySendError::Disconnected(_)) => return,
            }
        }
    });
}
