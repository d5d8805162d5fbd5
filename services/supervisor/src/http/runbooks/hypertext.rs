//! A runbook as a page for browsers.

use pulldown_cmark::{CowStr, Event, Options, Parser, Tag, TagEnd, html};

/// The page has styles of this service, and nothing else.
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

/// The page for a text in Markdown.
pub(super) fn of(markdown: &str) -> String {
    let title = markdown.lines().find_map(|line| line.strip_prefix("# ")).unwrap_or("Runbook");
    let mut events = Vec::new();
    // Only runbooks are served. Instead of a link to another document, its place in the repository is named.
    let mut outside: Option<CowStr<'_>> = None;
    for event in Parser::new_ext(markdown, Options::ENABLE_TABLES) {
        if let Event::Start(Tag::Link { dest_url, .. }) = &event
            && dest_url.starts_with("../")
        {
            outside = Some(dest_url.clone());
        } else if event == Event::End(TagEnd::Link)
            && let Some(path) = outside.take()
        {
            events.push(Event::Text(" (".into()));
            events.push(Event::Code(path.replacen("../", "docs/", 1).into()));
            events.push(Event::Text(")".into()));
        } else if matches!(event, Event::Start(Tag::Table(_))) {
            // A wide table scrolls on its own, by keys as well.
            events.extend([Event::Html("<div class=\"wide\" tabindex=\"0\">".into()), event]);
        } else if event == Event::End(TagEnd::Table) {
            events.extend([event, Event::Html("</div>\n".into())]);
        } else {
            events.push(event);
        }
    }
    let mut page = String::from(BEFORE_TITLE);
    page.push_str(title);
    page.push_str(BEFORE_BODY);
    html::push_html(&mut page, events.into_iter());
    page.push_str(AFTER_BODY);
    page
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_has_its_title_tables_code_and_links_within_the_folder() {
        let page = of("# Leak\n\nSee [all](README.md) and [operations](../operations.md).\n\n\
                       | a | b |\n| --- | --- |\n| 1 < 2 | `x` |\n\n```sh\necho \"<b>\"\n```\n");
        for part in [
            "<title>Leak - vibrissa</title>",
            "<h1>Leak</h1>",
            "<a href=\"README.md\">all</a>",
            "operations (<code>docs/operations.md</code>)",
            "<td>1 &lt; 2</td>",
            "echo \"&lt;b&gt;\"",
        ] {
            assert!(page.contains(part), "{part}: {page}");
        }
    }
}
