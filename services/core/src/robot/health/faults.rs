//! Faults: reported by the robot, shown by its pressures, or by silence.

use crate::estimation::leak::Source;
use crate::robot::Robot;
use crate::robot::effect::{Effect, Fault, Reason, WhiskerIndex};
use crate::robot::event::{GaugeState, Link, RegulatorState, WhiskerStatus};
use crate::robot::params::Params;
use crate::robot::state::rare_state::RareState;
use crate::robot::state::whisker::{Holds, Whisker};
use crate::units::{Megapascal, Micros};

/// Time after a silence, of the robot or of this supervisor, in which a whisker that is found vented was vented because of it.
const RETURN_FOR: Micros = Micros(60_000_000);
/// Time after a report of a setpoint in which a status from before it is taken for a late one. A log is read again within
/// seconds after an outage; robots send a status every 10 s.
const LATE_FOR: Micros = Micros(60_000_000);

impl Robot {
    pub(in crate::robot) fn status(
        &mut self,
        params: &Params,
        now: Micros,
        robot_time: Micros,
        entry: &WhiskerStatus<'_>,
        effects: &mut Vec<Effect>,
    ) {
        let Some(index) = self.find(entry.array, entry.whisker) else { return };
        let whisker = &mut self.whiskers[index];
        let was_doubtful = whisker.has_doubtful_leak(params);
        whisker.heard = Some(now);
        whisker.air.measure(entry.pressure);
        whisker.air.regulator = entry.regulator;
        whisker.gauge.reported = entry.gauge;
        // While a setpoint is under way its own reports say where it goes.
        if whisker.command.is_none() && !self.is_from_before_setpoint(now, robot_time, index) {
            self.pressure_told(params, now, index, entry.setpoint, effects);
        }
        let whisker = &mut self.whiskers[index];
        whisker.watch_leak(params, robot_time, entry);
        whisker.watch_pressure(params, now);
        self.refresh_fault(params, now, index, effects);
        if was_doubtful && !self.whiskers[index].has_doubtful_leak(params) {
            // It served on while the leak was in doubt.
            self.head.undecided = true;
        }
        self.follow_pressure(params, index, params.health.settled_within_mpa);
    }

    /// Whether a status was sent before the robot reported its last setpoint, and arrived after that report: brokers and
    /// logs keep the order of messages only within a topic. The pressure that it reports is a former one.
    ///
    /// A robot's clock that has gone back meanwhile says nothing of the order. But statuses that come late from a log make
    /// the clock seem to have gone back, too. So the estimate of the clock counts only some time after the report.
    fn is_from_before_setpoint(&self, now: Micros, robot_time: Micros, index: WhiskerIndex) -> bool {
        let rare: &RareState = &self.whiskers[index].rare;
        let is_recent = now.since(rare.set_heard) < LATE_FOR;
        let present = self.head.clock.robot_time(now);
        robot_time < rare.set_at && (is_recent || present.is_some_and(|at_present| at_present >= rare.set_at))
    }

    /// Follows the setpoint that a robot reports, except a stray pressure, which is undone first. At the nominal
    /// pressure the learned state shows at once whether the whisker has changed; at an unexplained pressure a cut would
    /// be taken for the model's error there.
    ///
    /// A regulator rounds setpoints: a report close to the pressure of a compensation is that pressure. Any other report
    /// means that the robot has not kept the setpoint that it took. That counts as a failed try, so that the same setpoint
    /// is not sent again and again.
    fn pressure_told(
        &mut self,
        params: &Params,
        now: Micros,
        index: WhiskerIndex,
        setpoint: Megapascal,
        effects: &mut Vec<Effect>,
    ) {
        if self.is_stray(params, index, setpoint) {
            if self.whiskers[index].holds != Holds::Stray {
                self.release(index);
                self.whiskers[index].holds = Holds::Stray;
            }
            return;
        }
        let kept = self.whiskers[index].kept_pressure();
        if kept.is_some_and(|kept| (setpoint.mpa() - kept.mpa()).abs() <= params.health.settled_within_mpa) {
            self.whiskers[index].holds = Holds::Known;
            return self.whiskers[index].forgive_tries(params, now);
        }
        let was_wanted = self.whiskers[index].desired.is_some();
        self.whiskers[index].holds = self.held_after(params, now, index, setpoint);
        let is_restored = !was_wanted && self.whiskers[index].desired.is_some();
        self.whiskers[index].pressure_set(setpoint, params);
        if kept.is_some() || is_restored {
            let counts = !self.has_returned(now);
            self.not_kept(params, now, index, counts, effects);
        } else if self.whiskers[index].desired.is_none() {
            self.whiskers[index].forgive_tries(params, now);
        }
    }

    /// Whether a silence of the robot or of this supervisor is over since a moment, or goes on.
    fn has_returned(&self, now: Micros) -> bool {
        let returned = self.head.heard_again.max(self.head.listening_since);
        self.head.silent || now.since(returned) < RETURN_FOR
    }

    /// Notices that a robot has vented a whisker by itself, as robots may without a supervisor. The pressure before is restored
    /// if a silence explains it and nothing speaks against it: a compensation's by [`Robot::reconcile`], or else the nominal one.
    fn held_after(&mut self, params: &Params, now: Micros, index: WhiskerIndex, setpoint: Megapascal) -> Holds {
        let whisker = &self.whiskers[index];
        let was_known = whisker.holds != Holds::Unheard || self.head.is_taken_up;
        let is_empty = |pressure: Megapascal| pressure.mpa() <= params.health.settled_within_mpa;
        let has_vented = was_known && !is_empty(whisker.air.setpoint) && whisker.desired.is_none();
        if !is_empty(setpoint) || !(has_vented || whisker.holds == Holds::Vented) {
            return Holds::Known;
        }
        let is_sound = matches!(whisker.air.regulator, RegulatorState::Ok | RegulatorState::Venting)
            && !whisker.leak.is_leaking()
            && !whisker.given_up;
        if has_vented && self.has_returned(now) && is_sound && !self.holds(index) {
            self.release(index);
            return Holds::Known;
        }
        Holds::Vented
    }

    /// Whether a pressure was set by a command that is not known here: the first status after a take-up reports a
    /// setpoint that is neither the known one, nor one that robots go to by themselves (nominal or vented), nor about
    /// to change.
    fn is_stray(&self, params: &Params, index: WhiskerIndex, setpoint: Megapascal) -> bool {
        let whisker = &self.whiskers[index];
        let wanted = whisker.desired.as_ref().is_some_and(|desired| desired.reason != Reason::Release);
        if !self.head.is_taken_up || whisker.holds == Holds::Known || whisker.given_up || wanted || self.holds(index) {
            return false;
        }
        let explained = [whisker.air.setpoint, whisker.sheet.pressure, Megapascal::ZERO];
        explained.iter().all(|known| (setpoint.mpa() - known.mpa()).abs() > params.health.settled_within_mpa)
    }

    /// Brings a whisker's fault, and the alarms that statuses flip, up to date.
    pub(in crate::robot) fn refresh_fault(
        &mut self,
        params: &Params,
        now: Micros,
        index: WhiskerIndex,
        effects: &mut Vec<Effect>,
    ) {
        let present = self.present_fault(params, now, index);
        let (whisker, from) = (&self.whiskers[index], self.whiskers[index].fault);
        let (to, flapping) = whisker.with_evidence(&params.health.flapping, now, present);
        if flapping != whisker.rare.flapping {
            self.whiskers[index].rare.get_or_insert().flapping = flapping;
        }
        let vents = self.whiskers[index].vents_with_evidence(&params.health.flapping, now);
        if vents != self.whiskers[index].rare.vents {
            self.whiskers[index].rare.get_or_insert().vents = vents;
        }
        if from != to {
            self.whiskers[index].fault = to;
            effects.push(Effect::Fault { whisker: index, from, to });
        }
    }

    /// Whether the present evidence would change neither a whisker's fault nor the record of its changes and vents.
    pub(in crate::robot) fn is_fault_up_to_date(&self, params: &Params, now: Micros, index: WhiskerIndex) -> bool {
        let whisker = &self.whiskers[index];
        let present = self.present_fault(params, now, index);
        whisker.with_evidence(&params.health.flapping, now, present) == (whisker.fault, whisker.rare.flapping)
            && whisker.vents_with_evidence(&params.health.flapping, now) == whisker.rare.vents
    }

    fn present_fault(&self, params: &Params, now: Micros, index: WhiskerIndex) -> Option<Fault> {
        let (online, since) = (self.head.link == Link::Online, self.head.listening_since);
        self.whiskers[index].present_fault(params, now, online, since)
    }
}

impl Whisker {
    /// Evaluates a status for leaks.
    fn watch_leak(&mut self, params: &Params, robot_time: Micros, entry: &WhiskerStatus<'_>) {
        let leak = &params.health.leak;
        let off_by_mpa = (entry.pressure.mpa() - self.air.setpoint.mpa()).abs();
        match entry.regulator {
            RegulatorState::Ok if self.command.is_none() && off_by_mpa <= params.health.held_within_mpa => {
                self.leak.read(leak, Source::Status, robot_time, entry.pressure);
            }
            // A robot that reports LEAK needs no proof, and a regulator that is out of order gives none.
            RegulatorState::Ok
            | RegulatorState::Filling
            | RegulatorState::Venting
            | RegulatorState::SupplyLow
            | RegulatorState::Leak
            | RegulatorState::Fault => self.leak.disturbed(leak, robot_time),
        }
    }

    /// A pressure that stays away from its setpoint with nothing under way is not held.
    fn watch_pressure(&mut self, params: &Params, now: Micros) {
        let Some(measured) = self.air.measured() else { return };
        let off_by_mpa = (measured.mpa() - self.air.setpoint.mpa()).abs();
        if off_by_mpa <= params.health.held_within_mpa || self.command.is_some() {
            self.air.unheld_since = None;
        } else {
            self.air.unheld_since.get_or_insert(now);
        }
    }

    /// Whether the last measured pressure is near the setpoint that its robot holds.
    pub(in crate::robot) fn holds_setpoint(&self, params: &Params) -> bool {
        let off_by_mpa = |measured: Megapascal| (measured.mpa() - self.air.setpoint.mpa()).abs();
        self.air.unheld_since.is_none()
            && self.air.measured().is_none_or(|measured| off_by_mpa(measured) <= params.health.held_within_mpa)
    }

    /// Whether only its readings show a leak, and its pressure is held: then it may be none, and a compensation serves on.
    pub(in crate::robot) fn has_doubtful_leak(&self, params: &Params) -> bool {
        self.fault == Some(Fault::Leak) && self.air.regulator != RegulatorState::Leak && self.holds_setpoint(params)
    }

    /// Whether it was heard once, and then not for too long a time in which it could be heard.
    pub(in crate::robot) fn is_silent(&self, params: &Params, now: Micros, listening_since: Micros) -> bool {
        self.heard.is_some_and(|heard| now.since(heard.max(listening_since)) > params.health.stale_after)
    }

    /// The worst that is known now; the cause before the symptom.
    fn present_fault(&self, params: &Params, now: Micros, online: bool, listening_since: Micros) -> Option<Fault> {
        if self.is_silent(params, now, listening_since) || !online {
            return Some(Fault::Stale);
        }
        if self.gauge.state() != GaugeState::Ok {
            return Some(Fault::Gauge(self.gauge.state()));
        }
        let unheld = self.air.unheld_since.is_some_and(|since| now.since(since) > params.health.unheld_after);
        match self.air.regulator {
            RegulatorState::Leak => Some(Fault::Leak),
            RegulatorState::Fault => Some(Fault::Regulator),
            RegulatorState::SupplyLow => Some(Fault::SupplyLow),
            RegulatorState::Ok | RegulatorState::Filling | RegulatorState::Venting
                if unheld || self.leak.is_leaking() =>
            {
                Some(Fault::Leak)
            }
            RegulatorState::Ok | RegulatorState::Filling | RegulatorState::Venting => None,
        }
    }
}
