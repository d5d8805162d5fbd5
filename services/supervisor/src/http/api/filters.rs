//! Conditions on robots and whiskers, in the lists and in requests for many.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use vibrissa_core::robot::effect::AlarmKind;
use vibrissa_edge::words::Word as _;
use vibrissa_protocol::Name;
use vibrissa_store::list::{Filter, Value};
use vibrissa_store::lists::whiskers::named;

use crate::http::access::Scope;
use crate::http::fleets::FleetFilter;
use crate::http::labels::LabelFilter;
use crate::http::problem::Problem;
use crate::http::search::Search;
use crate::http::words::{ConditionWord, ConnectionWord};

/// Conditions on robots; those that are given must all hold.
#[derive(Debug, Clone, Default, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct RobotFilter {
    /// Fleets: names or patterns such as `hall-*`, separated by commas.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fleet: Option<FleetFilter>,
    /// Name of the robot.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<String>, pattern = "^[A-Za-z0-9_-]{1,64}$")]
    pub robot: Option<Name>,
    /// Connection state of the robot.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub connection: Option<ConnectionWord>,
    /// True: only robots with something that needs attention; false: only the others.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub attention: Option<bool>,
    /// True: only robots that an operator holds; false: only the others.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub held: Option<bool>,
    /// Conditions on the labels of the robot: `key=value`, or `key` for any value; up to 8, separated by commas.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub label: Option<LabelFilter>,
    /// Text to look for in the names of fleet and robot and in the model, in upper or lower case.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<String>, min_length = 1, max_length = 100, pattern = "^[^\\x00]+$")]
    pub q: Option<Search>,
}

/// Conditions on whiskers; those that are given must all hold.
#[derive(Debug, Clone, Default, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct WhiskerFilter {
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
    /// Mechanical condition of the whisker.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub condition: Option<ConditionWord>,
    /// True: only whiskers with a fault; false: only those without.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub faulty: Option<bool>,
    /// True: only whiskers that an operator holds; false: only the others.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub held: Option<bool>,
    /// True: only whiskers for which the alarm VENTED stands; false: only the others.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vented: Option<bool>,
    /// Model of the whisker.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<String>, pattern = "^[A-Za-z0-9_-]{1,64}$")]
    pub model: Option<Name>,
    /// Conditions on the labels of the robot: `key=value`, or `key` for any value; up to 8, separated by commas.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub label: Option<LabelFilter>,
    /// Text to look for in the names of fleet, robot and array, in upper or lower case.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<String>, min_length = 1, max_length = 100, pattern = "^[^\\x00]+$")]
    pub q: Option<Search>,
}

fn text(column: &'static str, text: Option<impl ToString>) -> Option<Filter> {
    text.map(|text| Filter::Is(column, Value::Text(text.to_string())))
}

fn labels(label: Option<&LabelFilter>) -> impl Iterator<Item = Filter> {
    Filter::labels("robot_id", label.map(|LabelFilter(conditions)| conditions))
}

/// A body can contain a NUL in a search, which PostgreSQL refuses.
fn checked(q: Option<Search>) -> Result<Option<String>, Problem> {
    match q.map(|q| q.to_string()) {
        Some(q) if q.contains('\0') => Err(Problem::nul("q")),
        q => Ok(q),
    }
}

impl RobotFilter {
    /// The conditions for the list of robots, limited to the caller's fleets.
    ///
    /// # Errors
    /// The search contains a NUL character.
    pub(super) fn conditions(self, scope: &Scope) -> Result<Vec<Filter>, Problem> {
        let mut all: Vec<Filter> = scope.filter("fleet").into_iter().collect();
        all.extend(self.fleet.map(|fleets| Filter::fleets("fleet", fleets.iter())));
        all.extend(text("robot", self.robot));
        all.extend(text("connection", self.connection));
        all.extend(self.attention.map(|attention| match attention {
            true => Filter::AtLeast("attention", Value::Whole(1)),
            false => Filter::Below("attention", Value::Whole(1)),
        }));
        all.extend(self.held.map(|held| Filter::Is("held", Value::Flag(held))));
        all.extend(labels(self.label.as_ref()));
        all.extend(checked(self.q)?.map(|q| Filter::Contains(&["fleet", "robot", "model"], q)));
        Ok(all)
    }
}

impl WhiskerFilter {
    /// The conditions for the list of whiskers, limited to the caller's fleets.
    ///
    /// # Errors
    /// The search contains a NUL character.
    pub(super) fn conditions(self, scope: &Scope) -> Result<Vec<Filter>, Problem> {
        let mut all: Vec<Filter> = scope.filter("fleet").into_iter().collect();
        all.extend(self.fleet.map(|fleets| Filter::fleets("fleet", fleets.iter())));
        all.extend(text("robot", self.robot));
        all.extend(text("\"array\"", self.array));
        all.extend(text("condition", self.condition));
        all.extend(self.faulty.map(|faulty| Filter::IsNull("fault", !faulty)));
        all.extend(self.held.map(|held| Filter::Is("held", Value::Flag(held))));
        all.extend(self.vented.map(has_vented_alarm));
        all.extend(text("model", self.model));
        all.extend(labels(self.label.as_ref()));
        all.extend(checked(self.q)?.map(named));
        Ok(all)
    }
}

/// The condition that the alarm VENTED stands for a whisker, or does not.
pub(super) fn has_vented_alarm(stands: bool) -> Filter {
    Filter::HasAlarm("whisker_id", AlarmKind::Vented.word(), stands)
}
