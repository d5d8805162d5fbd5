//! PgBouncer before PostgreSQL: session mode works, and a mode that shares sessions is refused at the start.

use std::os::unix::fs::chown;
use std::process::Command;

use tempfile::TempDir;
use vibrissa_store::{DatabaseAddress, Store, StoreError};
use vibrissa_tests::mosquitto::free_port;
use vibrissa_tests::postgres::Postgres;
use vibrissa_tests::process::{Launch, Process};
use vibrissa_tests::wait::until;

use crate::stage::Stage;

struct PgBouncer {
    _process: Process,
    port: u16,
    _folder: TempDir,
}

impl PgBouncer {
    /// Starts PgBouncer with its defaults except for the mode.
    async fn start(server: &Postgres, mode: &str) -> Self {
        let (folder, port) = (tempfile::tempdir().unwrap(), free_port());
        let file = folder.path().join("pgbouncer.ini");
        let text = format!(
            "[databases]\nvibrissa = host=127.0.0.1 port={} dbname=vibrissa\n[pgbouncer]\nlisten_addr = 127.0.0.1\n\
             listen_port = {port}\nunix_socket_dir =\nauth_type = trust\nauth_file = {}/users\npool_mode = {mode}\n",
            server.port(),
            folder.path().display()
        );
        std::fs::write(&file, text).unwrap();
        std::fs::write(folder.path().join("users"), "\"vibrissa\" \"\"\n").unwrap();
        let (mut program, mut arguments) = ("pgbouncer".to_owned(), vec![file.display().to_string()]);
        if std::fs::exists("/usr/sbin/pgbouncer").unwrap() {
            program = "/usr/sbin/pgbouncer".to_owned();
        }
        // PgBouncer refuses to run as root.
        if let Some(user) = user_instead_of_root() {
            chown(folder.path(), Some(user), None).unwrap();
            arguments.insert(0, program);
            arguments.splice(0..0, [format!("--reuid={user}"), "--clear-groups".to_owned()]);
            program = "setpriv".to_owned();
        }
        let process = Process::start(Launch {
            program: program.into(),
            arguments,
            environment: Vec::new(),
            log: folder.path().join("log"),
        });
        until("PgBouncer's first answer", async || {
            tokio::net::TcpStream::connect(("127.0.0.1", port)).await.ok().map(drop)
        })
        .await;
        Self { _process: process, port, _folder: folder }
    }
}

fn user_instead_of_root() -> Option<u32> {
    let id = |arguments: &[&str]| -> Option<u32> {
        String::from_utf8(Command::new("id").args(arguments).output().ok()?.stdout).ok()?.trim().parse().ok()
    };
    if id(&["-u"]) == Some(0) { id(&["-u", "postgres"]) } else { None }
}

#[tokio::test(flavor = "multi_thread")]
async fn session_mode_works() {
    let server = Postgres::start().await;
    let pooler = PgBouncer::start(&server, "session").await;
    let stage = Stage::start(&Postgres::url(pooler.port)).await;
    stage.until_busy(&server.connect()).await;
    stage.end(&server.connect()).await.is_clean();
}

#[tokio::test(flavor = "multi_thread")]
async fn transaction_and_statement_mode_are_refused_with_what_to_set() {
    let server = Postgres::start().await;
    for mode in ["transaction", "statement"] {
        let pooler = PgBouncer::start(&server, mode).await;
        let address: DatabaseAddress = Postgres::url(pooler.port).parse().unwrap();
        let store = Store::open(&address, "test").await.unwrap();
        let refused = store.prepare().await.unwrap_err();
        assert!(matches!(refused, StoreError::SharedSessions { .. }), "{mode}: {refused}");
        assert!(refused.to_string().contains("pool_mode = session") && !refused.is_passing(), "{refused}");
        store.close().await;
    }
}
