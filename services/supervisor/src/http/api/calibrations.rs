//! Calibrations: upload of measurements, inspection of the fit, and activation in a fleet.

use axum::extract::{Extension, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Json, Response};
use serde::{Deserialize, Serialize};
use serde_json::json;
use utoipa::{IntoParams, ToSchema};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vibrissa_core::mechanics::{CalibrationRow as Measured, Fit, FitError, Geometry, Parameter, fit_calibration};
use vibrissa_core::units::{Megapascal, Millimetre, Strain};
use vibrissa_host::task;
use vibrissa_protocol::Name;

use crate::http::App;
use crate::http::access::{Caller, Scope};
use crate::http::asking::{Asker, Why, ask, number_of, reason};
use crate::http::extract::{Body, OptionalBody, Path, Query};
use crate::http::listing::Listing;
use crate::http::page::{Page, list_query};
use crate::http::problem::{Kind, Problem};
use crate::http::search::Search;
use vibrissa_edge::actions::RecordedKind;
use vibrissa_edge::calibration_file::{CalibrationFile, GeometrySection};
use vibrissa_edge::words::Word as _;
use vibrissa_store::actions::Asked;
use vibrissa_store::calibrations::NewCalibration;
use vibrissa_store::list::{Filter, Value};
use vibrissa_store::lists::actions::ActionRow;
use vibrissa_store::lists::calibrations::{
    CALIBRATION_TEXTS, CALIBRATIONS, CalibrationRow, CalibrationSort, CalibrationText,
};

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new()
        .routes(routes!(list_calibrations, upload_calibration))
        .routes(routes!(get_calibration))
        .routes(routes!(get_calibration_use))
        .routes(routes!(activate_calibration))
}

/// Maximum number of rows of measurements.
const ROWS_MAX: usize = 500;

/// Measurements of a whisker under pressure, without contact.
#[derive(Debug, Deserialize, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Measurements {
    /// Name of the whisker model, as in factsheets.
    #[schema(value_type = String, pattern = "^[A-Za-z0-9_-]{1,64}$")]
    pub model: Name,
    /// Young's modulus of the rubber in MPa. Strains alone determine only its product with k2.
    #[schema(exclusive_minimum = 0.0, maximum = 1000.0)]
    pub youngs_modulus_mpa: f64,
    /// Geometry of the whisker; the paper's (Table 1) if omitted.
    pub geometry: Option<GeometrySection>,
    /// Readings: at least four with a strain above zero pressure, at three or more pressures.
    #[schema(min_items = 1, max_items = 500)]
    pub rows: Vec<MeasuredRow>,
    /// Reason in free text, at most 1000 characters.
    #[schema(max_length = 1000)]
    pub reason: Option<String>,
}

/// One reading: a pressure with a strain, an elongation, or both.
#[derive(Debug, Deserialize, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct MeasuredRow {
    /// Pressure in the chamber, MPa.
    #[schema(minimum = 0.0, maximum = 1.0)]
    pub pressure_mpa: f64,
    /// Axial strain of the gauge, m/m.
    pub strain: Option<f64>,
    /// Elongation of the chamber at the tip, mm.
    pub elongation_mm: Option<f64>,
}

/// A fitted parameter with its uncertainty.
#[derive(Debug, Serialize, Deserialize, ToSchema)]
pub struct FittedNumber {
    /// Best estimate of the parameter.
    pub value: f64,
    /// Standard error, to first order.
    pub standard_error: f64,
    /// Lower bound of the 95 % interval.
    pub low: f64,
    /// Upper bound of the 95 % interval.
    pub high: f64,
}

impl From<&Parameter> for FittedNumber {
    fn from(number: &Parameter) -> Self {
        let Parameter { value, standard_error, low, high } = *number;
        Self { value, standard_error, low, high }
    }
}

/// Fit of the measurements: k2(Q) = c + a exp(-b Q), elongation = G Q / (k2(Q) E).
#[derive(Debug, Serialize, Deserialize, ToSchema)]
pub struct CalibrationFit {
    /// Limit of k2 at high pressure.
    pub c: FittedNumber,
    /// Excess of k2 at zero pressure.
    pub a: FittedNumber,
    /// Rate of softening per MPa.
    pub b_per_mpa: FittedNumber,
    /// Elongation gain G in mm; null if no elongation was measured: it then follows from the geometry (Eq. 24).
    pub elongation_gain_mm: Option<FittedNumber>,
    /// Scatter of single strain readings about the fit, as a ratio.
    pub strain_scatter: f64,
    /// Scatter of single elongations about the fit, as a ratio.
    pub elongation_scatter: Option<f64>,
    /// Residuals of the rows, in their order.
    pub residuals: Vec<RowFit>,
}

/// Residuals of a row.
#[derive(Debug, Serialize, Deserialize, ToSchema)]
pub struct RowFit {
    /// k2 of this row (Eq. 33); null without a strain above zero pressure.
    pub k2: Option<f64>,
    /// Residual of ln k2, measured - fitted.
    pub k2_residual: Option<f64>,
    /// Residual of ln elongation, measured - fitted.
    pub elongation_residual: Option<f64>,
}

impl From<&Fit> for CalibrationFit {
    fn from(fit: &Fit) -> Self {
        let row = |row: &vibrissa_core::mechanics::RowResidual| RowFit {
            k2: row.k2,
            k2_residual: row.k2_residual,
            elongation_residual: row.elongation_residual,
        };
        Self {
            c: (&fit.c).into(),
            a: (&fit.a).into(),
            b_per_mpa: (&fit.b_per_mpa).into(),
            elongation_gain_mm: fit.elongation_gain_mm.as_ref().map(Into::into),
            strain_scatter: fit.residual_sd,
            elongation_scatter: fit.elongation_residual_sd,
            residuals: fit.residuals.iter().map(row).collect(),
        }
    }
}

/// A calibration with its numbers, fit and measurements.
#[derive(Debug, Serialize, ToSchema)]
pub struct CalibrationDetail {
    /// Summary, as in the list.
    #[serde(flatten)]
    pub calibration: CalibrationRow,
    /// The numbers, as in a calibration file.
    pub numbers: CalibrationFile,
    /// Fit of the measurements.
    pub fit: CalibrationFit,
    /// Measurements, as they were uploaded.
    pub measurements: Measurements,
}

/// Checks uploaded measurements; each problem names its field.
fn measured(measurements: &Measurements) -> Result<(Geometry, Vec<Measured>), Problem> {
    if measurements.rows.len() > ROWS_MAX {
        return Err(Problem::invalid("rows", format!("must have at most {ROWS_MAX} rows")));
    }
    if !(measurements.youngs_modulus_mpa > 0.0 && measurements.youngs_modulus_mpa <= 1000.0) {
        return Err(Problem::invalid("youngs_modulus_mpa", "must be above 0 and at most 1000"));
    }
    let bad = |row: usize, field: &str, problem: &dyn std::fmt::Display| {
        Problem::invalid(format!("rows[{row}].{field}"), problem.to_string())
    };
    let mut rows = Vec::with_capacity(measurements.rows.len());
    for (at, row) in measurements.rows.iter().enumerate() {
        rows.push(Measured {
            pressure: Megapascal::new(row.pressure_mpa).map_err(|problem| bad(at, "pressure_mpa", &problem))?,
            axial_strain: row.strain.map(Strain::new).transpose().map_err(|problem| bad(at, "strain", &problem))?,
            elongation: row
                .elongation_mm
                .map(Millimetre::new)
                .transpose()
                .map_err(|problem| bad(at, "elongation_mm", &problem))?,
        });
    }
    Ok((measurements.geometry.map_or_else(Geometry::nguyen_2021, Into::into), rows))
}

fn fitted(measurements: &Measurements) -> Result<(Geometry, Vec<Measured>, Fit), Problem> {
    let (geometry, rows) = measured(measurements)?;
    let fit = fit_calibration(&geometry, measurements.youngs_modulus_mpa, &rows).map_err(|problem| {
        let field = match problem {
            FitError::StrainNotPositive { row, .. } => format!("rows[{}].strain", row - 1),
            FitError::ElongationNotPositive { row, .. } => format!("rows[{}].elongation_mm", row - 1),
            FitError::NothingAboveZeroPressure
            | FitError::TooFewStrains { .. }
            | FitError::TooFewPressures { .. }
            | FitError::OneElongation
            | FitError::ForceBelowZero { .. }
            | FitError::GaugeReversed
            | FitError::OnChamber { .. }
            | FitError::ModulusWithoutContacts
            | FitError::NoScatter { .. }
            | FitError::NotDetermined { .. }
            | FitError::Model(_) => "rows".to_owned(),
        };
        Problem::invalid(field, problem.to_string())
    })?;
    Ok((geometry, rows, fit))
}

/// Upload measurements. They are fitted and stored as the model's next version, which is not active in any fleet yet.
#[utoipa::path(
    post, path = "/v1/calibrations", tag = "calibrations",
    params(("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
    request_body = Measurements,
    responses((status = 201, description = "The calibration is stored", body = CalibrationDetail)),
    extensions(("x-required-role" = json!("ENGINEER")))
)]
async fn upload_calibration(
    State(app): State<App>,
    asker: Asker,
    Body(measurements): Body<Measurements>,
) -> Result<Response, Problem> {
    let (why, scope) = (reason(measurements.reason.clone())?, asker.caller.scope.clone());
    let worked = task::blocking(move || fitted(&measurements).map(|(geometry, _, fit)| (measurements, geometry, fit)));
    let (measurements, geometry, fit) =
        worked.await.map_err(|problem| Problem::new(Kind::Internal, problem.to_string()))??;
    let file = CalibrationFile::new(&measurements.model, &geometry, &fit.calibration);
    let new = NewCalibration {
        model: measurements.model.to_string(),
        measurements: text(&measurements)?,
        fit: text(&CalibrationFit::from(&fit))?,
        calibration: text(&file)?,
    };
    let action = asker.action(
        RecordedKind::CalibrationUpload.word(),
        &json!({ "model": measurements.model, "calibration": file }),
        why,
    );
    let (asked, calibration_id) = app.store.add_calibration(&new, &action).await?;
    let id = match (asked, calibration_id) {
        (_, Some(id)) => id,
        // The calibration that was stored under the same key before.
        (Asked::Again(kept), None) => kept_by(&app, &new.model, &kept.actor, kept.asked_us).await?,
        (asked, None) => number_of(asked)?,
    };
    let place = [(header::LOCATION, format!("/v1/calibrations/{id}"))];
    Ok((StatusCode::CREATED, place, Json(detail(&app, &scope, id).await?)).into_response())
}

fn text(value: &impl Serialize) -> Result<String, Problem> {
    serde_json::to_string(value).map_err(|problem| Problem::new(Kind::Internal, problem.to_string()))
}

async fn kept_by(app: &App, model: &str, actor: &str, uploaded_us: i64) -> Result<i64, Problem> {
    let filters = vec![
        Filter::Is("model", Value::Text(model.to_owned())),
        Filter::Is("uploaded_by", Value::Text(actor.to_owned())),
        Filter::Is("uploaded_at", Value::Whole(uploaded_us)),
    ];
    let found: Option<CalibrationRow> = app.store.first(&CALIBRATIONS, filters).await?;
    found.map(|row| row.calibration_id).ok_or_else(|| Problem::not_found("calibration under that key"))
}

/// Path parameters of a calibration.
#[derive(Debug, Clone, Deserialize, IntoParams)]
#[into_params(parameter_in = Path)]
pub struct CalibrationPath {
    /// Number of the calibration.
    #[param(minimum = 0)]
    pub calibration_id: i64,
}

async fn texts(app: &App, id: i64) -> Result<CalibrationText, Problem> {
    let found = app.store.first(&CALIBRATION_TEXTS, vec![Filter::Is("calibration_id", Value::Whole(id))]).await?;
    found.ok_or_else(|| Problem::not_found(format_args!("calibration {id}")))
}

fn read<T: serde::de::DeserializeOwned>(text: &str) -> Result<T, Problem> {
    serde_json::from_str(text)
        .map_err(|problem| Problem::new(Kind::Internal, format!("a stored calibration: {problem}")))
}

/// Removes fleets outside the caller's scope from the list of fleets in which the calibration is active.
fn seen_by(scope: &Scope, mut row: CalibrationRow) -> CalibrationRow {
    let seen = row.active_in.iter().flat_map(|fleets| fleets.split(',')).filter(|fleet| scope.covers(fleet));
    row.active_in = Some(seen.collect::<Vec<_>>().join(",")).filter(|fleets| !fleets.is_empty());
    row
}

async fn detail(app: &App, scope: &Scope, id: i64) -> Result<CalibrationDetail, Problem> {
    let row: Option<CalibrationRow> =
        app.store.first(&CALIBRATIONS, vec![Filter::Is("calibration_id", Value::Whole(id))]).await?;
    let calibration = seen_by(scope, row.ok_or_else(|| Problem::not_found(format_args!("calibration {id}")))?);
    let texts = texts(app, id).await?;
    Ok(CalibrationDetail {
        calibration,
        numbers: read(&texts.calibration)?,
        fit: read(&texts.fit)?,
        measurements: read(&texts.measurements)?,
    })
}

list_query! {
    /// Filters for the list of calibrations.
    pub struct CalibrationsQuery by CalibrationSort {
        /// Name of the whisker model.
        #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9_-]{1,64}$")]
        pub model: Option<Name>,
        /// Text to look for in the names of models and of those who uploaded, in upper or lower case.
        #[param(value_type = Option<String>, min_length = 1, max_length = 100, pattern = "^[^\\x00]+$")]
        pub q: Option<Search>,
    }
}

/// Uploaded calibrations, each with the fleets in which it is active.
#[utoipa::path(
    get, path = "/v1/calibrations", tag = "calibrations", params(CalibrationsQuery),
    responses((status = 200, description = "A page of calibrations", body = Page<CalibrationRow>))
)]
async fn list_calibrations(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    listing: Listing,
    Query(query): Query<CalibrationsQuery>,
) -> Result<Response, Problem> {
    let mut selection = query.page()?;
    selection.is("model", query.model);
    selection.contains(&["model", "uploaded_by"], query.q);
    listing.answer_with(&app, &CALIBRATIONS, selection, move |row| seen_by(&caller.scope, row)).await
}

/// One calibration with its numbers, fit and measurements.
#[utoipa::path(
    get, path = "/v1/calibrations/{calibration_id}", tag = "calibrations", params(CalibrationPath),
    responses((status = 200, description = "The calibration", body = CalibrationDetail))
)]
async fn get_calibration(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    Path(at): Path<CalibrationPath>,
) -> Result<Json<CalibrationDetail>, Problem> {
    detail(&app, &caller.scope, at.calibration_id).await.map(Json)
}

/// Use of a whisker model in a fleet.
#[derive(Debug, Serialize, ToSchema)]
pub struct CalibrationUse {
    /// Name of the fleet.
    pub fleet: String,
    /// Whether this calibration of the model is active in the fleet.
    pub is_active: bool,
    /// Number of robots with whiskers of the model.
    #[schema(minimum = 0)]
    pub robots: i64,
    /// Number of whiskers of the model that are on robots now.
    #[schema(minimum = 0)]
    pub whiskers: i64,
}

/// Fleets in which a calibration or its model is used.
#[derive(Debug, Serialize, ToSchema)]
pub struct CalibrationUses {
    /// The fleets by name.
    pub items: Vec<CalibrationUse>,
}

/// Fleets that have whiskers of the calibration's model, or in which the calibration is active.
#[utoipa::path(
    get, path = "/v1/calibrations/{calibration_id}/use", tag = "calibrations", params(CalibrationPath),
    responses((status = 200, description = "The fleets", body = CalibrationUses))
)]
async fn get_calibration_use(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    Path(at): Path<CalibrationPath>,
) -> Result<Json<CalibrationUses>, Problem> {
    let row: Option<CalibrationRow> =
        app.store.first(&CALIBRATIONS, vec![Filter::Is("calibration_id", Value::Whole(at.calibration_id))]).await?;
    let row = row.ok_or_else(|| Problem::not_found(format_args!("calibration {}", at.calibration_id)))?;
    let row = seen_by(&caller.scope, row);
    let filters: Vec<Filter> = caller.scope.filter("r.fleet").into_iter().collect();
    let known = app.store.model_use(&filters, &row.model).await?;
    let active: Vec<&str> = row.active_in.iter().flat_map(|fleets| fleets.split(',')).collect();
    let without = active.iter().filter(|fleet| !known.iter().any(|one| one.fleet == **fleet));
    let mut items: Vec<CalibrationUse> = without
        .map(|fleet| CalibrationUse { fleet: (*fleet).to_owned(), is_active: true, robots: 0, whiskers: 0 })
        .collect();
    items.extend(known.iter().map(|one| CalibrationUse {
        fleet: one.fleet.clone(),
        is_active: active.contains(&one.fleet.as_str()),
        robots: one.robots,
        whiskers: one.whiskers,
    }));
    items.sort_by(|one, other| one.fleet.cmp(&other.fleet));
    Ok(Json(CalibrationUses { items }))
}

/// The numbers of a calibration.
pub(super) async fn numbers_of(app: &App, calibration_id: i64) -> Result<CalibrationFile, Problem> {
    read(&texts(app, calibration_id).await?.calibration)
}

/// Path parameters of an activation.
#[derive(Debug, Clone, Deserialize, IntoParams)]
#[into_params(parameter_in = Path)]
pub struct ActivationPath {
    /// Name of the fleet.
    #[param(value_type = String, pattern = "^[A-Za-z0-9_-]{1,64}$")]
    pub fleet: Name,
    /// Number of the calibration.
    #[param(minimum = 0)]
    pub calibration_id: i64,
}

/// Activate a calibration in a fleet.
///
/// The baselines of the model's whiskers are then relearned at their currently estimated lengths.
#[utoipa::path(
    post, path = "/v1/fleets/{fleet}/calibrations/{calibration_id}/activate", tag = "calibrations",
    params(ActivationPath, ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
    request_body = Option<Why>,
    responses(
        (status = 200, description = "The calibration is active", body = ActionRow),
        (status = 202, description = "Pending; poll the action", body = ActionRow)
    ),
    extensions(("x-required-role" = json!("ENGINEER")))
)]
async fn activate_calibration(
    State(app): State<App>,
    Path(at): Path<ActivationPath>,
    asker: Asker,
    OptionalBody(why): OptionalBody<Why>,
) -> Result<Response, Problem> {
    let numbers = numbers_of(&app, at.calibration_id).await?;
    if !app.store.has_fleet(at.fleet.as_str()).await? {
        return Err(Problem::not_found(format_args!("fleet {}", at.fleet)));
    }
    let parameters = json!({ "calibration_id": at.calibration_id, "calibration": numbers });
    let mut action = asker.action(RecordedKind::Calibration.word(), &parameters, reason(why.reason)?);
    action.fleet = Some(at.fleet.to_string());
    ask(&app, &at.fleet, &action).await
}

#[cfg(test)]
mod tests {
    use super::*;
    use vibrissa_store::time::Time;

    #[test]
    fn regress_only_the_callers_fleets_are_named() {
        let row = |active_in: Option<&str>| CalibrationRow {
            calibration_id: 1,
            model: "m".to_owned(),
            version: 1,
            uploaded_at: Time(0),
            uploaded_by: "local".to_owned(),
            active_in: active_in.map(ToOwned::to_owned),
        };
        let one = Scope::of(["b".parse().unwrap()]);
        let seen = |scope: &Scope, fleets| seen_by(scope, row(fleets)).active_in;
        assert_eq!(seen(&one, Some("a,b,c")).as_deref(), Some("b"));
        assert_eq!(seen(&one, Some("a,c")), None);
        assert_eq!(seen(&Scope::All, Some("a,c")).as_deref(), Some("a,c"));
        assert_eq!(seen(&Scope::All, None), None);
    }
}
