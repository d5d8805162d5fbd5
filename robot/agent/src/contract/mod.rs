//! The rules of the contract for a robot, without sockets and clock. Durations are measured by [`Moment`]s; the
//! times in messages are in microseconds since 1970 UTC by the robot's clock.

pub mod births;
pub mod commands;
pub mod estimates;
pub mod outbox;
pub mod reading_gain;
pub mod response;
pub mod supervision;
pub mod time;
pub mod touch_tests;
pub mod voice;

pub use births::Births;
pub use commands::{Addressee, CommandAnswer, Commands, Verdict};
pub use estimates::EstimateOrder;
pub use outbox::Outbox;
pub use reading_gain::ReadingGain;
pub use response::Response;
pub use supervision::Supervision;
pub use time::{Moment, Now};
pub use touch_tests::{TestAnswer, TestVerdict, Tested, TouchTests};
pub use voice::{Facts, Voice};

use vibrissa_protocol::RobotTopic;

/// Action for the network.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Outgoing {
    /// Publish on one of the robot's topics, with that topic's quality of service and retain flag.
    Publish {
        /// Topic of the message.
        topic: RobotTopic,
        /// Encoded message.
        payload: Vec<u8>,
    },
    /// The robot has restarted: cut the connection without a farewell, then connect again.
    Restart,
}
