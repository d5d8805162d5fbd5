//! Topic levels: `whisker/v1/{fleet}/{robot}/{topic}` and `whisker/v1/{fleet}/supervisor/state`.

use std::fmt;

use crate::{Name, Refusal};

const ROOT: &str = "whisker/v1/";
const EXPECTED: &str = "expected whisker/v1/{fleet}/{robot}/{topic} or whisker/v1/{fleet}/supervisor/state";

/// What MQTT promises about a message: the two levels that the contract uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum QualityOfService {
    /// QoS 0.
    AtMostOnce,
    /// QoS 1.
    AtLeastOnce,
}

/// The last level of a robot's topics.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum RobotTopic {
    /// Robot: online, offline, or (as last will) broken.
    Connection,
    /// Robot: what is on it.
    Factsheet,
    /// Robot: a batch of contacts.
    Contacts,
    /// Robot: chamber pressures, regulator and gauge condition.
    Status,
    /// Supervisor: how far the robot's contacts are committed.
    Receipt,
    /// Supervisor: a pressure to hold.
    Setpoint,
    /// Robot: what became of a setpoint.
    SetpointState,
    /// Supervisor: send something again.
    Request,
}

impl RobotTopic {
    /// All of them, in the contract's order.
    pub const ALL: [Self; 8] = [
        Self::Connection,
        Self::Factsheet,
        Self::Contacts,
        Self::Status,
        Self::Receipt,
        Self::Setpoint,
        Self::SetpointState,
        Self::Request,
    ];

    /// The level's text.
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
        }
    }

    /// Whether the robot sends it; otherwise the supervisor does.
    #[must_use]
    pub const fn is_from_robot(self) -> bool {
        match self {
            Self::Connection | Self::Factsheet | Self::Contacts | Self::Status | Self::SetpointState => true,
            Self::Receipt | Self::Setpoint | Self::Request => false,
        }
    }

    /// The quality of service it is sent with; for contacts, that of robots that send again by receipt.
    #[must_use]
    pub const fn quality_of_service(self) -> QualityOfService {
        match self {
            Self::Contacts | Self::Status | Self::Receipt => QualityOfService::AtMostOnce,
            Self::Connection | Self::Factsheet | Self::Setpoint | Self::SetpointState | Self::Request => {
                QualityOfService::AtLeastOnce
            }
        }
    }

    /// Whether the broker retains it.
    #[must_use]
    pub const fn is_retained(self) -> bool {
        match self {
            Self::Connection | Self::Factsheet => true,
            Self::Contacts | Self::Status | Self::Receipt | Self::Setpoint | Self::SetpointState | Self::Request => {
                false
            }
        }
    }

    /// The subscription to this topic of every robot of a fleet: `whisker/v1/{fleet}/+/contacts`.
    #[must_use]
    pub fn fleet_filter(self, fleet: &Name) -> String {
        format!("{ROOT}{fleet}/+/{self}")
    }

    /// The topic of the supervisor's probes for [`Self::fleet_filter`]: `whisker/v1/{fleet}/supervisor/contacts`. The filter
    /// matches it as it matches robots' topics, and no robot may publish there.
    #[must_use]
    pub fn probe_topic(self, fleet: &Name) -> String {
        format!("{ROOT}{fleet}/{}/{self}", Name::RESERVED)
    }

    /// The topic that a probe on `topic` is for; none if `topic` is not a probe's.
    #[must_use]
    pub fn probed_on(topic: &str) -> Option<Self> {
        let (fleet, kind) = topic.strip_prefix(ROOT)?.split_once('/')?;
        let kind = kind.strip_prefix(Name::RESERVED)?.strip_prefix('/')?;
        Name::new(fleet).ok()?;
        Self::ALL.into_iter().filter(|one| one.is_from_robot()).find(|one| one.as_str() == kind)
    }

    /// This topic of one robot.
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
    /// Of one robot.
    Robot {
        /// Its fleet.
        fleet: Name,
        /// Its name, never `supervisor`.
        robot: Name,
        /// The last level.
        kind: RobotTopic,
    },
    /// Whether a supervisor owns the fleet.
    SupervisorState {
        /// The fleet.
        fleet: Name,
    },
}

impl Topic {
    /// Reads a topic.
    ///
    /// # Errors
    /// [`Refusal::UnknownTopic`] if it is not one of the contract, [`Refusal::BadName`] if a level is no name.
    pub fn parse(text: &str) -> Result<Self, Refusal> {
        let unknown = || Refusal::UnknownTopic { topic: text.chars().take(200).collect(), expected: EXPECTED };
        let mut levels = text.strip_prefix(ROOT).ok_or_else(unknown)?.split('/');
        let (Some(fleet), Some(robot), Some(last), None) = (levels.next(), levels.next(), levels.next(), levels.next())
        else {
            return Err(unknown());
        };
        let fleet = Name::new(fleet).map_err(|source| Refusal::BadName { level: "fleet", source })?;
        if robot == Name::RESERVED {
            return if last == "state" { Ok(Self::SupervisorState { fleet }) } else { Err(unknown()) };
        }
        let robot = Name::robot(robot).map_err(|source| Refusal::BadName { level: "robot", source })?;
        let kind = RobotTopic::ALL.into_iter().find(|kind| kind.as_str() == last).ok_or_else(unknown)?;
        Ok(Self::Robot { fleet, robot, kind })
    }

    /// The fleet that it belongs to.
    #[must_use]
    pub fn fleet(&self) -> &Name {
        match self {
            Self::Robot { fleet, .. } | Self::SupervisorState { fleet } => fleet,
        }
    }
}

impl fmt::Display for Topic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Robot { fleet, robot, kind } => write!(f, "{ROOT}{fleet}/{robot}/{kind}"),
            Self::SupervisorState { fleet } => write!(f, "{ROOT}{fleet}/{}/state", Name::RESERVED),
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
        let state = Topic::SupervisorState { fleet };
        assert_eq!(Topic::parse("whisker/v1/f1/supervisor/state"), Ok(state));
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
            assert!(Topic::parse(&topic).is_err(), "{topic}");
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
