//! The operators' console: a page at `/` and its modules under `/console/`. They read everything they show from the
//! API. The files are served without a token, because they contain no data.
//!
//! Debug builds read the files from the source folder, so that they can be edited while the service runs; other builds
//! contain them.

mod declared;

use std::borrow::Cow;

use axum::Router;
use axum::extract;
use axum::http::{HeaderMap, HeaderName, StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::get;

use super::problem::{Kind, Problem};
use super::version;

/// The page, served at `/` only, because its links are relative to that path.
const PAGE: &str = "index.html";

/// Headers for every file, in addition to those of `headers` for all answers. Scripts, styles and data come from this
/// origin alone, nothing is inline, and no other site's page may frame it. `no-cache` makes browsers check a copy's
/// `ETag` each time.
const HEADERS: [(HeaderName, &str); 2] = [
    (
        header::CONTENT_SECURITY_POLICY,
        "default-src 'self'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; \
         object-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    ),
    (header::CACHE_CONTROL, "no-cache"),
];

/// Defines `FILES`: the name of each file with its content.
macro_rules! files {
    ($($name:literal)+) => {
        const FILES: &[(&str, &[u8])] =
            &[$(($name, include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/console/", $name)))),+];
    };
}

files!(
    "actions.js"
    "address.js"
    "api.js"
    "browse.js"
    "calibration-file.js"
    "charts/data.js"
    "charts/events.js"
    "charts/gaps.js"
    "charts/lane.js"
    "charts/plot.js"
    "charts/range.js"
    "charts/ratio.js"
    "charts/scale.js"
    "charts/series.js"
    "charts/toolbar.js"
    "charts/values.js"
    "charts/whisker.js"
    "dialog.js"
    "dom.js"
    "drawing.js"
    "follow.js"
    "format.js"
    "icon.svg"
    "index.html"
    "live.js"
    "main.js"
    "marks.js"
    "menu.js"
    "notices.js"
    "notify.js"
    "pages/alarm-statistics.js"
    "pages/alarms.js"
    "pages/audit.js"
    "pages/bulk-action.js"
    "pages/bulk.js"
    "pages/calibration.js"
    "pages/calibrations.js"
    "pages/compensation.js"
    "pages/compensations.js"
    "pages/design.js"
    "pages/fleet.js"
    "pages/fleets.js"
    "pages/nowhere.js"
    "pages/operation.js"
    "pages/operations.js"
    "pages/policy.js"
    "pages/robot.js"
    "pages/rollout.js"
    "pages/rollouts.js"
    "pages/setpoints.js"
    "pages/timeline.js"
    "pages/trims.js"
    "pages/webhook.js"
    "pages/webhooks.js"
    "pages/what-if.js"
    "pages/whisker.js"
    "pages/whiskers.js"
    "parts/alarm-count.js"
    "parts/alarms.js"
    "parts/board.js"
    "parts/boxes.js"
    "parts/bulk.js"
    "parts/candidates.js"
    "parts/contact-uses.js"
    "parts/decisions.js"
    "parts/effect.js"
    "parts/entries.js"
    "parts/fleets.js"
    "parts/incidents.js"
    "parts/labels.js"
    "parts/maintenance.js"
    "parts/menu.js"
    "parts/newest.js"
    "parts/notes.js"
    "parts/proposals.js"
    "parts/readiness.js"
    "parts/refusals.js"
    "parts/rollouts.js"
    "parts/since.js"
    "parts/spark.js"
    "parts/story.js"
    "parts/tabs.js"
    "parts/tests.js"
    "parts/trims.js"
    "parts/webhooks.js"
    "parts/worst.js"
    "places.js"
    "rights.js"
    "router.js"
    "save.js"
    "schema.js"
    "session.js"
    "shortcuts.js"
    "sse.js"
    "styles/base.css"
    "styles/board.css"
    "styles/cards.css"
    "styles/charts.css"
    "styles/forms.css"
    "styles/interface.css"
    "styles/layout.css"
    "styles/lists.css"
    "styles/pictures.css"
    "styles/runbooks.css"
    "styles/story.css"
    "table.js"
    "tour.js"
    "vendor/uPlot.LICENSE.txt"
    "vendor/uPlot.esm.js"
    "vendor/uPlot.min.css"
    "views.js"
    "words.js"
    "zone-choice.js"
    "zone.js"
);

/// The page of all parts in all states, for people who change the console. Only debug builds serve it.
const DESIGN: &str = "pages/design.js";

/// The content of a file, if there is one of that name.
fn content(name: &str) -> Option<Cow<'static, [u8]>> {
    if name == DESIGN && !cfg!(debug_assertions) {
        return None;
    }
    if name == declared::PATH {
        return Some(declared::MODULE.as_bytes().into());
    }
    let (name, content) = FILES.iter().find(|(known, _)| *known == name)?;
    if cfg!(debug_assertions)
        && let Ok(edited) = std::fs::read(format!("{}/console/{name}", env!("CARGO_MANIFEST_DIR")))
    {
        return Some(edited.into());
    }
    Some((*content).into())
}

/// The page and its files.
pub(super) fn routes() -> Router {
    Router::new().route("/", get(page)).route("/console/{*path}", get(file))
}

async fn page(headers: HeaderMap) -> Response {
    answer(PAGE, &headers)
}

async fn file(extract::Path(path): extract::Path<String>, headers: HeaderMap) -> Response {
    if path == PAGE { missing() } else { answer(&path, &headers) }
}

fn answer(path: &str, headers: &HeaderMap) -> Response {
    let Some(content) = content(path) else { return missing() };
    let tag = tag(&content);
    if version::names(headers, header::IF_NONE_MATCH, &tag) {
        return (StatusCode::NOT_MODIFIED, HEADERS, [(header::ETAG, tag)]).into_response();
    }
    (HEADERS, [(header::ETAG, tag), (header::CONTENT_TYPE, media_type(path).to_owned())], content).into_response()
}

fn missing() -> Response {
    Problem::new(Kind::NotFound, "the console has no file of that name").into_response()
}

/// `ETag` of a file: a hash of its content.
fn tag(content: &[u8]) -> String {
    format!("\"{}\"", &blake3::hash(content).to_hex()[..32])
}

fn media_type(path: &str) -> &'static str {
    match path.rsplit_once('.').map(|(_, ending)| ending) {
        Some("html") => "text/html; charset=utf-8",
        Some("css") => "text/css; charset=utf-8",
        Some("js") => "text/javascript; charset=utf-8",
        Some("svg") => "image/svg+xml",
        Some("txt") => "text/plain; charset=utf-8",
        _ => "application/octet-stream",
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use super::*;

    async fn ask(path: &str, tags: &str) -> Response {
        let mut headers = HeaderMap::new();
        headers.insert(header::IF_NONE_MATCH, tags.parse().unwrap());
        file(extract::Path(path.to_owned()), headers).await
    }

    #[tokio::test]
    async fn a_file_that_was_not_changed_is_not_sent_again() {
        let first = ask("styles/base.css", "\"another\"").await;
        assert_eq!(first.status(), StatusCode::OK);
        assert_eq!(first.headers()[header::CONTENT_TYPE], "text/css; charset=utf-8");
        let tag = first.headers()[header::ETAG].to_str().unwrap().to_owned();
        for tags in [tag.clone(), format!("\"x\", W/{tag}"), "*".to_owned()] {
            let again = ask("styles/base.css", &tags).await;
            assert_eq!(again.status(), StatusCode::NOT_MODIFIED, "{tags}");
            assert_eq!(again.headers()[header::ETAG].to_str().unwrap(), tag);
        }
    }

    #[tokio::test]
    async fn what_is_not_in_the_folder_is_not_found() {
        for path in ["nothing.js", "../Cargo.toml", "..%2fCargo.toml", "/etc/hostname", "", "index.html"] {
            assert_eq!(ask(path, "").await.status(), StatusCode::NOT_FOUND, "{path:?}");
        }
    }

    #[test]
    fn every_file_has_a_type_that_browsers_take() {
        for (path, _) in FILES {
            assert_ne!(media_type(path), "application/octet-stream", "{path}");
        }
        assert!(FILES.iter().any(|(path, _)| *path == PAGE));
    }

    #[test]
    fn every_file_of_the_folder_is_served() {
        assert!(FILES.iter().all(|(path, _)| *path != declared::PATH), "{} is made, and no file", declared::PATH);
        fn add(folder: &Path, before: &str, names: &mut Vec<String>) {
            for entry in fs::read_dir(folder).unwrap() {
                let entry = entry.unwrap();
                let name = format!("{before}{}", entry.file_name().to_str().unwrap());
                if entry.path().is_dir() {
                    add(&entry.path(), &format!("{name}/"), names);
                } else {
                    names.push(name);
                }
            }
        }
        let mut names = Vec::new();
        add(&Path::new(env!("CARGO_MANIFEST_DIR")).join("console"), "", &mut names);
        names.sort();
        assert_eq!(FILES.iter().map(|(name, _)| *name).collect::<Vec<_>>(), names, "the list above, in order");
    }
}
