//! URL of PostgreSQL servers: `postgres://USER@HOST1:PORT1,HOST2:PORT2/DATABASE?PARAMETERS`, as libpq writes it.
//!
//! sqlx reads URLs with one host. A URL with several becomes one URL for each host, with the same user, database and
//! parameters.

use std::borrow::Cow;
use std::time::Duration;

use sqlx::postgres::PgConnectOptions;
use url::Url;
use url::form_urlencoded::{Serializer, parse};
use vibrissa_protocol::plain;

/// Most servers that a URL may name.
pub(super) const SERVERS_MAX: usize = 16;
/// Time limit for one of several servers to accept a connection, if the URL states none: all must be tried within the
/// time to live of a lease.
const ONE_OF_SEVERAL: Duration = Duration::from_secs(1);
/// Time limit for the only server.
const THE_ONLY: Duration = Duration::from_secs(10);
/// Longest time limit that a URL may state.
const CONNECT_TIMEOUT_MAX_S: u64 = 60;

/// The servers of a URL, in its order.
pub(super) struct Servers {
    /// Options of a connection to each server.
    pub(super) options: Vec<PgConnectOptions>,
    /// Time limit for one server to accept a connection.
    pub(super) connect_timeout: Duration,
}

/// The parts of a PostgreSQL URL. The borrowed text is in percent encoding.
struct Parts<'a> {
    scheme: &'a str,
    /// User and password with the `@`, or nothing.
    user: &'a str,
    /// Hosts with their ports, separated by commas.
    hosts: &'a str,
    /// Path of the database, from its slash on.
    path: &'a str,
    /// Parameters without the question mark.
    query: &'a str,
}

impl<'a> Parts<'a> {
    fn of(text: &'a str) -> Option<Self> {
        let (scheme, rest) = text.split_once("://")?;
        let (authority, rest) = rest.split_at(rest.find(['/', '?', '#']).unwrap_or(rest.len()));
        let (user, hosts) = authority.split_at(authority.rfind('@').map_or(0, |at| at + 1));
        let rest = rest.split('#').next().unwrap_or_default();
        let (path, query) = rest.split_once('?').unwrap_or((rest, ""));
        Some(Self { scheme, user, hosts, path, query })
    }

    /// The URL with one host instead of all.
    fn with_host(&self, host: &str, query: &str) -> String {
        let Self { scheme, user, path, .. } = self;
        let mark = if query.is_empty() { "" } else { "?" };
        format!("{scheme}://{user}{host}{path}{mark}{query}")
    }
}

/// The URL of the first server, which has the user, password, database and parameters of all; `None` if the text is no
/// URL.
#[must_use]
pub fn url_of_first(text: &str) -> Option<Url> {
    let single = Parts::of(text).filter(|parts| parts.hosts.contains(',')).map(|parts| {
        let first = parts.hosts.split(',').next().unwrap_or_default();
        parts.with_host(first, parts.query)
    });
    Url::parse(single.as_deref().unwrap_or(text)).ok()
}

/// A URL of one server as text, with the hosts of another text that names several.
#[must_use]
pub fn with_hosts_of(url: &Url, text: &str) -> String {
    match (Parts::of(text), Parts::of(url.as_str())) {
        (Some(several), Some(one)) if several.hosts.contains(',') => one.with_host(several.hosts, one.query),
        _ => url.to_string(),
    }
}

/// Reads the servers of a URL.
///
/// # Errors
/// The text is not a valid URL of PostgreSQL servers. The error quotes no part of it, because it may hold a password.
pub(super) fn servers(text: &str) -> Result<Servers, String> {
    let parts = Parts::of(text).ok_or("after the scheme comes ://")?;
    let mut lists = Lists::default();
    let mut connect_timeout = None;
    let (mut database, mut others, mut seen) = (None, Serializer::new(String::new()), Vec::new());
    for (name, value) in parse(parts.query.as_bytes()) {
        let is_repeatable = name == "options" || name.starts_with("options[");
        if !is_repeatable && seen.contains(&name) {
            return Err("a parameter is there twice".to_owned());
        }
        seen.push(name.clone());
        match &*name {
            "host" => lists.hosts = Some(value),
            "hostaddr" => lists.addresses = Some(value),
            "port" => lists.ports = Some(value),
            "connect_timeout" => connect_timeout = Some(timeout(&value)?),
            "target_session_attrs" => accepts_writes(&value)?,
            _ => {
                if name == "dbname" && !value.is_empty() {
                    database = Some(());
                }
                others.append_pair(&name, &value);
            }
        }
    }
    if parts.path.trim_matches('/').is_empty() && database.is_none() {
        return Err("the name of the database is missing".to_owned());
    }
    let others = others.finish();
    let hosts = lists.hosts(parts.hosts)?;
    if hosts.len() > SERVERS_MAX {
        return Err(format!("it names more than {SERVERS_MAX} servers"));
    }
    let of = |host: &Host| one(&parts.with_host(&host.written(), &others), host.port);
    let options = hosts.iter().map(of).collect::<Result<Vec<_>, _>>()?;
    let default = if hosts.len() > 1 { ONE_OF_SEVERAL } else { THE_ONLY };
    Ok(Servers { options, connect_timeout: connect_timeout.unwrap_or(default) })
}

/// A host, as it is written in a URL.
struct Host {
    /// Empty for the default.
    name: String,
    port: Option<u16>,
}

impl Host {
    fn written(&self) -> String {
        match self.port {
            Some(port) if !self.name.is_empty() => format!("{}:{port}", self.name),
            Some(_) | None => self.name.clone(),
        }
    }
}

/// Options for a URL with one host.
fn one(text: &str, port: Option<u16>) -> Result<PgConnectOptions, String> {
    let url = Url::parse(text).map_err(|problem| plain::url(&problem.to_string()))?;
    let host = url.host_str().unwrap_or_default();
    if is_beyond_ascii(host) {
        return Err("a host name is in ASCII, an international one in Punycode: xn--...".to_owned());
    }
    let options: PgConnectOptions =
        text.parse().map_err(|_| "it has an option that PostgreSQL does not know".to_owned())?;
    let options = port.into_iter().fold(options, PgConnectOptions::port);
    // An IPv6 address is in brackets only in a URL.
    let bare = host.strip_prefix('[').and_then(|host| host.strip_suffix(']'));
    Ok(match bare {
        Some(bare) => options.host(bare),
        None => options,
    })
}

/// The parameters that have one value for each server, separated by commas.
#[derive(Default)]
struct Lists<'a> {
    hosts: Option<Cow<'a, str>>,
    addresses: Option<Cow<'a, str>>,
    ports: Option<Cow<'a, str>>,
}

impl Lists<'_> {
    /// Each host with its port. Parameters replace the hosts before the path.
    fn hosts(&self, authority: &str) -> Result<Vec<Host>, String> {
        let mut hosts: Vec<(String, Option<String>)> = match self.addresses.as_ref().or(self.hosts.as_ref()) {
            Some(list) => list.split(',').map(|host| (encoded(host), None)).collect(),
            None => authority.split(',').map(split_port).collect(),
        };
        // A single empty host stands for the default.
        if hosts.len() > 1 && hosts.iter().any(|(host, _)| host.is_empty()) {
            return Err("a host is missing beside a comma".to_owned());
        }
        if let Some(list) = &self.ports {
            let ports: Vec<&str> = list.split(',').collect();
            if ports.len() != 1 && ports.len() != hosts.len() {
                return Err(format!("it has {} ports for {} hosts", ports.len(), hosts.len()));
            }
            for (at, (_, port)) in hosts.iter_mut().enumerate() {
                let stated = ports.get(at).or(ports.first()).copied().unwrap_or_default();
                *port = (!stated.is_empty()).then(|| stated.to_owned());
            }
        }
        hosts.into_iter().map(|(name, text)| Ok(Host { name, port: text.as_deref().map(port).transpose()? })).collect()
    }
}

/// A host and its port, if it has one.
fn split_port(text: &str) -> (String, Option<String>) {
    match text.rsplit_once(':') {
        // The last colon of an address in brackets may be part of it.
        Some((host, port)) if !port.contains(']') => (host.to_owned(), (!port.is_empty()).then(|| port.to_owned())),
        _ => (text.to_owned(), None),
    }
}

fn port(text: &str) -> Result<u16, String> {
    let port = text.trim().parse().ok().filter(|&port| port > 0);
    port.ok_or_else(|| "a port is a number from 1 to 65535".to_owned())
}

/// A host of a parameter as it is written in a URL: a folder of sockets in percent encoding, IPv6 in brackets.
fn encoded(host: &str) -> String {
    let host = host.trim();
    if host.starts_with('/') {
        return url::form_urlencoded::byte_serialize(host.as_bytes()).collect::<String>().replace('+', "%20");
    }
    if host.contains(':') && !host.starts_with('[') { format!("[{host}]") } else { host.to_owned() }
}

fn timeout(text: &str) -> Result<Duration, String> {
    match text.trim().parse() {
        Ok(seconds @ 1..=CONNECT_TIMEOUT_MAX_S) => Ok(Duration::from_secs(seconds)),
        _ => Err(format!("connect_timeout is a number of seconds from 1 to {CONNECT_TIMEOUT_MAX_S}")),
    }
}

/// A supervisor writes, so the words for other servers are refused.
fn accepts_writes(text: &str) -> Result<(), String> {
    match text {
        "read-write" | "primary" => Ok(()),
        _ => Err("target_session_attrs is read-write or primary: a supervisor writes".to_owned()),
    }
}

/// Whether a host of a URL, whose other characters are in percent encoding, has a character beyond ASCII.
fn is_beyond_ascii(host: &str) -> bool {
    host.split('%')
        .skip(1)
        .any(|code| code.starts_with(['8', '9', 'A', 'B', 'C', 'D', 'E', 'F', 'a', 'b', 'c', 'd', 'e', 'f']))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Host or folder, and port, of each server.
    fn read(text: &str) -> Result<Vec<(String, u16)>, String> {
        let of = |one: &PgConnectOptions| {
            let folder = one.get_socket().map(|folder| folder.display().to_string());
            (folder.unwrap_or_else(|| one.get_host().to_owned()), one.get_port())
        };
        servers(text).map(|servers| servers.options.iter().map(of).collect())
    }

    fn are(text: &str, expected: &[(&str, u16)]) {
        let read = read(text).unwrap_or_else(|problem| panic!("{text}: {problem}"));
        let read: Vec<(&str, u16)> = read.iter().map(|(host, port)| (host.as_str(), *port)).collect();
        assert_eq!(read, expected, "{text}");
    }

    #[test]
    fn each_host_has_its_port_or_the_default() {
        are("postgres://u@a:1,b:2,c/d", &[("a", 1), ("b", 2), ("c", 5432)]);
        are("postgresql://a,b/d?target_session_attrs=read-write", &[("a", 5432), ("b", 5432)]);
        are("postgres://a:,b:3/d?target_session_attrs=primary", &[("a", 5432), ("b", 3)]);
        are("postgres://u:p@one:5433/d", &[("one", 5433)]);
    }

    #[test]
    fn ipv6_addresses_are_in_brackets_in_the_authority_and_bare_in_parameters() {
        are("postgres://u@[::1]:1,[fe80::2],10.0.0.3:4/d", &[("::1", 1), ("fe80::2", 5432), ("10.0.0.3", 4)]);
        are("postgres://u@/d?host=::1,[::2]&port=7,8", &[("::1", 7), ("::2", 8)]);
        are("postgres:///d?hostaddr=::1,10.0.0.2&host=a,b", &[("::1", 5432), ("10.0.0.2", 5432)]);
    }

    #[test]
    fn sockets_are_folders_in_percent_encoding_or_in_the_parameter() {
        are("postgres://%2Frun%2Fone,b:2/d", &[("/run/one", 5432), ("b", 2)]);
        are("postgres://u@/d?host=/run/one,/run/the%20other&port=1,2", &[("/run/one", 1), ("/run/the other", 2)]);
    }

    #[test]
    fn ports_of_the_parameter_are_one_for_all_or_one_for_each() {
        are("postgres:///d?host=a,b,c&port=7", &[("a", 7), ("b", 7), ("c", 7)]);
        assert_eq!(read("postgres:///d?port=7").unwrap()[0].1, 7);
        are("postgres:///d?host=a,b,c&port=7,,9", &[("a", 7), ("b", 5432), ("c", 9)]);
        are("postgres://a:1,b:2/d?port=9", &[("a", 9), ("b", 9)]);
        assert_eq!(read("postgres:///d?host=a,b,c&port=7,8").unwrap_err(), "it has 2 ports for 3 hosts");
    }

    #[test]
    fn user_password_database_and_options_are_those_of_every_server() {
        let text =
            "postgres://u%40x:p%2C%3A%2F@a:1,b:2/d%20d?sslmode=verify-full&application_name=x%26y&connect_timeout=7";
        let Servers { options, connect_timeout } = servers(text).unwrap();
        assert_eq!((options.len(), connect_timeout), (2, Duration::from_secs(7)));
        for one in &options {
            assert_eq!((one.get_username(), one.get_database()), ("u@x", Some("d d")));
            assert_eq!(one.get_application_name(), Some("x&y"));
            assert!(matches!(one.get_ssl_mode(), sqlx::postgres::PgSslMode::VerifyFull));
            assert!(format!("{one:?}").contains("p,:/"), "the password is decoded");
        }
        // A comma and an at sign of the password do not end it.
        are("postgres://u:p,q@r@a,b/d", &[("a", 5432), ("b", 5432)]);
    }

    #[test]
    fn a_parameter_is_there_once_and_options_add_up() {
        for name in ["host=a", "port=1", "target_session_attrs=primary", "sslmode=require", "connect_timeout=3"] {
            let twice = format!("postgres://h/d?{name}&{name}");
            assert_eq!(read(&twice).unwrap_err(), "a parameter is there twice", "{twice}");
        }
        are("postgres://h/d?options=-c%20a%3D1&options=-c%20b%3D2", &[("h", 5432)]);
    }

    #[test]
    fn what_is_wrong_is_refused_with_what_to_write() {
        let many = vec!["h"; SERVERS_MAX + 1].join(",");
        for (text, expected) in [
            ("postgres://a,,b/d", "a host is missing"),
            ("postgres://a,/d", "a host is missing"),
            ("postgres:///d?host=a,", "a host is missing"),
            ("postgres://a:0,b/d", "from 1 to 65535"),
            ("postgres://a:1,b:x/d", "from 1 to 65535"),
            ("postgres://a:1,b:70000/d", "from 1 to 65535"),
            ("postgres://a,b", "the database is missing"),
            ("postgres://a,b/?sslmode=require", "the database is missing"),
            ("postgres://a,b/d?target_session_attrs=any", "read-write or primary"),
            ("postgres://a,b/d?target_session_attrs=standby", "read-write or primary"),
            ("postgres://a,b/d?connect_timeout=0", "from 1 to 60"),
            ("postgres://a,b/d?sslmode=perhaps", "does not know"),
            ("postgres://a,b\u{fc}cher.example/d", "Punycode"),
            (&format!("postgres://{many}/d"), "more than 16 servers"),
        ] {
            let problem = read(text).unwrap_err();
            assert!(problem.contains(expected), "{text}: {problem}");
        }
    }

    #[test]
    fn the_url_of_the_first_server_has_what_all_share() {
        let text = "postgres://u:p@a:1,b:2/d?sslkey=k";
        let mut url = url_of_first(text).unwrap();
        assert_eq!((url.host_str(), url.port(), url.password()), (Some("a"), Some(1), Some("p")));
        url.set_password(Some("***")).unwrap();
        assert_eq!(with_hosts_of(&url, text), "postgres://u:***@a:1,b:2/d?sslkey=k");
        let single = "postgres://u@h/d";
        assert_eq!(with_hosts_of(&url_of_first(single).unwrap(), single), single);
    }
}
