//! A slow disk slows a fleet down, and does not stop it.

use sqlx::ConnectOptions;
use vibrissa_protocol::ArrayType;
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::postgres::Postgres;
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::until_true;
use vibrissa_tests::web::try_get;

use crate::actions::{owns, supervisor};

/// Each commit takes 2.5 s, longer than the lease's time to live, as on a disk that is slow to write.
const SLOW: &str = "CREATE FUNCTION slow() RETURNS trigger LANGUAGE plpgsql AS \
    $$ BEGIN PERFORM pg_sleep(2.5); RETURN NULL; END $$; \
    CREATE CONSTRAINT TRIGGER slow AFTER UPDATE ON leases DEFERRABLE INITIALLY DEFERRED FOR EACH ROW \
    WHEN (OLD.commits IS DISTINCT FROM NEW.commits) EXECUTE FUNCTION slow()";

/// The lease had expired at the end of each commit, so that no receipt went out.
#[tokio::test]
async fn regress_commits_slower_than_the_lease_are_receipted() {
    let (broker, server) = (Mosquitto::start(), Postgres::start().await);
    let owner = supervisor("a", server.port(), &broker).await;
    until_true("an owner", async || owns(&owner)).await;
    let mut robot = HandRobot::born(broker.port(), "r", array(ArrayType::Type1, &[70.0, 65.0])).await;
    robot.touch(1, 1).await;
    robot.receipted().await;
    let mut link = server.connect().connect().await.unwrap();
    sqlx::raw_sql(SLOW).execute(&mut link).await.unwrap();
    robot.touch(1, 1).await;
    robot.receipted().await;
    assert!(owns(&owner), "the fleet stays with its owner");
    sqlx::raw_sql("DROP TRIGGER slow ON leases").execute(&mut link).await.unwrap();
    owner.stop().await;
}

/// Somebody locks the table of contacts: nothing fails, and nothing is recorded.
#[tokio::test]
async fn a_locked_table_is_told_by_the_age_of_the_oldest_commit() {
    let (broker, server) = (Mosquitto::start(), Postgres::start().await);
    let owner = supervisor("a", server.port(), &broker).await;
    until_true("an owner", async || owns(&owner)).await;
    let mut robot = HandRobot::born(broker.port(), "r", array(ArrayType::Type1, &[70.0, 65.0])).await;
    robot.touch(1, 1).await;
    robot.receipted().await;
    let age_s = async || {
        let (_, text) = try_get(owner.http, "/metrics").await.unwrap();
        let name = "vibrissa_promise_age_seconds{fleet=\"f\",promise=\"COMMITTED\"} ";
        text.lines().find_map(|line| line.strip_prefix(name)?.parse::<f64>().ok())
    };
    let mut link = server.connect().connect().await.unwrap();
    sqlx::raw_sql("BEGIN; LOCK TABLE contacts IN ACCESS EXCLUSIVE MODE").execute(&mut link).await.unwrap();
    robot.touch(1, 1).await;
    until_true("an old message", async || age_s().await.is_some_and(|age| age > 3.0)).await;
    until_true("the problem", async || {
        let (status, body) = try_get(owner.http, "/readyz").await.unwrap();
        status == 503 && body.contains("nothing is recorded: ")
    })
    .await;
    sqlx::raw_sql("ROLLBACK").execute(&mut link).await.unwrap();
    robot.receipted().await;
    until_true("readiness", async || try_get(owner.http, "/readyz").await.unwrap().0 == 200).await;
    assert!(age_s().await.is_none_or(|age| age < 3.0));
    owner.stop().await;
}
