//! Fleets: who supervises them, and how many of what they have.

use serde::Serialize;
use utoipa::ToSchema;

use super::counts::{alarm_counts, proposal_counts, whisker_counts};
use super::sorts;
use crate::Store;
use crate::list::List;
use crate::readings::readings;

readings! {
    /// A fleet with its counts.
    #[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
    pub struct FleetSummary {
        /// Fleet.
        pub fleet: String,
        /// The supervisor that has it now; null if none has.
        pub holder: Option<String>,
        /// Rises at each change of supervisor; 0 before the first.
        #[schema(minimum = 0)]
        pub epoch: i64,
        /// Whether a supervisor has it now.
        pub supervised: bool,
        /// Robots that were ever heard of.
        #[schema(minimum = 0)]
        pub robots: i64,
        /// Robots that are connected.
        #[schema(minimum = 0)]
        pub robots_online: i64,
        /// Whiskers that are on its robots.
        #[schema(minimum = 0)]
        pub whiskers: i64,
        /// Those in condition `HEALTHY` and without a fault.
        #[schema(minimum = 0)]
        pub whiskers_healthy: i64,
        /// Those in condition `TRIMMED`.
        #[schema(minimum = 0)]
        pub whiskers_trimmed: i64,
        /// Trimmed ones that no compensation in force serves.
        #[schema(minimum = 0)]
        pub whiskers_uncompensated: i64,
        /// Those with a fault.
        #[schema(minimum = 0)]
        pub whiskers_faulty: i64,
        /// Decisions that wait for somebody's word.
        #[schema(minimum = 0)]
        pub proposals: i64,
        /// Alarms that stand.
        #[schema(minimum = 0)]
        pub alarms: i64,
        /// How much there is to look at: alarms, faulty and uncompensated whiskers, proposals, and robots that are not
        /// connected, added up; one more if nobody supervises the fleet.
        #[schema(minimum = 0)]
        pub attention: i64,
    }
}

sorts! {
    /// What a list of fleets may be sorted by.
    pub enum FleetSort {
        /// How much there is to look at.
        Attention = "attention" Whole Down,
        /// Name.
        Fleet = "fleet" Text Up,
    }
}

/// The query, with what tells a lease that holds from one that is over.
macro_rules! fleets {
    ($holds:literal) => {
        List {
            what: "list the fleets",
            select: concat!(
                "SELECT q.*, alarms + whiskers_faulty + whiskers_uncompensated + proposals + robots - robots_online \
                 + CASE WHEN supervised THEN 0 ELSE 1 END AS attention FROM \
                 (SELECT row_number() OVER (ORDER BY fleet) AS fleet_id, fleet, \
                 CASE WHEN ",
                $holds,
                " THEN holder END AS holder, coalesce(epoch, 0) AS epoch, \
                 CASE WHEN ",
                $holds,
                " THEN true ELSE false END AS supervised, coalesce(robots, 0) AS robots, \
                 coalesce(robots_online, 0) AS robots_online, coalesce(whiskers, 0) AS whiskers, \
                 coalesce(whiskers_healthy, 0) AS whiskers_healthy, \
                 coalesce(whiskers_trimmed, 0) AS whiskers_trimmed, \
                 coalesce(whiskers_uncompensated, 0) AS whiskers_uncompensated, \
                 coalesce(whiskers_faulty, 0) AS whiskers_faulty, coalesce(proposals, 0) AS proposals, \
                 coalesce(alarms, 0) AS alarms \
                 FROM (SELECT fleet FROM leases UNION SELECT fleet FROM robots) f LEFT JOIN leases l USING (fleet) \
                 LEFT JOIN (SELECT fleet, count(*) AS robots, \
                  count(*) FILTER (WHERE connection = 'ONLINE') AS robots_online FROM robots GROUP BY fleet) r \
                  USING (fleet) \
                 LEFT JOIN ",
                whisker_counts!("fleet"),
                " w USING (fleet) \
                 LEFT JOIN ",
                alarm_counts!("fleet"),
                " a USING (fleet) LEFT JOIN ",
                proposal_counts!("fleet"),
                " o USING (fleet)) q"
            ),
            sorts: FleetSort::SORTS,
            id: "fleet_id",
        }
    };
}

/// Fleets of a file: its owner has every lease until it gives it back.
static OF_FILE: List = fleets!("l.owner IS NOT NULL");
/// Fleets of a server: leases run by its clock.
static OF_SERVER: List = fleets!("l.owner IS NOT NULL AND l.expires_us > clock_us()");

/// Fleets that were ever heard of.
#[must_use]
pub fn fleets(store: &Store) -> &'static List {
    if store.is_shared() { &OF_SERVER } else { &OF_FILE }
}
