//! The connections to the broker: one receives and one publishes, so that setpoints never wait behind a burst.
//!
//! The broker's sessions are not relied on: each connection starts clean under an unguessable client id (`identity`),
//! and subscribes again. Then it asks all robots for births and factsheets (`births`), because the broker may have
//! forgotten the retained ones. The receiving connection proves that it hears robots (`hearing`).
//!
//! Further connections: [`record`] records, [`TestClient`] tests a robot, whose topics a [`Relay`] records, and
//! [`try_hearing`] tests for a short time whether a fleet can be heard; `former_owner` asks for the fleet's last owner. [`prepare`] reads certificates before the first
//! attempt; [`BrokerLink`] gives the reason of an outage. A broker may have several nodes; [`nodes`] has their order.

mod address;
mod tls;

mod births;
mod receive;
mod subscriptions;

mod hearing;

mod encoded;
mod proofs;
mod publish;
mod refusals;

mod recorder;

mod relay;
mod test_client;

mod former_owner;
mod trial;

mod coalescing;
mod connector;
mod identity;
mod limits;
mod link;
mod nodes;
mod poll;
mod problem;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use rumqttc::{MqttOptions, TlsConfiguration, Transport};
use vibrissa_protocol::{BootId, Name};

use crate::thread::Occupancy;

pub(crate) use births::{FleetBirths, SharedBirths};
pub(crate) use former_owner::retained_epoch;

pub use address::{BadBrokerUrl, BrokerAddress, ClientCertificate, Credentials, Node, TlsOptions};
pub use link::{BrokerLink, NodesInUse};
pub use publish::publish;
pub use receive::receive;
pub use recorder::{RecorderState, record};
pub use relay::{ClientRecord, Relay, RelayRecord, Trouble};
pub use test_client::{ReceivedMessage, TestClient};
pub use tls::{PrepareError, Prepared, prepare};
pub use trial::try_hearing;

/// Size limit of incoming packets in bytes. The broker is told at the connection, and must not send larger ones;
/// without the limit, one larger packet would end each connection.
const PACKET_MAX: u32 = 2 * 1024 * 1024;
/// Limit of this supervisor's publications without an acknowledgement. The client keeps a table of this size; its
/// default is the protocol's maximum of 65,535.
const IN_FLIGHT: u16 = 64;
/// Number of waiting publications sent in one write: about 8 KiB of receipts. The client's default is one write for
/// each.
const WRITE_BATCH: usize = 64;

/// Settings of a fleet's connections.
#[derive(Debug, Clone)]
pub struct Connection {
    /// Address of the broker; the node in use comes first.
    pub broker: BrokerAddress,
    /// Secrets and certificates, read by [`prepare`].
    pub prepared: Prepared,
    /// Fleet whose topics are used.
    pub fleet: Name,
    /// Requests for births of the fleet.
    pub(crate) births: SharedBirths,
    /// Boot id of this supervisor for the fleet.
    pub boot_id: BootId,
    /// Epoch of the fleet's lease.
    pub epoch: u64,
    /// Whether contacts and statuses come over MQTT, not from a partitioned log.
    pub hears_contacts: bool,
    /// Receives the state of the connections.
    pub link: BrokerLink,
    /// Number of fleets in the thread that receives.
    pub occupancy: Occupancy,
}

impl Connection {
    /// Settings with the lowest epoch.
    #[must_use]
    pub fn new(broker: BrokerAddress, prepared: Prepared, fleet: Name, boot_id: BootId) -> Self {
        let (births, link) = (SharedBirths::default(), BrokerLink::default());
        let occupancy = Occupancy::default();
        Self { broker, prepared, fleet, births, boot_id, epoch: 0, hears_contacts: true, link, occupancy }
    }

    /// Options of a client with a new client id, and a flag that is set once TCP is connected.
    fn options(&self, role: &str) -> (MqttOptions, Arc<AtomicBool>) {
        self.options_as(identity::client_id(&self.fleet, role))
    }

    /// The same with this client id.
    fn options_as(&self, id: String) -> (MqttOptions, Arc<AtomicBool>) {
        let limits = connector::Limits::of(&self.broker);
        let (host, port) = (self.broker.host.clone(), self.broker.port);
        let mut options = MqttOptions::new(id, (host.clone(), port));
        options
            .set_clean_start(true)
            .set_keep_alive(poll::KEEP_ALIVE_S)
            .set_max_packet_size(Some(PACKET_MAX))
            .set_outgoing_inflight_upper_limit(IN_FLIGHT)
            .set_read_batch_size(coalescing::READ_MAX)
            .set_max_request_batch(WRITE_BATCH)
            .set_connect_timeout(limits.whole);
        self.show_secrets(&mut options);
        let reached = Arc::new(AtomicBool::new(false));
        let is_reached = reached.clone();
        options.set_socket_connector(move |_, _| connector::connect(host.clone(), port, limits, is_reached.clone()));
        (options, reached)
    }

    /// Sets password and certificates.
    fn show_secrets(&self, options: &mut MqttOptions) {
        if let Some(credentials) = &self.broker.credentials {
            options.set_credentials(&credentials.username, credentials.password.reveal().to_owned());
        }
        if let Some(tls) = &self.prepared.tls {
            options.set_transport(Transport::tls_with_config(TlsConfiguration::Rustls(tls.clone())));
        }
    }

    /// The same connection to this node.
    fn at(&self, node: &Node) -> Self {
        Self { broker: self.broker.at(node), ..self.clone() }
    }

    /// The same connection with the current contents of the password and certificate files. If a file is unusable, its
    /// last contents stay in use.
    fn with_secrets_read_again(&self) -> Self {
        let mut renewed = self.clone();
        let mut problem = None;
        if let Some(credentials) = &mut renewed.broker.credentials {
            match credentials.password.read_again() {
                Ok(password) => credentials.password = password,
                Err(why) => problem = Some(format!("mqtt.password_file: {why}")),
            }
        }
        match self.prepared.read_again(&self.broker) {
            Ok(prepared) => renewed.prepared = prepared,
            Err(why) => problem = Some(why.to_string()),
        }
        self.link.secrets(problem);
        renewed
    }
}
