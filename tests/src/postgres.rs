//! Runs a private PostgreSQL on a free port with its data in a temporary folder. `fsync` is off: programs are killed, machines are
//! not.

use std::fs::File;
use std::io::Write;
use std::os::unix::fs::chown;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command};
use std::time::Duration;

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use sqlx::postgres::{PgConnectOptions, PgConnection};
use sqlx::{ConnectOptions, Connection, Executor};
use tempfile::TempDir;

use crate::certificates::write;
use crate::mosquitto::free_port;
use crate::wait;

/// Name of the superuser, who needs no password on this machine.
pub(crate) const USER: &str = "vibrissa";
/// Environment variable with the folder of the server's programs, instead of the system's.
const PROGRAMS: &str = "VIBRISSA_TEST_POSTGRES";
/// Database role of supervisors in a deployment.
const SUPERVISOR: &str = "supervisor";
/// The shipped file that creates this role.
const SUPERVISOR_SQL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../deploy/postgres/supervisor.sql");
/// Name of the database that exists, empty, after the start.
pub const DATABASE: &str = "vibrissa";
/// Time limit of an orderly shutdown; afterwards the server is killed.
const END_PATIENCE: Duration = Duration::from_secs(5);

/// A running server, stopped on drop.
#[derive(Debug)]
pub struct Postgres {
    /// Folder of the server's programs, if it is not the system's.
    programs: Option<PathBuf>,
    folder: TempDir,
    port: u16,
    process: Option<Child>,
}

impl Postgres {
    /// Starts a new, empty server and waits until it answers.
    ///
    /// # Panics
    /// PostgreSQL is not installed, or does not start.
    pub async fn start() -> Self {
        Self::start_programs(std::env::var_os(PROGRAMS).map(PathBuf::from)).await
    }

    /// As [`Self::start`], with the server's programs in a folder.
    ///
    /// # Panics
    /// As [`Self::start`].
    pub async fn start_of(programs: &Path) -> Self {
        Self::start_programs(Some(programs.to_owned())).await
    }

    async fn start_programs(programs: Option<PathBuf>) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        if let Some((uid, gid)) = account() {
            chown(folder.path(), Some(uid), Some(gid)).expect("a folder of ours");
        }
        let initdb = server_command(programs.as_deref(), "initdb", folder.path())
            .args(["--pgdata", "data", "--username", USER, "--auth", "trust", "--encoding", "UTF8"])
            .args(["--locale", "C", "--no-sync", "--no-instructions"])
            .output()
            .expect("PostgreSQL's server must be installed for this test");
        assert!(initdb.status.success(), "initdb: {}", String::from_utf8_lossy(&initdb.stderr));
        let settings = File::options().append(true).open(folder.path().join("data/postgresql.conf"));
        settings.and_then(|mut file| file.write_all(b"fsync = off\n")).expect("a file that initdb made just now");
        let mut server = Self { programs, folder, port: free_port(), process: None };
        server.restart().await;
        let mut connection = server.options("postgres").connect().await.expect("a server that answered just now");
        connection.execute("CREATE DATABASE vibrissa").await.expect("a new server");
        connection.close().await.expect("a connection of ours");
        server
    }

    /// Starts a server with the shipped role for supervisors; see [`Self::supervisor_url`].
    ///
    /// # Panics
    /// As [`Self::start`].
    pub async fn start_with_supervisor() -> Self {
        let server = Self::start().await;
        server.make_supervisor();
        server
    }

    /// Turns `fsync` on, for measurements.
    ///
    /// # Panics
    /// The server does not answer.
    pub async fn synchronise(&self) {
        let mut connection = self.connect().connect().await.expect("a server that runs");
        connection.execute("ALTER SYSTEM SET fsync = on").await.expect("a setting");
        connection.execute("SELECT pg_reload_conf()").await.expect("a server that runs");
        connection.close().await.expect("a connection of ours");
    }

    /// Runs the shipped `deploy/postgres/supervisor.sql` in the database.
    ///
    /// # Panics
    /// The script fails.
    pub fn make_supervisor(&self) {
        let password = write(self.folder.path(), "supervisor.password", "none\n");
        let mut psql = self.client("psql");
        psql.args(["-X", "-q", "-d", DATABASE, "-f", SUPERVISOR_SQL]).env("SUPERVISOR_PASSWORD_FILE", password);
        let ended = psql.output().expect("psql must be installed for this test");
        assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
    }

    /// URL of the database for the role of [`Self::make_supervisor`], through this port of 127.0.0.1.
    #[must_use]
    pub fn supervisor_url(port: u16) -> String {
        format!("postgres://{SUPERVISOR}@127.0.0.1:{port}/{DATABASE}")
    }

    /// Port of the server on 127.0.0.1.
    #[must_use]
    pub fn port(&self) -> u16 {
        self.port
    }

    /// Process id of the server, whose child processes serve the connections. None while it is down.
    #[must_use]
    pub fn pid(&self) -> Option<u32> {
        self.process.as_ref().map(Child::id)
    }

    /// URL of the database through this port of 127.0.0.1: the server's own, or that of a proxy in front of it.
    #[must_use]
    pub fn url(port: u16) -> String {
        format!("postgres://{USER}@127.0.0.1:{port}/{DATABASE}")
    }

    /// Options for a connection to the database.
    #[must_use]
    pub fn connect(&self) -> PgConnectOptions {
        Self::options_of(self.port)
    }

    /// Options for a connection to the database through a port of 127.0.0.1.
    pub(crate) fn options_of(port: u16) -> PgConnectOptions {
        PgConnectOptions::new().host("127.0.0.1").port(port).username(USER).database(DATABASE)
    }

    fn options(&self, database: &str) -> PgConnectOptions {
        PgConnectOptions::new().host("127.0.0.1").port(self.port).username(USER).database(database)
    }

    /// One of PostgreSQL's client programs with the server's address and user set.
    #[must_use]
    pub fn client(&self, program: &str) -> Command {
        let mut client = Command::new(path_of(program));
        client.env("PGHOST", "127.0.0.1").env("PGPORT", self.port.to_string()).env("PGUSER", USER);
        client
    }

    /// Kills the server with all its processes, without cleanup, as after a power failure.
    ///
    /// # Panics
    /// The server's processes have ended.
    pub fn kill(&mut self) {
        let Some(mut process) = self.process.take() else { return };
        let server = pid_of(&process);
        // A stopped server creates no new process while its processes are listed.
        kill(server, Signal::SIGSTOP).expect("our process");
        for child in children(server) {
            // It may have just ended on its own.
            let _ = kill(child, Signal::SIGKILL);
        }
        process.kill().expect("our process");
        process.wait().expect("our process");
    }

    /// Starts the server again on the same port; returns when it has recovered and accepts connections.
    ///
    /// # Panics
    /// The server does not start.
    pub async fn restart(&mut self) {
        let log = File::options().create(true).append(true).open(self.folder.path().join("log")).expect("a log");
        let process = server_command(self.programs.as_deref(), "postgres", self.folder.path())
            .args(["-D", "data", "-p", &self.port.to_string()])
            .args(["-c", "listen_addresses=127.0.0.1", "-c", "unix_socket_directories="])
            .args(["-c", "max_connections=100", "-c", "max_wal_size=4GB"])
            .stderr(log)
            .spawn()
            .expect("PostgreSQL's server must be installed for this test");
        self.process = Some(process);
        wait::until("PostgreSQL's first answer", async || {
            let ended = self.process.as_mut().and_then(|process| process.try_wait().expect("our process"));
            assert!(ended.is_none(), "PostgreSQL ended: {}", self.log());
            let connection = PgConnection::connect_with(&self.options("postgres")).await.ok()?;
            connection.close().await.ok()
        })
        .await;
    }

    /// The server's log.
    fn log(&self) -> String {
        std::fs::read_to_string(self.folder.path().join("log")).unwrap_or_default()
    }
}

impl Drop for Postgres {
    fn drop(&mut self) {
        if let Some(process) = &mut self.process {
            stop(process);
        }
    }
}

/// Stops a server.
pub(crate) fn stop(process: &mut Child) {
    // SIGQUIT is PostgreSQL's immediate shutdown: it writes no checkpoint but frees the shared memory.
    let _ = kill(pid_of(process), Signal::SIGQUIT);
    let deadline = std::time::Instant::now() + END_PATIENCE;
    while std::time::Instant::now() < deadline {
        if !matches!(process.try_wait(), Ok(None)) {
            return;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let _ = process.kill();
    let _ = process.wait();
}

fn pid_of(process: &Child) -> Pid {
    Pid::from_raw(i32::try_from(process.id()).expect("a process id"))
}

/// Child processes of a process (Linux only).
pub(crate) fn children(parent: Pid) -> Vec<Pid> {
    let entries = std::fs::read_dir("/proc").expect("Linux");
    let of_parent = |entry: std::fs::DirEntry| {
        let pid: i32 = entry.file_name().to_str()?.parse().ok()?;
        let stat = std::fs::read_to_string(entry.path().join("stat")).ok()?;
        // The process name may contain any character; after it follow the state and the parent's id.
        let parent_of_it: i32 = stat.rsplit_once(") ")?.1.split(' ').nth(1)?.parse().ok()?;
        (parent_of_it == parent.as_raw()).then(|| Pid::from_raw(pid))
    };
    entries.filter_map(Result::ok).filter_map(of_parent).collect()
}

/// One of the server's programs, run in the folder, never as root: the server refuses to run as root.
pub(crate) fn command(program: &str, folder: &Path) -> Command {
    server_command(None, program, folder)
}

fn server_command(programs: Option<&Path>, program: &str, folder: &Path) -> Command {
    let mut command = Command::new(programs.map_or_else(|| path_of(program), |programs| programs.join(program)));
    command.current_dir(folder).env_remove("PGDATA");
    if let Some((uid, gid)) = account() {
        command.uid(uid).gid(gid);
    }
    command
}

/// Path of a server program. Debian keeps these off the search path; the newest version is used.
pub(crate) fn path_of(program: &str) -> PathBuf {
    let versions = std::fs::read_dir("/usr/lib/postgresql").into_iter().flatten().filter_map(Result::ok);
    let newest = versions
        .filter_map(|entry| Some((entry.file_name().to_str()?.parse::<u32>().ok()?, entry.path())))
        .filter(|(_, path)| path.join("bin").join(program).exists())
        .max();
    newest.map_or_else(|| PathBuf::from(program), |(_, path)| path.join("bin").join(program))
}

/// User and group to use instead of root: `postgres`, created by PostgreSQL's package.
pub(crate) fn account() -> Option<(u32, u32)> {
    let id = |arguments: &[&str]| -> Option<u32> {
        String::from_utf8(Command::new("id").args(arguments).output().ok()?.stdout).ok()?.trim().parse().ok()
    };
    (id(&["-u"]) == Some(0)).then(|| {
        let postgres = id(&["-u", "postgres"]).zip(id(&["-g", "postgres"]));
        postgres.expect("root needs the user postgres to start PostgreSQL")
    })
}

#[cfg(test)]
mod tests {
    use sqlx::Row;

    use super::*;

    #[tokio::test]
    async fn what_was_committed_outlives_a_kill() {
        let mut server = Postgres::start().await;
        let mut connection = server.connect().connect().await.unwrap();
        connection.execute("CREATE TABLE t (n BIGINT)").await.unwrap();
        connection.execute("INSERT INTO t VALUES (1)").await.unwrap();
        let server_pid = pid_of(server.process.as_ref().unwrap());
        let pids = children(server_pid);
        assert!(pids.len() > 2, "expected the background writers and one connection: {pids:?}");
        server.kill();
        assert!(connection.execute("SELECT 1").await.is_err());
        for pid in pids {
            wait::until_true("the end of a process of the server", async || kill(pid, None).is_err()).await;
        }
        server.restart().await;
        let mut connection = server.connect().connect().await.unwrap();
        let count: i64 = connection.fetch_one("SELECT count(*) FROM t").await.unwrap().get(0);
        assert_eq!(count, 1);
    }
}
