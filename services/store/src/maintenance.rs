//! Windows of maintenance: times in which alarms of a fleet or of a robot are shelved and notify nobody.

use sqlx::AssertSqlSafe;
use vibrissa_edge::events::EventKind;

use super::actions::{Asked, NewAction, record_done};
use super::database::{Tx, on};
use super::events::write::EventRow;
use super::events::{StoredEvent, VERSION};
use super::from_row::from_row;
use super::set_aside::SetAside;
use super::{Store, StoreError, events, failed};

/// Most windows in the database.
pub const WINDOWS_MAX: i64 = 200;
/// Time for which a window is kept after its end, µs: 30 days.
const KEPT_US: i64 = 30 * 86_400_000_000;

const TABLE: &str = "maintenance";

/// Most spans of time whose alarms one message at the end of a window lists.
const SPANS_MAX: usize = 400;

const WHAT: &str = "change the windows of maintenance";

from_row! {
    /// A window of maintenance, or a series of windows.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct MaintenanceRow {
        /// Number of the window.
        pub maintenance_id: i64,
        /// Name of the fleet.
        pub fleet: String,
        /// Name of the robot; `None` for all robots of the fleet.
        pub robot: Option<String>,
        /// Number of the robot; `None` for all robots of the fleet.
        pub robot_id: Option<i64>,
        /// Begin of the first window, µs since 1970 UTC.
        pub begins_us: i64,
        /// Length of each window, µs.
        pub lasts_us: i64,
        /// Time from one begin to the next, µs; `None` for a single window.
        pub repeat_us: Option<i64>,
        /// Time from which on there is no window, µs since 1970 UTC; `None` without such a time.
        pub ended_us: Option<i64>,
        /// End of the last window whose alarms were told again, µs since 1970 UTC.
        pub told_us: i64,
        /// Reason that the person gave.
        pub reason: String,
        /// Person or token that set it.
        pub set_by: String,
        /// Time at which it was set, µs since 1970 UTC.
        pub set_us: i64,
    }
}

const SELECT: &str = "SELECT maintenance_id, m.fleet, robot, m.robot_id, begins_us, lasts_us, repeat_us, ended_us, told_us, \
     reason, set_by, set_us FROM maintenance m LEFT JOIN robots r ON r.robot_id = m.robot_id";

/// A new window.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NewMaintenance {
    /// Name of the fleet.
    pub fleet: String,
    /// Name of the robot; `None` for all robots of the fleet.
    pub robot: Option<String>,
    /// Begin of the first window, µs since 1970 UTC.
    pub begins_us: i64,
    /// Length of each window, µs.
    pub lasts_us: i64,
    /// Time from one begin to the next, µs, at least the length; `None` for a single window.
    pub repeat_us: Option<i64>,
    /// Time from which on there is no window, µs since 1970 UTC.
    pub ended_us: Option<i64>,
    /// Reason that the person gave.
    pub reason: String,
}

/// Result of setting a window.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Planned {
    /// The window with this number is as asked.
    Done(i64),
    /// The same request was executed before, or its key belongs to a different action.
    Known(Box<Asked>),
    /// There is no such robot.
    NoRobot,
    /// There are [`WINDOWS_MAX`] windows.
    Full,
}

impl MaintenanceRow {
    /// Begin and end of the window that began last before a time, or at it; `None` before the first.
    fn newest(&self, at_us: i64) -> Option<(i64, i64)> {
        if at_us < self.begins_us {
            return None;
        }
        let since_us = at_us.saturating_sub(self.begins_us);
        // A row of which a bit has changed may have any numbers.
        let repeat_us = self.repeat_us.filter(|&repeat_us| repeat_us > 0).unwrap_or(i64::MAX);
        // A time behind the end of a series belongs to no later window than the last one.
        let last_us =
            self.ended_us.map_or(i64::MAX, |ended_us| ended_us.saturating_sub(self.begins_us).saturating_sub(1).max(0));
        let begins_us = self.begins_us + since_us.min(last_us) / repeat_us * repeat_us;
        let ends_us = begins_us.saturating_add(self.lasts_us);
        Some((begins_us, self.ended_us.map_or(ends_us, |ended_us| ends_us.min(ended_us))))
    }

    /// Begin and end of the window at a time; `None` if there is none.
    #[must_use]
    pub fn at(&self, at_us: i64) -> Option<(i64, i64)> {
        self.newest(at_us).filter(|(_, ends_us)| at_us < *ends_us)
    }

    /// Begin and end of the window at a time, or else of the next one; `None` if no window comes any more.
    #[must_use]
    pub fn next(&self, at_us: i64) -> Option<(i64, i64)> {
        let following_us = match self.newest(at_us) {
            None => self.begins_us,
            Some((_, ends_us)) if at_us < ends_us => at_us,
            Some((begins_us, _)) => begins_us.checked_add(self.repeat_us?)?,
        };
        self.at(following_us)
    }

    /// The window that has ended last before a time.
    fn ended(&self, at_us: i64) -> Option<(i64, i64)> {
        let newest = self.newest(at_us)?;
        if newest.1 <= at_us { Some(newest) } else { self.newest(newest.0.saturating_sub(1)) }
    }

    /// Whether a robot is in maintenance at a time.
    #[must_use]
    pub fn concerns(&self, fleet: &str, robot: Option<&str>, at_us: i64) -> bool {
        let is_of_robot = self.robot.is_none() || self.robot.as_deref() == robot;
        self.fleet == fleet && is_of_robot && self.at(at_us).is_some()
    }
}

/// Whether windows keep an event from a webhook: a new alarm. A person does not learn of its end either.
pub(crate) fn is_muted(windows: &[MaintenanceRow], event: &StoredEvent, is_mail: bool) -> bool {
    let is_of_alarm = match event.event_kind() {
        Some(EventKind::AlarmRaised) => true,
        Some(EventKind::AlarmCleared) => is_mail,
        _ => false,
    };
    let concerns = |one: &MaintenanceRow| one.concerns(&event.fleet, event.robot.as_deref(), event.recorded_us);
    is_of_alarm && windows.iter().any(concerns)
}

/// Every window in the database, single ones and series.
pub(crate) async fn windows(tx: &mut Tx<'_>, set_aside: &SetAside) -> sqlx::Result<Vec<MaintenanceRow>> {
    let rows = on!(tx, |tx| sqlx::query_as(SELECT).fetch_all(&mut **tx).await)?;
    Ok(set_aside.readable(TABLE, rows))
}

impl Store {
    /// All windows, also those that have ended less than 30 days ago, in the order of their numbers.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn maintenance(&self) -> Result<Vec<MaintenanceRow>, StoreError> {
        let sql = format!("{SELECT} ORDER BY maintenance_id");
        let rows = on!(&self.pool, |pool| sqlx::query_as(AssertSqlSafe(sql)).fetch_all(pool).await)
            .map_err(failed("list the windows of maintenance"))?;
        Ok(self.set_aside.readable(TABLE, rows))
    }

    /// Sets a window at most once, and records the action in the audit log. Windows that ended 30 days ago are removed.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn set_maintenance(&self, new: &NewMaintenance, action: &NewAction) -> Result<Planned, StoreError> {
        const OLD: &str = "DELETE FROM maintenance WHERE coalesce(ended_us, $1) < $1 \
             OR repeat_us IS NULL AND begins_us + lasts_us < $1";
        const COUNT: &str = "SELECT count(*) FROM maintenance";
        const ROBOT: &str = "SELECT robot_id FROM robots WHERE fleet = $1 AND robot = $2";
        const INSERT: &str = "INSERT INTO maintenance (fleet, robot_id, begins_us, lasts_us, repeat_us, ended_us, told_us, \
             reason, set_by, set_us) VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $7) RETURNING maintenance_id";
        let (now_us, mut tx) = (action.asked_us, self.pool.begin().await.map_err(failed(WHAT))?);
        let asked = record_done(&mut tx, action, now_us).await?;
        if !matches!(asked, Asked::New(_)) {
            return Ok(Planned::Known(Box::new(asked)));
        }
        on!(&mut tx, |tx| sqlx::query(OLD).bind(now_us - KEPT_US).execute(&mut **tx).await.map(drop))
            .map_err(failed(WHAT))?;
        let many: i64 =
            on!(&mut tx, |tx| sqlx::query_scalar(COUNT).fetch_one(&mut **tx).await).map_err(failed(WHAT))?;
        if many >= WINDOWS_MAX {
            return Ok(Planned::Full);
        }
        let mut robot_id = None;
        if let Some(robot) = &new.robot {
            let found: Option<i64> = on!(&mut tx, |tx| sqlx::query_scalar(ROBOT)
                .bind(&new.fleet)
                .bind(robot)
                .fetch_optional(&mut **tx)
                .await)
            .map_err(failed(WHAT))?;
            let Some(found) = found else { return Ok(Planned::NoRobot) };
            robot_id = Some(found);
        }
        let maintenance_id: i64 = on!(&mut tx, |tx| sqlx::query_scalar(INSERT)
            .bind(&new.fleet)
            .bind(robot_id)
            .bind(new.begins_us)
            .bind(new.lasts_us)
            .bind(new.repeat_us)
            .bind(new.ended_us)
            .bind(now_us)
            .bind(&new.reason)
            .bind(&action.actor)
            .fetch_one(&mut **tx)
            .await)
        .map_err(failed(WHAT))?;
        tell_pages(&mut tx, &new.fleet, now_us).await.map_err(failed(WHAT))?;
        tx.commit().await.map_err(failed(WHAT))?;
        Ok(Planned::Done(maintenance_id))
    }

    /// Ends a window and its series now, at most once, and records the action in the audit log.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn end_maintenance(&self, row: &MaintenanceRow, action: &NewAction) -> Result<Asked, StoreError> {
        const SQL: &str = "UPDATE maintenance SET ended_us = $2 WHERE maintenance_id = $1 \
             AND (ended_us IS NULL OR ended_us > $2)";
        let (now_us, mut tx) = (action.asked_us, self.pool.begin().await.map_err(failed(WHAT))?);
        let asked = record_done(&mut tx, action, now_us).await?;
        if matches!(asked, Asked::New(_)) {
            on!(&mut tx, |tx| sqlx::query(SQL)
                .bind(row.maintenance_id)
                .bind(now_us)
                .execute(&mut **tx)
                .await
                .map(drop))
            .map_err(failed(WHAT))?;
            tell_pages(&mut tx, &row.fleet, now_us).await.map_err(failed(WHAT))?;
        }
        tx.commit().await.map_err(failed(WHAT))?;
        Ok(asked)
    }

    /// Tells once more of the alarms that were raised in a window and stand after its end.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn tell_after_maintenance(&self, now_us: i64) -> Result<(), StoreError> {
        const WHAT: &str = "tell the alarms after a maintenance";
        if self.model.is_some() {
            // It has no windows.
            return Ok(());
        }
        let rows = self.maintenance().await?;
        for row in &rows {
            let Some(window) = row.ended(now_us).filter(|(_, ends_us)| *ends_us > row.told_us) else {
                continue;
            };
            let mut tx = self.pool.begin().await.map_err(failed(WHAT))?;
            tell_again(&mut tx, row, &spans(&rows, row, window), window.1, now_us).await.map_err(failed(WHAT))?;
            tx.commit().await.map_err(failed(WHAT))?;
        }
        Ok(())
    }
}

/// Has live pages read their lists again.
async fn tell_pages(tx: &mut Tx<'_>, fleet: &str, now_us: i64) -> sqlx::Result<()> {
    events::write::write(tx, fleet, &[EventRow::new(EventKind::Action, now_us)]).await
}

/// A span of time; the end of a window lists the alarms of its spans.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Span {
    begins_us: i64,
    ends_us: i64,
    /// Number of the robot; `None` for all robots of the fleet.
    robot_id: Option<i64>,
}

/// Spans of a window's end: its own, and those of windows that ended within it, because their ends listed nothing. The
/// rule holds for windows that ended within these, too.
fn spans(rows: &[MaintenanceRow], row: &MaintenanceRow, (begins_us, ends_us): (i64, i64)) -> Vec<Span> {
    let mut spans = vec![Span { begins_us, ends_us, robot_id: row.robot_id }];
    let mut next = 0;
    while let Some(&span) = spans.get(next).filter(|_| next < SPANS_MAX) {
        next += 1;
        for other in rows.iter().filter(|other| other.fleet == row.fleet) {
            if other.robot_id.is_some() && span.robot_id.is_some() && other.robot_id != span.robot_id {
                continue;
            }
            // A window that ends as the span begins belongs to it.
            let Some((begins_us, until_us)) = other.at(span.begins_us - 1) else { continue };
            let earlier = Span { begins_us, ends_us: until_us, robot_id: span.robot_id.or(other.robot_id) };
            if until_us <= ends_us && !spans.contains(&earlier) {
                spans.push(earlier);
            }
        }
    }
    spans
}

/// Unless another supervisor has done it.
async fn tell_again(
    tx: &mut Tx<'_>,
    row: &MaintenanceRow,
    spans: &[Span],
    ends_us: i64,
    now_us: i64,
) -> sqlx::Result<()> {
    const TOLD: &str = "UPDATE maintenance SET told_us = $2 WHERE maintenance_id = $1 AND told_us < $2";
    let told = on!(&mut *tx, |tx| sqlx::query(TOLD)
        .bind(row.maintenance_id)
        .bind(ends_us)
        .execute(&mut **tx)
        .await
        .map(|done| done.rows_affected()))?;
    if told == 0 {
        return Ok(());
    }
    let raised = |Span { begins_us, ends_us, robot_id }: &Span| {
        let of_robot = robot_id.map(|id| format!(" AND r.robot_id = {id}")).unwrap_or_default();
        format!("(a.raised_us >= {begins_us} AND a.raised_us < {ends_us}{of_robot})")
    };
    let raised = spans.iter().map(raised).collect::<Vec<_>>().join(" OR ");
    let insert = format!(
        "INSERT INTO events (recorded_us, version, kind, audience, word, fleet, robot_id, whisker_id, data) \
         SELECT CAST($1 AS BIGINT), {VERSION}, 'ALARM_RAISED', 'PEOPLE', a.kind, r.fleet, r.robot_id, a.whisker_id, '{{}}' \
         FROM alarms a LEFT JOIN whiskers w ON w.whisker_id = a.whisker_id \
         JOIN robots r ON r.robot_id = coalesce(a.robot_id, w.robot_id) \
         WHERE a.cleared_us IS NULL AND r.fleet = $2 AND ({raised}) ORDER BY a.alarm_id"
    );
    on!(tx, |tx| sqlx::query(AssertSqlSafe(insert)).bind(now_us).bind(&row.fleet).execute(&mut **tx).await.map(drop))
}

#[cfg(test)]
mod tests {
    use super::*;

    const HOUR: i64 = 3_600_000_000;
    const DAY: i64 = 24 * HOUR;

    fn window(repeat_us: Option<i64>, ended_us: Option<i64>) -> MaintenanceRow {
        MaintenanceRow {
            maintenance_id: 1,
            fleet: "hall".to_owned(),
            robot: None,
            robot_id: None,
            begins_us: 10 * HOUR,
            lasts_us: 2 * HOUR,
            repeat_us,
            ended_us,
            told_us: 0,
            reason: "belts".to_owned(),
            set_by: "ann".to_owned(),
            set_us: 0,
        }
    }

    #[test]
    fn a_window_tells_the_alarms_of_those_that_ended_in_it() {
        let of = |begins: i64, lasts: i64, robot_id: Option<i64>| MaintenanceRow {
            begins_us: begins * HOUR,
            lasts_us: lasts * HOUR,
            robot: robot_id.map(|id| id.to_string()),
            robot_id,
            ..window(None, None)
        };
        let told = |rows: &[MaintenanceRow]| {
            let last = rows.last().unwrap();
            let spans = spans(rows, last, last.ended(90 * DAY).unwrap());
            spans.iter().map(|one| (one.begins_us / HOUR, one.ends_us / HOUR, one.robot_id)).collect::<Vec<_>>()
        };
        let last = of(11, 4, None);
        let all = |rows: &[MaintenanceRow]| told(&[rows, std::slice::from_ref(&last)].concat());
        assert_eq!(all(&[]), [(11, 15, None)]);
        assert_eq!(all(&[of(10, 2, None)]), [(11, 15, None), (10, 12, None)], "it ends in the last one");
        assert_eq!(all(&[of(9, 2, None)]), [(11, 15, None), (9, 11, None)], "it ends as the last one begins");
        assert_eq!(all(&[of(8, 2, None)]), [(11, 15, None)], "it ended before, and was told");
        assert_eq!(all(&[of(10, 9, None)]), [(11, 15, None)], "it tells the last one's at its own end");
        assert_eq!(all(&[of(12, 1, None)]), [(11, 15, None)], "it is in the last one");
        assert_eq!(all(&[of(10, 2, Some(7))]), [(11, 15, None), (10, 12, Some(7))], "of one robot");
        let chain = [of(8, 2, Some(7)), of(9, 3, None)];
        assert_eq!(all(&chain), [(11, 15, None), (9, 12, None), (8, 10, Some(7))], "one after the other");
        let robots = [of(10, 2, Some(8)), of(10, 2, Some(7)), of(11, 4, Some(7))];
        assert_eq!(told(&robots), [(11, 15, Some(7)), (10, 12, Some(7))], "another robot's are its own");
        let foreign = MaintenanceRow { fleet: "yard".to_owned(), ..of(10, 2, None) };
        assert_eq!(all(&[foreign]), [(11, 15, None)]);
    }

    #[test]
    fn a_single_window_is_from_its_begin_to_before_its_end() {
        let once = window(None, None);
        let own = Some((10 * HOUR, 12 * HOUR));
        assert_eq!([10 * HOUR - 1, 10 * HOUR, 12 * HOUR - 1, 12 * HOUR].map(|at| once.at(at)), [None, own, own, None]);
        assert_eq!([0, 11 * HOUR, 12 * HOUR].map(|at| once.next(at)), [own, own, None]);
        assert_eq!([11 * HOUR, 12 * HOUR, 90 * DAY].map(|at| once.ended(at)), [None, own, own]);
    }

    #[test]
    fn a_series_ends_with_its_last_window_and_one_under_way_is_cut() {
        let daily = window(Some(DAY), None);
        let second = Some((DAY + 10 * HOUR, DAY + 12 * HOUR));
        assert_eq!((daily.at(DAY + 11 * HOUR), daily.next(13 * HOUR)), (second, second));
        assert_eq!(daily.ended(2 * DAY), second);
        assert_eq!(daily.ended(DAY + 11 * HOUR), Some((10 * HOUR, 12 * HOUR)));
        let cut = window(Some(DAY), Some(DAY + 11 * HOUR));
        let last = Some((DAY + 10 * HOUR, DAY + 11 * HOUR));
        assert_eq!((cut.at(DAY + 10 * HOUR), cut.at(DAY + 11 * HOUR)), (last, None));
        assert_eq!((cut.next(DAY + 11 * HOUR), cut.next(9 * DAY)), (None, None));
        assert_eq!(cut.ended(9 * DAY), last);
        let never = window(Some(DAY), Some(5 * HOUR));
        assert_eq!((never.at(11 * HOUR), never.next(0)), (None, None));
    }

    #[test]
    fn brute_force_windows_of_a_series() {
        let daily = window(Some(DAY), Some(3 * DAY + 11 * HOUR));
        for at in (0..5 * DAY).step_by(HOUR as usize / 2) {
            let begin = (0..5).map(|day| day * DAY + 10 * HOUR).find(|begin| (*begin..begin + 2 * HOUR).contains(&at));
            let expected = begin.filter(|_| at < 3 * DAY + 11 * HOUR);
            assert_eq!(daily.at(at).map(|(begin, _)| begin), expected, "{at}");
        }
    }

    #[test]
    fn a_window_of_a_robot_concerns_it_alone() {
        let one = MaintenanceRow { robot: Some("r".to_owned()), ..window(None, None) };
        assert!(one.concerns("hall", Some("r"), 11 * HOUR));
        assert!(!one.concerns("hall", Some("q"), 11 * HOUR) && !one.concerns("hall", None, 11 * HOUR));
        assert!(!one.concerns("lab", Some("r"), 11 * HOUR) && !one.concerns("hall", Some("r"), 12 * HOUR));
        assert!(window(None, None).concerns("hall", Some("q"), 11 * HOUR));
    }
}
