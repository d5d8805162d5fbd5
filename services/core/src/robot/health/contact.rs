//! Contacts, and the consequences of the detector's verdicts for a whisker.

use crate::detection::{Change, Checks, HypothesisKind, Verdict};
use crate::estimation::LengthEstimate;
use crate::mechanics::Offset;
use crate::robot::Robot;
use crate::robot::effect::{Condition, ContactRecord, ContactUse, Effect, Trim, WhiskerIndex};
use crate::robot::event::Contact;
use crate::robot::health::misfit::Cause;
use crate::robot::params::Params;
use crate::robot::state::place::Placed;
use crate::robot::state::rare_state::PendingTrim;
use crate::units::Micros;

impl Robot {
    pub(in crate::robot) fn contact(
        &mut self,
        params: &Params,
        now: Micros,
        position: usize,
        contact: &Contact<'_>,
        effects: &mut Vec<Effect>,
    ) {
        let Some(index) = self.find(contact.array, contact.whisker) else {
            effects.push(Effect::UnknownWhisker { position });
            return;
        };
        if self.is_late(now, index, contact.robot_time) {
            let whisker = &mut self.whiskers[index];
            whisker.heard = Some(now);
            let length = whisker.told(whisker.filter.length());
            let (used, ratio) = (ContactUse::Late, Placed::on(&length, contact.place).ok().map(|placed| placed.ratio));
            let unused =
                ContactRecord { position, whisker: index, ratio, used, residual: None, standardised: None, length };
            effects.push(Effect::Contact(unused));
            return;
        }
        let suspicious = self.whiskers[index].detector.is_suspicious();
        let checks = if suspicious {
            Checks { others: self.others_feel(params, index), touch_test: self.can_confirm(params, now, index) }
        } else {
            Checks::NONE
        };
        let states_distance = self.head.states_distance;
        let whisker = &mut self.whiskers[index];
        let Some(model) = whisker.model(params) else {
            effects.push(Effect::UnknownWhisker { position });
            return;
        };
        whisker.heard = Some(now);
        let place = whisker.true_place(params, contact, states_distance);
        let felt = whisker.feel(params, model, &Contact { place, ..*contact }, checks);
        effects.push(Effect::Contact(ContactRecord {
            position,
            whisker: index,
            ratio: felt.ratio,
            used: felt.used,
            residual: felt.innovation.map(|seen| seen.residual),
            standardised: felt.innovation.map(|seen| seen.alone.standardised),
            length: whisker.told(whisker.filter.length()),
        }));
        self.watch_misfit(index, felt.used, felt.innovation.map(|seen| seen.residual));
        self.refresh_fault(params, now, index, effects);
        if let Some((seen, ratio)) = felt.innovation.zip(felt.ratio) {
            if !matches!(felt.verdict, Verdict::Quiet | Verdict::Looking | Verdict::Unconfirmed) {
                self.changed_at(index, contact.robot_time);
            }
            self.gain_wandered(params, index, felt.wandered);
            let turn_max = if contact.angle_is_stated { 0.0 } else { params.detection.turn_max() };
            self.conclude(params, index, (felt.verdict, turn_max), effects);
            if !self.head.touch_tests.tip && !self.head.touch_tests.wall {
                self.whiskers[index].follow_turn(params, turn_max);
            }
            self.test_change(params, index, &felt);
            self.measure(params, index, (position, ratio), contact, &seen, effects);
            self.follow_wear(params, index, effects);
        }
        self.follow_reach(params, index, contact, effects);
        self.request_test(params, now, index, effects);
    }

    /// Turns a verdict into a condition. A turn of the contacts changes the log sensitivity by at most `turn_max`.
    fn conclude(
        &mut self,
        params: &Params,
        index: WhiskerIndex,
        (verdict, turn_max): (Verdict, f64),
        effects: &mut Vec<Effect>,
    ) {
        let whisker = &self.whiskers[index];
        let learned = whisker.contacts >= u64::from(params.detection.cold_start_contacts);
        match verdict {
            Verdict::Quiet if whisker.condition == Condition::Learning && learned => {
                self.set_condition(index, Condition::Healthy, effects);
                self.look_first(params, index, effects);
            }
            Verdict::Quiet if whisker.is_due_for_look() => {
                self.look_at_others(params, index, effects);
            }
            Verdict::Quiet if whisker.is_decided_after_doubt() && !self.awaits_confirmation(index) => {
                self.end_doubt(index, effects);
            }
            Verdict::Quiet | Verdict::Looking | Verdict::Unconfirmed => {}
            Verdict::Alarm => {
                self.ask_others(index);
                if self.whiskers[index].condition == Condition::Healthy {
                    self.set_condition(index, Condition::Suspected, effects);
                }
            }
            Verdict::Dismissed | Verdict::Wandered => {
                self.whiskers[index].cannot_deny();
                self.end_suspicion(index, effects);
            }
            Verdict::Changed(change) => {
                self.changed(params, index, (&change, turn_max), effects);
                self.whiskers[index].cannot_deny();
            }
            Verdict::Shared(change) => self.shared_shift(params, index, &change, effects),
        }
        self.watch_baseline(params, index);
        self.settle_trim(params, index, effects);
    }

    /// Ends a suspicion that something else explains, unless another doubt keeps it.
    pub(super) fn end_suspicion(&mut self, index: WhiskerIndex, effects: &mut Vec<Effect>) {
        let whisker = &self.whiskers[index];
        let keeps = whisker.keeps_suspicion() || self.awaits_confirmation(index);
        if whisker.condition == Condition::Suspected && !keeps {
            self.keep_small_doubt(index);
            self.set_condition(index, Condition::Healthy, effects);
        }
    }

    fn changed(
        &mut self,
        params: &Params,
        index: WhiskerIndex,
        (change, turn_max): (&Change, f64),
        effects: &mut Vec<Effect>,
    ) {
        let whisker = &mut self.whiskers[index];
        if change.kind != HypothesisKind::Drifting
            && whisker.model(params).is_some_and(|model| whisker.is_rest_of_shift(model, change))
        {
            self.end_suspicion(index, effects);
            // It could be a cut after all: an alarm is raised, though no pressure is changed.
            self.whiskers[index].shift_told = true;
            return;
        }
        if matches!(change.kind, HypothesisKind::LessSensitive | HypothesisKind::Shorter)
            && self.is_exchange(params, index, change, effects)
        {
            return;
        }
        if self.whiskers[index].may_have_turned(params, change, turn_max) {
            self.turned(params, index, (change, turn_max), effects);
            return;
        }
        let whisker = &mut self.whiskers[index];
        let length_before_mm = whisker.filter.length().length.mm();
        match change.kind {
            HypothesisKind::LessSensitive => {
                if whisker.reads_like_whole(change) {
                    self.name_cause(index, Cause::WhiskerReplaced);
                }
                self.rescale(params, index, change);
                // A small cut that takes a part of the loss back looks like its end.
                self.keep_small_doubt(index);
                self.set_condition(index, Condition::SensitivityLoss, effects);
            }
            HypothesisKind::Shorter if whisker.regains(params, change) => {
                self.rescale(params, index, change);
                self.doubt_length(params, index, change, effects);
            }
            HypothesisKind::Shorter => {
                whisker.end_small_doubt();
                whisker.exceeds_turn(params, change, turn_max);
                whisker.jump(change);
                whisker.doubt_gain(params);
                if whisker.is_at_nominal_pressure() {
                    whisker.leaves_whole(whisker.filter.whole_offset());
                }
                let before = whisker.rare.pending_trim.map_or(length_before_mm, |pending| pending.length_before_mm);
                whisker.rare.get_or_insert().pending_trim = Some(PendingTrim {
                    length_before_mm: before,
                    contacts_since_change: change.contacts,
                    contacts_since_confirmed: 0,
                });
            }
            HypothesisKind::Eroding => {
                whisker.exceeds_turn(params, change, turn_max);
                whisker.jump(change);
                if whisker.condition != Condition::Eroding {
                    whisker.begin_erosion(params, -change.size * whisker.filter.length().length.mm());
                    self.set_condition(index, Condition::Eroding, effects);
                }
            }
            HypothesisKind::Drifting => {
                whisker.jump(change);
                whisker.drifting = true;
                whisker.drift_told = true;
                self.end_suspicion(index, effects);
            }
        }
    }

    /// Takes a change of a whisker's scale out, which is no change of its length: its offset is learned anew around it.
    /// A cut stays known, and so does its compensation. What was measured in it is brought to the new scale, but the
    /// response while whole stays the target, so that the gain makes up for the change.
    pub(super) fn rescale(&mut self, params: &Params, index: WhiskerIndex, change: &Change) {
        let Some(log_shift) = self.take_out(params, index, change) else { return };
        let whisker = &mut self.whiskers[index];
        if whisker.is_at_nominal_pressure() {
            let now = whisker.filter.whole_offset();
            let before = Offset { level: now.level - log_shift, ..now };
            whisker.leaves_whole(before);
        }
    }

    /// [`Self::rescale`] of a whisker that goes on being whole. Returns the change, log sensitivity.
    pub(super) fn take_out(&mut self, params: &Params, index: WhiskerIndex, change: &Change) -> Option<f64> {
        let whisker = &mut self.whiskers[index];
        let model = whisker.model(params)?;
        let log_shift = change.size * whisker.log_slope_with_length(model);
        whisker.filter.rescaled(change.size, change.lacking, log_shift, log_shift);
        self.shift_measured(index, log_shift);
        self.hasten_reviews(index);
        Some(log_shift)
    }

    /// A whisker's gain has wandered. If it compensates, the published gain is renewed.
    pub(in crate::robot) fn gain_wandered(&mut self, params: &Params, index: WhiskerIndex, log_shift: f64) {
        if log_shift.abs() < params.refinement.gain_margin {
            return;
        }
        self.shift_measured(index, log_shift);
        self.hasten_reviews(index);
    }

    /// The gains by this compensator are reviewed as soon as there are enough contacts.
    fn hasten_reviews(&mut self, compensator: WhiskerIndex) {
        for running in self.head.compensations.iter_mut().filter(|one| one.compensator() == compensator) {
            running.refining.hasten();
        }
    }

    /// Raises an alarm for a baseline that was followed without a verdict, once it is far off.
    fn watch_baseline(&mut self, params: &Params, index: WhiskerIndex) {
        let whisker = &mut self.whiskers[index];
        // While something is suspected, the baseline may stand for something else.
        if !whisker.detector.is_calm() || whisker.rare.pending_trim.is_some() {
            return;
        }
        let (baseline_strain, sd_strain) = whisker.filter.baseline_strain();
        if baseline_strain.abs() - 2.0 * sd_strain > params.health.baseline_strain_max {
            whisker.drift_told = true;
        }
    }

    /// A confirmed cut is acted on once its length is certain enough.
    fn settle_trim(&mut self, params: &Params, index: WhiskerIndex, effects: &mut Vec<Effect>) {
        if self.whiskers[index].rare.pending_trim.is_some() && self.may_be_exchanged(params, index) {
            return;
        }
        let whisker = &mut self.whiskers[index];
        let Some(pending) = whisker.rare.get_mut().and_then(|rare| rare.pending_trim.as_mut()) else { return };
        let length: LengthEstimate = whisker.filter.relative_length();
        // After a large cut the model's own error keeps this from being reached: then the full number of contacts is
        // waited for, in which the filter gets over its linearisation, too.
        let certain = length.sd_mm <= params.health.length_sd_max_mm;
        if !certain && pending.contacts_since_confirmed < params.health.length_contacts_max {
            pending.contacts_since_confirmed += 1;
            return;
        }
        self.call_trim(index, effects);
    }

    /// Calls a confirmed cut a trim, with the length as it is estimated now.
    pub(in crate::robot) fn call_trim(&mut self, index: WhiskerIndex, effects: &mut Vec<Effect>) {
        let whisker = &mut self.whiskers[index];
        let Some(pending) = whisker.rare.get_mut().and_then(|rare| rare.pending_trim.take()) else { return };
        let length: LengthEstimate = whisker.filter.length();
        whisker.undecided = true;
        whisker.refused_servers.clear();
        whisker.forget_reach();
        let id = self.head.next_trim;
        self.head.next_trim += 1;
        effects.push(Effect::Trim(Trim {
            id,
            whisker: index,
            length_before: crate::units::Millimetre::known(pending.length_before_mm),
            length_after: length,
            contacts_to_detect: pending.contacts_since_change + pending.contacts_since_confirmed,
        }));
        self.set_condition(index, Condition::Trimmed, effects);
    }

    /// Changes a condition, with its effect.
    pub(in crate::robot) fn set_condition(&mut self, index: WhiskerIndex, to: Condition, effects: &mut Vec<Effect>) {
        let from = self.whiskers[index].condition;
        if from != to {
            let whisker = &mut self.whiskers[index];
            whisker.condition = to;
            if !matches!(to, Condition::Learning | Condition::Healthy | Condition::Suspected) {
                whisker.rare.forget_first();
            }
            // Only who is trimmed needs to be served.
            whisker.unserved = false;
            effects.push(Effect::Condition { whisker: index, from, to });
        }
    }
}
