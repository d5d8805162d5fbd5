//! Databases that the program refuses, each in words that name the remedy.

use sqlx::{ConnectOptions, Executor};
use vibrissa_protocol::ArrayType;
use vibrissa_store::{DatabaseAddress, Store, StoreError};
use vibrissa_supervisor::service::{Service, ServiceOptions};
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::postgres::{DATABASE, Postgres};
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::{until, until_true};

use crate::fleet;
use crate::restore::options;

async fn prepared(url: &str) -> Result<(), StoreError> {
    let address: DatabaseAddress = url.parse().unwrap();
    Store::open(&address, "unfit").await?.prepare().await
}

#[tokio::test]
async fn regress_a_database_in_another_encoding_or_without_its_tables_is_refused() {
    let server = Postgres::start().await;
    let mut link = server.connect().connect().await.unwrap();
    for encoding in ["LATIN1", "SQL_ASCII"] {
        let create = format!("CREATE DATABASE other ENCODING '{encoding}' LOCALE 'C' TEMPLATE template0");
        link.execute(sqlx::AssertSqlSafe(create)).await.unwrap();
        let url = format!("{}other", Postgres::url(server.port()).strip_suffix(DATABASE).unwrap());
        let problem = prepared(&url).await.unwrap_err();
        assert!(!problem.is_passing());
        let problem = problem.to_string();
        assert!(problem.contains(encoding) && problem.contains("createdb --encoding=UTF8"), "{problem}");
        link.execute("DROP DATABASE other WITH (FORCE)").await.unwrap();
    }
    let url = Postgres::url(server.port());
    assert!(prepared(&url).await.is_ok());
    link.execute("DROP TABLE setpoints CASCADE").await.unwrap();
    let problem = prepared(&url).await.unwrap_err().to_string();
    assert!(problem.contains("setpoints") && problem.contains("pg_restore"), "{problem}");
}

/// Starts a supervisor on the database, waits until it is ready or tells of another database, and stops it. True if it
/// supervises the fleet.
async fn takes_up(database: &DatabaseAddress, broker: &Mosquitto, is_new_installation: bool) -> bool {
    let service = Service::start(ServiceOptions { is_new_installation, ..options(database, broker) }).await.unwrap();
    // One look decides: a passing problem may come right after it.
    let is_ready = until("the decision", async || {
        let problems = service.readiness.problems();
        let refuses = problems.iter().any(|problem| problem.contains("it is another database"));
        (refuses || problems.is_empty()).then_some(!refuses)
    })
    .await;
    if is_ready {
        HandRobot::born(broker.port(), "r", array(ArrayType::Type1, &[70.0])).await;
        until_true("the robot", async || service.store.has_robots(&fleet()).await.unwrap()).await;
    } else {
        let problem = service.readiness.problems().into_iter().collect::<Vec<_>>().join("; ");
        assert!(problem.contains("database.installation = \"new\"") && problem.contains("back-up"), "{problem}");
        assert!(!service.store.has_robots(&fleet()).await.unwrap());
    }
    service.stop().await;
    is_ready
}

async fn regress_vanished(database: &DatabaseAddress, other: &DatabaseAddress) {
    let broker = Mosquitto::start();
    assert!(takes_up(database, &broker, false).await, "nobody has owned the fleet yet");
    assert!(takes_up(database, &broker, false).await);
    for _ in 0..2 {
        assert!(!takes_up(other, &broker, false).await, "also after a restart");
    }
    assert!(takes_up(other, &broker, true).await, "somebody says that it is new");
    for known in [other, database] {
        assert!(takes_up(known, &broker, false).await);
    }
}

#[tokio::test]
async fn regress_an_empty_database_takes_up_no_fleet_of_another_one() {
    let server = Postgres::start().await;
    server.connect().connect().await.unwrap().execute("CREATE DATABASE other").await.unwrap();
    let url = Postgres::url(server.port());
    let other = format!("{}other", url.strip_suffix(DATABASE).unwrap());
    regress_vanished(&url.parse().unwrap(), &other.parse().unwrap()).await;
}

#[tokio::test]
async fn regress_an_emptied_folder_takes_up_no_fleet_of_another_database() {
    let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    let [database, other] = folders.each_ref().map(|folder| DatabaseAddress::Sqlite(folder.path().join("v.sqlite3")));
    regress_vanished(&database, &other).await;
}
