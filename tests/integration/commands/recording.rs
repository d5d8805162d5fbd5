//! `vibrissa record` without a broker.

use std::net::{Ipv4Addr, TcpListener};

use crate::program::{err, vibrissa};

/// A port on which nothing listens.
fn free_port() -> u16 {
    TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap().local_addr().unwrap().port()
}

#[test]
fn a_recording_without_a_broker_fails_and_names_the_address_and_the_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let port = free_port();
    let url = format!("mqtt://127.0.0.1:{port}");
    for out in ["-", "day.jsonl"] {
        let arguments = ["record", "--broker", &url, "--fleet", "lab", "--for", "500ms", "--out", out];
        let ended = vibrissa(&arguments, folder.path());
        let message = err(&ended);
        let last = message.lines().last().unwrap();
        assert_eq!(ended.status.code(), Some(1), "{message}");
        assert!(last.starts_with("vibrissa: 0 messages recorded; not recorded: fleet lab: tried "), "{message}");
        assert!(last.contains(&format!("127.0.0.1:{port}: nothing listens there: start the broker")), "{message}");
        assert!(ended.stdout.is_empty());
    }
    let left: Vec<_> = std::fs::read_dir(folder.path()).unwrap().collect();
    assert!(left.is_empty(), "an empty recording would be in the way of the next attempt: {left:?}");
}

#[test]
fn a_server_that_never_answers_is_named_too() {
    let folder = tempfile::tempdir().unwrap();
    // The system accepts the connection; nobody reads from it.
    let mute = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
    let address = mute.local_addr().unwrap();
    let url = format!("mqtt://{address}");
    let ended = vibrissa(&["record", "--broker", &url, "--for", "500ms"], folder.path());
    assert_eq!(ended.status.code(), Some(1), "{}", err(&ended));
    let message = err(&ended);
    assert!(message.contains("tried once in ") && message.contains(&format!("MQTT broker {address}: ")), "{message}");
}
