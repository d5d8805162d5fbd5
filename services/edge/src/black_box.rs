//! The lines of a black box that are not messages of MQTT: its description, and the robot's state at its beginning.
//!
//! Their topics are outside of the contract, so that a program that reads recordings can skip them.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::{Deserialize, Serialize};
use vibrissa_core::robot::{RestoreError, Robot};
use vibrissa_core::units::Micros;
use vibrissa_protocol::Name;

use crate::recording::Recorded;

/// Version of both lines.
const FORMAT: u32 = 1;
/// Beginning of the topic of the line that describes the box; the fleet's and the robot's name follow.
const ABOUT: &str = "vibrissa/black-box/";
/// Beginning of the topic of the line with the robot's state.
const STATE: &str = "vibrissa/robot-state/";

/// Description of a black box, as the payload of its first line.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct About {
    /// Version of this line.
    pub format: u32,
    /// Number of the box in the database.
    pub black_box_id: i64,
    /// `TRIM`, or the kind of fault or alarm that opened the box.
    pub cause: String,
    /// Time of the event that opened it, µs since 1970 UTC by the supervisor's clock.
    pub event_us: i64,
    /// Time of its beginning, by the same clock.
    pub began_us: i64,
    /// Time of its end, by the same clock; planned, unless the state is `COMPLETE`.
    pub ends_us: i64,
    /// `RECORDING`, `COMPLETE` or `PARTIAL`.
    pub state: String,
    /// Messages between beginning and end that the limits of memory left out.
    pub left_out: i64,
}

impl About {
    /// Version of the line that this program writes.
    pub const FORMAT: u32 = FORMAT;

    /// The line with this description.
    #[must_use]
    pub fn line(&self, fleet: &str, robot: &str) -> Recorded {
        let payload = serde_json::to_vec(self).unwrap_or_default();
        let received = Micros(u64::try_from(self.began_us).unwrap_or_default());
        Recorded { received, topic: format!("{ABOUT}{fleet}/{robot}"), payload }
    }
}

#[derive(Serialize, Deserialize)]
struct StatePayload {
    format: u32,
    head: String,
    whiskers: Vec<String>,
}

/// State of a robot as the bytes of its checkpoint: those of the head, and those of each whisker.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct StateBytes {
    /// Bytes of the head.
    pub head: Vec<u8>,
    /// Bytes of each whisker.
    pub whiskers: Vec<Vec<u8>>,
}

/// Why the state in a box cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum StateError {
    /// Not a line of this format.
    #[error("the line with the robot's state cannot be read: {0}")]
    Malformed(String),
    /// Written by another version of the program.
    #[error(transparent)]
    Version(#[from] RestoreError),
}

impl StateBytes {
    /// The state of a robot; `None` if it has more than `bytes_max` bytes, or cannot be encoded.
    #[must_use]
    pub fn within(robot: &Robot, bytes_max: usize) -> Option<Self> {
        let mut state = Self { head: robot.to_bytes()?, whiskers: Vec::with_capacity(robot.whisker_count()) };
        let mut rest = bytes_max.checked_sub(state.head.len())?;
        for index in 0..robot.whisker_count() {
            let bytes = robot.whisker_to_bytes(index)?;
            rest = rest.checked_sub(bytes.len())?;
            state.whiskers.push(bytes);
        }
        Some(state)
    }

    /// Number of bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.head.len() + self.whiskers.iter().map(Vec::len).sum::<usize>()
    }

    /// The line with this state.
    #[must_use]
    pub fn line(&self, at: Micros, fleet: &str, robot: &str) -> Recorded {
        let payload = StatePayload {
            format: FORMAT,
            head: STANDARD.encode(&self.head),
            whiskers: self.whiskers.iter().map(|bytes| STANDARD.encode(bytes)).collect(),
        };
        let payload = serde_json::to_vec(&payload).unwrap_or_default();
        Recorded { received: at, topic: format!("{STATE}{fleet}/{robot}"), payload }
    }
}

/// A line of a black box that is no message of MQTT.
#[derive(Debug)]
pub enum Special {
    /// It describes the box.
    About,
    /// State of a robot at the line's time.
    State {
        /// Name of the fleet.
        fleet: Name,
        /// Name of the robot.
        robot: Name,
        /// The restored robot, or the reason why it cannot be restored.
        state: Result<Box<Robot>, StateError>,
    },
}

impl Special {
    /// The special line; `None` for a message of MQTT.
    #[must_use]
    pub fn of(recorded: &Recorded) -> Option<Self> {
        if recorded.topic.starts_with(ABOUT) {
            return Some(Self::About);
        }
        let (fleet, robot) = recorded.topic.strip_prefix(STATE)?.split_once('/')?;
        let (fleet, robot) = (Name::new(fleet).ok()?, Name::robot(robot).ok()?);
        Some(Self::State { fleet, robot, state: restored(&recorded.payload).map(Box::new) })
    }
}

fn restored(payload: &[u8]) -> Result<Robot, StateError> {
    let malformed = |problem: &dyn std::fmt::Display| StateError::Malformed(problem.to_string());
    let stored: StatePayload = serde_json::from_slice(payload).map_err(|problem| malformed(&problem))?;
    if stored.format != FORMAT {
        return Err(malformed(&format_args!("format {}, and this program reads format {FORMAT}", stored.format)));
    }
    let decode = |text: &String| STANDARD.decode(text).map_err(|problem| malformed(&problem));
    let whiskers = stored.whiskers.iter().map(decode).collect::<Result<Vec<_>, _>>()?;
    Ok(Robot::restore(&decode(&stored.head)?, &whiskers)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use vibrissa_core::robot::Numbers;

    #[test]
    fn a_state_comes_back_and_another_format_is_named() {
        let robot = Robot::new(7, Numbers::default());
        let line = StateBytes::within(&robot, 1000).unwrap().line(Micros(5), "lab", "crawler");
        let Some(Special::State { fleet, robot: name, state: Ok(again) }) = Special::of(&line) else {
            panic!("{line:?}")
        };
        assert_eq!((fleet.as_str(), name.as_str(), again.to_bytes()), ("lab", "crawler", robot.to_bytes()));
        let text = String::from_utf8(line.payload.clone()).unwrap().replace("\"format\":1", "\"format\":9");
        let Some(Special::State { state: Err(problem), .. }) =
            Special::of(&Recorded { payload: text.into_bytes(), ..line })
        else {
            panic!("another format is refused")
        };
        assert!(problem.to_string().contains("format 9"), "{problem}");
    }

    #[test]
    fn a_state_above_the_limit_is_left_out() {
        let robot = Robot::new(7, Numbers::default());
        let bytes = StateBytes::within(&robot, usize::MAX).unwrap().bytes();
        assert!(StateBytes::within(&robot, bytes).is_some() && StateBytes::within(&robot, bytes - 1).is_none());
    }

    #[test]
    fn messages_are_no_special_lines() {
        let topic = "whisker/v1/lab/crawler/contacts".to_owned();
        assert!(Special::of(&Recorded { received: Micros(1), topic, payload: b"{}".to_vec() }).is_none());
    }
}
