//! Black boxes in both databases: written and replaced under the lease, of bounded number and age.

use vibrissa_store::black_boxes::{BOXES_PER_ROBOT, NewBlackBox};
use vibrissa_store::list::Selection;
use vibrissa_store::lists::black_boxes::{BLACK_BOXES, BlackBox};
use vibrissa_store::retention::{Done, Retention};
use vibrissa_store::{Lease, Store, StoreError, Writer};
use vibrissa_tests::wait::until;

use crate::rows::{self, Numbered};
use crate::{Fresh, brief, fleet, supervisor};

fn one(numbered: &Numbered, event_us: i64, state: &'static str) -> NewBlackBox {
    NewBlackBox {
        robot_id: numbered.robot_id,
        whisker_id: numbered.whisker_ids[0],
        cause: "TRIM",
        event_us,
        began_us: event_us - 60_000_000,
        ends_us: event_us + 60_000_000,
        last_us: event_us,
        state,
        messages: 3,
        left_out: 0,
        has_state: true,
        bytes: 10,
        body: state.as_bytes().to_vec(),
    }
}

/// States and numbers of all boxes, the newest first.
async fn boxes(store: &Store) -> Vec<(String, i64)> {
    let rows = store.list::<BlackBox>(&BLACK_BOXES, &Selection::all(&BLACK_BOXES, 1000)).await.unwrap().rows;
    rows.into_iter().map(|row| (row.state, row.black_box_id)).collect()
}

/// The fleet's first owner, with one robot.
async fn taken(database: &Fresh) -> (Writer, Lease, Numbered) {
    let (a, mut writer) = (brief("a"), database.store.writer());
    writer.sign_in(&a, &[]).await.unwrap();
    let lease = writer.acquire(&a, &fleet()).await.unwrap().unwrap();
    let numbered = rows::robot(&mut writer, &lease).await;
    (writer, lease, numbered)
}

async fn boxes_are_replaced_limited_and_removed(database: &Fresh) {
    let (mut writer, lease, numbered) = taken(database).await;
    let store = &database.store;
    writer.write_black_box(&lease, &one(&numbered, 1_000_000_000, "RECORDING")).await.unwrap();
    let before = boxes(store).await;
    writer.write_black_box(&lease, &one(&numbered, 1_000_000_000, "COMPLETE")).await.unwrap();
    assert_eq!(boxes(store).await, [("COMPLETE".to_owned(), before[0].1)], "the same box, replaced");
    let body = store.black_box(before[0].1).await.unwrap().unwrap();
    assert_eq!((body.fleet.as_str(), body.robot.as_str(), &body.body[..]), ("f", "r", &b"COMPLETE"[..]));
    assert_eq!(store.black_box(before[0].1 + 1).await.unwrap(), None);

    for number in 1..=BOXES_PER_ROBOT + 2 {
        let event_us = 1_000_000_000 + number * 60_000_000;
        writer.write_black_box(&lease, &one(&numbered, event_us, "COMPLETE")).await.unwrap();
    }
    assert_eq!(boxes(store).await.len() as i64, BOXES_PER_ROBOT, "the oldest are gone");

    // Boxes of a time at which the clock was ahead are not newer than the next one.
    for number in 1..=BOXES_PER_ROBOT {
        let event_us = 1_000_000_000_000_000 + number * 60_000_000;
        writer.write_black_box(&lease, &one(&numbered, event_us, "COMPLETE")).await.unwrap();
    }
    for number in 1..=BOXES_PER_ROBOT {
        let event_us = 1_000_000_000 + (number + 2) * 60_000_000;
        writer.write_black_box(&lease, &one(&numbered, event_us, "PARTIAL")).await.unwrap();
        let boxes = boxes(store).await;
        let young = boxes.iter().filter(|(state, _)| state == "PARTIAL").count();
        assert_eq!((boxes.len(), young), (BOXES_PER_ROBOT as usize, number as usize));
    }

    let mut reports = Vec::new();
    let retention = Retention { contacts_days: 0, minutes_days: 0, black_boxes_days: 1, records_days: 0 };
    let now_us = 86_400_000_000 + 1_000_000_000 + 10 * 60_000_000;
    store.look_after(retention, now_us, &mut |done| reports.push(done)).await.unwrap();
    assert_eq!(reports, [Done::Removed { table: "black_boxes", rows: 7 }], "those of the minutes 3 to 9");
}

#[tokio::test]
async fn regress_boxes_are_replaced_limited_and_removed_on_sqlite() {
    boxes_are_replaced_limited_and_removed(&Fresh::sqlite().await).await;
}

#[tokio::test]
async fn regress_boxes_are_replaced_limited_and_removed_on_postgres() {
    boxes_are_replaced_limited_and_removed(&Fresh::postgres().await).await;
}

#[tokio::test]
async fn a_new_owner_marks_the_unfinished_boxes_and_the_former_one_writes_none() {
    let database = Fresh::postgres().await;
    let (mut writer, old, numbered) = taken(&database).await;
    writer.write_black_box(&old, &one(&numbered, 1_000_000_000, "COMPLETE")).await.unwrap();
    writer.write_black_box(&old, &one(&numbered, 2_000_000_000, "RECORDING")).await.unwrap();
    let (b, mut other) = (supervisor("b"), database.store.writer());
    let new = until("taken over", async || other.acquire(&b, &fleet()).await.unwrap()).await;
    other.end_black_boxes(&new).await.unwrap();
    let states = async || boxes(&database.store).await.into_iter().map(|(state, _)| state).collect::<Vec<_>>();
    assert_eq!(states().await, ["PARTIAL", "COMPLETE"]);
    let refused = writer.write_black_box(&old, &one(&numbered, 2_000_000_000, "COMPLETE")).await;
    assert!(matches!(refused, Err(StoreError::LeaseLost { .. })), "{refused:?}");
    assert_eq!(states().await, ["PARTIAL", "COMPLETE"]);
}
