//! Without an agreement on TLS the supervisor sends neither CONNECT nor user nor password.

use std::path::PathBuf;

use tempfile::TempDir;
use vibrissa_tests::certificates::{Authority, Identity, Validity, write};
use vibrissa_tests::wait::until_true;

use crate::link::{Link, PASSWORD, tls, with_password};
use crate::recorder::Recorder;

/// Type of a client's first TLS record.
const CLIENT_HELLO: u8 = 0x16;
const USER: &str = "somebody";

fn contains(haystack: &[u8], needle: &str) -> bool {
    haystack.windows(needle.len()).any(|window| window == needle.as_bytes())
}

fn trusted(authority: &Authority) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let ca_file = write(folder.path(), "ca.crt", &authority.certificate());
    (folder, ca_file)
}

/// Makes several attempts at a server that must not be trusted.
async fn nothing_gets_out(authority: &Authority, server: Identity, sentence: &[&str]) {
    let (_folder, ca_file) = trusted(authority);
    let recorder = Recorder::start(Some(&server)).await;
    let link = Link::start(with_password(tls(recorder.port, &ca_file), USER));
    link.problem_with(sentence).await;
    until_true("several attempts", async || recorder.heard().connections >= 5).await;
    link.stop().await;
    let heard = recorder.heard();
    assert_eq!(heard.wire.first(), Some(&CLIENT_HELLO), "the first byte must be TLS");
    assert_eq!(heard.plain, b"", "nothing may follow the handshake");
    for secret in [PASSWORD, USER, "MQTT", "vibrissa"] {
        assert!(!contains(&heard.wire, secret), "{secret}");
    }
}

#[tokio::test]
async fn a_server_that_is_trusted_gets_the_password_so_that_the_recorder_is_known_to_hear() {
    let authority = Authority::new("ours");
    let (_folder, ca_file) = trusted(&authority);
    let recorder = Recorder::start(Some(&authority.server(&["localhost"], Validity::Now))).await;
    let link = Link::start(with_password(tls(recorder.port, &ca_file), USER));
    until_true("a password", async || contains(&recorder.heard().plain, PASSWORD)).await;
    let heard = recorder.heard();
    assert!(contains(&heard.plain, "MQTT") && contains(&heard.plain, USER));
    assert!(!contains(&heard.wire, PASSWORD));
    link.problem_with(&["says nothing within 5 s"]).await;
    link.stop().await;
}

#[tokio::test]
async fn a_certificate_of_another_authority_gets_nothing() {
    let other = Authority::new("theirs").server(&["localhost"], Validity::Now);
    nothing_gets_out(&Authority::new("ours"), other, &["not signed by a trusted authority", "ca.crt", "mqtt.ca_file"])
        .await;
}

#[tokio::test]
async fn an_authority_of_the_same_name_gets_nothing() {
    let other = Authority::new("ours").server(&["localhost"], Validity::Now);
    nothing_gets_out(&Authority::new("ours"), other, &["not signed by a trusted authority", "ca.crt"]).await;
}

#[tokio::test]
async fn a_certificate_for_another_host_gets_nothing() {
    let authority = Authority::new("ours");
    let server = authority.server(&["broker.example"], Validity::Now);
    nothing_gets_out(&authority, server, &["not for \"localhost\"", "broker.example", "mqtt.url"]).await;
}

#[tokio::test]
async fn a_certificate_that_has_expired_gets_nothing() {
    let authority = Authority::new("ours");
    let server = authority.server(&["localhost"], Validity::Over);
    nothing_gets_out(&authority, server, &["has expired", "clock"]).await;
}

#[tokio::test]
async fn a_certificate_that_is_not_valid_yet_gets_nothing() {
    let authority = Authority::new("ours");
    let server = authority.server(&["localhost"], Validity::Ahead);
    nothing_gets_out(&authority, server, &["not valid yet", "clock"]).await;
}

#[tokio::test]
async fn a_server_without_tls_gets_nothing_but_the_wish_for_it() {
    let (_folder, ca_file) = trusted(&Authority::new("ours"));
    let recorder = Recorder::start(None).await;
    let link = Link::start(with_password(tls(recorder.port, &ca_file), USER));
    link.problem_with(&["says nothing within 5 s", "TLS"]).await;
    link.stop().await;
    let heard = recorder.heard();
    assert_eq!(heard.wire.first(), Some(&CLIENT_HELLO));
    for secret in [PASSWORD, USER, "MQTT", "vibrissa"] {
        assert!(!contains(&heard.wire, secret), "{secret}");
    }
}
