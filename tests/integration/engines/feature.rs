//! The features of a broker that the supervisor, its robots and `check-robot` use, each with a check.
//!
//! In a cluster the sender is at the first node and the receiver at the last one.

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

use rumqttc::{QoS, RetainForwardRule, SubscribeFilterInput};
use vibrissa_protocol::PAYLOAD_MAX_BYTES;
use vibrissa_tests::mqtt_311::OldClient;

use crate::engine::{ALL, FEW, FOREIGN, PASSWORD};
use crate::peer::{ANSWER, PACKET_MAX, Peer, Who};

/// A time in which nothing must come.
const QUIET: Duration = Duration::from_millis(400);
/// Messages in order, as a robot sends after an outage.
const MANY: usize = 1000;
const CONTACTS: &str = "whisker/v1/f/r/contacts";
const EVERY_ROBOT: &str = "whisker/v1/f/+/contacts";

/// Result of a check; the error says what the broker does instead.
type Checked = Result<(), String>;

/// A feature with its row in docs/brokers.md.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Feature {
    Version5,
    CleanStart,
    Filters,
    Probes,
    Expiry,
    ExpiryOfWaiting,
    LargePayload,
    PacketLimit,
    Arrival,
    Order,
    Will,
    Retained,
    RetainedAgain,
    RetainedRefused,
    RetainedAsPublished,
    Takeover,
    WrongPassword,
    RefusedSubscription,
    RefusedPublication,
    OldVersion,
}

impl Feature {
    pub(crate) const EVERY: [Self; 20] = [
        Self::Version5,
        Self::CleanStart,
        Self::Filters,
        Self::Probes,
        Self::Expiry,
        Self::ExpiryOfWaiting,
        Self::LargePayload,
        Self::PacketLimit,
        Self::Arrival,
        Self::Order,
        Self::Will,
        Self::Retained,
        Self::RetainedAgain,
        Self::RetainedRefused,
        Self::RetainedAsPublished,
        Self::Takeover,
        Self::WrongPassword,
        Self::RefusedSubscription,
        Self::RefusedPublication,
        Self::OldVersion,
    ];

    /// Whether a broker without the feature may show it by chance.
    pub(crate) fn is_by_chance(self) -> bool {
        self == Self::Order
    }

    /// Its row in docs/brokers.md.
    pub(crate) fn title(self) -> &'static str {
        match self {
            Self::Version5 => "MQTT 5, QoS 1 both ways",
            Self::CleanStart => "clean start",
            Self::Filters => "filters of a fleet",
            Self::Probes => "own messages come back",
            Self::Expiry => "message expiry",
            Self::ExpiryOfWaiting => "expiry in a session without a client",
            Self::LargePayload => "messages of 256 KiB",
            Self::PacketLimit => "maximum packet size of the client",
            Self::Arrival => "1,000 messages arrive once",
            Self::Order => "messages of a client in order",
            Self::Will => "last will",
            Self::Retained => "retained messages",
            Self::RetainedAgain => "retained messages at each subscription",
            Self::RetainedRefused => "no retained messages on request",
            Self::RetainedAsPublished => "QoS 2 subscriptions with the retain flag",
            Self::Takeover => "takeover of a client id",
            Self::WrongPassword => "wrong password",
            Self::RefusedSubscription => "refused subscription",
            Self::RefusedPublication => "refused publication",
            Self::OldVersion => "MQTT 3.1.1",
        }
    }
}

/// A broker's first and last node.
pub(crate) struct Stage {
    near: u16,
    far: u16,
    /// Longest time from a confirmed subscription at one node to the first message from the other one.
    pub(crate) settled_in: Duration,
}

impl Stage {
    pub(crate) fn new(ports: &[u16]) -> Self {
        Self { near: ports[0], far: ports[ports.len() - 1], settled_in: Duration::ZERO }
    }

    /// Checks a feature within a time limit.
    pub(crate) async fn check(&mut self, feature: Feature) -> Checked {
        let limit = Duration::from_secs(40);
        let checked = tokio::time::timeout(limit, self.checked(feature)).await;
        checked.unwrap_or_else(|_| Err("no result in time".to_owned()))
    }

    async fn checked(&mut self, feature: Feature) -> Checked {
        match feature {
            Feature::Version5 => self.version_5().await,
            Feature::CleanStart => self.clean_start().await,
            Feature::Filters => self.filters().await,
            Feature::Probes => self.probes().await,
            Feature::Expiry => self.expiry().await,
            Feature::ExpiryOfWaiting => self.expiry_of_waiting().await,
            Feature::LargePayload => self.large_payload().await,
            Feature::PacketLimit => self.packet_limit().await,
            Feature::Arrival => self.overtaking().await.map(drop),
            Feature::Order => match self.overtaking().await? {
                0 => Ok(()),
                early => Err(format!("{early} of {MANY} overtake others")),
            },
            Feature::Will => self.will().await,
            Feature::Retained => self.retained().await,
            Feature::RetainedAgain => self.retained_again().await,
            Feature::RetainedRefused => self.retained_refused().await,
            Feature::RetainedAsPublished => self.retained_as_published().await,
            Feature::Takeover => self.takeover().await,
            Feature::WrongPassword => self.wrong_password().await,
            Feature::RefusedSubscription => self.refused_subscription().await,
            Feature::RefusedPublication => self.refused_publication().await,
            Feature::OldVersion => self.old_version().await,
        }
    }

    async fn sender(&self) -> Result<Peer, String> {
        Peer::connect(self.near, &Who::new("sender")).await
    }

    /// A receiver with a subscription that the sender's node knows.
    async fn receiver(&mut self, sender: &mut Peer, who: &Who, filter: &str) -> Result<Peer, String> {
        let mut receiver = Peer::connect(self.far, who).await?;
        receiver.subscribe(filter, QoS::AtLeastOnce).await?;
        self.settle(sender, &mut receiver, &who.id).await?;
        Ok(receiver)
    }

    /// Waits until a later subscription of the receiver has reached the sender's node; the earlier ones have, too.
    async fn settle(&mut self, sender: &mut Peer, receiver: &mut Peer, id: &str) -> Checked {
        let topic = &format!("whisker/v1/f/settling-{id}/request");
        receiver.subscribe(topic, QoS::AtLeastOnce).await?;
        let begun = Instant::now();
        loop {
            sender.publish(topic, "settled?").await?;
            if receiver.hear(Duration::from_millis(100)).await.is_some_and(|heard| heard.payload == "settled?") {
                break;
            }
            if begun.elapsed() > ANSWER {
                return Err("messages do not reach the other node".to_owned());
            }
        }
        self.settled_in = self.settled_in.max(begun.elapsed());
        // Repetitions that are still under way.
        while receiver.hear(Duration::from_millis(50)).await.is_some() {}
        Ok(())
    }

    async fn version_5(&mut self) -> Checked {
        let mut sender = self.sender().await?;
        let mut receiver = self.receiver(&mut sender, &Who::new("receiver"), EVERY_ROBOT).await?;
        sender.publish(CONTACTS, "one").await?;
        let heard = receiver.hear_payload(b"one").await?;
        // The second one comes only if the client's acknowledgement of the first one counts.
        sender.publish(CONTACTS, "two").await?;
        receiver.hear_payload(b"two").await?;
        wants(heard.qos == QoS::AtLeastOnce, || format!("arrives with {:?}", heard.qos))
    }

    async fn clean_start(&mut self) -> Checked {
        let mut sender = self.sender().await?;
        let kept = Who { clean: false, session_s: Some(60), ..Who::new("kept") };
        self.receiver(&mut sender, &kept, EVERY_ROBOT).await?.leave().await;
        sender.publish(CONTACTS, "for the old session").await?;
        let mut receiver = Peer::connect(self.far, &Who::new("kept")).await?;
        wants(!receiver.ack.session_present, || "an old session is present".to_owned())?;
        sender.publish(CONTACTS, "again").await?;
        wants(receiver.hear(QUIET).await.is_none(), || "an old subscription is in force".to_owned())
    }

    async fn filters(&mut self) -> Checked {
        let mut sender = self.sender().await?;
        let mut receiver = self.receiver(&mut sender, &Who::new("receiver"), EVERY_ROBOT).await?;
        let mut recorder = self.receiver(&mut sender, &Who::new("recorder"), "whisker/v1/f/#").await?;
        for topic in ["whisker/v1/g/r/contacts", "whisker/v1/f/r/status", "whisker/v1/f/r-1_X/contacts"] {
            sender.publish(topic, topic).await?;
        }
        let first = receiver.hear(ANSWER).await.ok_or("nothing arrives")?;
        wants(first.topic == "whisker/v1/f/r-1_X/contacts", || format!("{:?} arrives", first.topic))?;
        recorder.hear_payload(b"whisker/v1/f/r/status").await?;
        recorder.hear_payload(b"whisker/v1/f/r-1_X/contacts").await.map(drop)
    }

    async fn probes(&mut self) -> Checked {
        let mut supervisor = self.sender().await?;
        supervisor.subscribe(EVERY_ROBOT, QoS::AtLeastOnce).await?;
        supervisor.publish_as("whisker/v1/f/supervisor/contacts", b"probe".to_vec(), false, Some(15)).await?;
        supervisor.hear_payload(b"probe").await.map(drop)
    }

    async fn expiry(&mut self) -> Checked {
        let mut sender = self.sender().await?;
        let mut receiver = self.receiver(&mut sender, &Who::new("receiver"), EVERY_ROBOT).await?;
        sender.publish_as(CONTACTS, b"fresh".to_vec(), false, Some(15)).await?;
        let heard = receiver.hear_payload(b"fresh").await?;
        let left_s = heard.properties.and_then(|properties| properties.message_expiry_interval);
        wants(left_s.is_some_and(|left_s| (1..=15).contains(&left_s)), || format!("the expiry arrives as {left_s:?}"))?;
        Ok(())
    }

    async fn expiry_of_waiting(&mut self) -> Checked {
        let mut sender = self.sender().await?;
        let who = Who { clean: false, session_s: Some(60), ..Who::new("sleeper") };
        let receiver = self.receiver(&mut sender, &who, EVERY_ROBOT).await?;
        receiver.leave().await;
        sender.publish_as(CONTACTS, b"late".to_vec(), false, Some(1)).await?;
        sender.publish(CONTACTS, "kept").await?;
        tokio::time::sleep(Duration::from_millis(2_200)).await;
        let mut receiver = Peer::connect(self.far, &who).await?;
        let first = receiver.hear(ANSWER).await.ok_or("a waiting message does not arrive")?;
        // Ends the session.
        drop(Peer::connect(self.far, &Who::new("sleeper")).await?);
        wants(first.payload == "kept", || "an expired message arrives".to_owned())
    }

    async fn large_payload(&mut self) -> Checked {
        let mut sender = self.sender().await?;
        let mut receiver = self.receiver(&mut sender, &Who::new("receiver"), EVERY_ROBOT).await?;
        let large = vec![b'x'; PAYLOAD_MAX_BYTES];
        sender.publish(CONTACTS, large.clone()).await?;
        receiver.hear_payload(&large).await.map(drop)
    }

    async fn packet_limit(&mut self) -> Checked {
        let mut sender = self.sender().await?;
        let who = Who { packet_max: 100_000, ..Who::new("small") };
        let mut receiver = self.receiver(&mut sender, &who, EVERY_ROBOT).await?;
        wants(sender.ack_packet_max() >= PAYLOAD_MAX_BYTES as u32 + 1024, || {
            format!("it accepts at most {} bytes", sender.ack_packet_max())
        })?;
        sender.publish(CONTACTS, vec![b'x'; 200_000]).await?;
        sender.publish(CONTACTS, "small").await?;
        receiver.hear_payload(b"small").await.map(drop)
    }

    /// Number of messages that overtake others. Each arrives once.
    async fn overtaking(&mut self) -> Result<usize, String> {
        let mut sender = self.sender().await?;
        let mut receiver = self.receiver(&mut sender, &Who::new("receiver"), EVERY_ROBOT).await?;
        for number in 0..MANY {
            sender.send(CONTACTS, number.to_string().into_bytes(), false, None)?;
        }
        let (mut next, mut early) = (0, 0);
        let mut missing: BTreeSet<usize> = (0..MANY).collect();
        while !missing.is_empty() {
            let heard = receiver.hear(ANSWER).await.ok_or_else(|| format!("{} do not arrive", missing.len()))?;
            let number = std::str::from_utf8(&heard.payload).ok().and_then(|text| text.parse().ok());
            let number: usize = number.ok_or("another message arrives")?;
            early += usize::from(number > next);
            next = next.max(number + 1);
            wants(missing.remove(&number), || format!("{number} arrives twice"))?;
        }
        Ok(early)
    }

    async fn will(&mut self) -> Checked {
        let topic = "whisker/v1/f/r/connection";
        let mut sender = self.sender().await?;
        let mut receiver = self.receiver(&mut sender, &Who::new("receiver"), topic).await?;
        let mortal =
            Peer::connect(self.near, &Who { will: Some((topic.to_owned(), true)), ..Who::new("mortal") }).await?;
        drop(mortal);
        receiver.hear_payload(b"will").await?;
        let polite =
            Peer::connect(self.near, &Who { will: Some((topic.to_owned(), true)), ..Who::new("polite") }).await?;
        polite.leave().await;
        let more = receiver.hear(QUIET).await;
        sender.publish_as(topic, Vec::new(), true, None).await?;
        wants(more.is_none(), || "a client that says farewell has a last will".to_owned())
    }

    async fn retained(&mut self) -> Checked {
        let topic = "whisker/v1/f/r/factsheet";
        let mut sender = self.sender().await?;
        sender.publish_as(topic, b"kept".to_vec(), true, None).await?;
        let heard = self.retained_for("later", topic, QoS::AtLeastOnce).await?;
        wants(heard.retain, || "without the retain flag".to_owned())?;
        sender.publish_as(topic, Vec::new(), true, None).await?;
        // Another node may learn it later.
        tokio::time::sleep(QUIET).await;
        let mut latest = Peer::connect(self.far, &Who::new("latest")).await?;
        latest.subscribe(topic, QoS::AtLeastOnce).await?;
        wants(latest.hear(QUIET).await.is_none(), || "a deleted message is retained".to_owned())
    }

    /// The retained message of a topic. A cluster may replicate it late.
    async fn retained_for(&self, id: &str, topic: &str, qos: QoS) -> Result<rumqttc::Publish, String> {
        for _ in 0..20 {
            let mut peer = Peer::connect(self.far, &Who::new(id)).await?;
            peer.subscribe_as(SubscribeFilterInput::new(topic, qos).preserve_retain(true)).await?;
            if let Some(heard) = peer.hear(QUIET).await {
                return Ok(heard);
            }
        }
        Err("no retained message".to_owned())
    }

    async fn retained_again(&mut self) -> Checked {
        let topic = "whisker/v1/f/again/factsheet";
        let mut sender = self.sender().await?;
        sender.publish_as(topic, b"kept".to_vec(), true, None).await?;
        self.retained_for("again", topic, QoS::AtLeastOnce).await?;
        let mut receiver = Peer::connect(self.far, &Who::new("twice")).await?;
        for _ in 0..2 {
            receiver.subscribe("whisker/v1/f/+/factsheet", QoS::AtLeastOnce).await?;
            receiver.hear_payload(b"kept").await?;
        }
        sender.publish_as(topic, Vec::new(), true, None).await
    }

    async fn retained_refused(&mut self) -> Checked {
        let topic = "whisker/v1/f/unwanted/factsheet";
        let mut sender = self.sender().await?;
        sender.publish_as(topic, b"kept".to_vec(), true, None).await?;
        self.retained_for("wanted", topic, QoS::AtLeastOnce).await?;
        let mut receiver = Peer::connect(self.far, &Who::new("trial")).await?;
        let filter = SubscribeFilterInput::new("whisker/v1/f/+/factsheet", QoS::AtLeastOnce);
        receiver.subscribe_as(filter.retain_forward_rule(RetainForwardRule::Never)).await?;
        let heard = receiver.hear(QUIET).await;
        sender.publish_as(topic, Vec::new(), true, None).await?;
        wants(heard.is_none(), || "retained messages arrive".to_owned())
    }

    async fn retained_as_published(&mut self) -> Checked {
        let topic = "whisker/v1/f/flag/factsheet";
        let mut sender = self.sender().await?;
        let mut receiver = Peer::connect(self.far, &Who::new("check")).await?;
        let filter = SubscribeFilterInput::new(topic, QoS::ExactlyOnce).preserve_retain(true);
        receiver.subscribe_as(filter).await?;
        self.settle(&mut sender, &mut receiver, "check").await?;
        sender.publish_as(topic, b"kept".to_vec(), true, None).await?;
        let heard = receiver.hear_payload(b"kept").await?;
        sender.publish_as(topic, Vec::new(), true, None).await?;
        wants(heard.retain, || "the flag is cleared".to_owned())
    }

    async fn takeover(&mut self) -> Checked {
        let mut first = Peer::connect(self.near, &Who::new("twin")).await?;
        let mut second = Peer::connect(self.far, &Who::new("twin")).await?;
        first.ended().await.map_err(|_| "both connections stay open".to_owned())?;
        // The second one lives.
        second.publish(CONTACTS, "alive").await
    }

    async fn wrong_password(&mut self) -> Checked {
        let who = Who { password: "wrong", ..Who::new("thief") };
        let Err(refusal) = Peer::connect(self.near, &who).await else { return Err("it is accepted".to_owned()) };
        let is_told = refusal.contains("NotAuthorized") || refusal.contains("BadUserNamePassword");
        wants(is_told, || format!("refused without the reason: {refusal}"))
    }

    async fn refused_subscription(&mut self) -> Checked {
        let mut few = self.few("few-reader").await?;
        few.subscribe("whisker/v1/f/few/setpoint", QoS::AtLeastOnce).await?;
        let refused = few.subscribe(EVERY_ROBOT, QoS::AtLeastOnce).await;
        wants(refused.is_err(), || "it is accepted".to_owned())?;
        few.publish("whisker/v1/f/few/contacts", "still here").await.map_err(|ended| format!("then {ended}"))
    }

    async fn refused_publication(&mut self) -> Checked {
        let mut few = self.few("few-writer").await?;
        few.publish("whisker/v1/f/few/contacts", "own").await?;
        let refused = few.publish(FOREIGN, "foreign").await;
        let Err(reason) = refused else { return Err("it is acknowledged as if it were accepted".to_owned()) };
        wants(reason.contains("NotAuthorized"), || format!("reported as {reason}"))?;
        few.publish("whisker/v1/f/few/contacts", "still here").await.map_err(|ended| format!("then {ended}"))
    }

    /// The user with few rights, if the broker has users.
    async fn few(&self, id: &str) -> Result<Peer, String> {
        Peer::connect(self.near, &Who { user: FEW, ..Who::new(id) }).await
    }

    async fn old_version(&mut self) -> Checked {
        let said = |problem: std::io::Error| problem.to_string();
        let mut sender = self.sender().await?;
        let mut receiver = self.receiver(&mut sender, &Who::new("receiver"), EVERY_ROBOT).await?;
        let (old, mut heard) = OldClient::connect(self.near, "old", Some((ALL, PASSWORD))).await.map_err(said)?;
        wants(old.subscribe("whisker/v1/f/old/setpoint").await.map_err(said)?, || "no subscription".to_owned())?;
        old.publish("whisker/v1/f/old/contacts", b"from an old client", false).await.map_err(said)?;
        receiver.hear_payload(b"from an old client").await?;
        // With an expiry, which MQTT 3.1.1 does not have.
        receiver.publish_as("whisker/v1/f/old/setpoint", b"to an old client".to_vec(), false, Some(15)).await?;
        let message = tokio::time::timeout(ANSWER, heard.recv()).await.ok().flatten().ok_or("it hears nothing")?;
        wants(message.payload == b"to an old client" && message.qos == 1, || format!("it hears {message:?}"))
    }
}

fn wants(holds: bool, otherwise: impl FnOnce() -> String) -> Checked {
    if holds { Ok(()) } else { Err(otherwise()) }
}

impl Peer {
    /// Largest packet that the broker accepts, in bytes.
    fn ack_packet_max(&self) -> u32 {
        self.ack.properties.as_ref().and_then(|properties| properties.max_packet_size).unwrap_or(PACKET_MAX)
    }
}
