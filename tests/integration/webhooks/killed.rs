//! A supervisor that is killed between the commit of an event and its delivery.

use std::path::Path;

use serde_json::json;
use vibrissa_tests::mosquitto::free_port;
use vibrissa_tests::process::{Launch, Process};
use vibrissa_tests::wait::until_true;
use vibrissa_tests::web::{send, try_get};

use crate::receiver::{Manner, Receiver};
use crate::stage::{Stage, taken};

/// A supervisor process.
struct Program {
    process: Process,
    http: std::net::SocketAddr,
}

impl Program {
    async fn start(stage: &Stage, name: &str, database: &str) -> Self {
        let http = std::net::SocketAddr::from(([127, 0, 0, 1], free_port()));
        let broker = format!("mqtt://127.0.0.1:{}", stage.broker.port());
        let arguments = [
            "run",
            "--fleet",
            "f",
            "--name",
            name,
            "--http",
            &http.to_string(),
            "--mqtt-url",
            &broker,
            "--database-url",
            database,
            "--webhooks-allowed-hosts",
            "127.0.0.1",
        ];
        let process = Process::start(Launch {
            program: env!("CARGO_BIN_EXE_vibrissa-under-test").into(),
            arguments: arguments.iter().map(|&argument| argument.to_owned()).collect(),
            environment: Vec::new(),
            log: Path::new(stage.folder.path()).join(format!("{name}.log")),
        });
        until_true("the program answers", async || try_get(http, "/livez").await.is_ok()).await;
        Self { process, http }
    }

    async fn hook(&self, receiver: &Receiver) {
        let body = json!({ "name": "tickets", "url": receiver.url() });
        let answer = send(self.http, "POST", "/v1/webhooks", &[], Some(&body)).await.unwrap();
        assert_eq!(answer.status, 201, "{}", answer.body);
    }
}

/// No secret and no path of a URL is in a log.
fn tells_no_secret(stage: &Stage) {
    for entry in std::fs::read_dir(stage.folder.path()).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|ending| ending == "log") {
            let log = std::fs::read_to_string(&path).unwrap();
            assert!(!log.contains("whsec_") && !log.contains("confidential"), "{log}");
        }
    }
}

#[tokio::test]
async fn chaos_a_killed_supervisor_with_a_file_loses_no_event() {
    let stage = Stage::sqlite().await;
    let database = format!("sqlite:{}", stage.file().display());
    let receiver = Receiver::start(Manner::Status(503)).await;
    let mut program = Program::start(&stage, "a", &database).await;
    stage.robot().await;
    program.hook(&receiver).await;
    let mut raw = stage.raw().await;
    for trim_id in 1..=5 {
        raw.trim(trim_id).await;
    }
    until_true("an attempt", async || !receiver.requests().is_empty()).await;
    program.process.kill();
    drop(program);
    receiver.is(Manner::Status(200));
    let _program = Program::start(&stage, "b", &database).await;
    assert_eq!(taken(&receiver, 5).await, [1, 2, 3, 4, 5]);
    tells_no_secret(&stage);
}
