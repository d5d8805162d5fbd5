//! Files of the console: their headers, and that the page requests nothing from other hosts.

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

use crate::stage::Stage;

/// Status line and headers of an answer, in lower case.
async fn head(address: std::net::SocketAddr, path: &str, more: &str) -> String {
    let mut stream = TcpStream::connect(address).await.unwrap();
    let request = format!("GET {path} HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n{more}\r\n");
    stream.write_all(request.as_bytes()).await.unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).await.unwrap();
    answer.split_once("\r\n\r\n").unwrap().0.to_lowercase()
}

#[tokio::test]
async fn every_page_loads_without_an_error_and_asks_nobody_but_the_service() {
    let mut stage = Stage::start().await;
    stage.cut().await;
    stage.robot.setpoint().await;
    for (name, hash) in stage.pages().await {
        stage.open(&hash).await;
        let heading = stage.browser.js("document.querySelector('h1').textContent").await;
        assert_ne!(heading, "Cannot show this page", "{name}");
        assert_eq!(heading == "Page not found", name == "nowhere", "{name}: {heading}");
    }
    stage.is_clean();
    stage.stop().await;
}

#[tokio::test]
async fn the_files_come_with_headers_that_keep_the_page_to_itself() {
    let stage = Stage::start().await;
    for (path, kind) in
        [("/", "text/html"), ("/console/main.js", "text/javascript"), ("/console/styles/base.css", "text/css")]
    {
        let head_of = head(stage.service.http, path, "").await;
        assert!(head_of.starts_with("http/1.1 200"), "{path}: {head_of}");
        for part in [
            format!("content-type: {kind}; charset=utf-8"),
            "cache-control: no-cache".to_owned(),
            "x-content-type-options: nosniff".to_owned(),
            "referrer-policy: no-referrer".to_owned(),
            "default-src 'self'".to_owned(),
            "frame-ancestors 'none'".to_owned(),
        ] {
            assert!(head_of.contains(&part), "{path} lacks {part}: {head_of}");
        }
        assert!(!head_of.contains("unsafe"), "{path}: {head_of}");
        let tag = head_of.lines().find_map(|line| line.strip_prefix("etag: ")).unwrap().to_owned();
        let again = head(stage.service.http, path, &format!("If-None-Match: {tag}\r\n")).await;
        assert!(again.starts_with("http/1.1 304"), "{path}: {again}");
    }
    for path in ["/console/nothing.js", "/console/index.html", "/console/..%2fCargo.toml"] {
        let head_of = head(stage.service.http, path, "").await;
        assert!(head_of.starts_with("http/1.1 404"), "{path}: {head_of}");
    }
    stage.stop().await;
}
