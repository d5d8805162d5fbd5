//! Why a whisker learns, or does not: the use of its newest contacts, with remedies.

use axum::extract::State;
use axum::response::Json;
use serde::Serialize;
use utoipa::ToSchema;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vibrissa_core::robot::effect::ContactUse;
use vibrissa_edge::contact_uses::{remedy, segmenter_remedy};
use vibrissa_edge::words::{Words, named};
use vibrissa_protocol::Segmenter;
use vibrissa_store::contact_uses::ContactsOfUse;
use vibrissa_store::time::Time;

use super::paths::WhiskerPath;
use crate::http::App;
use crate::http::extract::Path;
use crate::http::problem::Problem;

/// Number of contacts that are counted.
const NEWEST: u32 = 200;

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(get_contact_uses))
}

/// Uses of a whisker's newest contacts, and the state of its segmenter.
#[derive(Debug, Serialize, ToSchema)]
pub struct ContactUses {
    /// Number of contacts that were counted, about 200 at most; 0 if none is recorded, or if contacts are not kept.
    #[schema(minimum = 0)]
    pub contacts: i64,
    /// Number of these that were used, or learned from.
    #[schema(minimum = 0)]
    pub contacts_used: i64,
    /// The uses, the most frequent first.
    pub items: Vec<ContactsByUse>,
    /// Finding of contacts in samples of strain; null if the robot does not say.
    pub segmenter: Option<SegmenterState>,
}

/// How far contacts can be relied on that a robot finds in samples of strain.
#[derive(Debug, Serialize, ToSchema)]
pub struct SegmenterState {
    /// State by the newest status, such as `READY` or `LEARNING`.
    pub state: String,
    /// The state in a few words.
    pub meaning: Option<&'static str>,
    /// Advice if contacts are not found; null if they are.
    pub remedy: Option<&'static str>,
}

impl From<String> for SegmenterState {
    fn from(state: String) -> Self {
        let known: Option<Segmenter> = named(&state);
        let (meaning, remedy) = (known.and_then(Words::label), known.and_then(segmenter_remedy));
        Self { state, meaning, remedy }
    }
}

/// Contacts of one use.
#[derive(Debug, Serialize, ToSchema)]
pub struct ContactsByUse {
    /// Use of the contacts; all words but `LEARNING` and `USED` say why they were not used.
    pub used: String,
    /// Number of contacts.
    #[schema(minimum = 1)]
    pub contacts: i64,
    /// Time of the newest one, by the robot's clock.
    pub newest_at: Time,
    /// The use in a few words.
    pub meaning: Option<&'static str>,
    /// Advice if the contacts were not used; null if they were.
    pub remedy: Option<&'static str>,
}

impl From<ContactsOfUse> for ContactsByUse {
    fn from(row: ContactsOfUse) -> Self {
        let used: Option<ContactUse> = named(&row.used);
        Self {
            used: row.used,
            contacts: row.contacts,
            newest_at: row.newest_at,
            meaning: used.and_then(Words::label),
            remedy: used.and_then(remedy),
        }
    }
}

/// Use of a whisker's newest contacts: how many were used, why the others were not or are not found, and what to do.
#[utoipa::path(
    get, path = "/v1/fleets/{fleet}/robots/{robot}/arrays/{array}/whiskers/{whisker}/contact-uses", tag = "whiskers",
    params(WhiskerPath),
    responses((status = 200, description = "The uses", body = ContactUses))
)]
async fn get_contact_uses(State(app): State<App>, Path(at): Path<WhiskerPath>) -> Result<Json<ContactUses>, Problem> {
    let whisker_id = at.whisker_id(&app.store).await?;
    let uses = app.store.contact_uses(whisker_id, NEWEST).await?;
    let items: Vec<ContactsByUse> = uses.into_iter().map(ContactsByUse::from).collect();
    let used = items.iter().filter(|one| one.remedy.is_none()).map(|one| one.contacts).sum();
    let contacts = items.iter().map(|one| one.contacts).sum();
    let segmenter = app.store.segmenter(whisker_id).await?.map(SegmenterState::from);
    Ok(Json(ContactUses { contacts, contacts_used: used, items, segmenter }))
}
