//! Setpoints: one at a time per whisker, sent until answered, superseded or expired. [`super::tries`] bounds the tries.

use crate::robot::Robot;
use crate::robot::effect::{Command, CommandKey, CommandState, Effect, EndReason, Reason, WhiskerIndex};
use crate::robot::event::{Link, Rejection, SetpointReport};
use crate::robot::params::Params;
use crate::robot::setpoints::tries::{TASK_PAUSE_MAX, Tries};
use crate::robot::state::rare_state::RareState;
use crate::robot::state::whisker::{Desired, Holds, InFlight};
use crate::units::{Megapascal, Micros};

/// Pressures closer than this are the same setpoint, MPa.
const SAME_MPA: f64 = 1e-5;

impl Robot {
    /// Sets the pressure that a whisker shall hold from now on. A held whisker follows only an operator's setpoints;
    /// its other setpoints follow from the compensations when it is released.
    pub(in crate::robot) fn desire(&mut self, index: WhiskerIndex, desired: Desired) {
        if self.holds(index) && desired.reason != Reason::Operator {
            return;
        }
        let whisker = &mut self.whiskers[index];
        // A pressure that was lost is desired again: its tries go on.
        whisker.desired = Some(Box::new(desired));
        let is_former = whisker.wanted().is_some_and(|wanted| is_same(whisker.air.setpoint, wanted));
        if let Some(rare) = whisker.rare.get_mut() {
            rare.not_before = Micros::default();
            if !rare.tries.is_failing() && !is_former {
                rare.tries = Tries::NONE;
            }
        }
    }

    /// Back to the nominal pressure, because a compensation is over.
    pub(in crate::robot) fn release(&mut self, index: WhiskerIndex) {
        let pressure = self.whiskers[index].sheet.pressure;
        self.desire(index, Desired { pressure, reason: Reason::Release, compensation: None, gain: None });
    }

    /// Sends a new setpoint if the desired pressure is not held, or an unanswered one again.
    pub(in crate::robot) fn reconcile(
        &mut self,
        params: &Params,
        now: Micros,
        index: WhiskerIndex,
        effects: &mut Vec<Effect>,
    ) {
        self.expire(params, now, index, effects);
        let held = self.holds(index);
        let whisker = &self.whiskers[index];
        let (Some(desired), Some(wanted)) = (&whisker.desired, whisker.wanted()) else { return };
        let by_hand = desired.reason == Reason::Operator;
        if held && !by_hand {
            return;
        }
        if let Some(flight) = &whisker.command {
            let same = (flight.command.reason == Reason::Operator) == by_hand
                && is_same(flight.command.pressure, wanted)
                && flight.command.compensation == desired.compensation;
            if same {
                let waits = is_ahead(now, flight.resend_at, params.command.resend_after);
                if !waits
                    && flight.state == CommandState::Pending
                    && let Some(flight) = &mut self.whiskers[index].command
                {
                    flight.resend_at = now.after(params.command.resend_after);
                    effects.push(Effect::Resend(Box::new(flight.command.clone())));
                }
                return;
            }
        } else if whisker.holds != Holds::Stray && is_same(whisker.air.setpoint, wanted) {
            if desired.reason == Reason::Release || by_hand {
                self.whiskers[index].desired = None;
                return;
            }
            if self.head.compensations.iter().all(|one| Some(one.id) != desired.compensation || one.settled) {
                return;
            }
        }
        self.send(params, now, index, effects);
    }

    /// [`Self::reconcile`] for all whiskers.
    pub(in crate::robot) fn reconcile_all(&mut self, params: &Params, now: Micros, effects: &mut Vec<Effect>) {
        for index in 0..self.whiskers.len() {
            self.reconcile(params, now, index, effects);
        }
    }

    /// Whether a setpoint can reach it: it is connected, its clock is known, by which setpoints expire, and it is
    /// heard. Each setpoint expires after its time to live: to one who is not heard they would go out in vain, one
    /// after the other.
    pub(in crate::robot) fn can_be_told(&self, params: &Params, now: Micros) -> bool {
        let is_heard = self.head.clock.heard().is_some_and(|heard| now.since(heard) <= params.health.stale_after);
        !self.is_duplicated()
            && self.head.link == Link::Online
            && self.head.boot_id.is_some()
            && self.head.clock.robot_time(now).is_some()
            && is_heard
    }

    /// Manual setpoints that were not answered: they are not sent later.
    pub(in crate::robot) fn forget_manual(&mut self) {
        for index in 0..self.whiskers.len() {
            if self.whiskers[index].desired.as_ref().is_some_and(|desired| desired.reason == Reason::Operator) {
                self.whiskers[index].forget_manual();
            }
        }
    }

    fn send(&mut self, params: &Params, now: Micros, index: WhiskerIndex, effects: &mut Vec<Effect>) {
        if !self.can_be_told(params, now) {
            return;
        }
        let Some(robot_time) = self.head.clock.robot_time(now) else { return };
        let whisker = &self.whiskers[index];
        let (Some(desired), Some(pressure)) = (whisker.desired.clone(), whisker.wanted()) else { return };
        if whisker.given_up || !whisker.may_try(params, now) {
            return;
        }
        let Some(boot_id) = &self.head.boot_id else { return };
        let robot_boot_id = boot_id.as_str().to_owned();
        let whisker = &mut self.whiskers[index];
        let rare = whisker.rare.get_or_insert();
        rare.not_before = now.after(params.command.resend_after);
        let key = CommandKey { epoch: self.head.epoch, version: self.head.next_version };
        self.head.next_version += 1;
        let valid_for = whisker.valid_for(params, pressure);
        let command = Command {
            key,
            whisker: index,
            robot_boot_id,
            pressure,
            slew_mpa_per_s: params.command.slew_mpa_per_s,
            issued: now,
            expires: robot_time.after(valid_for),
            reason: desired.reason,
            compensation: desired.compensation,
            gain: desired.gain,
        };
        let flight = InFlight {
            command: command.clone(),
            state: CommandState::Pending,
            resend_at: now.after(params.command.resend_after),
        };
        if let Some(replaced) = whisker.command.replace(Box::new(flight)) {
            effects.push(state_of(&replaced.command, Some(index), CommandState::Superseded));
        }
        effects.push(Effect::Command(Box::new(command)));
    }

    /// A setpoint that its robot would refuse as expired by now, or that has gone unanswered for so long by our own
    /// clock.
    fn expire(&mut self, params: &Params, now: Micros, index: WhiskerIndex, effects: &mut Vec<Effect>) {
        let (clock, heard) = (&self.head.clock, self.head.clock.heard());
        let listening_since = self.head.listening_since;
        let whisker = &self.whiskers[index];
        let Some(flight) = &whisker.command else { return };
        let Command { key, issued, expires, pressure, .. } = flight.command;
        let is_pending = flight.state == CommandState::Pending;
        // One that the robot has taken is followed for as long as nothing is heard.
        let known_until = if is_pending { now } else { heard.unwrap_or_default() };
        let is_over = clock.robot_time(known_until).is_some_and(|robot_time| robot_time > expires);
        // A clock that was set back by more than that says nothing of its age.
        let valid_for = whisker.valid_for(params, pressure);
        let is_unanswered = is_pending && now.since(issued).max(issued.since(now)) > valid_for;
        if !is_over && !is_unanswered {
            return;
        }
        let epoch = self.head.epoch;
        let whisker = &mut self.whiskers[index];
        if let Some(flight) = whisker.command.take() {
            effects.push(state_of(&flight.command, Some(index), CommandState::Expired));
        }
        // The robot could hear it and answer, if it is heard so long after the setpoint and we have listened all the time.
        let answers_from = issued.after(params.command.resend_after);
        let could_answer = listening_since <= issued && heard.is_some_and(|heard| heard >= answers_from);
        let counts = !is_pending || could_answer;
        if !counts || key.epoch < epoch {
            // A manual setpoint is not sent later: it may have been asked of a supervisor that is no more.
            whisker.forget_manual();
        }
        self.try_failed(params, now, index, counts, effects);
    }

    /// How long a setpoint may be taken from when it was issued; `pressure` is its own.
    #[must_use]
    pub fn valid_for(&self, params: &Params, whisker: WhiskerIndex, pressure: Megapascal) -> Micros {
        self.whiskers.get(whisker).map_or(params.command.time_to_live, |one| one.valid_for(params, pressure))
    }

    /// The robot has not kept a setpoint that it took: a failed try. `counts` is false after a silence, which explains it. The
    /// first time its pressure is restored at once.
    pub(in crate::robot) fn not_kept(
        &mut self,
        params: &Params,
        now: Micros,
        index: WhiskerIndex,
        counts: bool,
        effects: &mut Vec<Effect>,
    ) {
        let before: &RareState = &self.whiskers[index].rare;
        let (is_first, not_before) = (before.tries == Tries::NONE, before.not_before);
        self.try_failed(params, now, index, counts, effects);
        let rare = self.whiskers[index].rare.get_or_insert();
        if is_first && !rare.tries.is_failing() {
            rare.not_before = not_before;
        }
    }

    /// A try has failed; `counts` is false if nobody was heard meanwhile. At the limit the whisker is given up, until the
    /// pause is over.
    fn try_failed(
        &mut self,
        params: &Params,
        now: Micros,
        index: WhiskerIndex,
        counts: bool,
        effects: &mut Vec<Effect>,
    ) {
        let rare = self.whiskers[index].rare.get_or_insert();
        rare.tries = rare.tries.failed(&params.command, counts);
        let next = now.after(rare.tries.pause(&params.command));
        let is_failing = rare.tries.is_failing();
        if is_failing {
            rare.not_before = next;
        } else if !counts {
            rare.not_before = rare.not_before.max(next);
        }
        if is_failing {
            self.give_up(index, effects);
        }
    }

    /// The robot is in a task: its setpoint is tried again after a growing pause.
    fn wait_for_task(&mut self, params: &Params, now: Micros, index: WhiskerIndex) {
        let rare = self.whiskers[index].rare.get_or_insert();
        let (tries, pause) = rare.tries.in_task(&params.command);
        rare.tries = tries;
        rare.not_before = rare.not_before.max(now.after(pause));
    }

    /// Gives a whisker up until an operator, another boot or another whisker comes: another try would fail, too.
    fn give_up_for_good(&mut self, index: WhiskerIndex, effects: &mut Vec<Effect>) {
        self.whiskers[index].rare.forget_tries();
        self.give_up(index, effects);
    }

    /// Lets a whisker with failed setpoints serve again, once the pause is over and the robot can be told. The alarm stands
    /// until the robot has taken a setpoint. Returns whether the whisker serves again.
    pub(in crate::robot) fn try_again_in_time(&mut self, params: &Params, now: Micros, index: WhiskerIndex) -> bool {
        let whisker = &self.whiskers[index];
        let is_due = whisker.waits_for_retry()
            && whisker.may_try(params, now)
            && !self.holds(index)
            && self.can_be_told(params, now);
        if is_due {
            self.back_to_automatic(index);
        }
        is_due
    }

    /// Gives a whisker up as compensator, with an alarm: others may serve instead.
    fn give_up(&mut self, index: WhiskerIndex, effects: &mut Vec<Effect>) {
        let whisker = &mut self.whiskers[index];
        whisker.given_up = true;
        whisker.desired = None;
        whisker.holds = Holds::Known;
        // Proposals, too: they could not be carried out.
        self.end_as_compensator(index, EndReason::SetpointFailed, |_| true, effects);
    }

    /// Takes a robot's report on a setpoint in. `robot_time` is the time of sending by the robot's clock; 0 if it is
    /// unknown.
    pub(in crate::robot) fn setpoint_reported(
        &mut self,
        params: &Params,
        now: Micros,
        (key, robot_time): (CommandKey, Micros),
        report: SetpointReport,
        effects: &mut Vec<Effect>,
    ) {
        let Some(index) = self.whiskers.iter().position(|one| one.is_under_way(key)) else { return };
        let whisker = &mut self.whiskers[index];
        whisker.heard = Some(now);
        let Some(flight) = &mut whisker.command else { return };
        let pressure = flight.command.pressure;
        if matches!(report, SetpointReport::Applying | SetpointReport::Applied(_)) {
            let rare = whisker.rare.get_or_insert();
            (rare.set_at, rare.set_heard) = (robot_time, now);
        }
        match report {
            SetpointReport::Received => {
                if flight.state == CommandState::Pending {
                    flight.state = CommandState::Received;
                    effects.push(state_of(&flight.command, Some(index), CommandState::Received));
                }
            }
            SetpointReport::Applying => {
                if matches!(flight.state, CommandState::Pending | CommandState::Received) {
                    flight.state = CommandState::Applying;
                    effects.push(state_of(&flight.command, Some(index), CommandState::Applying));
                    whisker.pressure_set(pressure, params);
                }
            }
            SetpointReport::Applied(reached) => self.applied(params, index, reached, effects),
            SetpointReport::Rejected(rejection) => self.rejected(params, now, index, key, rejection, effects),
            SetpointReport::Failed => {
                effects.push(state_of(&flight.command, Some(index), CommandState::Failed));
                whisker.command = None;
                self.try_failed(params, now, index, true, effects);
                let is_faulty = self.pressure_it_has(params, index).is_some();
                if self.whiskers[index].rare.tries.is_failing() && !is_faulty {
                    // It was taken, and the pressure was not reached again and again.
                    self.give_up_for_good(index, effects);
                }
                // A pressure that nobody can hold has drifted meanwhile.
                self.follow_pressure(params, index, 0.0);
            }
            SetpointReport::Superseded => {
                effects.push(state_of(&flight.command, Some(index), CommandState::Superseded));
                whisker.command = None;
                self.try_failed(params, now, index, true, effects);
            }
        }
        self.reconcile(params, now, index, effects);
    }

    fn applied(&mut self, params: &Params, index: WhiskerIndex, reached: Megapascal, effects: &mut Vec<Effect>) {
        let whisker = &mut self.whiskers[index];
        let Some(flight) = whisker.command.take() else { return };
        whisker.pressure_set(flight.command.pressure, params);
        whisker.holds = Holds::Known;
        whisker.air.measure(reached);
        if flight.command.reason == Reason::Operator {
            // Once, and no more: what the robot does later is its own.
            whisker.desired.take_if(|desired| desired.reason == Reason::Operator);
        }
        if let Some(compensation) =
            self.head.compensations.iter_mut().find(|one| Some(one.id) == flight.command.compensation)
        {
            compensation.settled = true;
            self.test_after_setpoint(index);
        }
        effects.push(Effect::CommandState {
            command: flight.command.key,
            whisker: Some(index),
            asked: flight.command.asked(),
            state: CommandState::Applied,
            rejection: None,
            pressure: Some(reached),
        });
    }

    fn rejected(
        &mut self,
        params: &Params,
        now: Micros,
        index: WhiskerIndex,
        key: CommandKey,
        rejection: Rejection,
        effects: &mut Vec<Effect>,
    ) {
        let Some(flight) = self.whiskers[index].command.take() else { return };
        effects.push(Effect::CommandState {
            command: key,
            whisker: Some(index),
            asked: flight.command.asked(),
            state: CommandState::Rejected,
            rejection: Some(rejection),
            pressure: None,
        });
        match rejection {
            // Another try can succeed: with a new number, a new expiry.
            Rejection::NotReady => {}
            // The robot is well, and says so: no try has failed.
            Rejection::InTask => return self.wait_for_task(params, now, index),
            // Its clock may have been stepped: the next messages tell.
            Rejection::Expired => {
                self.whiskers[index].rare.get_or_insert().not_before = now.after(params.command.time_to_live);
            }
            // Of a former epoch: the setpoint after it was ours, too, and may have been lost with a restored database.
            // A manual setpoint of then is not sent again.
            Rejection::Stale if key.epoch < self.head.epoch => self.whiskers[index].forget_manual(),
            // The robot is another one than we think.
            Rejection::WrongBoot | Rejection::UnknownWhisker => effects.push(Effect::AskForFactsheet),
            // Somebody with a higher epoch commands this robot, or our limits are wrong: do not insist.
            Rejection::Stale | Rejection::OutOfRange => return self.give_up_for_good(index, effects),
        }
        self.try_failed(params, now, index, true, effects);
    }

    /// Setpoints that were under way to a boot that is no more.
    pub(in crate::robot) fn abandon_commands(&mut self, effects: &mut Vec<Effect>) {
        self.forget_manual();
        for index in 0..self.whiskers.len() {
            let whisker = &mut self.whiskers[index];
            whisker.given_up = false;
            whisker.rare.forget_tries();
            if let Some(flight) = whisker.command.take() {
                effects.push(state_of(&flight.command, Some(index), CommandState::Abandoned));
            }
        }
    }
}

impl crate::robot::Whisker {
    /// The time to live of a setpoint, on top of the time that the pressure takes on its way.
    fn valid_for(&self, params: &Params, pressure: Megapascal) -> Micros {
        let way_mpa = (pressure.mpa() - self.air.setpoint.mpa()).abs();
        params.command.time_to_live.after(Micros::from_s(way_mpa / params.command.slew_mpa_per_s))
    }

    /// Whether the pause before the next try is over.
    fn may_try(&self, params: &Params, now: Micros) -> bool {
        let pause_max = self.rare.tries.pause(&params.command).max(params.command.time_to_live).max(TASK_PAUSE_MAX);
        !is_ahead(now, self.rare.not_before, pause_max)
    }

    /// The desired pressure within the limits of the factsheet and of the paper, which may have changed since.
    fn wanted(&self) -> Option<Megapascal> {
        let limit = self.pressure_limit();
        self.desired.as_ref().map(|desired| if desired.pressure < limit { desired.pressure } else { limit })
    }

    /// Whether a setpoint that was sent before `time` has no answer.
    pub(in crate::robot) fn has_unanswered_setpoint(&self, time: Micros) -> bool {
        let is_open = |flight: &InFlight| flight.state == CommandState::Pending && flight.command.issued < time;
        self.command.as_deref().is_some_and(is_open)
    }

    /// Whether its setpoint has failed and is tried again in time.
    pub(in crate::robot) fn waits_for_retry(&self) -> bool {
        self.given_up && self.rare.tries.is_failing()
    }

    /// Whether a setpoint has failed that was not taken since.
    pub(in crate::robot) fn has_failed_setpoint(&self) -> bool {
        let is_unmet = self.wanted().is_some_and(|wanted| !is_same(self.air.setpoint, wanted));
        self.given_up || self.rare.tries.is_failing() && (is_unmet || self.command.is_some())
    }

    /// The pressure that was set for a compensation and is in force by the robot's last report.
    pub(in crate::robot) fn kept_pressure(&self) -> Option<Megapascal> {
        self.wanted().filter(|&wanted| self.command.is_none() && is_same(self.air.setpoint, wanted))
    }

    /// Forgets failed tries once the robot has kept its setpoint for as long as the longest pause between two: a robot that
    /// takes a setpoint and leaves it again goes on where it was.
    pub(in crate::robot) fn forgive_tries(&mut self, params: &Params, now: Micros) {
        let rare: &RareState = &self.rare;
        let kept_for = now.since(rare.set_heard.max(rare.not_before));
        if rare.tries != Tries::NONE && !self.given_up && kept_for >= params.command.retry_after_max {
            self.rare.forget_tries();
        }
    }

    fn forget_manual(&mut self) {
        self.desired.take_if(|desired| desired.reason == Reason::Operator);
    }

    fn is_under_way(&self, key: CommandKey) -> bool {
        self.command.as_ref().is_some_and(|flight| flight.command.key == key)
    }
}

fn is_same(one: Megapascal, other: Megapascal) -> bool {
    (one.mpa() - other.mpa()).abs() < SAME_MPA
}

/// Whether a time lies ahead, by no more than it can: else our clock was set back since.
fn is_ahead(now: Micros, time: Micros, by_at_most: Micros) -> bool {
    now < time && time.since(now) <= by_at_most
}

pub(in crate::robot) fn state_of(command: &Command, whisker: Option<WhiskerIndex>, state: CommandState) -> Effect {
    let asked = command.asked();
    Effect::CommandState { command: command.key, whisker, asked, state, rejection: None, pressure: None }
}
