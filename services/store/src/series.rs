//! Contacts of a whisker over time: one by one, or as means over equal spans of time.

use super::database::on;
use super::readings::readings;
use super::time::Time;
use super::{Store, StoreError, failed};

readings! {
    /// A contact, or the mean of those in a span of time.
    #[derive(Debug, Clone, PartialEq)]
    pub struct ContactMean {
        /// When, by the robot's clock; or the number of the span.
        pub at_us: i64,
        /// How many.
        pub contacts: i64,
        /// Contact ratio.
        pub ratio: f64,
        /// Deflection.
        pub deflection_mm: f64,
        /// Strain, m/m.
        pub strain: f64,
        /// Pressure.
        pub pressure_mpa: f64,
        /// Strain by deflection.
        pub sensitivity_per_mm: Option<f64>,
        /// ln(measured / predicted sensitivity), of those that were used.
        pub residual: Option<f64>,
        /// Estimated length.
        pub length_mm: f64,
        /// Its standard deviation.
        pub length_sd_mm: f64,
    }

    /// What there is in a span of time.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    struct Extent {
        total: i64,
        first_us: Option<i64>,
        last_us: Option<i64>,
    }
}

/// What is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Span {
    /// From then on, by the robot's clock.
    pub from: Option<Time>,
    /// Before then.
    pub to: Option<Time>,
    /// Points at the most, above 0.
    pub points: u32,
}

/// Contacts over time, in order.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// What was looked at: from then on; none if nothing is recorded.
    pub from: Option<Time>,
    /// Before then.
    pub to: Option<Time>,
    /// Contacts in it.
    pub total: i64,
    /// Length of the spans whose means these are; none if they are the contacts themselves.
    pub bucket_us: Option<i64>,
    /// Contacts or means. The time of a mean is the begin of its span; empty spans are left out.
    pub items: Vec<ContactMean>,
}

const DAY_US: i64 = 86_400_000_000;
/// Time that is looked at unless `from` is given.
pub const SPAN_US: i64 = DAY_US;
/// Time that is looked at at the most: the newest of a longer one.
pub const SPAN_MAX_US: i64 = 31 * DAY_US;
/// Time before a whisker was heard of last that is looked at first for its newest contacts.
const FIRST_REACH_US: i64 = 10_000_000;
/// How much more of it is looked at each time.
const REACH_FACTOR: i64 = 8;

impl Store {
    /// The number of a whisker, on a robot now or once; none if it was never heard of.
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
        .map_err(failed("find a whisker"))
    }

    /// Contacts of a whisker: the newest if no time is given, else those of that time, as means if they are more than
    /// the points.
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

    /// The newest ones. What is of today has no index by whisker in PostgreSQL: so the time before the whisker was heard of
    /// last is looked at first, and then ever more of it.
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
        const SQL: &str = "SELECT t_us AS at_us, CAST(1 AS BIGINT) AS contacts, ratio, deflection_mm, strain, pressure_mpa, \
             strain / NULLIF(deflection_mm, 0) AS sensitivity_per_mm, residual, length_mm, length_sd_mm FROM contacts \
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
        const EACH: &str = "SELECT t_us AS at_us, CAST(1 AS BIGINT) AS contacts, ratio, deflection_mm, strain, \
             pressure_mpa, strain / NULLIF(deflection_mm, 0) AS sensitivity_per_mm, residual, length_mm, length_sd_mm \
             FROM contacts WHERE whisker_id = $1 AND t_us >= $2 AND t_us < $3 ORDER BY t_us, boot, seq, position LIMIT $4";
        const MEANS: &str = "SELECT bucket AS at_us, count(*) AS contacts, avg(ratio) AS ratio, \
             avg(deflection_mm) AS deflection_mm, avg(strain) AS strain, avg(pressure_mpa) AS pressure_mpa, \
             avg(strain / NULLIF(deflection_mm, 0)) AS sensitivity_per_mm, avg(residual) AS residual, \
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
        // Equal spans from the first contact to the last: at most as many as points.
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
