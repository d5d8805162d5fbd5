//! The configuration of the mail server, and addresses of people.

use std::time::Duration;

use lettre::Address;
use lettre::message::Mailbox;
use vibrissa_store::secret::Secret;
use vibrissa_store::webhooks::MAIL;

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
    // The library allows any character in a domain, such as the question mark before a subject.
    let is_host = |host: &str| host.chars().all(|one| one.is_alphanumeric() || "-.[]:".contains(one));
    address.filter(|address| is_host(address.domain())).map(|address| format!("{MAIL}{address}")).ok_or_else(|| {
        "must have one address after mailto:, without a subject or other fields: write mailto:NAME@HOST".to_owned()
    })
}

impl MailOptions {
    /// Host of the sender, for identifiers of mails.
    pub(super) fn domain(&self) -> String {
        sender(&self.sender).map_or_else(|_| "localhost".to_owned(), |sender| sender.email.domain().to_owned())
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
