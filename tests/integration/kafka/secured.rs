//! Brokers that ask for credentials over TLS.

use tempfile::TempDir;
use vibrissa_protocol::ArrayType;
use vibrissa_tests::certificates::{Authority, Validity, write};
use vibrissa_tests::kafka::{Kafka, PASSWORD, START, USER};
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::{until_true, until_within};

use crate::published::topics;
use crate::stage::{Events, Program};

/// A secured broker, and a folder with the files of the supervisor.
async fn secured() -> Option<(Kafka, TempDir)> {
    let folder = tempfile::tempdir().unwrap();
    let (authority, stranger) = (Authority::new("authority"), Authority::new("stranger"));
    let own = authority.server(&["127.0.0.1"], Validity::Now);
    let identity = write(folder.path(), "broker.pem", &(own.key + &own.certificate));
    write(folder.path(), "ca.pem", &authority.certificate());
    write(folder.path(), "stranger.pem", &stranger.certificate());
    write(folder.path(), "password", PASSWORD);
    write(folder.path(), "wrong", "wrong");
    Some((Kafka::start_secured(identity).await?, folder))
}

/// Starts a supervisor that publishes with this file of authorities, file with the password, and mechanism.
async fn program(broker: &Mosquitto, kafka: &Kafka, folder: &TempDir, [ca, password, sasl]: [&str; 3]) -> Program {
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (url, ca, password) = (kafka.secured_url(), path(ca), path(password));
    let arguments = [
        ["--publish", "kafka"],
        ["--kafka-url", &url],
        ["--kafka-ca-file", &ca],
        ["--kafka-username", USER],
        ["--kafka-password-file", &password],
        ["--kafka-sasl", sasl],
    ];
    Program::start(broker.port(), arguments.as_flattened()).await
}

#[tokio::test]
async fn events_reach_a_broker_with_tls_and_each_kind_of_credentials() {
    let Some((kafka, folder)) = secured().await else { return };
    topics(&kafka).await;
    let mut events = Events::of(&kafka).await;
    for (sasl, name) in [("scram-sha-512", "r"), ("scram-sha-256", "s"), ("plain", "t")] {
        let broker = Mosquitto::start();
        let _program = program(&broker, &kafka, &folder, ["ca.pem", "password", sasl]).await;
        let mut robot = HandRobot::born(broker.port(), name, array(ArrayType::Type2, &[70.0])).await;
        events.of_another_database();
        let before = events.contacts().len();
        robot.touch(0, 20).await;
        robot.receipted().await;
        until_true(&format!("contacts over {sasl}"), async || {
            events.read().await;
            events.contacts().len() == before + 20
        })
        .await;
    }
}

#[tokio::test]
async fn wrong_credentials_and_authorities_are_named_and_robots_are_served_meanwhile() {
    let Some((kafka, folder)) = secured().await else { return };
    topics(&kafka).await;
    for (files, part) in [
        (["ca.pem", "wrong", "scram-sha-512"], "the brokers refuse the credentials"),
        (["stranger.pem", "password", "scram-sha-512"], "cannot be trusted, check kafka.ca_file"),
    ] {
        let broker = Mosquitto::start();
        let program = program(&broker, &kafka, &folder, files).await;
        let mut robot = HandRobot::born(broker.port(), "r", array(ArrayType::Type2, &[70.0])).await;
        robot.touch(0, 20).await;
        robot.receipted().await;
        let is_named = async || program.log().lines().any(|line| line.contains(part)).then_some(());
        until_within(START, part, is_named).await;
        assert!(!program.log().contains(PASSWORD), "{}", program.log());
    }
}
