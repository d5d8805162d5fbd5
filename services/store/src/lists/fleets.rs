//! Fleets: the supervisor of each, and counts of its robots, whiskers, alarms and proposals.

use serde::Serialize;
use utoipa::ToSchema;

use super::counts::{alarm_counts, need_counts, presence, proposal_counts};
use super::sorts;
use crate::Store;
use crate::from_row::from_row;
use crate::list::List;

from_row! {
    /// A fleet with counts of its robots, whiskers, alarms and proposals.
    #[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
    pub struct FleetSummary {
        /// Name of the fleet.
        pub fleet: String,
        /// Name of the supervisor that holds the fleet's lease now; null if none does.
        pub holder: Option<String>,
        /// Epoch of the fleet, which rises at each change of supervisor; 0 before the first.
        #[schema(minimum = 0)]
        pub epoch: i64,
        /// Whether a supervisor holds the fleet's lease now.
        pub supervised: bool,
        /// Number of robots of the fleet, without decommissioned ones.
        #[schema(minimum = 0)]
        pub robots: i64,
        /// Number of robots that are connected and heard (`ONLINE`).
        #[schema(minimum = 0)]
        pub robots_online: i64,
        /// Number of robots that are connected, but not heard (`SILENT`).
        #[schema(minimum = 0)]
        pub robots_silent: i64,
        /// Number of whiskers on the fleet's robots now.
        #[schema(minimum = 0)]
        pub whiskers: i64,
        /// Number of whiskers in condition `HEALTHY` and without a fault.
        #[schema(minimum = 0)]
        pub whiskers_healthy: i64,
        /// Number of whiskers in condition `LEARNING` and without a fault.
        #[schema(minimum = 0)]
        pub whiskers_learning: i64,
        /// Number of whiskers in condition `SUSPECTED`, `ERODING` or `SENSITIVITY_LOSS` and without a fault.
        #[schema(minimum = 0)]
        pub whiskers_worn: i64,
        /// Number of trimmed whiskers with a compensation in force and without a fault.
        #[schema(minimum = 0)]
        pub whiskers_compensated: i64,
        /// Number of whiskers in condition `TRIMMED`, which the other counts contain, too.
        #[schema(minimum = 0)]
        pub whiskers_trimmed: i64,
        /// Number of trimmed whiskers without a compensation in force, with or without a fault.
        #[schema(minimum = 0)]
        pub whiskers_uncompensated: i64,
        /// Number of whiskers with a fault, except uncompensated ones.
        #[schema(minimum = 0)]
        pub whiskers_faulty: i64,
        /// Number of compensations that wait for an operator's approval.
        #[schema(minimum = 0)]
        pub proposals: i64,
        /// Number of standing alarms that are not shelved.
        #[schema(minimum = 0)]
        pub alarms: i64,
        /// Number of standing alarms that are shelved.
        #[schema(minimum = 0)]
        pub alarms_shelved: i64,
        /// Number of things that need attention: `alarms`, plus one if no supervisor holds the fleet. Each thing has one
        /// alarm, such as a silent robot or a proposal.
        #[schema(minimum = 0)]
        pub attention: i64,
    }
}

sorts! {
    /// Sort keys of the list of fleets.
    pub enum FleetSort {
        /// By number of things that need attention.
        Attention = "attention" Whole Down,
        /// By name of the fleet.
        Fleet = "fleet" Text Up,
    }
}

/// The list of fleets, given the condition that a lease is in force.
macro_rules! fleets {
    ($holds:literal) => {
        List {
            what: "list the fleets",
            select: concat!(
                "SELECT q.*, alarms + CASE WHEN supervised THEN 0 ELSE 1 END AS attention FROM \
                 (SELECT row_number() OVER (ORDER BY fleet) AS fleet_id, fleet, \
                 holder, coalesce(epoch, 0) AS epoch, coalesce(held, false) AS supervised, coalesce(robots, 0) AS robots, \
                 coalesce(robots_online, 0) AS robots_online, coalesce(robots_silent, 0) AS robots_silent, \
                 coalesce(whiskers, 0) AS whiskers, \
                 coalesce(whiskers, 0) - coalesce(whiskers_unsound, 0) AS whiskers_healthy, \
                 coalesce(whiskers_learning, 0) AS whiskers_learning, coalesce(whiskers_worn, 0) AS whiskers_worn, \
                 coalesce(whiskers_compensated, 0) AS whiskers_compensated, \
                 coalesce(whiskers_trimmed, 0) AS whiskers_trimmed, \
                 coalesce(whiskers_uncompensated, 0) AS whiskers_uncompensated, \
                 coalesce(whiskers_faulty, 0) AS whiskers_faulty, coalesce(proposals, 0) AS proposals, \
                 coalesce(alarms, 0) AS alarms, coalesce(alarms_shelved, 0) AS alarms_shelved \
                 FROM (SELECT fleet FROM leases UNION SELECT fleet FROM robots) f LEFT JOIN (SELECT fleet, epoch, (",
                $holds,
                ") AS held, CASE WHEN ",
                $holds,
                " THEN holder END AS holder FROM leases l) l USING (fleet) \
                 LEFT JOIN (SELECT fleet, count(*) AS robots, \
                  count(*) FILTER (WHERE connection = 'ONLINE') AS robots_online, \
                  count(*) FILTER (WHERE connection = 'SILENT') AS robots_silent FROM (SELECT fleet, ",
                presence!("b"),
                " AS connection FROM robots b WHERE decommissioned_us IS NULL) b GROUP BY fleet) r \
                  USING (fleet) \
                 LEFT JOIN (SELECT fleet, CAST(sum(whiskers) AS BIGINT) AS whiskers FROM robots JOIN arrays USING (robot_id) \
                  GROUP BY fleet) n USING (fleet) \
                 LEFT JOIN (SELECT fleet, CAST(sum(whiskers_unsound) AS BIGINT) AS whiskers_unsound, \
                  CAST(sum(whiskers_learning) AS BIGINT) AS whiskers_learning, \
                  CAST(sum(whiskers_worn) AS BIGINT) AS whiskers_worn, \
                  CAST(sum(whiskers_compensated) AS BIGINT) AS whiskers_compensated, \
                  CAST(sum(whiskers_trimmed) AS BIGINT) AS whiskers_trimmed, \
                  CAST(sum(whiskers_uncompensated) AS BIGINT) AS whiskers_uncompensated, \
                  CAST(sum(whiskers_faulty) AS BIGINT) AS whiskers_faulty FROM robots JOIN ",
                need_counts!("w.robot_id"),
                " n USING (robot_id) GROUP BY fleet) w USING (fleet) \
                 LEFT JOIN ",
                alarm_counts!("fleet"),
                " a USING (fleet) LEFT JOIN ",
                proposal_counts!("fleet"),
                " o USING (fleet)) q"
            ),
            details: "",
            keys: &[],
            sorts: FleetSort::SORTS,
            id: "fleet_id",
        }
    };
}

/// Fleets in SQLite: the owner holds each lease until it releases it.
static OF_FILE: List = fleets!("l.owner IS NOT NULL");
/// Fleets in PostgreSQL: leases expire by the server's clock.
static OF_SERVER: List = fleets!("l.owner IS NOT NULL AND l.expires_us > clock_us()");

/// All fleets that the database knows.
#[must_use]
pub fn fleets(store: &Store) -> &'static List {
    if store.is_shared() { &OF_SERVER } else { &OF_FILE }
}
