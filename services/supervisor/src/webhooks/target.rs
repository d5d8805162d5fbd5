//! Which URLs and addresses may get events. Without a permission of the configuration these are public addresses only:
//! whoever may set a webhook must not reach the services behind the supervisor's firewall through it.

use std::collections::BTreeSet;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr};
use std::sync::Arc;

use url::{Host, Url};
use vibrissa_protocol::plain;
use vibrissa_store::webhooks::MAIL;

use super::mail::checked_address;

/// Maximum length of a URL, in characters.
pub const URL_CHARS_MAX: usize = 2000;

/// Hosts that may have private addresses.
#[derive(Debug, Clone)]
pub struct Hosts(Arc<BTreeSet<String>>);

impl Hosts {
    /// Host names and addresses as in URLs; upper and lower case are the same.
    #[must_use]
    pub fn new(hosts: &[String]) -> Self {
        let plain = |host: &String| host.trim_matches(['[', ']']).to_ascii_lowercase();
        Self(Arc::new(hosts.iter().map(plain).collect()))
    }

    /// Whether this host may have private addresses.
    #[must_use]
    pub fn allows(&self, host: &str) -> bool {
        self.0.contains(&host.trim_matches(['[', ']']).to_ascii_lowercase())
    }
}

/// The URL of a target, as it is stored.
///
/// # Errors
/// It is neither an address of a person nor a URL of a web server, holds a password, or names a private address that is
/// not allowed.
pub fn checked(text: &str, hosts: &Hosts) -> Result<String, String> {
    if text.chars().count() > URL_CHARS_MAX {
        return Err(format!("must have at most {URL_CHARS_MAX} characters"));
    }
    if text.starts_with(MAIL) {
        return checked_address(text);
    }
    let url = Url::parse(text)
        .map_err(|problem| format!("is not a URL ({}): write https://HOST/PATH", plain::url(&problem.to_string())))?;
    if !matches!(url.scheme(), "http" | "https") {
        return Err("must begin with https://, http:// or mailto:".to_owned());
    }
    if !url.username().is_empty() || url.password().is_some() {
        return Err("must not contain a user name or password: requests are signed instead".to_owned());
    }
    if url.fragment().is_some() {
        return Err("must not contain a fragment (#...): it is not sent".to_owned());
    }
    let address = match url.host() {
        Some(Host::Ipv4(ip)) => Some(IpAddr::V4(ip)),
        Some(Host::Ipv6(ip)) => Some(IpAddr::V6(ip)),
        Some(Host::Domain(_)) | None => None,
    };
    if let Some(address) = address
        && !is_public(address)
        && !hosts.allows(&address.to_string())
    {
        return Err(refusal(&address.to_string()));
    }
    Ok(url.into())
}

/// Why a host is refused, and what to do.
#[must_use]
pub fn refusal(host: &str) -> String {
    format!("{host} is not a public address: add the host to webhooks.allowed_hosts if events may go there")
}

/// Whether an address belongs to the public internet.
#[must_use]
pub fn is_public(address: IpAddr) -> bool {
    match address {
        IpAddr::V4(ip) => is_public_v4(ip),
        IpAddr::V6(ip) => is_public_v6(ip),
    }
}

/// The ranges of IANA's registry of special-purpose addresses are not public.
fn is_public_v4(ip: Ipv4Addr) -> bool {
    let [a, b, c, _] = ip.octets();
    let is_special = ip.is_private()
        || ip.is_loopback()
        || ip.is_link_local()
        || ip.is_documentation()
        || a == 0
        || (a == 100 && (64..128).contains(&b))
        || (a == 192 && b == 0 && c == 0)
        || (a == 192 && b == 88 && c == 99)
        || (a == 198 && (18..20).contains(&b))
        || a >= 224;
    !is_special
}

/// Only global unicast addresses are public; those that contain an IPv4 address only if that one is.
fn is_public_v6(ip: Ipv6Addr) -> bool {
    let parts = ip.segments();
    let embedded = |high: u16, low: u16| {
        let ([a, b], [c, d]) = (high.to_be_bytes(), low.to_be_bytes());
        is_public_v4(Ipv4Addr::new(a, b, c, d))
    };
    match parts {
        [0, 0, 0, 0, 0, 0xffff, high, low] | [0x64, 0xff9b, 0, 0, 0, 0, high, low] => embedded(high, low),
        // 6to4, Teredo, documentation.
        [0x2002, high, low, ..] => embedded(high, low),
        [0x2001, 0 | 0xdb8, ..] | [0x3fff, ..] => false,
        [first, ..] => first & 0xe000 == 0x2000,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_behind_the_firewall_are_not_public_in_any_notation() {
        for address in [
            "127.0.0.1",
            "127.9.9.9",
            "10.0.0.1",
            "172.16.0.1",
            "172.31.255.255",
            "192.168.1.1",
            "169.254.169.254",
            "100.64.0.1",
            "0.0.0.0",
            "255.255.255.255",
            "224.0.0.1",
            "240.0.0.1",
            "192.0.0.1",
            "198.18.0.1",
            "203.0.113.1",
            "::",
            "::1",
            "fc00::1",
            "fd12::1",
            "fe80::1",
            "ff02::1",
            "::ffff:10.0.0.1",
            "::ffff:127.0.0.1",
            "64:ff9b::a00:1",
            "2002:a00:1::1",
            "2001::1",
            "2001:db8::1",
            "::7f00:1",
        ] {
            assert!(!is_public(address.parse().unwrap()), "{address}");
        }
        for address in ["1.1.1.1", "172.32.0.1", "100.128.0.1", "2606:4700::1111", "::ffff:1.1.1.1"] {
            assert!(is_public(address.parse().unwrap()), "{address}");
        }
    }

    #[test]
    fn urls_are_checked_with_every_notation_of_an_address() {
        let (none, some) = (Hosts::new(&[]), Hosts::new(&["127.0.0.1".to_owned(), "[::1]".to_owned()]));
        assert_eq!(checked("https://hooks.example/a?b=c", &none).as_deref(), Ok("https://hooks.example/a?b=c"));
        for text in
            ["http://127.0.0.1/", "http://2130706433/", "http://0x7f.1/", "http://[::1]/", "http://0177.0.0.1:8080/"]
        {
            assert!(checked(text, &none).unwrap_err().contains("webhooks.allowed_hosts"), "{text}");
            assert!(checked(text, &some).is_ok(), "{text}");
        }
        for (text, expected) in [
            ("ftp://h/", "must begin with"),
            ("file:///etc/passwd", "must begin with"),
            ("gopher://h:70/1", "must begin with"),
            ("https://u:hunter2@h/", "must not contain a user name"),
            ("https://h/#a", "fragment"),
            ("hooks", "is not a URL"),
            ("https://", "is not a URL"),
        ] {
            let problem = checked(text, &some).unwrap_err();
            assert!(problem.contains(expected) && !problem.contains("hunter2"), "{text}: {problem}");
        }
        assert!(checked(&format!("https://h/{}", "a".repeat(URL_CHARS_MAX)), &none).is_err());
    }
}
