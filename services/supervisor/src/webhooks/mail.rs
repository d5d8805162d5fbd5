//! Mails to people, over one mail server: its configuration, and the delivery of one letter.

use std::error::Error as _;
use std::time::{Duration, UNIX_EPOCH};

use lettre::message::Mailbox;
use lettre::message::header::{ContentType, HeaderName, HeaderValue};
use lettre::transport::smtp::Error;
use lettre::transport::smtp::authentication::Credentials;
use lettre::transport::smtp::extension::ClientId;
use lettre::{Address, Message, SmtpTransport, Transport as _};
use vibrissa_edge::clock::wall_clock;
use vibrissa_protocol::plain;
use vibrissa_store::secret::Secret;
use vibrissa_store::webhooks::MAIL;

use super::letter::Letter;
use super::sending::AttemptResult;

/// Time limit of one step of a conversation with the mail server.
const STEP_PATIENCE: Duration = Duration::from_secs(5);

/// How the connection to the mail server is encrypted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encryption {
    /// TLS from the first byte.
    Tls,
    /// TLS after STARTTLS, without which no mail is sent.
    StartTls,
    /// None: for a server on this machine.
    None,
}

/// The mail server, and the rules for mails.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MailOptions {
    /// Name or address of the server.
    pub host: String,
    /// Its port; `None` for the usual one: 465 for TLS, 587 for STARTTLS, 25 without encryption.
    pub port: Option<u16>,
    /// How the connection is encrypted.
    pub encryption: Encryption,
    /// User name and password for the server, if it wants them.
    pub credentials: Option<(String, Secret)>,
    /// Sender of the mails: an address, or a name and an address in angle brackets.
    pub sender: String,
    /// Time for which the first event of a mail waits for others.
    pub gather: Duration,
    /// Shortest time between two mails to one address.
    pub pause: Duration,
    /// Address at which browsers reach the console, without a slash at the end; `None` for mails without links to it.
    pub console_url: Option<String>,
    /// Address of the runbooks, without a slash at the end; `None` for mails without links to them.
    pub runbooks_url: Option<String>,
}

/// The sender's address.
///
/// # Errors
/// The text is no address.
pub fn sender(text: &str) -> Result<Mailbox, String> {
    text.parse().map_err(|_| {
        "must be an address such as vibrissa@example.org, or a name and an address: Vibrissa <vibrissa@example.org>"
            .to_owned()
    })
}

/// The URL of a person's address, as it is stored.
///
/// # Errors
/// It is not `mailto:` and one address.
pub(super) fn checked_address(url: &str) -> Result<String, String> {
    let address: Option<Address> = url.get(MAIL.len()..).and_then(|text| text.parse().ok());
    address.map(|address| format!("{MAIL}{address}")).ok_or_else(|| {
        "must have one address after mailto:, without a subject or other fields: write mailto:NAME@HOST".to_owned()
    })
}

impl MailOptions {
    /// Host of the sender, for identifiers of mails.
    fn domain(&self) -> String {
        sender(&self.sender).map_or_else(|_| "localhost".to_owned(), |sender| sender.email.domain().to_owned())
    }

    fn message(&self, letter: &Letter) -> Result<Message, String> {
        let to: Address = letter.to.parse().map_err(|_| format!("{} is no address", letter.to))?;
        let domain = self.domain();
        let threads: Vec<String> = letter.threads.iter().map(|thread| format!("<{thread}@{domain}>")).collect();
        let mut message = Message::builder()
            .from(sender(&self.sender)?)
            .to(Mailbox::new(None, to))
            .date(UNIX_EPOCH + Duration::from_micros(wall_clock().0))
            .message_id(Some(format!("<{}@{domain}>", letter.id)))
            .subject(&letter.subject)
            // So that no program answers that its owner is on holiday.
            .raw_header(HeaderValue::new(
                HeaderName::new_from_ascii_str("Auto-Submitted"),
                "auto-generated".to_owned(),
            ));
        if let Some(first) = threads.first() {
            message = message.in_reply_to(first.clone()).references(threads.join(" "));
        }
        message.header(ContentType::TEXT_PLAIN).body(letter.text.clone()).map_err(|problem| problem.to_string())
    }

    fn transport(&self) -> Result<SmtpTransport, Error> {
        let builder = match self.encryption {
            Encryption::Tls => SmtpTransport::relay(&self.host)?,
            Encryption::StartTls => SmtpTransport::starttls_relay(&self.host)?,
            Encryption::None => SmtpTransport::builder_dangerous(&self.host),
        };
        let builder = self.port.into_iter().fold(builder, |builder, port| builder.port(port));
        let builder = self.credentials.iter().fold(builder, |builder, (name, password)| {
            builder.credentials(Credentials::new(name.clone(), password.reveal().to_owned()))
        });
        Ok(builder.hello_name(ClientId::Domain(self.domain())).timeout(Some(STEP_PATIENCE)).build())
    }

    /// Sends a letter. It blocks its thread.
    pub(super) fn send(&self, letter: &Letter) -> AttemptResult {
        let message = match self.message(letter) {
            Ok(message) => message,
            Err(problem) => return AttemptResult { status: None, failure: Some(problem) },
        };
        match self.transport().and_then(|transport| transport.send(&message)) {
            Ok(answer) => AttemptResult { status: Some(answer.code().into()), failure: None },
            Err(problem) => {
                AttemptResult { status: problem.status().map(u16::from), failure: Some(failure(&problem, &self.host)) }
            }
        }
    }
}

/// Why the mail server has not taken a mail, with what to do.
fn failure(problem: &Error, host: &str) -> String {
    let source = problem.source();
    let said = source.map_or_else(String::new, |source| plain::text(&source.to_string()));
    if let Some(code) = problem.status() {
        return format!("the mail server answered {code}: {said}");
    }
    if problem.is_timeout() {
        return format!("the mail server {host} does not answer in time: check mail.url, the network and firewalls");
    }
    if problem.is_tls() {
        return format!(
            "TLS cannot be used with the mail server {host}: correct mail.url, or its certificate ({said})"
        );
    }
    match source.and_then(|source| source.downcast_ref::<std::io::Error>()) {
        Some(problem) => format!("no connection to the mail server {host}: {}", plain::io(problem)),
        None => format!("the mail server {host} does not take the mail: {said}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_plain_address_is_a_target_and_nothing_that_adds_headers_is() {
        assert_eq!(checked_address("mailto:ann@example.org").as_deref(), Ok("mailto:ann@example.org"));
        for url in [
            "mailto:",
            "mailto:ann",
            "mailto:ann@example.org?subject=x",
            "mailto:ann@example.org,bob@example.org",
            "mailto:ann@example.org%0ABcc:bob@example.org",
            "mailto:ann@example.org\nBcc: bob@example.org",
            "mailto:Ann <ann@example.org>",
        ] {
            assert!(checked_address(url).unwrap_err().contains("one address"), "{url}");
        }
    }
}
