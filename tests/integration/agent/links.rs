//! Ways to a driver other than a child process, and programs that cannot start.

use std::process::Command;

use tokio::io::{AsyncBufReadExt, AsyncWriteExt, BufReader};
use tokio::net::UnixStream;
use vibrissa_tests::mosquitto::free_port;
use vibrissa_tests::process::{Launch, Process};
use vibrissa_tests::wait::until_true;

use crate::stage::{BOARD, Stage, agent_program, scenario};

/// A board as a process of its own, with these arguments.
fn board(stage: &Stage, arguments: &[&str]) -> Process {
    let folder = stage.folder.path();
    let (scenario, log) = (scenario(folder, 20.0), folder.join("board.log"));
    let fixed = ["board", "--scenario", scenario.to_str().unwrap(), "--log-file", log.to_str().unwrap()];
    Process::start(Launch {
        program: BOARD.into(),
        arguments: fixed.iter().chain(arguments).map(|&argument| argument.to_owned()).collect(),
        environment: vec![],
        log: folder.join("board.err"),
    })
}

async fn contacts_come(stage: &Stage) {
    let before = stage.number("SELECT count(*) FROM contacts").await;
    until_true("contacts", async || stage.number("SELECT count(*) FROM contacts").await >= before + 20).await;
}

#[tokio::test]
async fn a_serial_board_is_heard_and_again_after_it_was_unplugged() {
    let stage = Stage::start(|folder| format!("serial = {:?}", folder.join("tty"))).await;
    let link = stage.folder.path().join("tty");
    let mut plugged = board(&stage, &["--pty", link.to_str().unwrap()]);
    contacts_come(&stage).await;
    plugged.kill();
    until_true("an agent that misses its board", async || stage.agent_log().contains("the driver has gone")).await;
    plugged.restart();
    contacts_come(&stage).await;
}

#[tokio::test]
async fn a_board_over_tcp_is_reached_in_either_direction() {
    let port = free_port();
    let stage = Stage::start(|_| format!("tcp = \"127.0.0.1:{port}\"")).await;
    let _listening = board(&stage, &["--listen", &format!("127.0.0.1:{port}")]);
    contacts_come(&stage).await;
    let port = free_port();
    let stage = Stage::start(|_| format!("listen = \"127.0.0.1:{port}\"")).await;
    let _connecting = board(&stage, &["--connect", &format!("127.0.0.1:{port}")]);
    contacts_come(&stage).await;
}

#[tokio::test]
async fn noise_on_a_unix_socket_is_answered_and_good_lines_are_taken() {
    let stage = Stage::start(|folder| format!("unix = {:?}", folder.join("driver.sock"))).await;
    let path = stage.folder.path().join("driver.sock");
    for _ in 0..2 {
        // The second driver comes when the first one has gone.
        let (reader, mut writer) = UnixStream::connect(&path).await.unwrap().into_split();
        let mut lines = BufReader::new(reader).lines();
        let mut bytes = b"\xff\x00noise\n{\"type\":\n".to_vec();
        bytes.extend_from_slice(&b"[".repeat(100_000));
        bytes.extend_from_slice(b"\n");
        for whisker in 0..2 {
            bytes.extend_from_slice(
                format!(
                    "{{\"type\":\"contact\",\"whisker\":{whisker},\"deflection_mm\":1,\"strain\":0.01,\"ratio\":0.7,\
                         \"pressure_mpa\":0.1}}\r\n"
                )
                .as_bytes(),
            );
        }
        let before = stage.number("SELECT count(*) FROM contacts").await;
        writer.write_all(&bytes).await.unwrap();
        let mut errors = Vec::new();
        while errors.len() < 3 {
            let line = lines.next_line().await.unwrap().expect("an answer");
            if line.contains("\"error\"") {
                errors.push(line);
            }
        }
        assert!(errors[0].contains("\"line\":1,\"problem\":\"the line is not UTF-8\""), "{errors:?}");
        assert!(errors[2].contains("longer than 65536 bytes"), "{errors:?}");
        // The operator sees the first one, and not each.
        let refusals = stage.agent_log().lines().filter(|line| line.contains("of the driver is refused")).count();
        assert_eq!(refusals, 1, "{}", stage.agent_log());
        until_true("two contacts", async || stage.number("SELECT count(*) FROM contacts").await == before + 2).await;
    }
}

#[test]
fn an_agent_that_cannot_start_says_why() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("agent.toml");
    let problem_of = |text: &str| {
        std::fs::write(&path, text).unwrap();
        let output = Command::new(agent_program()).arg("--config").arg(&path).output().unwrap();
        assert!(!output.status.success());
        String::from_utf8(output.stderr).unwrap()
    };
    let good = crate::stage::configuration(1, "command = [\"true\"]");
    for (from, to, why) in [
        ("robot = ", "robbot = ", "robbot"),
        ("silent_s = 1.5", "silent_s = 0", "driver.silent_s is 0, but must be between 0.5 and 600"),
        ("\"outbox\"", "\"no/folder/outbox\"", "outbox.file: cannot lock"),
        ("command = [\"true\"]", "listen = \"10.0.0.1:5\"", "driver.listen: must be a loopback address"),
    ] {
        let problem = problem_of(&good.replace(from, to));
        assert!(problem.contains(why), "{why}: {problem}");
    }
    std::fs::write(&path, &good).unwrap();
    let checked = Command::new(agent_program()).args(["--check", "--config"]).arg(&path).output().unwrap();
    assert!(checked.status.success() && String::from_utf8_lossy(&checked.stdout).contains("robot r of fleet f"));
}
