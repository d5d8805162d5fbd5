//! Tests on SQLite and PostgreSQL: the same behaviour of both, and leases between supervisors.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod actions;
mod backup;
mod black_boxes;
mod contract;
mod formats;
mod history;
mod leases;
mod log_positions;
mod one_log;
mod one_owner;
mod opened;
mod plans;
mod reference;
mod refused;
mod restore;
mod retention;
mod role;
mod rollouts;
mod rows;
mod schema;
mod slow_disk;
mod supervisors;
mod unfit;
mod versions;

use tempfile::TempDir;
use vibrissa_protocol::Name;
use vibrissa_store::{DatabaseAddress, Store, Supervisor};
use vibrissa_tests::postgres::Postgres;

/// A private database with its schema, removed on drop.
struct Fresh {
    store: Store,
    address: DatabaseAddress,
    server: Option<Postgres>,
    _folder: Option<TempDir>,
}

impl Fresh {
    async fn sqlite() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let address = DatabaseAddress::Sqlite(folder.path().join("v.sqlite3"));
        let store = Store::open(&address, "test").await.unwrap();
        store.prepare().await.unwrap();
        Self { store, address, server: None, _folder: Some(folder) }
    }

    /// A PostgreSQL with the shipped role, which must be sufficient.
    async fn postgres() -> Self {
        Self::of(Postgres::start_with_supervisor().await).await
    }

    async fn of(server: Postgres) -> Self {
        let address: DatabaseAddress = Postgres::supervisor_url(server.port()).parse().unwrap();
        let store = Store::open(&address, "test").await.unwrap();
        store.prepare().await.unwrap();
        Self { store, address, server: Some(server), _folder: None }
    }
}

/// A supervisor of fleet `f`. Its time to live is also the time limit of its questions.
fn supervisor(id: &str) -> Supervisor {
    Supervisor {
        id: id.into(),
        name: format!("supervisor {id}"),
        fleets: vec![Name::new("f").unwrap()],
        time_to_live: std::time::Duration::from_secs(60),
    }
}

/// One whose leases lapse during the test.
fn brief(id: &str) -> Supervisor {
    Supervisor { time_to_live: std::time::Duration::from_secs(2), ..supervisor(id) }
}

fn fleet() -> Name {
    Name::new("f").unwrap()
}
