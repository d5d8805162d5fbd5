//! Actions on all robots, whiskers or fleets that meet conditions.
//!
//! A dry run lists the subjects and returns their digest. The request itself names the digest, so that it concerns the
//! subjects that were listed, and no others. Each subject gets an action of its own, which the owner of its fleet executes.

use std::collections::BTreeSet;

use axum::extract::State;
use axum::response::Json;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use utoipa::ToSchema;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vibrissa_edge::actions::{ActionKind, RecordedKind};
use vibrissa_edge::words::Word as _;
use vibrissa_protocol::Name;
use vibrissa_store::actions::NewAction;
use vibrissa_store::bulk::{BulkAsked, ChildAction, WAITING_MAX};
use vibrissa_store::list::{Filter, Selection, Value as Sql};
use vibrissa_store::lists::robots::{ROBOTS, RobotSort, RobotSummary};
use vibrissa_store::lists::whiskers::{WHISKERS, Whisker};

use super::filters::{RobotFilter, WhiskerFilter, has_vented_alarm};
use crate::http::App;
use crate::http::asking::{Asker, number_of, reason};
use crate::http::extract::Body;
use crate::http::problem::{Kind, Problem};

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new()
        .routes(routes!(hold_robots))
        .routes(routes!(release_robots))
        .routes(routes!(hold_whiskers))
        .routes(routes!(release_whiskers))
        .routes(routes!(rebaseline_whiskers))
}

/// Most subjects of a request.
pub const SUBJECTS_MAX: u32 = 1000;
/// Subjects whose actions become due in each second, unless the request states another number.
const PER_S: u32 = 20;
/// Greatest number of actions that become due in each second.
const PER_S_MAX: u32 = 100;
/// Length of a digest.
const DIGEST_CHARS: usize = 32;
/// Time in which an action must be executed once it is due, µs.
const LIFETIME_US: i64 = 30_000_000;

/// Defines the bodies of requests for many.
macro_rules! bodies {
    ($($(#[$meta:meta])* $name:ident: $filter:ty;)+) => {
        $($(#[$meta])*
        #[derive(Debug, Deserialize, ToSchema)]
        #[serde(deny_unknown_fields)]
        pub struct $name {
            /// Conditions on the subjects.
            #[serde(default)]
            pub filter: $filter,
            /// True: only list the subjects, and change nothing.
            #[serde(default)]
            pub dry_run: bool,
            /// Digest of the subjects that the dry run listed. The request is refused (412) if other subjects meet the conditions
            /// meanwhile. Without it, the subjects are those of the moment.
            #[schema(pattern = "^[0-9a-f]{32}$")]
            pub digest: Option<String>,
            /// Number of subjects whose actions become due in each second, 1 to 100; by default 20.
            #[schema(minimum = 1, maximum = 100)]
            pub per_second: Option<u32>,
            /// Reason in free text, at most 1000 characters.
            #[schema(max_length = 1000)]
            pub reason: Option<String>,
        })+
    };
}

bodies! {
    /// Robots that a request concerns.
    RobotsAtOnce: RobotFilter;
    /// Whiskers that a request concerns.
    WhiskersAtOnce: WhiskerFilter;
}

/// A subject of a request for many.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
#[schema(as = BulkSubject)]
pub struct Subject {
    /// Name of the fleet.
    pub fleet: String,
    /// Name of the robot; null for a whole fleet.
    pub robot: Option<String>,
    /// Name of the array; null for a whole robot or fleet.
    pub array: Option<String>,
    /// Number of the whisker in its array; null for a whole robot or fleet.
    #[schema(minimum = 0)]
    pub whisker: Option<i64>,
}

/// Subjects that a request would concern, or concerns.
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = BulkStarted)]
pub struct Started {
    /// Whether nothing was requested.
    pub dry_run: bool,
    /// Number of subjects, at most 1000.
    #[schema(minimum = 0, maximum = 1000)]
    pub subjects: usize,
    /// Whether further subjects meet the conditions: repeat the request for them.
    pub more: bool,
    /// Digest of the subjects, for `digest` of the request.
    #[schema(pattern = "^[0-9a-f]{32}$")]
    pub digest: String,
    /// Number of the request for many, whose progress is at `/v1/bulk-actions/{action_id}`; null in a dry run, and without
    /// subjects.
    pub action_id: Option<i64>,
    /// The subjects, in a dry run only.
    pub items: Vec<Subject>,
}

/// A request for many.
pub(super) struct Request {
    /// Kind of the entry that stands for the request.
    pub(super) of_all: RecordedKind,
    /// Word of the action of each subject.
    pub(super) of_each: &'static str,
    /// Conditions, for the audit log.
    pub(super) which: Value,
    /// Further parameters of the request, for the audit log.
    pub(super) details: Value,
    /// Subjects, each with the parameters of its action.
    pub(super) subjects: Vec<(Subject, Value)>,
    /// Whether there are more subjects.
    pub(super) more: bool,
    pub(super) options: Options,
}

/// The caller's choices for a request.
pub(super) struct Options {
    pub(super) dry_run: bool,
    pub(super) digest: Option<String>,
    pub(super) per_second: Option<u32>,
    pub(super) reason: Option<String>,
}

/// A digest of subjects and of the versions of what is changed. It does not depend on what a request changes, because the
/// dry run may come before that is decided.
fn digest(subjects: &[(Subject, Value)]) -> String {
    let mut hasher = blake3::Hasher::new();
    for (subject, parameters) in subjects {
        hasher.update(json!([subject, parameters.get("expected_version")]).to_string().as_bytes());
    }
    hasher.finalize().to_hex()[..DIGEST_CHARS].to_owned()
}

fn is_digest(text: &str) -> bool {
    text.len() == DIGEST_CHARS && text.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'a'..=b'f'))
}

/// The fleet of the subjects, if it is the same for all.
fn only_fleet(subjects: &[(Subject, Value)]) -> Option<&str> {
    let first = subjects.first()?.0.fleet.as_str();
    subjects.iter().all(|(one, _)| one.fleet == first).then_some(first)
}

/// Lists the subjects, or requests an action of each.
pub(super) async fn ask_many(app: &App, asker: Asker, request: Request) -> Result<Json<Started>, Problem> {
    let Request { of_all, of_each, which, details, subjects, more, options } = request;
    let why = reason(options.reason)?;
    let per_s = options.per_second.unwrap_or(PER_S);
    if !(1..=PER_S_MAX).contains(&per_s) {
        return Err(Problem::invalid("per_second", format!("must be 1 to {PER_S_MAX}, not {per_s}")));
    }
    if let Some(given) = options.digest.as_ref().filter(|given| !is_digest(given)) {
        return Err(Problem::invalid("digest", format!("must be the digest of a dry run, not {given:?}")));
    }
    let digest = digest(&subjects);
    let count = subjects.len();
    let answer = |dry_run, action_id, items| {
        Ok(Json(Started { dry_run, subjects: count, more, digest: digest.clone(), action_id, items }))
    };
    if options.dry_run {
        return answer(true, None, subjects.into_iter().map(|(subject, _)| subject).collect());
    }
    let mut parameters = json!({ "which": which, "per_second": per_s, "digest": options.digest });
    if let (Value::Object(all), Value::Object(details)) = (&mut parameters, details) {
        all.extend(details);
    }
    let mut each = asker.clone().action(of_each, &json!({}), why.clone());
    each.idempotency_key = None;
    let key = asker.idempotency_key.clone();
    let mut all = asker.action(of_all.word(), &parameters, why);
    all.fleet = only_fleet(&subjects).map(ToOwned::to_owned);
    if let Some(known) = known(app, &all, key.is_some()).await? {
        return answer(false, Some(known), Vec::new());
    }
    if options.digest.as_ref().is_some_and(|expected| *expected != digest) {
        let problem = format!("{count} subjects meet the conditions, but not those of the dry run: repeat the dry run");
        return Err(Problem::new(Kind::VersionChanged, problem));
    }
    if subjects.is_empty() {
        return answer(false, None, Vec::new());
    }
    let child = |(at, (subject, parameters)): (usize, &(Subject, Value))| {
        let not_before_us = each.asked_us + at as i64 * 1_000_000 / i64::from(per_s);
        let action = NewAction {
            fleet: Some(subject.fleet.clone()),
            robot: subject.robot.clone(),
            array: subject.array.clone(),
            whisker: subject.whisker,
            parameters: parameters.to_string(),
            expires_us: not_before_us + LIFETIME_US,
            ..each.clone()
        };
        ChildAction { action, not_before_us }
    };
    let children: Vec<ChildAction> = subjects.iter().enumerate().map(child).collect();
    let asked = match app.store.ask_many(&all, &children).await? {
        BulkAsked::Done(asked) => *asked,
        BulkAsked::TooMany(waiting) => {
            let problem = format!("{waiting} actions wait already, and at most {WAITING_MAX} may: repeat this later");
            return Err(Problem::new(Kind::TooManyRequests, problem));
        }
    };
    let action_id = number_of(asked)?;
    let fleets: BTreeSet<&str> = subjects.iter().map(|(subject, _)| subject.fleet.as_str()).collect();
    for fleet in fleets.into_iter().filter_map(|fleet| Name::new(fleet).ok()) {
        app.action_notifier.notify(&fleet);
    }
    app.action_notifier.changed();
    answer(false, Some(action_id), Vec::new())
}

/// The number of the same request under the same idempotency key. Its subjects may be others by now, for example because
/// they are held.
async fn known(app: &App, all: &NewAction, has_key: bool) -> Result<Option<i64>, Problem> {
    if !has_key {
        return Ok(None);
    }
    let before = app.store.action_of_key(&all.actor, all.idempotency_key.as_deref()).await?;
    Ok(before
        .filter(|before| before.kind == all.kind && before.parameters == all.parameters && before.reason == all.reason)
        .map(|before| before.action_id))
}

/// The robots that meet the conditions, and whether there are more.
async fn robots(
    app: &App,
    asker: &Asker,
    filter: RobotFilter,
    held: Option<bool>,
) -> Result<(Vec<Subject>, bool), Problem> {
    let mut filters = filter.conditions(&asker.caller.scope)?;
    filters.extend(held.map(|held| Filter::Is("held", Sql::Flag(held))));
    let sort = RobotSort::RobotId.sort();
    let selection = Selection { filters, sort, descending: false, after: None, limit: SUBJECTS_MAX };
    let page = app.store.list::<RobotSummary>(&ROBOTS, &selection).await?;
    let subject = |row: RobotSummary| Subject { fleet: row.fleet, robot: Some(row.robot), array: None, whisker: None };
    Ok((page.rows.into_iter().map(subject).collect(), page.next.is_some()))
}

/// The whiskers that meet the conditions, and whether there are more.
async fn whiskers(
    app: &App,
    asker: &Asker,
    filter: WhiskerFilter,
    held: Option<bool>,
) -> Result<(Vec<Subject>, bool), Problem> {
    let mut filters = filter.conditions(&asker.caller.scope)?;
    let is_held = |held| Filter::Is("held", Sql::Flag(held));
    filters.extend(held.map(|held| match held {
        // A release fills a vented whisker again.
        true => Filter::AnyOf(vec![is_held(true), has_vented_alarm(true)]),
        false => is_held(false),
    }));
    let selection = Selection { filters, ..Selection::all(&WHISKERS, SUBJECTS_MAX) };
    let page = app.store.list::<Whisker>(&WHISKERS, &selection).await?;
    let subject = |row: Whisker| Subject {
        fleet: row.fleet,
        robot: Some(row.robot),
        array: Some(row.array),
        whisker: Some(row.whisker),
    };
    Ok((page.rows.into_iter().map(subject).collect(), page.next.is_some()))
}

/// Defines the requests for many: path, kind of the request, action of each subject, and whether only subjects that are held
/// or not held are concerned.
macro_rules! at_once {
    ($($(#[$meta:meta])* $name:ident = $path:literal, $tag:literal, $body:ty, $find:ident($held:expr), $all:ident, $each:ident;)+) => {
        $($(#[$meta])*
        ///
        /// With `dry_run` it lists them and changes nothing. Each subject gets its own entry in the audit log, which the owner of its
        /// fleet executes. `/v1/bulk-actions/{action_id}` has the progress.
        #[utoipa::path(
            post, path = $path, tag = $tag,
            params(("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
            request_body = $body,
            responses((status = 200, description = "The subjects", body = Started)),
            extensions(("x-required-role" = json!("OPERATOR")))
        )]
        async fn $name(
            State(app): State<App>,
            asker: Asker,
            Body(body): Body<$body>,
        ) -> Result<Json<Started>, Problem> {
            let which = json!(body.filter);
            let (subjects, more) = $find(&app, &asker, body.filter, $held).await?;
            let request = Request {
                of_all: RecordedKind::$all,
                of_each: ActionKind::$each.word(),
                which,
                details: json!({}),
                subjects: subjects.into_iter().map(|subject| (subject, json!({}))).collect(),
                more,
                options: Options {
                    dry_run: body.dry_run,
                    digest: body.digest,
                    per_second: body.per_second,
                    reason: body.reason,
                },
            };
            ask_many(&app, asker, request).await
        })+
    };
}

at_once! {
    /// Hold all robots that meet the conditions and are not held, at most 1000.
    hold_robots = "/v1/robots/hold", "robots", RobotsAtOnce, robots(Some(false)), RobotsHold, Hold;
    /// Release all robots that meet the conditions and are held, at most 1000.
    release_robots = "/v1/robots/release", "robots", RobotsAtOnce, robots(Some(true)), RobotsRelease, Release;
    /// Hold all whiskers that meet the conditions and are not held, at most 1000.
    hold_whiskers = "/v1/whiskers/hold", "whiskers", WhiskersAtOnce, whiskers(Some(false)), WhiskersHold, Hold;
    /// Release all whiskers that meet the conditions and are held or vented (alarm VENTED), at most 1000.
    release_whiskers = "/v1/whiskers/release", "whiskers", WhiskersAtOnce, whiskers(Some(true)), WhiskersRelease, Release;
    /// Relearn the baselines of all whiskers that meet the conditions, at most 1000.
    rebaseline_whiskers = "/v1/whiskers/rebaseline", "whiskers", WhiskersAtOnce, whiskers(None), WhiskersRebaseline, Rebaseline;
}

const _: () = assert!(SUBJECTS_MAX == 1000, "the texts above name the limit");
