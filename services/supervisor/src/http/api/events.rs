//! Server-sent events: changes as they happen.

use std::convert::Infallible;

use axum::extract::{Extension, State};
use axum::http::{HeaderMap, HeaderName, header};
use axum::response::IntoResponse;
use axum::response::sse::{Event, KeepAlive, Sse};
use futures_util::stream::{self, StreamExt as _};
use tokio::sync::watch;
use tokio::time::{Duration, Instant, timeout};
use utoipa::IntoParams;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use crate::events::{Event as LogEvent, published};
use crate::http::App;
use crate::http::access::{Caller, Credential};
use crate::http::extract::Query;
use crate::http::fleets::FleetFilter;
use crate::http::places::{TakenPlace, fleet_of};
use crate::http::problem::{Kind, Problem};
use vibrissa_store::events::{Position, StoredEvent};

pub(super) fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(follow_events))
}

/// Interval at which the database is polled for changes written by other supervisors.
const POLL: Duration = Duration::from_secs(1);
/// Longest time that a stream stays open. Clients reconnect, and an expired token is then refused.
const LIFETIME: Duration = Duration::from_secs(300);
/// Interval of comment lines, which keep the connection open through proxies.
const KEEP_ALIVE: Duration = Duration::from_secs(15);

/// Length of the comment at the begin of a stream, bytes. It tells the client at once that the stream is open, and fills the
/// first buffer of proxies and browsers that wait for one.
const PADDING_BYTES: usize = 2048;
/// Headers of a stream. The first makes nginx pass each event on at once. The others keep proxies from compression, which would
/// hold events back: Caddy ignores `no-transform`, but compresses no answer that names a coding, be it `identity`.
const UNBUFFERED: [(HeaderName, &str); 3] = [
    (HeaderName::from_static("x-accel-buffering"), "no"),
    (header::CACHE_CONTROL, "no-store, no-transform"),
    (header::CONTENT_ENCODING, "identity"),
];

/// Filters for events.
#[derive(Debug, serde::Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct EventsQuery {
    /// Fleets: names or patterns such as `hall-*`, separated by commas.
    pub fleet: Option<FleetFilter>,
}

/// Client of an event stream.
struct Follower {
    app: App,
    caller: Caller,
    /// Credential for identifying the caller again.
    credential: Credential,
    /// Time of the next identification.
    check_at: Instant,
    fleet: Option<FleetFilter>,
    position: Position,
    /// Whether the client's last event is no longer stored, so that it may have missed others.
    is_reset_due: bool,
    /// Events with their positions; `None` for one that cannot be read.
    waiting: std::collections::VecDeque<(Position, Option<StoredEvent>)>,
    changed: watch::Receiver<u64>,
    stop: watch::Receiver<bool>,
    /// Time at which the stream ends and the client must reconnect.
    ends: Instant,
    _place: TakenPlace,
}

/// Whether a stream may go on.
enum Standing {
    /// The caller may still see these events.
    Good,
    /// The token is no longer valid.
    Ended,
    /// The database or the identity provider does not answer.
    Unknown,
}

/// Changes from now on, or after `Last-Event-ID`.
///
/// Events are `change` (its data names what changed; read the object itself from the API) and `reset` (the ID is older
/// than the stored changes: read everything again). The stream ends after five minutes: reconnect with `Last-Event-ID`.
/// It ends within 30 s after its token becomes invalid. A caller may have ten streams at a time, the callers of
/// a fleet a hundred, a service four hundred; beyond that the answer is 429.
#[utoipa::path(
    get, path = "/v1/events", tag = "events",
    params(EventsQuery, ("Last-Event-ID" = Option<String>, Header, description = "ID of the last event received", pattern = "^[0-9]{1,18}\\.[0-9]{1,18}$")),
    responses((status = 200, description = "A stream of events; the data of each is an Event", body = LogEvent, content_type = "text/event-stream"))
)]
async fn follow_events(
    State(app): State<App>,
    Extension(caller): Extension<Caller>,
    Extension(credential): Extension<Credential>,
    Query(query): Query<EventsQuery>,
    headers: HeaderMap,
) -> Result<impl IntoResponse, Problem> {
    let fleet = fleet_of(&caller.scope, query.fleet.as_ref());
    let place = app.streams.open(&caller.actor, fleet)?;
    let (changed, stop) = (app.action_notifier.changes(), app.stop.clone());
    let ends = app.store.log_ends().await?;
    let end = ends.map_or(Position::default(), |(_, end)| end);
    let last_id = headers.get("last-event-id").map(|last_id| last_id.to_str().unwrap_or_default().parse::<Position>());
    let (position, is_reset_due) = match last_id {
        None => (end, false),
        Some(Err(_)) => return Err(Problem::invalid("Last-Event-ID", "is not an event ID: two numbers with a dot")),
        // The last event must still be stored, or others may be missing too. A position of another database may lie
        // ahead.
        Some(Ok(position)) if ends.is_some_and(|(first, last)| (first..=last).contains(&position)) => (position, false),
        Some(Ok(_)) => (end, true),
    };
    let now = Instant::now();
    let (check_at, ends) = (now + app.streams.options().check_every, now + LIFETIME);
    let follower = Follower {
        app,
        caller,
        credential,
        check_at,
        fleet: query.fleet,
        position,
        is_reset_due,
        waiting: std::collections::VecDeque::new(),
        changed,
        stop,
        ends,
        _place: place,
    };
    let events = stream::unfold(follower, |mut follower| async move {
        let event = follower.next().await?;
        Some((Ok(event), follower))
    });
    let padding = stream::once(async { Ok::<_, Infallible>(Event::default().comment(" ".repeat(PADDING_BYTES))) });
    let answer = Sse::new(padding.chain(events)).keep_alive(KeepAlive::new().interval(KEEP_ALIVE));
    Ok((UNBUFFERED, answer))
}

impl Follower {
    /// The next event; `None` once the service stops, or the caller may no longer see events.
    async fn next(&mut self) -> Option<Event> {
        if std::mem::take(&mut self.is_reset_due) {
            return Some(Event::default().event("reset").id(self.position.to_string()).data("{}"));
        }
        loop {
            if *self.stop.borrow() || Instant::now() >= self.ends {
                return None;
            }
            match self.standing().await {
                Standing::Good => {}
                Standing::Ended => return None,
                // Send no event while the caller's rights are unknown.
                Standing::Unknown => {
                    self.pause().await;
                    continue;
                }
            }
            while let Some((position, stored)) = self.waiting.pop_front() {
                self.position = position;
                if let Some(stored) = stored.filter(|stored| self.concerns(stored)) {
                    return Some(Event::default().event("change").id(position.to_string()).data(published(&stored)));
                }
            }
            self.look().await;
        }
    }

    /// Identifies the caller again when due: the token may have ended, or an administrator or the identity provider may
    /// have changed its fleets.
    async fn standing(&mut self) -> Standing {
        if Instant::now() < self.check_at {
            return Standing::Good;
        }
        match self.app.access.identify(&self.app.store, &self.credential).await {
            Ok(caller) => {
                self.caller = caller;
                self.check_at = Instant::now() + self.app.streams.options().check_every;
                Standing::Good
            }
            Err(problem) if problem.kind == Kind::Unavailable => Standing::Unknown,
            Err(_) => Standing::Ended,
        }
    }

    fn concerns(&self, event: &StoredEvent) -> bool {
        let is_asked_for = self.fleet.as_ref().is_none_or(|fleets| fleets.matches(&event.fleet));
        is_asked_for && self.caller.scope.covers(&event.fleet)
    }

    /// Reads new changes, or waits if nothing is new. An unreachable database is retried.
    async fn look(&mut self) {
        self.changed.mark_unchanged();
        let found = self.app.store.events_after(self.position).await.unwrap_or_default();
        let is_quiet = found.is_empty();
        self.waiting.extend(found);
        if is_quiet {
            self.pause().await;
        }
    }

    /// Waits for a change of this supervisor, at most for the polling interval.
    async fn pause(&mut self) {
        let (changed, stop) = (&mut self.changed, &mut self.stop);
        let something = async {
            tokio::select! {
                _ = changed.changed() => {}
                _ = stop.changed() => {}
            }
        };
        let _ = timeout(POLL, something).await;
    }
}
