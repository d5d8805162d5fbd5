//! The `policies` table: what operators have set in place of the configuration's policy, in all versions.
//!
//! Its columns for the policy's numbers have the names of [`policy_numbers!`](vibrissa_core::policy_numbers).

use serde::Serialize;
use tokio::time::Duration;
use vibrissa_core::policy::PolicyParams;
use vibrissa_core::policy_numbers;
use vibrissa_edge::words::named;

use super::batch::PolicyRow;
use super::database::on;
use super::from_row::from_row;
use super::set_aside::Tried;
use super::{Lease, Model, Store, StoreError, Writer, failed};

/// Time limit for reading the policy.
const PATIENCE: Duration = Duration::from_secs(5);

macro_rules! policy {
    ([$($name:ident {
        key: $key:tt, default: $default:tt, min: $min:tt, max: $max:tt, unit: $unit:tt, title: $title:tt, doc: $doc:tt,
    })+]) => {
        from_row! {
            /// The newest policy that an operator has set for a fleet.
            #[derive(Debug, Clone, PartialEq, Serialize)]
            pub struct PolicyReading {
                /// Name of the fleet.
                pub fleet: String,
                /// Version of the fleet's policy, from 1.
                pub version: i64,
                /// `AUTOMATIC`: compensations start without approval; `ADVISE`: each waits for approval.
                pub mode: String,
                /// Quantity that a setpoint is solved for: `TIP` or `MEAN`.
                pub objective: String,
                /// Whether a longer whisker may compensate for a shorter one: `NEVER`, `LAST_RESORT` or `ALLOWED`.
                pub longer_for_shorter: String,
                $(#[doc = $doc] pub $name: f64,)+
                /// Time at which this version was set, µs since 1970 UTC.
                pub changed_us: i64,
                /// Person or token that set this version.
                pub changed_by: String,
                /// Reason that the person gave.
                pub reason: Option<String>,
                /// Number of the action that set this version.
                pub action_id: i64,
            }
        }

        impl PolicyReading {
            /// The policy as parameters of the core; `None` if a word in it is unknown.
            #[must_use]
            pub fn params(&self) -> Option<PolicyParams> {
                Some(PolicyParams {
                    mode: named(&self.mode)?,
                    objective: named(&self.objective)?,
                    longer_for_shorter: named(&self.longer_for_shorter)?,
                    $($name: self.$name,)+
                })
            }
        }

        impl From<&PolicyRow> for PolicyReading {
            fn from(row: &PolicyRow) -> Self {
                let PolicyRow { fleet, version, changed_us, changed_by, reason, action_id, .. } = row.clone();
                let [mode, objective, longer_for_shorter] =
                    [row.mode, row.objective, row.longer_for_shorter].map(str::to_owned);
                Self {
                    fleet, version, mode, objective, longer_for_shorter,
                    $($name: row.$name,)+
                    changed_us, changed_by, reason, action_id,
                }
            }
        }

        /// The columns; the numbers of the policy are the last ones.
        const COLUMNS: &str = concat!(
            "version, fleet, mode, objective, longer_for_shorter, changed_us, changed_by, reason, action_id",
            $(", ", stringify!($name),)+
        );
    };
}
policy_numbers!(policy);

const TABLE: &str = "policies";
const VERSION: &str = "SELECT coalesce(max(version), 0) FROM policies WHERE fleet = $1";

fn newest() -> String {
    format!("SELECT {COLUMNS} FROM policies WHERE fleet = $1 ORDER BY version DESC LIMIT 1")
}

impl Store {
    /// The newest policy that an operator has set for a fleet; `None` if the policy of the configuration is in force, because
    /// none was set, or because it cannot be read.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn policy(&self, fleet: &str) -> Result<Option<PolicyReading>, StoreError> {
        let sql = newest();
        let read: Option<Tried<PolicyReading>> =
            on!(&self.pool, |pool| sqlx::query_as(sqlx::AssertSqlSafe(sql)).bind(fleet).fetch_optional(pool).await)
                .map_err(failed("read the policy"))?;
        Ok(read.and_then(|row| self.set_aside.read(TABLE, row)))
    }

    /// Version of the newest policy that an operator has set for a fleet, also if it cannot be read; 0 without one.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn policy_version(&self, fleet: &str) -> Result<i64, StoreError> {
        on!(&self.pool, |pool| sqlx::query_scalar(VERSION).bind(fleet).fetch_one(pool).await)
            .map_err(failed("read the policy"))
    }
}

impl Writer {
    /// The newest policy that an operator has set for the lease's fleet; `None` if the policy of the configuration is
    /// in force, because none was set, or because it cannot be read.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn policy(&mut self, lease: &Lease) -> Result<Option<PolicyReading>, StoreError> {
        const WHAT: &str = "read the policy";
        let (sql, fleet) = (newest(), lease.fleet().as_str());
        let model = |model: &mut dyn Model| Ok(model.policy(lease).map(Tried::Read));
        let read: Option<Tried<PolicyReading>> = self
            .attempt(WHAT, PATIENCE, model, async |link| {
                on!(link, |link| sqlx::query_as(sqlx::AssertSqlSafe(sql)).bind(fleet).fetch_optional(link).await)
                    .map_err(failed(WHAT))
            })
            .await?;
        Ok(read.and_then(|row| self.set_aside.read(TABLE, row)))
    }

    /// Version of the newest policy that an operator has set for the lease's fleet, also if it cannot be read; 0 without one.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn policy_version(&mut self, lease: &Lease) -> Result<i64, StoreError> {
        const WHAT: &str = "read the policy";
        self.attempt(
            WHAT,
            PATIENCE,
            |model| Ok(model.policy(lease).map_or(0, |policy| policy.version)),
            async |link| {
                on!(link, |link| sqlx::query_scalar(VERSION).bind(lease.fleet().as_str()).fetch_one(link).await)
                    .map_err(failed(WHAT))
            },
        )
        .await
    }
}
