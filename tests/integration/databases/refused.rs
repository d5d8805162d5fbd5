//! The database refuses a row of one robot: the rows of all other robots are written, and the robot is named.
//!
//! For each table in turn, a trigger refuses the rows of one of two robots.

use std::collections::BTreeSet;

use sqlx::{AssertSqlSafe, ConnectOptions};
use vibrissa_store::Resolution;
use vibrissa_store::batch::{Batch, JournalRow, Owner, QuarantineRow, Record, RollupRow, SetpointRow};
use vibrissa_store::{DatabaseAddress, Lease, Refused, RejectionCause, StoreError, Writer};
use vibrissa_tests::actions::asks_of;

use crate::rows::{self, Numbered, contacts};
use crate::{Fresh, contract, fleet, supervisor};

/// Tables with rows of a single robot, and the condition that a new row `n` belongs to robot `{r}`, which has the
/// whiskers `{w}`, the compensation `{c}`, and the action `{a}`.
const OF_ROBOTS: [(&str, &str); 19] = [
    ("robots", "n.robot_id = {r} AND n.state IS NOT NULL"),
    ("whiskers", "n.robot_id = {r} AND n.state IS NOT NULL"),
    ("contacts", "n.whisker_id IN ({w})"),
    ("contact_minutes", "n.whisker_id IN ({w})"),
    ("contact_hours", "n.whisker_id IN ({w})"),
    ("health_changes", "n.whisker_id IN ({w})"),
    ("alarms", "n.whisker_id IN ({w})"),
    ("trims", "n.robot_id = {r}"),
    ("compensations", "n.robot_id = {r}"),
    ("compensation_candidates", "n.compensation_id = {c}"),
    ("compensation_refinements", "n.compensation_id = {c}"),
    ("compensation_responses", "n.compensation_id = {c}"),
    ("compensation_errors", "n.compensation_id = {c}"),
    (
        "compensation_error_bins",
        "n.compensation_error_id IN (SELECT compensation_error_id FROM compensation_errors WHERE compensation_id = {c})",
    ),
    ("setpoints", "n.robot_id = {r}"),
    ("setpoint_states", "n.command_id = 'c{r}'"),
    ("touch_tests", "n.robot_id = {r}"),
    ("events", "n.robot_id = {r}"),
    ("actions", "n.action_id = {a} AND n.state <> 'PENDING'"),
];

/// All other tables, and the reason why this test does not cover them.
const OTHERS: [(&str, &str); 29] = [
    ("journal", "has a separate test"),
    ("quarantine", "has a separate test"),
    ("boots", "is written with a birth, before its effects"),
    ("arrays", "is written with a factsheet, before its effects"),
    ("leases", "belongs to supervisors"),
    ("epochs", "belongs to supervisors"),
    ("event_positions", "belongs to a fleet"),
    ("supervisors", "belongs to supervisors"),
    ("supervised_fleets", "belongs to supervisors"),
    ("archives", "belongs to a fleet"),
    ("log_positions", "belongs to a fleet"),
    ("archive_horizons", "belongs to a fleet"),
    ("policies", "belongs to a fleet"),
    ("calibrations", "belongs to a fleet"),
    ("active_calibrations", "belongs to a fleet"),
    ("rollouts", "belongs to a fleet"),
    ("rollout_events", "belongs to a fleet"),
    ("api_tokens", "belongs to users"),
    ("alarm_shelves", "belongs to users"),
    ("maintenance", "belongs to users"),
    ("notes", "belongs to users"),
    ("allowed_robots", "belongs to users"),
    ("webhooks", "belongs to users"),
    ("console_sessions", "belongs to users"),
    ("webhook_dead_letters", "is written by the deliveries"),
    ("black_boxes", "is written separately, and refused rows are dropped"),
    ("refusals", "is written separately, and refused rows are dropped"),
    ("turned_away", "is written separately, and refused rows are dropped"),
    ("_sqlx_migrations", "belongs to the migrations"),
];

/// Ids of a robot in the database, and of an action for it.
struct Subject {
    numbered: Numbered,
    action_id: i64,
}

impl Subject {
    fn condition(&self, text: &str) -> String {
        let robot_id = self.numbered.robot_id;
        let whiskers: Vec<String> = self.numbered.whisker_ids.iter().map(i64::to_string).collect();
        text.replace("{r}", &robot_id.to_string())
            .replace("{w}", &whiskers.join(", "))
            .replace("{c}", &(robot_id << 32).to_string())
            .replace("{a}", &self.action_id.to_string())
    }

    /// A batch with a row of every kind and an entry of the journal.
    fn batch(&self) -> Batch {
        let numbered = &self.numbered;
        let mut batch = rows::states(numbered);
        batch.append_all(contacts(numbered, 0..3));
        batch.rollups = [Resolution::Minute, Resolution::Hour].map(|resolution| rollup(numbered, resolution)).to_vec();
        batch.records = contract::records(numbered);
        batch.events = contract::events(numbered);
        batch.events.truncate(2);
        let answer =
            Record::Answer { action_id: self.action_id, robot_id: 0, state: "DONE", problem: None, done_us: 17 };
        batch.records.push(answer);
        let (action_id, robot_id) = (self.action_id, numbered.robot_id);
        batch.records.push(Record::TestOfAction { action_id, robot_id, test_id: format!("t{robot_id}-0") });
        batch.responses = vec![contract::response(numbered)];
        batch
    }
}

fn rollup(numbered: &Numbered, resolution: Resolution) -> RollupRow {
    RollupRow {
        whisker_id: numbered.whisker_ids[0],
        resolution,
        start_us: 1_795_248_000_000_000,
        contacts: [3, 0, 0],
        residual: [Some(0.0), None, Some(0.0), Some(0.0)],
        sensitivity_per_mm: Some(0.004),
        ratio: Some(0.8),
        length_mm: Some(70.0),
        length_sd_mm: Some(0.2),
        length_mean_mm: Some(70.0),
        pressure_mpa: Some(0.1),
        temperature_c: Some(24.0),
        compensation_error: None,
    }
}

/// Journal entries in the format of this test: a robot's id in 8 bytes, and one further byte.
fn entries(robots: &[i64]) -> Vec<u8> {
    robots.iter().flat_map(|robot_id| robot_id.to_be_bytes().into_iter().chain([0])).collect()
}

fn split(bytes: &[u8]) -> Vec<(i64, Vec<u8>)> {
    bytes.chunks(9).map(|entry| (i64::from_be_bytes(entry[..8].try_into().unwrap()), entry.to_vec())).collect()
}

/// An administrator's connection to the database.
pub(crate) enum Admin {
    Sqlite(sqlx::SqliteConnection),
    Postgres(sqlx::PgConnection),
}

macro_rules! run {
    ($admin:expr, $sql:expr) => {
        match $admin {
            Admin::Sqlite(link) => sqlx::raw_sql(AssertSqlSafe($sql)).execute(link).await.map(drop),
            Admin::Postgres(link) => sqlx::raw_sql(AssertSqlSafe($sql)).execute(link).await.map(drop),
        }
    };
}

macro_rules! ask {
    ($admin:expr, $sql:expr) => {
        match $admin {
            Admin::Sqlite(link) => sqlx::query_scalar(AssertSqlSafe($sql)).fetch_all(link).await.unwrap(),
            Admin::Postgres(link) => sqlx::query_scalar(AssertSqlSafe($sql)).fetch_all(link).await.unwrap(),
        }
    };
}

impl Admin {
    pub(crate) async fn of(database: &Fresh) -> Self {
        match &database.address {
            DatabaseAddress::Sqlite(path) => {
                Self::Sqlite(sqlx::sqlite::SqliteConnectOptions::new().filename(path).connect().await.unwrap())
            }
            DatabaseAddress::Postgres(_) => {
                Self::Postgres(database.server.as_ref().unwrap().connect().connect().await.unwrap())
            }
        }
    }

    pub(crate) async fn execute(&mut self, sql: String) {
        run!(self, sql).unwrap();
    }

    /// Refuses new and changed rows `n` of a table that satisfy a condition.
    async fn refuse(&mut self, table: &str, condition: &str) {
        let sql = match self {
            Self::Sqlite(_) => ["INSERT", "UPDATE"]
                .map(|action| {
                    let condition = condition.replace("n.", "NEW.");
                    format!(
                        "CREATE TRIGGER planted_{action} BEFORE {action} ON {table} WHEN {condition} \
                         BEGIN SELECT RAISE(ABORT, 'planted'); END;"
                    )
                })
                .join(" "),
            Self::Postgres(_) => format!(
                "CREATE FUNCTION planted() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN IF {} THEN \
                 RAISE EXCEPTION 'planted' USING ERRCODE = '23514'; END IF; RETURN NEW; END $$; \
                 CREATE TRIGGER planted BEFORE INSERT OR UPDATE ON {table} FOR EACH ROW EXECUTE FUNCTION planted();",
                condition.replace("n.", "NEW.")
            ),
        };
        run!(self, sql).unwrap();
    }

    /// Removes the triggers.
    async fn relent(&mut self, table: &str) {
        let sql = match self {
            Self::Sqlite(_) => "DROP TRIGGER planted_INSERT; DROP TRIGGER planted_UPDATE;".to_owned(),
            Self::Postgres(_) => format!("DROP TRIGGER planted ON {table}; DROP FUNCTION planted();"),
        };
        run!(self, sql).unwrap();
    }

    async fn count(&mut self, table: &str, condition: &str) -> i64 {
        let counts: Vec<i64> = ask!(self, format!("SELECT count(*) FROM {table} n WHERE {condition}"));
        counts[0]
    }

    async fn tables(&mut self) -> BTreeSet<String> {
        let tables: Vec<String> = match self {
            Self::Sqlite(_) => ask!(
                self,
                "SELECT name FROM sqlite_master WHERE type = 'table' AND name NOT LIKE 'sqlite_%'".to_owned()
            ),
            Self::Postgres(_) => ask!(
                self,
                "SELECT relname::text FROM pg_class WHERE relnamespace = 'public'::regnamespace \
                 AND relkind IN ('r', 'p') AND NOT relispartition"
                    .to_owned()
            ),
        };
        tables.into_iter().collect()
    }
}

async fn begin(database: &Fresh) -> (Writer, Lease) {
    let (a, mut writer) = (supervisor("a"), database.store.writer());
    writer.sign_in(&a, &[]).await.unwrap();
    let lease = writer.acquire(&a, &fleet()).await.unwrap().unwrap();
    (writer, lease)
}

async fn subject(database: &Fresh, writer: &mut Writer, lease: &Lease, name: &str) -> Subject {
    let numbered = rows::numbered(writer, lease, name).await;
    let asked = database.store.ask(&asks_of("HOLD", "{}", Some(1))).await.unwrap();
    let vibrissa_store::actions::Asked::New(action_id) = asked else { panic!("{asked:?}") };
    let mut admin = Admin::of(database).await;
    run!(&mut admin, format!("UPDATE actions SET robot = '{name}' WHERE action_id = {action_id}")).unwrap();
    Subject { numbered, action_id }
}

/// Writes all rows of two robots and returns the owners of refused rows.
async fn write(writer: &mut Writer, lease: &Lease, batch: &mut Batch) -> Vec<Refused> {
    let whole = writer.commit(lease, batch).await.unwrap_err();
    assert_eq!(whole.rejection().map(|one| one.cause), Some(RejectionCause::Constraint), "{whole}");
    let mut refused = Vec::new();
    writer.commit_apart(lease, batch, split, &mut refused).await.unwrap();
    refused
}

async fn every_table(database: Fresh) {
    let mut admin = Admin::of(&database).await;
    let (mut writer, lease) = begin(&database).await;
    for (at, (table, condition)) in OF_ROBOTS.into_iter().enumerate() {
        let good = subject(&database, &mut writer, &lease, &format!("good-{at}")).await;
        let bad = subject(&database, &mut writer, &lease, &format!("bad-{at}")).await;
        let mut batch = good.batch();
        batch.append_all(bad.batch());
        admin.refuse(table, &bad.condition(condition)).await;
        let refused = write(&mut writer, &lease, &mut batch).await;
        assert_eq!(
            refused.iter().map(|one| one.owner).collect::<Vec<_>>(),
            [Owner::Robot(bad.numbered.robot_id)],
            "{table}"
        );
        assert!(refused[0].rejection.text.contains("planted"), "{:?}", refused[0]);
        admin.relent(table).await;
        for (other, condition) in OF_ROBOTS {
            assert!(
                admin.count(other, &good.condition(condition)).await > 0,
                "rows refused in {table}, but missing in {other}"
            );
            assert_eq!(
                admin.count(other, &bad.condition(condition)).await,
                0,
                "rows refused in {table}, but present in {other}"
            );
        }
        assert!(
            batch.robots.iter().all(|row| row.robot_id == good.numbered.robot_id),
            "the batch must contain exactly the rows that were written"
        );
    }
    let known: BTreeSet<String> = OF_ROBOTS.iter().chain(&OTHERS).map(|(table, _)| (*table).to_owned()).collect();
    let unknown: Vec<String> = admin.tables().await.difference(&known).cloned().collect();
    assert!(unknown.is_empty(), "add these tables to OF_ROBOTS or OTHERS: {unknown:?}");
}

#[tokio::test]
async fn regress_a_row_refused_in_any_table_leaves_out_its_robot_alone_on_sqlite() {
    every_table(Fresh::sqlite().await).await;
}

#[tokio::test]
async fn regress_a_row_refused_in_any_table_leaves_out_its_robot_alone_on_postgres() {
    every_table(Fresh::postgres().await).await;
}

/// A journal row has entries of several robots, so its entries are separated, too.
async fn in_the_journal(database: Fresh) {
    let mut admin = Admin::of(&database).await;
    let (mut writer, lease) = begin(&database).await;
    let mut numbered = Vec::new();
    for name in ["a", "b", "c", "d", "e"] {
        numbered.push(rows::numbered(&mut writer, &lease, name).await.robot_id);
    }
    let bad = numbered[3];
    let is_sqlite = matches!(admin, Admin::Sqlite(_));
    let hex: String = bad.to_be_bytes().iter().map(|byte| format!("{byte:02x}")).collect();
    let condition = if is_sqlite {
        format!("instr(n.entries, x'{hex}') > 0")
    } else {
        format!("position('\\x{hex}'::bytea IN n.entries) > 0")
    };
    admin.refuse("journal", &condition).await;
    let mut batch = Batch {
        journal: Some(JournalRow { number: 7, entries: entries(&[&numbered[..], &numbered[..]].concat()) }),
        journal_done: Some(3),
        ..Batch::default()
    };
    let earlier =
        Batch { journal: Some(JournalRow { number: 3, entries: entries(&[numbered[0]]) }), ..Batch::default() };
    writer.commit(&lease, &earlier).await.unwrap();
    let refused = write(&mut writer, &lease, &mut batch).await;
    assert_eq!(refused.iter().map(|one| one.owner).collect::<Vec<_>>(), [Owner::Robot(bad)]);
    let journal = writer.journal(&lease, -1, 10).await.unwrap();
    // The earlier entry stays, because the state of the robot with the refused row may need it.
    assert_eq!(journal.iter().map(|row| row.number).collect::<Vec<_>>(), [3, 7]);
    let mut written: Vec<i64> = split(&journal[1].entries).into_iter().map(|(robot_id, _)| robot_id).collect();
    written.sort_unstable();
    let mut others: Vec<i64> = numbered.iter().filter(|&&one| one != bad).flat_map(|&one| [one, one]).collect();
    others.sort_unstable();
    assert_eq!(written, others);
}

#[tokio::test]
async fn regress_entries_that_are_refused_in_the_journal_are_left_out_alone_on_sqlite() {
    in_the_journal(Fresh::sqlite().await).await;
}

#[tokio::test]
async fn regress_entries_that_are_refused_in_the_journal_are_left_out_alone_on_postgres() {
    in_the_journal(Fresh::postgres().await).await;
}

/// After a lost answer the next attempt recognises its own commit, including the robots whose rows were dropped.
#[tokio::test]
async fn a_transaction_written_apart_is_not_written_again() {
    let database = Fresh::postgres().await;
    let mut admin = Admin::of(&database).await;
    let (mut writer, lease) = begin(&database).await;
    let (good, bad) =
        (rows::numbered(&mut writer, &lease, "good").await, rows::numbered(&mut writer, &lease, "bad").await);
    admin.refuse("contacts", &format!("n.whisker_id = {}", bad.whisker_ids[0])).await;
    let mut batch = contacts(&good, 0..3);
    batch.append_all(contacts(&bad, 0..3));
    let mut refused = write(&mut writer, &lease, &mut batch).await;
    // The commit counter in the database is one ahead, as after a lost answer.
    run!(&mut admin, "UPDATE leases SET commits = commits + 1".to_owned()).unwrap();
    writer.commit_apart(&lease, &mut batch, split, &mut refused).await.unwrap();
    assert_eq!(refused.len(), 1);
    assert_eq!(database.store.contact_count().await.unwrap(), 3);
    // A counter that another owner has advanced is not mistaken for this transaction.
    run!(&mut admin, "UPDATE leases SET commits = commits + 5".to_owned()).unwrap();
    let lost = writer.commit_apart(&lease, &mut batch, split, &mut refused).await.unwrap_err();
    assert!(matches!(lost, StoreError::LeaseLost { .. }), "{lost}");
}

/// The quarantine has a size limit, and a message that cannot be stored there affects no other robot.
async fn in_quarantine(database: Fresh) {
    let mut admin = Admin::of(&database).await;
    let (mut writer, lease) = begin(&database).await;
    let row = |seq: i64| {
        Record::Quarantined(Box::new(QuarantineRow {
            robot: "r".to_owned(),
            topic: "factsheet",
            boot_id: Some("b".to_owned()),
            seq: Some(seq),
            received_us: 5,
            quarantined_us: 6,
            cause: "DATA",
            code: "22021".to_owned(),
            payload: vec![0, 1, 255],
        }))
    };
    let records = (0..QuarantineRow::ROWS_MAX + 10).map(row).collect();
    writer.commit(&lease, &Batch { records, ..Batch::default() }).await.unwrap();
    assert_eq!(admin.count("quarantine", "TRUE").await, QuarantineRow::ROWS_MAX);
    assert_eq!(admin.count("quarantine", "seq < 10").await, 0, "the oldest rows must be removed");
    admin.refuse("quarantine", "n.seq = 5000").await;
    let numbered = rows::numbered(&mut writer, &lease, "r").await;
    let mut batch = contacts(&numbered, 0..3);
    batch.records = vec![row(5000)];
    let refused = write(&mut writer, &lease, &mut batch).await;
    assert_eq!(refused.iter().map(|one| one.owner).collect::<Vec<_>>(), [Owner::Quarantine]);
    assert_eq!(database.store.contact_count().await.unwrap(), 3);
}

#[tokio::test]
async fn the_quarantine_is_bounded_on_sqlite() {
    in_quarantine(Fresh::sqlite().await).await;
}

#[tokio::test]
async fn the_quarantine_is_bounded_on_postgres() {
    in_quarantine(Fresh::postgres().await).await;
}

/// A setpoint whose name, or whose robot, epoch and version, the table has already is told from all other rows.
async fn setpoints_twice(database: Fresh) {
    let (mut writer, lease) = begin(&database).await;
    let numbered = rows::numbered(&mut writer, &lease, "r").await;
    let all = || contract::records(&numbered);
    let decided =
        all().into_iter().filter(|one| matches!(one, Record::Decision(_) | Record::Setpoint(_) | Record::Trim(_)));
    writer.commit(&lease, &Batch { records: decided.collect(), ..Batch::default() }).await.unwrap();
    let mut refusal = async |record: Record| {
        let mut batch = Batch { records: vec![record], ..Batch::default() };
        let refused = write(&mut writer, &lease, &mut batch).await;
        (refused[0].rejection.is_of_setpoint_key(), refused[0].rejection.text.clone())
    };
    let changes: [fn(&mut SetpointRow); 2] = [|row| row.command_id = "other".to_owned(), |row| row.version += 1];
    for change in changes {
        for record in all() {
            let Record::Setpoint(mut row) = record else { continue };
            change(&mut row);
            let (is, text) = refusal(Record::Setpoint(row)).await;
            assert!(is, "{text}");
        }
    }
    let trim = all().into_iter().find(|one| matches!(one, Record::Trim(_))).unwrap();
    let (is, text) = refusal(trim).await;
    assert!(!is, "{text}");
}

#[tokio::test]
async fn a_setpoint_that_is_there_already_is_told_from_other_rows_on_sqlite() {
    setpoints_twice(Fresh::sqlite().await).await;
}

#[tokio::test]
async fn a_setpoint_that_is_there_already_is_told_from_other_rows_on_postgres() {
    setpoints_twice(Fresh::postgres().await).await;
}
