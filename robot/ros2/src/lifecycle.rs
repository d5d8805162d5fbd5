//! The lifecycle of a managed node, with the states and transitions of `lifecycle_msgs`.

use serde::{Deserialize, Serialize};

/// What the bridge does in a state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Activity {
    /// Nothing: messages of ROS are ignored, and the agent hears that readings are missing.
    Idle,
    /// Messages of ROS are passed on; there are no setpoints and no touch tests.
    Listening,
    /// Everything.
    Active,
}

/// `lifecycle_msgs/msg/State`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the names of ROS")]
pub struct State {
    pub id: u8,
    pub label: String,
}

/// `lifecycle_msgs/msg/Transition`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the names of ROS")]
pub struct Transition {
    pub id: u8,
    pub label: String,
}

/// `lifecycle_msgs/msg/TransitionDescription`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the names of ROS")]
pub struct TransitionDescription {
    pub transition: Transition,
    pub start_state: State,
    pub goal_state: State,
}

/// `lifecycle_msgs/msg/TransitionEvent`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the names of ROS")]
pub struct TransitionEvent {
    pub timestamp: u64,
    pub transition: Transition,
    pub start_state: State,
    pub goal_state: State,
}

const UNCONFIGURED: u8 = 1;
const INACTIVE: u8 = 2;
const ACTIVE: u8 = 3;
const FINALIZED: u8 = 4;
const CONFIGURING: u8 = 10;
const CLEANING_UP: u8 = 11;
const SHUTTING_DOWN: u8 = 12;
const ACTIVATING: u8 = 13;
const DEACTIVATING: u8 = 14;

/// All states with their labels.
const STATES: [(u8, &str); 11] = [
    (0, "unknown"),
    (UNCONFIGURED, "unconfigured"),
    (INACTIVE, "inactive"),
    (ACTIVE, "active"),
    (FINALIZED, "finalized"),
    (CONFIGURING, "configuring"),
    (CLEANING_UP, "cleaningup"),
    (SHUTTING_DOWN, "shuttingdown"),
    (ACTIVATING, "activating"),
    (DEACTIVATING, "deactivating"),
    (15, "errorprocessing"),
];

struct Row {
    id: u8,
    label: &'static str,
    start: u8,
    /// State during the transition.
    via: u8,
    /// Transition that ends it.
    success: u8,
    goal: u8,
}

const fn row(id: u8, label: &'static str, [start, via, success, goal]: [u8; 4]) -> Row {
    Row { id, label, start, via, success, goal }
}

const ROWS: [Row; 7] = [
    row(1, "configure", [UNCONFIGURED, CONFIGURING, 10, INACTIVE]),
    row(2, "cleanup", [INACTIVE, CLEANING_UP, 20, UNCONFIGURED]),
    row(3, "activate", [INACTIVE, ACTIVATING, 30, ACTIVE]),
    row(4, "deactivate", [ACTIVE, DEACTIVATING, 40, INACTIVE]),
    row(5, "shutdown", [UNCONFIGURED, SHUTTING_DOWN, 50, FINALIZED]),
    row(6, "shutdown", [INACTIVE, SHUTTING_DOWN, 50, FINALIZED]),
    row(7, "shutdown", [ACTIVE, SHUTTING_DOWN, 50, FINALIZED]),
];

fn state(id: u8) -> State {
    let label = STATES.iter().find(|(of, _)| *of == id).map_or("unknown", |(_, label)| label);
    State { id, label: label.to_owned() }
}

impl Row {
    /// The transition to the state between, and the one from there.
    fn parts(&self) -> [TransitionDescription; 2] {
        let part = |id: u8, label: &str, start: u8, goal: u8| TransitionDescription {
            transition: Transition { id, label: label.to_owned() },
            start_state: state(start),
            goal_state: state(goal),
        };
        [part(self.id, self.label, self.start, self.via), part(self.success, "transition_success", self.via, self.goal)]
    }
}

/// The state of the node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Lifecycle {
    state: u8,
}

impl Default for Lifecycle {
    fn default() -> Self {
        Self { state: UNCONFIGURED }
    }
}

impl Lifecycle {
    /// The present state.
    #[must_use]
    pub fn state(self) -> State {
        state(self.state)
    }

    /// What the bridge does now.
    #[must_use]
    pub fn activity(self) -> Activity {
        match self.state {
            ACTIVE => Activity::Active,
            INACTIVE => Activity::Listening,
            _ => Activity::Idle,
        }
    }

    /// All states.
    #[must_use]
    pub fn states() -> Vec<State> {
        STATES.iter().map(|(id, _)| state(*id)).collect()
    }

    /// The transitions that are possible now.
    #[must_use]
    pub fn available(self) -> Vec<TransitionDescription> {
        let possible = ROWS.iter().filter(|row| row.start == self.state);
        possible.map(|row| row.parts()[0].clone()).collect()
    }

    /// All transitions.
    #[must_use]
    pub fn graph() -> Vec<TransitionDescription> {
        ROWS.iter().flat_map(Row::parts).collect()
    }

    /// Makes a transition, which is named by its label or, without one, by its number. Returns its two parts.
    pub fn change(&mut self, asked: &Transition) -> Option<[TransitionDescription; 2]> {
        let is_asked = |row: &&Row| if asked.label.is_empty() { row.id == asked.id } else { row.label == asked.label };
        let row = ROWS.iter().filter(|row| row.start == self.state).find(is_asked)?;
        self.state = row.goal;
        Some(row.parts())
    }
}
