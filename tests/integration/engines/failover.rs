//! A pair of Artemis brokers: the primary is killed, and the fleet goes on at the backup.

use std::time::{Duration, Instant};

use vibrissa_tests::wait::until_true;

use crate::artemis::Artemis;
use crate::running::{LEARNED, Running, cut, robots, touches};

#[tokio::test]
async fn a_fleet_goes_on_at_the_backup_when_the_primary_is_killed() {
    let Some(mut pair) = Artemis::start_pair() else { return };
    let ports = pair.ports.clone();
    let running = Running::start(&ports).await;
    // The order does not matter: only one of the two listens.
    let fleet = robots(&[ports[1], ports[0]]);
    running.knows(&fleet).await;
    touches(&fleet, 4 * LEARNED as u64).await;

    pair.brokers[0].kill();
    let killed = Instant::now();
    until_true("the backup", async || running.nodes().await == Some([ports[1], ports[1]])).await;
    let took = killed.elapsed();
    eprintln!("Artemis: the supervisor hears and answers robots at the backup after {took:?}");
    assert!(took < Duration::from_secs(15), "{took:?}");
    cut(&fleet, "one", 65.0);
    running.applied("one", 0).await;
    eprintln!("Artemis: a cut after that is compensated after {:?}", killed.elapsed());
    fleet.rest();
    until_true("every message receipted", async || fleet.is_receipted()).await;
    fleet.stop().await;
    running.service.stop().await;
}
