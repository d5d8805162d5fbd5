//! Two supervisors on one database, of which the owner has a wrong clock: it says so, and the other one takes the fleet.

use sqlx::ConnectOptions;
use tempfile::TempDir;
use vibrissa_protocol::ArrayType;
use vibrissa_simulator::clock::now_us;
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::postgres::Postgres;
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::until_true;

use crate::listener::{Supervised, set_host_clock};

/// Fewer robots have no vote.
const ROBOTS: usize = 3;
const CONTACTS: usize = 20;
const OFF_US: i64 = 120_000_000;

struct Stage {
    broker: Mosquitto,
    server: Postgres,
    folder: TempDir,
    robots: Vec<HandRobot>,
    sent: usize,
}

impl Stage {
    async fn new() -> Self {
        let (broker, server) = (Mosquitto::start(), Postgres::start().await);
        Self { broker, server, folder: tempfile::tempdir().unwrap(), robots: Vec::new(), sent: 0 }
    }

    fn supervisor(&self, name: &str) -> Supervised {
        let url = format!("mqtt://127.0.0.1:{}", self.broker.port());
        let database = Postgres::url(self.server.port());
        let arguments = ["--fleet", "f", "--mqtt-url", &url, "--database-url", &database];
        Supervised::start(self.folder.path(), name, &arguments)
    }

    fn set_clock(&self, name: &str, ahead_us: i64) {
        set_host_clock(self.folder.path(), name, ahead_us);
    }

    /// All robots send contacts with the true time until they are receipted.
    async fn talk(&mut self) {
        if self.robots.is_empty() {
            for number in 0..ROBOTS {
                let facts = array(ArrayType::Type2, &[70.0, 69.3]);
                let mut robot = HandRobot::connect(self.broker.port(), &format!("r{number}"), facts).await;
                robot.birth().await;
                robot.settle().await;
                self.robots.push(robot);
            }
        }
        for robot in &mut self.robots {
            robot.clock_us = now_us();
            robot.status().await;
            let contacts = (0..CONTACTS).map(|_| robot.contact(0)).collect();
            let message = robot.message(contacts);
            robot.deliver(vec![message]).await;
            self.sent += CONTACTS;
        }
    }

    /// Robots go on until a supervisor gives this answer.
    async fn talk_until(&mut self, supervisor: &Supervised, is_ready: bool, words: &[String]) {
        let mut holds = false;
        while !holds {
            self.talk().await;
            holds = supervisor
                .ready()
                .await
                .is_some_and(|(ready, text)| ready == is_ready && words.iter().all(|word| text.contains(word)));
        }
    }

    async fn number(&self, sql: &'static str) -> i64 {
        let mut link = self.server.connect().connect().await.unwrap();
        sqlx::query_scalar(sql).fetch_one(&mut link).await.unwrap()
    }

    /// All contacts are recorded once with the true time, and none was refused.
    async fn everything_is_recorded(&self, supervisors: &[&Supervised]) {
        let sent = i64::try_from(self.sent).unwrap();
        let count = "SELECT count(*) FROM contacts";
        until_true("every contact recorded", async || self.number(count).await == sent).await;
        assert_eq!(self.number("SELECT count(*) FROM contacts WHERE used = 'IMPLAUSIBLE'").await, 0);
        for supervisor in supervisors {
            assert_eq!(supervisor.metric("vibrissa_contacts_bad_time_total", "").await, 0.0);
            assert_eq!(supervisor.metric("vibrissa_messages_refused_total", "").await, 0.0);
            assert_eq!(supervisor.logged("bad_time"), 0);
        }
    }
}

fn words<const N: usize>(words: [&str; N]) -> [String; N] {
    words.map(str::to_owned)
}

/// The first owner began with a wrong clock, before anybody could contradict it.
async fn an_owner_that_began_with_a_wrong_clock(ahead_us: i64) {
    let mut stage = Stage::new().await;
    stage.set_clock("a", ahead_us);
    let mut a = stage.supervisor("a");
    a.says(false, &words(["OWNED"])).await;
    let way = if ahead_us > 0 { "120.0 s behind" } else { "120.0 s ahead" };
    let expected =
        words(["most other clocks contradict this supervisor's", "the database's clock is", way, "(NTP)", "OWNED"]);
    stage.talk_until(&a, false, &expected).await;
    let robots = a.metric("vibrissa_clock_ahead_seconds", "clock=\"robots\"").await;
    assert!((robots + ahead_us as f64 / 1e6).abs() < 1.0, "the robots' clock is {robots} s ahead");
    let mut b = stage.supervisor("b");
    stage.talk_until(&b, true, &words(["OWNED"])).await;
    let expected = words(["most other clocks contradict this supervisor's", "\"holder\":\"b\""]);
    stage.talk_until(&a, false, &expected).await;
    stage.talk().await;
    stage.everything_is_recorded(&[&a, &b]).await;
    assert_eq!(stage.number("SELECT count(*) FROM epochs").await, 2, "the fleet changes hands once");
    a.terminate().await;
    b.terminate().await;
}

#[tokio::test]
async fn regress_an_owner_whose_clock_is_ahead_says_so_and_gives_its_fleet_away() {
    an_owner_that_began_with_a_wrong_clock(OFF_US).await;
}

#[tokio::test]
async fn regress_an_owner_whose_clock_is_behind_says_so_and_gives_its_fleet_away() {
    an_owner_that_began_with_a_wrong_clock(-OFF_US).await;
}

#[tokio::test]
async fn regress_an_owner_whose_host_is_stepped_says_so_and_gives_its_fleet_away() {
    let mut stage = Stage::new().await;
    let mut a = stage.supervisor("a");
    a.says(true, &words(["OWNED"])).await;
    let mut b = stage.supervisor("b");
    b.says(true, &words(["STANDBY"])).await;
    stage.talk().await;
    for (ahead_us, way) in [(OFF_US, "120.0 s ahead"), (-OFF_US, "120.0 s behind")] {
        let (owner, name, other) = if ahead_us > 0 { (&a, "a", &b) } else { (&b, "b", &a) };
        stage.set_clock(name, ahead_us);
        stage.talk_until(other, true, &words(["OWNED"])).await;
        let expected = words(["keeps its own time: the host's clock is", way, "STANDBY"]);
        stage.talk_until(owner, false, &expected).await;
        let host = owner.metric("vibrissa_clock_ahead_seconds", "clock=\"host\"").await;
        assert!((host - ahead_us as f64 / 1e6).abs() < 1.0, "the host's clock is {host} s ahead");
        stage.set_clock(name, 0);
        stage.talk_until(owner, true, &words(["STANDBY"])).await;
    }
    stage.everything_is_recorded(&[&a, &b]).await;
    assert_eq!(stage.number("SELECT count(*) FROM epochs").await, 3, "no owner takes its fleet back");
    a.terminate().await;
    b.terminate().await;
}
