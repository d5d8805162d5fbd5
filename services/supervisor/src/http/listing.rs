//! Answers of lists: a page as JSON, or rows as CSV.

use axum::body::{Body, Bytes};
use axum::extract::{Extension, FromRequestParts};
use axum::http::request::Parts;
use axum::http::{HeaderName, HeaderValue, Uri, header};
use axum::response::{IntoResponse, Json, Response};
use futures_util::stream;
use serde::Serialize;
use tokio::time::Instant;
use utoipa::PartialSchema;
use vibrissa_store::list::{List, Listed, Rows, Selection};

use super::App;
use super::accept::preferred;
use super::access::{Caller, Credential};
use super::csv_rows::{Columns, MEDIA_TYPE};
use super::page::{LIMIT_MAX, Page};
use super::places::{TakenPlace, fleet_of};
use super::problem::{Kind, Problem};
use super::words::FormatWord;

/// Format and caller of a request for a list.
#[derive(Debug)]
pub struct Listing {
    is_csv: bool,
    /// Whether the request limits the number of rows.
    is_limited: bool,
    uri: Uri,
    caller: Caller,
    credential: Credential,
}

impl<S: Send + Sync> FromRequestParts<S> for Listing {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Problem> {
        let absent = |_| Problem::new(Kind::Internal, "the request bypassed authentication");
        let Extension(caller) = Extension::from_request_parts(parts, state).await.map_err(absent)?;
        let Extension(credential) = Extension::from_request_parts(parts, state).await.map_err(absent)?;
        // The query is checked by its own extractor.
        let parameter_of = |name: &str| parameter_of(&parts.uri, name);
        let is_csv = match parameter_of("format").as_deref() {
            Some(format) => format == FormatWord::Csv.to_string(),
            None => preferred(&parts.headers, &["application/json", "text/csv"]) == Some(1),
        };
        Ok(Self { is_csv, is_limited: parameter_of("limit").is_some(), uri: parts.uri.clone(), caller, credential })
    }
}

/// A parameter of a query.
fn parameter_of(uri: &Uri, name: &str) -> Option<String> {
    let mut pairs = url::form_urlencoded::parse(uri.query().unwrap_or_default().as_bytes());
    pairs.find(|(key, _)| key == name).map(|(_, value)| value.into_owned())
}

/// The same request for the page at a cursor.
fn next_page(uri: &Uri, cursor: &str) -> String {
    let pairs = url::form_urlencoded::parse(uri.query().unwrap_or_default().as_bytes());
    let mut query = url::form_urlencoded::Serializer::new(String::new());
    query.extend_pairs(pairs.filter(|(key, _)| key != "cursor")).append_pair("cursor", cursor);
    // Without the path, which may be another one behind a proxy: it is relative to the address of the request.
    format!("?{}", query.finish())
}

impl Listing {
    /// The selected rows of a list.
    ///
    /// # Errors
    /// The database cannot be read, or the caller has too many open streams.
    pub async fn answer<T>(self, app: &App, list: &'static List, selection: Selection) -> Result<Response, Problem>
    where
        T: Listed + Serialize + PartialSchema + 'static,
    {
        self.answer_with::<T, T>(app, list, selection, |row| row).await
    }

    /// The selected rows of a list, each turned into the row of the answer by a function.
    ///
    /// # Errors
    /// The database cannot be read, or the caller has too many open streams.
    pub async fn answer_with<R, T>(
        self,
        app: &App,
        list: &'static List,
        mut selection: Selection,
        change: impl Fn(R) -> T + Send + Sync + 'static,
    ) -> Result<Response, Problem>
    where
        R: Listed + 'static,
        T: Serialize + PartialSchema + 'static,
    {
        if self.is_csv && !self.is_limited {
            let place = app.streams.open(&self.caller.actor, fleet_of(&self.caller.scope, None))?;
            selection.limit = LIMIT_MAX;
            let first = app.store.list::<R>(list, &selection).await?;
            return Ok(self.streamed(Reading { app: app.clone(), list, selection, change, place }, first));
        }
        let rows = app.store.list::<R>(list, &selection).await?;
        let page = Page::of(rows, &selection).map(change);
        let link =
            page.next_cursor.as_deref().map(|cursor| format!("<{}>; rel=\"next\"", next_page(&self.uri, cursor)));
        let mut response = if self.is_csv {
            let mut text = header_row::<T>()?;
            for row in &page.items {
                text.extend(Columns::of::<T>().row(row).map_err(|problem| internal(&problem))?);
            }
            (self.headers(), text).into_response()
        } else {
            ([(header::VARY, "Accept")], Json(page)).into_response()
        };
        if let Some(Ok(link)) = link.map(|link| HeaderValue::from_str(&link)) {
            response.headers_mut().insert(header::LINK, link);
        }
        Ok(response)
    }

    /// All rows as CSV, read from the database page by page as the client takes them.
    fn streamed<R, T, F>(self, reading: Reading<F>, first: Rows<R>) -> Response
    where
        R: Listed + 'static,
        T: Serialize + PartialSchema + 'static,
        F: Fn(R) -> T + Send + Sync + 'static,
    {
        let headers = self.headers();
        let check_at = Instant::now() + reading.app.streams.options().check_every;
        let state = (reading, Some(first), self.credential, check_at, true);
        let chunks = stream::try_unfold(state, |(mut reading, page, credential, mut check_at, is_first)| async move {
            let Some(page) = page else { return Ok::<_, anyhow::Error>(None) };
            let mut text = if is_first { Columns::of::<T>().header()? } else { Vec::new() };
            let next = page.next.clone();
            for row in page.rows {
                text.extend(Columns::of::<T>().row(&(reading.change)(row))?);
            }
            let following = match next {
                None => None,
                Some(position) => {
                    reading.check(&credential, &mut check_at).await?;
                    reading.selection.after = Some(position);
                    Some(reading.app.store.list::<R>(reading.list, &reading.selection).await?)
                }
            };
            Ok(Some((Bytes::from(text), (reading, following, credential, check_at, false))))
        });
        (headers, Body::from_stream(chunks)).into_response()
    }

    fn headers(&self) -> [(HeaderName, HeaderValue); 3] {
        // `contacts/each` lists contacts.
        let name = self.uri.path().rsplit('/').find(|part| *part != "each").unwrap_or_default();
        let file = HeaderValue::from_str(&format!("attachment; filename=\"{name}.csv\""));
        [
            (header::CONTENT_TYPE, HeaderValue::from_static(MEDIA_TYPE)),
            (header::CONTENT_DISPOSITION, file.unwrap_or(HeaderValue::from_static("attachment"))),
            (header::VARY, HeaderValue::from_static("Accept")),
        ]
    }
}

fn header_row<T: PartialSchema>() -> Result<Vec<u8>, Problem> {
    Columns::of::<T>().header().map_err(|problem| internal(&problem))
}

fn internal(problem: &dyn std::fmt::Display) -> Problem {
    Problem::new(Kind::Internal, problem.to_string())
}

/// A list that is being read page by page.
struct Reading<F> {
    app: App,
    list: &'static List,
    selection: Selection,
    change: F,
    #[expect(dead_code, reason = "it frees its place when the stream ends")]
    place: TakenPlace,
}

impl<F> Reading<F> {
    /// Ends the stream if the service stops or the token is no longer valid. The client notices it: the last chunk is
    /// missing.
    async fn check(&self, credential: &Credential, check_at: &mut Instant) -> anyhow::Result<()> {
        anyhow::ensure!(!*self.app.stop.borrow(), "the service stops");
        if Instant::now() >= *check_at {
            let identity = self.app.access.identify(&self.app.store, credential).await;
            identity.map_err(|problem| anyhow::anyhow!("{}", problem.detail))?;
            *check_at = Instant::now() + self.app.streams.options().check_every;
        }
        Ok(())
    }
}
