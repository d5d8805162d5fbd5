//! HTTP: listeners, connection limits and access.

use std::net::SocketAddr;

use super::address::web_url;
use super::keys::Key;
use super::reader::Reader;
use vibrissa_supervisor::http::HttpOptions;
use vibrissa_supervisor::http::access::AccessOptions;
use vibrissa_supervisor::http::access::OidcOptions;
use vibrissa_supervisor::http::access::SignInOptions;
use vibrissa_supervisor::http::client_address::Network;
use vibrissa_supervisor::http::server::Limits;

/// Minimum length of a token in a file, in characters.
const TOKEN_CHARS_MIN: usize = 32;

/// The listeners and their connection limits.
pub(super) fn listeners(reader: &mut Reader) -> Option<HttpOptions> {
    let listen = reader.parsed(Key::HttpListen, |text| address(text, "127.0.0.1:8080"));
    let is_monitored = reader.is_explicit(Key::HttpMonitoringListen);
    let monitoring_listen = reader.parsed(Key::HttpMonitoringListen, |text| address(text, "127.0.0.1:9464"));
    let connections_max = reader.whole(Key::HttpConnectionsMax);
    let connections_per_address_max = reader.whole(Key::HttpConnectionsPerAddressMax);
    if monitoring_listen.is_some_and(|monitoring| Some(monitoring) == listen && monitoring.port() != 0) {
        reader.refuse(Key::HttpMonitoringListen, "must be another address or port than http.listen");
        return None;
    }
    let limits =
        Limits { connections_max: connections_max?, connections_per_address_max: connections_per_address_max? };
    let runbooks_url = runbooks_url(reader)?;
    let base_path = base_path(reader);
    let trusted_proxies = trusted_proxies(reader)?;
    (monitoring_listen.is_some() == is_monitored).then_some(HttpOptions {
        listen: listen?,
        monitoring_listen,
        limits,
        runbooks_url,
        base_path,
        trusted_proxies,
    })
}

fn trusted_proxies(reader: &mut Reader) -> Option<Vec<Network>> {
    let parsed: Result<Vec<Network>, _> =
        reader.texts(Key::HttpTrustedProxies)?.iter().map(|text| text.parse()).collect();
    parsed.map_err(|problem| reader.refuse(Key::HttpTrustedProxies, problem.to_string())).ok()
}

/// Address of the runbooks, if configured; outer `None` after a refusal.
#[expect(clippy::option_option, reason = "outer: None after a refusal; inner: None if not configured")]
fn runbooks_url(reader: &mut Reader) -> Option<Option<String>> {
    if !reader.is_explicit(Key::HttpRunbooksUrl) {
        return Some(None);
    }
    reader.parsed(Key::HttpRunbooksUrl, |text| web_url(text).map(|_| text.to_owned())).map(Some)
}

/// Path of the public address; `sign_in` refuses a wrong address.
fn base_path(reader: &mut Reader) -> String {
    let is_set = reader.is_explicit(Key::HttpPublicUrl);
    let url = if is_set { reader.text(Key::HttpPublicUrl) } else { None };
    url.and_then(|text| web_url(&text).ok()).map_or_else(String::new, |url| url.path().trim_end_matches('/').to_owned())
}

fn address(text: &str, example: &str) -> Result<SocketAddr, String> {
    text.parse().map_err(|_| format!("must be an address and a port such as {example}, not {text:?}"))
}

/// The configured credentials.
pub(super) fn access(reader: &mut Reader) -> Option<AccessOptions> {
    let is_filed = reader.is_explicit(Key::HttpTokenFile);
    let token = reader.secret_file(Key::HttpTokenFile);
    if token.as_ref().is_some_and(|token| token.reveal().chars().count() < TOKEN_CHARS_MIN) {
        reader.refuse(Key::HttpTokenFile, format!("must hold a token of at least {TOKEN_CHARS_MIN} characters"));
        return None;
    }
    let oidc = oidc(reader)?;
    (token.is_some() == is_filed).then_some(AccessOptions { token, oidc })
}

/// The identity provider, if configured; outer `None` after a refusal.
#[expect(clippy::option_option, reason = "outer: None after a refusal; inner: None if not configured")]
fn oidc(reader: &mut Reader) -> Option<Option<OidcOptions>> {
    let [issuer, jwks_url] = [Key::HttpOidcIssuer, Key::HttpOidcJwksUrl].map(|key| {
        let is_set = reader.is_explicit(key);
        (is_set, reader.parsed(key, secure_url))
    });
    let audience = reader.text(Key::HttpOidcAudience);
    let sign_in = sign_in(reader);
    let (role_claim, fleets_claim) = (reader.text(Key::HttpOidcRoleClaim)?, reader.text(Key::HttpOidcFleetsClaim)?);
    if !issuer.0 {
        for key in [Key::HttpOidcAudience, Key::HttpOidcJwksUrl, Key::HttpOidcClientId] {
            if reader.is_explicit(key) {
                reader.refuse(key, "has no effect without http.oidc_issuer");
            }
        }
        return Some(None);
    }
    if !cfg!(feature = "oidc") {
        let what = "this program was built without OpenID Connect: build it with --features oidc, or leave the key out";
        reader.refuse(Key::HttpOidcIssuer, what);
        return None;
    }
    if !reader.is_explicit(Key::HttpOidcAudience) {
        reader.refuse(
            Key::HttpOidcIssuer,
            "needs an audience, otherwise every token of this issuer is accepted: set http.oidc_audience",
        );
    }
    if jwks_url.0 && jwks_url.1.is_none() {
        return None;
    }
    let (issuer, jwks_url) = (issuer.1?, jwks_url.1);
    Some(Some(OidcOptions { issuer, audience: audience?, jwks_url, role_claim, fleets_claim, sign_in: sign_in? }))
}

/// How people sign in at the console, if configured; outer `None` after a refusal.
#[expect(clippy::option_option, reason = "outer: None after a refusal; inner: None if not configured")]
fn sign_in(reader: &mut Reader) -> Option<Option<SignInOptions>> {
    let is_secret = reader.is_explicit(Key::HttpOidcClientSecretFile);
    let client_secret = reader.secret_file(Key::HttpOidcClientSecretFile);
    let is_public = reader.is_explicit(Key::HttpPublicUrl);
    let public_url = reader.parsed(Key::HttpPublicUrl, public_url);
    let scopes = reader.texts(Key::HttpOidcScopes);
    if !reader.is_explicit(Key::HttpOidcClientId) {
        if is_secret {
            reader.refuse(Key::HttpOidcClientSecretFile, "has no effect without http.oidc_client_id");
        }
        return Some(None);
    }
    if !is_public {
        let what = "needs the address to which the provider leads browsers back: set http.public_url";
        reader.refuse(Key::HttpOidcClientId, what);
    }
    let (client_id, scopes) = (reader.text(Key::HttpOidcClientId)?, scopes?);
    if let Some(bad) = scopes.iter().find(|scope| !is_scope(scope)) {
        reader.refuse(
            Key::HttpOidcScopes,
            format!("{bad:?} is no scope: one is a word without spaces, quotes and backslashes"),
        );
        return None;
    }
    (client_secret.is_some() == is_secret).then_some(())?;
    Some(Some(SignInOptions { client_id, client_secret, scopes, public_url: public_url? }))
}

/// Whether a text is a scope of OAuth 2 (RFC 6749, section 3.3).
fn is_scope(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_graphic() && !matches!(byte, b'"' | b'\\'))
}

/// An address of the console: HTTPS or this machine, with the path that a proxy gives it.
fn public_url(text: &str) -> Result<String, String> {
    secure_url(text).map_err(|problem| problem.replace("keys sent", "cookies sent").replace("forged", "read"))?;
    let url = web_url(text)?;
    if url.query().is_some() || url.fragment().is_some() || !url.username().is_empty() {
        let what = "must be scheme, host, port and path only, such as https://vibrissa.example or https://hall.example/vibrissa";
        return Err(what.to_owned());
    }
    Ok(text.trim_end_matches('/').to_owned())
}

/// A URL whose answers nobody can forge: HTTPS, or this machine.
fn secure_url(text: &str) -> Result<String, String> {
    let url = web_url(text)?;
    let is_here = match url.host() {
        Some(url::Host::Ipv4(ip)) => ip.is_loopback(),
        Some(url::Host::Ipv6(ip)) => ip.is_loopback(),
        Some(url::Host::Domain(name)) => name == "localhost",
        None => false,
    };
    if url.scheme() == "https" || (url.scheme() == "http" && is_here) {
        // Unchanged, because an issuer is compared exactly.
        Ok(text.to_owned())
    } else {
        Err("must begin with https://: keys sent in plain text could be forged".to_owned())
    }
}
