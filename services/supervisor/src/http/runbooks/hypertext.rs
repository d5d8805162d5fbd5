//! A runbook, or a document beside it, as a page for browsers.

use pulldown_cmark::{Event, Options, Parser, Tag, TagEnd, html};

/// Content security policy: the page loads styles and images of this service, and nothing else.
pub(super) const POLICY: &str = "default-src 'none'; style-src 'self'; img-src 'self'; base-uri 'none'; \
                                 form-action 'none'; frame-ancestors 'none'";

const BEFORE_TITLE: &str = "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
    <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
    <meta name=\"color-scheme\" content=\"light dark\">\n\
    <link rel=\"icon\" href=\"../console/icon.svg\" type=\"image/svg+xml\">\n\
    <link rel=\"stylesheet\" href=\"../console/styles/base.css\">\n\
    <link rel=\"stylesheet\" href=\"../console/styles/layout.css\">\n\
    <link rel=\"stylesheet\" href=\"../console/styles/runbooks.css\">\n<title>";
const BEFORE_BODY: &str = " - vibrissa</title>\n</head>\n<body>\n<header class=\"top\">\n\
    <p class=\"brand\"><a href=\"../#/alarms\">vibrissa</a></p>\n\
    <nav aria-label=\"Main\"><ul><li><a href=\"README.md\">All runbooks</a></li></ul></nav>\n\
    </header>\n<main class=\"runbook\">\n";
const AFTER_BODY: &str = "</main>\n</body>\n</html>\n";

/// The page for a text in Markdown. A link to a file for which `is_served` is true leads to the page of that file. A
/// link to another file of the repository becomes its text and the file's path.
#[expect(clippy::wildcard_enum_match_arm, reason = "the library's events: most of them stay as they are")]
pub(super) fn of(markdown: &str, is_served: impl Fn(&str) -> bool) -> String {
    let title = markdown.lines().find_map(|line| line.strip_prefix("# ")).unwrap_or("Runbook");
    let mut events = Vec::new();
    // Path of a file that is not served, until the end of its link.
    let mut outside: Option<String> = None;
    // Index of the event that begins the heading, and the heading's words so far.
    let mut heading: Option<(usize, String)> = None;
    for event in Parser::new_ext(markdown, Options::ENABLE_TABLES) {
        if let Some((_, words)) = &mut heading
            && let Event::Text(text) | Event::Code(text) = &event
        {
            words.push_str(text);
        }
        match event {
            Event::Start(Tag::Link { link_type, dest_url, title, id }) => match place(&dest_url, &is_served) {
                Place::Here(dest_url) => {
                    let dest_url = dest_url.into();
                    events.push(Event::Start(Tag::Link { link_type, dest_url, title, id }));
                }
                Place::Repository(path) => outside = Some(path),
            },
            Event::End(TagEnd::Link) => match outside.take() {
                Some(path) => {
                    events.push(Event::Text(" (".into()));
                    events.push(Event::Code(path.into()));
                    events.push(Event::Text(")".into()));
                }
                None => events.push(event),
            },
            Event::Start(Tag::Heading { .. }) => {
                heading = Some((events.len(), String::new()));
                events.push(event);
            }
            Event::End(TagEnd::Heading(_)) => {
                if let Some((at, words)) = heading.take()
                    && let Some(Event::Start(Tag::Heading { id, .. })) = events.get_mut(at)
                {
                    *id = Some(anchor(&words).into());
                }
                events.push(event);
            }
            // A wide table scrolls within this box. `tabindex` lets people scroll it by keyboard, too.
            Event::Start(Tag::Table(_)) => {
                events.extend([Event::Html("<div class=\"wide\" tabindex=\"0\">".into()), event]);
            }
            Event::End(TagEnd::Table) => events.extend([event, Event::Html("</div>\n".into())]),
            other => events.push(other),
        }
    }
    let mut page = String::from(BEFORE_TITLE);
    page.push_str(title);
    page.push_str(BEFORE_BODY);
    html::push_html(&mut page, events.into_iter());
    page.push_str(AFTER_BODY);
    page
}

/// Where a link leads.
enum Place {
    /// To a page of this service, a heading of this page, or another host.
    Here(String),
    /// To a file of the repository that is not served.
    Repository(String),
}

/// The place of a link. The repository has the pages in two folders, and the service has them in one.
fn place(link: &str, is_served: impl Fn(&str) -> bool) -> Place {
    let name = link.trim_start_matches("../").trim_start_matches("runbooks/");
    let file = name.split_once('#').map_or(name, |(file, _)| file);
    if file.is_empty() || link.contains("://") || is_served(file) {
        return Place::Here(name.to_owned());
    }
    Place::Repository(link.trim_start_matches("../").to_owned())
}

/// The anchor of a heading by the rule of GitHub: small letters, digits, hyphens and underscores.
fn anchor(words: &str) -> String {
    let known = words.chars().filter(|letter| letter.is_alphanumeric() || matches!(letter, ' ' | '-' | '_'));
    known.collect::<String>().to_lowercase().replace(' ', "-")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_has_its_title_tables_code_and_links_within_the_folder() {
        let is_served = |name: &str| ["README.md", "operations.md"].contains(&name);
        let text = "# Leak\n\nSee [all](README.md), [copies](../operations.md#back-up), [code](../../src/main.rs) and \
                    [here](#a-b).\n\n## A `b`\n\n\
                       | a | b |\n| --- | --- |\n| 1 < 2 | `x` |\n\n```sh\necho \"<b>\"\n```\n";
        let page = of(text, is_served);
        for part in [
            "<title>Leak - vibrissa</title>",
            "<h1 id=\"leak\">Leak</h1>",
            "<a href=\"README.md\">all</a>",
            "<a href=\"operations.md#back-up\">copies</a>",
            "code (<code>src/main.rs</code>)",
            "<a href=\"#a-b\">here</a>",
            "<h2 id=\"a-b\">A <code>b</code></h2>",
            "<td>1 &lt; 2</td>",
            "echo \"&lt;b&gt;\"",
        ] {
            assert!(page.contains(part), "{part}: {page}");
        }
    }
}
