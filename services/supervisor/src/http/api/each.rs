//! Each contact of a whisker, and each length estimated from one, page by page.

use axum::extract::State;
use axum::response::Response;
use serde::Serialize;
use utoipa::ToSchema;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::contacts::Z95;
use super::paths::WhiskerPath;
use crate::http::App;
use crate::http::extract::{Path, Query};
use crate::http::listing::Listing;
use crate::http::moment::{Moment, between};
use crate::http::page::{Page, list_query};
use crate::http::problem::Problem;
use vibrissa_store::list::{Filter, Selection, Value};
use vibrissa_store::lists::contacts::{CONTACTS, Contact, ContactSort};
use vibrissa_store::time::Time;

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(list_contacts)).routes(routes!(list_lengths))
}

list_query! {
    /// Filters for single contacts.
    pub struct EachQuery by ContactSort {
        /// Earliest time, inclusive, by the robot's clock.
        #[param(value_type = Option<String>, format = DateTime)]
        pub from: Option<Moment>,
        /// Latest time, exclusive.
        #[param(value_type = Option<String>, format = DateTime)]
        pub to: Option<Moment>,
    }
}

/// Estimated length of a whisker after a contact.
#[derive(Debug, Serialize, ToSchema)]
pub struct Length {
    /// Time of the contact, by the robot's clock.
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

impl From<Contact> for Length {
    fn from(contact: Contact) -> Self {
        let Contact { at, length_mm, length_sd_mm, pressure_mpa, .. } = contact;
        let half = Z95 * length_sd_mm;
        Self { at, length_mm, length_low_mm: length_mm - half, length_high_mm: length_mm + half, pressure_mpa }
    }
}

async fn selection(app: &App, at: &WhiskerPath, query: &EachQuery) -> Result<Selection, Problem> {
    let mut selection = query.page()?;
    selection.filters = between("t_us", query.from, query.to).collect();
    selection.filters.push(Filter::Is("whisker_id", Value::Whole(at.whisker_id(&app.store).await?)));
    Ok(selection)
}

/// Each contact of a whisker, the newest first.
#[utoipa::path(
    get, path = "/v1/fleets/{fleet}/robots/{robot}/arrays/{array}/whiskers/{whisker}/contacts/each", tag = "whiskers",
    params(WhiskerPath, EachQuery),
    responses((status = 200, description = "A page of contacts", body = Page<Contact>))
)]
async fn list_contacts(
    State(app): State<App>,
    Path(at): Path<WhiskerPath>,
    listing: Listing,
    Query(query): Query<EachQuery>,
) -> Result<Response, Problem> {
    let selection = selection(&app, &at, &query).await?;
    listing.answer::<Contact>(&app, &CONTACTS, selection).await
}

/// The length of a whisker after each of its contacts, the newest first.
#[utoipa::path(
    get, path = "/v1/fleets/{fleet}/robots/{robot}/arrays/{array}/whiskers/{whisker}/lengths/each", tag = "whiskers",
    params(WhiskerPath, EachQuery),
    responses((status = 200, description = "A page of lengths", body = Page<Length>))
)]
async fn list_lengths(
    State(app): State<App>,
    Path(at): Path<WhiskerPath>,
    listing: Listing,
    Query(query): Query<EachQuery>,
) -> Result<Response, Problem> {
    let selection = selection(&app, &at, &query).await?;
    listing.answer_with::<Contact, Length>(&app, &CONTACTS, selection, Length::from).await
}
