//! Contacts of a whisker over time: single contacts, or means over equal spans of time.

use super::database::on;
use super::from_row::from_row;
use super::time::Time;
use super::{Store, StoreError, failed};

from_row! {
    /// A contact, or the mean of the contacts in a span of time.
    #[derive(Debug, Clone, PartialEq)]
    pub struct ContactMean {
        /// Time of the contact or start of the span, µs since 1970 UTC by the robot's clock. Queries of means first
        /// return the number of the span here.
        pub at_us: i64,
        /// Number of contacts; 1 for a single contact.
        pub contacts: i64,
        /// Contact ratio, 0 at the base, 1 at the tip; `None` if no place is known.
        pub ratio: Option<f64>,
        /// Measured distance from the base, mm; `None` if the robot stated none.
        pub distance_mm: Option<f64>,
        /// Deflection at the contact, mm.
        pub deflection_mm: f64,
        /// Measured strain, m/m.
        pub strain: f64,
        /// Pressure of the chamber, MPa.
        pub pressure_mpa: f64,
        /// Temperature at the gauge, °C; `None` if none was stored.
        pub temperature_c: Option<f64>,
        /// Sensitivity, strain per mm of deflection; `None` without deflection.
        pub sensitivity_per_mm: Option<f64>,
        /// ln(measured / predicted sensitivity); `None` if no contact was used.
        pub residual: Option<f64>,
        /// Estimated length, mm.
        pub length_mm: f64,
        /// Standard deviation of the estimated length, mm.
        pub length_sd_mm: f64,
    }

    /// Number and range of times of the contacts in a span.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    struct Extent {
        total: i64,
        first_us: Option<i64>,
        last_us: Option<i64>,
    }
}

/// Requested span of time and resolution.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Span {
    /// Start of the span, by the robot's clock; `None` for one day before its end.
    pub from: Option<Time>,
    /// End of the span, excluded, by the robot's clock; `None` for the newest contact.
    pub to: Option<Time>,
    /// Most points of the result; must be above 0.
    pub points: u32,
}

/// Contacts over time, in order.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Start of the evaluated span, by the robot's clock; `None` if there is no contact.
    pub from: Option<Time>,
    /// End of the evaluated span, excluded; `None` if there is no contact.
    pub to: Option<Time>,
    /// Number of contacts in the span.
    pub total: i64,
    /// Length of the spans of the means, µs; `None` if `items` are single contacts.
    pub bucket_us: Option<i64>,
    /// Contacts or means. The time of a mean is the start of its span; spans without contacts are left out.
    pub items: Vec<ContactMean>,
}

const DAY_US: i64 = 86_400_000_000;
/// Length of the evaluated span if `from` is not given, µs.
pub const SPAN_US: i64 = DAY_US;
/// Greatest length of the evaluated span, µs; of a longer one, the newest part is evaluated.
pub const SPAN_MAX_US: i64 = 31 * DAY_US;
/// Length of the first span that is searched for the newest contacts, up to the last message about the whisker, µs.
const FIRST_REACH_US: i64 = 10_000_000;
/// Factor by which the searched span grows each time.
const REACH_FACTOR: i64 = 8;

impl Store {
    /// Number of a whisker in the database; `None` if it is unknown. The whisker may have left its robot.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn whisker_id(&self, whisker: (&str, &str, &str, u16)) -> Result<Option<i64>, StoreError> {
        on!(&self.pool, |pool| sqlx::query_scalar(
            "SELECT whisker_id FROM whiskers w JOIN arrays USING (array_id) JOIN robots r ON r.robot_id = w.robot_id \
             WHERE fleet = $1 AND robot = $2 AND \"array\" = $3 AND whisker = $4",
        )
        .bind(whisker.0)
        .bind(whisker.1)
        .bind(whisker.2)
        .bind(i64::from(whisker.3))
        .fetch_optional(pool)
        .await)
        .map_err(failed("read a whisker's number"))
    }

    /// Contacts of a whisker: the newest ones if no time is given, else those in the span, as means if there are more
    /// than `points`.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn contacts(&self, whisker_id: i64, span: Span) -> Result<Series, StoreError> {
        const WHAT: &str = "read a whisker's contacts";
        let is_newest = span.from.is_none() && span.to.is_none();
        let newest = self.newest_contacts(whisker_id, if is_newest { span.points } else { 1 }).await;
        let newest = newest.map_err(failed(WHAT))?;
        let Some(newest_us) = newest.items.last().map(|last| last.at_us).filter(|_| !is_newest) else {
            return Ok(newest);
        };
        let to_us = span.to.map_or(newest_us + 1, |to| to.0.min(newest_us + 1));
        let from_us = span.from.map_or(to_us - SPAN_US, |from| from.0).clamp(to_us - SPAN_MAX_US, to_us);
        self.contacts_of((whisker_id, from_us, to_us), span.points).await.map_err(failed(WHAT))
    }

    /// The newest contacts. PostgreSQL has no index by whisker for the partition of today, so a short span up to the
    /// last message about the whisker is searched first, and then ever longer ones.
    async fn newest_contacts(&self, whisker_id: i64, points: u32) -> sqlx::Result<Series> {
        const HEARD: &str = "SELECT heard_us FROM whiskers WHERE whisker_id = $1";
        let heard_us: Option<Option<i64>> =
            on!(&self.pool, |pool| sqlx::query_scalar(HEARD).bind(whisker_id).fetch_optional(pool).await)?;
        if let Some(heard_us) = heard_us.flatten() {
            let mut reach_us = FIRST_REACH_US;
            while reach_us < SPAN_MAX_US {
                let newest = self.newest_since(whisker_id, heard_us - reach_us, points).await?;
                if newest.total == i64::from(points) {
                    return Ok(newest);
                }
                reach_us *= REACH_FACTOR;
            }
        }
        self.newest_since(whisker_id, i64::MIN, points).await
    }

    async fn newest_since(&self, whisker_id: i64, from_us: i64, points: u32) -> sqlx::Result<Series> {
        const SQL: &str = "SELECT t_us AS at_us, CAST(1 AS BIGINT) AS contacts, ratio, distance_mm, deflection_mm, strain, \
             pressure_mpa, temperature_c, strain / NULLIF(deflection_mm, 0) AS sensitivity_per_mm, residual, length_mm, length_sd_mm FROM contacts \
             WHERE whisker_id = $1 AND t_us >= $2 ORDER BY t_us DESC, boot DESC, seq DESC, position DESC LIMIT $3";
        let mut items: Vec<ContactMean> = on!(&self.pool, |pool| sqlx::query_as(SQL)
            .bind(whisker_id)
            .bind(from_us)
            .bind(i64::from(points))
            .fetch_all(pool)
            .await)?;
        items.reverse();
        let from = items.first().map(|first| Time(first.at_us));
        let to = items.last().map(|last| Time(last.at_us + 1));
        Ok(Series { from, to, total: items.len() as i64, bucket_us: None, items })
    }

    async fn contacts_of(&self, of: (i64, i64, i64), points: u32) -> sqlx::Result<Series> {
        const EXTENT: &str = "SELECT count(*) AS total, min(t_us) AS first_us, max(t_us) AS last_us FROM contacts \
             WHERE whisker_id = $1 AND t_us >= $2 AND t_us < $3";
        const EACH: &str = "SELECT t_us AS at_us, CAST(1 AS BIGINT) AS contacts, ratio, distance_mm, deflection_mm, strain, \
             pressure_mpa, temperature_c, strain / NULLIF(deflection_mm, 0) AS sensitivity_per_mm, residual, length_mm, length_sd_mm \
             FROM contacts WHERE whisker_id = $1 AND t_us >= $2 AND t_us < $3 ORDER BY t_us, boot, seq, position LIMIT $4";
        const MEANS: &str = "SELECT bucket AS at_us, count(*) AS contacts, avg(ratio) AS ratio, \
             avg(distance_mm) AS distance_mm, avg(deflection_mm) AS deflection_mm, avg(strain) AS strain, avg(pressure_mpa) AS pressure_mpa, \
             avg(temperature_c) AS temperature_c, avg(strain / NULLIF(deflection_mm, 0)) AS sensitivity_per_mm, avg(residual) AS residual, \
             avg(length_mm) AS length_mm, avg(length_sd_mm) AS length_sd_mm \
             FROM (SELECT (t_us - $2) / $4 AS bucket, c.* FROM contacts c \
              WHERE whisker_id = $1 AND t_us >= $2 AND t_us < $3) b GROUP BY bucket ORDER BY bucket";
        let (whisker_id, from_us, to_us) = of;
        let mut series =
            Series { from: Some(Time(from_us)), to: Some(Time(to_us)), total: 0, bucket_us: None, items: Vec::new() };
        let extent: Extent = on!(&self.pool, |pool| sqlx::query_as(EXTENT)
            .bind(whisker_id)
            .bind(from_us)
            .bind(to_us)
            .fetch_one(pool)
            .await)?;
        let (Some(first_us), Some(last_us)) = (extent.first_us, extent.last_us) else { return Ok(series) };
        series.total = extent.total;
        // Equal spans from the first contact to the last, at most as many as points.
        let bucket_us = (last_us - first_us) / i64::from(points) + 1;
        let is_each = extent.total <= i64::from(points);
        let (sql, last) = if is_each { (EACH, i64::from(points)) } else { (MEANS, bucket_us) };
        series.items = on!(&self.pool, |pool| sqlx::query_as(sql)
            .bind(whisker_id)
            .bind(first_us)
            .bind(to_us)
            .bind(last)
            .fetch_all(pool)
            .await)?;
        if !is_each {
            series.bucket_us = Some(bucket_us);
            for item in &mut series.items {
                item.at_us = first_us + item.at_us * bucket_us;
            }
        }
        Ok(series)
    }
}
