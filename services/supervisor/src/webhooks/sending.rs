//! Sends a signed request to a target, within limits of time and size. No redirect is followed and no proxy is used,
//! because either would lead past the check of addresses.

use std::fmt::Debug;
use std::sync::Arc;
use std::time::Duration;

use futures_util::future::BoxFuture;
use rustls_native_certs::load_native_certs;
use tokio::time::timeout;
use ureq::Agent;
use ureq::config::Config;
use ureq::http::Uri;
use ureq::tls::{Certificate, RootCerts, TlsConfig};
use ureq::unversioned::resolver::{DefaultResolver, ResolvedSocketAddrs, Resolver};
use ureq::unversioned::transport::{DefaultConnector, NextTimeout};
use vibrissa_host::task;

use super::letter::Letter;
use super::mail::MailOptions;
use super::signature::header;
use super::smtp;
use super::target::{Hosts, is_public, refusal};
use crate::outgoing;
use vibrissa_edge::clock::wall_clock;

/// Time limit of an attempt.
pub const PATIENCE: Duration = Duration::from_secs(10);
/// Time limit for the connection.
const CONNECT_PATIENCE: Duration = Duration::from_secs(5);
/// Size limit of an answer's headers in bytes. Its body is not read.
const HEADER_BYTES_MAX: usize = 16 * 1024;
/// Maximum length of the text about a failure, in characters.
const PROBLEM_CHARS_MAX: usize = 300;

/// A request.
#[derive(Clone)]
pub struct Message {
    /// Where it goes.
    pub url: String,
    /// Identifier: the same at each attempt.
    pub id: String,
    /// JSON of the event.
    pub body: Vec<u8>,
    /// Keys that sign it. Neither logged nor shown.
    pub secrets: Vec<Vec<u8>>,
}

/// Result of an attempt.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AttemptResult {
    /// Status of HTTP or of SMTP; `None` without an answer.
    pub status: Option<u16>,
    /// Why there was no answer, or what a mail server said.
    pub failure: Option<String>,
}

impl AttemptResult {
    /// Why the target has not taken the event; `None` if it has.
    #[must_use]
    pub fn problem(&self) -> Option<String> {
        match (self.status, &self.failure) {
            (Some(200..=299), _) => None,
            (Some(_), Some(failure)) => Some(failure.clone()),
            (Some(status @ 300..=399), _) => Some(format!("answered {status}: redirects are not followed")),
            (Some(status), _) => Some(format!("answered {status}")),
            (None, failure) => Some(failure.clone().unwrap_or_else(|| "no answer".to_owned())),
        }
    }
}

/// A way to the targets: HTTP, or a model in simulated time.
pub trait Post: Debug + Send + Sync {
    /// Sends a request and waits for its answer, for at most [`PATIENCE`].
    fn post(&self, message: Message) -> BoxFuture<'_, AttemptResult>;
}

/// Sends requests. Clones share their connections.
#[derive(Debug, Clone)]
pub struct Sender {
    post: Arc<dyn Post>,
    hosts: Hosts,
    mail: Option<Arc<MailOptions>>,
}

impl Sender {
    /// Sends to public addresses and to these hosts, and mails if there is a mail server.
    #[must_use]
    pub fn new(hosts: Hosts, mail: Option<MailOptions>) -> Self {
        let config = Agent::config_builder()
            .timeout_global(Some(PATIENCE))
            .timeout_connect(Some(CONNECT_PATIENCE))
            .max_redirects(0)
            .max_redirects_will_error(false)
            .http_status_as_error(false)
            .max_response_header_size(HEADER_BYTES_MAX)
            // Each request resolves and checks the host again.
            .max_idle_connections(0)
            .proxy(None)
            .tls_config(TlsConfig::builder().root_certs(roots()).build())
            .user_agent(concat!("vibrissa/", env!("CARGO_PKG_VERSION")))
            .build();
        let resolver = Guard { hosts: hosts.clone(), resolver: DefaultResolver::default() };
        let agent = Agent::with_parts(config, DefaultConnector::default(), resolver);
        Self { post: Arc::new(Http(agent)), hosts, mail: mail.map(Arc::new) }
    }

    /// Sends another way.
    #[must_use]
    pub fn over(post: Arc<dyn Post>) -> Self {
        Self { post, hosts: Hosts::new(&[]), mail: None }
    }

    /// The hosts that may have private addresses.
    #[must_use]
    pub fn hosts(&self) -> &Hosts {
        &self.hosts
    }

    /// The mail server, if there is one.
    #[must_use]
    pub fn mail(&self) -> Option<&MailOptions> {
        self.mail.as_deref()
    }

    /// Sends the mail that `letter` writes, in a thread of its own, and waits for the mail server's answer.
    pub async fn send_mail(&self, letter: impl FnOnce(&MailOptions) -> Letter) -> AttemptResult {
        let failed = |why: &str| AttemptResult { status: None, failure: Some(why.to_owned()) };
        let Some(mail) = self.mail.clone() else {
            return failed("there is no mail server: set mail.url");
        };
        let letter = letter(&mail);
        let sent = timeout(PATIENCE, task::blocking(move || smtp::send(&mail, &letter))).await;
        let mut answer = match sent {
            Ok(Ok(Ok(status))) => AttemptResult { status: Some(status), failure: None },
            Ok(Ok(Err((status, problem)))) => AttemptResult { status, failure: Some(problem) },
            Ok(Err(problem)) => failed(&problem.to_string()),
            Err(_) => failed("the mail server does not answer in time: check mail.url, the network and firewalls"),
        };
        answer.failure = answer.failure.map(|text| shortened(&text));
        answer
    }

    /// Sends a request and waits for its answer.
    pub async fn send(&self, message: Message) -> AttemptResult {
        self.post.post(message).await
    }
}

/// HTTP, in a thread for each request.
#[derive(Debug)]
struct Http(Agent);

impl Post for Http {
    fn post(&self, message: Message) -> BoxFuture<'_, AttemptResult> {
        let agent = self.0.clone();
        Box::pin(async move {
            let sent = task::blocking(move || send(&agent, &message)).await;
            sent.unwrap_or_else(|problem| AttemptResult { status: None, failure: Some(problem.to_string()) })
        })
    }
}

fn send(agent: &Agent, message: &Message) -> AttemptResult {
    let timestamp_s = wall_clock().0 as i64 / 1_000_000;
    let request = agent
        .post(&message.url)
        .header("content-type", "application/json")
        .header("webhook-id", &message.id)
        .header("webhook-timestamp", timestamp_s.to_string())
        .header("webhook-signature", header(&message.secrets, &message.id, timestamp_s, &message.body));
    match request.send(message.body.as_slice()) {
        Ok(answer) => AttemptResult { status: Some(answer.status().as_u16()), failure: None },
        Err(problem) => AttemptResult { status: None, failure: Some(shortened(&outgoing::failure(&problem))) },
    }
}

/// A text about a failure, as it is stored.
fn shortened(text: &str) -> String {
    text.chars().filter(|&one| one != '\0').take(PROBLEM_CHARS_MAX).collect()
}

/// The certificates that this machine trusts; those of browsers if it has none.
fn roots() -> RootCerts {
    let found = load_native_certs().certs;
    if found.is_empty() {
        return RootCerts::WebPki;
    }
    RootCerts::new_with_certs(&found.iter().map(|one| Certificate::from_der(one).to_owned()).collect::<Vec<_>>())
}

/// Resolves a host to addresses that may get requests. The connection goes to one of these addresses, so that a name that
/// resolves differently a second time leads nowhere else.
#[derive(Debug)]
struct Guard {
    hosts: Hosts,
    resolver: DefaultResolver,
}

impl Resolver for Guard {
    fn resolve(&self, uri: &Uri, config: &Config, timeout: NextTimeout) -> Result<ResolvedSocketAddrs, ureq::Error> {
        let found = self.resolver.resolve(uri, config, timeout)?;
        let host = uri.host().unwrap_or_default();
        if self.hosts.allows(host) {
            return Ok(found);
        }
        let mut public = self.empty();
        found.iter().filter(|address| is_public(address.ip())).for_each(|address| public.push(*address));
        if public.is_empty() {
            return Err(ureq::Error::Other(refusal(host).into()));
        }
        Ok(public)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn a_name_that_leads_to_a_private_address_is_refused_before_the_connection() {
        let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
        listener.set_nonblocking(true).unwrap();
        let url = format!("http://localhost:{}/", listener.local_addr().unwrap().port());
        let message = Message { url, id: "a".to_owned(), body: b"{}".to_vec(), secrets: vec![vec![1]] };
        let answer = Sender::new(Hosts::new(&[]), None).send(message).await;
        assert!(answer.problem().unwrap().contains("localhost is not a public address"), "{answer:?}");
        assert!(listener.accept().is_err(), "nobody has connected");
    }
}
