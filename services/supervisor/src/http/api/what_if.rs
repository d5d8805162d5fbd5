//! Simulates a cut of a whisker, and shows the decisions that would follow.

use axum::extract::State;
use axum::response::Json;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vibrissa_core::mechanics::{CONTACT_RATIOS, Objective};
use vibrissa_core::robot::effect::{CandidateRecord, Decision};
use vibrissa_core::robot::{Params, Planned, Robot, Served, WhatIf, one_number};
use vibrissa_core::units::{ContactRatio, Millimetre};
use vibrissa_edge::words::Word;
use vibrissa_host::task;

use super::model::per_mm;
use super::paths::{Learned, WhiskerPath};
use crate::http::App;
use crate::http::extract::{Path, Query};
use crate::http::problem::{Kind, Problem};
use vibrissa_edge::ids::wide_id;
use vibrissa_store::lists::compensations::{Candidate, Numbers};

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(get_what_if))
}

/// Parameters of a what-if query.
#[derive(Debug, Clone, Copy, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct WhatIfQuery {
    /// Remaining length, mm.
    #[param(minimum = 1, maximum = 1000)]
    pub length_mm: f64,
}

/// Result of a what-if query.
#[derive(Debug, Serialize, ToSchema)]
pub struct WhatIfAnswer {
    /// Decisions that would be taken: for the whisker itself, for whiskers that lose it as compensator, and for
    /// whiskers whose compensator it takes.
    pub decisions: Vec<WhatIfDecision>,
    /// Compensations in force that would end.
    pub ended: Vec<WhatIfEnd>,
    /// Setpoints that would be sent.
    pub setpoints: Vec<WhatIfSetpoint>,
    /// Compensation of the cut whisker with each objective of the policy, beside one another.
    pub by_objective: Vec<WhatIfObjective>,
    /// Predicted sensitivities at the contact ratios 0.45, 0.50 .. 1.00, each with the learned offset of the whisker that
    /// feels the contact; empty if the answering supervisor does not know the whisker's model.
    pub by_ratio: Vec<WhatIfSensitivity>,
}

/// Predicted sensitivities at a contact ratio, in strain per mm of deflection (Eq. 31, averaged over the gauge's grid).
#[derive(Debug, Serialize, ToSchema)]
pub struct WhatIfSensitivity {
    /// Contact ratio: position along the whisker, 0 at the base, 1 at the tip.
    pub ratio: f64,
    /// Whole whisker at its nominal pressure, which a compensation imitates; null where the contact would lie on the chamber.
    pub before_per_mm: Option<f64>,
    /// Whisker after the cut, at its nominal pressure.
    pub after_per_mm: Option<f64>,
    /// Reading of the compensator at the pressure of its setpoint, with its reading gain; null without a compensator.
    pub compensated_per_mm: Option<f64>,
}

/// A decision that would be taken.
#[derive(Debug, Serialize, ToSchema)]
pub struct WhatIfDecision {
    /// Array of the target whisker.
    pub array: String,
    /// Number of the target whisker.
    pub target_whisker: u16,
    /// Whole length of the target whisker, mm.
    pub target_length_mm: f64,
    /// Nominal pressure of the target whisker, MPa.
    pub target_pressure_mpa: f64,
    /// Number of the compensator; null if no candidate is suitable.
    pub compensator_whisker: Option<u16>,
    /// Candidates in the order of evaluation.
    pub candidates: Vec<Candidate>,
}

/// Compensation of the cut whisker with one objective, for a robot that applies a gain exactly if the objective needs one.
#[derive(Debug, Serialize, ToSchema)]
pub struct WhatIfObjective {
    /// Objective: `TIP`, `MEAN` or `SHAPE`.
    pub objective: String,
    /// Whether the policy and the robot have it now.
    pub in_force: bool,
    /// Number of the compensator in its array; null if no candidate is suitable.
    #[schema(minimum = 0)]
    pub compensator_whisker: Option<u16>,
    /// Case of the paper: `SELF_COMPENSATION`, `SHORTER_FOR_LONGER` or `LONGER_FOR_SHORTER`.
    pub case: Option<String>,
    /// Pressure to hold, MPa.
    pub pressure_mpa: Option<f64>,
    /// Factor on each reading; null with an objective that needs no gain.
    pub reading_gain: Option<f64>,
    /// Predicted mean error of the reading (Eq. 35), as a ratio.
    pub predicted_error: Option<f64>,
    /// Lower bound of the 95 % interval of `predicted_error`, as a ratio.
    pub predicted_error_low: Option<f64>,
    /// Upper bound of the 95 % interval of `predicted_error`, as a ratio.
    pub predicted_error_high: Option<f64>,
}

/// A compensation that would end.
#[derive(Debug, Serialize, ToSchema)]
pub struct WhatIfEnd {
    /// Number of the compensation.
    #[schema(minimum = 0)]
    pub compensation_id: i64,
    /// Reason for its end.
    pub reason: String,
}

/// A setpoint that would be sent.
#[derive(Debug, Serialize, ToSchema)]
pub struct WhatIfSetpoint {
    /// Name of the array.
    pub array: String,
    /// Number of the whisker in its array.
    pub whisker: u16,
    /// Pressure to hold, MPa.
    pub pressure_mpa: f64,
    /// Reason for the setpoint.
    pub reason: String,
    /// Residual gain at the contact ratios 0.45, 0.50 .. 1.00; null if there is no gain to apply.
    pub gain: Option<Vec<f64>>,
}

/// Maps the core's whisker indices to names.
struct Names<'a> {
    robot: &'a Robot,
    robot_id: i64,
}

/// The sensitivities before the cut, after it, and of the compensator that the decision about the whisker chooses.
fn by_ratio(
    robot: &Robot,
    params: &Params,
    index: usize,
    length: Millimetre,
    answer: &WhatIf,
) -> Vec<WhatIfSensitivity> {
    let Some(view) = robot.whisker(index) else { return Vec::new() };
    let Some(model) = params.model(&view.sheet.model) else { return Vec::new() };
    let own = answer.decisions.iter().find(|one| one.target == index);
    let chosen = own.and_then(|one| one.candidates.get(one.chosen?));
    let compensator = chosen.and_then(|one| {
        let view = robot.whisker(one.whisker)?;
        // A whisker that serves itself has the length of the cut.
        let length = if one.whisker == index { length } else { one.length.length };
        let planned = answer.setpoints.iter().find(|planned| planned.whisker == one.whisker);
        let reading_gain = planned.and_then(|planned| one_number(planned.gain.as_ref()?)).unwrap_or(1.0);
        Some((params.model(&view.sheet.model)?, view.offset, length, one.pressure?, reading_gain))
    });
    let sensitivity = |a: f64| {
        let ratio = ContactRatio::new(a).ok()?;
        let own = |length: Millimetre| {
            let predicted = per_mm(model, ratio, length.mm(), view.sheet.pressure.mpa())?;
            Some(predicted * view.offset.at(ratio).exp())
        };
        Some(WhatIfSensitivity {
            ratio: a,
            before_per_mm: own(view.sheet.length),
            after_per_mm: own(length),
            compensated_per_mm: compensator.and_then(|(model, offset, length, pressure, reading_gain)| {
                Some(reading_gain * per_mm(model, ratio, length.mm(), pressure.mpa())? * offset.at(ratio).exp())
            }),
        })
    };
    CONTACT_RATIOS.into_iter().filter_map(sensitivity).collect()
}

impl Names<'_> {
    fn name(&self, index: usize) -> (String, u16) {
        self.robot.whisker(index).map_or_else(Default::default, |view| (view.array.to_owned(), view.sheet.number))
    }

    fn answer(&self, answer: &WhatIf, in_force: Objective, by_ratio: Vec<WhatIfSensitivity>) -> WhatIfAnswer {
        let ended = answer.ended.iter().map(|&(number, reason)| WhatIfEnd {
            compensation_id: wide_id(self.robot_id, number),
            reason: reason.word().to_owned(),
        });
        WhatIfAnswer {
            decisions: answer.decisions.iter().map(|one| self.decision(one)).collect(),
            ended: ended.collect(),
            setpoints: answer.setpoints.iter().map(|one| self.setpoint(one)).collect(),
            by_objective: answer.by_objective.iter().map(|one| self.objective(one, in_force)).collect(),
            by_ratio,
        }
    }

    fn objective(&self, &(objective, served): &(Objective, Option<Served>), in_force: Objective) -> WhatIfObjective {
        let interval = served.and_then(|served| served.predicted_error_interval);
        WhatIfObjective {
            objective: objective.word().to_owned(),
            in_force: objective == in_force,
            compensator_whisker: served.map(|served| self.name(served.compensator).1),
            case: served.map(|served| served.case.word().to_owned()),
            pressure_mpa: served.map(|served| served.pressure.mpa()),
            reading_gain: served.and_then(|served| served.reading_gain),
            predicted_error: served.map(|served| served.predicted_error),
            predicted_error_low: interval.map(|interval| interval.0),
            predicted_error_high: interval.map(|interval| interval.1),
        }
    }

    fn decision(&self, decision: &Decision) -> WhatIfDecision {
        let (array, target_whisker) = self.name(decision.target);
        let chosen = decision.chosen.and_then(|at| decision.candidates.get(at));
        let candidates = decision.candidates.iter().enumerate();
        WhatIfDecision {
            array,
            target_whisker,
            target_length_mm: decision.target_length.mm(),
            target_pressure_mpa: decision.target_pressure.mpa(),
            compensator_whisker: chosen.map(|one| self.name(one.whisker).1),
            candidates: candidates.map(|(at, one)| self.candidate(one, decision.chosen == Some(at))).collect(),
        }
    }

    fn candidate(&self, one: &CandidateRecord, chosen: bool) -> Candidate {
        Candidate {
            whisker: self.name(one.whisker).1.into(),
            compensation_case: one.case.word().to_owned(),
            length_mm: one.length.length.mm(),
            length_sd_mm: one.length.sd_mm,
            pressure_before_mpa: one.pressure_before.mpa(),
            pressure_mpa: one.pressure.map(|pressure| pressure.mpa()),
            predicted_error: one.predicted_error,
            predicted_error_low: one.predicted_error_interval.map(|interval| interval.0),
            predicted_error_high: one.predicted_error_interval.map(|interval| interval.1),
            predicted_error_by_ratio: one.predicted_error_by_ratio.map(|by_ratio| Numbers(by_ratio.to_vec())),
            gives_up_own_role: one.gives_up_own_role,
            chosen,
            refused: one.refused.map(|refused| refused.word().to_owned()),
        }
    }

    fn setpoint(&self, planned: &Planned) -> WhatIfSetpoint {
        let (array, whisker) = self.name(planned.whisker);
        WhatIfSetpoint {
            array,
            whisker,
            pressure_mpa: planned.pressure.mpa(),
            reason: planned.reason.word().to_owned(),
            gain: planned.gain.map(|gain| gain.to_vec()),
        }
    }
}

/// Decisions and setpoints that would follow if a whisker were cut to a length and the cut had just been detected.
/// Changes nothing.
#[utoipa::path(
    get, path = "/v1/fleets/{fleet}/robots/{robot}/arrays/{array}/whiskers/{whisker}/what-if", tag = "whiskers",
    params(WhiskerPath, WhatIfQuery),
    responses(
        (status = 200, description = "The result", body = WhatIfAnswer),
        (status = 409, description = "The whisker is already that short", body = crate::http::problem::ProblemBody,
         content_type = "application/problem+json"),
    )
)]
async fn get_what_if(
    State(app): State<App>,
    Path(at): Path<WhiskerPath>,
    Query(query): Query<WhatIfQuery>,
) -> Result<Json<WhatIfAnswer>, Problem> {
    let length = Millimetre::new(query.length_mm).ok().filter(|length| length.mm() >= 1.0);
    let length = length.ok_or_else(|| Problem::invalid("length_mm", "must be 1 to 1000"))?;
    let Learned { robot, robot_id, index } = at.learned(&app.store).await?;
    // Assigning compensators in a large array takes a while.
    let params = app.params_of(&at.fleet, &at.robot).await?;
    let answered = task::blocking(move || {
        let answer = robot.what_if(&params, index, length)?;
        let curve = by_ratio(&robot, &params, index, length, &answer);
        let in_force = params.policy.objective_for(robot.applies_gain());
        Ok::<_, vibrissa_core::robot::WhatIfError>(Names { robot: &robot, robot_id }.answer(&answer, in_force, curve))
    });
    let answered = answered.await.map_err(|problem| Problem::new(Kind::Internal, problem.to_string()))?;
    answered.map(Json).map_err(|problem| Problem::new(Kind::Refused, problem.to_string()))
}
