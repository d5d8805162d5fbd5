//! Plots are well-formed SVG documents with texts for screen readers.

use crate::document::{Document, get_operations};
use crate::served::Served;

/// Panics unless elements are properly nested and no tag or text is open.
fn assert_well_formed(svg: &str) {
    let mut open: Vec<&str> = Vec::new();
    let mut rest = svg;
    while let Some(begin) = rest.find('<') {
        let end = begin + rest[begin..].find('>').unwrap_or_else(|| panic!("an open tag in {svg}"));
        let text = &rest[..begin];
        assert!(
            text.split('&').skip(1).all(|part| ["amp;", "lt;", "gt;", "quot;"].iter().any(|e| part.starts_with(e))),
            "{text}"
        );
        let tag = &rest[begin + 1..end];
        assert_eq!(tag.matches('"').count() % 2, 0, "{tag}");
        let name = tag.trim_matches('/').split_whitespace().next().unwrap();
        match (tag.starts_with('/'), tag.ends_with('/')) {
            (true, _) => assert_eq!(open.pop(), Some(name), "{svg}"),
            (false, true) => {}
            (false, false) => open.push(name),
        }
        rest = &rest[end + 1..];
    }
    assert!(open.is_empty() && rest.trim().is_empty(), "{open:?} {rest}");
}

#[tokio::test]
async fn pictures_are_well_formed_and_told_in_words() {
    let served = Served::sqlite().await;
    let id = served.items("/v1/compensations?fleet=f&robot=r1").await[0]["compensation_id"].to_string();
    let document = Document::of(&served).await;
    let mut pictures = 0;
    for (path, _) in get_operations(&document.0)
        .filter(|(path, _)| path.ends_with("/plot.svg") && !path.contains("{calibration_id}"))
    {
        let path = path.replace("{fleet}", "f").replace("{robot}", "r1").replace("{array}", "left");
        for whisker in ["0", "2"] {
            let path = path.replace("{whisker}", whisker).replace("{compensation_id}", &id);
            let answer = served.get(&path).await;
            assert_eq!((answer.status, answer.headers["content-type"].as_str()), (200, "image/svg+xml"), "{path}");
            let svg = &answer.body;
            assert_well_formed(svg);
            for needed in ["role=\"img\"", "viewBox=\"0 0 ", "<title id=", "<desc id=", "prefers-color-scheme:dark"] {
                assert!(svg.contains(needed), "{path}: no {needed}");
            }
            for unwanted in ["<script", "<svg width", "NaN", "inf"] {
                assert!(!svg.contains(unwanted), "{path}: {unwanted}");
            }
            assert_eq!(*svg, served.get(&path).await.body, "{path}: every request must give the same plot");
            pictures += 1;
        }
    }
    assert_eq!(pictures, 12);
}
