//! The history of a fleet in the database, for a supervisor that is about to take it up.

use vibrissa_protocol::Name;

use super::database::on;
use super::{Store, StoreError, failed};

impl Store {
    /// Whether the database has a robot of the fleet, also a decommissioned one.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn has_robots(&self, fleet: &Name) -> Result<bool, StoreError> {
        if let Some(model) = &self.model {
            return model.query("look for robots of a fleet", |model| Ok(model.has_robots(fleet))).await;
        }
        const SQL: &str = "SELECT count(*) FROM (SELECT 1 FROM robots WHERE fleet = $1 LIMIT 1) AS one";
        let count: i64 = on!(&self.pool, |pool| sqlx::query_scalar(SQL).bind(fleet.as_str()).fetch_one(pool).await)
            .map_err(failed("look for robots of a fleet"))?;
        Ok(count > 0)
    }

    /// Whether the fleet had an owner at this epoch or earlier. Epochs are times: a database that has only later ones was
    /// begun later.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn has_epoch_until(&self, fleet: &Name, epoch: u64) -> Result<bool, StoreError> {
        if let Some(model) = &self.model {
            return model.query("look for an epoch of a fleet", |model| Ok(model.has_epoch_until(fleet, epoch))).await;
        }
        const SQL: &str = "SELECT count(*) FROM (SELECT 1 FROM epochs WHERE fleet = $1 AND epoch <= $2 LIMIT 1) AS one";
        let epoch = i64::try_from(epoch).unwrap_or(i64::MAX);
        let count: i64 =
            on!(&self.pool, |pool| sqlx::query_scalar(SQL).bind(fleet.as_str()).bind(epoch).fetch_one(pool).await)
                .map_err(failed("look for an epoch of a fleet"))?;
        Ok(count > 0)
    }
}
