//! The mail server for people, who get events as webhooks do.

use std::time::Duration;

use url::Url;
use vibrissa_edge::guidance::RUNBOOKS;
use vibrissa_protocol::plain;
use vibrissa_supervisor::webhooks::{Encryption, MailOptions, mail_sender};

use super::keys::Key;
use super::reader::Reader;

/// Keys that have an effect only with a mail server.
const KEYS: [Key; 3] = [Key::MailSender, Key::MailUsername, Key::MailPasswordFile];

/// The mail server, if configured; outer `None` after a refusal.
#[expect(clippy::option_option, reason = "outer: None after a refusal; inner: None if not configured")]
pub(super) fn mail(reader: &mut Reader) -> Option<Option<MailOptions>> {
    let is_set = reader.is_explicit(Key::MailUrl);
    let server = reader.parsed(Key::MailUrl, server);
    let sender = reader.parsed(Key::MailSender, |text| mail_sender(text).map(|_| text.to_owned()));
    let (username, password) = (reader.text(Key::MailUsername), reader.secret_file(Key::MailPasswordFile));
    let (gather_s, per_hour_max) = (reader.whole(Key::MailGatherS), reader.whole(Key::MailPerHourMax));
    if !is_set {
        for key in KEYS {
            if reader.is_explicit(key) {
                reader.refuse(key, "has no effect without mail.url");
            }
        }
        return Some(None);
    }
    if !reader.is_explicit(Key::MailSender) {
        reader.refuse(Key::MailUrl, "needs a sender: set mail.sender");
    }
    let keys = [Key::MailUsername, Key::MailPasswordFile];
    for (key, other) in [(keys[0], keys[1]), (keys[1], keys[0])] {
        if reader.is_explicit(key) && !reader.is_explicit(other) {
            reader.refuse(key, format!("has no effect alone: set {other} too"));
        }
    }
    let Server { host, port, encryption } = server?;
    if encryption == Encryption::None && reader.is_explicit(Key::MailPasswordFile) {
        let what = "must begin with smtps:// or starttls://: anybody could read the password";
        reader.refuse(Key::MailUrl, what);
    }
    // `http` refuses a wrong address.
    let set = |reader: &mut Reader, key: Key| if reader.is_explicit(key) { reader.text(key) } else { None };
    let short = |url: String| url.trim_end_matches('/').to_owned();
    let console_url = set(reader, Key::HttpPublicUrl).map(short);
    let runbooks_url = set(reader, Key::HttpRunbooksUrl).map(short);
    let runbooks_url = runbooks_url.or_else(|| console_url.as_ref().map(|url| format!("{url}{RUNBOOKS}")));
    Some(Some(MailOptions {
        host,
        port,
        encryption,
        credentials: username.zip(password),
        sender: sender?,
        gather: Duration::from_secs(gather_s?.into()),
        pause: Duration::from_secs(3600) / per_hour_max?,
        console_url,
        runbooks_url,
    }))
}

/// A mail server.
#[derive(Debug, PartialEq)]
struct Server {
    host: String,
    port: Option<u16>,
    encryption: Encryption,
}

/// Reads `smtps://HOST`, `starttls://HOST` or `smtp://HOST`, each with or without a port.
fn server(text: &str) -> Result<Server, String> {
    let example = "write smtps://HOST, starttls://HOST or smtp://HOST";
    let url = Url::parse(text)
        .map_err(|problem| format!("is not a URL ({}): {example}", plain::url(&problem.to_string())))?;
    let encryption = match url.scheme() {
        "smtps" => Encryption::Tls,
        "starttls" => Encryption::StartTls,
        "smtp" => Encryption::None,
        _ => return Err(format!("must begin with smtps://, starttls:// or smtp://: {example}")),
    };
    if !url.username().is_empty() || url.password().is_some() {
        return Err("must not hold a password: set mail.username and mail.password_file instead".to_owned());
    }
    let host = url.host_str().filter(|host| !host.is_empty()).ok_or_else(|| format!("must name a host: {example}"))?;
    if !matches!(url.path(), "" | "/") || url.query().is_some() || url.fragment().is_some() {
        return Err(format!("must end with the host or the port: {example}"));
    }
    Ok(Server { host: host.trim_matches(['[', ']']).to_owned(), port: url.port(), encryption })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_url_names_encryption_host_and_port() {
        let read = |host: &str, port, encryption| Ok(Server { host: host.to_owned(), port, encryption });
        assert_eq!(server("smtps://mail.example"), read("mail.example", None, Encryption::Tls));
        assert_eq!(server("starttls://mail.example:2587/"), read("mail.example", Some(2587), Encryption::StartTls));
        assert_eq!(server("smtp://127.0.0.1:2525"), read("127.0.0.1", Some(2525), Encryption::None));
        assert_eq!(server("smtps://[::1]"), read("::1", None, Encryption::Tls));
        for (bad, expected) in [
            ("mail.example", "is not a URL"),
            ("mail.example:25", "must begin with"),
            ("https://mail.example", "must begin with"),
            ("smtps://", "must name a host"),
            ("smtps://u:hunter2@mail.example", "mail.password_file"),
            ("smtps://mail.example/x", "must end with"),
            ("smtps://mail.example?tls=required", "must end with"),
        ] {
            let problem = server(bad).unwrap_err();
            assert!(problem.contains(expected) && !problem.contains("hunter2"), "{bad}: {problem}");
        }
    }
}
