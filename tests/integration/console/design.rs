//! The page of all parts in all states: sizes of type, heights of rows, and nothing that is cut off.

use serde_json::json;

use crate::checks::{complaints, overflow, sideways};
use crate::stage::Stage;

/// Sizes of the texts of the page in px, without those of drawings.
const SIZES: &str = "[...new Set([...document.querySelectorAll('body *')]\
    .filter((one) => !one.closest('svg') && one.getClientRects().length \
        && [...one.childNodes].some((node) => node.nodeType === Node.TEXT_NODE && node.data.trim())) \
    .map((one) => Math.round(10 * parseFloat(getComputedStyle(one).fontSize)) / 10))].sort((one, other) => one - other)";
/// Heights of the rows of tables.
const ROWS: &str = "[...document.querySelectorAll('main tbody tr')].map((one) => one.getBoundingClientRect().height)";
/// Names that take more than one line, or are cut off.
const BROKEN: &str = "[...document.querySelectorAll('main tbody th, main tbody td a')]\
    .filter((one) => one.getClientRects().length > 1 || one.scrollWidth > one.clientWidth + 1).map((one) => one.innerText)";

#[tokio::test]
async fn all_parts_keep_the_rules_of_type_rows_and_widths() {
    let mut stage = Stage::start().await;
    let mut widths = None;
    for scheme in ["light", "dark"] {
        stage.browser.prefers(scheme).await;
        for width in [360, 390, 768, 1280, 1920] {
            stage.browser.size(width, 900).await;
            stage.open("#/design").await;
            let at = format!("{scheme}, {width} px");
            assert_eq!(stage.browser.js("document.querySelector('h1').textContent").await, "Design");
            assert_eq!(complaints(&mut stage.browser).await, Vec::<String>::new(), "{at}");
            assert_eq!(overflow(&mut stage.browser).await, Vec::<String>::new(), "{at}");
            stage.picture(&format!("design-{width}-{scheme}")).await;
            let sizes = stage.browser.js(SIZES).await;
            let expected = if width <= 640 { json!([13.7, 16, 24]) } else { json!([12, 14, 21]) };
            assert_eq!(sizes, expected, "{at}: three sizes of type");
            if width >= 1280 {
                let rows = stage.browser.js(ROWS).await;
                let rows = rows.as_array().unwrap();
                assert!(rows.len() > 5 && rows.iter().all(|one| *one == json!(36)), "{at}: {rows:?}");
                assert_eq!(stage.browser.js(BROKEN).await, json!([]), "{at}");
                // A table is as wide as its content: on each of these screens the same.
                let wide = stage.browser.js("document.querySelector('main table').offsetWidth").await;
                assert_eq!(*widths.get_or_insert(wide.clone()), wide, "{at}");
            }
            // Header, content and footer have one left edge.
            let edges = "new Set(['.brand', 'h1', 'footer .zone'].map((one) => \
                Math.round(document.querySelector(one).getBoundingClientRect().left))).size";
            assert_eq!(stage.browser.js(edges).await, 1, "{at}");
            assert_eq!(sideways(&mut stage.browser).await, Vec::<String>::new(), "{at}");
        }
    }
    stage.is_clean();
    stage.stop().await;
}
