//! Address of the database: an SQLite file, or one PostgreSQL server or several of which one accepts writes.

mod servers;

use std::ops::Deref;
use std::path::PathBuf;
use std::time::Duration;

use sqlx::postgres::{PgConnectOptions, PgSslMode};

use crate::secret::Secret;

pub use servers::{url_of_first, with_hosts_of};

/// Address of the database.
#[derive(Clone)]
pub enum DatabaseAddress {
    /// An SQLite file, for one supervisor.
    Sqlite(PathBuf),
    /// A PostgreSQL server, which several supervisors may share.
    Postgres(PostgresAddress),
}

/// Addresses of PostgreSQL servers with the same database, with user and password. Dereferences to the options of the
/// first server.
#[derive(Clone)]
pub struct PostgresAddress {
    /// At least one.
    servers: Vec<PgConnectOptions>,
    connect_timeout: Duration,
    /// Password that replaces the one of the URL.
    password: Option<Secret>,
}

impl PostgresAddress {
    /// The same servers with a password that may come from a file.
    #[must_use]
    pub fn with_password(self, password: Secret) -> Self {
        let with = |server: PgConnectOptions| server.password(password.reveal());
        Self { servers: self.servers.into_iter().map(with).collect(), password: Some(password.clone()), ..self }
    }

    /// A server that no connection can be opened to.
    pub(super) fn nowhere() -> Self {
        let server = PgConnectOptions::new_without_pgpass().socket("/dev/null");
        Self { servers: vec![server], connect_timeout: Duration::ZERO, password: None }
    }

    /// The same servers with an application name, which PostgreSQL shows in its list of sessions.
    pub(super) fn named(self, application: &str) -> Self {
        // PgBouncer refuses the startup parameter `extra_float_digits`. PostgreSQL's default is exact, too.
        let with = |server: PgConnectOptions| server.application_name(application).extra_float_digits(None);
        Self { servers: self.servers.into_iter().map(with).collect(), ..self }
    }

    /// The same servers with the current password of the file. If the file is unusable, the password read before stays
    /// in use; if that one is wrong, the server reports it.
    pub(super) fn with_password_read_again(&self) -> Self {
        let renewed = self.password.as_ref().and_then(|password| password.read_again().ok());
        renewed.map_or_else(|| self.clone(), |password| self.clone().with_password(password))
    }

    /// Options of a connection to each server, in the order of the URL.
    pub(super) fn servers(&self) -> &[PgConnectOptions] {
        &self.servers
    }

    /// Time limit for one server to accept a connection.
    pub(super) fn connect_timeout(&self) -> Duration {
        self.connect_timeout
    }
}

/// Host and port of a server, or the folder of its socket, for people.
pub(super) fn place(server: &PgConnectOptions) -> String {
    let (host, port) = (server.get_host(), server.get_port());
    match server.get_socket() {
        Some(folder) => format!("{}:{port}", folder.display()),
        None if host.contains(':') => format!("[{host}]:{port}"),
        None => format!("{host}:{port}"),
    }
}

fn places(servers: &[PgConnectOptions]) -> String {
    servers.iter().map(place).collect::<Vec<_>>().join(",")
}

impl std::fmt::Debug for PostgresAddress {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "PostgresAddress({})", places(&self.servers))
    }
}

impl Deref for PostgresAddress {
    type Target = PgConnectOptions;

    #[expect(clippy::indexing_slicing, reason = "there is at least one server")]
    fn deref(&self) -> &PgConnectOptions {
        &self.servers[0]
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
        let scheme = text.split_once(':').map_or("", |(scheme, _)| scheme);
        if !matches!(scheme, "postgres" | "postgresql") {
            return Err(bad("it begins with neither sqlite: nor postgres:"));
        }
        let servers::Servers { options, connect_timeout } = servers::servers(text).map_err(BadDatabaseUrl)?;
        Ok(Self::Postgres(PostgresAddress { servers: options, connect_timeout, password: None }))
    }
}

impl std::fmt::Display for DatabaseAddress {
    /// Without the password.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Sqlite(path) => write!(f, "sqlite:{}", path.display()),
            Self::Postgres(options) => write!(
                f,
                "postgres://{}@{}/{}",
                options.get_username(),
                places(options.servers()),
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
    /// Whether an attacker on the network could read the traffic to a server or impersonate it: the server is on
    /// another host and its certificate is not verified.
    #[must_use]
    pub fn is_exposed(&self) -> bool {
        match self {
            Self::Sqlite(_) => false,
            Self::Postgres(address) => address.servers().iter().any(|server| {
                let is_here = server.get_socket().is_some()
                    || matches!(server.get_host(), "localhost" | "127.0.0.1" | "::1")
                    || server.get_host().starts_with('/');
                !is_here && !matches!(server.get_ssl_mode(), PgSslMode::VerifyFull | PgSslMode::VerifyCa)
            }),
        }
    }

    /// Whether the URL names several servers, of which one accepts writes.
    #[must_use]
    pub fn has_several_servers(&self) -> bool {
        match self {
            Self::Sqlite(_) => false,
            Self::Postgres(address) => address.servers().len() > 1,
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
        assert!(!is_exposed("postgres://u@[::1]/d") && is_exposed("postgres://u@127.0.0.1,db/d"));
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
        assert_eq!(shown("postgres://u:secret@h,[::1]:2/d").unwrap(), "postgres://u@h:5432,[::1]:2/d");
        for bad in [
            "",
            "sqlite:",
            "h:5432",
            "mysql://u:secret@h/d",
            "postgres://u:secret@h",
            "postgres://u:secret@h:x/d",
            "postgres://u:secret@h,:x/d",
        ] {
            let problem = shown(bad).unwrap_err().to_string();
            assert!(!problem.contains("secret"), "{problem}");
        }
    }
}
