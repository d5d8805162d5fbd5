//! Allow lists of robots, and the robots that they refused.

use axum::extract::{DefaultBodyLimit, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{Json, Response};
use serde::{Deserialize, Serialize};
use serde_json::json;
use utoipa::ToSchema;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use uuid::Uuid;
use vibrissa_edge::actions::RecordedKind;
use vibrissa_edge::words::Word as _;
use vibrissa_protocol::Name;

use super::paths::FleetPath;
use crate::http::App;
use crate::http::asking::{Asker, Why, answered, number_of, reason, replaced_before};
use crate::http::extract::{Body, OptionalBody, Path};
use crate::http::problem::{Kind, Problem};
use crate::http::version::{etag, lists, tagged};
use vibrissa_store::allowed::{AllowedReading, TurnedAwayReading, names_of};
use vibrissa_store::lists::actions::ActionRow;
use vibrissa_store::time::Time;

/// Maximum number of robots in a list.
const ROBOTS_MAX: usize = 10_000;
/// Size limit of a list in bytes: enough for `ROBOTS_MAX` names of full length.
const BODY_BYTES_MAX: usize = 1024 * 1024;

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new()
        .routes(routes!(get_allowed_robots, put_allowed_robots, delete_allowed_robots))
        .layer(DefaultBodyLimit::max(BODY_BYTES_MAX))
}

/// A robot that is on no list and has sent messages.
#[derive(Debug, Serialize, ToSchema)]
pub struct TurnedAway {
    /// The robot's name.
    pub robot: String,
    /// Number of its messages that were refused.
    #[schema(minimum = 1)]
    pub tries: i64,
    /// Time of its first refused message.
    pub first_at: Time,
    /// Time of its last refused message.
    pub last_at: Time,
}

impl From<TurnedAwayReading> for TurnedAway {
    fn from(row: TurnedAwayReading) -> Self {
        Self { robot: row.robot, tries: row.tries, first_at: Time(row.first_us), last_at: Time(row.last_us) }
    }
}

/// A fleet's allow list: every robot is allowed if both lists are null, otherwise each robot in at least one of them.
#[derive(Debug, Serialize, ToSchema)]
pub struct AllowedRobots {
    /// The fleet's name.
    pub fleet: String,
    /// Version of the list: rises with each change, 0 before the first.
    #[schema(minimum = 0)]
    pub version: i64,
    /// The list set over HTTP; null if no list is set.
    pub robots: Option<Vec<String>>,
    /// The list in this supervisor's file (`limits.robots_file`); null if it has none.
    pub in_file: Option<Vec<String>>,
    /// Time at which the list was set or removed; null if never.
    pub changed_at: Option<Time>,
    /// Actor who set or removed the list; null if never.
    pub changed_by: Option<String>,
    /// Reason for the change; null if none was given.
    pub reason: Option<String>,
    /// Refused robots, the newest first, at most some hundreds; a few seconds old.
    pub turned_away: Vec<TurnedAway>,
}

/// A list of robots.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = NewAllowedRobots)]
pub struct AllowedBody {
    /// Names of the robots; an empty list allows no robot.
    #[schema(value_type = Vec<String>, max_items = 10_000)]
    pub robots: Vec<Name>,
    /// Reason in free text, at most 1000 characters.
    #[schema(max_length = 1000)]
    pub reason: Option<String>,
}

async fn in_force(app: &App, at: &FleetPath) -> Result<Option<AllowedReading>, Problem> {
    if !app.store.has_fleet(at.fleet.as_str()).await? {
        return Err(Problem::not_found(at));
    }
    Ok(app.store.allowed_robots(at.fleet.as_str()).await?)
}

/// The fleet's allow list, and the robots that it refused. A change must send the `ETag` of this answer as `If-Match`.
#[utoipa::path(
    get, path = "/v1/fleets/{fleet}/allowed-robots", tag = "robots", params(FleetPath),
    responses((
        status = 200, description = "The lists", body = AllowedRobots,
        headers(("ETag" = String, description = "Version of the list"))
    ))
)]
async fn get_allowed_robots(State(app): State<App>, Path(at): Path<FleetPath>) -> Result<Response, Problem> {
    let reading = in_force(&app, &at).await?;
    let version = reading.as_ref().map_or(0, |reading| reading.version);
    let sorted = |names: Vec<String>| {
        let mut names = names;
        names.sort_unstable();
        names
    };
    let in_file = app.robots_file.as_ref().map(|file| {
        let robots = file.borrow().of_fleet(&at.fleet);
        sorted(robots.iter().map(Name::to_string).collect())
    });
    let robots = reading.as_ref().and_then(|reading| reading.robots.as_deref());
    let turned_away = app.store.turned_away(at.fleet.as_str()).await?;
    let body = AllowedRobots {
        fleet: at.fleet.to_string(),
        version,
        robots: robots.map(|names| names_of(names).map(|name| name.to_string()).collect()),
        in_file,
        changed_at: reading.as_ref().map(|reading| Time(reading.changed_us)),
        changed_by: reading.as_ref().map(|reading| reading.changed_by.clone()),
        reason: reading.and_then(|reading| reading.reason),
        turned_away: turned_away.into_iter().map(TurnedAway::from).collect(),
    };
    // Always with its body: robots are turned away without a new version.
    Ok(tagged(version, Json(body)))
}

/// The version in the caller's `If-Match`, if it is still current.
async fn expected(app: &App, at: &FleetPath, headers: &HeaderMap) -> Result<i64, Problem> {
    let now = in_force(app, at).await?.map_or(0, |reading| reading.version);
    let Some(given) = headers.get(header::IF_MATCH) else {
        let tag = etag(now);
        return Err(Problem::new(
            Kind::VersionMissing,
            format!("read the list first, and send its ETag as If-Match: {tag}"),
        ));
    };
    if lists(headers, header::IF_MATCH, now) {
        return Ok(now);
    }
    let given = given.to_str().unwrap_or_default();
    Err(changed(now, given))
}

fn changed(now: i64, tag: &str) -> Problem {
    Problem::new(Kind::VersionChanged, format!("the list in force is {}, not {tag}: read it again", etag(now)))
}

async fn set(
    app: &App,
    at: &FleetPath,
    headers: &HeaderMap,
    asker: Asker,
    (robots, why): (Option<Vec<Name>>, Option<String>),
) -> Result<Response, Problem> {
    let why = reason(why)?;
    let kind = RecordedKind::AllowedRobots.word();
    let version = match replaced_before(app, &asker, kind, &at.fleet, headers).await? {
        Some(version) => version,
        None => expected(app, at, headers).await?,
    };
    let text = robots.map(|robots| {
        let mut names: Vec<&str> = robots.iter().map(Name::as_str).collect();
        names.sort_unstable();
        names.dedup();
        names.join("\n")
    });
    // The audit log does not repeat a long list, because the list's own versions are stored.
    let parameters = json!({
        "expected_version": version,
        "robots": text.as_ref().map(|text| text.lines().count()),
        "list": text.as_ref().map(|text| Uuid::new_v5(&Uuid::NAMESPACE_OID, text.as_bytes()).to_string()),
    });
    let mut action = asker.action(kind, &parameters, why);
    action.fleet = Some(at.fleet.to_string());
    let asked = app.store.set_allowed_robots(at.fleet.as_str(), version, text.as_deref(), &action).await?;
    let action_id = number_of(asked.ok_or_else(|| changed(version + 1, &etag(version)))?)?;
    app.action_notifier.notify(&at.fleet);
    answered(app, action_id, StatusCode::OK).await
}

/// Allow only these robots, in place of the list that was read.
///
/// The fleet's owner applies the list within five seconds. It then refuses messages of other robots as `not_allowed`;
/// their recorded data stay. Robots in a supervisor's file (`limits.robots_file`) are allowed as well.
///
/// Once this is answered, no further setpoint and no further request of a touch test goes out to an excluded robot. Those that wait
/// for the broker are withdrawn when the list is applied. One that the broker has already can still reach the robot until it
/// expires, 20 s after it was made at the latest.
#[utoipa::path(
    put, path = "/v1/fleets/{fleet}/allowed-robots", tag = "robots",
    params(
        FleetPath,
        ("If-Match" = Option<String>, Header, description = "`ETag` of the list that was read; 428 if missing"),
        ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")
    ),
    request_body = AllowedBody,
    responses((status = 200, description = "The list is set", body = ActionRow)),
    extensions(("x-required-role" = json!("ENGINEER")))
)]
async fn put_allowed_robots(
    State(app): State<App>,
    Path(at): Path<FleetPath>,
    headers: HeaderMap,
    asker: Asker,
    Body(body): Body<AllowedBody>,
) -> Result<Response, Problem> {
    if body.robots.len() > ROBOTS_MAX {
        return Err(Problem::invalid("robots", format!("must have at most {ROBOTS_MAX} names")));
    }
    if let Some(reserved) = body.robots.iter().find(|name| Name::robot(name.as_str()).is_err()) {
        return Err(Problem::invalid("robots", format!("{reserved} is a reserved name")));
    }
    set(&app, &at, &headers, asker, (Some(body.robots), body.reason)).await
}

/// Remove the list: every robot is allowed, unless a file restricts the fleet.
#[utoipa::path(
    delete, path = "/v1/fleets/{fleet}/allowed-robots", tag = "robots",
    params(
        FleetPath,
        ("If-Match" = Option<String>, Header, description = "`ETag` of the list that was read; 428 if missing"),
        ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")
    ),
    request_body = Option<Why>,
    responses((status = 200, description = "The list is removed", body = ActionRow)),
    extensions(("x-required-role" = json!("ENGINEER")))
)]
async fn delete_allowed_robots(
    State(app): State<App>,
    Path(at): Path<FleetPath>,
    headers: HeaderMap,
    asker: Asker,
    OptionalBody(why): OptionalBody<Why>,
) -> Result<Response, Problem> {
    set(&app, &at, &headers, asker, (None, why.reason)).await
}
