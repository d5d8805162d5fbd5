//! The picture of the console in the README: written by this test, or compared with the page of today.
//!
//! Two pictures of the same page differ in times, measured values and fonts. So the file of the picture has, in a comment of
//! the PNG format, a description of what it shows, and the test compares that with the page.

use std::path::Path;

use serde_json::{Value, json};
use vibrissa_tests::demo::LiveDemo;
use vibrissa_tests::svg::{document, writes_docs};
use vibrissa_tests::web::send;

use crate::browser::Browser;

const PROGRAM: &str = env!("CARGO_BIN_EXE_lab-under-test");
const LOOK: &str = include_str!("look.js");
/// Beginning of the comment in the PNG file: its keyword, no compression, no language.
const KEYWORD: &[u8] = b"vibrissa-look\0\0\0\0\0";
/// The parts of the page that are in the picture.
const PARTS: [&str; 7] = [
    "body > header",
    "main > .trail",
    "main > .headline",
    "main > .marks",
    "main > .facts",
    "main > section:nth-of-type(1)",
    "main > section:nth-of-type(2)",
];

/// The same cuts as in the demo's own script.
async fn cut(demo: &LiveDemo, whisker: u16, by_mm: f64) {
    let body = json!({ "robot": "crawler-1", "array": "left", "whisker": whisker, "kind": "CUT", "by_mm": by_mm });
    let answer = send(demo.http, "POST", "/demo/incidents", &[], Some(&body)).await.unwrap();
    assert_eq!(answer.status, 200, "{}", answer.body);
    let applied = |one: &Value| one["setpoint_state"] == "APPLIED";
    demo.item(&format!("/v1/compensations?robot=crawler-1&target_whisker={whisker}"), applied).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_picture_of_the_console_in_docs_is_up_to_date() {
    let mut demo = LiveDemo::start(PROGRAM).await;
    cut(&demo, 2, 5.0).await;
    cut(&demo, 4, 14.0).await;
    let mut browser = Browser::start().await;
    browser.open(&format!("http://{}/#/fleets/demo/robots/crawler-1", demo.http)).await;
    let compensated =
        "document.querySelectorAll('main section:nth-of-type(2) td .mark, main section:nth-of-type(2) .mark')";
    browser
        .until(
            "both cuts are compensated",
            &format!("[...{compensated}].filter((one) => one.innerText.includes('trimmed, compensated')).length === 2"),
        )
        .await;
    let mut look = texts(&browser.js(&format!("({})({})", LOOK.trim_end(), json!(PARTS))).await);
    look.retain(|line| !line.starts_with("option"));
    let end = browser.js("document.querySelectorAll('main > section')[1].getBoundingClientRect().bottom + 16").await;
    let path = document("console.png");
    if writes_docs() {
        browser.picture_of_top(&path, 1280.0, end.as_f64().unwrap().ceil()).await;
        let png = std::fs::read(&path).unwrap();
        std::fs::write(&path, with_comment(&png, look.join("\n").as_bytes())).unwrap();
    }
    let then = described(&path);
    let new: Vec<&String> = look.iter().filter(|line| !then.contains(line)).collect();
    let gone: Vec<&String> = then.iter().filter(|line| !look.contains(line)).collect();
    assert!(
        new.is_empty() && gone.is_empty(),
        "docs/console.png is outdated: write it with VIBRISSA_WRITE_DOCS=1 cargo test -p vibrissa-tests --test console \
         the_picture_of\nnew: {new:#?}\nno longer shown: {gone:#?}"
    );
    demo.type_line("quit");
    assert!(demo.ended().await.success());
}

fn texts(list: &Value) -> Vec<String> {
    list.as_array().unwrap().iter().map(|one| one.as_str().unwrap().to_owned()).collect()
}

/// Chunks of a PNG file: type, content, and the end of the chunk in the file.
fn chunks(png: &[u8]) -> impl Iterator<Item = (&[u8], &[u8], usize)> {
    let mut at = 8;
    std::iter::from_fn(move || {
        let length = u32::from_be_bytes(png.get(at..at + 4)?.try_into().ok()?) as usize;
        let (kind, content) = (png.get(at + 4..at + 8)?, png.get(at + 8..at + 8 + length)?);
        at += 12 + length;
        Some((kind, content, at))
    })
}

/// The file with a comment after its first chunk.
fn with_comment(png: &[u8], text: &[u8]) -> Vec<u8> {
    let (.., head) = chunks(png).next().expect("a PNG file");
    let content = [b"iTXt", KEYWORD, text].concat();
    let mut crc = flate2::Crc::new();
    crc.update(&content);
    let length = u32::try_from(content.len() - 4).unwrap().to_be_bytes();
    [&png[..head], &length, &content, &crc.sum().to_be_bytes(), &png[head..]].concat()
}

/// The lines of the comment of a file.
fn described(path: &Path) -> Vec<String> {
    let png = std::fs::read(path).unwrap();
    let text = chunks(&png).find_map(|(kind, content, _)| content.strip_prefix(KEYWORD).filter(|_| kind == b"iTXt"));
    let text = String::from_utf8_lossy(text.unwrap_or_default()).into_owned();
    text.lines().map(ToOwned::to_owned).collect()
}
