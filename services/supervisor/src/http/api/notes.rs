//! Notes on robots.

use axum::extract::State;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Json, Response};
use serde::Deserialize;
use serde_json::json;
use utoipa::{IntoParams, ToSchema};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vibrissa_edge::actions::RecordedKind;
use vibrissa_edge::words::Word as _;
use vibrissa_protocol::Name;
use vibrissa_store::list::{Filter, Value};
use vibrissa_store::lists::actions::ActionRow;
use vibrissa_store::lists::notes::{NOTES, Note, NoteSort};
use vibrissa_store::notes::{NOTES_MAX, NoteChange, Noted};

use super::paths::RobotPath;
use crate::http::App;
use crate::http::asking::{Asker, Why, answered, number_of, reason};
use crate::http::extract::{Body, OptionalBody, Path, Query};
use crate::http::listing::Listing;
use crate::http::page::{Page, list_query};
use crate::http::problem::{Kind, Problem};

/// Most characters of a note.
const TEXT_CHARS_MAX: usize = 2000;

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(list_notes, add_note)).routes(routes!(get_note, remove_note))
}

/// Path parameters of a note.
#[derive(Debug, Clone, Deserialize, IntoParams)]
#[into_params(parameter_in = Path)]
pub struct NotePath {
    /// Name of the fleet.
    #[param(value_type = String, pattern = "^[A-Za-z0-9_-]{1,64}$")]
    pub fleet: Name,
    /// Name of the robot.
    #[param(value_type = String, pattern = "^[A-Za-z0-9_-]{1,64}$")]
    pub robot: Name,
    /// Number of the note.
    #[param(minimum = 0)]
    pub note_id: i64,
}

impl NotePath {
    fn on_robot(&self) -> RobotPath {
        RobotPath { fleet: self.fleet.clone(), robot: self.robot.clone() }
    }
}

/// A new note.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = NewNote)]
pub struct NoteBody {
    /// Plain text: 1 to 2000 characters without control characters except line breaks and tabs.
    #[schema(min_length = 1, max_length = 2000)]
    pub text: String,
}

impl NoteBody {
    /// The text without spaces at its ends, and with a line feed at the end of each line.
    fn text(&self) -> Result<String, Problem> {
        let text = self.text.replace("\r\n", "\n").trim().to_owned();
        if !(1..=TEXT_CHARS_MAX).contains(&text.chars().count()) {
            let problem = format!("must have 1 to {TEXT_CHARS_MAX} characters, without spaces at its ends");
            return Err(Problem::invalid("text", problem));
        }
        if text.contains(|letter: char| letter.is_control() && !matches!(letter, '\n' | '\t')) {
            return Err(Problem::invalid("text", "must not contain control characters except line breaks and tabs"));
        }
        Ok(text)
    }
}

list_query! {
    /// Parameters of the list of notes.
    pub struct NotesQuery by NoteSort {}
}

/// The notes on a robot, the newest first.
#[utoipa::path(
    get, path = "/v1/fleets/{fleet}/robots/{robot}/notes", tag = "robots", params(RobotPath, NotesQuery),
    responses((status = 200, description = "A page of notes", body = Page<Note>))
)]
async fn list_notes(
    State(app): State<App>,
    Path(at): Path<RobotPath>,
    listing: Listing,
    Query(query): Query<NotesQuery>,
) -> Result<Response, Problem> {
    if !app.store.has_robot(at.fleet.as_str(), at.robot.as_str()).await? {
        return Err(at.unknown(&app.store).await);
    }
    let mut selection = query.page()?;
    selection.filters.extend(at.filters());
    listing.answer::<Note>(&app, &NOTES, selection).await
}

/// Add a note to a robot. A robot has at most 100 notes.
#[utoipa::path(
    post, path = "/v1/fleets/{fleet}/robots/{robot}/notes", tag = "robots",
    params(RobotPath, ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
    request_body = NoteBody,
    responses((status = 201, description = "The note is added", body = Note)),
    extensions(("x-required-role" = json!("OPERATOR")))
)]
async fn add_note(
    State(app): State<App>,
    Path(at): Path<RobotPath>,
    asker: Asker,
    Body(body): Body<NoteBody>,
) -> Result<Response, Problem> {
    let text = body.text()?;
    let parameters = json!({ "text": text });
    let action_id = change(&app, &at, asker, (RecordedKind::NoteAdd, NoteChange::Add(&text), parameters, None)).await?;
    let own = Filter::Is("action_id", Value::Whole(action_id));
    let note: Option<Note> = app.store.first(&NOTES, vec![own]).await?;
    let note = note.ok_or_else(|| Problem::unknown("the note was removed meanwhile"))?;
    let place = format!("/v1/fleets/{}/robots/{}/notes/{}", at.fleet, at.robot, note.note_id);
    Ok((StatusCode::CREATED, [(header::LOCATION, place)], Json(note)).into_response())
}

/// One note on a robot.
#[utoipa::path(
    get, path = "/v1/fleets/{fleet}/robots/{robot}/notes/{note_id}", tag = "robots", params(NotePath),
    responses((status = 200, description = "The note", body = Note))
)]
async fn get_note(State(app): State<App>, Path(at): Path<NotePath>) -> Result<Json<Note>, Problem> {
    let mut filters = at.on_robot().filters();
    filters.push(Filter::Is("note_id", Value::Whole(at.note_id)));
    let found = app.store.first(&NOTES, filters).await?;
    found.map(Json).ok_or_else(|| no_note(&at.robot, at.note_id))
}

/// Remove a note from a robot. The audit log keeps its text.
#[utoipa::path(
    delete, path = "/v1/fleets/{fleet}/robots/{robot}/notes/{note_id}", tag = "robots",
    params(NotePath, ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,128}$")),
    request_body = Option<Why>,
    responses((status = 200, description = "The note is removed", body = ActionRow)),
    extensions(("x-required-role" = json!("OPERATOR")))
)]
async fn remove_note(
    State(app): State<App>,
    Path(at): Path<NotePath>,
    asker: Asker,
    OptionalBody(why): OptionalBody<Why>,
) -> Result<Response, Problem> {
    let (removal, parameters) = (NoteChange::Remove(at.note_id), json!({ "note_id": at.note_id }));
    let what = (RecordedKind::NoteRemove, removal, parameters, why.reason);
    let action_id = change(&app, &at.on_robot(), asker, what).await?;
    answered(&app, action_id, StatusCode::OK).await
}

/// Changes the notes on a robot; the number of the action.
async fn change(
    app: &App,
    at: &RobotPath,
    asker: Asker,
    (kind, change, parameters, why): (RecordedKind, NoteChange<'_>, serde_json::Value, Option<String>),
) -> Result<i64, Problem> {
    let mut action = asker.action(kind.word(), &parameters, reason(why)?);
    action.fleet = Some(at.fleet.to_string());
    action.robot = Some(at.robot.to_string());
    match (app.store.change_notes((at.fleet.as_str(), at.robot.as_str()), change, &action).await?, change) {
        (Noted::Done(asked), _) => {
            let action_id = number_of(*asked)?;
            app.action_notifier.changed();
            Ok(action_id)
        }
        (Noted::NoNote, NoteChange::Remove(note_id)) => Err(no_note(&at.robot, note_id)),
        (Noted::NoRobot | Noted::NoNote, _) => Err(at.unknown(&app.store).await),
        (Noted::TooMany, _) => Err(Problem::new(
            Kind::Refused,
            format!("the robot {} has {NOTES_MAX} notes, which is the limit: remove one first", at.robot),
        )),
    }
}

fn no_note(robot: &Name, note_id: i64) -> Problem {
    Problem::unknown(format!("the robot {robot} has no note {note_id}"))
}
