//! The use of a whisker's newest contacts: why it learns, or does not.

use super::database::on;
use super::from_row::from_row;
use super::series::Span;
use super::{Store, StoreError, failed};
use crate::time::Time;

from_row! {
    /// Contacts of one use.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct ContactsOfUse {
        /// Use of the contacts: a word of `contacts.used`.
        pub used: String,
        /// Number of contacts.
        pub contacts: i64,
        /// Time of the newest one, by the robot's clock.
        pub newest_at: Time,
    }
}

impl Store {
    /// Uses of a whisker's newest contacts, the most frequent use first. `most` is the number of contacts that are counted;
    /// contacts of the same time as the oldest of them count, too.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn contact_uses(&self, whisker_id: i64, most: u32) -> Result<Vec<ContactsOfUse>, StoreError> {
        const SQL: &str = "SELECT used, count(*) AS contacts, max(t_us) AS newest_at FROM contacts \
             WHERE whisker_id = $1 AND t_us >= $2 GROUP BY used ORDER BY contacts DESC, used";
        let newest = self.contacts(whisker_id, Span { from: None, to: None, points: most }).await?;
        let Some(from) = newest.from else { return Ok(Vec::new()) };
        on!(&self.pool, |pool| sqlx::query_as(SQL).bind(whisker_id).bind(from.0).fetch_all(pool).await)
            .map_err(failed("count a whisker's contacts by use"))
    }

    /// State of a whisker's segmenter by its newest status; `None` if its robot states none.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn segmenter(&self, whisker_id: i64) -> Result<Option<String>, StoreError> {
        const SQL: &str = "SELECT segmenter FROM whiskers WHERE whisker_id = $1";
        let found: Option<Option<String>> =
            on!(&self.pool, |pool| sqlx::query_scalar(SQL).bind(whisker_id).fetch_optional(pool).await)
                .map_err(failed("read the state of a segmenter"))?;
        Ok(found.flatten())
    }
}
