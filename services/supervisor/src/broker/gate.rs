//! Admits clients, and limits the publications that the broker keeps. The library asks here.

use std::future::Future;
use std::net::SocketAddr;
use std::pin::Pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use mqtt5::broker::{
    AuthProvider, AuthResult, BrokerEventHandler, ClientPublishEvent, PublishAction, RetainedSetEvent,
};
use mqtt5::packet::connect::ConnectPacket;
use mqtt5::protocol::v5::reason_codes::ReasonCode;
use subtle::ConstantTimeEq as _;
use tokio::time::{Instant, sleep_until};
use tracing::warn;

use super::ledger::Ledger;
use crate::mqtt::Credentials;

/// Rate of publications of all clients together, bytes per second. What one client sends too fast waits at that client, and not
/// here for the clients that receive it.
const BYTES_PER_S: f64 = 33_554_432.0;
/// Time for which the rate may be exceeded.
const BURST: Duration = Duration::from_millis(500);

type HookFuture<'a, T> = Pin<Box<dyn Future<Output = T> + Send + 'a>>;

/// Checks of connections and publications at the embedded broker.
#[derive(Debug)]
pub(super) struct Gate {
    /// Hash of user name and password; `None` admits everyone.
    credentials: Option<blake3::Hash>,
    ledger: Arc<Ledger>,
    /// Time until which the rate is used up.
    used_until: Mutex<Instant>,
}

/// Hash of user name and password. The length separates them.
fn hash(username: &str, password: &[u8]) -> blake3::Hash {
    let mut hasher = blake3::Hasher::new();
    hasher.update(&(username.len() as u64).to_be_bytes()).update(username.as_bytes()).update(password);
    hasher.finalize()
}

impl Gate {
    pub(super) fn new(credentials: Option<&Credentials>, ledger: Arc<Ledger>) -> Self {
        let hash = |one: &Credentials| hash(&one.username, one.password.reveal().as_bytes());
        Self { credentials: credentials.map(hash), ledger, used_until: Mutex::new(Instant::now()) }
    }

    fn admits(&self, connect: &ConnectPacket) -> AuthResult {
        if let Some(known) = self.credentials {
            let given =
                hash(connect.username.as_deref().unwrap_or_default(), connect.password.as_deref().unwrap_or(&[]));
            if !bool::from(given.as_bytes().ct_eq(known.as_bytes())) {
                warn!("embedded MQTT broker: a client with a wrong user name or password was refused");
                return AuthResult::fail(ReasonCode::BadUsernameOrPassword);
            }
        }
        // The broker publishes a will itself, and asks nobody then.
        match &connect.will {
            Some(will) if will.retain && !self.keeps(&will.topic, will.payload.len()) => {
                AuthResult::fail(ReasonCode::QuotaExceeded)
            }
            Some(_) | None => AuthResult::success(),
        }
    }

    fn keeps(&self, topic: &str, payload_bytes: usize) -> bool {
        let is_kept = self.ledger.retain(topic, payload_bytes);
        if !is_kept {
            warn!(payload_bytes, "embedded MQTT broker: no room for another retained message, it is not kept");
        }
        is_kept
    }

    /// Waits until there is time for so many bytes.
    async fn pace(&self, bytes: usize) {
        let begin = {
            let mut used_until = self.used_until.lock().unwrap_or_else(PoisonError::into_inner);
            let begin = Instant::now().max(*used_until);
            *used_until = begin + Duration::from_secs_f64(bytes as f64 / BYTES_PER_S);
            begin
        };
        if begin > Instant::now() + BURST {
            sleep_until(begin - BURST).await;
        }
    }
}

impl AuthProvider for Gate {
    fn authenticate<'a>(
        &'a self,
        connect: &'a ConnectPacket,
        _client: SocketAddr,
    ) -> HookFuture<'a, mqtt5::Result<AuthResult>> {
        Box::pin(async move { Ok(self.admits(connect)) })
    }

    fn authorize_publish<'a>(&'a self, _client: &str, _user: Option<&'a str>, _topic: &'a str) -> HookFuture<'a, bool> {
        Box::pin(async { true })
    }

    fn authorize_subscribe<'a>(
        &'a self,
        _client: &str,
        _user: Option<&'a str>,
        _filter: &'a str,
    ) -> HookFuture<'a, bool> {
        Box::pin(async { true })
    }
}

impl BrokerEventHandler for Gate {
    fn on_client_publish<'a>(&'a self, event: ClientPublishEvent) -> HookFuture<'a, PublishAction> {
        Box::pin(async move {
            self.pace(event.topic.len() + event.payload.len()).await;
            if event.retain && !self.keeps(&event.topic, event.payload.len()) {
                return PublishAction::Handled;
            }
            PublishAction::Continue
        })
    }

    fn on_retained_set<'a>(&'a self, event: RetainedSetEvent) -> HookFuture<'a, ()> {
        Box::pin(async move {
            let bytes = if event.cleared { 0 } else { event.payload.len() };
            self.ledger.retain(&event.topic, bytes);
        })
    }
}
