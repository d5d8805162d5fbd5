//! Warnings at the start about files and connections that expose data or control. Each names the setting or file, who has
//! access, and how to close it.

use std::net::IpAddr;
use std::os::unix::fs::MetadataExt;
use std::path::Path;

use vibrissa_program::files::open_file;

use crate::config::{Config, Way};
use crate::mqtt::address;

/// Warnings about everything at a robot that others can read or do; empty if nothing is exposed. `path` is the configuration.
#[must_use]
pub fn exposures(path: &Path, config: &Config) -> Vec<String> {
    let mut found = Vec::new();
    let changed = changed_by_others(path);
    found
        .extend(changed.map(|who| format!("{}: {who} can change it, and so the robot: chmod go-w it", path.display())));
    let broker = &config.broker;
    for (key, file) in [
        ("broker.password_file", broker.password_file.as_deref()),
        ("broker.client_key_file", broker.client.as_ref().map(|client| client.key_file.as_path())),
    ] {
        found.extend(file.and_then(|file| open_file(key, file)));
    }
    let tokens = config.drivers.iter().filter_map(|driver| driver.token_file.as_deref());
    found.extend(tokens.filter_map(|file| open_file("driver.token_file", file)));
    let sockets = config.drivers.iter().map(|driver| ("driver.unix", socket(&driver.way)));
    for (key, file) in [("outbox.file", config.outbox_file.as_deref())].into_iter().chain(sockets) {
        let Some(folder) = file.and_then(Path::parent) else { continue };
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let who = changed_by_others(folder);
        found.extend(who.map(|who| format!("{key}: {who} can replace files in {}: chmod go-w it", folder.display())));
    }
    let far: Vec<String> = broker.nodes().into_iter().filter(|(host, _)| !is_loopback(host)).map(text).collect();
    if broker.tls.is_none() && !far.is_empty() {
        let what = if broker.credentials.is_some() { "the MQTT password, contacts" } else { "contacts" };
        found.push(format!(
            "broker.url: {what} and setpoints go to {} in plain text, where others on the network can read and change them: use \
             mqtts://",
            far.join(", ")
        ));
    }
    found
}

/// Logs each warning.
pub fn warn(path: &Path, config: &Config) {
    exposures(path, config).iter().for_each(|exposure| tracing::warn!("{exposure}"));
}

fn text((host, port): (String, u16)) -> String {
    address(&host, port)
}

/// Whether a host is this machine; an IPv6 address may be in brackets.
pub(crate) fn is_loopback(host: &str) -> bool {
    let host = host.trim_start_matches('[').trim_end_matches(']');
    host == "localhost" || host.parse::<IpAddr>().is_ok_and(|address| address.is_loopback())
}

fn socket(way: &Way) -> Option<&Path> {
    if let Way::Unix(path) = way { Some(path) } else { None }
}

/// The people besides the owner and root that can change a file, or replace the files in a folder.
fn changed_by_others(path: &Path) -> Option<&'static str> {
    let found = std::fs::metadata(path).ok()?;
    // In a sticky folder only the owner of a file can replace it.
    if found.is_dir() && found.mode() & 0o1000 != 0 {
        return None;
    }
    match found.mode() & 0o022 {
        0 => None,
        mode if mode & 0o002 != 0 => Some("everyone on this machine"),
        _ if found.gid() == 0 => None,
        _ => Some("its group"),
    }
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::PermissionsExt;

    use super::*;
    use crate::config::tests::EXAMPLE;

    #[test]
    fn regress_what_a_robot_exposes_is_told_with_what_to_do() {
        let folder = std::env::temp_dir().join(format!("vibrissa-robot-exposure-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let password = folder.join("password");
        std::fs::write(&password, "p".repeat(32)).unwrap();
        let set_mode =
            |path: &Path, mode: u32| std::fs::set_permissions(path, std::fs::Permissions::from_mode(mode)).unwrap();
        let warnings_of = |from: &str, to: &str| {
            let text = EXAMPLE.replacen(from, to, 1);
            exposures(&password, &Config::from_toml_str(&text, &folder).unwrap())
        };
        set_mode(&password, 0o600);
        assert_eq!(warnings_of("x", "x"), [""; 0]);
        for (from, to, expected) in [
            ("mqtt://127.0.0.1", "mqtt://broker", "broker.url: contacts and setpoints go to broker:1883 in plain text"),
            ("mqtt://127.0.0.1", "mqtts://broker", ""),
            ("command = [\"python3\", \"driver.py\"]", "tcp = \"127.0.0.1:5\"\ntoken_file = \"password\"", ""),
        ] {
            let warnings = warnings_of(from, to);
            assert_eq!(warnings.len(), usize::from(!expected.is_empty()), "{warnings:?}");
            assert!(warnings.iter().all(|one| one.starts_with(expected)), "{warnings:?}");
        }
        set_mode(&password, 0o644);
        let readable = warnings_of("[broker]", "[broker]\nusername = \"u\"\npassword_file = \"password\"");
        assert!(readable.len() == 1 && readable[0].contains("everyone on this machine can read"), "{readable:?}");
        set_mode(&password, 0o600);
        set_mode(&folder, 0o777);
        let replaceable = warnings_of("[driver]", "[outbox]\nfile = \"outbox\"\n[driver]");
        assert!(replaceable.len() == 1 && replaceable[0].starts_with("outbox.file: everyone"), "{replaceable:?}");
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
