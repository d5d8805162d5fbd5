//! Labels of robots.

use axum::extract::State;
use axum::http::StatusCode;
use axum::response::Response;
use serde::Deserialize;
use serde_json::json;
use utoipa::{IntoParams, ToSchema};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vibrissa_edge::actions::RecordedKind;
use vibrissa_edge::labels::{LABELS_MAX, LabelKey};
use vibrissa_edge::words::Word as _;
use vibrissa_protocol::Name;
use vibrissa_store::labels::{LabelChange, Labelled};
use vibrissa_store::lists::actions::ActionRow;

use super::paths::RobotPath;
use crate::http::App;
use crate::http::asking::{Asker, Why, answered, number_of, reason};
use crate::http::extract::{Body, OptionalBody, Path};
use crate::http::labels::{LabelKeyText, LabelValueText};
use crate::http::problem::{Kind, Problem};

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(set_label, remove_label))
}

/// Path parameters of a label.
#[derive(Debug, Clone, Deserialize, IntoParams)]
#[into_params(parameter_in = Path)]
pub struct LabelPath {
    /// Name of the fleet.
    #[param(value_type = String, pattern = "^[A-Za-z0-9_-]{1,64}$")]
    pub fleet: Name,
    /// Name of the robot.
    #[param(value_type = String, pattern = "^[A-Za-z0-9_-]{1,64}$")]
    pub robot: Name,
    /// Key of the label.
    #[param(inline)]
    pub key: LabelKeyText,
}

/// Value of a label.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = LabelValue)]
pub struct LabelBody {
    /// Value: 1 to 64 characters without commas and control characters, and without spaces at its ends.
    pub value: LabelValueText,
    /// Reason in free text, at most 1000 characters.
    #[schema(max_length = 1000)]
    pub reason: Option<String>,
}

async fn change(
    app: &App,
    at: &LabelPath,
    asker: Asker,
    (kind, change, why): (RecordedKind, LabelChange<'_>, Option<String>),
) -> Result<Response, Problem> {
    let parameters = match change {
        LabelChange::Set(key, value) => json!({ "key": key, "value": value }),
        LabelChange::Remove(key) => json!({ "key": key }),
    };
    let mut action = asker.action(kind.word(), &parameters, reason(why)?);
    action.fleet = Some(at.fleet.to_string());
    action.robot = Some(at.robot.to_string());
    let LabelPath { fleet, robot, key: LabelKeyText(key) } = at;
    match app.store.change_labels((fleet.as_str(), robot.as_str()), change, &action).await? {
        Labelled::Done(asked) => {
            let action_id = number_of(*asked)?;
            app.action_notifier.changed();
            answered(app, action_id, StatusCode::OK).await
        }
        Labelled::NoRobot => Err(RobotPath { fleet: fleet.clone(), robot: robot.clone() }.unknown(&app.store).await),
        Labelled::NoLabel => Err(no_label(robot, key)),
        Labelled::TooMany => Err(Problem::new(
            Kind::Refused,
            format!("the robot {robot} has {LABELS_MAX} labels, which is the limit: remove one first"),
        )),
    }
}

fn no_label(robot: &Name, key: &LabelKey) -> Problem {
    Problem::unknown(format!("the robot {robot} has no label {}", key.as_str()))
}

/// Set a label of a robot, in place of the value that it may have. A robot has at most 16 labels.
#[utoipa::path(
    put, path = "/v1/fleets/{fleet}/robots/{robot}/labels/{key}", tag = "robots",
    params(LabelPath, ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
    request_body = LabelBody,
    responses((status = 200, description = "The label is set", body = ActionRow)),
    extensions(("x-required-role" = json!("OPERATOR")))
)]
async fn set_label(
    State(app): State<App>,
    Path(at): Path<LabelPath>,
    asker: Asker,
    Body(body): Body<LabelBody>,
) -> Result<Response, Problem> {
    let LabelBody { value: LabelValueText(value), reason } = body;
    change(&app, &at, asker, (RecordedKind::LabelSet, LabelChange::Set(&at.key.0, &value), reason)).await
}

/// Remove a label of a robot.
#[utoipa::path(
    delete, path = "/v1/fleets/{fleet}/robots/{robot}/labels/{key}", tag = "robots",
    params(LabelPath, ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
    request_body = Option<Why>,
    responses((status = 200, description = "The label is removed", body = ActionRow)),
    extensions(("x-required-role" = json!("OPERATOR")))
)]
async fn remove_label(
    State(app): State<App>,
    Path(at): Path<LabelPath>,
    asker: Asker,
    OptionalBody(why): OptionalBody<Why>,
) -> Result<Response, Problem> {
    change(&app, &at, asker, (RecordedKind::LabelRemove, LabelChange::Remove(&at.key.0), why.reason)).await
}
