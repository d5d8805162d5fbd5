//! Reads contacts and setpoints from the database at the end of a run.

use sqlx::postgres::{PgConnection, PgRow};
use sqlx::{Connection, Row};

use super::ledger::{Content, Ledger, Recorded};
use super::obedience::Decided;

/// Adds every contact of the honest robots to the ledger, in any order: sorting the rows of a long run takes longer
/// than reading them.
///
/// # Errors
/// The database does not answer.
pub async fn contacts(connection: &mut PgConnection, hostile: &[String], ledger: &mut Ledger) -> sqlx::Result<()> {
    const ALL: &str = "DECLARE all_contacts CURSOR FOR SELECT robot, b.boot_id, seq, c.position, \"array\", whisker, \
        t_us, ratio, deflection_mm, strain, c.pressure_mpa, coalesce(temperature_c, 'NaN') \
        FROM contacts c JOIN boots b USING (boot) \
        JOIN robots r USING (robot_id) JOIN whiskers w USING (whisker_id) JOIN arrays a USING (array_id) \
        WHERE NOT (robot = ANY($1))";
    let mut tx = connection.begin().await?;
    sqlx::query(ALL).bind(hostile).execute(&mut *tx).await?;
    loop {
        let rows = sqlx::query("FETCH 20000 FROM all_contacts").fetch_all(&mut *tx).await?;
        if rows.is_empty() {
            return tx.rollback().await;
        }
        rows.iter().for_each(|row| ledger.recorded(contact(row)));
    }
}

fn contact(row: &PgRow) -> Recorded {
    Recorded {
        robot: row.get(0),
        boot_id: row.get(1),
        seq: row.get::<i64, _>(2) as u64,
        position: row.get::<i64, _>(3) as usize,
        content: Content {
            array: row.get(4),
            whisker: row.get(5),
            t_us: row.get(6),
            values: [row.get(7), row.get(8), row.get(9), row.get(10), row.get(11)],
        },
    }
}

/// Number of contacts of the honest robots.
///
/// # Errors
/// The database does not answer.
pub async fn count(connection: &mut PgConnection, hostile: &[String]) -> sqlx::Result<i64> {
    const SQL: &str = "SELECT count(*) FROM contacts WHERE NOT (boot = ANY(ARRAY(\
        SELECT boot FROM boots JOIN robots USING (robot_id) WHERE robot = ANY($1))))";
    sqlx::query_scalar(SQL).bind(hostile).fetch_one(connection).await
}

/// All setpoints of the honest robots.
///
/// # Errors
/// The database does not answer, or a gain is not valid JSON.
pub async fn setpoints(connection: &mut PgConnection, hostile: &[String]) -> sqlx::Result<Vec<Decided>> {
    const SQL: &str = "SELECT command_id, robot, \"array\", whisker, compensation_id, epoch, version, s.pressure_mpa, \
        reason, s.state, s.gain, s.robot_boot_id FROM setpoints s JOIN whiskers w USING (whisker_id) JOIN arrays a USING (array_id) \
        JOIN robots r ON r.robot_id = s.robot_id WHERE NOT (robot = ANY($1))";
    let decided = |row: PgRow| {
        let gain: Option<String> = row.get(10);
        let gain = gain.as_deref().map_or(Ok(Vec::new()), serde_json::from_str);
        Ok(Decided {
            command_id: row.get(0),
            whisker: (row.get(1), row.get(2), row.get(3)),
            compensation_id: row.get(4),
            order: (row.get(5), row.get(6)),
            pressure_mpa: row.get(7),
            reason: row.get(8),
            state: row.get(9),
            robot_boot_id: row.get(11),
            gain: gain.map_err(|problem| sqlx::Error::Decode(problem.into()))?,
        })
    };
    sqlx::query(SQL).bind(hostile).fetch_all(connection).await?.into_iter().map(decided).collect()
}
