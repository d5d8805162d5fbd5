//! Faults, switched from outside at any time.

use tokio::time::Instant;

use super::ModelBroker;
use super::lanes::{Delay, Way};
use super::report::{Counts, Observer};

/// How the broker ends a connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// The client's stream ends.
    Told,
    /// The client is not told: its stream stays open, its bytes are accepted, and nothing is answered.
    Silent,
}

/// Memory of a broker after a restart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Memory {
    /// Retained messages, and sessions that outlive their connections.
    Kept,
    /// Nothing.
    Lost,
}

impl ModelBroker {
    /// Ends the connections of a client, or all (`None`). Their wills are published.
    pub fn end(&self, client: Option<&str>, ending: Ending) {
        self.hub().end(Instant::now(), client, ending == Ending::Silent);
    }

    /// Ends all connections without their wills; messages on their way are lost. The broker is no longer frozen. For a time
    /// between stop and start, use [`Self::set_accepting`], too.
    pub fn restart(&self, memory: Memory) {
        self.hub().restart(Instant::now(), memory == Memory::Lost);
    }

    /// Sets whether connections are accepted. Present ones stay.
    pub fn set_accepting(&self, is_accepting: bool) {
        self.hub().is_accepting = is_accepting;
    }

    /// Whether connections are accepted.
    #[must_use]
    pub fn is_accepting(&self) -> bool {
        self.hub().is_accepting
    }

    /// Freezes the broker, or lets it go on: frozen, it accepts connections and bytes, and answers nothing. It then goes on
    /// with everything that has arrived.
    pub fn set_frozen(&self, is_frozen: bool) {
        self.hub().freeze(Instant::now(), is_frozen);
    }

    /// Delays each message that is sent from now on.
    pub fn set_delay(&self, way: Way, delay: Delay) {
        self.hub().delays.insert(way, delay);
    }

    /// Sets whether messages to clients keep their order within a topic only, as in a cluster of brokers. It matters with a
    /// delay.
    pub fn set_topics_overtake(&self, topics_overtake: bool) {
        self.hub().topics_overtake = topics_overtake;
    }

    /// Holds back, or delivers, what a client in this process sends or shall receive, over its next connections, too. Its
    /// keep-alive runs meanwhile. For byte streams see [`super::Route::cut`].
    pub fn set_held(&self, client: &str, way: Way, is_held: bool) {
        self.hub().hold(Instant::now(), client, way, is_held);
    }

    /// Probability, 0 to 1, that a delivery with QoS 1 is repeated: queued once more with the repetition flag.
    pub fn set_repetition(&self, probability: f64) {
        self.hub().machine.faults.repetition = probability;
    }

    /// Probability, 0 to 1, that a delivery with QoS 0 is lost.
    pub fn set_loss(&self, probability: f64) {
        self.hub().machine.faults.loss = probability;
    }

    /// Refuses publications on topics that the filter matches, with reason `NotAuthorized`; those with QoS 0 are dropped.
    pub fn refuse(&self, filter: &str) {
        self.hub().machine.faults.refused.insert(filter.to_owned());
    }

    /// Ends a refusal of [`Self::refuse`].
    pub fn stop_refusing(&self, filter: &str) {
        self.hub().machine.faults.refused.remove(filter);
    }

    /// Loses all subscriptions of a client, without telling it.
    pub fn forget_subscriptions(&self, client: &str) {
        self.hub().machine.forget_subscriptions(client);
    }

    /// Loses the retained messages on topics that the filter matches.
    pub fn forget_retained(&self, filter: &str) {
        self.hub().machine.forget_retained(filter);
    }

    /// Numbers of events so far.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.hub().machine.counts
    }

    /// Client ids of the present connections, in alphabetical order.
    #[must_use]
    pub fn clients(&self) -> Vec<String> {
        self.hub().machine.clients()
    }

    /// Sets the observer of all messages.
    pub fn observe(&self, observer: Observer) {
        self.hub().machine.observer = Some(observer);
    }
}
