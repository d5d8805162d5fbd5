//! The runbooks under `/runbooks/`: what an alarm means and what to do. They are part of the program, so they can be read
//! without other hosts, and without a token, because they contain no data.

mod hypertext;

use axum::Router;
use axum::extract;
use axum::http::{HeaderMap, header};
use axum::response::{IntoResponse, Redirect, Response};
use axum::routing::get;

use serde::Deserialize;

use super::accept::preferred;
use super::extract::Query;
use super::problem::Problem;
use vibrissa_edge::guidance::RUNBOOKS;
use vibrissa_protocol::Name;

/// The page that lists the others.
const FIRST: &str = "README.md";

macro_rules! pages {
    ($($name:literal,)+) => {
        /// The pages by name, in order.
        const PAGES: &[(&str, &str)] =
            &[$(($name, include_str!(concat!("../../../../docs/runbooks/", $name)))),+];
    };
}

pages! {
    "README.md",
    "VibrissaApprovalWaiting.md",
    "VibrissaArchiveBehind.md",
    "VibrissaBrokerDisconnected.md",
    "VibrissaClockDisagrees.md",
    "VibrissaCommitLag.md",
    "VibrissaCompensationErrorHigh.md",
    "VibrissaContactLag.md",
    "VibrissaDatabaseAsynchronous.md",
    "VibrissaDatabaseDown.md",
    "VibrissaDatabaseErrors.md",
    "VibrissaFleetHeldTwice.md",
    "VibrissaFleetSilent.md",
    "VibrissaFleetUnsupervised.md",
    "VibrissaHttpErrors.md",
    "VibrissaInboxShedding.md",
    "VibrissaInvariantViolated.md",
    "VibrissaItemsSetAside.md",
    "VibrissaKafkaBehind.md",
    "VibrissaKafkaDisconnected.md",
    "VibrissaKafkaEventsMissing.md",
    "VibrissaKafkaEventsWaiting.md",
    "VibrissaLeaseFlapping.md",
    "VibrissaMessagesLost.md",
    "VibrissaMessagesQuarantined.md",
    "VibrissaMessagesRefused.md",
    "VibrissaModelMisfit.md",
    "VibrissaNoSupervisor.md",
    "VibrissaNothingRecorded.md",
    "VibrissaProbesLost.md",
    "VibrissaQueueNearlyFull.md",
    "VibrissaReadingsShifted.md",
    "VibrissaReceiptsMissing.md",
    "VibrissaReceiptsUnheard.md",
    "VibrissaRestarting.md",
    "VibrissaRobotDuplicate.md",
    "VibrissaRobotNotTaken.md",
    "VibrissaRobotSilent.md",
    "VibrissaRobotsDisconnected.md",
    "VibrissaRolloutRolledBack.md",
    "VibrissaSessionTakenOver.md",
    "VibrissaSetpointFailed.md",
    "VibrissaSetpointsFailing.md",
    "VibrissaSupervisorDown.md",
    "VibrissaUpkeepFailing.md",
    "VibrissaWebhookStuck.md",
    "VibrissaWhiskerFault.md",
    "VibrissaWhiskerUncompensated.md",
    "VibrissaWhiskerWearing.md",
    "WhiskerErodingAway.md",
    "WhiskerUnheard.md",
}

/// Documents that the runbooks refer to, by name.
const DOCUMENTS: &[(&str, &str)] = &[
    ("archive.md", include_str!("../../../../docs/archive.md")),
    ("invariants.md", include_str!("../../../../docs/invariants.md")),
    ("kafka.md", include_str!("../../../../docs/kafka.md")),
    ("operations.md", include_str!("../../../../docs/operations.md")),
    ("postgresql.md", include_str!("../../../../docs/postgresql.md")),
    ("security.md", include_str!("../../../../docs/security.md")),
    ("webhooks.md", include_str!("../../../../docs/webhooks.md")),
];

/// The text of a page or document.
fn text_of(name: &str) -> Option<&'static str> {
    PAGES.iter().chain(DOCUMENTS).find(|(known, _)| *known == name).map(|(_, text)| *text)
}

/// The pages: as hypertext for browsers, and as Markdown for all others.
pub(super) fn routes() -> Router<super::App> {
    Router::new().route("/runbooks", get(async || Redirect::permanent(&format!("{RUNBOOKS}/{FIRST}")))).route(
        "/runbooks/{name}",
        get(async |extract::Path(name): extract::Path<String>, Query(subject): Query<Subject>, headers: HeaderMap| {
            page(&name, &subject, &headers)
        }),
    )
}

/// The names that replace the placeholders of a page.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Subject {
    fleet: Option<Name>,
    robot: Option<Name>,
    array: Option<Name>,
    whisker: Option<u16>,
}

impl Subject {
    /// The page with its placeholders replaced where they are words of their own: ROBOT, but not `ROBOT_SILENT`.
    fn fill(&self, text: &str) -> String {
        let name = |name: &Option<Name>| name.as_ref().map(Name::to_string);
        let names = [
            ("FLEET", name(&self.fleet)),
            ("ROBOT", name(&self.robot)),
            ("ARRAY", name(&self.array)),
            ("NUMBER", self.whisker.map(|whisker| whisker.to_string())),
        ];
        let is_of_word = |letter: char| letter.is_ascii_alphanumeric() || letter == '_';
        let mut filled = String::with_capacity(text.len());
        let mut rest = text;
        while !rest.is_empty() {
            let word = rest.find(|letter| !is_of_word(letter)).unwrap_or(rest.len());
            let known = names.iter().find(|(placeholder, _)| *placeholder == &rest[..word]);
            filled.push_str(known.and_then(|(_, name)| name.as_deref()).unwrap_or(&rest[..word]));
            let end = rest[word..].find(is_of_word).map_or(rest.len(), |at| word + at);
            filled.push_str(&rest[word..end]);
            rest = &rest[end..];
        }
        filled
    }
}

fn page(name: &str, subject: &Subject, headers: &HeaderMap) -> Response {
    let Some(text) = text_of(name) else {
        return Problem::not_found(format_args!("runbook called {name}: {RUNBOOKS}/{FIRST} lists them"))
            .into_response();
    };
    let text = subject.fill(text);
    let vary = (header::VARY, "accept");
    if preferred(headers, &["text/plain", "text/html"]) == Some(1) {
        let content = (header::CONTENT_TYPE, "text/html; charset=utf-8");
        let policy = (header::CONTENT_SECURITY_POLICY, hypertext::POLICY);
        return ([content, policy, vary], hypertext::of(&text, |name| text_of(name).is_some())).into_response();
    }
    // Browsers show this type, and would only save text/markdown.
    ([(header::CONTENT_TYPE, "text/plain; charset=utf-8"), vary], text).into_response()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn placeholders_that_are_words_of_their_own_are_replaced() {
        let subject = Subject {
            fleet: Some(Name::new("lab").unwrap()),
            robot: Some(Name::new("crawler-1").unwrap()),
            array: None,
            whisker: Some(2),
        };
        let page = "ROBOT_SILENT: `/v1/fleets/FLEET/robots/ROBOT/arrays/ARRAY/whiskers/NUMBER`, FLEETS \u{2264} NUMBER";
        let filled = "ROBOT_SILENT: `/v1/fleets/lab/robots/crawler-1/arrays/ARRAY/whiskers/2`, FLEETS \u{2264} 2";
        assert_eq!(subject.fill(page), filled);
        assert_eq!(Subject::default().fill(page), page);
    }

    #[test]
    fn each_document_that_a_runbook_refers_to_is_served() {
        for (page, text) in PAGES {
            let html = hypertext::of(text, |name| text_of(name).is_some());
            for link in html.split("<a href=\"").skip(1).map(|rest| rest.split_once('"').unwrap().0) {
                let (name, anchor) = link.split_once('#').unwrap_or((link, ""));
                if name.starts_with("..") || name.starts_with("http") {
                    continue;
                }
                let target = text_of(name).unwrap_or_else(|| panic!("{page} refers to {link}"));
                let target = hypertext::of(target, |_| true);
                assert!(anchor.is_empty() || target.contains(&format!("id=\"{anchor}\"")), "{page} refers to {link}");
            }
            for file in text.split("](../").skip(1).map(|rest| rest.split([')', '#']).next().unwrap()) {
                assert!(text_of(file).is_some(), "{page} refers to {file}");
            }
        }
    }

    #[test]
    fn each_page_of_the_folder_is_served() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/runbooks");
        let names = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<String> = names.collect();
        names.sort();
        assert_eq!(PAGES.iter().map(|(name, _)| *name).collect::<Vec<_>>(), names, "the list above, in order");
    }
}
