//! A deferred transaction is committed as bytes; its rows are written later by the current owner of the fleet.

use vibrissa_store::batch::Batch;
use vibrissa_store::{Lease, StoreError, Writer};
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::postgres::Postgres;
use vibrissa_tests::wait::until;

use crate::rows::{self, contacts};
use crate::supervisors::Replica;
use crate::{Fresh, fleet, supervisor};

async fn lease(database: &Fresh) -> (Writer, Lease) {
    let (a, mut writer) = (supervisor("a"), database.store.writer());
    writer.sign_in(&a, &[]).await.unwrap();
    let lease = writer.acquire(&a, &fleet()).await.unwrap().unwrap();
    (writer, lease)
}

async fn kept_and_written(database: &Fresh) {
    let (mut writer, lease) = lease(database).await;
    let robot = rows::robot(&mut writer, &lease).await;
    let batch = Batch { responses: Vec::new(), ..contacts(&robot, 0..5) };
    let bytes = batch.to_bytes().unwrap();
    writer.write_intent(&lease, 7, &bytes).await.unwrap();
    writer.write_intent(&lease, 8, &contacts(&robot, 5..6).to_bytes().unwrap()).await.unwrap();
    assert_eq!(database.store.contact_count().await.unwrap(), 0, "only the bytes may be stored");
    // The rows are written once and in order.
    for (number, contacts) in [(7, 5), (8, 6)] {
        let (first, bytes) = writer.pending_intent(&lease).await.unwrap().unwrap();
        assert_eq!(first, number);
        let batch = Batch { redo_done: Some(number), ..Batch::from_bytes(&bytes).unwrap() };
        writer.commit(&lease, &batch).await.unwrap();
        assert_eq!(database.store.contact_count().await.unwrap(), contacts);
    }
    assert_eq!(writer.pending_intent(&lease).await.unwrap(), None);

    // A supervisor that has lost its fleet cannot defer transactions.
    let (b, mut other) = (supervisor("b"), database.store.writer());
    let new = until("taken over", async || other.acquire(&b, &fleet()).await.unwrap()).await;
    let refused = writer.write_intent(&lease, 9, &bytes).await.unwrap_err();
    assert!(matches!(refused, StoreError::LeaseLost { .. }), "{refused}");
    assert_eq!(other.pending_intent(&new).await.unwrap(), None);
}

#[tokio::test]
async fn what_is_kept_is_written_once_on_sqlite() {
    kept_and_written(&Fresh::sqlite().await).await;
}

#[tokio::test]
async fn what_is_kept_is_written_once_on_postgres() {
    kept_and_written(&Fresh::postgres().await).await;
}

/// A supervisor defers transactions and is killed before their rows are written. The next owner writes them and
/// discards bytes that it cannot decode.
#[tokio::test]
async fn regress_whoever_takes_a_fleet_up_writes_what_was_kept() {
    let (database, broker) = (Fresh::postgres().await, Mosquitto::start());
    let (mut writer, lease) = lease(&database).await;
    let robot = rows::robot(&mut writer, &lease).await;
    let bytes = contacts(&robot, 0..5).to_bytes().unwrap();
    writer.write_intent(&lease, 7, &bytes).await.unwrap();
    writer.write_intent(&lease, 8, &bytes[..bytes.len() / 2]).await.unwrap();
    writer.write_intent(&lease, 9, &contacts(&robot, 5..8).to_bytes().unwrap()).await.unwrap();

    let (folder, url) = (tempfile::tempdir().unwrap(), Postgres::url(database.server.as_ref().unwrap().port()));
    let mut next = Replica::start(folder.path(), "s", "f", &url, broker.port(), 0.8);
    next.says(200, "OWNED").await;
    assert_eq!(database.store.contact_count().await.unwrap(), 8);
    assert_eq!(writer.pending_intent(&lease).await.unwrap(), None);
    next.terminate().await;
}
