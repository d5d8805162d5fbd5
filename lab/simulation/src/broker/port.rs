//! The client's end of a connection.

use std::sync::Arc;

use rumqttc::Packet;
use tokio::sync::Notify;
use tokio::time::Instant;

use super::{LinkId, ModelBroker};

/// The client's end of a connection. Dropping it breaks the connection.
#[derive(Debug)]
pub(super) struct ClientPort {
    broker: ModelBroker,
    link: LinkId,
    wake: Arc<Notify>,
}

impl ClientPort {
    /// Connects a byte stream, or the client of this name in this process; `None` if the broker accepts no connection.
    pub(super) fn open(broker: &ModelBroker, direct: Option<&str>) -> Option<Self> {
        let (link, wake) = broker.hub().open(direct)?;
        Some(Self { broker: broker.clone(), link, wake })
    }

    pub(super) fn send(&self, packet: Packet) {
        self.broker.hub().submit(Instant::now(), self.link, Some(packet));
    }

    /// The next packet that has arrived; `Some(None)` at the end of the connection.
    pub(super) fn try_next(&self) -> Option<Option<Packet>> {
        self.broker.hub().received(self.link)
    }

    /// Waits for the next packet; `None` at the end of the connection. Cancel safe.
    pub(super) async fn next(&self) -> Option<Packet> {
        loop {
            if let Some(packet) = self.try_next() {
                return packet;
            }
            self.wake.notified().await;
        }
    }
}

impl Drop for ClientPort {
    fn drop(&mut self) {
        self.broker.hub().submit(Instant::now(), self.link, None);
    }
}
