//! Topic levels: `whisker/v1/{fleet}/{robot}/{topic}`, `whisker/v1/{fleet}/supervisor/state` and
//! `whisker/v1/{fleet}/supervisor/request`.

use std::fmt;

use crate::{Name, Refusal};

const ROOT: &str = "whisker/v1/";
const EXPECTED: &str =
    "expected whisker/v1/{fleet}/{robot}/{topic} or whisker/v1/{fleet}/supervisor/state or .../supervisor/request";
/// Last level of [`Topic::SupervisorState`].
const STATE: &str = "state";
/// Last level of [`Topic::SupervisorRequest`].
const REQUEST: &str = "request";

/// The two MQTT qualities of service that the contract uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum QualityOfService {
    /// QoS 0: the message may be lost.
    AtMostOnce,
    /// QoS 1: the message may arrive more than once.
    AtLeastOnce,
}

/// The last level of a robot's topics.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum RobotTopic {
    /// From the robot: online, offline, or (as last will) connection broken.
    Connection,
    /// From the robot: its arrays and whiskers.
    Factsheet,
    /// From the robot: a batch of contacts.
    Contacts,
    /// From the robot: chamber pressures, condition of regulators and gauges.
    Status,
    /// From the supervisor: which contacts are committed.
    Receipt,
    /// From the supervisor: a pressure to hold.
    Setpoint,
    /// From the robot: progress or result of a setpoint.
    SetpointState,
    /// From the supervisor: asks for a message again, or for a touch test.
    Request,
    /// From the robot: progress or result of a touch test.
    TestState,
    /// From the supervisor: present lengths of the whiskers.
    Estimate,
    /// From the supervisor, to other tools: facts for the maintenance of the whiskers. Optional.
    Maintenance,
}

impl RobotTopic {
    /// All topics, in the contract's order.
    pub const ALL: [Self; 11] = [
        Self::Connection,
        Self::Factsheet,
        Self::Contacts,
        Self::Status,
        Self::Receipt,
        Self::Setpoint,
        Self::SetpointState,
        Self::Request,
        Self::TestState,
        Self::Estimate,
        Self::Maintenance,
    ];

    /// Text of the topic level.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Connection => "connection",
            Self::Factsheet => "factsheet",
            Self::Contacts => "contacts",
            Self::Status => "status",
            Self::Receipt => "receipt",
            Self::Setpoint => "setpoint",
            Self::SetpointState => "setpoint_state",
            Self::Request => "request",
            Self::TestState => "test_state",
            Self::Estimate => "estimate",
            Self::Maintenance => "maintenance",
        }
    }

    /// Whether the robot sends the message; otherwise the supervisor does.
    #[must_use]
    pub const fn is_from_robot(self) -> bool {
        match self {
            Self::Connection
            | Self::Factsheet
            | Self::Contacts
            | Self::Status
            | Self::SetpointState
            | Self::TestState => true,
            Self::Receipt | Self::Setpoint | Self::Request | Self::Estimate | Self::Maintenance => false,
        }
    }

    /// Quality of service of the message; for contacts, that of robots that send again without a receipt.
    #[must_use]
    pub const fn quality_of_service(self) -> QualityOfService {
        match self {
            Self::Contacts | Self::Status | Self::Receipt => QualityOfService::AtMostOnce,
            Self::Connection
            | Self::Factsheet
            | Self::Setpoint
            | Self::SetpointState
            | Self::Request
            | Self::TestState
            | Self::Estimate
            | Self::Maintenance => QualityOfService::AtLeastOnce,
        }
    }

    /// Whether the broker retains the message.
    #[must_use]
    pub const fn is_retained(self) -> bool {
        match self {
            Self::Connection | Self::Factsheet | Self::Estimate | Self::Maintenance => true,
            Self::Contacts
            | Self::Status
            | Self::Receipt
            | Self::Setpoint
            | Self::SetpointState
            | Self::Request
            | Self::TestState => false,
        }
    }

    /// Subscription to this topic of all robots of a fleet: `whisker/v1/{fleet}/+/contacts`.
    #[must_use]
    pub fn fleet_filter(self, fleet: &Name) -> String {
        format!("{ROOT}{fleet}/+/{self}")
    }

    /// Topic of the supervisor's probes for [`Self::fleet_filter`]: `whisker/v1/{fleet}/supervisor/contacts`. The
    /// filter matches it like robots' topics, and no robot may publish there.
    #[must_use]
    pub fn probe_topic(self, fleet: &Name) -> String {
        format!("{ROOT}{fleet}/{}/{self}", Name::RESERVED)
    }

    /// The topic that a probe received on `topic` tests; `None` if `topic` is not that of a probe.
    #[must_use]
    pub fn probed_on(topic: &str) -> Option<Self> {
        let (fleet, kind) = topic.strip_prefix(ROOT)?.split_once('/')?;
        let kind = kind.strip_prefix(Name::RESERVED)?.strip_prefix('/')?;
        Name::new(fleet).ok()?;
        Self::ALL.into_iter().filter(|one| one.is_from_robot()).find(|one| one.as_str() == kind)
    }

    /// This topic for one robot.
    #[must_use]
    pub fn of(self, fleet: &Name, robot: &Name) -> Topic {
        Topic::Robot { fleet: fleet.clone(), robot: robot.clone(), kind: self }
    }
}

impl fmt::Display for RobotTopic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.as_str())
    }
}

/// A topic of the contract.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Topic {
    /// A topic of one robot.
    Robot {
        /// Fleet of the robot.
        fleet: Name,
        /// Name of the robot, never `supervisor`.
        robot: Name,
        /// Last level of the topic.
        kind: RobotTopic,
    },
    /// The topic that states whether a supervisor owns the fleet.
    SupervisorState {
        /// Name of the fleet.
        fleet: Name,
    },
    /// The topic on which the supervisor asks all robots of the fleet for something.
    SupervisorRequest {
        /// Name of the fleet.
        fleet: Name,
    },
}

impl Topic {
    /// Parses a topic.
    ///
    /// # Errors
    /// [`Refusal::UnknownTopic`] if it is not part of the contract, [`Refusal::BadName`] if a level is not a valid
    /// name.
    pub fn parse(text: &str) -> Result<Self, Refusal> {
        let unknown = || Refusal::UnknownTopic { topic: text.chars().take(200).collect(), expected: EXPECTED };
        let mut levels = text.strip_prefix(ROOT).ok_or_else(unknown)?.split('/');
        let (Some(fleet), Some(robot), Some(last), None) = (levels.next(), levels.next(), levels.next(), levels.next())
        else {
            return Err(unknown());
        };
        let fleet = Name::new(fleet).map_err(|source| Refusal::BadName { level: "fleet", source })?;
        if robot == Name::RESERVED {
            return match last {
                STATE => Ok(Self::SupervisorState { fleet }),
                REQUEST => Ok(Self::SupervisorRequest { fleet }),
                _ => Err(unknown()),
            };
        }
        let robot = Name::robot(robot).map_err(|source| Refusal::BadName { level: "robot", source })?;
        let kind = RobotTopic::ALL.into_iter().find(|kind| kind.as_str() == last).ok_or_else(unknown)?;
        Ok(Self::Robot { fleet, robot, kind })
    }

    /// Fleet of the topic.
    #[must_use]
    pub fn fleet(&self) -> &Name {
        match self {
            Self::Robot { fleet, .. } | Self::SupervisorState { fleet } | Self::SupervisorRequest { fleet } => fleet,
        }
    }
}

impl fmt::Display for Topic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Robot { fleet, robot, kind } => write!(f, "{ROOT}{fleet}/{robot}/{kind}"),
            Self::SupervisorState { fleet } => write!(f, "{ROOT}{fleet}/{}/{STATE}", Name::RESERVED),
            Self::SupervisorRequest { fleet } => write!(f, "{ROOT}{fleet}/{}/{REQUEST}", Name::RESERVED),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_topic_round_trips() {
        let (fleet, robot) = (Name::new("f1").unwrap(), Name::new("r-1").unwrap());
        for kind in RobotTopic::ALL {
            let topic = kind.of(&fleet, &robot);
            assert_eq!(topic.to_string(), format!("whisker/v1/f1/r-1/{kind}"));
            assert_eq!(Topic::parse(&topic.to_string()), Ok(topic));
        }
        let (state, request) = (Topic::SupervisorState { fleet: fleet.clone() }, Topic::SupervisorRequest { fleet });
        for (topic, text) in [(state, "whisker/v1/f1/supervisor/state"), (request, "whisker/v1/f1/supervisor/request")]
        {
            assert_eq!(topic.to_string(), text);
            assert_eq!(Topic::parse(text), Ok(topic));
        }
    }

    #[test]
    fn one_wildcard_stands_for_every_robot() {
        let fleet = Name::new("f1").unwrap();
        assert_eq!(RobotTopic::Contacts.fleet_filter(&fleet), "whisker/v1/f1/+/contacts");
    }

    #[test]
    fn a_probes_topic_is_no_robots_and_matches_the_filter_that_it_proves() {
        let fleet = Name::new("f1").unwrap();
        for kind in RobotTopic::ALL {
            let topic = kind.probe_topic(&fleet);
            assert_eq!(topic, kind.fleet_filter(&fleet).replace('+', "supervisor"));
            assert_eq!(RobotTopic::probed_on(&topic), Some(kind).filter(|kind| kind.is_from_robot()));
            let is_request_to_all = Topic::parse(&topic) == Ok(Topic::SupervisorRequest { fleet: fleet.clone() });
            assert_eq!(is_request_to_all, kind == RobotTopic::Request, "{topic}");
            assert!(is_request_to_all || Topic::parse(&topic).is_err(), "{topic}");
        }
        for other in ["whisker/v1/f1/r/contacts", "whisker/v1/f1/supervisor/state", "whisker/v1/supervisor/contacts"] {
            assert_eq!(RobotTopic::probed_on(other), None, "{other}");
        }
    }

    #[test]
    fn what_is_no_topic_is_refused_by_its_label() {
        for (text, label) in [
            ("", "unknown_topic"),
            ("whisker/v2/f/r/contacts", "unknown_topic"),
            ("whisker/v1/f/r", "unknown_topic"),
            ("whisker/v1/f/r/contacts/more", "unknown_topic"),
            ("whisker/v1/f/r/nonsense", "unknown_topic"),
            ("whisker/v1/f/supervisor/contacts", "unknown_topic"),
            ("whisker/v1//r/contacts", "bad_name"),
            ("whisker/v1/f/a b/contacts", "bad_name"),
        ] {
            assert_eq!(Topic::parse(text).unwrap_err().label(), label, "{text}");
        }
    }
}
