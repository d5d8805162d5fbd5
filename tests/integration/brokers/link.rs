//! The service's two connections without its database.

use tokio::sync::{mpsc, watch};
use tokio::task::JoinHandle;
use vibrissa_protocol::{BootId, Name};
use vibrissa_store::secret::Secret;
use vibrissa_supervisor::metrics::{FleetMetrics, Metrics};
use vibrissa_supervisor::mqtt::{
    self, BrokerAddress, BrokerLink, ClientCertificate, Connection, Credentials, NodesInUse, TlsOptions,
};
use vibrissa_tests::wait::{until, until_true};

use vibrissa_supervisor::outbox::{Losses, Publication};

use vibrissa_supervisor::inbox::Inbox;

/// A password that must never appear in logs or on the network in plain text.
pub(crate) const PASSWORD: &str = "correct-horse-battery-staple";

/// Both connections of a fleet, running.
pub(crate) struct Link {
    pub(crate) metrics: FleetMetrics,
    /// Keeps the receiver open; it is not read.
    _inbox: Inbox,
    state: BrokerLink,
    outbox: mpsc::Sender<Publication>,
    stop: watch::Sender<bool>,
    tasks: [JoinHandle<()>; 2],
}

/// Address of a broker on this host, without TLS and user.
pub(crate) fn plain(port: u16) -> BrokerAddress {
    BrokerAddress::new("localhost", port)
}

/// The same with TLS and the authorities in this file.
pub(crate) fn tls(port: u16, ca_file: &std::path::Path) -> BrokerAddress {
    BrokerAddress { tls: Some(TlsOptions { ca_file: Some(ca_file.to_owned()), client: None }), ..plain(port) }
}

/// The same with a user and [`PASSWORD`].
pub(crate) fn with_password(address: BrokerAddress, username: &str) -> BrokerAddress {
    let credentials = Credentials { username: username.to_owned(), password: Secret::new(PASSWORD) };
    BrokerAddress { credentials: Some(credentials), ..address }
}

/// The same with a client certificate.
pub(crate) fn with_certificate(mut address: BrokerAddress, client: ClientCertificate) -> BrokerAddress {
    address.tls.as_mut().unwrap().client = Some(client);
    address
}

impl Link {
    /// Starts both connections for fleet `f`.
    pub(crate) fn start(broker: BrokerAddress) -> Self {
        let state = BrokerLink::default();
        let (prepared, fleet) = (mqtt::prepare(&broker).unwrap(), Name::new("f").unwrap());
        let mut connection = Connection::new(broker, prepared, fleet, BootId::new("s1").unwrap());
        (connection.epoch, connection.link) = (1, state.clone());
        let metrics = Metrics::new(false).unwrap().of_fleet(&connection.fleet);
        let (stop, stopped) = watch::channel(false);
        let (inbox, receiving) = mqtt::receive(&connection, metrics.clone(), stopped);
        let (outbox, publications) = mpsc::channel(10);
        let publishing = mqtt::publish(&connection, metrics.clone(), publications, Losses::default());
        Self { metrics, _inbox: inbox, state, outbox, stop, tasks: [tokio::spawn(receiving), publishing] }
    }

    /// The current problem of the connections, if any.
    pub(crate) fn problem(&self) -> Option<String> {
        self.state.problem()
    }

    /// The current problems of the connections.
    pub(crate) fn problems(&self) -> Vec<String> {
        self.state.problems()
    }

    /// Nodes that the connections use.
    pub(crate) fn nodes(&self) -> NodesInUse {
        self.state.nodes()
    }

    /// Waits until both connections are established.
    pub(crate) async fn connected(&self) {
        until_true("the connections", async || self.problem().is_none()).await;
        assert_eq!(self.metrics.broker_connected.get(), 1);
    }

    /// Waits for a problem whose text contains all of these words.
    pub(crate) async fn problem_with(&self, words: &[&str]) -> String {
        let mut last = None;
        let found = until(&format!("a problem with {words:?}"), async || {
            let problem = self.problem();
            if problem != last {
                eprintln!("{problem:?}");
                last.clone_from(&problem);
            }
            problem.filter(|problem| words.iter().all(|word| problem.contains(word)))
        })
        .await;
        assert_eq!(self.metrics.broker_connected.get(), 0, "{found}");
        assert!(!found.contains(PASSWORD), "{found}");
        found
    }

    /// Stops both connections in an orderly way.
    pub(crate) async fn stop(self) {
        let _ = self.stop.send(true);
        drop(self.outbox);
        for task in self.tasks {
            task.await.unwrap();
        }
    }
}
