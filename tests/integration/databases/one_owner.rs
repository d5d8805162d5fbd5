//! A database whose fleet was divided into shards: the migration to one owner loses nothing.
//!
//! The database of `tests/data/database-37` is divided into four shards before this version opens it. Its robots belong to
//! shards by the hashes that their rows have.

use serde_json::json;
use sqlx::sqlite::SqliteConnectOptions;
use sqlx::{AssertSqlSafe, ConnectOptions as _};
use vibrissa_store::{DatabaseAddress, Store};
use vibrissa_tests::postgres::Postgres;

use crate::Fresh;
use crate::history::rows;
use crate::one_log::outbox_row;
use crate::opened::{LEFT_37, postgres_of, sqlite_of};

/// Divides the fleet: leases with rising epochs, an epoch that two shards have, journals with equal numbers, horizons of shards and
/// of a former one, and events that wait. EMPTY stands for no bytes,
/// and OVERRIDING for the permission to give numbers that PostgreSQL gives.
const DIVIDE: &str = "
    UPDATE leases SET shards = 4, shards_wanted = 4, owner = 'a', holder = 'a';
    INSERT INTO leases (fleet, epoch, owner, holder, commits, expires_us, shard, shards, shards_wanted)
        SELECT fleet, epoch + 10 * n.shard, 'b', 'b', n.shard, expires_us, n.shard, 4, 4 FROM leases
        CROSS JOIN (SELECT 1 AS shard UNION ALL SELECT 2 UNION ALL SELECT 3) n;
    INSERT INTO epochs (fleet, epoch, owner, holder, began_us, shard)
        SELECT fleet, epoch, 'b', 'b', epoch * 1000, shard FROM leases WHERE shard > 0;
    INSERT INTO epochs (fleet, epoch, owner, holder, began_us, shard)
        SELECT fleet, epoch, 'b', 'b', began_us - 5, 2 FROM epochs ORDER BY epoch LIMIT 1;
    INSERT INTO journal (fleet, shard, number, entries) VALUES
        ('f', 1, 202, EMPTY), ('f', 1, 203, EMPTY), ('f', 2, 203, EMPTY), ('f', 3, 204, EMPTY);
    INSERT INTO event_outbox (fleet, shard, epoch, number, events) VALUES
        ('f', 0, 1, 7, EVENT_1), ('f', 1, 1, 7, EVENT_2), ('f', 3, 1, 6, EVENT_3), ('f', 3, 2, 1, EVENT_4), ('g', 0, 1, 7, EVENT_5);
    INSERT INTO archive_horizons (fleet, shard, written_to_us) VALUES
        ('f', 0, 50), ('f', 1, 40), ('f', 3, 60), ('f', 9, 5), ('g', 0, 70);";

/// Pending actions of shards: of a calibration that the first shard has executed, of such a policy, and of a policy that it has not
/// executed yet. Actions 4 and 14 of the fixture are a calibration and a policy.
const PENDING: &str = "
    INSERT INTO actions (action_id, fleet, kind, parameters, actor, role, request_id, asked_us, expires_us, state, parent_id, shard)
    OVERRIDING VALUES (101, 'f', 'CALIBRATION', '{}', 'ann', 'ENGINEER', 'q', 1, 2, 'PENDING', 4, 1),
        (102, 'f', 'CALIBRATION', '{}', 'ann', 'ENGINEER', 'q', 1, 2, 'PENDING', 4, 2),
        (103, 'f', 'POLICY', '{}', 'ann', 'ENGINEER', 'q', 1, 2, 'PENDING', 14, 3),
        (104, 'f', 'POLICY', '{}', 'ann', 'ENGINEER', 'q', 1, 2, 'PENDING', NULL, NULL),
        (105, 'f', 'POLICY', '{}', 'ann', 'ENGINEER', 'q', 1, 2, 'PENDING', 104, 1);";

/// The statements with an event in the place of each EVENT_, which has the number as that of a trim.
fn with_events(sql: &str, blob: impl Fn(String) -> String) -> String {
    (1..=5).fold(sql.to_owned(), |sql, number| {
        let event = json!({ "type": "TRIM", "version": 1, "timestamp": "2026-11-20T08:00:00.000Z", "fleet": "f",
            "robot": "r", "trim": { "trim_id": number } });
        sql.replace(&format!("EVENT_{number}"), &blob(outbox_row("r", &[event])))
    })
}

async fn execute(address: &DatabaseAddress, sql: &str) {
    match address {
        DatabaseAddress::Sqlite(path) => {
            let mut link = SqliteConnectOptions::new().filename(path).connect().await.unwrap();
            let sql = with_events(sql, |bytes| format!("x'{bytes}'"));
            let sql = AssertSqlSafe(sql.replace("EMPTY", "x''").replace("OVERRIDING", ""));
            sqlx::raw_sql(sql).execute(&mut link).await.map(drop).unwrap();
        }
        DatabaseAddress::Postgres(options) => {
            let mut link = options.connect().await.unwrap();
            let sql = with_events(sql, |bytes| format!("decode('{bytes}', 'hex')"));
            let sql =
                AssertSqlSafe(sql.replace("EMPTY", "'\\x'::bytea").replace("OVERRIDING", "OVERRIDING SYSTEM VALUE"));
            sqlx::raw_sql(sql).execute(&mut link).await.map(drop).unwrap();
        }
    }
}

async fn prepare(address: &DatabaseAddress) {
    let store = Store::open(address, "test").await.unwrap();
    store.prepare().await.unwrap();
    store.close().await;
}

/// States of the actions that were pending.
async fn states(address: &DatabaseAddress) -> Vec<(i64, String)> {
    rows!(address, (i64, String), "SELECT action_id, state FROM actions WHERE action_id > 100 ORDER BY action_id")
}

fn expected_states() -> Vec<(i64, String)> {
    let word = |(action_id, state): (i64, &str)| (action_id, state.to_owned());
    [(101, "PENDING"), (102, "REFUSED"), (103, "REFUSED"), (104, "PENDING"), (105, "REFUSED")].map(word).into()
}

/// Epochs with their begins, in order.
async fn epochs(address: &DatabaseAddress) -> Vec<(i64, i64)> {
    rows!(address, (i64, i64), "SELECT epoch, began_us FROM epochs ORDER BY epoch")
}

async fn everything_is_there(address: &DatabaseAddress) {
    let before = epochs(address).await;
    let [former, (newest, _)] = before[..] else { panic!("{before:?}") };
    let mut journal =
        rows!(address, (i64, i64, i64), "SELECT number * 4, shard, CAST(length(entries) AS BIGINT) FROM journal");
    let robots = rows!(
        address,
        (i64, i64),
        "SELECT robot_id, journal_number * 4 + shard_hash % 4 FROM robots ORDER BY robot_id"
    );
    assert!(!journal.is_empty() && robots.len() == 4);
    execute(address, DIVIDE).await;
    execute(address, PENDING).await;
    prepare(address).await;

    type Lease = (String, i64, Option<String>, Option<String>, i64);
    let leases = rows!(address, Lease, "SELECT fleet, epoch, owner, holder, commits FROM leases");
    assert_eq!(leases, [("f".to_owned(), newest + 30, None, None, 0)]);

    let after = epochs(address).await;
    assert_eq!(after[0], (former.0, former.1 - 5), "the earliest begin of an epoch");
    let numbers: Vec<i64> = after.iter().map(|(epoch, _)| *epoch).collect();
    assert_eq!(numbers, [former.0, newest, newest + 10, newest + 20, newest + 30]);

    journal.extend([(202 * 4 + 1, 1, 0), (203 * 4 + 1, 1, 0), (203 * 4 + 2, 2, 0), (204 * 4 + 3, 3, 0)]);
    journal.sort_unstable();
    let joined = rows!(
        address,
        (i64, i64, i64),
        "SELECT number, log_partition, CAST(length(entries) AS BIGINT) FROM journal ORDER BY number"
    );
    assert_eq!(joined, journal);
    assert_eq!(
        rows!(address, (i64, i64), "SELECT robot_id, journal_number FROM robots ORDER BY robot_id"),
        robots,
        "a checkpoint contains the same rows as before"
    );

    let waiting = "SELECT fleet, data FROM events WHERE audience = 'PROGRAMS' ORDER BY fleet, event_id";
    let waiting: Vec<(String, Option<i64>)> = rows!(address, (String, String), waiting)
        .into_iter()
        .map(|(fleet, data)| (fleet, data.parse::<serde_json::Value>().unwrap()["trim"]["trim_id"].as_i64()))
        .collect();
    let expected = [("f", 3), ("f", 1), ("f", 2), ("f", 4), ("g", 5)];
    assert_eq!(waiting, expected.map(|(fleet, number)| (fleet.to_owned(), Some(number))));

    let horizons = rows!(address, (String, i64), "SELECT fleet, written_to_us FROM archive_horizons ORDER BY fleet");
    assert_eq!(horizons, [("f".to_owned(), 40), ("g".to_owned(), 70)]);
    assert_eq!(states(address).await, expected_states());
}

#[tokio::test]
async fn a_fleet_of_four_shards_gets_one_owner_with_nothing_lost_on_sqlite() {
    let (_folder, address, _) = sqlite_of(&LEFT_37);
    everything_is_there(&address).await;
}

#[tokio::test]
async fn a_fleet_of_four_shards_gets_one_owner_with_nothing_lost_on_postgres() {
    let (_server, address, _) = postgres_of(&LEFT_37).await;
    everything_is_there(&address).await;
}

#[tokio::test]
async fn golden_a_divided_sqlite_database_goes_on_with_equal_views() {
    let (folder, address, url) = sqlite_of(&LEFT_37);
    execute(&address, DIVIDE).await;
    LEFT_37.shows((folder, &url), &LEFT_37.recorded("views-sqlite.json")).await;
}

#[tokio::test]
async fn golden_a_divided_postgresql_database_goes_on_with_equal_views() {
    let (_server, address, url) = postgres_of(&LEFT_37).await;
    execute(&address, DIVIDE).await;
    LEFT_37.shows((tempfile::tempdir().unwrap(), &url), &LEFT_37.recorded("views-postgres.json")).await;
}

/// The supervisors' role may answer pending actions, and cannot change the table, which belongs to another role.
#[tokio::test]
async fn the_supervisors_role_may_end_the_actions_of_shards() {
    let database = Fresh::of(Postgres::start_with_supervisor().await).await;
    const PARENTS: &str = "
        INSERT INTO actions (action_id, fleet, kind, parameters, actor, role, request_id, asked_us, expires_us, state, done_us)
        OVERRIDING VALUES (4, 'f', 'CALIBRATION', '{}', 'ann', 'ENGINEER', 'q', 1, 2, 'DONE', 2),
            (14, 'f', 'POLICY', '{}', 'ann', 'ENGINEER', 'q', 1, 2, 'DONE', 2);";
    execute(&database.address, PARENTS).await;
    execute(&database.address, PENDING).await;
    let migration = include_str!("../../../migrations/postgres/0063_one_owner.sql");
    let (_, of_actions) = migration.split_once("DROP TABLE divided;").unwrap();
    execute(&database.address, of_actions).await;
    assert_eq!(states(&database.address).await, expected_states());
}
