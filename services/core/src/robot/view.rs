//! Read access to a robot's state.

use super::effect::{Command, CommandKey, Condition, Fault, Reason, TestKind, TestState, WhiskerIndex};
use super::event::{ArrayKind, Link};
use super::health::standing::Standing;
use super::{Compensation, Robot, Sequence, Sheet};
use crate::estimation::{Erosion, Interval, LengthEstimate};
use crate::mechanics::Offset;
use crate::text::ShortText;
use crate::units::{Megapascal, Micros};

impl Robot {
    /// Index of the whisker with this array and number.
    #[must_use]
    pub fn find(&self, array: &str, number: u16) -> Option<WhiskerIndex> {
        let array = self.head.arrays.iter().position(|known| known.name == *array)?;
        self.place(array as u16, number)
    }

    /// The state of a whisker for display and for the database.
    #[must_use]
    pub fn whisker(&self, index: WhiskerIndex) -> Option<WhiskerView<'_>> {
        let whisker = self.whiskers.get(index)?;
        let array = &self.head.arrays[usize::from(whisker.array)];
        Some(WhiskerView {
            array: array.name.as_str(),
            kind: array.kind,
            sheet: &whisker.sheet,
            length: whisker.told(whisker.filter.length()),
            relative_length: whisker.told(whisker.filter.relative_length()),
            offset: whisker.filter.offset(),
            noise_scale: whisker.noise.variance().sqrt(),
            contacts: whisker.contacts,
            condition: whisker.condition,
            fault: whisker.fault,
            leak_per_s: whisker.leak.rate_per_s(),
            erosion: whisker.rare.erosion.as_ref().and_then(|erosion| {
                erosion.erosion(&whisker.filter.relative_length(), whisker.filter.learned_length().sd_mm)
            }),
            pressure: whisker.air.measured(),
            setpoint: whisker.air.setpoint,
            heard: whisker.heard,
            held: whisker.held,
            standing: whisker.standing,
            touch_test: whisker.rare.length_test.as_ref().and_then(|test| test.in_flight()),
            zero: whisker.rare.zero.measured(),
        })
    }

    /// Whether an operator holds the whole robot.
    #[must_use]
    pub fn is_held(&self) -> bool {
        self.head.held
    }

    /// Whether contacts messages of a boot are missing. Then a duplicate, too, can change the state: it starts or ends
    /// the time for which the missing messages are waited for.
    #[must_use]
    pub fn has_gap(&self, boot_id: &str) -> bool {
        self.sequence(boot_id).is_some_and(|sequence| !sequence.held().is_empty())
    }

    /// Since when the oldest missing contacts message of the newest boot is waited for; `None` if none is missing.
    #[must_use]
    pub fn gap_since(&self) -> Option<Micros> {
        self.sequence(self.connection_state().0?)?.gap_since()
    }

    /// Names of its arrays, in the order of the factsheet.
    pub fn arrays(&self) -> impl Iterator<Item = &str> {
        self.head.arrays.iter().map(|array| array.name.as_str())
    }

    /// Number of whiskers; indices are below.
    #[must_use]
    pub fn whisker_count(&self) -> usize {
        self.whiskers.len()
    }

    /// The newest boot and its connection.
    #[must_use]
    pub fn connection_state(&self) -> (Option<&str>, Link) {
        (self.head.boot_id.as_ref().map(ShortText::as_str), self.head.link)
    }

    /// How far its clock is ahead of the supervisor's, in microseconds; `None` while that is not known, or if nothing was
    /// heard within the last minute.
    #[must_use]
    pub fn clock_ahead_us(&self, now: Micros) -> Option<i64> {
        self.head.clock.ahead_us(now)
    }

    /// Whether its times pass too slowly or too fast to be in microseconds. Then no setpoint goes out, because none would
    /// expire in time.
    #[must_use]
    pub fn has_wrong_time_unit(&self) -> bool {
        self.head.clock.has_wrong_unit()
    }

    /// Message numbers of a boot, as its receipts state them.
    #[must_use]
    pub fn sequence(&self, boot_id: &str) -> Option<&Sequence> {
        self.head.sequences.of(boot_id)
    }

    /// Setpoints that are not settled yet.
    pub fn commands_under_way(&self) -> impl Iterator<Item = &Command> {
        self.whiskers.iter().filter_map(|one| one.command.as_ref().map(|flight| &flight.command))
    }

    /// Those that go out again to a robot that is back. A manual one that is not answered goes out once.
    pub fn commands_to_repeat(&self) -> impl Iterator<Item = &Command> {
        self.whiskers.iter().filter_map(|one| {
            let command = &one.command.as_ref()?.command;
            let is_wanted = one.desired.as_ref().is_some_and(|desired| desired.reason == Reason::Operator);
            (command.reason != Reason::Operator || is_wanted).then_some(command)
        })
    }

    /// Touch tests that are requested and not over, each with its whisker.
    pub fn tests_under_way(&self) -> impl Iterator<Item = (CommandKey, WhiskerIndex)> {
        self.whiskers
            .iter()
            .enumerate()
            .filter_map(|(index, one)| Some((one.rare.length_test.as_ref()?.key_under_way()?, index)))
    }

    /// Whether it multiplies its readings by the reading gain of the setpoint applied last.
    #[must_use]
    pub fn applies_gain(&self) -> bool {
        self.head.applies_gain
    }

    /// Compensations in force, and those that wait for approval.
    #[must_use]
    pub fn compensations(&self) -> &[Compensation] {
        &self.head.compensations
    }
}

/// State of a whisker for display and for the database.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WhiskerView<'a> {
    /// Name of its array.
    pub array: &'a str,
    /// Kind of its array.
    pub kind: ArrayKind,
    /// Data of the whisker in the factsheet.
    pub sheet: &'a Sheet,
    /// Present length estimate.
    pub length: LengthEstimate,
    /// The same without the error of the factory length, for a loss of length.
    pub relative_length: LengthEstimate,
    /// Present offset from the model, log sensitivity.
    pub offset: Offset,
    /// Noise of its contacts over the stated noise, as a ratio of standard deviations.
    pub noise_scale: f64,
    /// Contacts that were used.
    pub contacts: u64,
    /// Mechanical condition of the whisker.
    pub condition: Condition,
    /// Fault, if any.
    pub fault: Option<Fault>,
    /// Relative loss of gauge pressure per second while the pressure is held, once it can be estimated.
    pub leak_per_s: Option<Interval>,
    /// Rate of erosion and time until it leaves the compensable range, if it erodes.
    pub erosion: Option<Erosion>,
    /// Pressure as last measured.
    pub pressure: Option<Megapascal>,
    /// Pressure that the robot holds or moves to.
    pub setpoint: Megapascal,
    /// Time of its last contact or status by the supervisor's clock.
    pub heard: Option<Micros>,
    /// Whether an operator holds this whisker; see [`Robot::is_held`] for a hold of the whole robot.
    pub held: bool,
    /// Alarms that stand for the whisker.
    pub standing: Standing,
    /// Kind and state of the touch test that is requested or proposed, and not over.
    pub touch_test: Option<(TestKind, TestState)>,
    /// Measured error of the distances that its robot states, to be added to them, and its standard deviation, mm.
    pub zero: Option<(f64, f64)>,
}
