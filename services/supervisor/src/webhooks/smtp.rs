//! Delivery of one letter to the mail server.

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

use super::letter::Letter;
use super::mail::{Encryption, MailOptions, sender};

/// Time limit of one step of a conversation with the mail server.
const STEP_PATIENCE: Duration = Duration::from_secs(5);

/// Why a mail was not taken: the server's status, if it has answered, and a text.
pub(super) type NotTaken = (Option<u16>, String);

/// Sends a letter; returns the server's status. It blocks its thread.
pub(super) fn send(mail: &MailOptions, letter: &Letter) -> Result<u16, NotTaken> {
    let message = message(mail, letter).map_err(|problem| (None, problem))?;
    let answer = transport(mail).and_then(|transport| transport.send(&message));
    let refused = |problem: Error| (problem.status().map(u16::from), failure(&problem, &mail.host));
    answer.map(|answer| answer.code().into()).map_err(refused)
}

fn message(mail: &MailOptions, letter: &Letter) -> Result<Message, String> {
    let to: Address = letter.to.parse().map_err(|_| format!("{} is no address", letter.to))?;
    let domain = mail.domain();
    let threads: Vec<String> = letter.threads.iter().map(|thread| format!("<{thread}@{domain}>")).collect();
    let mut message = Message::builder()
        .from(sender(&mail.sender)?)
        .to(Mailbox::new(None, to))
        .date(UNIX_EPOCH + Duration::from_micros(wall_clock().0))
        .message_id(Some(format!("<{}@{domain}>", letter.id)))
        .subject(&letter.subject)
        // So that no program answers that its owner is on holiday.
        .raw_header(HeaderValue::new(HeaderName::new_from_ascii_str("Auto-Submitted"), "auto-generated".to_owned()));
    if let Some(first) = threads.first() {
        message = message.in_reply_to(first.clone()).references(threads.join(" "));
    }
    message.header(ContentType::TEXT_PLAIN).body(letter.text.clone()).map_err(|problem| problem.to_string())
}

fn transport(mail: &MailOptions) -> Result<SmtpTransport, Error> {
    let builder = match mail.encryption {
        Encryption::Tls => SmtpTransport::relay(&mail.host)?,
        Encryption::StartTls => SmtpTransport::starttls_relay(&mail.host)?,
        Encryption::None => SmtpTransport::builder_dangerous(&mail.host),
    };
    let builder = mail.port.into_iter().fold(builder, |builder, port| builder.port(port));
    let builder = mail.credentials.iter().fold(builder, |builder, (name, password)| {
        builder.credentials(Credentials::new(name.clone(), password.reveal().to_owned()))
    });
    Ok(builder.hello_name(ClientId::Domain(mail.domain())).timeout(Some(STEP_PATIENCE)).build())
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
