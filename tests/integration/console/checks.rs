//! Whether people can read and reach what a page shows.

use serde_json::{Value, json};

use crate::browser::Browser;

const CHECKS: &str = include_str!("checks.js");

/// An expression over the checks, as `all`.
async fn with_checks(browser: &mut Browser, expression: &str) -> Value {
    let checks = CHECKS.trim_end().trim_end_matches(';');
    browser.js(&format!("(() => {{ const all = {checks}; return {expression}; }})()")).await
}

/// Roles that must have a name, for people who hear the page.
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

/// What is wrong with the page as it is shown, besides its width.
pub(crate) async fn complaints(browser: &mut Browser) -> Vec<String> {
    let mut found = Vec::new();
    for check in ["headings", "tables", "fields", "pictures", "contrast", "frames"] {
        found.extend(texts(&with_checks(browser, &format!("all.{check}()")).await));
    }
    found.extend(nameless(browser).await);
    found
}

/// Whether the page is wider than the screen.
pub(crate) async fn overflow(browser: &mut Browser) -> Vec<String> {
    texts(&with_checks(browser, "all.overflow()").await)
}

/// The least contrast of any text with what is behind it.
pub(crate) async fn least_contrast(browser: &mut Browser) -> f64 {
    with_checks(browser, "(all.contrast(), all.least)").await.as_f64().unwrap()
}

fn texts(list: &Value) -> Vec<String> {
    list.as_array().unwrap().iter().map(|one| one.as_str().unwrap().to_owned()).collect()
}

/// What has no name in the browser's own tree for assistive programs.
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
