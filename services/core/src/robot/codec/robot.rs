//! The stored bytes of a robot: its head and each whisker separately, so that a checkpoint writes only the changed
//! parts.

use borsh::BorshDeserialize;

use crate::robot::compensation::Compensation;
use crate::robot::effect::WhiskerIndex;
use crate::robot::event::{ArrayKind, Link, Task, TouchTests};
use crate::robot::params::Params;
use crate::robot::state::clock::Clock;
use crate::robot::state::head::Head;
use crate::robot::state::layout::share_models;
use crate::robot::state::sequence::SequencesOfVersion4;
use crate::robot::state::tracked::{Tracked, Whiskers};
use crate::robot::state::whisker::{Holds, Whisker};
use crate::robot::touch_tests::TestBudget;
use crate::robot::{Array, Numbers, Robot, Sequences};
use crate::text::ShortText;
use crate::units::Micros;

/// Version of the head's bytes. Raise it with every change of the format: bytes of two versions may have the same
/// length.
const STATE_VERSION: u16 = 12;
/// Bytes of a version up to this one are taken for those of a newer program; beyond it they are damaged.
const NEWEST_VERSION: u16 = STATE_VERSION + 100;
/// The end of a head up to version 7: no alarm for silence stands, and no silence has ended. The next step raises it.
const NO_SILENCE: [u8; 9] = [0; 9];
/// The end of a head up to version 8: nothing shows a second robot of the same name.
const NO_DUPLICATE: [u8; 10] = [0; 10];
/// The end of a head up to version 9: robots applied no gain, and had a supply of air. The next contact tells the kind of
/// places.
const NO_GAIN: [u8; 3] = [0; 3];
/// The end of a head up to version 11: nothing was seen that does not fit, and no change is remembered.
const NO_MISFIT: [u8; 8] = [0; 8];

/// The head of version 6. No test was due after a pause or by a schedule.
#[derive(BorshDeserialize)]
struct HeadOfVersion6 {
    epoch: u64,
    link: Link,
    boot_id: Option<ShortText>,
    clock: Clock,
    sequences: Sequences,
    arrays: Vec<Array>,
    compensations: Vec<Compensation>,
    next_version: u64,
    next_trim: u32,
    next_compensation: u32,
    undecided: bool,
    held: bool,
    listening_since: Micros,
    is_taken_up: bool,
    touch_tests: TouchTests,
    tests: TestBudget,
}

impl From<HeadOfVersion6> for Head {
    fn from(stored: HeadOfVersion6) -> Self {
        let HeadOfVersion6 { next_trim, next_compensation, .. } = stored;
        Self {
            link: stored.link,
            boot_id: stored.boot_id,
            clock: stored.clock,
            sequences: stored.sequences,
            arrays: stored.arrays,
            compensations: stored.compensations,
            next_version: stored.next_version,
            undecided: stored.undecided,
            held: stored.held,
            listening_since: stored.listening_since,
            is_taken_up: stored.is_taken_up,
            touch_tests: stored.touch_tests,
            tests: stored.tests,
            ..Self::new(stored.epoch, Numbers { next_trim, next_compensation })
        }
    }
}

/// An array up to version 5: all arrays compared readings at equal contact ratio.
#[derive(BorshDeserialize)]
struct ArrayOfVersion5 {
    name: ShortText,
    kind: ArrayKind,
}

impl From<ArrayOfVersion5> for Array {
    fn from(ArrayOfVersion5 { name, kind }: ArrayOfVersion5) -> Self {
        Self { name, kind, task: Task::Ratio }
    }
}

/// The head of version 5. Robots did no touch tests.
#[derive(BorshDeserialize)]
struct HeadOfVersion5 {
    epoch: u64,
    link: Link,
    boot_id: Option<ShortText>,
    clock: Clock,
    sequences: Sequences,
    arrays: Vec<ArrayOfVersion5>,
    compensations: Vec<Compensation>,
    next_version: u64,
    next_trim: u32,
    next_compensation: u32,
    undecided: bool,
    held: bool,
    listening_since: Micros,
    is_taken_up: bool,
}

impl From<HeadOfVersion5> for Head {
    fn from(stored: HeadOfVersion5) -> Self {
        let HeadOfVersion5 { next_trim, next_compensation, .. } = stored;
        Self {
            link: stored.link,
            boot_id: stored.boot_id,
            clock: stored.clock,
            sequences: stored.sequences,
            arrays: stored.arrays.into_iter().map(Array::from).collect(),
            compensations: stored.compensations,
            next_version: stored.next_version,
            undecided: stored.undecided,
            held: stored.held,
            listening_since: stored.listening_since,
            is_taken_up: stored.is_taken_up,
            ..Self::new(stored.epoch, Numbers { next_trim, next_compensation })
        }
    }
}

/// The head of version 4. It had the newest robot time instead of a clock, and remembered boots only as long as their
/// message numbers.
#[derive(BorshDeserialize)]
struct HeadOfVersion4 {
    epoch: u64,
    link: Link,
    boot_id: Option<ShortText>,
    _robot_time: Option<Micros>,
    sequences: SequencesOfVersion4,
    arrays: Vec<ArrayOfVersion5>,
    compensations: Vec<Compensation>,
    next_version: u64,
    next_trim: u32,
    next_compensation: u32,
    undecided: bool,
    held: bool,
    listening_since: Micros,
    is_taken_up: bool,
}

impl From<HeadOfVersion4> for HeadOfVersion5 {
    /// The clock is estimated anew from the next messages: a single time may have been wrong.
    fn from(stored: HeadOfVersion4) -> Self {
        Self {
            epoch: stored.epoch,
            link: stored.link,
            boot_id: stored.boot_id,
            clock: Clock::default(),
            sequences: stored.sequences.into(),
            arrays: stored.arrays,
            compensations: stored.compensations,
            next_version: stored.next_version,
            next_trim: stored.next_trim,
            next_compensation: stored.next_compensation,
            undecided: stored.undecided,
            held: stored.held,
            listening_since: stored.listening_since,
            is_taken_up: stored.is_taken_up,
        }
    }
}

/// Reads the head of this version or of version 4 to 11.
fn head_of(mut bytes: &[u8]) -> Result<Head, RestoreError> {
    let version = u16::deserialize(&mut bytes).map_err(|_| RestoreError::Head)?;
    let head = match version {
        STATE_VERSION => borsh::from_slice::<Head>(bytes),
        // Version 10 knew no need for tests of whiskers without places, and wrote the same bytes as 11.
        11 | 10 => borsh::from_slice::<Head>(&[bytes, &NO_MISFIT].concat()),
        9 => borsh::from_slice::<Head>(&[bytes, &NO_GAIN, &NO_MISFIT].concat()),
        8 => borsh::from_slice::<Head>(&[bytes, &NO_DUPLICATE, &NO_GAIN, &NO_MISFIT].concat()),
        7 => borsh::from_slice::<Head>(&[bytes, &NO_SILENCE, &NO_DUPLICATE, &NO_GAIN, &NO_MISFIT].concat()),
        6 => borsh::from_slice::<HeadOfVersion6>(bytes).map(Head::from),
        5 => borsh::from_slice::<HeadOfVersion5>(bytes).map(Head::from),
        4 => borsh::from_slice::<HeadOfVersion4>(bytes).map(HeadOfVersion5::from).map(Head::from),
        version if (STATE_VERSION + 1..=NEWEST_VERSION).contains(&version) => return Err(RestoreError::Newer),
        _ => return Err(RestoreError::Head),
    };
    head.map_err(|_| RestoreError::Head)
}

impl Robot {
    /// The stored bytes of the robot without its whiskers. None is a fault of the program: keep the bytes stored
    /// before.
    #[must_use]
    pub fn to_bytes(&self) -> Option<Vec<u8>> {
        borsh::to_vec(&(STATE_VERSION, &*self.head)).ok()
    }

    /// The stored bytes of one whisker; none for an index beyond the last.
    #[must_use]
    pub fn whisker_to_bytes(&self, index: WhiskerIndex) -> Option<Vec<u8>> {
        borsh::to_vec(self.whiskers.get(index)?).ok()
    }

    /// Restores a robot and takes it up under a new epoch: [`Robot::restore`], then [`Robot::take_up`].
    ///
    /// # Errors
    /// The bytes are neither of this version of the program nor of the one before.
    pub fn from_bytes(head: &[u8], whiskers: &[Vec<u8>], epoch: u64, now: Micros) -> Result<Self, RestoreError> {
        let mut robot = Self::restore(head, whiskers)?;
        robot.take_up(epoch, now);
        Ok(robot)
    }

    /// The robot exactly as it was stored: the events since then, given to [`Robot::step`] again at the same times,
    /// have the same effects and leave the same bytes. Only the time of the last request for the factsheet is lost.
    /// `whiskers` are in the order of their indices.
    ///
    /// # Errors
    /// The bytes are neither of this version of the program nor of the one before.
    pub fn restore(head: &[u8], stored: &[Vec<u8>]) -> Result<Self, RestoreError> {
        let head = head_of(head)?;
        // `collect` into a `Result` does not reserve: a million whiskers took 5 % more memory.
        let mut whiskers: Vec<Whisker> = Vec::with_capacity(stored.len());
        for (index, bytes) in stored.iter().enumerate() {
            if Whisker::is_of_newer_program(bytes) {
                return Err(RestoreError::Newer);
            }
            whiskers.push(borsh::from_slice(bytes).map_err(|_| RestoreError::Whisker(index))?);
        }
        let within = |index: u32| (index as usize) < whiskers.len();
        if !head.compensations.iter().all(|one| within(one.target) && within(one.compensator)) {
            return Err(RestoreError::Layout);
        }
        share_models(&mut whiskers, Vec::new());
        let mut robot = Self::of(Tracked::stored(head), Whiskers::stored(whiskers));
        for index in 0..robot.whiskers.len() {
            if !robot.whiskers[index].is_sound() {
                robot.whiskers[index].mend();
            }
        }
        Ok(robot)
    }

    /// Lets its whiskers share the names of their models with the parameters, as after a factsheet: with thousands of
    /// robots, separate names would miss the processor's caches.
    pub fn share_models(&mut self, params: &Params) {
        share_models(self.whiskers.without_mark(), params.model_names());
    }

    /// Continues under a new epoch and listens from `now` on. It marks nothing as changed: a supervisor that restores
    /// the robot again takes it up again.
    pub fn take_up(&mut self, epoch: u64, now: Micros) {
        let head = self.head.without_mark();
        head.epoch = epoch;
        head.clock.take_up();
        self.expect_stray_pressures();
        self.listen_from(now);
    }

    /// Continues the setpoint numbers after those of the same robot in a later state: robots accept no number twice,
    /// and the setpoints that were sent under them are not known here.
    pub fn go_on_numbering_after(&mut self, later: &Self) {
        self.head.next_version = self.head.next_version.max(later.head.next_version);
    }

    /// Continues the numbers of a robot that was here before under the same name: its trims and compensations, and its
    /// setpoints of this epoch.
    pub fn go_on_numbering(&mut self, numbers: Numbers, next_version: u64) {
        let head = &mut self.head;
        head.next_trim = head.next_trim.max(numbers.next_trim);
        head.next_compensation = head.next_compensation.max(numbers.next_compensation);
        head.next_version = head.next_version.max(next_version);
    }

    /// First free number of a setpoint.
    #[must_use]
    pub fn next_version(&self) -> u64 {
        self.head.next_version
    }

    /// Marks the robot as supervised before, by a state that may be older than the pressures of its whiskers, or that
    /// is not readable any more.
    #[must_use]
    pub fn taken_up(mut self) -> Self {
        self.expect_stray_pressures();
        self
    }

    fn expect_stray_pressures(&mut self) {
        self.head.without_mark().is_taken_up = true;
        let whiskers = self.whiskers.without_mark().iter_mut();
        whiskers.filter(|one| one.holds != Holds::Vented).for_each(|one| one.holds = Holds::Unheard);
    }

    /// Whether the robot has reported the pressure of each whisker since it was taken up. Until then a status may undo
    /// a stray pressure; the same status would not do so again to the robot as it was stored.
    #[must_use]
    pub fn is_settled(&self) -> bool {
        !self.head.is_taken_up
            || self.whiskers.iter().all(|whisker| matches!(whisker.holds, Holds::Known | Holds::Vented))
    }

    /// Nothing could be received before `now`: silence until then is not the robot's.
    pub fn listen_from(&mut self, now: Micros) {
        let head = self.head.without_mark();
        head.listening_since = head.listening_since.max(now);
        head.sequences.wait_anew();
        self.tick_deadline.end();
    }

    /// Whether the head or a whisker has changed since the last calls of [`Self::take_changed`] and
    /// [`Self::take_changed_whiskers`].
    #[must_use]
    pub fn has_changed(&self) -> bool {
        self.head.is_marked() || self.whiskers.has_changed()
    }

    /// Whether the head has changed since the last call.
    pub fn take_changed(&mut self) -> bool {
        self.head.take_mark()
    }

    /// Calls `visit` for each whisker that has changed since the last call.
    pub fn take_changed_whiskers(&mut self, visit: impl FnMut(WhiskerIndex)) {
        self.whiskers.take_changed(visit);
    }
}

/// Reason why stored bytes cannot be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum RestoreError {
    /// A newer version of the program has written the head, or a whisker.
    #[error("a newer version of the program has written the stored state of the robot")]
    Newer,
    /// The head has an unknown version or is damaged.
    #[error("the stored state of the robot is not of this version of the program, or damaged")]
    Head,
    /// The whisker of this index has an unknown version or is damaged.
    #[error("the stored state of whisker index {0} is not of this version of the program, or damaged")]
    Whisker(usize),
    /// Whiskers of a compensation are missing.
    #[error("the stored state of the robot names whiskers that are not stored")]
    Layout,
}
