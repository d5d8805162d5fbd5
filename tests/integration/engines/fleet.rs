//! A fleet on each engine: a cut, its compensation, and no lost contact.

use std::time::Instant;

use vibrissa_simulator::Fleet;
use vibrissa_tests::wait::until_true;

use crate::engine::Engine;
use crate::running::{LEARNED, Running, cut, robots, touches};

/// Contacts of each robot before a cut: both whiskers have learned.
const BEFORE: u64 = 4 * LEARNED as u64;

/// Stops the contacts, and waits until each one has a receipt.
async fn everything_is_receipted(fleet: &Fleet) {
    fleet.rest();
    until_true("every message receipted", async || fleet.is_receipted()).await;
}

/// One broker: supervisor and robots meet there.
async fn works_on(engine: Engine) {
    let Some(started) = engine.start().await else { return };
    let ports = started.ports();
    // First the supervisor: Artemis does not link topics to a subscription if both are new at the same moment.
    let running = Running::start(&ports).await;
    let fleet = robots(&ports);
    running.knows(&fleet).await;
    touches(&fleet, BEFORE).await;
    cut(&fleet, "one", 65.0);
    running.applied("one", 0).await;
    everything_is_receipted(&fleet).await;
    fleet.stop().await;
    running.service.stop().await;
    started.stop().await;
}

#[tokio::test]
async fn a_fleet_works_on_the_embedded_broker() {
    works_on(Engine::Embedded).await;
}

#[tokio::test]
async fn a_fleet_works_on_mosquitto() {
    works_on(Engine::Mosquitto).await;
}

#[tokio::test]
async fn a_fleet_works_on_rmqtt() {
    works_on(Engine::Rmqtt).await;
}

#[tokio::test]
async fn a_fleet_works_on_artemis() {
    works_on(Engine::Artemis).await;
}

#[tokio::test]
async fn a_fleet_works_on_the_model_broker() {
    works_on(Engine::Model).await;
}

/// Robots at the last node; the supervisor prefers the first one, which is killed.
#[tokio::test]
async fn a_fleet_survives_the_node_of_its_supervisor() {
    let Some(mut started) = Engine::RmqttCluster.start().await else { return };
    let ports = started.ports();
    let [first, second, third] = ports[..] else { panic!("three nodes") };
    let fleet = robots(&[third, second]);
    let running = Running::start(&ports).await;
    running.knows(&fleet).await;
    assert_eq!(running.nodes().await, Some([first, first]));
    touches(&fleet, BEFORE).await;
    cut(&fleet, "one", 65.0);
    let applied = running.applied("one", 0).await;

    started.kill(0);
    let killed = Instant::now();
    until_true("another node", async || {
        running.nodes().await.is_some_and(|nodes| nodes.iter().all(|node| [second, third].contains(node)))
    })
    .await;
    eprintln!("RMQTT: the supervisor hears and answers robots at another node after {:?}", killed.elapsed());
    cut(&fleet, "two", 65.0);
    running.applied("two", 0).await;
    eprintln!("RMQTT: a cut after that is compensated after {:?}", killed.elapsed());
    assert!(applied > 0);

    // The next owner begins at the third node, and knows the robots within seconds.
    let folder = running.stop().await;
    let begun = Instant::now();
    let running = Running::on(folder, &[third, second]).await;
    running.knows(&fleet).await;
    eprintln!("RMQTT: the next owner knows the robots after {:?}", begun.elapsed());
    everything_is_receipted(&fleet).await;
    fleet.stop().await;
    running.service.stop().await;
}
