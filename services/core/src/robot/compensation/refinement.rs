//! The closed loop: responses measured at a setpoint are compared with the target, and the setpoint is refined.
//!
//! A setpoint is evaluated after 300 and 800 contacts at a pressure, and then whenever their number has doubled: the more
//! there are, the less a further evaluation can add. A whisker whose gain wanders is evaluated again when that
//! may exceed the margin of the published gain. An evaluation teaches the whisker's own calibration, finds the pressure
//! with the least mean of Eq. 35 and moves there, if
//! - the gain in mean error exceeds a margin (below it the present pressure is as good as any),
//! - the move exceeds what a regulator dithers (or it would chase the regulator, not the whisker),
//! - 95 of 100 cases that the contacts leave open are better there, and
//! - no more than three steps were made. Numbers of setpoints are bounded by that and by the doubling.
//!
//! A gain by contact ratio corrects the errors that no single pressure can correct. It goes with each setpoint, and is
//! published anew, with the same pressure, when the contacts determine it better than the one in force: once for each
//! doubling of the contacts, or after 200 contacts where the gain has wandered further than a margin.
//!
//! A robot that multiplies its readings by one number ([`Objective::Shape`]) has its pressure refined for the shape of the
//! response, and gets the number anew after each evaluation that changes it. If its contacts state no place, only touch tests
//! tell the response, and each of them is evaluated at its end.

use borsh::{BorshDeserialize, BorshSerialize};

use crate::estimation::uncertainty::{Curve, Uncertain, mean_error, moments};
use crate::estimation::{Belief, Carried, ResponseBins, Visit};
use crate::mechanics::{CONTACT_RATIOS, Compensator, EVEN_WEIGHTS, LOG_MODULUS, Objective, Setpoint, least_error};
use crate::policy::Case;
use crate::robot::Robot;
use crate::robot::compensation::Compensation;
use crate::robot::compensation::responses::{LevelFrom, MeasuredResponses, over, reading_gain, sum};
use crate::robot::effect::{Condition, Effect, Fault, Reason, Refinement, RefinementOutcome, WhiskerIndex};
use crate::robot::params::Params;
use crate::robot::state::whisker::Desired;
use crate::units::Megapascal;

/// A reading gain is published anew if it has changed by more than this, log sensitivity: 1 % of the difference that a cut
/// of 1 mm makes. The doubling of the contacts bounds the number of setpoints.
const READING_GAIN_STEP: f64 = 3e-4;

/// Contacts of the first evaluation where contacts state no place: a touch test after the setpoint, without the touches that may
/// be missed. The next ones follow after 7/4 of them: the test after a new gain, and then the tests of the schedule.
const WITHOUT_PLACE_CONTACTS: u32 = 30;

/// Number of steps that leaves none, and from which on a pressure is followed instead: each time counts, up to the largest
/// number. A chamber of 0.2 MPa empties in 50 of them.
const KEEPS_PRESSURE: u8 = 192;

/// Progress of the refinement of a compensation.
#[derive(Debug, Clone, PartialEq, BorshSerialize, BorshDeserialize)]
pub(in crate::robot) struct Refining {
    steps: u8,
    /// Contacts at the present pressure from which the next evaluation is due; 0 for the first.
    due: u32,
    /// Belief about the response at the present pressure before it was held.
    pub carried: Carried,
    /// The gain that was published last.
    pub gain: Curve,
    /// The compensator's response since: the gain is judged by contacts that it was not made from.
    pub since_gain: ResponseBins,
}

crate::optional_parts::optional_fields!(Refining: carried, gain;
    steps: *steps > 0,
    due: *due > 0,
    since_gain: *since_gain != ResponseBins::default(),
);

impl Refining {
    pub(in crate::robot) fn new(gain: Curve, carried: Carried) -> Self {
        Self { steps: 0, due: 0, carried, gain, since_gain: ResponseBins::default() }
    }

    /// The chamber leaks, or its regulator is broken: only the gain is refined.
    pub(in crate::robot) fn of_gain(gain: Curve, carried: Carried) -> Self {
        Self { steps: KEEPS_PRESSURE, ..Self::new(gain, carried) }
    }

    /// Whether the pressure is the one that the chamber has, because of a fault when this was decided.
    pub(in crate::robot) fn keeps_pressure(&self) -> bool {
        self.steps >= KEEPS_PRESSURE
    }

    /// The same steps and gain, without any contacts at the present pressure.
    pub(in crate::robot) fn felt_anew(&self) -> Self {
        Self { steps: self.steps, ..Self::new(self.gain, Carried::default()) }
    }

    /// Brings what was measured to another scale, by this much log sensitivity.
    pub(in crate::robot) fn shift(&mut self, log_shift: f64) {
        self.carried.shift(log_shift);
        self.since_gain.shift(log_shift);
    }

    /// The next evaluation is due as soon as there are enough contacts for one.
    pub(in crate::robot) fn hasten(&mut self) {
        self.due = 0;
    }
}

/// Result of an evaluation.
struct Look {
    /// The best pressure and its predicted error.
    best: Setpoint,
    /// Mean error there, over the open cases.
    error: f64,
    /// Its standard deviation.
    sd: f64,
    /// Expected gain in mean error.
    gained: f64,
    /// Share of the cases that are better there.
    better: f64,
    /// The gain for it.
    gain: Curve,
    /// Belief about the response there.
    pub carried: Carried,
}

impl Robot {
    /// Evaluates a running compensation if that is due, and refines it.
    pub(in crate::robot) fn refine(&mut self, params: &Params, at: usize, effects: &mut Vec<Effect>) {
        let running = &self.head.compensations[at];
        let contacts = running.after.contacts();
        let by_tests = running.reading_gain().is_some() && self.states_no_place(running.compensator());
        let least = if by_tests { WITHOUT_PLACE_CONTACTS } else { params.refinement.first_look_contacts };
        let due = running.refining.due.max(least);
        let one = &self.whiskers[running.compensator()];
        // A cut whisker that has lost sensitivity goes on with another gain; its pressure stays. That of a leaking one, too.
        let has_lost = one.condition == Condition::SensitivityLoss;
        let holds_pressure = has_lost || one.fault.is_some();
        // A suspicion is for the detector to settle first.
        let calm = match one.condition {
            Condition::Healthy | Condition::Trimmed | Condition::SensitivityLoss => {
                matches!(one.fault, None | Some(Fault::Leak | Fault::Regulator)) && one.rare.pending_trim.is_none()
            }
            Condition::Learning | Condition::Suspected | Condition::Eroding => false,
        };
        if contacts < due || !calm || one.command.is_some() || self.holds(running.compensator()) {
            return;
        }
        let off = (params.refinement.gain_margin / one.walks.rate()).powi(2) as u32;
        let wandered = contacts.saturating_add(off.max(least));
        let next = if by_tests { contacts.saturating_mul(7) / 4 } else { params.refinement.next_look(contacts) };
        self.head.compensations[at].refining.due = next.min(wandered);
        if !has_lost {
            // With another gauge the change would be taken for one by the pressure.
            self.remember(at);
        }
        let running = &self.head.compensations[at];
        let Some(felt) =
            self.measured_responses(params, running, &running.refining.carried, &running.after, LevelFrom::Filter)
        else {
            return;
        };
        let look = self.look(params, running, &felt);
        let found = outcome(params, running, look.as_ref());
        let stays = holds_pressure && found == RefinementOutcome::Refined;
        let outcome = if stays { RefinementOutcome::HeldUncertain } else { found };
        let objective = running.objective();
        let in_force = running.reading_gain().map(|_| &running.refining.gain);
        let (error, error_sd) = (felt.error(in_force), felt.error_sd(in_force));
        let gain_error = felt.error(Some(&running.refining.gain));
        let own_gain_error = felt.error_of_own_gain(objective);
        let moves = outcome == RefinementOutcome::Refined;
        // A gain that wanders hastens the evaluations, but each published one is judged by as many contacts as the first.
        let is_judged = running.refining.since_gain.contacts() >= least;
        let is_better = match running.reading_gain() {
            None => gain_error > params.refinement.gain_margin.max(1.5 * own_gain_error),
            // One number from all contacts is better than the same from fewer.
            Some(gain) => (felt.gain(objective)[0] / gain).ln().abs() > READING_GAIN_STEP,
        };
        let gain_better = is_better && is_judged;
        if gain_better && !moves {
            // A gain that wanders faster than this would be published again and again, without effect.
            self.head.compensations[at].refining.due = next;
        }
        let running = &self.head.compensations[at];
        let record = Refinement {
            compensation: running.id,
            contacts,
            outcome,
            pressure_from: running.pressure,
            pressure_best: look.as_ref().map(|look| look.best.pressure),
            error,
            error_sd,
            error_best: look.as_ref().map(|look| (look.error, look.sd)),
            error_with_gain: gain_error,
            error_with_own_gain: own_gain_error,
            gain_published: moves || gain_better,
        };
        effects.push(Effect::Refined(Box::new(record)));
        match &look {
            Some(look) if moves => self.move_to(at, look),
            // A robot reports APPLIED only near the pressure that it has.
            Some(_) | None if gain_better => {
                let gain = felt.gain(objective);
                let compensator = self.head.compensations[at].compensator();
                if !self.follow_pressure(params, compensator, 0.0) {
                    self.publish_gain(at, gain);
                }
            }
            Some(_) | None => {}
        }
    }

    /// Stores the responses of a compensator at its pressure, for this and later decisions.
    fn remember(&mut self, at: usize) {
        let running = &self.head.compensations[at];
        let one = &mut self.whiskers[running.compensator()];
        // An estimate goes on after the decision, but the visit is measured against the length at it.
        let length_sd_mm = one.filter.relative_length().sd_mm.max(running.length_sd_mm);
        one.rare.get_or_insert().own.get_or_insert_default().remember(Visit {
            compensation: running.id,
            pressure: running.pressure,
            length: running.length,
            length_sd_mm,
            bins: running.after.clone(),
        });
    }

    /// Follows a pressure that drifts by more than so much, because the chamber leaks or its regulator is broken: a new setpoint
    /// with the pressure that it has, and the gain for it. Returns whether there is one.
    pub(in crate::robot) fn follow_pressure(&mut self, params: &Params, index: WhiskerIndex, within_mpa: f64) -> bool {
        let is_its = |one: &Compensation| one.compensator() == index && !one.proposed && one.refining.keeps_pressure();
        let Some(at) = self.head.compensations.iter().position(is_its) else { return false };
        let Some(pressure) = self.pressure_it_has(params, index) else { return false };
        let running = &self.head.compensations[at];
        let way_mpa = (pressure.mpa() - running.pressure.mpa()).abs();
        if way_mpa <= within_mpa
            || running.refining.steps == u8::MAX
            || self.whiskers[index].command.is_some()
            || self.holds(index)
        {
            return false;
        }
        let carried = &running.refining.carried;
        let felt = self.measured_responses(params, running, carried, &running.after, LevelFrom::Filter);
        let look = felt.and_then(|felt| self.look_between(params, running, &felt, (pressure, pressure)));
        if let Some(look) = &look {
            self.move_to(at, look);
        }
        look.is_some()
    }

    /// The best pressure within the compensation's limits, by the present knowledge of the compensator.
    fn look(&self, params: &Params, running: &Compensation, felt: &MeasuredResponses) -> Option<Look> {
        let (pressure_min, highest) = self.whiskers[running.compensator()].pressures(self.head.air_control);
        let limit = highest.mpa().min(Megapascal::EXAMINED_MAX.mpa());
        let highest = match running.case {
            // Lower than before, or the strain would grow beyond what the cut did.
            Case::SelfCompensation => limit.min(running.pressure_before.mpa()),
            Case::ShorterForLonger | Case::LongerForShorter => limit,
        };
        self.look_between(params, running, felt, (pressure_min, Megapascal::known(highest)))
    }

    /// The best pressure between two.
    fn look_between(
        &self,
        params: &Params,
        running: &Compensation,
        felt: &MeasuredResponses,
        (pressure_min, pressure_max): (Megapascal, Megapascal),
    ) -> Option<Look> {
        let one = &self.whiskers[running.compensator()];
        let (model, objective) = (one.model(params)?, running.objective());
        let belief = one.belief(model);
        let family = model.family(belief.predict[LOG_MODULUS]);
        let changes = |pressure: Megapascal| family.log_changes(model, running.length, pressure);
        let from = changes(running.pressure);
        let held = felt.held;
        let deviation =
            |pressure: Megapascal| sum(&held.by_ratio(), &Belief::change(&belief.predict, &from, &changes(pressure)));
        let compensator =
            Compensator { length: running.length, pressure: running.pressure_before, pressure_min, pressure_max };
        let [before, target] =
            [crate::robot::compensation::responses::BEFORE, crate::robot::compensation::responses::TARGET]
                .map(|response| felt.per_mm(response));
        let best = *least_error(model, compensator, &deviation, (before, target), objective, &felt.usual)?.setpoint();
        let to = changes(best.pressure);
        let mut known = felt.known;
        let there = sum(
            &crate::robot::compensation::responses::log_curve(model, running.length, best.pressure, &mut known),
            &deviation(best.pressure),
        );
        let [after, before, target] = felt.responses.mean;
        let mut both = Uncertain { mean: [after, before, target, there], causes: Vec::new() };
        // What moves the response here moves it there.
        both.causes.extend(felt.responses.causes.iter().map(|[a, b, t]| [*a, *b, *t, *a]));
        let causes = belief.causes(&from, &to);
        both.moves(&causes, &[3]);
        // With an objective that uses the gain, each pressure comes with its own.
        let weights = match objective {
            Objective::Tip | Objective::Mean => &EVEN_WEIGHTS,
            Objective::Shape => &felt.usual.weights,
        };
        let weights = over(&known, weights);
        let gain_at = |response: &Curve| match objective {
            Objective::Tip | Objective::Mean => [1.0; CONTACT_RATIOS.len()],
            Objective::Shape => reading_gain(response, &target, &weights),
        };
        let [by_gain_here, by_gain_there] = [after, there].map(|response| gain_at(&response).map(f64::ln));
        let cases = both.cases(|[here, before, target, there]| {
            let (here, there) = (sum(here, &by_gain_here), sum(there, &by_gain_there));
            (mean_error(&here, before, target, &weights), mean_error(&there, before, target, &weights))
        });
        let (error, sd) = moments(&cases.iter().map(|case| case.1).collect::<Vec<_>>());
        let (gained, _) = moments(&cases.iter().map(|case| case.0 - case.1).collect::<Vec<_>>());
        let better = cases.iter().filter(|case| case.1 < case.0).count() as f64 / cases.len() as f64;
        let gain = match objective {
            Objective::Tip | Objective::Mean => std::array::from_fn(|k| (target[k] - there[k]).exp()),
            Objective::Shape => gain_at(&there),
        };
        let carried = held.carried(&Belief::change(&belief.predict, &from, &to), &causes);
        Some(Look { best, error, sd, gained, better, gain, carried })
    }

    fn move_to(&mut self, at: usize, look: &Look) {
        let running = &mut self.head.compensations[at];
        running.pressure = look.best.pressure;
        running.refining.carried = look.carried;
        running.after = ResponseBins::default();
        running.refining.steps = running.refining.steps.saturating_add(1);
        running.refining.due = 0;
        self.publish_gain(at, look.gain);
    }

    /// A new setpoint with the present pressure and this gain.
    fn publish_gain(&mut self, at: usize, gain: Curve) {
        let running = &mut self.head.compensations[at];
        // Not settled until the robot has taken it: that is what makes it be sent.
        running.settled = false;
        running.refining.gain = gain;
        running.refining.since_gain = ResponseBins::default();
        let (compensator, desired) = (running.compensator(), running.desired(Reason::Refinement));
        self.desire(compensator, desired);
    }
}

impl Compensation {
    /// The objective by which it is refined. A gain that is one number tells [`Objective::Shape`].
    fn objective(&self) -> Objective {
        if self.reading_gain().is_some() { Objective::Shape } else { Objective::Mean }
    }

    /// The setpoint that its compensator shall hold now.
    pub(in crate::robot) fn desired(&self, reason: Reason) -> Desired {
        Desired { pressure: self.pressure, reason, compensation: Some(self.id), gain: Some(self.refining.gain) }
    }

    /// Mean and standard deviation of Eq. 35 with the gain in force, by contacts since it was published; none
    /// while these are too few.
    pub(in crate::robot) fn error_with_gain(&self, robot: &Robot, params: &Params) -> Option<(f64, f64)> {
        let since = &self.refining.since_gain;
        let enough = since.contacts() >= CONTACT_RATIOS.len() as u32 * params.measurement.bin_contacts_min;
        if !enough {
            return None;
        }
        // From these contacts alone: the earlier belief went into the gain.
        let felt = robot.measured_responses(params, self, &Carried::default(), since, LevelFrom::Contacts)?;
        let gain = Some(&self.refining.gain);
        Some((felt.error(gain), felt.error_sd(gain)))
    }
}

fn outcome(params: &Params, running: &Compensation, look: Option<&Look>) -> RefinementOutcome {
    let Some(look) = look else { return RefinementOutcome::HeldUnpredictable };
    let way_mpa = (look.best.pressure.mpa() - running.pressure.mpa()).abs();
    if way_mpa <= params.refinement.dither_mpa {
        RefinementOutcome::HeldDither
    } else if look.gained <= params.refinement.margin {
        RefinementOutcome::HeldMargin
    } else if look.better < params.refinement.confidence {
        RefinementOutcome::HeldUncertain
    } else if running.refining.steps >= params.refinement.steps_max {
        RefinementOutcome::HeldSteps
    } else {
        RefinementOutcome::Refined
    }
}
