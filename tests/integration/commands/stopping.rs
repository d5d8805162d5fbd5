//! Interrupts long commands.

use std::path::Path;
use std::process::{Child, Command, Output, Stdio};

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use vibrissa_tests::wait;

use crate::program::{PROGRAM, err, vibrissa};

fn start(arguments: &[&str], folder: &Path) -> Child {
    Command::new(PROGRAM)
        .args(arguments)
        .current_dir(folder)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Whether the process has a handler for SIGINT, according to `/proc`.
fn handles_interrupts(child: &Child) -> bool {
    let status = std::fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap();
    let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap();
    u64::from_str_radix(caught.trim(), 16).unwrap() & (1 << (Signal::SIGINT as u64 - 1)) != 0
}

/// Sends the signal once the process handles it, and waits for the end.
async fn stopped(child: Child, signal: Signal) -> Output {
    wait::until_true("it handles interrupts", async || handles_interrupts(&child)).await;
    kill(Pid::from_raw(child.id() as i32), signal).unwrap();
    // The standard input stays open until the process has ended.
    let mut child = child;
    let input = child.stdin.take();
    let has_ended = wait::found_within(wait::PATIENCE, async || child.try_wait().unwrap()).await;
    if has_ended.is_none() {
        child.kill().unwrap();
    }
    let output = child.wait_with_output().unwrap();
    drop(input);
    output
}

#[tokio::test]
async fn every_evaluation_can_be_stopped_and_leaves_nothing() {
    for (arguments, signal) in [
        (["detection", "--cuts", "1000000"], Signal::SIGINT),
        (["health", "--cases", "100000"], Signal::SIGTERM),
        (["compensation", "--plants", "10000"], Signal::SIGINT),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let child = start(&[&["evaluate"], &arguments[..], &["--svg", "figures"]].concat(), folder.path());
        let output = stopped(child, signal).await;
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(130), "{message}");
        assert!(message.contains("vibrissa: stopped: the evaluation is incomplete"), "{message}");
        assert!(output.stdout.is_empty());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}

#[tokio::test]
async fn a_replay_that_waits_for_its_input_can_be_stopped() {
    let folder = tempfile::tempdir().unwrap();
    let output = stopped(start(&["replay", "-"], folder.path()), Signal::SIGINT).await;
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(130), "{message}");
    assert!(message.contains("vibrissa: stopped: the output covers only the part"), "{message}");
}

#[test]
fn an_evaluation_tells_its_progress_without_a_terminal() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, what) in [
        (&["detection", "--cuts", "1", "--healthy", "1"][..], "whiskers"),
        (&["health", "--cases", "1"], "cases"),
        (&["compensation", "--plants", "1"], "compensations"),
        (&["reality", "--rows", "ideal", "--contacts", "1", "--cuts", "1"], "robots"),
    ] {
        let progress = err(&vibrissa(&[&["evaluate"], arguments].concat(), folder.path()));
        let first = progress.lines().next().unwrap_or_default();
        let is_progress = first.starts_with("vibrissa: 0 of ") && first.contains(&format!(" {what} done after "));
        assert!(is_progress, "{arguments:?}: {progress}");
    }
}
