//! Partitions of PostgreSQL's tables by time. Each span of time is a partition, which is created before it begins,
//! indexed for queries when it has ended, and dropped as a whole when it is too old.
//!
//! Every supervisor does this work, one at a time by advisory locks of the database; work that another one has done
//! is skipped. A row whose partition does not exist goes to the table's default partition, so no commit depends on
//! this work.

use sqlx::{AssertSqlSafe, Connection, PgConnection, Row};
use vibrissa_protocol::Timestamp;

use super::done::Done;

pub(crate) const DAY_US: i64 = 86_400_000_000;

/// A table that is partitioned by time.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Cut {
    pub(super) table: &'static str,
    /// Column of the table's times, µs since 1970 UTC.
    pub(super) key: &'static str,
    days: i64,
    /// Columns of the index for queries: whisker and time. A partition gets it when its span has ended; until then it
    /// has a BRIN index of the time only.
    lookup: Option<(&'static str, &'static str)>,
}

pub(super) static CONTACTS: Cut =
    Cut { table: "contacts", key: "received_us", days: 1, lookup: Some(("whisker_id", "t_us")) };
/// Queries use its primary key, so it needs no further index.
pub(super) static MINUTES: Cut = Cut { table: "contact_minutes", key: "start_us", days: 30, lookup: None };

/// A span of time; its end is excluded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Span {
    from_us: i64,
    to_us: i64,
}

/// A partition with a span, which the default partition has not.
#[derive(Debug, PartialEq, Eq)]
struct Partition {
    name: String,
    span: Span,
    bytes: i64,
}

/// Advisory lock for creating partitions, held for moments.
const MAKING: i64 = 0x7669_6272_0000_0001;
/// Advisory lock for upkeep of partitions that have ended, which may take minutes.
const UPKEEP: i64 = 0x7669_6272_0000_0002;
/// Time from the end of a span to its index, µs: late rows may arrive until then.
const INDEXED_AFTER_US: i64 = 3_600_000_000;
/// Most rows that one statement deletes.
const ROWS: i64 = 5000;

impl Cut {
    fn span_at(&self, at_us: i64) -> Span {
        let length_us = self.days * DAY_US;
        let from_us = at_us.div_euclid(length_us) * length_us;
        Span { from_us, to_us: from_us + length_us }
    }

    /// Name of a span's partition, such as `contacts_20261121`.
    fn name_of(&self, span: Span) -> String {
        let day: String = Timestamp(span.from_us.unsigned_abs()).to_string().chars().take(10).collect();
        format!("{}_{}", self.table, day.replace('-', ""))
    }
}

/// Parses PostgreSQL's bounds of a partition: `FOR VALUES FROM (MINVALUE) TO ('1795305600000000')`.
fn bounds(clause: &str) -> Option<Span> {
    let (from, to) = clause.strip_prefix("FOR VALUES FROM (")?.strip_suffix(')')?.split_once(") TO (")?;
    let bound = |text: &str, open: &str, value| match text {
        text if text == open => Some(value),
        text => text.trim_matches('\'').parse().ok(),
    };
    Some(Span { from_us: bound(from, "MINVALUE", i64::MIN)?, to_us: bound(to, "MAXVALUE", i64::MAX)? })
}

async fn partitions(link: &mut PgConnection, cut: &Cut) -> sqlx::Result<Vec<Partition>> {
    let rows = sqlx::query(
        "SELECT c.relname::text AS name, pg_get_expr(c.relpartbound, c.oid) AS told, \
         pg_total_relation_size(c.oid) AS bytes FROM pg_inherits i JOIN pg_class c ON c.oid = i.inhrelid \
         WHERE i.inhparent = $1::regclass ORDER BY c.relname",
    )
    .bind(cut.table)
    .fetch_all(link)
    .await?;
    let partition = |row: &sqlx::postgres::PgRow| {
        Some(Partition { span: bounds(row.get("told"))?, name: row.get("name"), bytes: row.get("bytes") })
    };
    Ok(rows.iter().filter_map(partition).collect())
}

/// A time that no row is older than; none without rows. It is that of the oldest partition with a row, or of the oldest row in
/// the default partition.
pub(super) async fn oldest(link: &mut PgConnection, cut: &Cut) -> sqlx::Result<Option<i64>> {
    let Cut { table, key, .. } = cut;
    let caught = AssertSqlSafe(format!("SELECT min({key}) FROM {table}_default"));
    let mut oldest: Option<i64> = sqlx::query_scalar(caught).fetch_one(&mut *link).await?;
    for one in partitions(link, cut).await? {
        let any = AssertSqlSafe(format!("SELECT EXISTS (SELECT 1 FROM {})", quoted(&one.name)));
        if sqlx::query_scalar(any).fetch_one(&mut *link).await? {
            oldest = Some(oldest.map_or(one.span.from_us, |oldest| oldest.min(one.span.from_us)));
        }
    }
    Ok(oldest)
}

async fn run(link: &mut PgConnection, sql: String) -> sqlx::Result<u64> {
    sqlx::raw_sql(AssertSqlSafe(sql)).execute(link).await.map(|done| done.rows_affected())
}

/// Creates the partitions of the present and the next span of every table.
pub(super) async fn make(link: &mut PgConnection, now_us: i64, report: &mut impl FnMut(Done)) -> sqlx::Result<()> {
    for cut in [&CONTACTS, &MINUTES] {
        let this = cut.span_at(now_us);
        for span in [this, cut.span_at(this.to_us)] {
            if is_missing(&partitions(link, cut).await?, span) && make_one(link, cut, span).await? {
                report(Done::Made { partition: cut.name_of(span) });
            }
        }
    }
    Ok(())
}

fn is_missing(partitions: &[Partition], span: Span) -> bool {
    partitions.iter().all(|other| other.span.to_us <= span.from_us || other.span.from_us >= span.to_us)
}

/// Creates a partition, and moves the rows of its span there from the default partition. Commits go on meanwhile: the
/// table itself is locked against changes of its definition only. Returns false if another supervisor was faster.
async fn make_one(link: &mut PgConnection, cut: &Cut, span: Span) -> sqlx::Result<bool> {
    let (Cut { table, key, lookup, .. }, Span { from_us, to_us }, name) = (cut, span, cut.name_of(span));
    let mut tx = link.begin().await?;
    // Waits for queries of the whole table; queries that arrive meanwhile wait behind this, hence the short limit.
    run(&mut tx, "SET LOCAL lock_timeout = '2s'".to_owned()).await?;
    sqlx::query("SELECT pg_advisory_xact_lock($1)").bind(MAKING).execute(&mut *tx).await?;
    if !is_missing(&partitions(&mut tx, cut).await?, span) {
        return Ok(false);
    }
    run(&mut tx, format!("CREATE TABLE {name} (LIKE {table} INCLUDING INDEXES)")).await?;
    if let Some((_, time)) = lookup {
        let index = format!("CREATE INDEX {name}_pages ON {name} USING brin ({time}) WITH (autosummarize = on)");
        run(&mut tx, index).await?;
    }
    run(&mut tx, format!("LOCK TABLE {table}_default IN ACCESS EXCLUSIVE MODE")).await?;
    let caught = format!(
        "WITH caught AS (DELETE FROM {table}_default WHERE {key} >= {from_us} AND {key} < {to_us} RETURNING *) \
         INSERT INTO {name} SELECT * FROM caught"
    );
    run(&mut tx, caught).await?;
    let attach = format!("ALTER TABLE {table} ATTACH PARTITION {name} FOR VALUES FROM ({from_us}) TO ({to_us})");
    run(&mut tx, attach).await?;
    tx.commit().await?;
    Ok(true)
}

/// Drops the partitions that ended before the given times, and indexes the others that have ended. Does nothing if
/// another supervisor is doing it.
pub(super) async fn look_after(
    link: &mut PgConnection,
    now_us: i64,
    forget_before: [(&Cut, Option<i64>); 2],
    report: &mut impl FnMut(Done),
) -> sqlx::Result<()> {
    let is_ours: bool =
        sqlx::query_scalar("SELECT pg_try_advisory_lock($1)").bind(UPKEEP).fetch_one(&mut *link).await?;
    if !is_ours {
        return Ok(());
    }
    // An index of a whole day takes longer than the session's limit.
    run(link, "SET statement_timeout = 0".to_owned()).await?;
    for (cut, before_us) in forget_before {
        if let Some(before_us) = before_us {
            drop_before(link, cut, before_us, report).await?;
        }
        if let Some(lookup) = cut.lookup {
            index_before(link, cut, lookup, now_us - INDEXED_AFTER_US, report).await?;
        }
    }
    sqlx::query("SELECT pg_advisory_unlock($1)").bind(UPKEEP).execute(link).await.map(drop)
}

/// Drops the partitions that ended before a time, and deletes older rows from the default partition.
async fn drop_before(
    link: &mut PgConnection,
    cut: &Cut,
    before_us: i64,
    report: &mut impl FnMut(Done),
) -> sqlx::Result<()> {
    for one in partitions(link, cut).await?.into_iter().filter(|one| one.span.to_us <= before_us) {
        let mut tx = link.begin().await?;
        // The drop locks the whole table. While it waits for a running query, commits wait behind it, for 200 ms at
        // most.
        run(&mut tx, "SET LOCAL lock_timeout = '200ms'".to_owned()).await?;
        run(&mut tx, format!("DROP TABLE {}", quoted(&one.name))).await?;
        tx.commit().await?;
        report(Done::Dropped { partition: one.name, bytes: one.bytes });
    }
    let (table, key) = (cut.table, cut.key);
    loop {
        let caught = format!(
            "DELETE FROM {table}_default WHERE ctid IN \
             (SELECT ctid FROM {table}_default WHERE {key} < {before_us} LIMIT {ROWS})"
        );
        let rows = run(link, caught).await?;
        if rows == 0 {
            return Ok(());
        }
        report(Done::Removed { table, rows });
    }
}

/// Adds the index for queries to partitions that ended before a time, without blocking anybody.
async fn index_before(
    link: &mut PgConnection,
    cut: &Cut,
    (who, time): (&'static str, &'static str),
    before_us: i64,
    report: &mut impl FnMut(Done),
) -> sqlx::Result<()> {
    for one in partitions(link, cut).await?.into_iter().filter(|one| one.span.to_us <= before_us) {
        let indices = sqlx::query(
            "SELECT x.relname::text AS name, indisvalid AS valid FROM pg_index i JOIN pg_class x ON x.oid = indexrelid \
             WHERE indrelid = $1::regclass AND indnkeyatts = 2",
        )
        .bind(quoted(&one.name))
        .fetch_all(&mut *link)
        .await?;
        if indices.iter().any(|index| index.get("valid")) {
            continue;
        }
        // Invalid indices of interrupted attempts.
        for index in indices {
            run(link, format!("DROP INDEX CONCURRENTLY {}", quoted(index.get("name")))).await?;
        }
        let index = quoted(&format!("{}_of_whisker", one.name));
        run(link, format!("CREATE INDEX CONCURRENTLY {index} ON {} ({who}, {time})", quoted(&one.name))).await?;
        report(Done::Indexed { partition: one.name });
    }
    Ok(())
}

fn quoted(name: &str) -> String {
    format!("\"{}\"", name.replace('"', "\"\""))
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOON_US: i64 = 1_795_262_400_000_000;

    #[test]
    fn golden_spans_and_names() {
        // `date -u -d @1795262400`: 2026-11-21 12:00:00
        let day = CONTACTS.span_at(NOON_US);
        assert_eq!((day.from_us, day.to_us), (NOON_US - DAY_US / 2, NOON_US + DAY_US / 2));
        assert_eq!(CONTACTS.name_of(day), "contacts_20261121");
        assert_eq!(CONTACTS.span_at(day.to_us - 1), day);
        let next = CONTACTS.span_at(day.to_us);
        assert_eq!((next.from_us, CONTACTS.name_of(next).as_str()), (day.to_us, "contacts_20261122"));
        let month = MINUTES.span_at(NOON_US);
        assert_eq!(month.to_us - month.from_us, 30 * DAY_US);
        assert_eq!(MINUTES.name_of(month), "contact_minutes_20261103");
    }

    #[test]
    fn what_postgres_says_of_partitions_is_understood() {
        let span = |from_us, to_us| Some(Span { from_us, to_us });
        assert_eq!(bounds("FOR VALUES FROM ('5') TO ('-7')"), span(5, -7));
        assert_eq!(bounds("FOR VALUES FROM (MINVALUE) TO ('1795305600000000')"), span(i64::MIN, 1_795_305_600_000_000));
        assert_eq!(bounds("FOR VALUES FROM ('1') TO (MAXVALUE)"), span(1, i64::MAX));
        assert_eq!((bounds("DEFAULT"), bounds("FOR VALUES IN ('1')")), (None, None));
    }

    #[test]
    fn what_lies_in_another_partition_already_is_not_missing() {
        let span = |from_us, to_us| Span { from_us, to_us };
        let of = |span| Partition { name: String::new(), span, bytes: 0 };
        let before = [of(span(i64::MIN, 20)), of(span(30, 40))];
        for (from, to, missing) in [(10, 20, false), (20, 30, true), (30, 40, false), (40, 50, true), (15, 25, false)] {
            assert_eq!(is_missing(&before, span(from, to)), missing, "{from} to {to}");
        }
    }
}
