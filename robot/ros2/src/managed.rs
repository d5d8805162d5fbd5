//! The services of a managed node.

use ros2_client::builtin_interfaces::Time;
use ros2_client::service::Server;
use ros2_client::{Message, MessageTypeName, Name, Node, Publisher, QosProfile, ServiceMapping, ServiceTypeName};
use serde::{Deserialize, Serialize};

use crate::actions::service_qos;
use crate::lifecycle::{Activity, Lifecycle, State, Transition, TransitionDescription, TransitionEvent};
use crate::remap::Names;

/// A request without fields: the generators of ROS add one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
struct Nothing {
    structure_needs_at_least_one_member: u8,
}

#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
struct ChangeState {
    transition: Transition,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
struct Changed {
    success: bool,
}

#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
struct CurrentState {
    current_state: State,
}

#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
struct AvailableStates {
    available_states: Vec<State>,
}

#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
struct AvailableTransitions {
    available_transitions: Vec<TransitionDescription>,
}

impl Message for Nothing {}
impl Message for ChangeState {}
impl Message for Changed {}
impl Message for CurrentState {}
impl Message for AvailableStates {}
impl Message for AvailableTransitions {}

/// The lifecycle of the node, and the services and the topic that tell it.
pub struct ManagedNode {
    lifecycle: Lifecycle,
    change_state: Server<ChangeState, Changed>,
    get_state: Server<Nothing, CurrentState>,
    get_available_states: Server<Nothing, AvailableStates>,
    get_available_transitions: Server<Nothing, AvailableTransitions>,
    get_transition_graph: Server<Nothing, AvailableTransitions>,
    events: Publisher<TransitionEvent>,
}

fn name(names: &Names, of: &str) -> Result<Name, String> {
    let full = names.service(&format!("~/{of}"))?;
    Name::parse(&full).map_err(|problem| format!("{full}: {problem}"))
}

fn serve<Q: Message + Clone + 'static, A: Message + 'static>(
    node: &mut Node,
    names: &Names,
    mapping: ServiceMapping,
    (of, kind): (&str, &str),
) -> Result<Server<Q, A>, String> {
    let kind = ServiceTypeName::new("lifecycle_msgs", kind);
    let served = node.create_server(mapping, &name(names, of)?, &kind, service_qos(), service_qos());
    served.map_err(|problem| format!("DDS: {problem:?}"))
}

/// Answers all requests of a service.
fn answer<Q: Message + Clone + 'static, A: Message + 'static>(server: &Server<Q, A>, mut of: impl FnMut(Q) -> A) {
    while let Ok(Some((id, request))) = server.receive_request() {
        // A client that does not confirm asks again.
        let _ = server.send_response(id, of(request));
    }
}

impl ManagedNode {
    /// Opens the services of an unconfigured node.
    ///
    /// # Errors
    /// DDS refuses a topic.
    pub fn open(node: &mut Node, names: &Names, mapping: ServiceMapping) -> Result<Self, String> {
        let qos: QosProfile = service_qos();
        let kind = MessageTypeName::new("lifecycle_msgs", "TransitionEvent");
        let failed = |problem: &dyn std::fmt::Debug| format!("DDS: {problem:?}");
        let topic =
            node.create_topic(&name(names, "transition_event")?, kind, &qos).map_err(|problem| failed(&problem))?;
        Ok(Self {
            lifecycle: Lifecycle::default(),
            change_state: serve(node, names, mapping, ("change_state", "ChangeState"))?,
            get_state: serve(node, names, mapping, ("get_state", "GetState"))?,
            get_available_states: serve(node, names, mapping, ("get_available_states", "GetAvailableStates"))?,
            get_available_transitions: serve(
                node,
                names,
                mapping,
                ("get_available_transitions", "GetAvailableTransitions"),
            )?,
            get_transition_graph: serve(node, names, mapping, ("get_transition_graph", "GetAvailableTransitions"))?,
            events: node.create_publisher(&topic, None).map_err(|problem| failed(&problem))?,
        })
    }

    /// Answers requests; returns the activity if it has changed.
    pub fn step(&mut self) -> Option<Activity> {
        let before = self.lifecycle.activity();
        let (lifecycle, events) = (&mut self.lifecycle, &self.events);
        answer(&self.change_state, |request: ChangeState| {
            let parts = lifecycle.change(&request.transition);
            let success = parts.is_some();
            for TransitionDescription { transition, start_state, goal_state } in parts.into_iter().flatten() {
                let timestamp = u64::try_from(Time::now().to_nanos()).unwrap_or_default();
                // Whoever misses an event can ask for the state.
                let _ = events.publish(TransitionEvent { timestamp, transition, start_state, goal_state });
            }
            Changed { success }
        });
        let lifecycle = self.lifecycle;
        answer(&self.get_state, |_| CurrentState { current_state: lifecycle.state() });
        answer(&self.get_available_states, |_| AvailableStates { available_states: Lifecycle::states() });
        let available = || AvailableTransitions { available_transitions: lifecycle.available() };
        answer(&self.get_available_transitions, |_| available());
        answer(&self.get_transition_graph, |_| AvailableTransitions { available_transitions: Lifecycle::graph() });
        Some(lifecycle.activity()).filter(|activity| *activity != before)
    }
}
