//! Migration to positions in a partitioned log.

use sqlx::postgres::PgConnection;
use sqlx::sqlite::SqliteConnectOptions;
use sqlx::{ConnectOptions as _, Connection as _};
use vibrissa_tests::postgres::Postgres;

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
