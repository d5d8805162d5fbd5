//! Shards: one fleet at several supervisors, and changes of the number of shards while robots send.

use nix::sys::signal::Signal;
use serde_json::{Value, json};
use vibrissa_edge::shard::{FleetShard, robot_hash};
use vibrissa_simulator::{Broker, Fleet, Scenario};
use vibrissa_store::shards::NotDivided;
use vibrissa_store::{Lease, Store, StoreError};
use vibrissa_tests::actions::{asks, asks_of};
use vibrissa_tests::wait::{until, until_true};
use vibrissa_tests::web::send;

use crate::rows::{self, contacts};
use crate::supervisors::{Replica, Stage};
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
    let old = writer.register(&whole, ("r0", "b"), 2).await.unwrap_err();
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

    // Each robot is in the shard of its name's hash. Robots come in any portions.
    let mut found = 0;
    for (lease, portion) in leases.iter().zip([1, 2, 100]) {
        let mut after = 0;
        loop {
            let some = writer.robots(lease, after, portion).await.unwrap().robots;
            assert!(some.len() <= portion as usize && some.is_sorted_by_key(|robot| robot.robot_id));
            let Some(last) = some.last() else { break };
            after = last.robot_id;
            for robot in some {
                assert_eq!(robot_hash("f", &robot.robot) % 3, lease.shard().number(), "{}", robot.robot);
                assert_eq!((robot.whisker_states.len(), robot.boots.len()), (2, 1));
                let alone = writer.robot(lease, robot.robot_id).await.unwrap().unwrap();
                assert_eq!((alone.robot, alone.whisker_ids), (robot.robot, robot.whisker_ids));
                for other in leases.iter().filter(|other| other.shard() != lease.shard()) {
                    assert!(writer.robot(other, robot.robot_id).await.unwrap().is_none(), "not its next robot either");
                }
                found += 1;
            }
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
        let pending = writer.pending(lease, 100).await.unwrap().actions;
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

/// One transaction acquires the shards that are free, and leaves the others to their owner.
#[tokio::test]
async fn in_postgresql_the_free_shards_are_acquired_together() {
    let database = Fresh::postgres().await;
    let (a, b) = (supervisor("a"), supervisor("b"));
    let (mut first, mut second) = (database.store.writer(), database.store.writer());
    first.sign_in(&a, &[]).await.unwrap();
    let whole = first.acquire(&a, &fleet()).await.unwrap().unwrap();
    first.want_shards(&fleet(), 5).await.unwrap();
    assert_eq!(first.divide(std::slice::from_ref(&whole), 5).await.unwrap(), Ok(()));
    let all: Vec<FleetShard> = FleetShard::all(&fleet(), 5).collect();
    let of_a = first.acquire_shards(&a, &all[1..3]).await.unwrap();
    assert_eq!(of_a.len(), 2);
    second.sign_in(&b, &[]).await.unwrap();
    let of_b = second.acquire_shards(&b, &all).await.unwrap();
    assert_eq!(of_b.iter().map(|lease| lease.shard().number()).collect::<Vec<_>>(), [0, 3, 4]);
    // A robot may move to any shard: no two leases of a fleet have the same epoch.
    let mut epochs: Vec<u64> = of_a.iter().chain(&of_b).map(Lease::epoch).collect();
    assert!(of_b.windows(2).all(|pair| pair[0].epoch() < pair[1].epoch()), "{epochs:?}");
    epochs.sort_unstable();
    epochs.dedup();
    assert_eq!(epochs.len(), 5);
    assert!(second.acquire_shards(&b, &all[1..3]).await.unwrap().is_empty(), "they have an owner");
    let membership = first.sign_in(&a, &of_a).await.unwrap();
    let owned_by =
        |id: &str| membership.leases.iter().filter(|lease| !lease.free && lease.owner.as_deref() == Some(id)).count();
    assert_eq!((owned_by(&a.id), owned_by(&b.id)), (2, 3));
}

/// Twelve robots with 600 contacts per second.
pub(crate) fn crowd(broker_port: u16, names: std::ops::Range<u32>) -> Fleet {
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

/// A database that supervisors without further arguments use, one after the other.
struct Place<'a> {
    stage: &'a Stage,
    url: String,
}

impl<'a> Place<'a> {
    fn sqlite(stage: &'a Stage) -> Self {
        Self { stage, url: format!("sqlite:{}", stage.folder().join("v.sqlite3").display()) }
    }

    fn postgres(stage: &'a Stage) -> Self {
        Self { stage, url: stage.database_url() }
    }

    fn supervisor(&self, fault: Option<&str>) -> Replica {
        let place = (self.stage.folder(), self.stage.broker_port());
        Replica::start_with(place, "a", "f", &self.url, 1.0, &[], fault)
    }

    /// Number of contacts, and of their different names.
    async fn counted(&self) -> (i64, i64) {
        const SQL: &str = "SELECT count(*), count(DISTINCT CAST(boot AS TEXT) || ' ' || CAST(seq AS TEXT) || ' ' || \
             CAST(position AS TEXT)) FROM contacts";
        match self.url.strip_prefix("sqlite:") {
            Some(path) => {
                let options = sqlx::sqlite::SqliteConnectOptions::new().filename(path).read_only(true);
                let mut link = sqlx::ConnectOptions::connect(&options).await.unwrap();
                sqlx::query_as(SQL).fetch_one(&mut link).await.unwrap()
            }
            None => self.stage.counted().await,
        }
    }

    async fn more_recorded(&self, more: i64) {
        let goal = self.counted().await.0 + more;
        until_true("more contacts recorded", async || self.counted().await.0 >= goal).await;
    }
}

async fn set_shards(replica: &Replica, body: Value) -> (u16, Value) {
    let answer = send(replica.http(), "PUT", "/v1/fleets/f/shards", &[], Some(&body)).await.unwrap();
    (answer.status, answer.json())
}

/// Waits until this number of shards is owned, and returns them.
async fn owns(replica: &Replica, count: usize) -> Vec<Value> {
    until(&format!("{count} shards"), async || {
        let answer = send(replica.http(), "GET", "/v1/fleets/f/shards", &[], None).await.ok()?;
        let items = answer.json()["items"].as_array().cloned().unwrap_or_default();
        let is_owned = |one: &Value| one["supervised"] == true && one["holder"] == "a" && one["began_at"].is_string();
        (items.len() == count && items.iter().all(is_owned)).then_some(items)
    })
    .await
}

/// Every contact is receipted and recorded once.
async fn each_contact_is_recorded_once(place: &Place<'_>, robots: Fleet) {
    robots.rest();
    until_true("every message receipted", async || robots.is_receipted()).await;
    let made = robots.contacts_made() as i64;
    until_true("every contact recorded", async || place.counted().await.0 >= made).await;
    assert_eq!(place.counted().await, (made, made));
    robots.stop().await;
}

async fn the_number_is_raised_and_lowered_by_request(place: &Place<'_>) {
    let a = place.supervisor(None);
    a.says(200, "OWNED").await;
    let robots = crowd(place.stage.broker_port(), 0..8);
    place.more_recorded(200).await;
    let mut last_epoch = 0;
    for count in [5, 2, 1] {
        let (status, told) = set_shards(&a, json!({ "shards": count, "reason": "growth" })).await;
        assert_eq!((status, &told["kind"], &told["state"]), (202, &json!("SHARDS"), &json!("DONE")), "{told}");
        let shards = owns(&a, count).await;
        let of_robots: i64 = shards.iter().map(|one| one["robots"].as_i64().unwrap()).sum();
        assert_eq!(of_robots, 8, "{shards:?}");
        let epoch = shards.iter().map(|one| one["epoch"].as_i64().unwrap()).min().unwrap();
        assert!(epoch > last_epoch, "an epoch is given twice: {shards:?}");
        last_epoch = shards.iter().map(|one| one["epoch"].as_i64().unwrap()).max().unwrap();
        place.more_recorded(200).await;
    }
    let audit = a.get("/v1/audit?kind=SHARDS").await;
    assert_eq!(serde_json::from_str::<Value>(&audit).unwrap()["items"].as_array().unwrap().len(), 3, "{audit}");
    for (body, status, part) in
        [(json!({ "shards": 0 }), 422, "from 1 to 1024"), (json!({ "shards": 1025 }), 422, "from 1 to 1024")]
    {
        let (told, answer) = set_shards(&a, body).await;
        assert_eq!(told, status, "{answer}");
        assert!(answer.to_string().contains(part), "{answer}");
    }
    let strange = send(a.http(), "PUT", "/v1/fleets/nobody/shards", &[], Some(&json!({ "shards": 2 }))).await.unwrap();
    assert_eq!(strange.status, 404, "{}", strange.body);
    each_contact_is_recorded_once(place, robots).await;
}

#[tokio::test]
async fn in_sqlite_the_number_is_raised_and_lowered_by_request() {
    let stage = Stage::new().await;
    the_number_is_raised_and_lowered_by_request(&Place::sqlite(&stage)).await;
}

#[tokio::test]
async fn in_postgresql_the_number_is_raised_and_lowered_by_request() {
    let stage = Stage::new().await;
    the_number_is_raised_and_lowered_by_request(&Place::postgres(&stage)).await;
}

/// A supervisor dies in the transaction of a division or right after it, and the next one goes on.
async fn nothing_is_lost_by_a_kill_in_a_division(place: &Place<'_>) {
    let mut next = None;
    let robots = crowd(place.stage.broker_port(), 0..8);
    for (fault, count) in [("division_cut", 4), ("division_done", 2)] {
        drop(next.take());
        let mut a = place.supervisor(Some(fault));
        a.says(200, "OWNED").await;
        place.more_recorded(200).await;
        assert_eq!(set_shards(&a, json!({ "shards": count })).await.0, 202);
        assert!(!a.ended().await, "{fault}: killed");
        let after = place.supervisor(None);
        owns(&after, count).await;
        place.more_recorded(200).await;
        next = Some(after);
    }
    each_contact_is_recorded_once(place, robots).await;
}

#[tokio::test]
async fn in_sqlite_nothing_is_lost_by_a_kill_in_a_division() {
    let stage = Stage::new().await;
    nothing_is_lost_by_a_kill_in_a_division(&Place::sqlite(&stage)).await;
}

#[tokio::test]
async fn in_postgresql_nothing_is_lost_by_a_kill_in_a_division() {
    let stage = Stage::new().await;
    nothing_is_lost_by_a_kill_in_a_division(&Place::postgres(&stage)).await;
}

/// A shard without robots publishes nothing, so the broker acknowledges nothing.
#[tokio::test]
async fn regress_a_shard_without_robots_is_ready() {
    let stage = Stage::new().await;
    let place = Place::sqlite(&stage);
    let a = place.supervisor(None);
    a.says(200, "OWNED").await;
    assert_eq!(set_shards(&a, json!({ "shards": 3 })).await.0, 202);
    owns(&a, 3).await;
    a.says(200, "f/2").await;
}
