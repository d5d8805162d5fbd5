//! Contacts of a whisker over time, and the lengths estimated from them.

use axum::extract::State;
use axum::response::Json;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::paths::WhiskerPath;
use crate::http::App;
use crate::http::extract::{Path, Query};
use crate::http::moment::Moment;
use crate::http::problem::Problem;
use vibrissa_store::series::{ContactMean, Series, Span};
use vibrissa_store::time::Time;

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(get_contacts)).routes(routes!(get_lengths))
}

/// Default number of points.
pub(super) const POINTS: u32 = 500;
/// Maximum number of points.
const POINTS_MAX: u32 = 2000;
/// Half the width of a 95 % interval, in standard deviations.
pub(super) const Z95: f64 = 1.959_963_984_540_054;

/// Time range of contacts; the newest ones without `from` and `to`.
#[derive(Debug, Clone, Copy, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct SpanQuery {
    /// Begin, inclusive, by the robot's clock. Default: one day before `to`; at most 31 days before it.
    #[param(value_type = Option<String>, format = DateTime)]
    pub from: Option<Moment>,
    /// End, exclusive. Default: after the newest contact.
    #[param(value_type = Option<String>, format = DateTime)]
    pub to: Option<Moment>,
    /// Maximum number of points. More contacts are averaged over equal intervals.
    #[param(minimum = 1, maximum = 2000, default = 500)]
    pub points: Option<u32>,
}

impl SpanQuery {
    fn span(self) -> Result<Span, Problem> {
        let points = self.points.unwrap_or(POINTS);
        if !(1..=POINTS_MAX).contains(&points) {
            return Err(Problem::invalid("points", format!("must be 1 to {POINTS_MAX}, not {points}")));
        }
        Ok(Span { from: self.from.map(|from| from.0), to: self.to.map(|to| to.0), points })
    }
}

/// Contacts of a whisker.
#[derive(Debug, Serialize, ToSchema)]
pub struct Contacts {
    /// Begin of the time range, inclusive; null if nothing is recorded.
    pub from: Option<Time>,
    /// End of the time range, exclusive.
    pub to: Option<Time>,
    /// Maximum number of points, as requested.
    pub points: u32,
    /// Number of contacts in the time range.
    #[schema(minimum = 0)]
    pub total: i64,
    /// Length of the averaging intervals in seconds; null if the items are single contacts.
    pub bucket_s: Option<f64>,
    /// Contacts or means in order of time; intervals without contacts are omitted.
    pub items: Vec<ContactPoint>,
}

/// A contact, or the mean of the contacts in an interval.
#[derive(Debug, Serialize, ToSchema)]
pub struct ContactPoint {
    /// Time of the contact, or begin of the interval, by the robot's clock.
    pub at: Time,
    /// Number of contacts.
    #[schema(minimum = 1)]
    pub contacts: i64,
    /// Contact ratio: position of the contact along the whisker, 0 at the base, 1 at the tip. It is the robot's, or its
    /// distance divided by the estimated length; null if the robot knew no place.
    pub ratio: Option<f64>,
    /// Distance from the base measured by the robot, mm; null if it measured none.
    pub distance_mm: Option<f64>,
    /// Deflection at the contact, mm.
    pub deflection_mm: f64,
    /// Axial strain of the gauge, m/m.
    pub strain: f64,
    /// Measured pressure, MPa.
    pub pressure_mpa: f64,
    /// Temperature at the gauge, °C; null if none was stored.
    pub temperature_c: Option<f64>,
    /// Strain per deflection, 1/mm; null without deflection.
    pub sensitivity_per_mm: Option<f64>,
    /// ln(measured / predicted sensitivity), mean of the contacts used for estimation; null if none was used.
    pub residual: Option<f64>,
    /// Estimated length after the contact, mm.
    pub length_mm: f64,
    /// Standard deviation of the estimated length, mm.
    pub length_sd_mm: f64,
}

impl From<&ContactMean> for ContactPoint {
    fn from(mean: &ContactMean) -> Self {
        Self {
            at: Time(mean.at_us),
            contacts: mean.contacts,
            ratio: mean.ratio,
            distance_mm: mean.distance_mm,
            deflection_mm: mean.deflection_mm,
            strain: mean.strain,
            pressure_mpa: mean.pressure_mpa,
            temperature_c: mean.temperature_c,
            sensitivity_per_mm: mean.sensitivity_per_mm,
            residual: mean.residual,
            length_mm: mean.length_mm,
            length_sd_mm: mean.length_sd_mm,
        }
    }
}

/// Estimated length of a whisker over time.
#[derive(Debug, Serialize, ToSchema)]
pub struct Lengths {
    /// Begin of the time range, inclusive; null if nothing is recorded.
    pub from: Option<Time>,
    /// End of the time range, exclusive.
    pub to: Option<Time>,
    /// Maximum number of points, as requested.
    pub points: u32,
    /// Number of contacts in the time range.
    #[schema(minimum = 0)]
    pub total: i64,
    /// Length of the averaging intervals in seconds; null if each item is a single contact.
    pub bucket_s: Option<f64>,
    /// Lengths in order of time; intervals without contacts are omitted.
    pub items: Vec<LengthPoint>,
}

/// Estimated length after a contact, or the mean over an interval.
#[derive(Debug, Serialize, ToSchema)]
pub struct LengthPoint {
    /// Time of the contact, or begin of the interval, by the robot's clock.
    pub at: Time,
    /// Estimated length, mm.
    pub length_mm: f64,
    /// Lower bound of its 95 % interval, mm.
    pub length_low_mm: f64,
    /// Upper bound of its 95 % interval, mm.
    pub length_high_mm: f64,
    /// Measured pressure, MPa.
    pub pressure_mpa: f64,
}

impl From<&ContactMean> for LengthPoint {
    fn from(mean: &ContactMean) -> Self {
        Self {
            at: Time(mean.at_us),
            length_mm: mean.length_mm,
            length_low_mm: mean.length_mm - Z95 * mean.length_sd_mm,
            length_high_mm: mean.length_mm + Z95 * mean.length_sd_mm,
            pressure_mpa: mean.pressure_mpa,
        }
    }
}

fn bucket_s(series: &Series) -> Option<f64> {
    series.bucket_us.map(|bucket_us| bucket_us as f64 / 1e6)
}

/// A whisker's contacts, single or averaged over equal intervals.
pub(super) async fn series(app: &App, at: &WhiskerPath, query: SpanQuery) -> Result<(Span, Series), Problem> {
    let span = query.span()?;
    Ok((span, app.store.contacts(at.whisker_id(&app.store).await?, span).await?))
}

/// A whisker's contacts: the newest ones, or those of a time range.
#[utoipa::path(
    get, path = "/v1/fleets/{fleet}/robots/{robot}/arrays/{array}/whiskers/{whisker}/contacts", tag = "whiskers",
    params(WhiskerPath, SpanQuery),
    responses((status = 200, description = "The contacts", body = Contacts))
)]
async fn get_contacts(
    State(app): State<App>,
    Path(at): Path<WhiskerPath>,
    Query(query): Query<SpanQuery>,
) -> Result<Json<Contacts>, Problem> {
    let (span, series) = series(&app, &at, query).await?;
    Ok(Json(Contacts {
        from: series.from,
        to: series.to,
        points: span.points,
        total: series.total,
        bucket_s: bucket_s(&series),
        items: series.items.iter().map(ContactPoint::from).collect(),
    }))
}

/// A whisker's estimated length and measured pressure over time.
#[utoipa::path(
    get, path = "/v1/fleets/{fleet}/robots/{robot}/arrays/{array}/whiskers/{whisker}/lengths", tag = "whiskers",
    params(WhiskerPath, SpanQuery),
    responses((status = 200, description = "The lengths", body = Lengths))
)]
async fn get_lengths(
    State(app): State<App>,
    Path(at): Path<WhiskerPath>,
    Query(query): Query<SpanQuery>,
) -> Result<Json<Lengths>, Problem> {
    let (span, series) = series(&app, &at, query).await?;
    Ok(Json(Lengths {
        from: series.from,
        to: series.to,
        points: span.points,
        total: series.total,
        bucket_s: bucket_s(&series),
        items: series.items.iter().map(LengthPoint::from).collect(),
    }))
}
