//! Both databases have the same tables and columns, which fit the declared rows, and every table has a comment.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use sqlx::{ConnectOptions, Row};
use vibrissa_store::lists::whiskers::{WHISKERS, Whisker};
use vibrissa_store::retention::tables::{Kept, TABLES};
use vibrissa_store::{DatabaseAddress, StoreError};
use vibrissa_tests::postgres::Postgres;

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
        "SELECT c.relname::text AS t, a.attname::text AS c FROM pg_class c JOIN pg_attribute a ON a.attrelid = c.oid \
         WHERE c.relnamespace = 'public'::regnamespace AND c.relkind IN ('r', 'p') AND NOT c.relispartition \
         AND a.attnum > 0 AND NOT a.attisdropped",
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
    let mut tables = sqlite_tables(path).await;
    // SQLite numbers rows anyway; PostgreSQL has no use for this column.
    assert!(tables.get_mut("contacts").unwrap().remove("contact_id"));
    assert!(
        tables.len() >= 25
            && tables["compensation_refinements"].contains("outcome")
            && tables["contacts"].contains("strain"),
        "{tables:?}"
    );
    let kept: BTreeSet<String> = TABLES.iter().map(|(table, _)| (*table).to_owned()).collect();
    assert_eq!(tables.keys().cloned().collect::<BTreeSet<_>>(), kept, "each table states its retention");
    assert_eq!(tables, postgres_tables(&postgres.server.as_ref().unwrap().connect()).await);
}

/// The document for operators names the setting of each table, or the table with its bound.
#[test]
fn the_retention_of_each_table_is_documented() {
    let document = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../docs/operations.md");
    let text = std::fs::read_to_string(document).unwrap();
    for (table, kept) in TABLES {
        let bound = match kept {
            Kept::Days(setting) => format!("`{setting}`"),
            Kept::Until(bound) | Kept::For(bound) => (*bound).to_owned(),
        };
        let mut rows = text.lines().filter(|line| line.starts_with('|') && line.contains(&format!("`{table}`")));
        assert!(rows.any(|row| row.contains(&bound)), "operations.md has no row of `{table}` with: {bound}");
    }
}

/// A column of a table: its type, and whether a new row must have a value for it.
type Types = BTreeMap<(String, String), (String, bool)>;

async fn sqlite_types(path: &std::path::Path) -> Types {
    let mut link = sqlx::sqlite::SqliteConnectOptions::new().filename(path).connect().await.unwrap();
    let rows = sqlx::query(
        "SELECT m.name AS t, p.name AS c, p.type AS kind, p.\"notnull\" AND p.dflt_value IS NULL AS needed \
         FROM sqlite_master m JOIN pragma_table_info(m.name) p WHERE m.type = 'table'",
    )
    .fetch_all(&mut link)
    .await
    .unwrap();
    rows.iter().map(|row| ((row.get("t"), row.get("c")), (row.get("kind"), row.get("needed")))).collect()
}

async fn postgres_types(options: &sqlx::postgres::PgConnectOptions) -> Types {
    let mut link = options.connect().await.unwrap();
    let rows = sqlx::query(
        "SELECT c.relname::text AS t, a.attname::text AS c, format_type(a.atttypid, a.atttypmod) AS kind, \
         a.attnotnull AND NOT a.atthasdef AND a.attidentity = '' AS needed \
         FROM pg_class c JOIN pg_attribute a ON a.attrelid = c.oid \
         WHERE c.relnamespace = 'public'::regnamespace AND c.relkind IN ('r', 'p') AND a.attnum > 0 \
         AND NOT a.attisdropped",
    )
    .fetch_all(&mut link)
    .await
    .unwrap();
    rows.iter().map(|row| ((row.get("t"), row.get("c")), (row.get("kind"), row.get("needed")))).collect()
}

/// Compares the declared rows with the tables of a database.
fn rows_fit(types: &Types, type_of: impl Fn(&(&'static str, &'static str, &'static str)) -> &'static str) {
    let written = vibrissa_store::tables::written();
    assert!(written.len() >= 20);
    for one in &written {
        for column in &one.columns {
            let found = types.get(&(one.table.to_owned(), column.0.to_owned()));
            let found = found.unwrap_or_else(|| panic!("table {} has no column {}", one.table, column.0));
            assert_eq!(found.0, type_of(column), "type of {}.{}", one.table, column.0);
        }
        for ((table, column), _) in types.iter().filter(|(_, (_, needed))| one.inserts && *needed) {
            let declared = one.columns.iter().any(|(name, ..)| name == column);
            assert!(table != one.table || declared, "{table}.{column} is not declared");
        }
    }
}

#[tokio::test]
async fn the_tables_have_the_columns_of_the_declared_rows() {
    let (lite, postgres) = (Fresh::sqlite().await, Fresh::postgres().await);
    let DatabaseAddress::Sqlite(path) = &lite.address else { panic!("a file") };
    rows_fit(&sqlite_types(path).await, |column| column.1);
    rows_fit(&postgres_types(&postgres.server.as_ref().unwrap().connect()).await, |column| column.2);
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
            assert!(at > 0 && lines[at - 1].starts_with("-- "), "{name}: no comment before: {line}");
        }
    }
}

/// Runs one or more statements on either database.
async fn execute(address: &DatabaseAddress, sql: &str) {
    let sql = sqlx::AssertSqlSafe(sql.to_owned());
    match address {
        DatabaseAddress::Sqlite(path) => {
            let mut link = sqlx::sqlite::SqliteConnectOptions::new().filename(path).connect().await.unwrap();
            sqlx::raw_sql(sql).execute(&mut link).await.unwrap();
        }
        DatabaseAddress::Postgres(options) => {
            let mut link = options.connect().await.unwrap();
            sqlx::raw_sql(sql).execute(&mut link).await.unwrap();
        }
    }
}

/// A database of the program's first version: its table of migrations, and one robot with a command in epoch 7, with at
/// least one row in every table.
const OF_THE_FIRST_VERSION: &str = "INSERT INTO supervisors (epoch, boot_id, started_us) VALUES (6, 'a', 1), (7, 'b', 2); \
    INSERT INTO robots (robot_id, fleet, robot) VALUES (1, 'f', 'r'); \
    INSERT INTO arrays (array_id, robot_id, \"array\", array_type) VALUES (1, 1, 'left', 'TYPE_2'); \
    INSERT INTO whiskers (whisker_id, array_id, robot_id, whisker, position, x_mm, y_mm, model, whole_length_mm, \
        nominal_pressure_mpa, pressure_max_mpa, length_mm, length_sd_mm, condition, setpoint_mpa) \
        VALUES (1, 1, 1, 0, 0, 0, 0, 'nguyen-2021', 70, 0.1, 0.2, 65, 0.2, 'TRIMMED', 0.05); \
    INSERT INTO boots (boot, robot_id, boot_id, first_seen_us) VALUES (1, 1, 'b1', 3); \
    INSERT INTO contacts (whisker_id, boot, seq, position, t_us, received_us, ratio, deflection_mm, strain, pressure_mpa, \
        used, length_mm, length_sd_mm) VALUES (1, 1, 0, 0, 4, 5, 0.85, 2.4, 0.01, 0.1, 'USED', 70, 0.3); \
    INSERT INTO trims (trim_id, robot_id, whisker_id, detected_us, length_before_mm, length_after_mm, length_after_sd_mm, \
        contacts_to_detect) VALUES (4294967296, 1, 1, 6, 70, 65, 0.2, 9); \
    INSERT INTO compensations (compensation_id, robot_id, target_whisker_id, target_length_mm, target_pressure_mpa, \
        compensator_whisker_id, compensation_case, decided_us) \
        VALUES (4294967296, 1, 1, 70, 0.1, 1, 'SELF_COMPENSATION', 6); \
    INSERT INTO setpoints (command_id, robot_id, whisker_id, compensation_id, epoch, version, robot_boot_id, pressure_mpa, \
        slew_mpa_per_s, issued_us, expires_us, reason, state) \
        VALUES ('c', 1, 1, 4294967296, 7, 0, 'b1', 0.05, 0.02, 6, 16, 'SELF_COMPENSATION', 'APPLIED'); \
    INSERT INTO alarms (whisker_id, raised_us, kind) VALUES (1, 7, 'UNCOMPENSATED')";

/// Migrates a database of the first version: all rows are kept, and new epochs are higher.
async fn of_the_first_version(folder: &str, address: &DatabaseAddress) {
    let first = migrations(folder)["0001_supervision.sql"].clone();
    let applied = sqlx::migrate::Migration::new(
        1,
        "supervision".into(),
        sqlx::migrate::MigrationType::Simple,
        sqlx::SqlSafeStr::into_sql_str(sqlx::AssertSqlSafe(first.clone())),
        false,
    );
    let checksum: String = applied.checksum.iter().map(|byte| format!("{byte:02x}")).collect();
    let (blob, checksum) =
        if folder == "sqlite" { ("BLOB", format!("x'{checksum}'")) } else { ("BYTEA", format!("'\\x{checksum}'")) };
    execute(address, &first).await;
    // PostgreSQL's generated ids are given explicitly.
    let (values, numbered) = (" VALUES", " OVERRIDING SYSTEM VALUE VALUES");
    execute(address, &OF_THE_FIRST_VERSION.replace(values, if folder == "sqlite" { values } else { numbered })).await;
    execute(
        address,
        &format!(
            "CREATE TABLE _sqlx_migrations (version BIGINT PRIMARY KEY, description TEXT NOT NULL, \
             installed_on TIMESTAMP NOT NULL DEFAULT CURRENT_TIMESTAMP, success BOOLEAN NOT NULL, \
             checksum {blob} NOT NULL, execution_time BIGINT NOT NULL); \
             INSERT INTO _sqlx_migrations VALUES (1, 'supervision', CURRENT_TIMESTAMP, TRUE, {checksum}, 0)"
        ),
    )
    .await;

    let store = vibrissa_store::Store::open(address, "test").await.unwrap();
    store.prepare().await.unwrap();
    let mut writer = store.writer();
    writer.sign_in(&crate::supervisor("s"), &[]).await.unwrap();
    let lease = writer.acquire(&crate::supervisor("s"), &crate::fleet()).await.unwrap().unwrap();
    assert!(lease.epoch() > 7);
    let robots = writer.robots(&lease, 0, i64::MAX).await.unwrap().robots;
    assert_eq!((robots.len(), robots[0].numbers.next_trim, robots[0].numbers.next_compensation), (1, 1, 1));
    assert_eq!(store.contact_count().await.unwrap(), 1);
    let whiskers = store.all::<Whisker>(&WHISKERS, Vec::new()).await.unwrap();
    assert_eq!((whiskers[0].length_mm, whiskers[0].held, whiskers[0].compensated_by), (65.0, false, Some(1 << 32)));
}

#[tokio::test]
async fn a_sqlite_of_the_first_version_goes_on_with_what_it_has() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("v.sqlite3");
    // An empty database.
    std::fs::File::create(&path).unwrap();
    of_the_first_version("sqlite", &DatabaseAddress::Sqlite(path)).await;
}

#[tokio::test]
async fn a_postgres_of_the_first_version_goes_on_with_what_it_has() {
    let server = Postgres::start().await;
    of_the_first_version("postgres", &Postgres::url(server.port()).parse().unwrap()).await;
}

/// During a rolling upgrade a newer program migrates the database first: running supervisors continue, and an older one
/// that starts reports why it cannot.
async fn of_a_newer_version(database: &Fresh) {
    let mut writer = database.store.writer();
    writer.sign_in(&crate::supervisor("s"), &[]).await.unwrap();
    let lease = writer.acquire(&crate::supervisor("s"), &crate::fleet()).await.unwrap().unwrap();
    let robot = crate::rows::robot(&mut writer, &lease).await;
    let newer = "ALTER TABLE robots ADD COLUMN something TEXT; INSERT INTO _sqlx_migrations (version, description, \
                 success, checksum, execution_time) SELECT 9999, 'newer', success, checksum, 0 FROM _sqlx_migrations \
                 WHERE version = 1";
    execute(&database.address, newer).await;
    writer.commit(&lease, &crate::rows::contacts(&robot, 0..3)).await.unwrap();
    assert_eq!(database.store.contact_count().await.unwrap(), 3);
    let problem = database.store.prepare().await.unwrap_err();
    assert!(matches!(problem, StoreError::TooNew { version: 9999, .. }) && !problem.is_passing(), "{problem}");
    let said = problem.to_string();
    assert!(said.contains("newer vibrissa") && said.contains("9999") && said.contains("back-up"), "{said}");
}

#[tokio::test]
async fn a_sqlite_of_a_newer_version_is_refused_by_name() {
    of_a_newer_version(&Fresh::sqlite().await).await;
}

#[tokio::test]
async fn a_postgres_of_a_newer_version_is_refused_by_name() {
    of_a_newer_version(&Fresh::postgres().await).await;
}
