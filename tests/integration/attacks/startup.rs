//! Warnings at the start about secrets that other users can read, and secrets on the command line.

use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::Command;

use crate::started::{EmptyDatabase, PROGRAM};

const SECRET: &str = "hunter2-is-secret";

fn mode(path: &Path) -> u32 {
    std::fs::metadata(path).unwrap().permissions().mode() & 0o777
}

fn write(path: &Path, content: &str, mode: u32) -> String {
    std::fs::write(path, content).unwrap();
    std::fs::set_permissions(path, std::fs::Permissions::from_mode(mode)).unwrap();
    path.display().to_string()
}

#[tokio::test]
async fn regress_a_new_database_and_its_copies_are_their_owners_alone() {
    let place = EmptyDatabase::sqlite();
    let started = place.start(&["--http", "127.0.0.1:0"]);
    let database = place.folder.path().join("v.sqlite3");
    let path = |ending: &str| place.folder.path().join(format!("v.sqlite3{ending}"));
    for ending in ["", "-wal", "-shm", ".lock"] {
        assert_eq!(mode(&path(ending)), 0o600, "{ending}");
    }
    let copy = place.folder.path().join("copy.sqlite3");
    let ended = place.command(&["backup", &copy.display().to_string()]);
    assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
    assert_eq!(mode(&copy), 0o600);
    assert!(!started.log().contains("database.url: "), "{}", started.log());
    drop(started);
    // A database file from an earlier version.
    std::fs::set_permissions(&database, std::fs::Permissions::from_mode(0o644)).unwrap();
    let log = place.start(&["--http", "127.0.0.1:0"]).log();
    let warning =
        format!("database.url: everyone on this machine can read {0} (mode 0644): chmod 600 {0}", database.display());
    assert!(log.contains(&warning), "{log}");
}

#[tokio::test]
async fn regress_files_with_secrets_that_others_can_read_are_told_at_the_start() {
    let place = EmptyDatabase::sqlite();
    let token = write(&place.folder.path().join("token"), &"t".repeat(40), 0o644);
    let password = write(&place.folder.path().join("password"), SECRET, 0o644);
    let arguments = ["--http", "127.0.0.1:0", "--http-token-file", &token];
    // No broker runs there; the program reports that and continues.
    let broker = ["--mqtt-url", "mqtt://127.0.0.1:9", "--mqtt-username", "u", "--mqtt-password-file", &password];
    let launch = |path: &Path| {
        let database = format!("sqlite:{}", path.display());
        let said = std::fs::File::create(place.folder.path().join("said")).unwrap();
        let mut child = Command::new(PROGRAM)
            .args(["run", "--database-url", &database])
            .args(arguments)
            .args(broker)
            .stdout(std::process::Stdio::piped())
            .stderr(said)
            .spawn()
            .unwrap();
        let mut line = String::new();
        std::io::BufRead::read_line(&mut std::io::BufReader::new(child.stdout.take().unwrap()), &mut line).unwrap();
        child.kill().unwrap();
        child.wait().unwrap();
        assert!(line.contains("HTTP on"), "{line}");
        std::fs::read_to_string(place.folder.path().join("said")).unwrap()
    };
    let said = launch(&place.folder.path().join("a.sqlite3"));
    for (key, file) in [("http.token_file", &token), ("mqtt.password_file", &password)] {
        let warning = format!("{key}: everyone on this machine can read {file} (mode 0644): chmod 600 {file}");
        assert!(said.contains(&warning), "{warning}\n{said}");
    }
    assert!(!said.contains(SECRET) && !said.contains("tttt"), "{said}");
    for file in [&token, &password] {
        std::fs::set_permissions(file, std::fs::Permissions::from_mode(0o600)).unwrap();
    }
    let said = launch(&place.folder.path().join("b.sqlite3"));
    assert!(!said.contains("chmod"), "{said}");
}

#[test]
fn regress_plain_text_beyond_loopback_is_told_with_the_setting() {
    let place = EmptyDatabase::sqlite();
    let token = write(&place.folder.path().join("token"), &"t".repeat(40), 0o600);
    // Addresses reserved for documentation (RFC 5737), so this machine has none of them: the program warns and then
    // cannot listen.
    let (http, url) = ("192.0.2.1:8080", "mqtt://192.0.2.2:1883");
    let ended = place.command(&["run", "--http", http, "--http-token-file", &token, "--mqtt-url", url]);
    let said = String::from_utf8(ended.stderr).unwrap();
    assert_eq!(ended.status.code(), Some(1), "{said}");
    for warning in [
        "http.listen: HTTP on 192.0.2.1:8080 is plain text",
        "plain text, where others can read and change them: use mqtts://",
    ] {
        assert!(said.contains(warning), "{warning}\n{said}");
    }
}

#[test]
fn regress_passwords_are_not_taken_from_the_command_line() {
    let folder = tempfile::tempdir().unwrap();
    let run = |command: &str, flags: &[&str], environment: &[(&str, &str)]| {
        let mut program = Command::new(PROGRAM);
        program.arg(command).args(flags).env_clear().envs(environment.iter().copied()).current_dir(folder.path());
        let ended = program.output().unwrap();
        let said = String::from_utf8(ended.stdout).unwrap() + &String::from_utf8(ended.stderr).unwrap();
        assert!(!said.contains(SECRET), "{said}");
        (ended.status.success(), said)
    };
    let broker = ["--mqtt-url=mqtt://h", "--mqtt-username=u"];
    let written = format!("--mqtt-password={SECRET}");
    for flags in [&[written.as_str()][..], &["--mqtt-password", SECRET], &["--mqtt-password"]] {
        for command in ["config", "run", "record"] {
            let (is_good, said) = run(command, &[&broker[..], flags].concat(), &[]);
            assert!(!is_good && said.contains("mqtt.password_file (--mqtt-password-file FILE)"), "{command}: {said}");
            assert!(said.contains("VIBRISSA_MQTT_PASSWORD"), "{said}");
        }
    }
    let url = format!("--database-url=postgres://u:{SECRET}@h/d");
    let queried = format!("--database-url=postgres://u@h/d?password={SECRET}");
    for flag in [&url, &queried] {
        let (is_good, said) = run("config", &[flag.as_str()], &[]);
        assert!(!is_good && said.contains("database.password_file (--database-password-file FILE)"), "{said}");
        assert!(said.contains("VIBRISSA_DATABASE_URL"), "{said}");
    }
    let (_, help) = run("run", &["--help"], &[]);
    assert!(help.contains("--mqtt-password-file") && !help.contains("--mqtt-password <"), "{help}");
    // The environment and files are the remaining ways.
    let (is_good, said) = run("config", &broker, &[("VIBRISSA_MQTT_PASSWORD", SECRET)]);
    assert!(is_good && said.contains("# password = \"***\"  # environment VIBRISSA_MQTT_PASSWORD"), "{said}");
    let url = format!("postgres://u:{SECRET}@h/d");
    assert!(run("config", &[], &[("VIBRISSA_DATABASE_URL", &url)]).0);
}
