//! Positions of the archive in a partitioned log, on both databases.

use vibrissa_store::StoreError;
use vibrissa_store::archive::Archived;
use vibrissa_store::log_archive::{LogArchive, LogSpan};

use crate::{Fresh, fleet, supervisor};

async fn a_position_advances_over_its_plan_only(database: &Fresh) {
    let a = supervisor("a");
    let mut writer = database.store.writer();
    writer.sign_in(&a, &[]).await.unwrap();
    let lease = writer.acquire(&a, &fleet()).await.unwrap().unwrap();
    assert_eq!(writer.log_archive(&lease).await.unwrap(), None);
    let span = |from, to| LogSpan { topic: "t".to_owned(), from, to };
    let at = |next_offset, planned_to, seen: &str| {
        let archived_to_us = if seen == "none" { 100 } else { 200 };
        Some(LogArchive { topic: "t".to_owned(), next_offset, planned_to, seen: seen.to_owned(), archived_to_us })
    };
    writer.plan_log_archive(&lease, &span(5, 9), ("none", 100)).await.unwrap();
    assert_eq!(writer.log_archive(&lease).await.unwrap(), at(5, Some(9), "none"));

    let archived = Archived { contacts: 7, bytes: 700 };
    for other in [span(4, 9), span(5, 8)] {
        writer.advance_log_archive(&lease, &other, ("some", 200), (1, archived)).await.unwrap();
        assert_eq!(writer.log_archive(&lease).await.unwrap(), at(5, Some(9), "none"), "{other:?} is not the plan");
    }
    // The second time changes nothing: the first answer was lost.
    for _ in 0..2 {
        writer.advance_log_archive(&lease, &span(5, 9), ("some", 200), (1, archived)).await.unwrap();
        assert_eq!(writer.log_archive(&lease).await.unwrap(), at(9, None, "some"));
    }

    // A lease that was lost writes nothing.
    writer.release(&lease).await.unwrap();
    // Reads the changed row: a lease is acquired only as it was read.
    writer.sign_in(&a, &[]).await.unwrap();
    let next = writer.acquire(&a, &fleet()).await.unwrap().unwrap();
    let refused = writer.plan_log_archive(&lease, &span(9, 12), ("other", 300)).await.unwrap_err();
    assert!(matches!(refused, StoreError::LeaseLost { .. }), "{refused}");
    assert_eq!(writer.log_archive(&next).await.unwrap(), at(9, None, "some"));
}

#[tokio::test]
async fn in_sqlite_a_position_advances_over_its_plan_only() {
    a_position_advances_over_its_plan_only(&Fresh::sqlite().await).await;
}

#[tokio::test]
async fn in_postgresql_a_position_advances_over_its_plan_only() {
    a_position_advances_over_its_plan_only(&Fresh::postgres().await).await;
}
