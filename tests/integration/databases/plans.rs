//! The lists that people open most read their rows from an index in the order of the page, on both databases: a page costs
//! the same for ten robots and for ten thousand.

use sqlx::{ConnectOptions, Executor};
use vibrissa_store::list::{Filter, List, Position, Selection, Value};
use vibrissa_store::lists::actions::ACTIONS;
use vibrissa_store::lists::alarms::ALARMS;
use vibrissa_store::lists::compensations::COMPENSATIONS;
use vibrissa_store::lists::contacts::CONTACTS;
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

/// A page of single contacts, and of the lengths after them: those of one whisker, in a time, and after a cursor.
fn each() -> Vec<Selection> {
    let one = Filter::Is("whisker_id", Value::Whole(1));
    let all = Selection { filters: vec![one.clone()], ..Selection::all(&CONTACTS, 50) };
    let span = vec![one, Filter::AtLeast("t_us", Value::Whole(1)), Filter::Below("t_us", Value::Whole(9))];
    let within = Selection { filters: span, ..all.clone() };
    let later = Selection { after: Some(Position { value: Value::Whole(5), id: 7 }), ..all.clone() };
    vec![all, within, later]
}

async fn contacts_use_the_index_of_whisker_and_time(store: &Store) {
    for selection in each() {
        let plan = store.plan(&CONTACTS, &selection).await.unwrap();
        let scans = plan.iter().any(|step| step.contains("of_whisker"));
        let bounds = plan.iter().any(|step| step.contains("whisker_id"));
        assert!(scans && bounds, "{selection:?}: {plan:#?}");
    }
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
    contacts_use_the_index_of_whisker_and_time(&fresh.store).await;
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
        let store = Store::open(&address, "plans").await.unwrap();
        they_use_an_index(&store, pages).await;
        contacts_use_the_index_of_whisker_and_time(&store).await;
    }
}
