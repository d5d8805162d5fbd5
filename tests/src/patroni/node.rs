//! A server of the cluster: Patroni, and the PostgreSQL that it runs.

use std::os::unix::fs::chown;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;

use super::TTL_S;
use crate::mosquitto::free_port;
use crate::network::ServerAddress;
use crate::postgres::{USER, account, children, path_of};
use crate::process::{Launch, Process};

/// Time limit of an orderly shutdown; afterwards the server is killed.
const END_PATIENCE: Duration = Duration::from_secs(5);

#[derive(Debug)]
pub(super) struct Node {
    pub(super) host: String,
    pub(super) port: u16,
    pub(super) rest_port: u16,
    folder: PathBuf,
    launch: Launch,
    patroni: Option<Process>,
}

impl Node {
    /// A node that does not run yet.
    pub(super) fn new(name: &str, folder: &Path, place: &ServerAddress, etcd: &str, is_synchronous: bool) -> Self {
        let folder = folder.join(name);
        std::fs::create_dir(&folder).expect("a folder of ours");
        let (port, rest_port) = (free_port(), free_port());
        let configuration = folder.join("patroni.yml");
        std::fs::write(&configuration, configured(name, &folder, &place.host, (port, rest_port), etcd, is_synchronous))
            .expect("a folder of ours");
        let mut command: Vec<String> = Vec::new();
        // Neither Patroni nor PostgreSQL runs as root.
        if let Some((uid, gid)) = account() {
            chown(&folder, Some(uid), Some(gid)).expect("a folder of ours");
            let user = [format!("--reuid={uid}"), format!("--regid={gid}"), "--clear-groups".to_owned()];
            command.push("setpriv".to_owned());
            command.extend(user);
        }
        command.extend(["patroni".to_owned(), configuration.display().to_string()]);
        let launch = place.launch(Launch {
            program: command.remove(0).into(),
            arguments: command,
            environment: vec![("HOME".to_owned(), folder.display().to_string())],
            log: folder.join("log"),
        });
        Self { host: place.host.clone(), port, rest_port, folder, launch, patroni: None }
    }

    pub(super) fn start(name: &str, folder: &Path, place: &ServerAddress, etcd: &str, is_synchronous: bool) -> Self {
        let mut node = Self::new(name, folder, place, etcd, is_synchronous);
        node.restart();
        node
    }

    pub(super) fn restart(&mut self) {
        self.patroni = Some(Process::start(self.launch.clone()));
    }

    /// Removes the data of the server, which has ended. Patroni may have removed them before.
    pub(super) fn remove_data(&self) {
        let removed = std::fs::remove_dir_all(self.folder.join("data"));
        assert!(removed.is_ok() || !self.folder.join("data").exists(), "a folder of ours: {removed:?}");
    }

    pub(super) fn address(&self) -> String {
        format!("{}:{}", self.host, self.port)
    }

    pub(super) fn log(&self) -> String {
        std::fs::read_to_string(self.folder.join("log")).unwrap_or_default()
    }

    /// PostgreSQL's first process, if it runs.
    fn postmaster(&self) -> Option<Pid> {
        let text = std::fs::read_to_string(self.folder.join("data/postmaster.pid")).ok()?;
        let pid = Pid::from_raw(text.lines().next()?.trim().parse().ok()?);
        is_running(pid).then_some(pid)
    }

    pub(super) fn kill(&mut self) {
        // A stopped Patroni does not restart PostgreSQL, and a stopped PostgreSQL makes no new process.
        self.freeze(true);
        if let Some(postmaster) = self.postmaster() {
            for process in children(postmaster).into_iter().chain([postmaster]) {
                // It may have just ended on its own.
                let _ = kill(process, Signal::SIGKILL);
            }
        }
        if let Some(mut patroni) = self.patroni.take() {
            patroni.kill();
        }
    }

    /// Kills Patroni alone, and continues PostgreSQL if it is stopped.
    pub(super) fn kill_patroni(&mut self) {
        if let Some(mut patroni) = self.patroni.take() {
            patroni.kill();
        }
        self.freeze(false);
    }

    pub(super) fn freeze(&self, is_frozen: bool) {
        let signal = if is_frozen { Signal::SIGSTOP } else { Signal::SIGCONT };
        if let Some(patroni) = &self.patroni {
            patroni.signal(signal);
        }
        let postmaster = self.postmaster();
        if let Some(postmaster) = postmaster {
            let _ = kill(postmaster, signal);
        }
        for process in postmaster.into_iter().flat_map(children) {
            let _ = kill(process, signal);
        }
    }
}

impl Drop for Node {
    fn drop(&mut self) {
        if let Some(mut patroni) = self.patroni.take()
            && patroni.ended_already().is_none()
        {
            patroni.kill();
        }
        let Some(postmaster) = self.postmaster() else { return };
        // SIGQUIT is PostgreSQL's immediate shutdown: it frees the shared memory.
        let _ = kill(postmaster, Signal::SIGQUIT);
        for process in children(postmaster).into_iter().chain([postmaster]) {
            let _ = kill(process, Signal::SIGCONT);
        }
        let deadline = Instant::now() + END_PATIENCE;
        while is_running(postmaster) {
            if Instant::now() > deadline {
                let _ = kill(postmaster, Signal::SIGKILL);
                return;
            }
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

/// Whether a process runs. One that nobody has waited for has ended, too.
fn is_running(pid: Pid) -> bool {
    let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
    stat.rsplit_once(") ").is_some_and(|(_, rest)| !rest.starts_with('Z'))
}

/// Patroni's configuration. Its times are short, so that a failover takes seconds.
fn configured(
    name: &str,
    folder: &Path,
    host: &str,
    (port, rest_port): (u16, u16),
    etcd: &str,
    is_synchronous: bool,
) -> String {
    let programs = path_of("postgres").parent().expect("a path").display().to_string();
    let network = match host.rsplit_once('.') {
        Some((subnet, _)) if !host.starts_with("127.") => format!("{subnet}.0/24"),
        _ => "127.0.0.1/32".to_owned(),
    };
    let folder = folder.display();
    format!(
        r#"
scope: vibrissa
name: {name}
restapi: {{listen: "{host}:{rest_port}", connect_address: "{host}:{rest_port}"}}
etcd3: {{host: "{etcd}"}}
bootstrap:
  dcs:
    ttl: {TTL_S}
    loop_wait: 1
    retry_timeout: 2
    primary_start_timeout: 0
    synchronous_mode: {is_synchronous}
    postgresql:
      use_pg_rewind: true
      parameters: {{wal_log_hints: "on", max_connections: 300}}
  initdb: [{{encoding: UTF8}}, {{locale: C}}, {{auth: trust}}, no-sync]
postgresql:
  listen: "{host}:{port}"
  connect_address: "{host}:{port}"
  data_dir: {folder}/data
  bin_dir: {programs}
  pgpass: {folder}/pgpass
  authentication: {{superuser: {{username: {USER}}}, replication: {{username: {USER}}}, rewind: {{username: {USER}}}}}
  pg_hba: ["host all all {network} trust", "host replication all {network} trust"]
  parameters: {{unix_socket_directories: ""}}
  basebackup: {{checkpoint: fast}}
"#
    )
}
