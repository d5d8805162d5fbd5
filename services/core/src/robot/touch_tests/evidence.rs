//! Contacts as evidence of a whisker's length.

use crate::estimation::{Reach, Z95};
use crate::robot::Robot;
use crate::robot::effect::{Condition, Effect, TestReason, TestState, WhiskerIndex};
use crate::robot::event::{Contact, ContactPlace, MissedTouch};
use crate::robot::params::Params;
use crate::robot::state::rare_state::PendingTrim;
use crate::robot::state::whisker::Whisker;
use crate::robot::touch_tests::LengthTest;
use crate::units::{Micros, Millimetre};

/// A cut is called when its posterior probability leaves less than this for the length before: five missed touches.
const UNCHANGED_MAX: f64 = 1e-6;
/// The same after a change of sensitivity, which is evidence, too.
const UNCHANGED_AFTER_CHANGE_MAX: f64 = 1e-4;
/// A suspicion is refuted when the length before has at least this posterior probability. With 0.99 touches against a wall would
/// not do, because the error of all distances is known to 0.2 mm only.
const UNCHANGED_MIN: f64 = 0.93;
/// Touches that a called cut needs: a robot whose wall is away feels nothing at any distance.
const TOUCHES_MIN: u16 = 3;
/// Touches and missed touches that a refutation needs.
const CONTACTS_MIN: u16 = 5;
/// Standard deviation of a length that is certain enough to be called at once, mm, ...
const CERTAIN_SD_MM: f64 = 0.5;
/// ... where contacts tell the length no better, because they state no ratio, mm, ...
const CERTAIN_ALONE_SD_MM: f64 = 0.25;
/// ... where one gain follows from the length, mm: all tests in a row measure it, ...
const CERTAIN_FOR_GAIN_SD_MM: f64 = 0.1;
/// ... and after the last test in a row, mm.
const USABLE_SD_MM: f64 = 1.5;
/// A touch of the robot's habit shows that the whisker reaches so many standard deviations below its distance. Of many touches
/// near the tip the farthest are those with the largest errors; without this, lengths were 0.4 mm too long.
const SELECTED_SD: f64 = 2.0;
/// Errors of a robot's distances that all contacts share, mm: the length's standard deviation is not smaller.
const SHARED_SD_MM: f64 = 0.2;
/// Losses below this are not called, mm: the factory length is not better known.
const LOSS_MIN_MM: f64 = 0.4;
/// Nor those within so many standard deviations of the length before: it was not known better.
const LOSS_MIN_SD: f64 = 3.0;

impl Robot {
    /// Takes a contact's place in as evidence of the whisker's reach and length.
    pub(in crate::robot) fn follow_reach(
        &mut self,
        params: &Params,
        index: WhiskerIndex,
        contact: &Contact<'_>,
        effects: &mut Vec<Effect>,
    ) {
        let states_distance = match contact.place {
            ContactPlace::Distance(_) => true,
            ContactPlace::Ratio { .. } | ContactPlace::Tip(_) => false,
            ContactPlace::Unknown => self.head.states_distance,
        };
        // Tests state distances, whatever the robot knows otherwise.
        if !contact.is_test && states_distance != self.head.states_distance {
            self.head.states_distance = states_distance;
        }
        let alone = self.needs_exact_length(index);
        let whisker = &mut self.whiskers[index];
        let (off_mm, zero_sd_mm) = whisker.zero(params);
        if contact.is_test && whisker.can_measure(params) {
            // The error that all distances share stays, however many contacts come.
            let least_sd_mm = SHARED_SD_MM.hypot(zero_sd_mm).max(whisker.filter.least_sd_mm().into());
            whisker.filter.keep_doubt(least_sd_mm);
        }
        let is_evidence = match contact.place {
            ContactPlace::Distance(at) => {
                whisker.touched_at(params, contact.is_test, at.at.mm(), at.sd_mm);
                let selected = if contact.is_test { 0.0 } else { SELECTED_SD };
                let least_mm = at.at.mm() + off_mm - selected * at.sd_mm;
                whisker.add_touch(at.sd_mm, |evidence| evidence.touched(least_mm, at.sd_mm))
            }
            ContactPlace::Tip(Some(at)) => {
                whisker.touched_at(params, contact.is_test, at.at.mm(), at.sd_mm);
                if !contact.is_test {
                    whisker.follow_zero(params, at, alone);
                }
                whisker.add_touch(at.sd_mm, |evidence| evidence.tip(at.at.mm() + off_mm, at.sd_mm))
            }
            // A ratio to the present length reaches 1 whatever that length is; one to an old length does not.
            ContactPlace::Ratio { ratio, sd } => {
                let whole_mm = whisker.sheet.length.mm();
                let sd_mm = sd.unwrap_or(params.noise.ratio) * whole_mm;
                whisker.touched_at(params, contact.is_test, ratio.a() * whole_mm, sd_mm);
                false
            }
            ContactPlace::Tip(None) | ContactPlace::Unknown => false,
        };
        // During a test the supervisor chooses the place, so these touches show no habit of the robot.
        let is_distance = !contact.is_test && !matches!(contact.place, ContactPlace::Ratio { .. });
        self.judge_reach(params, index, is_distance, effects);
        if is_evidence {
            self.judge_length(params, index, effects);
        }
    }

    /// Takes a touch that did not come in as evidence of the whisker's length. The first one begins a measurement.
    pub(in crate::robot) fn missed_touch(
        &mut self,
        params: &Params,
        now: Micros,
        missed: &MissedTouch<'_>,
        effects: &mut Vec<Effect>,
    ) {
        let Some(index) = self.find(missed.array, missed.whisker) else { return };
        let whisker = &mut self.whiskers[index];
        whisker.heard = Some(now);
        let length_mm = whisker.filter.length().length.mm();
        let (off_mm, _) = whisker.zero(params);
        if self.is_late(now, index, missed.robot_time) {
            effects.push(Effect::MissedTouch { whisker: index });
            return;
        }
        let rare = self.whiskers[index].rare.get_or_insert();
        let test = rare.length_test.get_or_insert_with(|| Box::new(LengthTest::new(length_mm)));
        effects.push(Effect::MissedTouch { whisker: index });
        if test.is_only_followed() {
            return;
        }
        // This is new evidence: a test that an operator refused may be proposed again.
        test.in_flight.take_if(|test| test.state == TestState::Refused);
        test.evidence.missed(missed.at.at.mm() + off_mm, missed.at.sd_mm);
        test.sd_mm = missed.at.sd_mm;
        test.contacts = test.contacts.saturating_add(1);
        self.judge_length(params, index, effects);
        self.request_test(params, now, index, effects);
    }

    /// Begins or ends the suspicion of a lost reach.
    fn judge_reach(&mut self, params: &Params, index: WhiskerIndex, is_distance: bool, effects: &mut Vec<Effect>) {
        let whisker = &self.whiskers[index];
        let is_suspected = whisker.condition == Condition::Suspected;
        let is_measured = whisker.rare.length_test.is_some();
        if whisker.is_reach_silent() {
            // A robot that states ratios has rather changed its habits: its readings go on being used, and only a long
            // silence asks for a test.
            let asks = is_distance || whisker.rare.reach.as_ref().is_some_and(|reach| reach.is_lost());
            if asks && !is_measured {
                self.whiskers[index].suspect_reach(params);
            }
            if is_distance && self.whiskers[index].condition == Condition::Healthy {
                self.set_condition(index, Condition::Suspected, effects);
            }
            return;
        }
        if is_measured && whisker.is_measured_for_silence() {
            self.whiskers[index].end_measurement();
        }
        let whisker = &self.whiskers[index];
        if is_distance && is_suspected && whisker.detector.is_calm() && whisker.rare.length_test.is_none() {
            self.set_condition(index, Condition::Healthy, effects);
        }
    }

    /// Calls a cut, refutes one, or goes on.
    pub(super) fn judge_length(&mut self, params: &Params, index: WhiskerIndex, effects: &mut Vec<Effect>) {
        let whisker = &self.whiskers[index];
        let Some(test) = &whisker.rare.length_test else { return };
        let (_, zero_sd_mm) = whisker.zero(params);
        let posterior = test.evidence.posterior(zero_sd_mm);
        let is_last = test.done >= params.touch_tests.in_a_row;
        let is_alone = self.is_measured_by_tests_alone(index);
        let certain_sd_mm = if self.needs_exact_length(index) {
            CERTAIN_FOR_GAIN_SD_MM
        } else if is_alone {
            CERTAIN_ALONE_SD_MM
        } else {
            CERTAIN_SD_MM
        };
        let sd_most_mm = if is_last { USABLE_SD_MM } else { certain_sd_mm };
        // Touches of the robot's habit do not refute the silence that they leave: only those of a test do.
        let may_refute = test.under_way().is_none() && (test.done > 0 || !whisker.is_reach_silent());
        let length_before_mm = test.evidence.length_mm();
        let unchanged_max = if test.is_for_change() { UNCHANGED_AFTER_CHANGE_MAX } else { UNCHANGED_MAX };
        // The test decides a doubt. It would never exceed three times the doubt of its own cut.
        let known_sd_mm = if whisker.has_doubtful_length() { 0.0 } else { whisker.filter.learned_length().sd_mm };
        let is_shorter = posterior.unchanged < unchanged_max
            && test.touches >= TOUCHES_MIN
            // More touches do not lessen the error that all distances share.
            && posterior.sd_mm <= sd_most_mm.hypot(zero_sd_mm)
            && posterior.mean_mm < length_before_mm - LOSS_MIN_MM.max(LOSS_MIN_SD * known_sd_mm);
        if is_shorter {
            let contacts = test.contacts.into();
            self.call_measured(
                params,
                index,
                posterior.mean_mm,
                posterior.sd_mm.hypot(SHARED_SD_MM.max(zero_sd_mm)),
                contacts,
                effects,
            );
        } else if posterior.unchanged > UNCHANGED_MIN && test.contacts >= CONTACTS_MIN && may_refute {
            if test.is_for_change() {
                self.refute_cut(params, index);
            }
            let whisker = &mut self.whiskers[index];
            let sd_mm = posterior.sd_mm.hypot(SHARED_SD_MM.max(zero_sd_mm));
            if whisker.has_doubtful_length() {
                whisker.learn_measured_length(whisker.sheet.length, sd_mm);
            }
            if whisker.rare.length_test.as_ref().is_some_and(|test| test.is_for_change()) {
                self.keep_small_doubt(index);
            }
            let whisker = &mut self.whiskers[index];
            // Silence that is refuted was a change of habits.
            if whisker.is_reach_silent() {
                whisker.forget_reach();
            }
            whisker.end_measurement();
            if whisker.condition == Condition::Suspected && whisker.detector.is_calm() {
                self.set_condition(index, Condition::Healthy, effects);
            }
        }
    }

    /// Tests in a row have ended without a decision about a doubtful length. The interval that contacts do not narrow reaches
    /// no further than the touches leave possible: from the length as told to that after a cut.
    pub(super) fn narrow_doubt(&mut self, params: &Params, index: WhiskerIndex) {
        let whisker = &mut self.whiskers[index];
        let zero_sd_mm = whisker.zero(params).1;
        let test = whisker.rare.length_test.as_ref().filter(|test| !test.is_only_followed());
        let Some(test) = test.filter(|test| test.done >= params.touch_tests.in_a_row) else { return };
        let posterior = test.evidence.posterior(zero_sd_mm);
        let told = whisker.filter.relative_length();
        let cut_mm = (told.length.mm() - posterior.mean_mm).abs() / Z95 + posterior.sd_mm;
        let sd_mm = cut_mm.hypot(SHARED_SD_MM.max(zero_sd_mm));
        if whisker.has_doubtful_length() && sd_mm < told.sd_mm && whisker.learn_measured_length(told.length, sd_mm) {
            whisker.filter.keep_doubt(sd_mm);
        }
    }

    /// Whether only tests tell the length of the whisker.
    fn is_measured_by_tests_alone(&self, index: WhiskerIndex) -> bool {
        // Contacts without a place leave a whisker in its first condition until tests have taught it.
        self.states_no_ratio(index) || self.whiskers[index].condition == Condition::Learning
    }

    /// Whether its contacts tell no length: they state distances, or no place.
    pub(in crate::robot) fn states_no_ratio(&self, index: WhiskerIndex) -> bool {
        self.head.states_distance || self.states_no_place(index)
    }

    /// Whether the gain of its readings follows from a length that only tests tell.
    pub(super) fn needs_exact_length(&self, index: WhiskerIndex) -> bool {
        self.head.applies_gain && self.states_no_ratio(index)
    }

    /// Calls a trim of a measured length.
    fn call_measured(
        &mut self,
        params: &Params,
        index: WhiskerIndex,
        length_mm: f64,
        sd_mm: f64,
        contacts: u32,
        effects: &mut Vec<Effect>,
    ) {
        let whisker = &mut self.whiskers[index];
        let Ok(length) = Millimetre::new(length_mm) else { return };
        let length_before_mm = whisker.filter.length().length.mm();
        let is_for_change = whisker.rare.length_test.as_ref().is_some_and(|test| test.is_for_change());
        let is_after_loss = is_for_change && whisker.rare.whole_offset.is_some();
        let is_taken = match is_after_loss {
            true => whisker.learn_measured_length(length, sd_mm),
            false => whisker.filter.measured_length(length, sd_mm),
        };
        if !is_taken {
            return;
        }
        // The error that all distances share stays, however many contacts come.
        whisker.filter.keep_doubt(SHARED_SD_MM.hypot(whisker.zero(params).1));
        // A zero that tests have measured has the error of the factory length in it. So only that before them counts.
        whisker.filter.measured_in(params.touch_tests.zero_sd_mm);
        whisker.detector = crate::detection::Detector::default();
        if is_for_change && !is_after_loss {
            whisker.take_gain_back(params);
        }
        if whisker.is_at_nominal_pressure() {
            whisker.leaves_whole(whisker.filter.whole_offset());
        }
        let before = whisker.rare.pending_trim.map_or(length_before_mm, |pending| pending.length_before_mm);
        whisker.rare.get_or_insert().pending_trim = Some(PendingTrim {
            length_before_mm: before,
            contacts_since_change: contacts,
            contacts_since_confirmed: 0,
        });
        self.call_trim(index, effects);
    }
}

impl Whisker {
    /// Whether contacts near the tip have failed to come for suspiciously long.
    pub(in crate::robot) fn is_reach_silent(&self) -> bool {
        self.rare.reach.as_ref().is_some_and(|reach| reach.is_silent())
    }

    /// Whether silence near the tip, or a doubtful length, keeps it suspected, whatever its sensitivity says.
    pub(in crate::robot) fn keeps_suspicion(&self) -> bool {
        self.is_reach_silent() && self.rare.length_test.is_some() || self.has_doubtful_length()
    }

    fn touched_at(&mut self, params: &Params, is_test: bool, distance_mm: f64, sd_mm: f64) {
        if is_test {
            return;
        }
        let length_mm = self.filter.length().length.mm();
        let reach = self.rare.get_or_insert().reach.get_or_insert_with(|| Box::new(Reach::new(length_mm)));
        reach.follow(distance_mm, sd_mm, params.touch_tests.contacts_between_false_alarms);
    }

    /// Adds a touch to a measurement that goes on; false if none does.
    fn add_touch(&mut self, sd_mm: f64, add: impl FnOnce(&mut crate::estimation::LengthEvidence)) -> bool {
        let Some(test) = self.rare.get_mut().and_then(|rare| rare.length_test.as_mut()) else { return false };
        if test.is_only_followed() {
            return false;
        }
        add(&mut test.evidence);
        test.sd_mm = sd_mm;
        test.touches = test.touches.saturating_add(1);
        test.contacts = test.contacts.saturating_add(1);
        true
    }

    /// Begins a measurement because of silence near the tip.
    fn suspect_reach(&mut self, params: &Params) {
        let length_mm = self.filter.length().length.mm();
        let Some(shortest_mm) = self.rare.reach.as_ref().map(|reach| reach.shortest_mm()) else { return };
        let mut test = LengthTest::new(length_mm);
        test.evidence.hardly_below(shortest_mm + self.zero(params).0);
        test.wanted = Some(TestReason::Suspicion);
        self.rare.get_or_insert().length_test = Some(Box::new(test));
    }

    /// Whether its length is measured only because of silence, and no test of it is under way.
    fn is_measured_for_silence(&self) -> bool {
        self.rare.length_test.as_ref().is_some_and(|test| {
            test.under_way().is_none() && test.done == 0 && test.wanted == Some(TestReason::Suspicion)
        })
    }

    /// Ends the measurement of its length. A test in flight is only followed to its end.
    pub(in crate::robot) fn end_measurement(&mut self) {
        let length_mm = self.filter.length().length.mm();
        let Some(rare) = self.rare.get_mut() else { return };
        let in_flight = rare.length_test.take().and_then(|test| test.in_flight);
        let in_flight = in_flight.filter(|test| test.state != TestState::Refused);
        rare.length_test =
            in_flight.map(|test| Box::new(LengthTest { in_flight: Some(test), ..LengthTest::new(length_mm) }));
    }

    /// Learns the reach anew, at another length or because a test has refuted a suspicion.
    pub(in crate::robot) fn forget_reach(&mut self) {
        if let Some(rare) = self.rare.get_mut() {
            rare.reach = None;
        }
        self.end_measurement();
    }
}
