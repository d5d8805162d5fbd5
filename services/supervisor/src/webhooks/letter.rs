//! The text of a mail about events. The subject says how bad and where; the body has advice, runbook and console.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use vibrissa_core::robot::effect::AlarmKind;
use vibrissa_edge::events::EventKind;
use vibrissa_edge::guidance::{Level, of_word, urgency};
use vibrissa_edge::words::{Word as _, Words as _, named};
use vibrissa_store::events::StoredEvent;
use vibrissa_store::time::Time;
use vibrissa_store::webhooks::{MAIL, WebhookRow};

use super::mail::MailOptions;

/// Most events that a mail lists of one group.
const LISTED_MAX: usize = 20;
/// Most threads that a mail names: a longer line than the 998 characters of a mail would be refused.
const THREADS_MAX: usize = 12;

/// A mail to one person, before the mail server has it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Letter {
    /// Address of the person.
    pub to: String,
    /// Identifier: the same at each attempt.
    pub id: String,
    /// One line: the level, the place and the kind.
    pub subject: String,
    /// Plain text: advice, links and the list of subjects.
    pub text: String,
    /// Names of the alarms, by which mail programs show an alarm and its end together.
    pub threads: Vec<String>,
}

/// Events of one kind in one fleet.
struct Group<'a> {
    kind: EventKind,
    level: Level,
    alarm: Option<AlarmKind>,
    events: Vec<&'a StoredEvent>,
}

impl Letter {
    /// The mail about events of a target, which has at least one.
    pub(super) fn about<'a>(
        webhook: &WebhookRow,
        id: String,
        events: impl Iterator<Item = &'a StoredEvent>,
        mail: &MailOptions,
    ) -> Self {
        let events: Vec<&StoredEvent> = events.collect();
        let mut threads = Vec::new();
        for event in &events {
            let thread = thread(event);
            if threads.len() < THREADS_MAX && !threads.contains(&thread) {
                threads.push(thread);
            }
        }
        let groups = groups(&events);
        let others = events.len() - groups.first().map_or(0, |group| group.events.len());
        let more = if others > 0 { format!(", and {others} more") } else { String::new() };
        let first = groups.first().map_or_else(String::new, Group::headline);
        let mut text = String::new();
        for group in &groups {
            group.tell(&mut text, mail);
        }
        if let Some(url) = &mail.console_url {
            let _ = writeln!(text, "All alarms: {url}/#/alarms\n");
        }
        text.push_str(&footer(webhook, mail));
        Self { to: address(webhook), id, subject: format!("{first}{more}"), text, threads }
    }

    /// The mail of a test.
    pub(crate) fn test(webhook: &WebhookRow, id: String, mail: &MailOptions) -> Self {
        let subject = format!("Test of {}", webhook.name);
        let text = format!("Alarms reach this address.\n\n{}", footer(webhook, mail));
        Self { to: address(webhook), id, subject, text, threads: Vec::new() }
    }
}

fn address(webhook: &WebhookRow) -> String {
    webhook.url.strip_prefix(MAIL).unwrap_or_default().to_owned()
}

fn footer(webhook: &WebhookRow, mail: &MailOptions) -> String {
    let page = mail.console_url.as_ref().map(|url| format!(": {url}/#/webhooks/{}", webhook.webhook_id));
    format!("-- \nThe webhook \"{}\" of vibrissa sends these mails{}\n", webhook.name, page.unwrap_or_default())
}

/// Name of the subject and the kind of an event. An alarm and its end have the same.
fn thread(event: &StoredEvent) -> String {
    let StoredEvent { fleet, robot, array, whisker, word, .. } = event;
    let named = format!("{fleet}/{robot:?}/{array:?}/{whisker:?}/{word:?}");
    format!("vibrissa-alarm-{}", &blake3::hash(named.as_bytes()).to_hex()[..24])
}

/// The events by level, by whether they tell of an end, by urgency, kind and fleet: the worst first.
fn groups<'a>(events: &[&'a StoredEvent]) -> Vec<Group<'a>> {
    let mut groups: BTreeMap<_, Group<'a>> = BTreeMap::new();
    for &event in events {
        let Some(kind) = event.event_kind() else { continue };
        let is_alarm = matches!(kind, EventKind::AlarmRaised | EventKind::AlarmCleared);
        let word = event.word.as_deref().filter(|_| is_alarm);
        let (level, alarm) = (kind.level(word), word.and_then(named::<AlarmKind>));
        let is_end = kind == EventKind::AlarmCleared;
        let place =
            (is_end, Reverse(level), Reverse(alarm.map_or(0, urgency)), kind.word(), word, event.fleet.as_str());
        let group = groups.entry(place).or_insert_with(|| Group { kind, level, alarm, events: Vec::new() });
        group.events.push(event);
    }
    groups.into_values().collect()
}

/// Robot and whisker of an event.
fn subject(event: &StoredEvent) -> String {
    let robot = event.robot.as_deref().unwrap_or("the whole fleet");
    match (&event.array, event.whisker) {
        (Some(array), Some(whisker)) => format!("{robot}, whisker {array} {whisker}"),
        _ => robot.to_owned(),
    }
}

/// Length that a trim has cost, if that is what the event is about.
fn lost(event: &StoredEvent) -> Option<String> {
    let data: serde_json::Value = serde_json::from_str(&event.data).ok()?;
    let trim = data.get("trim")?;
    let (before, after) = (trim.get("length_before_mm")?.as_f64()?, trim.get("length_after_mm")?.as_f64()?);
    Some(format!("{:.1} mm lost", before - after))
}

impl Group<'_> {
    fn fleet(&self) -> &str {
        self.events.first().map_or("", |event| event.fleet.as_str())
    }

    /// The subject of a single event by its name, several subjects by their number.
    fn subjects(&self) -> String {
        if let [event] = self.events.as_slice() {
            return format!("{} of {}", subject(event), event.fleet);
        }
        let robots: BTreeSet<&str> = self.events.iter().filter_map(|event| event.robot.as_deref()).collect();
        let whiskers: BTreeSet<_> =
            self.events.iter().map(|event| (&event.robot, &event.array, event.whisker)).collect();
        let of = match (robots.len(), robots.first()) {
            (1, Some(robot)) => format!("{robot} of {}", self.fleet()),
            (many, _) => format!("{many} robots of {}", self.fleet()),
        };
        let is_of_whiskers = self.events.iter().all(|event| event.whisker.is_some());
        if is_of_whiskers { format!("{} whiskers of {of}", whiskers.len()) } else { of }
    }

    /// How bad, where, and what: `URGENT: 41 robots of hall are silent`.
    fn headline(&self) -> String {
        let subjects = self.subjects();
        let told = match (self.alarm, self.events.as_slice()) {
            (Some(AlarmKind::RobotSilent), [_]) => format!("{subjects} is silent"),
            (Some(AlarmKind::RobotSilent), _) => format!("{subjects} are silent"),
            (Some(kind), _) => format!("{subjects}: {}", kind.label().unwrap_or(kind.word())),
            (None, [event]) => {
                let what = self.kind.label().unwrap_or(self.kind.word());
                format!("{subjects}: {}", lost(event).map_or_else(|| what.to_owned(), |lost| format!("{what}, {lost}")))
            }
            (None, _) => format!("{subjects}: {}", self.kind.label().unwrap_or(self.kind.word())),
        };
        let level = self.level.word();
        if self.kind == EventKind::AlarmCleared { format!("Over: {told}") } else { format!("{level}: {told}") }
    }

    fn tell(&self, text: &mut String, mail: &MailOptions) {
        let _ = writeln!(text, "{}", self.headline());
        let guidance = self.alarm.and_then(|kind| of_word(kind.word()));
        if let Some(guidance) = guidance.filter(|_| self.kind == EventKind::AlarmRaised) {
            let _ = writeln!(text, "What to do: {}", guidance.hint);
            if let Some(url) = &mail.runbooks_url {
                let _ = writeln!(text, "Runbook: {url}/{}", guidance.runbook);
            }
        }
        for event in self.events.iter().take(LISTED_MAX) {
            let lost = lost(event).map_or_else(String::new, |lost| format!(", {lost}"));
            let page = mail.console_url.as_ref().map_or_else(String::new, |url| format!(": {}", page(event, url)));
            let _ = writeln!(text, "- {}{lost}, {}{page}", subject(event), Time(event.recorded_us));
        }
        let rest = self.events.len().saturating_sub(LISTED_MAX);
        if rest > 0 {
            let _ = writeln!(text, "- and {rest} more");
        }
        text.push('\n');
    }
}

/// The page of the console about the event's subject. Names need no escapes: they have letters, digits and `_.-`.
fn page(event: &StoredEvent, console_url: &str) -> String {
    let mut page = format!("{console_url}/#/fleets/{}", event.fleet);
    if let Some(robot) = &event.robot {
        let _ = write!(page, "/robots/{robot}");
    }
    if let (Some(array), Some(whisker)) = (&event.array, event.whisker) {
        let _ = write!(page, "/arrays/{array}/whiskers/{whisker}");
    }
    page
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::super::mail::Encryption;
    use super::*;

    fn options() -> MailOptions {
        MailOptions {
            host: "h".to_owned(),
            port: None,
            encryption: Encryption::None,
            credentials: None,
            sender: "vibrissa@example.org".to_owned(),
            gather: Duration::ZERO,
            pause: Duration::ZERO,
            console_url: Some("https://v.example/west".to_owned()),
            runbooks_url: Some("https://v.example/west/runbooks".to_owned()),
        }
    }

    fn target() -> WebhookRow {
        WebhookRow {
            webhook_id: 3,
            name: "night".to_owned(),
            url: "mailto:ann@example.org".to_owned(),
            fleets: None,
            kinds: None,
            level: "WARNING".to_owned(),
            enabled: true,
            previous_until_us: None,
            created_us: 0,
            changed_us: 0,
            changed_by: "admin".to_owned(),
            done_tx: 0,
            done_event: 0,
            streak: 0,
            next_us: 0,
            last_us: None,
            last_status: None,
            last_problem: None,
            last_success_us: None,
            delivered: 0,
            failed: 0,
            lost: 0,
        }
    }

    fn event(kind: &str, word: Option<&str>, robot: &str, whisker: Option<i64>) -> StoredEvent {
        StoredEvent {
            event_id: 7,
            tx: 0,
            recorded_us: 1_795_260_000_000_000,
            version: 2,
            kind: kind.to_owned(),
            word: word.map(ToOwned::to_owned),
            fleet: "hall".to_owned(),
            robot: Some(robot.to_owned()),
            array: whisker.map(|_| "left".to_owned()),
            whisker,
            data: "{}".to_owned(),
        }
    }

    fn letter(events: &[StoredEvent]) -> Letter {
        Letter::about(&target(), "x".to_owned(), events.iter(), &options())
    }

    #[test]
    fn one_alarm_says_how_bad_and_where_what_to_do_and_where_to_look() {
        let one = letter(&[event("ALARM_RAISED", Some("LEAK"), "r-1", Some(2))]);
        assert_eq!(
            (one.to.as_str(), one.subject.as_str()),
            ("ann@example.org", "URGENT: r-1, whisker left 2 of hall: leaking")
        );
        for part in [
            "What to do: ",
            "Runbook: https://v.example/west/runbooks/Vibrissa",
            "https://v.example/west/#/fleets/hall/robots/r-1/arrays/left/whiskers/2",
            "https://v.example/west/#/webhooks/3",
        ] {
            assert!(one.text.contains(part), "{part}: {}", one.text);
        }
    }

    #[test]
    fn many_alarms_are_one_sentence_and_the_worst_is_the_subject() {
        let mut events: Vec<StoredEvent> =
            (0..41).map(|robot| event("ALARM_RAISED", Some("ROBOT_SILENT"), &format!("r-{robot}"), None)).collect();
        assert_eq!(letter(&events).subject, "URGENT: 41 robots of hall are silent");
        events.push(event("ALARM_RAISED", Some("ERODING"), "r-1", Some(1)));
        events.push(event("ALARM_CLEARED", Some("SETPOINT_FAILED"), "r-1", Some(1)));
        let all = letter(&events);
        assert_eq!(all.subject, "URGENT: 41 robots of hall are silent, and 2 more");
        assert!(
            all.text.contains("- and 21 more") && all.text.contains("Over: r-1, whisker left 1 of hall"),
            "{}",
            all.text
        );
        events.push(event("ALARM_RAISED", Some("SETPOINT_FAILED"), "r-2", Some(1)));
        assert_eq!(
            letter(&events).subject,
            "CRITICAL: r-2, whisker left 1 of hall: setpoints have failed, and 43 more"
        );
        let folded = letter(&[
            event("ALARM_RAISED", Some("LEAK"), "r", Some(1)),
            event("ALARM_RAISED", Some("LEAK"), "r", Some(2)),
        ]);
        assert_eq!(folded.subject, "URGENT: 2 whiskers of r of hall: leaking");
    }

    #[test]
    fn a_trim_says_how_much_is_lost() {
        let mut trim = event("TRIM", None, "r", Some(0));
        trim.data = r#"{"trim":{"trim_id":1,"length_before_mm":70.0,"length_after_mm":60.4}}"#.to_owned();
        assert!(letter(&[trim]).subject.ends_with(", 9.6 mm lost"));
    }

    #[test]
    fn an_alarm_and_its_end_share_a_thread_that_no_other_alarm_has() {
        let threads = |kind: &str, word: &str, whisker| letter(&[event(kind, Some(word), "r", Some(whisker))]).threads;
        let raised = threads("ALARM_RAISED", "LEAK", 1);
        assert_eq!(raised, threads("ALARM_CLEARED", "LEAK", 1));
        assert_ne!(raised, threads("ALARM_RAISED", "LEAK", 2));
        assert_ne!(raised, threads("ALARM_RAISED", "ERODING", 1));
        let many: Vec<StoredEvent> =
            (0..50).map(|whisker| event("ALARM_RAISED", Some("LEAK"), "r", Some(whisker))).collect();
        assert_eq!(letter(&many).threads.len(), THREADS_MAX);
    }
}
