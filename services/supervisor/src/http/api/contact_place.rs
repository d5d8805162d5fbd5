//! The place of a touch whose strain and deflection are known.

use axum::extract::State;
use axum::response::Json;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vibrissa_core::robot::Touch;
use vibrissa_core::units::{Megapascal, Millimetre, Strain};

use super::paths::{Learned, WhiskerPath};
use crate::http::App;
use crate::http::extract::{Path, Query};
use crate::http::problem::{Kind, Problem};

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(get_contact_place))
}

/// Readings of a touch.
#[derive(Debug, Clone, Copy, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct TouchQuery {
    /// Strain as measured, without any gain, m/m.
    #[param(minimum = -1, maximum = 1)]
    pub strain: f64,
    /// Deflection of the whisker at the contact, mm.
    #[param(exclusive_minimum = 0, maximum = 1000)]
    pub deflection_mm: f64,
    /// Gauge pressure of the chamber, MPa; by default the last measured one.
    #[param(minimum = 0, maximum = 1)]
    pub pressure_mpa: Option<f64>,
}

/// Place of a touch.
#[derive(Debug, Serialize, ToSchema)]
pub struct ContactPlaceAnswer {
    /// Most likely distance from the base, without the chamber's elongation, mm.
    pub distance_mm: f64,
    /// Lower bound of the 95 % interval of `distance_mm`, mm; not below the chamber's end.
    pub distance_low_mm: f64,
    /// Upper bound of the 95 % interval of `distance_mm`, mm; not beyond the tip.
    pub distance_high_mm: f64,
    /// `distance_mm` as a share of the present length.
    pub ratio: f64,
    /// Present length of the whisker, mm.
    pub length_mm: f64,
    /// Gauge pressure of the answer, MPa.
    pub pressure_mpa: f64,
}

/// Place of a touch on a whisker, by its present length, pressure and learned offset. Changes nothing.
#[utoipa::path(
    get, path = "/v1/fleets/{fleet}/robots/{robot}/arrays/{array}/whiskers/{whisker}/contact-place", tag = "whiskers",
    params(WhiskerPath, TouchQuery),
    responses(
        (status = 200, description = "The place", body = ContactPlaceAnswer),
        (status = 409, description = "No place on the whisker explains the strain",
         body = crate::http::problem::ProblemBody, content_type = "application/problem+json"),
    )
)]
async fn get_contact_place(
    State(app): State<App>,
    Path(at): Path<WhiskerPath>,
    Query(query): Query<TouchQuery>,
) -> Result<Json<ContactPlaceAnswer>, Problem> {
    let invalid = Problem::invalid;
    let touch = Touch {
        strain: Strain::new(query.strain).map_err(|_| invalid("strain", "must be -1 to 1"))?,
        deflection: (Millimetre::new(query.deflection_mm).ok().filter(|deflection| deflection.mm() > 0.0))
            .ok_or_else(|| invalid("deflection_mm", "must be above 0 and at most 1000"))?,
        pressure: (query.pressure_mpa.map(Megapascal::new).transpose())
            .map_err(|_| invalid("pressure_mpa", "must be 0 to 1"))?,
    };
    let Learned { robot, index, .. } = at.learned(&app.store).await?;
    let params = app.params_of(&at.fleet, &at.robot).await?;
    let located = robot.locate(&params, index, &touch);
    let located = located.map_err(|error| Problem::new(Kind::Refused, error.to_string()))?;
    Ok(Json(ContactPlaceAnswer {
        distance_mm: located.distance_mm,
        distance_low_mm: located.interval_mm.0,
        distance_high_mm: located.interval_mm.1,
        ratio: located.ratio.a(),
        length_mm: located.length.mm(),
        pressure_mpa: located.pressure.mpa(),
    }))
}
