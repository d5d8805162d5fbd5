//! The topics of the contract, each with the one message that is sent on it.

use crate::{QualityOfService, RobotTopic};

use super::examples;

/// A topic and its message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Channel {
    /// A robot's.
    Robot(RobotTopic),
    /// Whether a supervisor owns the fleet.
    SupervisorState,
}

impl Channel {
    /// All of them, in the contract's order.
    pub const ALL: [Self; 9] = [
        Self::Robot(RobotTopic::Connection),
        Self::Robot(RobotTopic::Factsheet),
        Self::Robot(RobotTopic::Contacts),
        Self::Robot(RobotTopic::Status),
        Self::Robot(RobotTopic::Receipt),
        Self::Robot(RobotTopic::Setpoint),
        Self::Robot(RobotTopic::SetpointState),
        Self::Robot(RobotTopic::Request),
        Self::SupervisorState,
    ];

    /// Its name in documents, such as `contacts`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Robot(topic) => topic.as_str(),
            Self::SupervisorState => "supervisor_state",
        }
    }

    /// Its topic, with parameters in braces.
    #[must_use]
    pub fn address(self) -> String {
        match self {
            Self::Robot(topic) => format!("whisker/v1/{{fleet}}/{{robot}}/{topic}"),
            Self::SupervisorState => "whisker/v1/{fleet}/supervisor/state".to_owned(),
        }
    }

    /// Whether the robot sends it; otherwise the supervisor does.
    #[must_use]
    pub const fn is_from_robot(self) -> bool {
        match self {
            Self::Robot(topic) => topic.is_from_robot(),
            Self::SupervisorState => false,
        }
    }

    /// The quality of service it is sent with, as MQTT's number.
    #[must_use]
    pub const fn qos(self) -> u8 {
        match self {
            Self::Robot(topic) => match topic.quality_of_service() {
                QualityOfService::AtMostOnce => 0,
                QualityOfService::AtLeastOnce => 1,
            },
            Self::SupervisorState => 1,
        }
    }

    /// Whether the broker retains it.
    #[must_use]
    pub const fn is_retained(self) -> bool {
        match self {
            Self::Robot(topic) => topic.is_retained(),
            Self::SupervisorState => true,
        }
    }

    /// What it is for and when it is sent, for the robot's engineer.
    #[must_use]
    pub const fn purpose(self) -> &'static str {
        match self {
            Self::Robot(RobotTopic::Connection) => {
                "Retained. ONLINE at each connection, OFFLINE before leaving in good order, and CONNECTION_BROKEN as the \
                 last will, with the boot_id of the connection that it belongs to."
            }
            Self::Robot(RobotTopic::Factsheet) => {
                "Retained. What is on the robot: arrays, whiskers, limits. After each birth, and again on request."
            }
            Self::Robot(RobotTopic::Contacts) => {
                "Contacts in batches. The robot keeps each message, in bounded number, until a receipt covers its seq, \
                 and sends uncovered ones again under their old seq, oldest first, with exponential backoff while no \
                 receipt comes. QoS 0 for robots that do so, 1 for others."
            }
            Self::Robot(RobotTopic::Status) => "Every 1 to 10 s and on change; again on request.",
            Self::Robot(RobotTopic::Receipt) => {
                "How far the robot's contacts are committed in the supervisor's database."
            }
            Self::Robot(RobotTopic::Setpoint) => {
                "A pressure to hold. Never retained, and it expires in the broker, too. The robot takes it only if \
                 robot_boot_id is its own, (epoch, version) is higher than any seen for that whisker, expires_us lies \
                 ahead on its own clock, and the pressure is in its factsheet's range. The same command_id again is \
                 answered again and not applied again."
            }
            Self::Robot(RobotTopic::SetpointState) => {
                "What became of a setpoint: RECEIVED, APPLYING, then one of APPLIED, REJECTED, FAILED or SUPERSEDED."
            }
            Self::Robot(RobotTopic::Request) => "Asks the robot to send its factsheet or its status again.",
            Self::SupervisorState => {
                "Retained, with a last will. Whether a supervisor owns the fleet, and in which epoch. For tools: a robot \
                 needs it for nothing, and the shipped access lists do not let it read this."
            }
        }
    }

    /// Messages that keep the contract: what each shows, and its JSON. At least one.
    #[must_use]
    pub const fn examples(self) -> &'static [(&'static str, &'static str)] {
        match self {
            Self::Robot(RobotTopic::Connection) => {
                &[("birth", examples::CONNECTION), ("last_will", examples::CONNECTION_WILL)]
            }
            Self::Robot(RobotTopic::Factsheet) => &[("two_whiskers", examples::FACTSHEET)],
            Self::Robot(RobotTopic::Contacts) => &[("one_contact", examples::CONTACTS)],
            Self::Robot(RobotTopic::Status) => {
                &[("all_is_well", examples::STATUS), ("contacts_were_dropped", examples::STATUS_DROPPED)]
            }
            Self::Robot(RobotTopic::Receipt) => &[("one_is_missing", examples::RECEIPT)],
            Self::Robot(RobotTopic::Setpoint) => &[("self_compensation", examples::SETPOINT)],
            Self::Robot(RobotTopic::SetpointState) => {
                &[("applied", examples::SETPOINT_STATE), ("rejected", examples::SETPOINT_STATE_REJECTED)]
            }
            Self::Robot(RobotTopic::Request) => &[("factsheet", examples::REQUEST)],
            Self::SupervisorState => &[("online", examples::SUPERVISOR_STATE)],
        }
    }
}
