//! The client of the action `touch_test`.

use ros2_client::action::{ActionClient, ActionClientQosPolicies, GoalId};
use ros2_client::qos::{Durability, History, WhenFull};
use ros2_client::{ActionTypeName, Name, Node, QosProfile, RmwRequestId, ServiceMapping};
use rustdds::DomainParticipant;

use crate::messages::{TouchTestFeedback, TouchTestGoal, TouchTestResult};
use crate::node::PUBLISH_WAIT;
use crate::touch::ActionServer;

/// Requests and answers that wait.
const DEPTH: usize = 10;
/// `STATUS_SUCCEEDED` of `action_msgs/msg/GoalStatus`.
const SUCCEEDED: ros2_client::action::GoalStatusEnum = ros2_client::action::GoalStatusEnum::Succeeded;

/// The node of the user that does touch tests.
pub struct TouchTestServer {
    client: ActionClient<TouchTestGoal, TouchTestResult, TouchTestFeedback>,
    participant: DomainParticipant,
    /// Topics of DDS that the node reads and writes.
    reads: [String; 2],
    writes: [String; 2],
}

/// Services of ROS are reliable and volatile.
pub(crate) fn service_qos() -> QosProfile {
    QosProfile::publisher_default()
        .reliability_reliable(WhenFull::Wait(PUBLISH_WAIT))
        .durability(Durability::Volatile)
        .history(History::KeepLast { depth: DEPTH })
}

impl TouchTestServer {
    /// Opens the action with this absolute name.
    ///
    /// # Errors
    /// DDS refuses a topic.
    pub fn open(
        node: &mut Node,
        participant: DomainParticipant,
        mapping: ServiceMapping,
        name: &str,
    ) -> Result<Self, String> {
        let qos = ActionClientQosPolicies {
            goal_service: service_qos(),
            result_service: service_qos(),
            cancel_service: service_qos(),
            feedback_subscription: service_qos(),
            status_subscription: service_qos(),
        };
        let parsed = Name::parse(name).map_err(|problem| format!("the action {name}: {problem}"))?;
        let kind = ActionTypeName::new("vibrissa_msgs", "TouchTest");
        let client = node.create_action_client(mapping, &parsed, &kind, qos);
        let client = client.map_err(|problem| format!("DDS: {problem:?}"))?;
        let both = |prefix: &str, suffix: &str| {
            ["send_goal", "get_result"].map(|service| format!("{prefix}{name}/_action/{service}{suffix}"))
        };
        Ok(Self { client, participant, reads: both("rq", "Request"), writes: both("rr", "Reply") })
    }
}

impl ActionServer for TouchTestServer {
    type Request = RmwRequestId;
    type Goal = GoalId;

    fn is_found(&self) -> bool {
        let readers = self.participant.discovered_readers();
        let writers = self.participant.discovered_writers();
        let reads = |topic: &String| readers.iter().any(|one| one.subscription_topic_data.topic_name == *topic);
        let writes = |topic: &String| writers.iter().any(|one| one.publication_topic_data.topic_name == *topic);
        self.reads.iter().all(reads) && self.writes.iter().all(writes)
    }

    fn send(&mut self, goal: TouchTestGoal) -> Result<(RmwRequestId, GoalId), String> {
        self.client.send_goal(goal).map_err(|problem| format!("the goal cannot be sent: {problem}"))
    }

    fn ask_result(&mut self, goal: GoalId) -> Result<RmwRequestId, String> {
        self.client.request_result(goal).map_err(|problem| format!("the result cannot be requested: {problem}"))
    }

    fn cancel(&mut self, goal: GoalId) {
        // The test has failed already; a node that does not hear this ends by its own limits.
        let _ = self.client.cancel_goal(goal);
    }

    fn answer(&mut self) -> Option<(RmwRequestId, bool)> {
        let answer = self.client.goal_client().receive_response().ok().flatten()?;
        Some((answer.0, answer.1.accepted))
    }

    fn result(&mut self) -> Option<(RmwRequestId, bool, TouchTestResult)> {
        // Feedback and status are not used, and must not pile up.
        while let Ok(Some(_)) = self.client.feedback_subscription().take() {}
        while let Ok(Some(_)) = self.client.status_subscription().take() {}
        let (request, response) = self.client.result_client().receive_response().ok().flatten()?;
        Some((request, response.status == SUCCEEDED, response.result))
    }
}
