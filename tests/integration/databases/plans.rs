//! The lists that people open most read their rows from an index in the order of the page, on both databases: a page costs
//! the same for ten robots and for ten thousand.

use sqlx::{ConnectOptions, Executor};
use vibrissa_store::list::{Filter, List, Selection, Value};
use vibrissa_store::lists::actions::ACTIONS;
use vibrissa_store::lists::alarms::ALARMS;
use vibrissa_store::lists::compensations::COMPENSATIONS;
use vibrissa_store::lists::happenings::TRIMS;
use vibrissa_store::lists::notes::NOTES;
use vibrissa_store::lists::refusals::REFUSALS;
use vibrissa_store::lists::setpoints::SETPOINTS;
use vibrissa_store::lists::timeline::TIMELINE;
use vibrissa_store::lists::whiskers::WHISKERS;
use vibrissa_store::{DatabaseAddress, Store};
use vibrissa_tests::postgres::Postgres;

use crate::Fresh;

fn text(column: &'static str, value: &str) -> Vec<Filter> {
    vec![Filter::Is(column, Value::Text(value.to_owned()))]
}

/// Entries since a time.
fn recent() -> Vec<Filter> {
    vec![Filter::AtLeast("at", Value::Whole(1))]
}

type Page = (&'static List, Vec<Filter>, &'static str);

/// Pages that an index has in their order.
fn in_order() -> Vec<Page> {
    vec![
        (&SETPOINTS, Vec::new(), "setpoints_in_order"),
        (&SETPOINTS, text("state", "REJECTED"), "setpoints_by_state"),
        (&COMPENSATIONS, Vec::new(), "compensations_decided"),
        (&TRIMS, Vec::new(), "trims_in_order"),
        (&ALARMS, Vec::new(), "alarms_in_order"),
        (&ACTIONS, Vec::new(), "actions"),
    ]
}

/// Pages of the few rows that an index selects, which are then sorted.
/// PostgreSQL may take either index of the whiskers of a robot while the table is empty.
fn selected() -> Vec<Page> {
    vec![
        (&WHISKERS, vec![Filter::Is("robot_id", Value::Whole(1))], "whiskers_of_"),
        (&WHISKERS, vec![Filter::IsOneOfNumbers("robot_id", vec![1, 2, 3])], "whiskers_of_"),
        (&REFUSALS, [text("fleet", "f"), text("robot", "r")].concat(), "refusals"),
        (&NOTES, [text("fleet", "f"), text("robot", "r")].concat(), "notes_of_robot"),
        (&TIMELINE, recent(), "events_by_time"),
        (&TIMELINE, recent(), "actions_in_order"),
    ]
}

async fn they_use_an_index(store: &Store, pages: Vec<Page>) {
    for (list, filters, index) in pages {
        let what = format!("{} with {filters:?}", list.what);
        let selection = Selection { filters, ..Selection::all(list, 50) };
        let plan = store.plan(list, &selection).await.unwrap();
        assert!(plan.iter().any(|step| step.contains(index)), "{what}: {plan:#?}");
    }
}

#[tokio::test]
async fn the_lists_use_an_index_of_sqlite() {
    let fresh = Fresh::sqlite().await;
    they_use_an_index(&fresh.store, [in_order(), selected()].concat()).await;
}

#[tokio::test]
async fn the_lists_use_an_index_of_postgres() {
    let fresh = Fresh::postgres().await;
    let server = fresh.server.as_ref().unwrap();
    let mut link = server.connect().connect().await.unwrap();
    // Empty tables are read as a whole and sorted, unless that is forbidden.
    for (setting, pages) in [("enable_seqscan", selected()), ("enable_sort", in_order())] {
        link.execute(sqlx::AssertSqlSafe(format!("ALTER DATABASE vibrissa SET {setting} = off"))).await.unwrap();
        let address: DatabaseAddress = Postgres::supervisor_url(server.port()).parse().unwrap();
        they_use_an_index(&Store::open(&address, "plans").await.unwrap(), pages).await;
    }
}
