//! Error messages when the program cannot start.

use std::net::TcpListener;
use std::path::Path;
use std::time::Duration;

use tempfile::TempDir;

use crate::program::PROGRAM;

/// The error message of the program, which must fail at once.
fn refusal(database: &Path, arguments: &[&str]) -> String {
    let ended = assert_cmd::Command::new(PROGRAM)
        .args(["run", "--database-url"])
        .arg(format!("sqlite:{}", database.display()))
        .args(arguments)
        .env("RUST_LOG", "off")
        .timeout(Duration::from_secs(20))
        .output()
        .unwrap();
    let said = String::from_utf8(ended.stderr).unwrap();
    assert_eq!(ended.status.code(), Some(1), "{said}");
    assert!(ended.stdout.is_empty(), "it must not print an address");
    assert!(said.starts_with("vibrissa: ") && said.trim_end().lines().count() == 1, "expected one line, not {said:?}");
    said
}

fn taken() -> (TcpListener, u16) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    (listener, port)
}

fn database() -> (TempDir, std::path::PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("vibrissa.sqlite3");
    (folder, path)
}

const ANY_PORTS: [&str; 4] = ["--mqtt-port", "0", "--http", "127.0.0.1:0"];

#[test]
fn a_taken_mqtt_port_is_named_with_both_ways_out() {
    let (_listener, port) = taken();
    let (_folder, path) = database();
    let said = refusal(&path, &["--mqtt-port", &port.to_string(), "--http", "127.0.0.1:0"]);
    let url = format!("--mqtt-url mqtt://127.0.0.1:{port}");
    for part in [&format!("port {port} on 127.0.0.1 is taken"), "--mqtt-port 0", url.as_str()] {
        assert!(said.contains(part), "{part} in {said}");
    }
}

#[test]
fn a_taken_http_port_is_named_with_the_way_out() {
    let (_listener, port) = taken();
    let (_folder, path) = database();
    let said = refusal(&path, &["--mqtt-port", "0", "--http", &format!("127.0.0.1:{port}")]);
    for part in [&format!("127.0.0.1:{port}"), "--http"] {
        assert!(said.contains(part), "{part} in {said}");
    }
    assert_eq!(said.matches("in use").count(), 1, "expected once: {said}");
}

#[test]
fn a_database_in_a_folder_that_does_not_exist_is_named_with_the_folder() {
    let (folder, _) = database();
    let missing = folder.path().join("nowhere");
    let said = refusal(&missing.join("vibrissa.sqlite3"), &ANY_PORTS);
    assert!(said.contains(&format!("the folder {} does not exist", missing.display())), "{said}");
}

#[test]
fn a_file_that_is_no_database_is_named_and_left_alone() {
    let (_folder, path) = database();
    let text = "not a database, but somebody's notes\n".repeat(50);
    std::fs::write(&path, &text).unwrap();
    let said = refusal(&path, &ANY_PORTS);
    assert!(said.contains(&path.display().to_string()), "{said}");
    assert_eq!(said.matches("file is not a database").count(), 1, "expected once: {said}");
    assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
}

#[test]
fn beyond_this_machine_it_does_not_start_where_nobody_could_be_let_in() {
    let (folder, database) = database();
    let exposed = ["--http", "0.0.0.0:0", "--mqtt-port", "0"];
    let message = refusal(&database, &exposed);
    assert!(message.contains("vibrissa token create") && message.contains("0.0.0.0:0"), "{message}");
    // It starts with a token from the database or a file; on loopback it needs none.
    let url = format!("sqlite:{}", database.display());
    let create = |role: &str, scope: &[&str]| {
        let mut command = std::process::Command::new(PROGRAM);
        command.args(["token", "create", "--role", role, "--expires", "90d", "--database-url", &url]).args(scope);
        command.output().unwrap()
    };
    let made = create("operator", &["--fleet", "a"]);
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let token = String::from_utf8(made.stdout).unwrap();
    assert!(token.starts_with("vbr_") && token.trim().len() > 50, "{token}");
    let unscoped = create("operator", &[]);
    assert!(!unscoped.status.success() && String::from_utf8_lossy(&unscoped.stderr).contains("--fleet"));
    let listed = std::process::Command::new(PROGRAM).args(["token", "list", "--database-url", &url]).output().unwrap();
    let listed = String::from_utf8(listed.stdout).unwrap();
    assert!(listed.contains("OPERATOR") && !listed.contains(token.trim()), "{listed}");
    // With a token for HTTP, MQTT must not be open to everyone on this machine.
    let message = refusal(&database, &exposed);
    assert!(message.contains("mqtt.password_file") && message.contains("mqtt.url"), "{message}");
    drop(folder);
}
