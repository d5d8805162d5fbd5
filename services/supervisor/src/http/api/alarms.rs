//! Alarms with guidance: all of them, the standing ones with storms folded, and their counts.

use std::borrow::Cow;

use axum::extract::{Extension, State};
use axum::response::{Json, Response};
use serde::{Deserialize, Serialize};
use utoipa::openapi::schema::ObjectBuilder;
use utoipa::openapi::{Ref, RefOr, Schema};
use utoipa::{PartialSchema, ToSchema};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vibrissa_edge::guidance;
use vibrissa_edge::words::{Word, Words};
use vibrissa_protocol::Name;

use super::alarm_actions::AlarmPath;
use crate::http::App;
use crate::http::access::{Caller, Scope};
use crate::http::extract::{Path, Query};
use crate::http::fleets::FleetFilter;
use crate::http::labels::LabelFilter;
use crate::http::listing::Listing;
use crate::http::moment::{Moment, between};
use crate::http::page::{Page, list_query};
use crate::http::problem::Problem;
use crate::http::search::Search;
use crate::http::words::{AlarmKindWord, AlarmStateWord, LevelWord, OneOf};
use vibrissa_core::robot::effect::AlarmKind;
use vibrissa_store::list::{Filter, Value};
use vibrissa_store::lists::alarms::{
    ALARMS, AlarmCount, AlarmRow, AlarmSort, COUNTS, CountSort, FOLDED, Fold, FoldedRow, FoldedSort, STANDING,
};

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new()
        .routes(routes!(list_alarms))
        .routes(routes!(get_alarm))
        .routes(routes!(list_folded_alarms))
        .routes(routes!(count_alarms))
}

/// Guidance about an alarm: how urgent it is, and what to do.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub struct AlarmGuidance {
    /// How soon somebody must act.
    pub level: LevelWord,
    /// Advice for people at once.
    pub hint: &'static str,
    /// Likely causes, the most likely first.
    pub causes: &'static [&'static str],
    /// Address of the runbook. It begins with a slash if this service has it.
    #[schema(example = "/runbooks/VibrissaWhiskerUncompensated.md")]
    pub runbook_url: String,
}

impl AlarmGuidance {
    /// The guidance about alarms of a kind. A kind of a newer program in the same database has the least level.
    fn of(kind: &str, app: &App) -> Self {
        let of = guidance::of_word(kind).unwrap_or(guidance::Guidance {
            level: guidance::Level::Warning,
            hint: "Update this supervisor: a newer one has raised this kind of alarm.",
            causes: &[],
            runbook: "README.md",
        });
        let runbook_url = format!("{}/{}", app.runbooks_url, of.runbook);
        Self { level: OneOf(of.level), hint: of.hint, causes: of.causes, runbook_url }
    }
}

/// An alarm about a whisker or a robot, with guidance.
#[derive(Debug, Clone, Serialize)]
pub struct Alarm {
    #[serde(flatten)]
    row: AlarmRow,
    #[serde(flatten)]
    guidance: AlarmGuidance,
}

impl Alarm {
    /// Adds the guidance to a row.
    pub(super) fn of(row: AlarmRow, app: &App) -> Self {
        Self { guidance: AlarmGuidance::of(&row.kind, app), row }
    }
}

/// Number of alarms of a kind in a fleet, with the level of the kind.
#[derive(Debug, Clone, Serialize)]
pub struct AlarmsOfKind {
    #[serde(flatten)]
    count: AlarmCount,
    /// How soon somebody must act.
    level: LevelWord,
}

/// A standing alarm, or a storm of them, with guidance.
#[derive(Debug, Clone, Serialize)]
pub struct FoldedAlarm {
    #[serde(flatten)]
    row: AlarmRow,
    /// The alarms for which the row stands.
    fold: Fold,
    #[serde(flatten)]
    guidance: AlarmGuidance,
}

/// Declares the schema of a row that serde flattens from parts, as one object: generators of clients and the columns of
/// CSV need its properties in one place.
macro_rules! joined_schema {
    ($($row:ident = $description:literal: $($part:ty),+ $(; $field:literal: $inner:ty)?;)+) => {
        $(impl PartialSchema for $row {
            fn schema() -> RefOr<Schema> {
                let mut all = ObjectBuilder::new().description(Some($description));
                $(if let RefOr::T(Schema::Object(part)) = <$part>::schema() {
                    all = part.properties.into_iter().fold(all, |all, (name, schema)| all.property(name, schema));
                    all = part.required.into_iter().fold(all, ObjectBuilder::required);
                })+
                $(all = all.property($field, Ref::from_schema_name(<$inner>::name())).required($field);)?
                all.into()
            }
        }

        impl ToSchema for $row {
            fn name() -> Cow<'static, str> {
                stringify!($row).into()
            }

            fn schemas(schemas: &mut Vec<(String, RefOr<Schema>)>) {
                $(<$part>::schemas(schemas);)+
                $(schemas.push((<$inner>::name().into_owned(), <$inner>::schema()));
                <$inner>::schemas(schemas);)?
            }
        })+
    };
}

joined_schema! {
    Alarm = "An alarm about a whisker or a robot, with guidance.": AlarmRow, AlarmGuidance;
    FoldedAlarm = "A standing alarm, or a storm of them, with guidance.": AlarmRow, AlarmGuidance; "fold": Fold;
    AlarmsOfKind = "Number of alarms of a kind in a fleet, with the level of the kind.": AlarmCount; "level": LevelWord;
}

/// Columns that a search looks into.
const SEARCHED: &[&str] =
    &["fleet", "robot", "\"array\"", "kind", "acknowledged_by", "acknowledged_reason", "shelved_reason"];

/// Most words of a search.
const WORDS_MAX: usize = 8;

/// Conditions on alarms; those that are given must all hold.
#[derive(Debug, Clone, Default, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct AlarmFilter {
    /// Fleets: names or patterns such as `hall-*`, separated by commas.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fleet: Option<FleetFilter>,
    /// Name of the robot.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<String>, pattern = "^[A-Za-z0-9_-]{1,64}$")]
    pub robot: Option<Name>,
    /// Name of the array.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<String>, pattern = "^[A-Za-z0-9_-]{1,64}$")]
    pub array: Option<Name>,
    /// Number of the whisker in its array.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(maximum = 65535)]
    pub whisker: Option<u16>,
    /// Conditions on the labels of the robot: `key=value`, or `key` for any value; up to 8, separated by commas.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub label: Option<LabelFilter>,
    /// Kind of the alarm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kind: Option<AlarmKindWord>,
    /// Level of the alarm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub level: Option<LevelWord>,
    /// State of the alarm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub state: Option<AlarmStateWord>,
    /// True: only alarms that are not shelved; false: only shelved ones.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub open: Option<bool>,
    /// Words that the alarm must contain, in its names, kind or comments; capital and small letters count alike.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<String>, min_length = 1, max_length = 100, pattern = "^[^\\x00]+$")]
    pub q: Option<Search>,
    /// Earliest time of raising, inclusive.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<String>, format = DateTime)]
    pub from: Option<Moment>,
    /// Latest time of raising, exclusive.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<String>, format = DateTime)]
    pub to: Option<Moment>,
}

impl AlarmFilter {
    /// The conditions for the database, limited to the caller's fleets.
    ///
    /// # Errors
    /// The search has too many words, or contains a NUL character.
    pub(super) fn conditions(self, scope: &Scope) -> Result<Vec<Filter>, Problem> {
        let text = |column, name: Option<Name>| name.map(|name| Filter::Is(column, Value::Text(name.to_string())));
        let mut all: Vec<Filter> = scope.filter("fleet").into_iter().collect();
        all.extend(self.fleet.map(|fleets| Filter::fleets("fleet", fleets.iter())));
        all.extend(text("robot", self.robot));
        all.extend(text("\"array\"", self.array));
        all.extend(self.whisker.map(|whisker| Filter::Is("whisker", Value::Whole(whisker.into()))));
        all.extend(Filter::labels("robot_id", self.label.as_ref().map(|LabelFilter(conditions)| conditions)));
        all.extend(self.kind.map(|kind| Filter::Is("kind", Value::Text(kind.to_string()))));
        all.extend(self.level.map(|level| Filter::IsOneOf("kind", kinds_of(level.0))));
        all.extend(self.state.map(|state| Filter::Is("state", Value::Text(state.to_string()))));
        all.extend(self.open.map(|open| Filter::IsNull("shelved_until", open)));
        all.extend(between("raised_at", self.from, self.to));
        all.extend(searched(&self.q.map(|q| q.to_string()).unwrap_or_default())?);
        Ok(all)
    }
}

fn kinds_of(level: guidance::Level) -> Vec<String> {
    let of = guidance::BY_URGENCY.into_iter().filter(|&kind| guidance::of(kind).level == level);
    of.map(|kind| kind.word().to_owned()).collect()
}

/// A condition for each word of a search.
fn searched(search: &str) -> Result<Vec<Filter>, Problem> {
    if search.split_whitespace().count() > WORDS_MAX {
        return Err(Problem::invalid("q", format!("must have at most {WORDS_MAX} words")));
    }
    if search.contains('\0') {
        return Err(Problem::nul("q"));
    }
    Ok(search.split_whitespace().map(contains).collect())
}

fn contains(word: &str) -> Filter {
    let small = word.to_lowercase();
    let is_named = |kind: &AlarmKind| kind.label().is_some_and(|label| label.to_lowercase().contains(&small));
    let kinds = AlarmKind::all().into_iter().filter(is_named).map(|kind| kind.word().to_owned()).collect();
    let mut any = vec![Filter::Contains(SEARCHED, word.to_owned()), Filter::IsOneOf("kind", kinds)];
    any.extend(word.parse::<u16>().ok().map(|number| Filter::Is("whisker", Value::Whole(number.into()))));
    Filter::AnyOf(any)
}

/// Query parameters with the conditions of [`AlarmFilter`].
macro_rules! alarms_query {
    ($(#[$meta:meta])* pub struct $name:ident by $sort:ty { $($(#[$more_meta:meta])* pub $more:ident: $more_type:ty,)* }) => {
        list_query! {
            $(#[$meta])*
            pub struct $name by $sort {
                /// Fleets: names or patterns such as `hall-*`, separated by commas.
                pub fleet: Option<FleetFilter>,
                /// Name of the robot.
                #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9_-]{1,64}$")]
                pub robot: Option<Name>,
                /// Name of the array.
                #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9_-]{1,64}$")]
                pub array: Option<Name>,
                /// Number of the whisker in its array.
                #[param(maximum = 65535)]
                pub whisker: Option<u16>,
                /// Conditions on the labels of the robot: `key=value`, or `key` for any value; up to 8, separated by commas.
                #[param(inline)]
                pub label: Option<LabelFilter>,
                /// Kind of the alarm.
                #[param(inline)]
                pub kind: Option<AlarmKindWord>,
                /// Level of the alarm.
                #[param(inline)]
                pub level: Option<LevelWord>,
                /// State of the alarm.
                #[param(inline)]
                pub state: Option<AlarmStateWord>,
                /// True: only alarms that are not shelved; false: only shelved ones.
                pub open: Option<bool>,
                /// Words that the alarm must contain, in its names, kind or comments; capital and small letters count alike.
                #[param(value_type = Option<String>, min_length = 1, max_length = 100, pattern = "^[^\\x00]+$")]
                pub q: Option<Search>,
                /// Earliest time of raising, inclusive.
                #[param(value_type = Option<String>, format = DateTime)]
                pub from: Option<Moment>,
                /// Latest time of raising, exclusive.
                #[param(value_type = Option<String>, format = DateTime)]
                pub to: Option<Moment>,
                $($(#[$more_meta])* pub $more: $more_type,)*
            }
        }

        impl $name {
            /// The conditions among the parameters.
            fn filter(&self) -> AlarmFilter {
                AlarmFilter {
                    fleet: self.fleet.clone(),
                    robot: self.robot.clone(),
                    array: self.array.clone(),
                    whisker: self.whisker,
                    label: self.label.clone(),
                    kind: self.kind,
                    level: self.level,
                    state: self.state,
                    open: self.open,
                    q: self.q.clone(),
                    from: self.from,
                    to: self.to,
                }
            }
        }
    };
}

alarms_query! {
    /// Filters for the list of alarms.
    pub struct AlarmsQuery by AlarmSort {
        /// True: only standing alarms; false: only the others.
        pub standing: Option<bool>,
    }
}

alarms_query! {
    /// Filters for the list of folded alarms.
    pub struct FoldedAlarmsQuery by FoldedSort {}
}

alarms_query! {
    /// Filters for the counts of alarms.
    pub struct AlarmCountsQuery by CountSort {}
}

/// All alarms, standing and cleared, each with a hint, likely causes and its runbook.
#[utoipa::path(
    get, path = "/v1/alarms", tag = "happenings", params(AlarmsQuery),
    responses((status = 200, description = "A page of alarms", body = Page<Alarm>))
)]
async fn list_alarms(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    listing: Listing,
    Query(query): Query<AlarmsQuery>,
) -> Result<Response, Problem> {
    let mut selection = query.page()?;
    selection.filters = query.filter().conditions(&caller.scope)?;
    selection.filters.extend(query.standing.map(|standing| Filter::Is("standing", Value::Flag(standing))));
    let list = if query.standing == Some(true) { &STANDING } else { &ALARMS };
    let guided = app.clone();
    listing.answer_with(&app, list, selection, move |row: AlarmRow| Alarm::of(row, &guided)).await
}

/// One alarm, standing or cleared, with a hint, likely causes and its runbook.
#[utoipa::path(
    get, path = "/v1/alarms/{alarm_id}", tag = "happenings", params(AlarmPath),
    responses((status = 200, description = "The alarm", body = Alarm))
)]
async fn get_alarm(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    Path(at): Path<AlarmPath>,
) -> Result<Json<Alarm>, Problem> {
    let mut filters = vec![Filter::Is("alarm_id", Value::Whole(at.alarm_id))];
    filters.extend(caller.scope.filter("fleet"));
    let found = app.store.first(&ALARMS, filters).await?;
    found.map(|row| Json(Alarm::of(row, &app))).ok_or_else(|| Problem::not_found(format_args!("alarm {}", at.alarm_id)))
}

/// The standing alarms by robot and array, the most urgent first, with storms folded.
///
/// A storm is more than 10 alarms of the same kind in one fleet, each raised within 5 minutes of the one before. It is one row
/// with their number. To unfold it, list `/v1/alarms` with its fleet, its kind, and its times as `from` and `to`.
#[utoipa::path(
    get, path = "/v1/alarms/folded", tag = "happenings", params(FoldedAlarmsQuery),
    responses((status = 200, description = "A page of standing alarms and storms", body = Page<FoldedAlarm>))
)]
async fn list_folded_alarms(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    listing: Listing,
    Query(query): Query<FoldedAlarmsQuery>,
) -> Result<Response, Problem> {
    let mut selection = query.page()?;
    selection.filters = query.filter().conditions(&caller.scope)?;
    let guided = app.clone();
    let folded = move |FoldedRow { row, fold }| {
        let guidance = AlarmGuidance::of(&row.kind, &guided);
        FoldedAlarm { row, fold, guidance }
    };
    listing.answer_with(&app, &FOLDED, selection, folded).await
}

/// Numbers of standing alarms by fleet and kind.
#[utoipa::path(
    get, path = "/v1/alarms/counts", tag = "happenings", params(AlarmCountsQuery),
    responses((status = 200, description = "A page of counts", body = Page<AlarmsOfKind>))
)]
async fn count_alarms(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    listing: Listing,
    Query(query): Query<AlarmCountsQuery>,
) -> Result<Response, Problem> {
    let mut selection = query.page()?;
    selection.filters = query.filter().conditions(&caller.scope)?;
    let guided = app.clone();
    let levelled = move |count: AlarmCount| {
        let level = AlarmGuidance::of(&count.kind, &guided).level;
        AlarmsOfKind { level, count }
    };
    listing.answer_with(&app, &COUNTS, selection, levelled).await
}
