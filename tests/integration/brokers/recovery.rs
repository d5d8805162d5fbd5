//! Brokers that stop and start again, and services that share a broker.

use tempfile::TempDir;
use vibrissa_supervisor::mqtt::{BrokerAddress, ClientCertificate};
use vibrissa_tests::certificates::{Authority, Validity, write};
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::wait::until_true;

use crate::link::{Link, PASSWORD, plain, tls, with_certificate, with_password};
use crate::running::{Running, everything_is_recorded, fleet};

/// A broker with TLS, a client certificate for the supervisor, and users.
fn broker(folder: &TempDir) -> (Mosquitto, BrokerAddress) {
    let authority = Authority::new("ours");
    let ca_file = write(folder.path(), "ca.crt", &authority.certificate());
    let broker = Mosquitto::builder()
        .tls(authority.server(&["localhost"], Validity::Now))
        .line(&format!("cafile {}", ca_file.display()))
        .user("vibrissa", PASSWORD)
        .user("lab/one", PASSWORD)
        .user("lab/two", PASSWORD)
        .start();
    let own = authority.client("vibrissa");
    let client = ClientCertificate {
        certificate_file: write(folder.path(), "me.crt", &own.certificate),
        key_file: write(folder.path(), "me.key", &own.key),
    };
    let address = with_password(with_certificate(tls(broker.port(), &ca_file), client), "vibrissa");
    (broker, address)
}

#[tokio::test]
async fn a_broker_with_tls_and_passwords_that_is_killed_is_used_again_and_nothing_is_lost() {
    let folder = tempfile::tempdir().unwrap();
    let (mut broker, address) = broker(&folder);
    let running = Running::start(address).await;
    let fleet = fleet(broker.port(), Some(&folder.path().join("ca.crt")));
    until_true("contacts", async || running.contacts().await > 100).await;
    broker.kill();
    until_true("no connection", async || !running.is_connected()).await;
    let during = fleet.contacts_made();
    until_true("contacts without a broker", async || fleet.contacts_made() > during + 20).await;
    broker.restart();
    // These contacts arrive only after new subscriptions.
    everything_is_recorded(&fleet, &running, 100).await;
    assert!(running.is_connected());
    fleet.stop().await;
    running.service.stop().await;
}

#[tokio::test]
async fn a_killed_broker_is_a_problem_until_it_is_back() {
    let mut broker = Mosquitto::start();
    let link = Link::start(plain(broker.port()));
    link.connected().await;
    broker.kill();
    link.problem_with(&["nothing listens there"]).await;
    broker.restart();
    link.connected().await;
    link.stop().await;
}

#[tokio::test]
async fn a_broker_that_stops_answering_is_noticed() {
    let broker = Mosquitto::start();
    let link = Link::start(plain(broker.port()));
    link.connected().await;
    let frozen = broker.freeze();
    // Within two keep-alive intervals of 6 s.
    link.problem_with(&["stopped answering"]).await;
    drop(frozen);
    link.connected().await;
    link.stop().await;
}

#[tokio::test]
async fn two_services_for_one_fleet_do_not_throw_each_other_out() {
    let broker = Mosquitto::builder().line("connection_messages true").start();
    let (one, other) = (Running::start(plain(broker.port())).await, Running::start(plain(broker.port())).await);
    let fleet = fleet(broker.port(), None);
    until_true("contacts at both", async || one.contacts().await > 100 && other.contacts().await > 100).await;
    for running in [&one, &other] {
        assert!(running.is_connected());
    }
    assert_eq!(broker.logged("already connected"), 0, "two clients used the same client id");
    fleet.stop().await;
    one.service.stop().await;
    other.service.stop().await;
}
