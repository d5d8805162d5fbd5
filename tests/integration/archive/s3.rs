//! An S3 server, which is away at first: recording goes on, and everything is archived later.

use std::process::{Child, Command, Stdio};

use vibrissa_tests::mosquitto::free_port;
use vibrissa_tests::oracle::robots::Robots;
use vibrissa_tests::python::environment;
use vibrissa_tests::wait::until_within;

use crate::reading::{Archive, python};
use crate::stage::{LONG, Stage};

const BUCKET: &str = "contacts";

/// An S3 server in memory, which ends with this value.
struct S3(Child);

impl S3 {
    async fn start(port: u16) -> Self {
        let programs = environment("requirements-archive.txt", env!("CARGO_TARGET_TMPDIR"));
        let mut server = Command::new(programs.join("moto_server"));
        server.args(["-H", "127.0.0.1", "-p", &port.to_string()]).stdout(Stdio::null()).stderr(Stdio::null());
        let server = Self(server.spawn().unwrap());
        let answers = async || std::net::TcpStream::connect(("127.0.0.1", port)).ok();
        until_within(LONG, "the S3 server", answers).await;
        server
    }
}

impl Drop for S3 {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn an_object_store_that_is_away_delays_the_archive_and_nothing_else() {
    let keys = tempfile::tempdir().unwrap();
    let secret = keys.path().join("secret");
    std::fs::write(&secret, "secret\n").unwrap();
    let port = free_port();
    let endpoint = format!("http://127.0.0.1:{port}");
    let archive = [
        "--archive-url",
        "s3://contacts/raw",
        "--archive-s3-endpoint",
        &endpoint,
        "--archive-s3-access-key",
        "key",
        "--archive-s3-secret-key-file",
        secret.to_str().unwrap(),
    ];
    let mut stage = Stage::start(None, &archive);
    let supervisor = stage.supervisor("s3", None);
    let metric = async |name: &str, least: f64| {
        until_within(LONG, name, async || supervisor.metric(name).await.filter(|&value| value >= least)).await
    };
    metric("vibrissa_archive_errors_total", 1.0).await;
    let before = metric("vibrissa_contacts_total", 0.0).await;
    metric("vibrissa_contacts_total", before + 100.0).await;
    assert_eq!(supervisor.metric("vibrissa_archive_contacts_total").await, Some(0.0));

    let _server = S3::start(port).await;
    python("bucket.py", &["make", &endpoint, BUCKET]);
    stage.robots.rest();
    until_within(LONG, "receipts of all messages", async || (stage.robots.undelivered() == 0).then_some(())).await;
    let robots = std::mem::replace(&mut stage.robots, Robots::start(&[], &[]).unwrap());
    let mut truth = robots.stop().await;
    metric("vibrissa_archive_contacts_total", truth.ledger.count() as f64).await;

    python("bucket.py", &["copy", &endpoint, BUCKET, stage.folder().to_str().unwrap()]);
    let archive = Archive::read(&stage.folder().join("raw"));
    archive.compare(&mut truth.ledger);
    let verdict = truth.ledger.verdict();
    assert_eq!((verdict.missing, verdict.duplicate, verdict.wrong), (0, 0, 0), "{verdict:?}\n{}", supervisor.log());
    let log = supervisor.log();
    assert!(log.contains("cannot archive contacts, retrying") && !log.contains("panicked at"), "{log}");
}
