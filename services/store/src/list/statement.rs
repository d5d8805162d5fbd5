//! The statement that reads a page of a list.

use std::sync::LazyLock;

use sqlx::{Database, Encode, QueryBuilder, Type};

use vibrissa_core::robot::effect::AlarmKind;
use vibrissa_edge::guidance::{BY_URGENCY, urgency};
use vibrissa_edge::words::Word;

use super::filter::{push_filters, push_value};
use super::{Filter, Keys, List, Selection};

/// The place of conditions within a query.
const FILTERS: &str = "{filters}";

/// Appends a query, with conditions at the place that it has for them.
pub(crate) fn push_select<DB: Database>(sql: &mut QueryBuilder<DB>, select: &str, filters: &[Filter])
where
    i64: for<'q> Encode<'q, DB> + Type<DB>,
    f64: for<'q> Encode<'q, DB> + Type<DB>,
    bool: for<'q> Encode<'q, DB> + Type<DB>,
    String: for<'q> Encode<'q, DB> + Type<DB>,
{
    // A number of this process, not of a client: whether times lie ahead is judged by this supervisor's clock.
    let now_us = vibrissa_edge::clock::wall_clock().0;
    let select = select.replace("{now_us}", &now_us.to_string()).replace("{urgency}", &URGENCY);
    match select.split_once(FILTERS) {
        None => drop(sql.push(select)),
        Some((before, after)) => {
            sql.push(before);
            push_filters(sql, filters);
            sql.push(after);
        }
    }
}

/// The place of the column `kind` in the order of alarms: greater is more urgent, and 0 is no kind of this program.
static URGENCY: LazyLock<String> = LazyLock::new(|| {
    let case = |kind: AlarmKind| format!(" WHEN '{}' THEN {}", kind.word(), urgency(kind));
    format!("CAST(CASE kind{} ELSE 0 END AS BIGINT)", BY_URGENCY.map(case).concat())
});

/// The statement of a selection after a text, which is empty or asks for the plan; it asks for one row more than the limit, to learn whether there is a next page.
pub(super) fn statement<DB: Database>(list: &List, selection: &Selection, before: &str) -> QueryBuilder<DB>
where
    i64: for<'q> Encode<'q, DB> + Type<DB>,
    f64: for<'q> Encode<'q, DB> + Type<DB>,
    bool: for<'q> Encode<'q, DB> + Type<DB>,
    String: for<'q> Encode<'q, DB> + Type<DB>,
{
    let (sort, id) = (selection.sort.column, list.id);
    let way = if selection.descending { "DESC" } else { "ASC" };
    let order = format!(" ORDER BY {sort} {way}, {id} {way}");
    let mut sql = QueryBuilder::<DB>::new(format!("{before}SELECT q.*"));
    sql.push(list.details).push(" FROM (SELECT * FROM (");
    match list.keys.iter().find(|keys| chooses(keys, selection)) {
        None => {
            push_select(&mut sql, list.select, &selection.filters);
            let is_filtered = list.select.contains(FILTERS);
            push_page(&mut sql, list, selection, if is_filtered { &[] } else { &selection.filters }, &order);
        }
        Some(keys) => {
            push_select(&mut sql, list.select, &[]);
            sql.push(") q WHERE ").push(id).push(" IN (SELECT ").push(id).push(" FROM (").push(keys.select);
            push_page(&mut sql, list, selection, &selection.filters, &order);
            sql.push(")");
        }
    }
    sql.push(") q").push(&order);
    sql
}

/// Whether a query of keys has all columns that choose the rows.
fn chooses(keys: &Keys, selection: &Selection) -> bool {
    keys.columns.contains(&selection.sort.column)
        && selection.filters.iter().all(|filter| filter.reads_only(keys.columns))
}

/// Appends the end of a subquery: its conditions, order and limit.
fn push_page<DB: Database>(
    sql: &mut QueryBuilder<DB>,
    list: &List,
    selection: &Selection,
    filters: &[Filter],
    order: &str,
) where
    i64: for<'q> Encode<'q, DB> + Type<DB>,
    f64: for<'q> Encode<'q, DB> + Type<DB>,
    bool: for<'q> Encode<'q, DB> + Type<DB>,
    String: for<'q> Encode<'q, DB> + Type<DB>,
{
    sql.push(") q WHERE true");
    push_filters(sql, filters);
    if let Some(position) = &selection.after {
        let after = if selection.descending { ") < (" } else { ") > (" };
        sql.push(" AND (").push(selection.sort.column).push(", ").push(list.id).push(after);
        push_value(sql, &position.value);
        sql.push(", ").push_bind(position.id).push(")");
    }
    sql.push(order).push(" LIMIT ").push_bind(i64::from(selection.limit) + 1);
}
