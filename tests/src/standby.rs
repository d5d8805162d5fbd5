//! A standby of a private PostgreSQL, without anything that promotes it.

use std::fs::File;
use std::os::unix::fs::chown;
use std::process::Child;

use sqlx::postgres::{PgConnectOptions, PgConnection};
use sqlx::{Connection, Executor, Row};
use tempfile::TempDir;

use crate::mosquitto::free_port;
use crate::postgres::{Postgres, USER, account, command};
use crate::wait;

/// A running standby, stopped on drop.
#[derive(Debug)]
pub struct Standby {
    port: u16,
    process: Child,
    _folder: TempDir,
}

impl Standby {
    /// Copies a server, which must be new, and replicates it through a port of 127.0.0.1: its own, or that of a proxy.
    ///
    /// # Panics
    /// The server cannot be copied, or the standby does not start.
    pub async fn of(leader: &Postgres, through: u16) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        if let Some((uid, gid)) = account() {
            chown(folder.path(), Some(uid), Some(gid)).expect("a folder of ours");
        }
        let copied = command("pg_basebackup", folder.path())
            .args(["--pgdata", "data", "--host", "127.0.0.1", "--port", &leader.port().to_string(), "--username", USER])
            .args(["--checkpoint=fast", "--no-sync", "--write-recovery-conf"])
            .output()
            .expect("PostgreSQL's programs must be installed for this test");
        assert!(copied.status.success(), "pg_basebackup: {}", String::from_utf8_lossy(&copied.stderr));
        let port = free_port();
        let log = File::create(folder.path().join("log")).expect("a log");
        let source = format!("primary_conninfo=host=127.0.0.1 port={through} user={USER}");
        let process = command("postgres", folder.path())
            .args(["-D", "data", "-p", &port.to_string(), "-c", &source])
            .args(["-c", "listen_addresses=127.0.0.1", "-c", "unix_socket_directories="])
            .stderr(log)
            .spawn()
            .expect("PostgreSQL's server must be installed for this test");
        let standby = Self { port, process, _folder: folder };
        wait::until("a standby that receives", async || {
            let mut connection = PgConnection::connect_with(&standby.connect()).await.ok()?;
            let receives: bool = connection
                .fetch_one("SELECT EXISTS (SELECT FROM pg_stat_wal_receiver WHERE status = 'streaming')")
                .await
                .ok()?
                .get(0);
            receives.then_some(())
        })
        .await;
        standby
    }

    /// Port of the server on 127.0.0.1.
    #[must_use]
    pub fn port(&self) -> u16 {
        self.port
    }

    /// Options for a connection to the database.
    #[must_use]
    pub fn connect(&self) -> PgConnectOptions {
        Postgres::options_of(self.port)
    }
}

impl Drop for Standby {
    fn drop(&mut self) {
        crate::postgres::stop(&mut self.process);
    }
}
