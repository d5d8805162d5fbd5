//! New events of the log.

use vibrissa_edge::events::EventKind;
use vibrissa_edge::words::Word as _;

use crate::row::row;

/// Version of the events' data. It rises if a field is removed or changes its meaning; new fields come without a new version.
pub const EVENT_VERSION: i64 = 2;

row! {
    /// A new event.
    pub struct EventRow {
        /// Time of the event, µs since 1970 UTC by the supervisor's clock.
        pub recorded_us: i64,
        /// Version of `data`.
        pub version: i64,
        /// Kind of the event.
        pub kind: &'static str,
        /// Its readers: a word of [`Audience`](vibrissa_edge::events::Audience).
        pub audience: &'static str,
        /// Kind of the alarm, or state of the setpoint; `None` for other kinds.
        pub word: Option<&'static str>,
        /// Number of the robot in the database; `None` if the whole fleet is concerned.
        pub robot_id: Option<i64>,
        /// Number of the whisker in the database; `None` if no single whisker is concerned.
        pub whisker_id: Option<i64>,
        /// Data of the event, a JSON object.
        pub data: String,
    }
}

impl EventRow {
    /// An event about a whole fleet, without data.
    #[must_use]
    pub fn new(kind: EventKind, recorded_us: i64) -> Self {
        Self {
            recorded_us,
            version: EVENT_VERSION,
            kind: kind.word(),
            audience: kind.audience().word(),
            word: None,
            robot_id: None,
            whisker_id: None,
            data: "{}".to_owned(),
        }
    }

    /// The event about a robot.
    #[must_use]
    pub fn of_robot(self, robot_id: i64) -> Self {
        Self { robot_id: Some(robot_id), ..self }
    }
}
