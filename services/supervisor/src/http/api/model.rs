//! Predicted sensitivity of a whisker in its present state, beside the measured one.

use axum::extract::State;
use axum::response::Json;
use serde::Serialize;
use utoipa::ToSchema;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vibrissa_core::mechanics::{CONTACT_RATIOS, Model, Offset};
use vibrissa_core::units::{ContactRatio, Megapascal, Millimetre};

use super::paths::WhiskerPath;
use super::whiskers::whisker;
use crate::http::App;
use crate::http::extract::Path;
use crate::http::problem::Problem;
use vibrissa_store::lists::whiskers::Whisker;
use vibrissa_store::series::{ContactMean, Span};
use vibrissa_store::time::Time;

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(get_model))
}

/// Maximum number of contacts used for the measured sensitivity.
const CONTACTS: u32 = 2000;
/// A contact counts if its pressure is within this of the present one, in MPa: the dither of a regulator.
const PRESSURE_WITHIN_MPA: f64 = 0.005;
/// A contact counts if its estimated length is within this of the present one, in mm.
const LENGTH_WITHIN_MM: f64 = 1.0;
/// Maximum number of single contacts in the answer.
const RECENT: usize = 200;
/// Half the width of a contact-ratio bin.
const RATIO_WITHIN: f64 = 0.025;

/// Predicted and measured sensitivity of a whisker.
#[derive(Debug, Serialize, ToSchema)]
pub struct ModelOfWhisker {
    /// Name of its model (a calibration).
    pub model: String,
    /// Whether the answering supervisor has that model; if not, only measured values are given.
    pub is_known: bool,
    /// Pressure of the prediction in MPa: last measured, or the setpoint before the first contact.
    pub pressure_mpa: f64,
    /// Length of the prediction in mm: the estimated one.
    pub length_mm: f64,
    /// Nominal pressure of the factsheet, MPa.
    pub nominal_pressure_mpa: f64,
    /// Whole length of the factsheet, mm.
    pub whole_length_mm: f64,
    /// Offset of this whisker's sensitivity from its model, ln(own / model) at the contact ratio 0.725; null if its
    /// state is not stored.
    pub offset_log: Option<f64>,
    /// Slope of that offset over the contact ratio.
    pub offset_slope: Option<f64>,
    /// Sensitivities at the contact ratios 0.45, 0.50 .. 1.00.
    pub by_ratio: Vec<Sensitivity>,
    /// The newest contacts at the present length and pressure, oldest first, at most 200: those that the measured
    /// means count.
    pub recent: Vec<RecentContact>,
}

/// A contact at the present length and pressure.
#[derive(Debug, Serialize, ToSchema)]
pub struct RecentContact {
    /// Time of the contact, by the robot's clock.
    pub at: Time,
    /// Contact ratio: position along the whisker, 0 at the base, 1 at the tip.
    pub ratio: f64,
    /// Measured sensitivity, strain per mm of deflection.
    pub sensitivity_per_mm: f64,
}

/// Sensitivities at a contact ratio, in strain per mm of deflection: the model's by Eq. 31, averaged over the gauge's
/// grid.
#[derive(Debug, Serialize, ToSchema)]
pub struct Sensitivity {
    /// Contact ratio of the bin's centre.
    pub ratio: f64,
    /// Model at the present length and pressure; null where the contact would lie on the chamber.
    pub model_per_mm: Option<f64>,
    /// The same with the whisker's own offset.
    pub own_per_mm: Option<f64>,
    /// Model at the whole length and nominal pressure.
    pub whole_per_mm: Option<f64>,
    /// Mean measured at the present length and pressure; null without contacts in this bin.
    pub measured_per_mm: Option<f64>,
    /// Number of contacts in the bin, of the newest 2000.
    #[schema(minimum = 0)]
    pub measured_contacts: i64,
}

/// The model's sensitivity at a contact ratio.
pub(super) fn per_mm(model: &Model, ratio: ContactRatio, length_mm: f64, pressure_mpa: f64) -> Option<f64> {
    let (length, pressure) = (Millimetre::new(length_mm).ok()?, Megapascal::new(pressure_mpa).ok()?);
    model.check_length(length).ok()?;
    model.sensitivity_per_mm(ratio, length, &model.morphology(pressure)).ok()
}

/// The contacts at the present length and pressure that were used for estimation, oldest first.
fn present(contacts: &[ContactMean], whisker: &Whisker, pressure_mpa: f64) -> Vec<RecentContact> {
    let is_present = |one: &&ContactMean| {
        (one.pressure_mpa - pressure_mpa).abs() <= PRESSURE_WITHIN_MPA
            && (one.length_mm - whisker.length_mm).abs() <= LENGTH_WITHIN_MM
            && one.residual.is_some()
    };
    let contact = |one: &ContactMean| {
        Some(RecentContact { at: Time(one.at_us), ratio: one.ratio?, sensitivity_per_mm: one.sensitivity_per_mm? })
    };
    contacts.iter().filter(is_present).filter_map(contact).collect()
}

/// Mean measured sensitivity near a contact ratio, and the number of contacts.
fn felt(present: &[RecentContact], ratio: f64) -> (Option<f64>, i64) {
    let here = present.iter().filter(|one| (one.ratio - ratio).abs() < RATIO_WITHIN);
    let (sum, count) = here.fold((0.0, 0), |(sum, count), one| (sum + one.sensitivity_per_mm, count + 1));
    ((count > 0).then(|| sum / f64::from(count)), count.into())
}

/// Sensitivity of a whisker by contact ratio: predicted now and at its whole length, and measured, with the newest
/// contacts at the present length and pressure.
#[utoipa::path(
    get, path = "/v1/fleets/{fleet}/robots/{robot}/arrays/{array}/whiskers/{whisker}/model", tag = "whiskers",
    params(WhiskerPath),
    responses((status = 200, description = "The model", body = ModelOfWhisker))
)]
async fn get_model(State(app): State<App>, Path(at): Path<WhiskerPath>) -> Result<Json<ModelOfWhisker>, Problem> {
    let whisker = whisker(&app, &at).await?;
    let span = Span { from: None, to: None, points: CONTACTS };
    let contacts = app.store.contacts(at.whisker_id(&app.store).await?, span).await?.items;
    let stored = app.store.robot_state(at.fleet.as_str(), at.robot.as_str()).await?;
    let robot = stored.and_then(|stored| stored.robot().ok());
    let offset: Option<Offset> = robot.and_then(|robot| {
        let index = robot.find(at.array.as_str(), at.whisker)?;
        robot.whisker(index).map(|view| view.offset)
    });
    let params = app.params_of(&at.fleet, &at.robot).await?;
    let model = params.model(&whisker.model);
    let pressure_mpa = whisker.pressure_mpa.unwrap_or(whisker.setpoint_mpa);
    let mut recent = present(&contacts, &whisker, pressure_mpa);
    let by_ratio: Vec<Sensitivity> = CONTACT_RATIOS
        .into_iter()
        .filter_map(|a| {
            let ratio = ContactRatio::new(a).ok()?;
            let model_per_mm = model.and_then(|model| per_mm(model, ratio, whisker.length_mm, pressure_mpa));
            let (measured_per_mm, measured_contacts) = felt(&recent, a);
            Some(Sensitivity {
                ratio: a,
                model_per_mm,
                own_per_mm: model_per_mm.zip(offset).map(|(model, offset)| model * offset.at(ratio).exp()),
                whole_per_mm: model
                    .and_then(|model| per_mm(model, ratio, whisker.whole_length_mm, whisker.nominal_pressure_mpa)),
                measured_per_mm,
                measured_contacts,
            })
        })
        .collect();
    recent.drain(..recent.len().saturating_sub(RECENT));
    Ok(Json(ModelOfWhisker {
        is_known: model.is_some(),
        pressure_mpa,
        length_mm: whisker.length_mm,
        nominal_pressure_mpa: whisker.nominal_pressure_mpa,
        whole_length_mm: whisker.whole_length_mm,
        offset_log: offset.map(|offset| offset.level),
        offset_slope: offset.map(|offset| offset.slope),
        by_ratio,
        recent,
        model: whisker.model,
    }))
}
