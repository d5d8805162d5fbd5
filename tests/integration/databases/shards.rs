//! Shards: one fleet at several supervisors, and changes of the number of shards while robots send.

use nix::sys::signal::Signal;
use vibrissa_edge::shard::{FleetShard, robot_hash};
use vibrissa_simulator::{Broker, Fleet, Scenario};
use vibrissa_store::shards::NotDivided;
use vibrissa_store::{Lease, Store, StoreError};
use vibrissa_tests::actions::{asks, asks_of};
use vibrissa_tests::wait::{until, until_true};

use crate::rows::{self, contacts};
use crate::supervisors::Stage;
use crate::{Fresh, fleet, supervisor};

/// The shards' robots, epochs and actions after a division, on both databases.
async fn robots_and_actions_follow_their_shards(database: &Fresh) {
    let a = supervisor("a");
    let mut writer = database.store.writer();
    writer.sign_in(&a, &[]).await.unwrap();
    let whole = writer.acquire(&a, &fleet()).await.unwrap().unwrap();
    let names: Vec<String> = (0..12).map(|number| format!("r{number}")).collect();
    for name in &names {
        let numbered = rows::numbered(&mut writer, &whole, name).await;
        writer.commit(&whole, &rows::states(&numbered)).await.unwrap();
        writer.commit(&whole, &contacts(&numbered, 0..3)).await.unwrap();
    }
    writer.want_shards(&fleet(), 3).await.unwrap();
    writer.want_shards(&fleet(), 2).await.unwrap();
    let membership = writer.sign_in(&a, std::slice::from_ref(&whole)).await.unwrap();
    assert_eq!(membership.leases[0].shards_wanted, 3, "the number is only raised");
    assert_eq!(writer.divide(std::slice::from_ref(&whole), 3).await.unwrap(), Ok(()));

    // The old lease is worth nothing, and the new ones come after it.
    let old = writer.robot_id(&whole, "r0", 2).await.unwrap_err();
    assert!(matches!(old, StoreError::LeaseLost { .. }), "{old}");
    assert!(writer.acquire(&a, &fleet()).await.unwrap().is_none(), "the whole fleet is no shard any more");
    let mut leases: Vec<Lease> = Vec::new();
    for shard in FleetShard::all(&fleet(), 3) {
        leases.push(writer.acquire_shard(&a, &shard).await.unwrap().unwrap());
    }
    assert!(leases.iter().all(|lease| lease.epoch() > whole.epoch()));
    let membership = writer.sign_in(&a, &leases).await.unwrap();
    assert_eq!(membership.leases.len(), 3);
    assert!(membership.leases.iter().all(|lease| !lease.free && lease.shard.count() == 3), "{membership:?}");

    // Each robot is in the shard of its name's hash.
    let mut found = 0;
    for lease in &leases {
        for robot in writer.robots(lease).await.unwrap() {
            assert_eq!(robot_hash("f", &robot.robot) % 3, lease.shard().number(), "{}", robot.robot);
            assert_eq!(robot.whisker_states.len(), 2);
            found += 1;
        }
    }
    assert_eq!(found, names.len());

    // Actions of robots go to their shards; those of unknown robots and of the fleet to the first.
    let of_robot =
        |name: &str| vibrissa_store::actions::NewAction { robot: Some(name.to_owned()), ..asks_of("HOLD", "{}", None) };
    for name in names.iter().map(String::as_str).chain(["stranger"]) {
        database.store.ask(&of_robot(name)).await.unwrap();
    }
    database.store.ask(&asks("POLICY", r#"{"expected_version":0}"#)).await.unwrap();
    for lease in &leases {
        let pending = writer.pending(lease, 100).await.unwrap();
        let mut robots: Vec<&str> = pending.iter().filter_map(|one| one.robot.as_deref()).collect();
        robots.sort_unstable();
        let first = lease.shard().is_first();
        let mut expected: Vec<&str> = names.iter().map(String::as_str).filter(|name| lease.shard().has(name)).collect();
        expected.extend(first.then_some("stranger"));
        expected.sort_unstable();
        assert_eq!(robots, expected);
        assert_eq!(pending.iter().any(|one| one.kind == "POLICY"), first, "the others wait for the first");
    }
    assert_eq!(writer.divide(&leases, 4).await.unwrap(), Err(NotDivided::ActionPending));
    writer.keep_shards(&fleet()).await.unwrap();
}

#[tokio::test]
async fn in_sqlite_robots_and_actions_follow_their_shards() {
    robots_and_actions_follow_their_shards(&Fresh::sqlite().await).await;
}

#[tokio::test]
async fn in_postgresql_robots_and_actions_follow_their_shards() {
    robots_and_actions_follow_their_shards(&Fresh::postgres().await).await;
}

/// Twelve robots with 600 contacts per second.
fn crowd(broker_port: u16, names: std::ops::Range<u32>) -> Fleet {
    let mut scenario = "fleet = \"f\"\nseed = 7\n[behaviour]\ncontacts_per_second = 25.0\ncontacts_per_message = 5\n\
         message_after_s = 0.2\n"
        .to_owned();
    for name in names {
        scenario += &format!(
            "[[robots]]\nrobot = \"r{name}\"\narrays = [{{ array = \"left\", type = \"TYPE_2\", \
             whiskers = [{{ whisker = 0 }}, {{ whisker = 1 }}] }}]\n"
        );
    }
    Fleet::start(&Scenario::from_toml_str(&scenario).unwrap(), &Broker::new("127.0.0.1", broker_port)).unwrap()
}

#[tokio::test]
async fn a_fleet_is_divided_while_its_robots_send_and_each_contact_is_recorded_once() {
    let stage = Stage::new().await;
    let a = stage.replica("a", "f", 1.0);
    until_true("a has it", async || stage.count_of("a").await == 1).await;
    let robots = crowd(stage.broker_port(), 0..12);
    stage.more_recorded(200).await;
    // A supervisor that wants four shards joins.
    let mut b = stage.replica_with("b", "f", 1.0, &["--fleet-shards", "4"]);
    until_true("two shards each", async || (stage.count_of("a").await, stage.count_of("b").await) == (2, 2)).await;
    stage.more_recorded(400).await;
    // Robots that nobody knew are heard by the owner of their shard.
    let late = crowd(stage.broker_port(), 12..16);
    let robots_known = async || stage.number("SELECT count(*) FROM robots WHERE connection = 'ONLINE'").await == 16;
    until_true("late robots known", robots_known).await;
    // A change of the policy reaches all shards: that of the fleet, and one action for each other shard.
    let store = Store::open(&stage.database(), "test").await.unwrap();
    store.ask(&asks("POLICY", r#"{"expected_version": 0, "mode": "ADVISE", "change_margin": 0.07}"#)).await.unwrap();
    let executed =
        async || stage.number("SELECT count(*) FROM actions WHERE kind = 'POLICY' AND state = 'DONE'").await == 4;
    until_true("the policy is in force in all shards", executed).await;
    store.close().await;
    // The owner of two shards is killed, and then that of all is frozen: it writes nothing when it comes back.
    b.kill();
    until_true("a has all", async || stage.count_of("a").await == 4).await;
    stage.more_recorded(400).await;
    a.signal(Signal::SIGSTOP);
    let c = stage.replica("c", "f", 1.0);
    until_true("c has all", async || stage.count_of("c").await == 4).await;
    a.signal(Signal::SIGCONT);
    until("a stands by or shares", async || a.ready().await.filter(|(code, _)| *code == 200)).await;
    stage.more_recorded(400).await;
    for fleet in [&robots, &late] {
        fleet.rest();
    }
    until_true("every message receipted", async || robots.is_receipted() && late.is_receipted()).await;
    let made = (robots.contacts_made() + late.contacts_made()) as i64;
    assert_eq!(stage.counted().await, (made, made));
    drop(c);
    robots.stop().await;
    late.stop().await;
}
