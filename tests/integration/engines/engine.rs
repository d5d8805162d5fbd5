//! The brokers under test, each with the users [`ALL`], who may do everything, and [`FEW`], who may use its own topics.

use tokio::net::TcpListener;
use tokio::task::JoinHandle;
use vibrissa_simulation::broker::{Limits, ModelBroker};
use vibrissa_supervisor::broker::Broker as Embedded;
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::rmqtt::Rmqtt;

use crate::artemis::Artemis;

/// User without limits.
pub(crate) const ALL: &str = "all";
/// User that may publish and subscribe on `whisker/v1/f/few/#` only.
pub(crate) const FEW: &str = "few";
/// Topic on which [`FEW`] may not publish. The model, which has no users, refuses it to all.
pub(crate) const FOREIGN: &str = "whisker/v1/f/r/setpoint";
/// Password of both.
pub(crate) const PASSWORD: &str = "correct-horse";

/// A kind of broker.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Engine {
    Embedded,
    Mosquitto,
    Rmqtt,
    RmqttCluster,
    Artemis,
    /// The broker of the simulation: it must do what real ones do. It is in no column of docs/brokers.md.
    Model,
}

impl Engine {
    /// All kinds, in the order of the columns of docs/brokers.md.
    pub(crate) const EVERY: [Self; 5] =
        [Self::Embedded, Self::Mosquitto, Self::Rmqtt, Self::RmqttCluster, Self::Artemis];

    /// Head of its column in docs/brokers.md.
    pub(crate) fn title(self) -> &'static str {
        match self {
            Self::Embedded => "embedded",
            Self::Mosquitto => "Mosquitto",
            Self::Rmqtt => "RMQTT",
            Self::RmqttCluster => "RMQTT, 3 nodes",
            Self::Artemis => "Artemis",
            Self::Model => "model",
        }
    }

    /// Starts it; `None` if it is not installed.
    pub(crate) async fn start(self) -> Option<Started> {
        Some(match self {
            Self::Embedded => Started::Embedded(Embedded::start(0).await.unwrap()),
            Self::Mosquitto => {
                let access =
                    format!("user {ALL}\ntopic readwrite #\nuser {FEW}\ntopic readwrite whisker/v1/f/{FEW}/#\n");
                Started::Mosquitto(Mosquitto::builder().user(ALL, PASSWORD).user(FEW, PASSWORD).acl(&access).start())
            }
            Self::Rmqtt => Started::Rmqtt(Rmqtt::start(1, &rmqtt_rules())?),
            Self::RmqttCluster => Started::Rmqtt(Rmqtt::start(3, &rmqtt_rules())?),
            Self::Artemis => Started::Artemis(Artemis::start()?),
            Self::Model => {
                let broker = ModelBroker::new(0, Limits::default());
                broker.refuse(FOREIGN);
                let listener = TcpListener::bind(("127.0.0.1", 0)).await.unwrap();
                let port = listener.local_addr().unwrap().port();
                Started::Model(port, tokio::spawn(async move { broker.listen(listener).await.unwrap() }))
            }
        })
    }
}

/// The users' permissions, in RMQTT's words.
fn rmqtt_rules() -> String {
    format!(
        r#"
    ["allow", {{ user = "{ALL}", password = "{PASSWORD}" }}, "connect"],
    ["allow", {{ user = "{FEW}", password = "{PASSWORD}" }}, "connect"],
    ["deny", "all", "connect"],
    ["allow", {{ user = "{ALL}" }}, "pubsub"],
    ["allow", {{ user = "{FEW}" }}, "pubsub", ["whisker/v1/f/{FEW}/#"]],
    ["deny", "all", "pubsub"],
"#
    )
}

/// A running broker; it ends on drop.
pub(crate) enum Started {
    Embedded(Embedded),
    Mosquitto(Mosquitto),
    Rmqtt(Rmqtt),
    Artemis(Artemis),
    /// Its port, and the task that accepts connections.
    Model(u16, JoinHandle<()>),
}

impl Started {
    /// MQTT ports of the nodes on 127.0.0.1.
    pub(crate) fn ports(&self) -> Vec<u16> {
        match self {
            Self::Embedded(broker) => vec![broker.address().port()],
            Self::Mosquitto(broker) => vec![broker.port()],
            Self::Rmqtt(cluster) => cluster.ports(),
            Self::Artemis(brokers) => brokers.ports.clone(),
            Self::Model(port, _) => vec![*port],
        }
    }

    /// Kills a node.
    pub(crate) fn kill(&mut self, node: usize) {
        match self {
            Self::Embedded(_) | Self::Model(..) => panic!("it runs in this process"),
            Self::Mosquitto(broker) => broker.kill(),
            Self::Rmqtt(cluster) => cluster.kill(node),
            Self::Artemis(brokers) => brokers.brokers[node].kill(),
        }
    }

    /// Ends the broker. Dropping one that runs in this process would not end it.
    pub(crate) async fn stop(self) {
        match self {
            Self::Embedded(broker) => broker.stop().await,
            Self::Model(_, accepting) => accepting.abort(),
            Self::Mosquitto(_) | Self::Rmqtt(_) | Self::Artemis(_) => {}
        }
    }
}
