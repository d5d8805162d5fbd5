//! Two connections to the broker: one receives, one publishes, so that setpoints never wait behind a burst.
//!
//! Nothing rests on the broker's sessions: each connection starts clean under a name that nobody can guess (`identity`), and
//! subscribes anew, so that retained births and factsheets come again. The receiving one proves that it hears (`hearing`).
//!
//! [`tap`] is a third, for recordings, [`Talk`] a fourth, to test a robot with, and [`try_hearing`] a fifth, for a moment. [`prepare`] reads certificates before anything is tried; [`LinkState`] tells why there is no connection.

mod address;
mod tls;

mod receive;

mod hearing;

mod publish;

mod tap;

mod talk;

mod trial;

mod dial;
mod identity;
mod link;
mod pace;
mod poll;
mod problem;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use rumqttc::{MqttOptions, TlsConfiguration, Transport};
use tokio::sync::watch;
use vibrissa_protocol::{BootId, Name};

pub use address::{BadBrokerUrl, BrokerAddress, ClientCertificate, Credentials, TlsOptions};
pub use link::LinkState;
pub use publish::publish;
pub use receive::receive;
pub use talk::{Said, Talk};
pub use tap::tap;
pub use tls::{PrepareError, Prepared, prepare};
pub use trial::try_hearing;

/// The largest packet that is taken. Larger ones the broker must not send; without this limit, one would
/// end every connection.
const PACKET_MAX: u32 = 2 * 1024 * 1024;
/// Publications of ours without an acknowledgement at a time. The client keeps a table of this size; its default
/// is the protocol's 65,535.
const IN_FLIGHT: u16 = 64;
/// Publications that go out in one write, if so many wait: some 8 KiB of receipts. By itself the client makes a write for each.
const WRITE_BATCH: usize = 64;

/// What both connections need to know.
#[derive(Debug, Clone)]
pub struct Connection {
    /// Where.
    pub broker: BrokerAddress,
    /// What [`prepare`] made of it.
    pub prepared: Prepared,
    /// Which fleet.
    pub fleet: Name,
    /// Which boot of the supervisor.
    pub boot_id: BootId,
    /// Its epoch.
    pub epoch: u64,
    /// Where it is told why there is no connection.
    pub link: LinkState,
}

impl Connection {
    /// The options of a client, with a new client id, and a flag that shows whether it has reached TCP.
    fn options(&self, role: &str) -> (MqttOptions, Arc<AtomicBool>) {
        let id = identity::client_id(&self.fleet, role);
        let (host, port) = (self.broker.host.clone(), self.broker.port);
        let mut options = MqttOptions::new(id, (host.clone(), port));
        options
            .set_clean_start(true)
            .set_keep_alive(poll::KEEP_ALIVE_S)
            .set_max_packet_size(Some(PACKET_MAX))
            .set_outgoing_inflight_upper_limit(IN_FLIGHT)
            .set_read_batch_size(pace::LOOK_MAX)
            .set_max_request_batch(WRITE_BATCH)
            .set_connect_timeout(dial::CONNECT_TIMEOUT);
        self.show_secrets(&mut options);
        let reached = Arc::new(AtomicBool::new(false));
        let dialled = reached.clone();
        options.set_socket_connector(move |_, _| dial::dial(host.clone(), port, dialled.clone()));
        (options, reached)
    }

    /// Password and certificates.
    fn show_secrets(&self, options: &mut MqttOptions) {
        if let Some(credentials) = &self.broker.credentials {
            options.set_credentials(&credentials.username, credentials.password.reveal().to_owned());
        }
        if let Some(tls) = &self.prepared.tls {
            options.set_transport(Transport::tls_with_config(TlsConfiguration::Rustls(tls.clone())));
        }
    }

    /// The same connection with the current contents of the password and certificate files. If a file is unusable, the contents
    /// read before stay in use.
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

/// Returns when it is time to stop, or when no one is left to say so.
pub async fn stopped(stop: &mut watch::Receiver<bool>) {
    let _ = stop.wait_for(|&stop| stop).await;
}
