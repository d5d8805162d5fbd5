//! Positions in a partitioned log: they change with the transaction of the records' effects, and only with it.

use std::collections::BTreeMap;
use std::ops::Range;

use rand::seq::IndexedRandom;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sqlx::postgres::PgConnection;
use sqlx::sqlite::SqliteConnectOptions;
use sqlx::{ConnectOptions as _, Connection as _};
use vibrissa_store::{Batch, Lease, LogPositions, StoreError, Writer};
use vibrissa_tests::postgres::Postgres;

use crate::rows::{self, Numbered, contacts};
use crate::{Fresh, fleet, supervisor};

const PARTITIONS: u32 = 5;
/// Contacts that `COPY` writes.
const COPIED: i64 = 1500;

/// Ways to write a batch.
#[derive(Debug, Clone, Copy)]
enum Way {
    /// As one statement where the database has one.
    Whole,
    /// With checkpoints.
    Checkpoints,
    /// With contacts so many that they are copied.
    Copied,
    /// Statement by statement, because of a layout.
    InSteps,
    /// Robot by robot.
    Apart,
}

const WAYS: [Way; 5] = [Way::Whole, Way::Checkpoints, Way::Copied, Way::InSteps, Way::Apart];

impl Way {
    fn batch(self, robot: &Numbered, seqs: Range<i64>) -> Batch {
        let contacts = contacts(robot, seqs).contacts;
        match self {
            Self::Whole | Self::Copied | Self::Apart => Batch { contacts, ..Batch::default() },
            Self::Checkpoints => Batch { contacts, layouts: Vec::new(), ..rows::states(robot) },
            Self::InSteps => Batch { contacts, ..rows::states(robot) },
        }
    }

    async fn write(self, writer: &mut Writer, lease: &Lease, batch: &mut Batch) -> Result<(), StoreError> {
        match self {
            Self::Apart => writer.commit_apart(lease, batch, |_| Vec::new(), &mut Vec::new()).await,
            Self::Whole | Self::Checkpoints | Self::Copied | Self::InSteps => writer.commit(lease, batch).await,
        }
    }
}

/// Random transactions, compared with a model after each.
async fn follow_the_transactions(database: Fresh) {
    let (a, b) = (supervisor("a"), supervisor("b"));
    let mut writer = database.store.writer();
    writer.sign_in(&a, &[]).await.unwrap();
    let lease = writer.acquire(&a, &fleet()).await.unwrap().unwrap();
    let robot = rows::robot(&mut writer, &lease).await;
    let mut random = ChaCha8Rng::seed_from_u64(62);
    let mut model: BTreeMap<&str, BTreeMap<u32, i64>> =
        BTreeMap::from([("one", BTreeMap::new()), ("two", BTreeMap::new())]);
    let mut seq = 0;
    for step in 0..60 {
        let way = *WAYS.choose(&mut random).unwrap();
        let topic = if random.random_bool(0.8) { "one" } else { "two" };
        let count = if matches!(way, Way::Copied) { COPIED } else { random.random_range(1..4) };
        let mut batch = way.batch(&robot, seq..seq + count);
        seq += count;
        for partition in 0..PARTITIONS {
            if random.random_bool(0.4) {
                // A topic that was created anew makes a position lower.
                batch.log.next.insert(partition, random.random_range(0..1_000_000));
            }
        }
        batch.log.topic = topic.into();
        model.get_mut(topic).unwrap().extend(batch.log.next.clone());
        way.write(&mut writer, &lease, &mut batch).await.unwrap();
        for (topic, positions) in &model {
            assert_eq!(writer.log_positions(&lease, topic).await.unwrap(), *positions, "step {step}, {way:?}, {topic}");
        }
        assert_eq!(database.store.contact_count().await.unwrap(), seq, "step {step}, {way:?}");
    }
    assert!(model.values().all(|positions| positions.len() == PARTITIONS as usize), "{model:?}");

    // Whoever has lost the lease moves no position.
    writer.release(&lease).await.unwrap();
    writer.sign_in(&b, &[]).await.unwrap();
    let next = writer.acquire(&b, &fleet()).await.unwrap().unwrap();
    for way in WAYS {
        let count = if matches!(way, Way::Copied) { COPIED } else { 2 };
        let mut batch = way.batch(&robot, seq..seq + count);
        batch.log = LogPositions { topic: "one".into(), next: (0..PARTITIONS).map(|one| (one, 7)).collect() };
        let refused = way.write(&mut writer, &lease, &mut batch).await;
        assert!(matches!(refused, Err(StoreError::LeaseLost { .. })), "{way:?}: {refused:?}");
        assert_eq!(writer.log_positions(&next, "one").await.unwrap(), model["one"], "{way:?}");
        assert_eq!(database.store.contact_count().await.unwrap(), seq, "{way:?}");
    }
}

#[tokio::test]
async fn property_positions_follow_the_transactions_on_sqlite() {
    follow_the_transactions(Fresh::sqlite().await).await;
}

#[tokio::test]
async fn property_positions_follow_the_transactions_on_postgres() {
    follow_the_transactions(Fresh::postgres().await).await;
}

/// The position of a shard becomes that of the partition with its number. A fleet that has read nothing has none.
#[tokio::test]
async fn the_migration_keeps_the_position_of_each_shard() {
    const BEFORE: &str = "CREATE TABLE leases (fleet TEXT, shard BIGINT, log_next BIGINT, log_topic TEXT); \
         INSERT INTO leases VALUES ('f', 0, 70, 'one'), ('f', 1, 80, 'one'), ('g', 0, 5, 'two'), ('h', 0, NULL, 'one'), \
         ('i', 0, NULL, NULL)";
    const AFTER: &str = "SELECT fleet, topic, log_partition, next FROM log_positions ORDER BY 1, 3";
    const LEFT: &str = "SELECT * FROM leases WHERE fleet = 'f' ORDER BY shard";
    type Rows = Vec<(String, String, i64, i64)>;
    let row = |fleet: &str, topic: &str, partition, next| (fleet.to_owned(), topic.to_owned(), partition, next);
    let expected = [row("f", "one", 0, 70), row("f", "one", 1, 80), row("g", "two", 0, 5)];

    let mut link = SqliteConnectOptions::new().in_memory(true).connect().await.unwrap();
    sqlx::raw_sql(BEFORE).execute(&mut link).await.unwrap();
    let migration = include_str!("../../../migrations/sqlite/0062_log_positions.sql");
    sqlx::raw_sql(migration).execute(&mut link).await.unwrap();
    let rows: Rows = sqlx::query_as(AFTER).fetch_all(&mut link).await.unwrap();
    assert_eq!(rows, expected);
    let left: Vec<(String, i64)> = sqlx::query_as(LEFT).fetch_all(&mut link).await.unwrap();
    assert_eq!(left.len(), 2);

    let server = Postgres::start().await;
    let mut link = PgConnection::connect(&Postgres::url(server.port())).await.unwrap();
    sqlx::raw_sql(BEFORE).execute(&mut link).await.unwrap();
    let migration = include_str!("../../../migrations/postgres/0062_log_positions.sql");
    sqlx::raw_sql(migration).execute(&mut link).await.unwrap();
    let rows: Rows = sqlx::query_as(AFTER).fetch_all(&mut link).await.unwrap();
    assert_eq!(rows, expected);
    let left: Vec<(String, i64)> = sqlx::query_as(LEFT).fetch_all(&mut link).await.unwrap();
    assert_eq!(left.len(), 2);
}
