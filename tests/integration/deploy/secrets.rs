//! `deploy/make-secrets` creates random passwords and keeps existing ones.

use std::collections::BTreeMap;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::project;

/// Path of the Python interpreter.
fn python() -> PathBuf {
    let ended = Command::new("python3").args(["-c", "import sys; print(sys.executable)"]).output().unwrap();
    PathBuf::from(String::from_utf8(ended.stdout).unwrap().trim())
}

/// Runs the script, optionally with a search path without Mosquitto, and returns the files it has written.
fn make(folder: &Path, with_mosquitto: bool) -> BTreeMap<String, String> {
    let mut command = Command::new("/bin/sh");
    command.arg(project().join("deploy/make-secrets")).arg(folder);
    let tools = tempfile::tempdir().unwrap();
    if !with_mosquitto {
        let needed = [
            "base64", "cat", "chmod", "chown", "cmp", "cp", "dirname", "head", "id", "mkdir", "mv", "python3", "rm",
            "tr",
        ];
        for tool in needed {
            let found = std::env::split_paths(&std::env::var_os("PATH").unwrap())
                .map(|folder| folder.join(tool))
                .find(|path| path.exists())
                .unwrap_or_else(|| panic!("{tool} must be installed for this test"));
            // The actual interpreter: version managers install wrappers, which need the full search path.
            let found = if tool == "python3" { python() } else { found };
            std::os::unix::fs::symlink(found, tools.path().join(tool)).unwrap();
        }
        command.env("PATH", tools.path());
    }
    let ended = command.output().unwrap();
    assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
    assert!(ended.stdout.is_empty() && ended.stderr.is_empty(), "{ended:?}");
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    files
        .map(|path| {
            let name = path.file_name().unwrap().to_str().unwrap().to_owned();
            (name, std::fs::read_to_string(&path).unwrap())
        })
        .collect()
}

#[test]
fn passwords_are_new_each_time_and_stay_once_they_are_there() {
    let [one, other] = [0, 1].map(|_| tempfile::tempdir().unwrap());
    let (first, elsewhere) = (make(one.path(), true), make(other.path(), true));
    let names = [
        "grafana_postgres_password",
        "mosquitto_acl",
        "mosquitto_passwords",
        "mosquitto_supervisor_passwords",
        "postgres_grafana_password",
        "postgres_password",
        "postgres_supervisor_password",
        "robots_mqtt_password",
        "supervisor_http_token",
        "supervisor_mqtt_password",
        "supervisor_postgres_password",
    ];
    assert_eq!(first.keys().collect::<Vec<_>>(), names);
    assert_eq!(first["postgres_supervisor_password"], first["supervisor_postgres_password"]);
    assert_ne!(
        first["postgres_password"], first["supervisor_postgres_password"],
        "the superuser needs a password of its own"
    );
    let acl = std::fs::read_to_string(project().join("deploy/mosquitto/acl")).unwrap();
    assert_eq!(first["mosquitto_acl"], acl);
    assert_eq!(first["grafana_postgres_password"], first["postgres_grafana_password"]);
    assert_ne!(first["grafana_postgres_password"], first["postgres_password"]);
    assert_ne!(first["supervisor_mqtt_password"], first["robots_mqtt_password"]);
    for name in names.iter().filter(|name| **name != "mosquitto_acl") {
        assert_ne!(first[*name], elsewhere[*name], "{name}");
    }
    for name in names.iter().filter(|name| !name.starts_with("mosquitto_")) {
        assert_eq!(first[*name].trim_end().len(), 32, "{name}");
    }
    assert_eq!(make(one.path(), true), first);
    std::fs::remove_file(one.path().join("robots_mqtt_password")).unwrap();
    std::fs::remove_file(one.path().join("mosquitto_passwords")).unwrap();
    let again = make(one.path(), true);
    assert_ne!(again["robots_mqtt_password"], first["robots_mqtt_password"]);
    assert_eq!(again["postgres_password"], first["postgres_password"]);
}

#[test]
fn regress_supervisors_do_not_keep_the_superusers_password_from_an_earlier_version() {
    let folder = tempfile::tempdir().unwrap();
    let first = make(folder.path(), true);
    for name in ["supervisor_postgres_password", "postgres_supervisor_password"] {
        std::fs::write(folder.path().join(name), &first["postgres_password"]).unwrap();
    }
    let again = make(folder.path(), true);
    assert_eq!(again["postgres_password"], first["postgres_password"]);
    assert_ne!(again["supervisor_postgres_password"], first["postgres_password"]);
    assert_eq!(again["supervisor_postgres_password"], again["postgres_supervisor_password"]);
}

#[test]
fn a_changed_access_list_is_copied_again() {
    let folder = tempfile::tempdir().unwrap();
    let first = make(folder.path(), true);
    std::fs::write(folder.path().join("mosquitto_acl"), "user old\n").unwrap();
    assert_eq!(make(folder.path(), true), first);
}

#[test]
fn the_brokers_users_are_those_of_its_access_list_with_hashes_only() {
    for with_mosquitto in [true, false] {
        let folder = tempfile::tempdir().unwrap();
        let files = make(folder.path(), with_mosquitto);
        let users =
            |name: &str| -> Vec<&str> { files[name].lines().map(|line| line.split(':').next().unwrap()).collect() };
        assert_eq!(users("mosquitto_passwords"), ["example/crawler-1", "example/crawler-2"]);
        assert_eq!(users("mosquitto_supervisor_passwords"), ["vibrissa"]);
        let passwords = [files["mosquitto_passwords"].as_str(), &files["mosquitto_supervisor_passwords"]].concat();
        for line in passwords.lines() {
            let parts: Vec<&str> = line.split('$').collect();
            assert_eq!((parts.len(), parts[1], parts[2]), (5, "7", "101"), "{line}");
            // Lengths of 12 and 64 bytes in base 64.
            assert_eq!((parts[3].len(), parts[4].len()), (16, 88), "{line}");
        }
        for name in ["supervisor_mqtt_password", "robots_mqtt_password"] {
            assert!(!passwords.contains(files[name].trim_end()), "{name} is readable");
        }
    }
}

#[test]
fn only_who_reads_a_password_can() {
    let folder = tempfile::tempdir().unwrap();
    make(folder.path(), true);
    assert_eq!(folder.path().metadata().unwrap().mode() & 0o777, 0o700);
    let owners = [
        ("grafana_postgres_password", 472),
        ("mosquitto_acl", 1883),
        ("mosquitto_passwords", 1883),
        ("mosquitto_supervisor_passwords", 1883),
        ("postgres_grafana_password", 999),
        ("postgres_password", 999),
        ("postgres_supervisor_password", 999),
        ("supervisor_postgres_password", 10001),
        ("supervisor_mqtt_password", 10001),
    ];
    for (name, owner) in owners {
        let file = folder.path().join(name).metadata().unwrap();
        // The script keeps the folder's ownership of the user who runs it.
        if folder.path().metadata().unwrap().uid() == 0 {
            assert_eq!((file.uid(), file.mode() & 0o777), (owner, 0o600), "{name}");
        } else {
            assert_eq!(file.mode() & 0o777, 0o444, "{name}");
        }
    }
}
