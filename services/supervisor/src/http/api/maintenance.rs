//! Windows of maintenance: alarms that are raised in them are shelved, and notify nobody.

use axum::extract::{Extension, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Json, Response};
use serde::{Deserialize, Serialize};
use serde_json::json;
use utoipa::{IntoParams, ToSchema};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vibrissa_edge::actions::RecordedKind;
use vibrissa_edge::clock::wall_clock;
use vibrissa_edge::words::Word as _;
use vibrissa_protocol::Name;
use vibrissa_store::actions::Asked;
use vibrissa_store::lists::actions::ActionRow;
use vibrissa_store::maintenance::{MaintenanceRow, NewMaintenance, Planned, WINDOWS_MAX};
use vibrissa_store::time::Time;

use crate::http::App;
use crate::http::access::Caller;
use crate::http::asking::{Asker, Why, answered, number_of, reason};
use crate::http::extract::{Body, OptionalBody, Path};
use crate::http::moment::Moment;
use crate::http::problem::{Kind, Problem};
use crate::http::words::words;

/// A day in µs.
const DAY_US: i64 = 86_400_000_000;
/// Longest window, µs: 30 days, as for shelving, so that no alarm is forgotten.
const LASTS_US_MAX: i64 = 30 * DAY_US;
/// Latest begin, µs from now: a year.
const AHEAD_US_MAX: i64 = 366 * DAY_US;

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(list_maintenance, set_maintenance)).routes(routes!(end_maintenance))
}

words! {
    /// How often a window of maintenance comes again.
    pub enum RepeatWord {
        /// Each day.
        Daily = "DAILY",
        /// Each week.
        Weekly = "WEEKLY",
    }
}

impl RepeatWord {
    /// Time from one begin to the next, µs. The hour stays the same in UTC, and not by a clock with summer time.
    const fn us(self) -> i64 {
        match self {
            Self::Daily => DAY_US,
            Self::Weekly => 7 * DAY_US,
        }
    }
}

words! {
    /// State of a window of maintenance.
    pub enum MaintenanceState {
        /// It is now.
        Active = "ACTIVE",
        /// It comes.
        Planned = "PLANNED",
        /// It is over, and does not come again.
        Ended = "ENDED",
    }
}

/// A window of maintenance, or a series of windows.
#[derive(Debug, Serialize, ToSchema)]
pub struct Maintenance {
    /// Number of the window.
    #[schema(minimum = 1)]
    pub maintenance_id: i64,
    /// Name of the fleet.
    pub fleet: String,
    /// Name of the robot; null for all robots of the fleet.
    pub robot: Option<String>,
    /// State of the window.
    pub state: MaintenanceState,
    /// Begin of the present window, or else of the next; null if none comes any more.
    pub begins_at: Option<Time>,
    /// End of that window; null if none comes any more.
    pub ends_at: Option<Time>,
    /// How often it comes again; null for a single window.
    pub repeats: Option<RepeatWord>,
    /// Time from which on there is no window; null without such a time.
    pub ended_at: Option<Time>,
    /// Reason that the person gave.
    pub reason: String,
    /// Person or token that set it.
    pub set_by: String,
    /// Time at which it was set.
    pub set_at: Time,
}

impl Maintenance {
    fn of(row: &MaintenanceRow) -> Self {
        let now_us = wall_clock().0 as i64;
        let next = row.next(now_us);
        let state = match (row.at(now_us), next) {
            (Some(_), _) => MaintenanceState::Active,
            (None, Some(_)) => MaintenanceState::Planned,
            (None, None) => MaintenanceState::Ended,
        };
        let repeats = [RepeatWord::Daily, RepeatWord::Weekly].into_iter().find(|one| Some(one.us()) == row.repeat_us);
        Self {
            maintenance_id: row.maintenance_id,
            fleet: row.fleet.clone(),
            robot: row.robot.clone(),
            state,
            begins_at: next.map(|(begins_us, _)| Time(begins_us)),
            ends_at: next.map(|(_, ends_us)| Time(ends_us)),
            repeats,
            ended_at: row.ended_us.map(Time),
            reason: row.reason.clone(),
            set_by: row.set_by.clone(),
            set_at: Time(row.set_us),
        }
    }
}

/// The windows of maintenance that the caller may see.
#[derive(Debug, Serialize, ToSchema)]
pub struct MaintenanceList {
    /// The windows, in the order of their numbers, also those that ended less than 30 days ago. There are at most 200.
    pub items: Vec<Maintenance>,
}

/// A new window of maintenance.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = NewMaintenance)]
pub struct MaintenanceBody {
    /// Name of the fleet.
    #[schema(value_type = String, pattern = "^[A-Za-z0-9_-]{1,64}$")]
    pub fleet: Name,
    /// Name of the robot; null for all robots of the fleet, also future ones.
    #[schema(value_type = Option<String>, pattern = "^[A-Za-z0-9_-]{1,64}$")]
    pub robot: Option<Name>,
    /// Begin of the window (RFC 3339), within a year; now if omitted.
    #[schema(value_type = Option<String>, format = DateTime, example = "2026-11-30T22:00:00Z")]
    pub from: Option<Moment>,
    /// End of the window (RFC 3339), at most 30 days after its begin, a day if it repeats daily, a week if weekly.
    #[schema(value_type = String, format = DateTime, example = "2026-11-30T23:00:00Z")]
    pub until: Moment,
    /// How often it comes again, at the same time in UTC; null for a single window.
    pub repeats: Option<RepeatWord>,
    /// Reason in free text, 1 to 1000 characters.
    #[schema(min_length = 1, max_length = 1000)]
    pub reason: String,
}

impl MaintenanceBody {
    fn checked(&self) -> Result<NewMaintenance, Problem> {
        let now_us = wall_clock().0 as i64;
        let begins_us = self.from.map_or(now_us, |Moment(Time(from_us))| from_us);
        if begins_us.saturating_sub(now_us) > AHEAD_US_MAX {
            return Err(Problem::invalid("from", "must be within a year from now"));
        }
        let Moment(Time(until_us)) = self.until;
        let lasts_us = until_us.saturating_sub(begins_us);
        let longest_us = self.repeats.map_or(LASTS_US_MAX, RepeatWord::us);
        if until_us <= now_us || !(1..=longest_us).contains(&lasts_us) {
            let problem =
                "must be in the future and after the begin, at most 30 days later, or a day or a week if it repeats";
            return Err(Problem::invalid("until", problem));
        }
        if self.reason.trim().is_empty() {
            return Err(Problem::invalid("reason", "must not be empty: state what is done"));
        }
        Ok(NewMaintenance {
            fleet: self.fleet.to_string(),
            robot: self.robot.as_ref().map(ToString::to_string),
            begins_us,
            lasts_us,
            repeat_us: self.repeats.map(RepeatWord::us),
            ended_us: None,
            reason: self.reason.trim().to_owned(),
        })
    }
}

/// Path parameters of a window of maintenance.
#[derive(Debug, Clone, Deserialize, IntoParams)]
#[into_params(parameter_in = Path)]
pub struct MaintenancePath {
    /// Number of the window.
    #[param(minimum = 0)]
    pub maintenance_id: i64,
}

/// The window of a number, if the caller may see it.
async fn found(app: &App, caller: &Caller, maintenance_id: i64) -> Result<MaintenanceRow, Problem> {
    let mut rows = app.store.maintenance().await?.into_iter();
    let row = rows.find(|row| row.maintenance_id == maintenance_id && caller.scope.covers(&row.fleet));
    row.ok_or_else(|| Problem::not_found(format_args!("maintenance {maintenance_id}")))
}

/// The windows of maintenance: present, coming, and those that ended less than 30 days ago.
#[utoipa::path(
    get, path = "/v1/maintenance", tag = "alarms",
    responses((status = 200, description = "The windows", body = MaintenanceList))
)]
async fn list_maintenance(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
) -> Result<Json<MaintenanceList>, Problem> {
    let rows = app.store.maintenance().await?;
    let items = rows.iter().filter(|row| caller.scope.covers(&row.fleet)).map(Maintenance::of).collect();
    Ok(Json(MaintenanceList { items }))
}

/// Set a window of maintenance. Alarms that are raised in it are recorded and shelved until its end, and notify nobody.
/// Those that still stand then are told again.
#[utoipa::path(
    post, path = "/v1/maintenance", tag = "alarms",
    params(("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
    request_body = MaintenanceBody,
    responses((status = 201, description = "The window is set", body = Maintenance)),
    extensions(("x-required-role" = json!("OPERATOR")))
)]
async fn set_maintenance(
    State(app): State<App>,
    asker: Asker,
    Body(body): Body<MaintenanceBody>,
) -> Result<Response, Problem> {
    let caller = asker.caller.clone();
    let (new, why) = (body.checked()?, reason(Some(body.reason.clone()))?);
    if !caller.scope.covers(&new.fleet) {
        return Err(Problem::not_found(format_args!("fleet {}", new.fleet)));
    }
    if !app.store.has_fleet(&new.fleet).await? {
        return Err(Problem::not_found(format_args!("fleet {}", new.fleet)));
    }
    // A repeated request without a begin has another time.
    let (from, until) = (body.from.map(|from| from.0), body.until.0);
    let parameters = json!({ "from": from, "until": until, "repeats": body.repeats });
    let mut action = asker.action(RecordedKind::MaintenanceSet.word(), &parameters, why);
    (action.fleet, action.robot) = (Some(new.fleet.clone()), new.robot.clone());
    let row = match app.store.set_maintenance(&new, &action).await? {
        Planned::Done(maintenance_id) => found(&app, &caller, maintenance_id).await?,
        Planned::Known(asked) => {
            // The request that has set it left its person and its time.
            let set = match &*asked {
                Asked::Again(kept) => (kept.actor.clone(), kept.asked_us),
                Asked::New(_) | Asked::Different(_) => Default::default(),
            };
            number_of(*asked)?;
            let same = |row: &MaintenanceRow| (&row.set_by, row.set_us) == (&set.0, set.1);
            let rows = app.store.maintenance().await?;
            rows.into_iter().rfind(same).ok_or_else(|| Problem::unknown("the window was removed meanwhile"))?
        }
        Planned::NoRobot => {
            let robot = new.robot.unwrap_or_default();
            return Err(Problem::not_found(format_args!("robot {robot} in fleet {}", new.fleet)));
        }
        Planned::Full => {
            let problem = format!("there are {WINDOWS_MAX} windows of maintenance already: end one, or wait");
            return Err(Problem::new(Kind::Refused, problem));
        }
    };
    let place = [(header::LOCATION, format!("/v1/maintenance/{}", row.maintenance_id))];
    Ok((StatusCode::CREATED, place, Json(Maintenance::of(&row))).into_response())
}

/// End a window of maintenance and its series now. Its alarms that still stand are told again.
#[utoipa::path(
    post, path = "/v1/maintenance/{maintenance_id}/end", tag = "alarms",
    params(MaintenancePath, ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
    request_body = Option<Why>,
    responses((status = 200, description = "The window is ended", body = ActionRow)),
    extensions(("x-required-role" = json!("OPERATOR")))
)]
async fn end_maintenance(
    State(app): State<App>,
    Path(at): Path<MaintenancePath>,
    asker: Asker,
    OptionalBody(why): OptionalBody<Why>,
) -> Result<Response, Problem> {
    let row = found(&app, &asker.caller, at.maintenance_id).await?;
    let parameters = json!({ "maintenance_id": row.maintenance_id });
    let mut action = asker.action(RecordedKind::MaintenanceEnd.word(), &parameters, reason(why.reason)?);
    (action.fleet, action.robot) = (Some(row.fleet.clone()), row.robot.clone());
    let action_id = number_of(app.store.end_maintenance(&row, &action).await?)?;
    answered(&app, action_id, StatusCode::OK).await
}
