//! The contract's topics, each with its message.

use crate::{QualityOfService, RobotTopic};

use super::examples;

/// A topic and the message that is sent on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Channel {
    /// A topic of a robot.
    Robot(RobotTopic),
    /// The topic that states whether a supervisor owns the fleet.
    SupervisorState,
    /// The topic on which the supervisor asks all robots of the fleet for something.
    SupervisorRequest,
}

impl Channel {
    /// All topics, in the contract's order.
    pub const ALL: [Self; 13] = [
        Self::Robot(RobotTopic::Connection),
        Self::Robot(RobotTopic::Factsheet),
        Self::Robot(RobotTopic::Contacts),
        Self::Robot(RobotTopic::Status),
        Self::Robot(RobotTopic::Receipt),
        Self::Robot(RobotTopic::Setpoint),
        Self::Robot(RobotTopic::SetpointState),
        Self::Robot(RobotTopic::Request),
        Self::Robot(RobotTopic::TestState),
        Self::Robot(RobotTopic::Estimate),
        Self::Robot(RobotTopic::Maintenance),
        Self::SupervisorState,
        Self::SupervisorRequest,
    ];

    /// Name of the topic in documents, such as `contacts`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Robot(topic) => topic.as_str(),
            Self::SupervisorState => "supervisor_state",
            Self::SupervisorRequest => "supervisor_request",
        }
    }

    /// Address of the topic, with parameters in braces.
    #[must_use]
    pub fn address(self) -> String {
        match self {
            Self::Robot(topic) => format!("whisker/v1/{{fleet}}/{{robot}}/{topic}"),
            Self::SupervisorState => "whisker/v1/{fleet}/supervisor/state".to_owned(),
            Self::SupervisorRequest => "whisker/v1/{fleet}/supervisor/request".to_owned(),
        }
    }

    /// Whether the robot sends the message; otherwise the supervisor does.
    #[must_use]
    pub const fn is_from_robot(self) -> bool {
        match self {
            Self::Robot(topic) => topic.is_from_robot(),
            Self::SupervisorState | Self::SupervisorRequest => false,
        }
    }

    /// Quality of service of the message, as MQTT's number.
    #[must_use]
    pub const fn qos(self) -> u8 {
        match self {
            Self::Robot(topic) => match topic.quality_of_service() {
                QualityOfService::AtMostOnce => 0,
                QualityOfService::AtLeastOnce => 1,
            },
            Self::SupervisorState | Self::SupervisorRequest => 1,
        }
    }

    /// Whether the broker retains the message.
    #[must_use]
    pub const fn is_retained(self) -> bool {
        match self {
            Self::Robot(topic) => topic.is_retained(),
            Self::SupervisorState => true,
            Self::SupervisorRequest => false,
        }
    }

    /// Purpose of the message and when it is sent, for robot engineers.
    #[must_use]
    pub const fn purpose(self) -> &'static str {
        match self {
            Self::Robot(RobotTopic::Connection) => {
                "Retained. ONLINE at each connection and on a request for BIRTH, OFFLINE before a deliberate disconnect, and CONNECTION_BROKEN as \
                 the last will, with the boot_id of the same connection."
            }
            Self::Robot(RobotTopic::Factsheet) => {
                "Retained. Arrays, whiskers and limits of the robot. Sent after each birth, on request, and when the \
                 versions of its programs are known. A robot whose broker has no retained messages (Retain Available \
                 is 0) publishes without the retain flag."
            }
            Self::Robot(RobotTopic::Contacts) => {
                "Contacts in batches. The robot stores each message, up to a limit, until a receipt covers its seq, \
                 and sends uncovered ones again with the same seq, oldest first, with exponential backoff while no \
                 receipt arrives. QoS 0 for robots that do so, 1 for others. The payload may be a map of CBOR (RFC 8949) instead \
                 of JSON, with the same fields, names as texts, and numbers as floats or integers. The first byte tells the \
                 encodings apart (0xA0 to 0xBF begin a CBOR map); over MQTT 5 such a message should also have the content \
                 type application/cbor."
            }
            Self::Robot(RobotTopic::Status) => "Sent every 1 to 10 s, on change, and on request.",
            Self::Robot(RobotTopic::Receipt) => {
                "The robot's contacts messages that are committed in the supervisor's database."
            }
            Self::Robot(RobotTopic::Setpoint) => {
                "A pressure to hold. Never retained, and it expires in the broker, too. The robot accepts it only if \
                 robot_boot_id is its own, (epoch, version) is higher than any seen for that whisker, expires_us is \
                 in the future by its own clock, and the pressure is in its factsheet's range. A repeated command_id \
                 is answered again and not applied again. Pressure and reading_gain belong together. A robot with \
                 applies_gain multiplies each reading of the whisker by the reading_gain of the setpoint that it \
                 reported APPLIED last. It changes the factor with that report. A setpoint that is REJECTED, SUPERSEDED or FAILED changes \
                 nothing, nor does a leak or another fault. If the robot gives the chamber another pressure by itself \
                 (without a supervisor, or for its own protection), the factor is 1 from that moment until the next APPLIED. In a \
                 new boot the factor is 1, or that of the estimate. Contacts have the strain before the factor. Where a \
                 robot uses gain, it does not use reading_gain: gain is the whole correction."
            }
            Self::Robot(RobotTopic::SetpointState) => {
                "Progress of a setpoint: RECEIVED, APPLYING, then one of APPLIED, REJECTED, FAILED or SUPERSEDED."
            }
            Self::Robot(RobotTopic::Request) => {
                "Asks the robot to send its factsheet or its status again, or to do a touch test. The robot accepts a touch \
                 test under the rules of a setpoint, and answers on test_state."
            }
            Self::Robot(RobotTopic::TestState) => {
                "Progress of a touch test: ACCEPTED or REJECTED, RUNNING, then DONE or FAILED. The contacts and missed \
                 touches of the test carry its test_id, and are sent before DONE."
            }
            Self::Robot(RobotTopic::Estimate) => {
                "Retained. Present lengths, conditions, pressures and gains of all whiskers. Sent when a length has \
                 changed by half the width of its 95 % interval or by 0.2 mm, when a condition, pressure or gain \
                 changes, after each birth and when a supervisor takes the fleet over; at most once a second. The robot \
                 ignores an estimate whose (epoch, version) is not higher than that of the last one that it took in \
                 this boot. It computes contact ratios with length_mm and corrects its readings with gain. A robot with \
                 applies_gain takes reading_gain only before its first APPLIED of the boot for that whisker, and only if \
                 pressure_mpa is the pressure that it holds by itself (within 0.0001 MPa). Before the \
                 first estimate of a boot the robot does not know the present lengths: the factory length is no \
                 evidence of them, so it sends distances instead of ratios."
            }
            Self::Robot(RobotTopic::Maintenance) => {
                "Retained, and optional: only a supervisor with the setting mqtt.maintenance_every_s sends it. For fleet \
                 controls and tools for maintenance; robots do not need it, and the shipped access lists do not let \
                 them read it. For each whisker the wear (length lost), the time of the last touch test, and the contacts \
                 that remain until it is too short to compensate for itself. Sent when a supervisor takes the fleet over and \
                 when a fact has changed, at most once in that time per robot. A decommissioned robot's message is cleared."
            }
            Self::SupervisorState => {
                "Retained, with a last will. States whether a supervisor owns the fleet, and its epoch. ONLINE is published \
                 at each connection and repeated every 5 s, because brokers forget. For tools: robots do not need it, \
                 and the shipped access lists do not let them read it."
            }
            Self::SupervisorRequest => {
                "Asks all robots of the fleet for BIRTH: each sends connection with ONLINE, then factsheet, in its present \
                 boot, at a random time within 2 s. So a supervisor knows its robots although the broker has forgotten \
                 their retained messages. Sent when a supervisor takes the fleet over, after each of its connections, and \
                 when it misses a birth; at most 10 times a minute. Never retained. Only supervisors may publish here. It is no \
                 sign that the fleet has an owner: a supervisor whose lease has just ended may have sent it. A \
                 robot that does not know this topic works with brokers that retain messages."
            }
        }
    }

    /// Valid example messages: the name and the JSON of each. At least one.
    #[must_use]
    pub const fn examples(self) -> &'static [(&'static str, &'static str)] {
        match self {
            Self::Robot(RobotTopic::Connection) => {
                &[("birth", examples::CONNECTION), ("last_will", examples::CONNECTION_WILL)]
            }
            Self::Robot(RobotTopic::Factsheet) => {
                &[("two_whiskers", examples::FACTSHEET), ("applies_gain", examples::FACTSHEET_GAIN)]
            }
            Self::Robot(RobotTopic::Contacts) => {
                &[("one_contact", examples::CONTACTS), ("touch_test", examples::CONTACTS_TOUCH_TEST)]
            }
            Self::Robot(RobotTopic::Status) => {
                &[("all_is_well", examples::STATUS), ("contacts_were_dropped", examples::STATUS_DROPPED)]
            }
            Self::Robot(RobotTopic::Receipt) => &[("one_is_missing", examples::RECEIPT)],
            Self::Robot(RobotTopic::Setpoint) => {
                &[("self_compensation", examples::SETPOINT), ("air_and_gain", examples::SETPOINT_GAIN)]
            }
            Self::Robot(RobotTopic::SetpointState) => {
                &[("applied", examples::SETPOINT_STATE), ("rejected", examples::SETPOINT_STATE_REJECTED)]
            }
            Self::Robot(RobotTopic::Request) => {
                &[("factsheet", examples::REQUEST), ("touch_test", examples::REQUEST_TOUCH_TEST)]
            }
            Self::Robot(RobotTopic::TestState) => {
                &[("done", examples::TEST_STATE), ("rejected", examples::TEST_STATE_REJECTED)]
            }
            Self::Robot(RobotTopic::Estimate) => {
                &[("trimmed_and_compensated", examples::ESTIMATE), ("air_and_gain", examples::ESTIMATE_GAIN)]
            }
            Self::Robot(RobotTopic::Maintenance) => &[("eroding_and_new", examples::MAINTENANCE)],
            Self::SupervisorState => &[("online", examples::SUPERVISOR_STATE)],
            Self::SupervisorRequest => &[("birth", examples::SUPERVISOR_REQUEST)],
        }
    }
}
