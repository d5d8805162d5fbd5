//! Warnings at the start about a configuration that exposes data or control. Each names the setting or file, who has
//! access, and how to close it.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use crate::config::{Config, Key};
use vibrissa_program::files::open_file;
use vibrissa_store::DatabaseAddress;

/// Warnings about everything that others can read or do; empty if nothing is exposed. The code that prepares the
/// connections to the broker and the database warns if they are not encrypted.
#[must_use]
pub fn exposures(config: &Config) -> Vec<String> {
    let mut found: Vec<String> = http(config).into_iter().collect();
    for (key, path) in &config.secret_files {
        found.extend(open_file(&key.to_string(), path));
    }
    if let DatabaseAddress::Sqlite(path) = &config.database {
        found.extend(
            ["", "-wal", "-shm"]
                .iter()
                .filter_map(|ending| open_file(&Key::DatabaseUrl.to_string(), &beside(path, ending))),
        );
    }
    found
}

fn http(config: &Config) -> Option<String> {
    let address = config.http.listen;
    if !address.ip().is_loopback() {
        return Some(format!(
            "http.listen: HTTP on {address} is plain text, so others on the network can read data and tokens: listen \
             on 127.0.0.1, and put a proxy with TLS in front"
        ));
    }
    let is_open = config.access.token.is_none() && config.access.oidc.is_none();
    is_open.then(|| {
        format!(
            "HTTP on {address} needs no token, so everyone on this machine has the role ADMIN: set http.token_file or \
             http.oidc_issuer to require one"
        )
    })
}

/// The path with an ending: SQLite names the files that belong to a database like this.
fn beside(path: &Path, ending: &str) -> PathBuf {
    let mut name = OsString::from(path);
    name.push(ending);
    PathBuf::from(name)
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::{MetadataExt, PermissionsExt};

    use super::*;
    use crate::config::{self, Sources};

    /// The warnings for a configuration in TOML.
    fn warnings_of(toml: &str) -> Vec<String> {
        let sources = Sources { file: Some(("/nowhere/v.toml".into(), toml.to_owned())), ..Sources::default() };
        exposures(&config::read(&sources).config.unwrap())
    }

    fn file(name: &str, content: &str) -> PathBuf {
        let path = std::env::temp_dir().join(format!("vibrissa-exposure-{}-{name}", std::process::id()));
        std::fs::write(&path, content).unwrap();
        path
    }

    fn set_mode(path: &Path, mode: u32) {
        std::fs::set_permissions(path, std::fs::Permissions::from_mode(mode)).unwrap();
    }

    #[test]
    fn http_without_a_token_or_beyond_loopback_is_told_with_the_setting() {
        let open = warnings_of("");
        assert!(
            open.len() == 1 && open[0].contains("127.0.0.1:8080") && open[0].contains("http.token_file"),
            "{open:?}"
        );
        let oidc = "http.oidc_issuer = \"https://i.example\"\nhttp.oidc_audience = \"a\"\n";
        assert_eq!(warnings_of(oidc), [""; 0]);
        for address in ["0.0.0.0:8080", "[::]:8080", "192.0.2.1:80"] {
            let exposed = warnings_of(&format!("{oidc}http.listen = {address:?}"));
            assert!(exposed.len() == 1 && exposed[0].starts_with("http.listen: "), "{exposed:?}");
            assert!(exposed[0].contains(address) && exposed[0].contains("TLS"), "{exposed:?}");
        }
    }

    #[test]
    fn a_file_that_others_can_read_is_told_with_what_to_do() {
        let token = file("token", &"t".repeat(32));
        let toml = format!("http.token_file = {:?}", token.display().to_string());
        // Files owned by root may be readable by their group.
        let is_root = std::fs::metadata(&token).unwrap().uid() == 0;
        for (mode, who) in [
            (0o600, None),
            (0o400, None),
            (0o604, Some("everyone on this machine can read ")),
            (0o444, Some("everyone on this machine can read ")),
            (0o666, Some("everyone on this machine can read or change ")),
            (0o640, (!is_root).then_some("its group can read ")),
            (0o620, Some("its group can read or change ")),
        ] {
            set_mode(&token, mode);
            let warnings = warnings_of(&toml);
            match who {
                None => assert_eq!(warnings, [""; 0], "{mode:o}"),
                Some(who) => {
                    let shown = token.display();
                    assert_eq!(
                        warnings,
                        [format!("http.token_file: {who}{shown} (mode {mode:04o}): chmod 600 {shown}")]
                    );
                }
            }
        }
        std::fs::remove_file(token).unwrap();
    }

    #[test]
    fn a_configuration_file_with_a_password_and_every_file_of_a_secret_are_looked_at() {
        let (config, key) = (file("config", ""), file("key", "k"));
        let [shown_config, shown_key] = [&config, &key].map(|path| path.display().to_string());
        let keys = |toml: &str| {
            let sources = Sources { file: Some((config.clone(), toml.to_owned())), ..Sources::default() };
            let files = config::read(&sources).config.unwrap().secret_files;
            files.iter().map(|(key, path)| format!("{key} {}", path.display())).collect::<Vec<_>>()
        };
        for (toml, expected) in [
            (
                "mqtt.url = \"mqtt://h\"\nmqtt.username = \"u\"\nmqtt.password = \"p\"".to_owned(),
                format!("mqtt.password {shown_config}"),
            ),
            ("database.url = \"postgres://u:p@h/d\"".to_owned(), format!("database.url {shown_config}")),
            (
                format!("database.url = \"postgres://u@h/d\"\ndatabase.password_file = {shown_key:?}"),
                format!("database.password_file {shown_key}"),
            ),
            (format!("database.url = \"postgres://u@h/d?sslkey={shown_key}\""), format!("database.url {shown_key}")),
            (
                format!("mqtt.url = \"mqtt://h\"\nmqtt.username = \"u\"\nmqtt.password_file = {shown_key:?}"),
                format!("mqtt.password_file {shown_key}"),
            ),
            (
                format!(
                    "mqtt.url = \"mqtts://h\"\nmqtt.client_certificate_file = {shown_key:?}\nmqtt.client_key_file = {shown_key:?}"
                ),
                format!("mqtt.client_key_file {shown_key}"),
            ),
        ] {
            assert_eq!(keys(&toml), [expected]);
        }
        assert_eq!(keys("database.url = \"postgres://u@h/d\""), [""; 0]);
        for path in [config, key] {
            std::fs::remove_file(path).unwrap();
        }
    }
}
