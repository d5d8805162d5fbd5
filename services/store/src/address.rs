//! Address of the database: an SQLite file or a PostgreSQL server.

use std::ops::Deref;
use std::path::PathBuf;

use sqlx::postgres::{PgConnectOptions, PgSslMode};

use crate::secret::Secret;

/// Address of the database.
#[derive(Clone)]
pub enum DatabaseAddress {
    /// An SQLite file, for one supervisor.
    Sqlite(PathBuf),
    /// A PostgreSQL server, which several supervisors may share.
    Postgres(PostgresAddress),
}

/// Address of a PostgreSQL server, with user and password.
#[derive(Clone)]
pub struct PostgresAddress {
    options: Box<PgConnectOptions>,
    /// Password that replaces the one of the URL.
    password: Option<Secret>,
}

impl PostgresAddress {
    /// The same server with a password that may come from a file.
    #[must_use]
    pub fn with_password(self, password: Secret) -> Self {
        let options = Box::new(self.options.password(password.reveal()));
        Self { options, password: Some(password) }
    }

    /// The same server with an application name, which PostgreSQL shows in its list of sessions.
    pub(super) fn named(self, application: &str) -> Self {
        Self { options: Box::new(self.options.application_name(application)), ..self }
    }

    /// The same server with the current password of the file. If the file is unusable, the password read before stays
    /// in use; if that one is wrong, the server reports it.
    pub(super) fn with_password_read_again(&self) -> Self {
        let renewed = self.password.as_ref().and_then(|password| password.read_again().ok());
        renewed.map_or_else(|| self.clone(), |password| self.clone().with_password(password))
    }
}

impl std::fmt::Debug for PostgresAddress {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "PostgresAddress({}:{})", self.get_host(), self.get_port())
    }
}

impl Deref for PostgresAddress {
    type Target = PgConnectOptions;

    fn deref(&self) -> &PgConnectOptions {
        &self.options
    }
}

/// The text is not the address of a database.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("not an address of a database ({0}): write sqlite:FILE or postgres://USER@HOST:5432/DATABASE")]
pub struct BadDatabaseUrl(String);

impl std::str::FromStr for DatabaseAddress {
    type Err = BadDatabaseUrl;

    /// The text may hold a password: the error quotes no part of it.
    fn from_str(text: &str) -> Result<Self, BadDatabaseUrl> {
        let bad = |why: &str| BadDatabaseUrl(why.to_owned());
        if let Some(path) = text.strip_prefix("sqlite:") {
            let path = path.strip_prefix("//").unwrap_or(path);
            return if path.is_empty() {
                Err(bad("the file is missing"))
            } else {
                Ok(Self::Sqlite(PathBuf::from(path)))
            };
        }
        let url = url::Url::parse(text).map_err(|problem| bad(&problem.to_string()))?;
        if !matches!(url.scheme(), "postgres" | "postgresql") {
            return Err(bad("it begins with neither sqlite: nor postgres:"));
        }
        if url.path().trim_matches('/').is_empty() {
            return Err(bad("the name of the database is missing"));
        }
        let options: PgConnectOptions =
            text.parse().map_err(|_| bad("it has an option that PostgreSQL does not know"))?;
        if is_beyond_ascii(url.host_str().unwrap_or_default()) {
            return Err(bad("a host name is in ASCII, an international one in Punycode: xn--..."));
        }
        Ok(Self::Postgres(PostgresAddress { options: Box::new(options), password: None }))
    }
}

/// Whether a host of a URL, whose other characters are in percent encoding, has a character beyond ASCII.
fn is_beyond_ascii(host: &str) -> bool {
    host.split('%')
        .skip(1)
        .any(|code| code.starts_with(['8', '9', 'A', 'B', 'C', 'D', 'E', 'F', 'a', 'b', 'c', 'd', 'e', 'f']))
}

impl std::fmt::Display for DatabaseAddress {
    /// Without the password.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Sqlite(path) => write!(f, "sqlite:{}", path.display()),
            Self::Postgres(options) => write!(
                f,
                "postgres://{}@{}:{}/{}",
                options.get_username(),
                options.get_host(),
                options.get_port(),
                options.get_database().unwrap_or_default()
            ),
        }
    }
}

impl std::fmt::Debug for DatabaseAddress {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{self}")
    }
}

impl DatabaseAddress {
    /// Whether an attacker on the network could read the traffic to the server or impersonate it: the server is on
    /// another host and its certificate is not verified.
    #[must_use]
    pub fn is_exposed(&self) -> bool {
        match self {
            Self::Sqlite(_) => false,
            Self::Postgres(options) => {
                let is_here = options.get_socket().is_some()
                    || matches!(options.get_host(), "localhost" | "127.0.0.1" | "::1")
                    || options.get_host().starts_with('/');
                !is_here && !matches!(options.get_ssl_mode(), PgSslMode::VerifyFull | PgSslMode::VerifyCa)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_server_elsewhere_is_exposed_unless_its_certificate_is_verified() {
        let is_exposed = |text: &str| text.parse::<DatabaseAddress>().unwrap().is_exposed();
        assert!(is_exposed("postgres://u@db/d") && is_exposed("postgres://u@db/d?sslmode=require"));
        assert!(!is_exposed("postgres://u@db/d?sslmode=verify-full"));
        assert!(!is_exposed("postgres://u@127.0.0.1/d") && !is_exposed("sqlite:v"));
    }

    #[test]
    fn a_host_that_is_not_in_ascii_is_refused_with_what_to_write() {
        assert!("postgres://u@xn--bcher-kva.example/d".parse::<DatabaseAddress>().is_ok());
        for host in ["b\u{fc}cher.example", "b%C3%BCcher.example"] {
            let refusal = format!("postgres://u@{host}/d").parse::<DatabaseAddress>().unwrap_err();
            assert!(refusal.to_string().contains("Punycode: xn--"), "{refusal}");
        }
    }

    #[test]
    fn an_address_is_a_file_or_a_server_and_keeps_its_password() {
        let shown = |text: &str| text.parse::<DatabaseAddress>().map(|address| address.to_string());
        assert_eq!(shown("sqlite:a/b.sqlite3").unwrap(), "sqlite:a/b.sqlite3");
        assert_eq!(shown("sqlite:///var/b.sqlite3").unwrap(), "sqlite:/var/b.sqlite3");
        assert_eq!(shown("postgres://u:secret@h:5433/d").unwrap(), "postgres://u@h:5433/d");
        for bad in
            ["", "sqlite:", "h:5432", "mysql://u:secret@h/d", "postgres://u:secret@h", "postgres://u:secret@h:x/d"]
        {
            let problem = shown(bad).unwrap_err().to_string();
            assert!(!problem.contains("secret"), "{problem}");
        }
    }
}
