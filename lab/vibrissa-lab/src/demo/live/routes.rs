//! The route by which the console's page lets incidents happen. Only the demo serves it.

use axum::extract::Extension;
use axum::response::Json;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vibrissa_protocol::Name;
use vibrissa_supervisor::http::asking::Asker;
use vibrissa_supervisor::http::extract::Body;
use vibrissa_supervisor::http::problem::{Kind, Problem};
use vibrissa_supervisor::http::{App, FurtherRoutes};

use super::incident::{Incident, WhiskerName};
use super::incidents::{Incidents, Refusal};

/// The demo's route.
pub(in crate::demo) fn routes(incidents: Incidents) -> FurtherRoutes {
    FurtherRoutes::new(OpenApiRouter::<App>::new().routes(routes!(cause_incident)).layer(Extension(incidents)))
}

/// Kind of an incident.
#[derive(Debug, Clone, Copy, Deserialize, ToSchema)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
enum IncidentKind {
    /// The whisker loses `by_mm` at once.
    Cut,
    /// Each contact wears the whisker off.
    Erode,
    /// The whisker's chamber leaks.
    Leak,
    /// The whiskers of the array get warmer by `by_k`.
    Heat,
    /// A new whisker is installed and reported.
    Replace,
}

/// An incident of a simulated whisker.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = Incident)]
struct IncidentBody {
    /// Name of the robot.
    #[schema(value_type = String, pattern = "^[A-Za-z0-9_-]{1,64}$")]
    robot: Name,
    /// Name of the array.
    #[schema(value_type = String, pattern = "^[A-Za-z0-9_-]{1,64}$")]
    array: Name,
    /// Number of the whisker in its array.
    whisker: u16,
    /// Kind of the incident.
    kind: IncidentKind,
    /// For `CUT`, and only for it: lost length, mm.
    by_mm: Option<f64>,
    /// For `HEAT`, and only for it: change of the temperature, K.
    by_k: Option<f64>,
}

/// Answer to an incident.
#[derive(Debug, Serialize, ToSchema)]
struct Happened {
    /// One sentence for people.
    told: String,
}

impl IncidentBody {
    fn incident(&self) -> Result<Incident, Problem> {
        let needed = |field: &str, value: Option<f64>| value.ok_or_else(|| Problem::invalid(field, "is missing"));
        let (incident, others) = match self.kind {
            IncidentKind::Cut => (Incident::Cut { by_mm: needed("by_mm", self.by_mm)? }, [("by_k", self.by_k); 2]),
            IncidentKind::Heat => (Incident::Heat { by_k: needed("by_k", self.by_k)? }, [("by_mm", self.by_mm); 2]),
            IncidentKind::Erode => (Incident::Erode, [("by_mm", self.by_mm), ("by_k", self.by_k)]),
            IncidentKind::Leak => (Incident::Leak, [("by_mm", self.by_mm), ("by_k", self.by_k)]),
            IncidentKind::Replace => (Incident::Replace, [("by_mm", self.by_mm), ("by_k", self.by_k)]),
        };
        match others.into_iter().find(|(_, value)| value.is_some()) {
            Some((field, _)) => Err(Problem::invalid(field, "does not belong to this kind of incident")),
            None => Ok(incident),
        }
    }
}

/// Let an incident happen to a simulated whisker of the demo.
#[utoipa::path(
    post, path = "/demo/incidents", tag = "demo", request_body = IncidentBody,
    responses((status = 200, description = "It has happened", body = Happened)),
    extensions(("x-required-role" = json!("ADMIN")))
)]
async fn cause_incident(
    Extension(incidents): Extension<Incidents>,
    asker: Asker,
    Body(body): Body<IncidentBody>,
) -> Result<Json<Happened>, Problem> {
    let incident = body.incident()?;
    let at = WhiskerName { robot: body.robot, array: body.array, whisker: body.whisker };
    match incidents.cause(&at, incident, asker).await {
        Ok(told) => Ok(Json(Happened { told })),
        Err(Refusal::Store(problem)) => Err(problem.into()),
        Err(Refusal::OutOfRange { field, detail }) => Err(Problem::invalid(field, detail)),
        Err(refusal @ Refusal::UnknownWhisker(..)) => Err(Problem::unknown(refusal.to_string())),
        Err(refusal @ (Refusal::NotYet | Refusal::Simulation(_) | Refusal::Report(_))) => {
            Err(Problem::new(Kind::Refused, refusal.to_string()))
        }
    }
}
