//! The shipped access list, on a Mosquitto with the shipped configuration.

use vibrissa_protocol::RobotTopic;
use vibrissa_tests::mosquitto::{Builder, Mosquitto};

use crate::client::{Client, Who};
use crate::link::PASSWORD;

const CONFIGURATION: &str = include_str!("../../../deploy/mosquitto/mosquitto.conf");
const ACL: &str = include_str!("../../../deploy/mosquitto/acl");

/// Topics that a robot must not read, and as the last ones the requests to all robots and its own `setpoint`.
const CURIOUS: [&str; 10] = [
    "#",
    "+/+/+/+/+",
    "whisker/v1/#",
    "whisker/v1/lab/#",
    "whisker/v1/+/+/setpoint",
    "whisker/v1/+/+/contacts",
    "whisker/v1/lab/two/setpoint",
    "whisker/v1/lab/supervisor/state",
    "whisker/v1/lab/supervisor/request",
    "whisker/v1/lab/one/setpoint",
];

/// The shipped broker with users for the supervisor, two robots of fleet `lab` and one of fleet `yard`.
pub(crate) fn shipped(configuration: &str) -> Builder {
    let builder = Mosquitto::builder().file(configuration).acl(ACL).supervisor("vibrissa", PASSWORD);
    ["lab/one", "lab/two", "yard/one"].into_iter().fold(builder, |builder, user| builder.user(user, PASSWORD))
}

/// Connects a client to the listener of its user.
pub(crate) async fn client(broker: &Mosquitto, id: &str, user: &str) -> Client {
    let who = Who { id, user: Some((user, PASSWORD)), ..Who::default() };
    let port = if user == "vibrissa" { broker.supervisor_port() } else { broker.port() };
    Client::connect(port, &who).await.unwrap_or_else(|| panic!("{user} is refused"))
}

fn topic(level: &str, kind: RobotTopic) -> String {
    format!("whisker/v1/{level}/{kind}")
}

#[tokio::test]
async fn a_robot_writes_its_own_level_in_the_contracts_direction_and_nothing_else() {
    let broker = shipped(CONFIGURATION).start();
    let mut robot = client(&broker, "lab.one", "lab/one").await;
    for kind in RobotTopic::ALL {
        assert_eq!(robot.publish(&topic("lab/one", kind), false).await, kind.is_from_robot(), "own {kind}");
        for level in ["lab/two", "yard/one", "lab/supervisor", "lab/three"] {
            assert!(!robot.publish(&topic(level, kind), false).await, "{level}/{kind}");
        }
    }
    for forbidden in [
        "whisker/v1/lab/supervisor/state",
        "whisker/v1/lab/supervisor/request",
        "whisker/v1/yard/supervisor/request",
        "whisker/v1/lab/supervisor/contacts",
        "whisker/v1/yard/supervisor/state",
        "whisker/v1/lab/supervisor/contacts/more",
        "whisker/v1/lab/one/state",
        "whisker/v1/lab/one/contacts/more",
        "whisker/v1/lab/one",
        "whisker/v2/lab/one/contacts",
        "anything",
        "$SYS/broker/version",
    ] {
        assert!(!robot.publish(forbidden, false).await, "{forbidden}");
    }
}

#[tokio::test]
async fn a_robot_hears_what_is_meant_for_it_and_nothing_else() {
    let broker = shipped(CONFIGURATION).start();
    let mut supervisor = client(&broker, "s", "vibrissa").await;
    let mut other = client(&broker, "lab.two", "lab/two").await;
    // One message is retained before the subscription, others are published afterwards.
    assert!(supervisor.publish("whisker/v1/lab/supervisor/state", true).await);
    assert!(other.publish("whisker/v1/lab/two/connection", true).await);
    let mut robot = client(&broker, "lab.one", "lab/one").await;
    for filter in CURIOUS {
        robot.subscribe(filter).await;
    }
    for level in ["lab/two", "yard/one"] {
        for kind in [RobotTopic::Setpoint, RobotTopic::Receipt, RobotTopic::Request, RobotTopic::Estimate] {
            assert!(supervisor.publish(&topic(level, kind), false).await);
        }
    }
    assert!(other.publish("whisker/v1/lab/two/contacts", false).await);
    assert!(supervisor.publish("whisker/v1/lab/supervisor/state", true).await);
    assert!(supervisor.publish("whisker/v1/lab/supervisor/request", false).await);
    for kind in [RobotTopic::Estimate, RobotTopic::Receipt, RobotTopic::Request, RobotTopic::Setpoint] {
        assert!(supervisor.publish(&topic("lab/one", kind), false).await);
    }
    let mut heard = robot.heard_until("whisker/v1/lab/one/setpoint").await;
    heard.sort();
    heard.dedup();
    let mut own =
        ["estimate", "receipt", "request", "setpoint"].map(|kind| format!("whisker/v1/lab/one/{kind}")).to_vec();
    own.push("whisker/v1/lab/supervisor/request".to_owned());
    assert_eq!(heard, own);
}

#[tokio::test]
async fn regress_the_supervisors_user_hears_all_of_a_recording_and_nothing_else() {
    let broker = shipped(CONFIGURATION).start();
    let mut listener = client(&broker, "listener", "vibrissa").await;
    listener.subscribe("#").await;
    let mut supervisor = client(&broker, "s", "vibrissa").await;
    for kind in RobotTopic::ALL {
        // It clears the retained messages of decommissioned robots.
        let may = !kind.is_from_robot() || kind.is_retained();
        assert_eq!(supervisor.publish(&topic("lab/one", kind), false).await, may, "{kind}");
    }
    assert!(supervisor.publish("whisker/v1/lab/supervisor/state", false).await);
    assert!(supervisor.publish("whisker/v1/lab/supervisor/request", false).await);
    for kind in RobotTopic::ALL.into_iter().filter(|kind| kind.is_from_robot()) {
        // The supervisor's probes. `listener` receives them, too; they are removed below.
        assert!(supervisor.publish(&topic("lab/supervisor", kind), false).await, "a probe of {kind}");
    }
    assert!(!supervisor.publish("anything", false).await);
    let mut robot = client(&broker, "lab.one", "lab/one").await;
    for kind in RobotTopic::ALL.into_iter().filter(|kind| kind.is_from_robot()) {
        assert!(robot.publish(&topic("lab/one", kind), false).await);
    }
    let robots: Vec<_> = RobotTopic::ALL.into_iter().filter(|kind| kind.is_from_robot()).collect();
    let mut heard = listener.heard_until(&topic("lab/one", *robots.last().unwrap())).await;
    let all = heard.len();
    heard.retain(|topic| RobotTopic::probed_on(topic).is_none());
    assert_eq!(all - heard.len(), robots.len(), "expected all probes");
    heard.sort();
    // Topics that the supervisor may clear were heard from both.
    heard.dedup();
    // `vibrissa record` uses this user: what supervisors write to robots is heard, too.
    let mut expected: Vec<_> = RobotTopic::ALL.into_iter().map(|kind| topic("lab/one", kind)).collect();
    // The supervisor must receive messages in its own name, to correct them. Every user may read requests to all robots.
    expected.extend(["state", "request"].map(|last| format!("whisker/v1/lab/supervisor/{last}")));
    expected.sort();
    assert_eq!(heard, expected);
}

#[tokio::test]
async fn wills_are_subject_to_it_too() {
    let broker = shipped(CONFIGURATION).start();
    let mut supervisor = client(&broker, "s", "vibrissa").await;
    supervisor.subscribe("whisker/v1/+/+/connection").await;
    for (id, topic) in [("a", "whisker/v1/lab/two/connection"), ("b", "whisker/v1/lab/one/connection")] {
        let who = Who { id, user: Some(("lab/one", PASSWORD)), will: Some(topic) };
        // Dropping the connection triggers its will. A broker may also refuse such a will at once.
        drop(Client::connect(broker.port(), &who).await);
    }
    assert_eq!(supervisor.heard_until("whisker/v1/lab/one/connection").await, ["whisker/v1/lab/one/connection"]);
}

#[tokio::test]
async fn nobody_without_a_name_and_a_password_is_let_in() {
    let broker = shipped(CONFIGURATION).start();
    let wrong =
        [None, Some(("lab/one", "wrong")), Some(("lab/one", "")), Some(("lab/three", PASSWORD)), Some(("", ""))];
    for user in wrong {
        let who = Who { id: "c", user, ..Who::default() };
        assert!(Client::connect(broker.port(), &who).await.is_none(), "{user:?}");
    }
}

#[tokio::test]
async fn tricks_in_the_names_of_users_and_clients_get_nothing() {
    let tricks =
        ["+", "#", "lab/+", "+/+", "lab/#", "lab", "lab/", "/", "lab/one/", "lab//one", "../one", "%u", "lab/%u"];
    let broker = tricks.iter().fold(shipped(CONFIGURATION), |builder, user| builder.user(user, PASSWORD)).start();
    let mut supervisor = client(&broker, "s", "vibrissa").await;
    let tricky_ids = [("lab/one", "+"), ("lab/one", "a#"), ("lab/one", "lab/two"), ("lab/one", "vibrissa")];
    let users = tricks.into_iter().map(|user| (user, "c")).chain(tricky_ids);
    for (user, id) in users {
        let who = Who { id, user: Some((user, PASSWORD)), ..Who::default() };
        let Some(mut trickster) = Client::connect(broker.port(), &who).await else {
            assert_eq!(user, "#", "only # is a comment in the list of users");
            continue;
        };
        for forbidden in [
            "whisker/v1/lab/two/contacts",
            "whisker/v1/lab/two/setpoint",
            "whisker/v1/yard/one/contacts",
            "whisker/v1/lab/supervisor/state",
        ] {
            assert!(!trickster.publish(forbidden, false).await, "{user} as {id}: {forbidden}");
        }
        for filter in CURIOUS {
            trickster.subscribe(filter).await;
        }
        assert!(supervisor.publish("whisker/v1/lab/two/setpoint", false).await);
        assert!(supervisor.publish("whisker/v1/yard/one/setpoint", false).await);
        // Own messages cannot come back, so every received message is a violation.
        let heard = trickster.heard_for_a_moment().await;
        assert_eq!(heard, Vec::<String>::new(), "{user} as {id}");
    }
}
