//! A webhook as JSON: properties to set, and state to show.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use vibrissa_edge::clock::wall_clock;
use vibrissa_edge::events::{Audience, EventKind, webhook_kinds};
use vibrissa_edge::fleets::{FLEETS_MAX, FleetPattern};
use vibrissa_edge::guidance::Level;
use vibrissa_edge::words::Word;
use vibrissa_store::time::Time;
use vibrissa_store::webhooks::manage::WebhookSettings;
use vibrissa_store::webhooks::queue::Queue;
use vibrissa_store::webhooks::{MAIL, WebhookRow};

use crate::http::App;
use crate::http::access::{Caller, Role};
use crate::http::problem::{Kind, Problem};
use crate::http::words::{EventKindWord, LevelWord, OneOf, words};
use crate::webhooks::target::checked;

/// Maximum length of a name, in characters.
const NAME_CHARS_MAX: usize = 100;
words! {
    /// State of a webhook.
    pub enum WebhookState {
        /// Nothing was sent yet.
        New = "NEW",
        /// It took the last event.
        Working = "WORKING",
        /// It did not take the last event, which is tried again.
        Failing = "FAILING",
        /// Events are not delivered, and wait.
        Disabled = "DISABLED",
    }
}

/// A webhook: a target that gets events.
#[derive(Debug, Serialize, ToSchema)]
pub struct Webhook {
    /// Number of the webhook.
    #[schema(minimum = 1)]
    pub webhook_id: i64,
    /// Its name.
    pub name: String,
    /// URL that receives the events. Only admins see what follows the host, which may be confidential. For a person it is
    /// `mailto:` and the address.
    pub url: String,
    /// Fleets of its events, as names and patterns; null for all fleets.
    pub fleets: Option<Vec<String>>,
    /// Kinds of its events; null for all kinds.
    pub kinds: Option<Vec<EventKindWord>>,
    /// Its least urgent events.
    pub level: LevelWord,
    /// Whether events are delivered; otherwise they wait.
    pub enabled: bool,
    /// State of the webhook.
    pub state: WebhookState,
    /// Time of its creation.
    pub created_at: Time,
    /// Time of the last change.
    pub changed_at: Time,
    /// Actor of the last change.
    pub changed_by: String,
    /// Until when the previous secret is valid, too; null if only the present one is.
    pub previous_secret_until: Option<Time>,
    /// Time of the last attempt; null before the first.
    pub last_at: Option<Time>,
    /// Status of the last answer, of HTTP or SMTP; null without an answer.
    #[schema(minimum = 100, maximum = 599)]
    pub last_status: Option<i64>,
    /// Why the last attempt failed; null after a success.
    pub last_problem: Option<String>,
    /// Time of the last success; null before the first.
    pub last_success_at: Option<Time>,
    /// Failed attempts since the last success.
    #[schema(minimum = 0)]
    pub failures: i64,
    /// Earliest time of the next attempt; null unless it waits for one.
    pub next_at: Option<Time>,
    /// Number of waiting events.
    #[schema(minimum = 0)]
    pub waiting: i64,
    /// Time of the oldest waiting event; null if none waits.
    pub oldest_at: Option<Time>,
    /// Number of dead letters.
    #[schema(minimum = 0)]
    pub dead_letters: i64,
    /// Number of delivered events, and of events that were delivered again.
    #[schema(minimum = 0)]
    pub delivered: i64,
    /// Number of failed attempts.
    #[schema(minimum = 0)]
    pub failed: i64,
    /// Number of events that were removed undelivered: the queue has at most 20,000 events of a week, and there are at
    /// most 1,000 dead letters.
    #[schema(minimum = 0)]
    pub lost: i64,
}

impl Webhook {
    pub(super) fn of(row: &WebhookRow, queue: Queue, caller: &Caller) -> Self {
        let now_us = wall_clock().0 as i64;
        let interest = row.interest();
        let state = match (row.enabled, row.last_us, row.streak) {
            (false, ..) => WebhookState::Disabled,
            (true, None, _) => WebhookState::New,
            (true, Some(_), 0) => WebhookState::Working,
            (true, Some(_), _) => WebhookState::Failing,
        };
        Self {
            webhook_id: row.webhook_id,
            name: row.name.clone(),
            url: if caller.role == Role::Admin { row.url.clone() } else { origin(&row.url) },
            fleets: interest.fleets.map(|fleets| fleets.iter().map(ToString::to_string).collect()),
            kinds: interest.kinds.map(|kinds| kinds.into_iter().map(OneOf).collect()),
            level: OneOf(interest.level),
            enabled: row.enabled,
            state,
            created_at: Time(row.created_us),
            changed_at: Time(row.changed_us),
            changed_by: row.changed_by.clone(),
            previous_secret_until: row.previous_until_us.filter(|&until_us| until_us > now_us).map(Time),
            last_at: row.last_us.map(Time),
            last_status: row.last_status,
            last_problem: row.last_problem.clone(),
            last_success_at: row.last_success_us.map(Time),
            failures: row.streak,
            next_at: (row.enabled && row.streak > 0).then_some(Time(row.next_us)),
            waiting: queue.waiting,
            oldest_at: queue.oldest_us.map(Time),
            dead_letters: queue.dead,
            delivered: row.delivered,
            failed: row.failed,
            lost: row.lost,
        }
    }
}

/// Scheme and host of a URL, or a person's address. The path of a URL and query may hold a credential, as those of chat services do.
pub(super) fn origin(url: &str) -> String {
    if url.starts_with(MAIL) {
        return url.to_owned();
    }
    url::Url::parse(url)
        .map_or_else(|_| String::new(), |url| format!("{}/\u{2026}", url.origin().ascii_serialization()))
}

/// All webhooks that the caller may see.
#[derive(Debug, Serialize, ToSchema)]
pub struct WebhookList {
    /// The webhooks, in the order of their names. There are at most 200.
    pub items: Vec<Webhook>,
}

/// A new webhook, or a changed one, with its secret.
#[derive(Debug, Serialize, ToSchema)]
pub struct WebhookWithSecret {
    /// The webhook.
    pub webhook: Webhook,
    /// Secret that signs the requests, `whsec_` and Base64. It is shown only now; null if the request was repeated, and
    /// for a person.
    pub secret: Option<String>,
}

/// Kinds of the events that a mail tells, unless others are asked for.
const MAIL_KINDS: [EventKind; 2] = [EventKind::AlarmRaised, EventKind::AlarmCleared];

/// Properties of a webhook.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = NewWebhook)]
pub struct WebhookBody {
    /// Its name, unique.
    #[schema(min_length = 1, max_length = 100, pattern = "^[^\\x00]+$")]
    pub name: String,
    /// URL that receives the events: `https://...` or `http://...`, or `mailto:` and the address of a person. Private
    /// addresses need the setting `webhooks.allowed_hosts`, mails the setting `mail.url`.
    #[schema(max_length = 2000, example = "https://hooks.example/vibrissa")]
    pub url: String,
    /// Fleets of its events: names, or patterns such as `hall-*`, which include future fleets; null for all fleets.
    #[schema(value_type = Option<Vec<String>>, min_items = 1, max_items = 100)]
    pub fleets: Option<Vec<FleetPattern>>,
    /// Kinds of its events, of those that docs/webhooks.md lists; null for all of them, and for mails for alarms and their
    /// ends.
    #[schema(min_items = 1)]
    pub kinds: Option<Vec<EventKindWord>>,
    /// Its least urgent events; `WARNING` if omitted, which means all.
    pub level: Option<LevelWord>,
    /// Whether events are delivered, by default true; otherwise they wait.
    pub enabled: Option<bool>,
    /// Reason in free text, at most 1000 characters.
    #[schema(max_length = 1000)]
    pub reason: Option<String>,
}

impl WebhookBody {
    pub(super) fn settings(&self, app: &App, caller: &Caller) -> Result<WebhookSettings, Problem> {
        let name = self.name.trim();
        if name.is_empty() || name.chars().count() > NAME_CHARS_MAX || name.contains(char::is_control) {
            let problem = format!("must have 1 to {NAME_CHARS_MAX} characters and no control characters");
            return Err(Problem::invalid("name", problem));
        }
        let url = checked(&self.url, app.webhooks.sender().hosts()).map_err(|what| Problem::invalid("url", what))?;
        if url.starts_with(MAIL) && app.webhooks.sender().mail().is_none() {
            return Err(Problem::invalid("url", "needs a mail server for mailto: set mail.url in the configuration"));
        }
        let fleets = self.fleets.as_ref();
        if fleets.is_some_and(|fleets| fleets.is_empty() || fleets.len() > FLEETS_MAX) {
            return Err(Problem::invalid(
                "fleets",
                format!("must have 1 to {FLEETS_MAX} names and patterns, or be null for all fleets"),
            ));
        }
        let kinds: Option<Vec<EventKind>> = self.kinds.as_ref().map(|kinds| kinds.iter().map(|kind| kind.0).collect());
        if kinds.as_ref().is_some_and(Vec::is_empty) {
            return Err(Problem::invalid("kinds", "must have at least one kind, or be null for all kinds"));
        }
        if let Some(other) = kinds.iter().flatten().find(|kind| kind.audience() != Audience::People) {
            let those = webhook_kinds().into_iter().map(Word::word).collect::<Vec<_>>().join(", ");
            return Err(Problem::invalid("kinds", format!("webhooks get no {}, only {those}", other.word())));
        }
        let fleets = fleets.filter(|fleets| !fleets.iter().any(FleetPattern::is_all));
        let fleets = fleets.map(|fleets| fleets.iter().map(FleetPattern::as_str).collect::<Vec<_>>().join(","));
        if !is_covered(caller, fleets.as_deref()) {
            return Err(Problem::new(
                Kind::Forbidden,
                "your token does not cover all fleets of this webhook: name fleets or patterns within your token's",
            ));
        }
        // Most other events are of use to programs alone.
        let kinds = kinds.or_else(|| url.starts_with(MAIL).then(|| MAIL_KINDS.to_vec()));
        let kinds = kinds.map(|kinds| kinds.into_iter().map(Word::word).collect::<Vec<_>>().join(","));
        Ok(WebhookSettings {
            name: name.to_owned(),
            url,
            fleets,
            kinds,
            level: self.level.map_or(Level::Warning, |level| level.0).word().to_owned(),
            enabled: self.enabled.unwrap_or(true),
        })
    }
}

/// Whether the caller may access all fleets of a webhook.
pub(super) fn is_covered(caller: &Caller, fleets: Option<&str>) -> bool {
    match fleets {
        None => caller.scope == crate::http::access::Scope::All,
        Some(fleets) => {
            fleets.split(',').all(|fleet| FleetPattern::new(fleet).is_ok_and(|one| caller.scope.includes(&one)))
        }
    }
}
