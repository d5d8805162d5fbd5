//! Both databases have the same tables and columns, and each table says what it is.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use sqlx::{ConnectOptions, Row};
use vibrissa::store::DatabaseAddress;

use crate::Fresh;

type Tables = BTreeMap<String, BTreeSet<String>>;

async fn sqlite_tables(path: &std::path::Path) -> Tables {
    let mut link = sqlx::sqlite::SqliteConnectOptions::new().filename(path).connect().await.unwrap();
    let rows = sqlx::query(
        "SELECT m.name AS t, p.name AS c FROM sqlite_master m JOIN pragma_table_info(m.name) p WHERE m.type = 'table'",
    )
    .fetch_all(&mut link)
    .await
    .unwrap();
    collect(rows.iter().map(|row| (row.get("t"), row.get("c"))))
}

async fn postgres_tables(options: &sqlx::postgres::PgConnectOptions) -> Tables {
    let mut link = options.connect().await.unwrap();
    let rows = sqlx::query(
        "SELECT table_name::text AS t, column_name::text AS c FROM information_schema.columns \
         WHERE table_schema = 'public'",
    )
    .fetch_all(&mut link)
    .await
    .unwrap();
    collect(rows.iter().map(|row| (row.get("t"), row.get("c"))))
}

fn collect(columns: impl Iterator<Item = (String, String)>) -> Tables {
    let mut tables = Tables::new();
    for (table, column) in columns.filter(|(table, _)| !table.starts_with("_sqlx") && !table.starts_with("sqlite_")) {
        tables.entry(table).or_default().insert(column);
    }
    tables
}

#[tokio::test]
async fn both_databases_have_the_same_tables_with_the_same_columns() {
    let (lite, postgres) = (Fresh::sqlite().await, Fresh::postgres().await);
    let DatabaseAddress::Sqlite(path) = &lite.address else { panic!("a file") };
    let tables = sqlite_tables(path).await;
    assert!(
        tables.len() >= 19
            && tables["compensation_refinements"].contains("outcome")
            && tables["contacts"].contains("strain"),
        "{tables:?}"
    );
    assert_eq!(tables, postgres_tables(&postgres.server.as_ref().unwrap().connect()).await);
}

fn migrations(folder: &str) -> BTreeMap<String, String> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../migrations").join(folder);
    let files = std::fs::read_dir(&folder).unwrap().map(|file| file.unwrap().path());
    files
        .map(|file| {
            let name = file.file_name().unwrap().to_string_lossy().into_owned();
            (name, std::fs::read_to_string(&file).unwrap())
        })
        .collect()
}

#[test]
fn migrations_have_the_same_numbers_and_names_and_every_table_is_commented() {
    let (lite, postgres) = (migrations("sqlite"), migrations("postgres"));
    assert_eq!(lite.keys().collect::<Vec<_>>(), postgres.keys().collect::<Vec<_>>());
    assert!(lite.len() >= 2);
    for (name, sql) in lite.iter().chain(&postgres) {
        let lines: Vec<&str> = sql.lines().collect();
        for (at, line) in lines.iter().enumerate().filter(|(_, line)| line.starts_with("CREATE TABLE")) {
            assert!(at > 0 && lines[at - 1].starts_with("-- "), "{name}: nothing says what this is: {line}");
        }
    }
}

/// A database of the first version, with one robot that was commanded in epoch 7.
#[tokio::test]
async fn a_database_of_the_version_before_goes_on_with_higher_epochs() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("v.sqlite3");
    let address = DatabaseAddress::Sqlite(path.clone());
    let store = vibrissa::store::Store::open(&address, "test").await.unwrap();
    {
        let options = sqlx::sqlite::SqliteConnectOptions::new().filename(&path);
        let mut link = options.connect().await.unwrap();
        let first = migrations("sqlite")["0001_supervision.sql"].clone();
        sqlx::raw_sql(sqlx::AssertSqlSafe(first.clone())).execute(&mut link).await.unwrap();
        sqlx::raw_sql(
            "INSERT INTO supervisors (epoch, boot_id, started_us) VALUES (6, 'a', 1), (7, 'b', 2); \
             INSERT INTO robots (fleet, robot) VALUES ('f', 'r'); \
             CREATE TABLE _sqlx_migrations (version BIGINT PRIMARY KEY, description TEXT NOT NULL, \
             installed_on TIMESTAMP NOT NULL DEFAULT CURRENT_TIMESTAMP, success BOOLEAN NOT NULL, \
             checksum BLOB NOT NULL, execution_time BIGINT NOT NULL)",
        )
        .execute(&mut link)
        .await
        .unwrap();
        let applied = sqlx::migrate::Migration::new(
            1,
            "supervision".into(),
            sqlx::migrate::MigrationType::Simple,
            sqlx::SqlSafeStr::into_sql_str(sqlx::AssertSqlSafe(first)),
            false,
        );
        sqlx::query("INSERT INTO _sqlx_migrations VALUES (1, 'supervision', CURRENT_TIMESTAMP, TRUE, $1, 0)")
            .bind(applied.checksum.to_vec())
            .execute(&mut link)
            .await
            .unwrap();
    }
    store.prepare().await.unwrap();
    let lease = store.writer().acquire(&crate::supervisor("s"), &crate::fleet()).await.unwrap().unwrap();
    assert!(lease.epoch() > 7);
}
