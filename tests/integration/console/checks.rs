//! Checks of readability and accessibility of a page.

use serde_json::{Value, json};

use crate::browser::Browser;

const CHECKS: &str = include_str!("checks.js");

/// Evaluates an expression over the checks, which are named `all`.
async fn with_checks(browser: &mut Browser, expression: &str) -> Value {
    let checks = CHECKS.trim_end().trim_end_matches(';');
    browser.js(&format!("(() => {{ const all = {checks}; return {expression}; }})()")).await
}

/// Roles that need a name for screen readers.
const NAMED: [&str; 11] = [
    "button",
    "link",
    "textbox",
    "spinbutton",
    "combobox",
    "image",
    "table",
    "region",
    "dialog",
    "navigation",
    "heading",
];

/// Problems of the visible page, except its width.
pub(crate) async fn complaints(browser: &mut Browser) -> Vec<String> {
    let mut found = Vec::new();
    for check in ["headings", "tables", "fields", "pictures", "contrast", "frames", "lines"] {
        found.extend(texts(&with_checks(browser, &format!("all.{check}()")).await));
    }
    found.extend(nameless(browser).await);
    found
}

/// Problems of the page's width: it must not exceed the screen.
pub(crate) async fn overflow(browser: &mut Browser) -> Vec<String> {
    texts(&with_checks(browser, "all.overflow()").await)
}

/// Elements that scroll sideways, with all parts of the page open.
pub(crate) async fn sideways(browser: &mut Browser) -> Vec<String> {
    browser.js("document.querySelectorAll('main details').forEach((one) => (one.open = true))").await;
    // Tables of values are filled by an event after the opening.
    browser.js("new Promise((drawn) => requestAnimationFrame(() => requestAnimationFrame(() => drawn(true))))").await;
    texts(&with_checks(browser, "all.sideways()").await)
}

/// Smallest contrast between a text and its background.
pub(crate) async fn least_contrast(browser: &mut Browser) -> f64 {
    with_checks(browser, "(all.contrast(), all.least)").await.as_f64().unwrap()
}

fn texts(list: &Value) -> Vec<String> {
    list.as_array().unwrap().iter().map(|one| one.as_str().unwrap().to_owned()).collect()
}

/// Elements without a name in the browser's accessibility tree.
async fn nameless(browser: &mut Browser) -> Vec<String> {
    let tree = browser.call("Accessibility.getFullAXTree", json!({})).await;
    let nodes = tree["nodes"].as_array().unwrap();
    assert!(nodes.len() > 20, "a tree");
    let is_nameless = |node: &&Value| {
        let role = node["role"]["value"].as_str().unwrap_or_default();
        let name = node["name"]["value"].as_str().unwrap_or_default();
        node["ignored"] != true && NAMED.contains(&role) && name.trim().is_empty()
    };
    nodes.iter().filter(is_nameless).map(|node| format!("no name: {}", node["role"]["value"])).collect()
}
