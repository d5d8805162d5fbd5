//! The part of a robot's state that is stored as one piece: everything except the whiskers.

use borsh::{BorshDeserialize, BorshSerialize};

use crate::robot::event::{AirControl, ArrayKind, Link, Task, TouchTests};
use crate::robot::health::duplicate::DuplicateWatch;
use crate::robot::health::exchange::CalledChange;
use crate::robot::health::misfit::MisfitWatch;
use crate::robot::state::clock::Clock;
use crate::robot::touch_tests::{TestBudget, TestTimes};
use crate::robot::{Compensation, Numbers, Sequences};
use crate::text::ShortText;
use crate::units::Micros;

/// The head of a robot's stored bytes, in this order.
#[derive(Debug, Clone, PartialEq, BorshSerialize, BorshDeserialize)]
pub(in crate::robot) struct Head {
    pub epoch: u64,
    pub link: Link,
    /// The newest boot, as its birth said.
    pub boot_id: Option<ShortText>,
    /// The clock of that boot.
    pub clock: Clock,
    pub sequences: Sequences,
    pub arrays: Vec<Array>,
    pub compensations: Vec<Compensation>,
    pub next_version: u64,
    pub next_trim: u32,
    pub next_compensation: u32,
    /// The policy must look at all arrays at the end of the next step.
    pub undecided: bool,
    /// An operator holds all whiskers, including those of a later layout.
    pub held: bool,
    /// Time from which this supervisor has listened: silence before it is not the robot's.
    pub listening_since: Micros,
    /// The robot was restored, not met for the first time: the pressures of its whiskers may have been set by commands
    /// that are not known here, because the database was restored or the state could not be read.
    pub is_taken_up: bool,
    /// Touch tests that the robot can do.
    pub touch_tests: TouchTests,
    /// Touch tests requested in the present hour.
    pub tests: TestBudget,
    /// Times for tests after a pause and on a schedule, by whisker; none of whiskers that were not touched since such
    /// tests were asked for.
    pub test_times: Vec<TestTimes>,
    /// The alarm for the robot's silence stands.
    pub silent: bool,
    /// End of the robot's last silence; 0 before the first.
    pub heard_again: Micros,
    /// Watch for a second robot of the same name.
    pub duplicate: DuplicateWatch,
    /// The robot multiplies its readings by the reading gain of the setpoint applied last.
    pub applies_gain: bool,
    /// Ways in which the robot can change the pressure of its chambers.
    pub air_control: AirControl,
    /// The place of the newest contact was a distance: its contact ratio is no better known than the length.
    pub states_distance: bool,
    /// How the newest contacts fit, by whisker; none before the first contact.
    pub misfits: Vec<MisfitWatch>,
    /// The newest changes of sensitivity that were called.
    pub called_changes: Vec<CalledChange>,
}

/// An array of the factsheet.
#[derive(Debug, Clone, PartialEq, Eq, BorshSerialize, BorshDeserialize)]
pub struct Array {
    /// Name, unique on the robot.
    pub name: ShortText,
    /// Type 1 or Type 2 of the paper.
    pub kind: ArrayKind,
    /// Use of its readings.
    pub task: Task,
}

impl Head {
    /// The head of a robot of which nothing is known.
    pub(in crate::robot) fn new(epoch: u64, numbers: Numbers) -> Self {
        Self {
            epoch,
            link: Link::Offline,
            boot_id: None,
            clock: Clock::default(),
            sequences: Sequences::default(),
            arrays: Vec::new(),
            compensations: Vec::new(),
            next_version: 0,
            next_trim: numbers.next_trim,
            next_compensation: numbers.next_compensation,
            undecided: false,
            held: false,
            listening_since: Micros::default(),
            is_taken_up: false,
            touch_tests: TouchTests::default(),
            tests: TestBudget::default(),
            test_times: Vec::new(),
            silent: false,
            heard_again: Micros::default(),
            duplicate: DuplicateWatch::default(),
            applies_gain: false,
            air_control: AirControl::FillAndVent,
            states_distance: false,
            misfits: Vec::new(),
            called_changes: Vec::new(),
        }
    }
}
