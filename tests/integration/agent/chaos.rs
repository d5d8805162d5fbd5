//! Agents, drivers, links and supervisors that are killed: the board's own log tells what should have been recorded.

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use tokio::time::{sleep, timeout};
use vibrissa_simulator::clock::now_us;
use vibrissa_tests::wait::{PATIENCE, until, until_true, until_within};

use crate::stage::{Stage, board_as_child};

/// What a kill of the agent may cost: contacts that wait for more in an incomplete message (0.1 s by default) and lines in
/// the pipe. A slow machine adds to it.
const BOUND_US: i64 = 500_000;
/// Time after a kill in which the board of a dead agent may still log contacts, until it finds its output closed.
const ORPHANED_US: i64 = 250_000;

/// Waits until that many more contacts are recorded.
async fn more_contacts(stage: &Stage, more: i64) {
    let before = stage.number("SELECT count(*) FROM contacts").await;
    until_true("more contacts", async || stage.number("SELECT count(*) FROM contacts").await >= before + more).await;
}

/// Sets a pressure until the board has been told: an agent without a driver refuses it.
async fn ordered(stage: &Stage, pressure_mpa: f64) {
    let is_told =
        || stage.board_log().iter().any(|line| line["log"] == "set_pressure" && line["pressure_mpa"] == pressure_mpa);
    let deadline = Instant::now() + PATIENCE;
    while !is_told() {
        assert!(Instant::now() < deadline, "the board was not told {pressure_mpa} MPa");
        stage.set_by_hand(0, pressure_mpa).await;
        let _ = timeout(Duration::from_secs(2), until_true("a board that was told", async || is_told())).await;
    }
}

/// No contact is recorded more often than the board has made one of this whisker and time: a board that was kept waiting
/// makes two in one microsecond.
async fn none_twice(stage: &Stage, recorded: &[(i64, i64)]) {
    let felt = stage.felt();
    let times = |all: &[(i64, i64)], one: &(i64, i64)| all.iter().filter(|&other| other == one).count();
    let twice = recorded.iter().filter(|one| times(recorded, one) > times(&felt, one));
    let twice: Vec<i64> = twice.map(|&(_, t_us)| t_us).collect();
    assert!(twice.is_empty(), "recorded twice: {}", stage.rows_of(&twice).await);
}

#[tokio::test]
async fn nothing_is_lost_beyond_the_bound_and_no_setpoint_is_applied_twice_or_late() {
    let mut stage = Stage::start(|folder| board_as_child(folder, 40.0)).await;
    until_true("contacts", async || stage.number("SELECT count(*) FROM contacts").await > 20).await;
    ordered(&stage, 0.101).await;

    // The link breaks, several times.
    for _ in 0..3 {
        stage.proxy.cut();
        more_contacts(&stage, 40).await;
    }
    ordered(&stage, 0.102).await;

    // The driver is killed; another one is started, and told the pressure again.
    // A contact that the board has logged and not yet said is lost with the board.
    let mut kills_us = vec![now_us() as i64];
    let first = stage.board_pid().unwrap();
    kill(Pid::from_raw(first), Signal::SIGKILL).unwrap();
    let second = until("another board", async || stage.board_pid().filter(|&pid| pid != first)).await;
    more_contacts(&stage, 40).await;
    ordered(&stage, 0.103).await;

    // The driver hangs; it is killed and started again.
    kills_us.push(now_us() as i64);
    kill(Pid::from_raw(second), Signal::SIGSTOP).unwrap();
    until("a third board", async || stage.board_pid().filter(|&pid| pid != second)).await;
    assert!(stage.agent_log().contains("the driver is silent"));
    more_contacts(&stage, 40).await;

    // The agent is killed while its contacts cannot be sent, and a second time before they are receipted.
    for _ in 0..2 {
        stage.proxy.stall(true);
        let before = stage.felt().len();
        until_true("contacts that wait", async || stage.felt().len() > before + 100).await;
        kills_us.push(now_us() as i64);
        stage.agent.kill();
        stage.proxy.stall(false);
        stage.proxy.cut();
        stage.agent.restart();
        more_contacts(&stage, 40).await;
    }
    ordered(&stage, 0.104).await;

    // The supervisor is killed, and the agent during its absence: the supervisor has never heard of the boot between.
    stage.supervisor.kill();
    stage.agent.kill();
    kills_us.push(now_us() as i64);
    stage.agent.restart();
    let before = stage.felt().len();
    until_true("contacts of an unknown boot", async || stage.felt().len() > before + 100).await;
    kills_us.push(now_us() as i64);
    stage.agent.kill();
    stage.agent.restart();
    stage.supervisor.restart();
    stage.is_ready().await;
    more_contacts(&stage, 40).await;
    ordered(&stage, 0.105).await;

    // The end in good order: everything is sent.
    let ended_us = now_us() as i64;
    stage.agent.signal(Signal::SIGTERM);
    assert!(stage.agent.ended(Duration::from_secs(10)).await.is_some_and(|status| status.success()));
    let felt = stage.felt();
    // The agent starts once more, without a driver that adds contacts, until all is receipted.
    let without = std::fs::read_to_string(stage.folder.path().join("agent.toml")).unwrap();
    let begin = without.find("command = ").unwrap();
    let end = begin + without[begin..].find('\n').unwrap();
    let without = format!("{}command = [\"sleep\", \"60\"]{}", &without[..begin], &without[end..]);
    std::fs::write(stage.folder.path().join("agent.toml"), without).unwrap();
    stage.agent.restart();
    let is_beyond = |t_us: i64| {
        t_us >= ended_us - BOUND_US || kills_us.iter().any(|&at| (at - BOUND_US..=at + ORPHANED_US).contains(&t_us))
    };
    let due: Vec<(i64, i64)> = felt.iter().copied().filter(|&(_, t_us)| !is_beyond(t_us)).collect();
    let lost = async || {
        let recorded: BTreeSet<(i64, i64)> = stage.recorded().await.into_iter().collect();
        due.iter().copied().filter(|contact| !recorded.contains(contact)).collect::<Vec<_>>()
    };
    let deadline = Instant::now() + Duration::from_secs(60);
    loop {
        let lost = lost().await;
        if lost.is_empty() {
            break;
        }
        assert!(Instant::now() < deadline, "lost: {lost:?}, of {} due; killed at {kills_us:?}", due.len());
        sleep(Duration::from_millis(100)).await;
    }

    let recorded = stage.recorded().await;
    none_twice(&stage, &recorded).await;
    assert!(recorded.iter().all(|contact| felt.contains(contact)), "a contact was recorded that nobody felt");
    println!("{} contacts felt, {} recorded, {} due", felt.len(), recorded.len(), due.len());
    assert!(due.len() > 250, "{} of {}", due.len(), felt.len());

    // 0.1 MPa is the pressure of each start; of orders each board gets only newer ones, and each one once.
    let mut newest_mpa = 0.0;
    for line in stage.board_log().iter().filter(|line| line["whisker"] == 0 || line["log"] == "started") {
        let (is_start, pressure_mpa) = (line["log"] == "started", line["pressure_mpa"].as_f64());
        if let Some(pressure_mpa) = pressure_mpa.filter(|&mpa| line["log"] == "set_pressure" && mpa != 0.1) {
            assert!(pressure_mpa > newest_mpa, "{pressure_mpa} MPa after {newest_mpa} MPa");
            newest_mpa = pressure_mpa;
        } else if is_start {
            // A new board is told the newest order again.
            newest_mpa -= 1e-9;
        }
    }
    assert_eq!(newest_mpa, 0.105);
    // The messages of earlier boots were taken; none was refused as one of an unknown boot in the end.
    assert_eq!(stage.number("SELECT count(*) FROM contacts WHERE used = 'BAD_TIME'").await, 0);
}

#[tokio::test]
async fn a_supervisor_that_was_away_for_a_whole_boot_gets_its_contacts() {
    let mut stage = Stage::start(|folder| board_as_child(folder, 20.0)).await;
    until_true("contacts", async || stage.number("SELECT count(*) FROM contacts").await > 20).await;
    stage.supervisor.kill();
    stage.agent.kill();
    stage.agent.restart();
    let began_us = now_us() as i64 + ORPHANED_US;
    let felt_since = |stage: &Stage, from_us: i64| stage.felt().iter().filter(|&&(_, t_us)| t_us >= from_us).count();
    until_true("contacts of the boot", async || felt_since(&stage, began_us) > 60).await;
    let killed_us = now_us() as i64;
    stage.agent.kill();
    stage.agent.restart();
    until_true("contacts of the next boot", async || felt_since(&stage, killed_us + ORPHANED_US) > 20).await;
    // It hears the retained messages of the next boot before anything of the one that it missed.
    stage.supervisor.restart();
    stage.is_ready().await;
    let missed = stage.felt().into_iter().filter(|&(_, t_us)| (began_us..killed_us - BOUND_US).contains(&t_us));
    let missed: Vec<(i64, i64)> = missed.collect();
    assert!(missed.len() > 20, "{missed:?}");
    until_within(Duration::from_secs(60), "the contacts of the boot that it missed", async || {
        let recorded: BTreeSet<(i64, i64)> = stage.recorded().await.into_iter().collect();
        missed.iter().all(|contact| recorded.contains(contact)).then_some(())
    })
    .await;
    assert!(stage.agent_log().contains("another one begins"));
    ordered(&stage, 0.11).await;
    let recorded = stage.recorded().await;
    none_twice(&stage, &recorded).await;
}
