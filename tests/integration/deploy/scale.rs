//! The simulation of docs/scale.md uses measured costs. `tests/release` compares its tables with those of the page.

use serde_json::{Map, Value};

use crate::project;

fn read(file: &str) -> String {
    std::fs::read_to_string(project().join(file)).unwrap_or_else(|problem| panic!("{file}: {problem}"))
}

#[test]
fn costs_of_the_simulation_are_those_of_the_documents() {
    let costs: Map<String, Value> = serde_json::from_str(&read("docs/scale/costs.json")).unwrap();
    for (name, cost) in &costs {
        let [table, after] = ["table", "after"].map(|key| cost[key].as_array().map(|texts| texts.iter().map(text)));
        let stated = match (table.map(Vec::from_iter), after.map(Vec::from_iter)) {
            (Some(place), None) => cell(&read(place[0]), place[1], place[2]).and_then(|cell| number(&cell)),
            (None, Some(place)) => after_text(&read(place[0]), place[1]),
            _ => {
                assert!(!text(&cost["assumed"]).is_empty(), "{name} has no source");
                continue;
            }
        };
        assert_eq!(stated, cost["value"].as_f64(), "{name}: the document, and costs.json: {cost}");
    }
}

fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}

/// The number that follows a text, in which lines may break anywhere.
fn after_text(document: &str, text: &str) -> Option<f64> {
    let document = document.split_whitespace().collect::<Vec<_>>().join(" ");
    document.split_once(text).and_then(|(_, rest)| number(rest))
}

/// The cell of the first table that has both the row, by its first cell, and the column, by its head.
fn cell(document: &str, row: &str, column: &str) -> Option<String> {
    let mut place = None;
    let mut was_table = false;
    for line in document.lines() {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let is_table = line.starts_with('|');
        if is_table && !was_table {
            place = cells.iter().position(|&head| head == column);
        }
        if let Some(place) = place.filter(|_| is_table && was_table && cells[1] == row) {
            return Some(cells[place].to_owned());
        }
        was_table = is_table;
    }
    None
}

/// The number at the start of a text, in which commas and underscores divide thousands.
fn number(text: &str) -> Option<f64> {
    let end = text.find(|letter: char| !letter.is_ascii_digit() && !",._".contains(letter)).unwrap_or(text.len());
    text[..end].replace([',', '_'], "").trim_end_matches('.').parse().ok()
}

#[test]
fn a_cell_is_found_by_its_row_and_the_head_of_its_column() {
    let document = "| a | b |\n| --- | --- |\n| x | 1 |\n\n| a | c |\n| --- | --- |\n| x | 2,500 us, once 3 |\n";
    assert_eq!(cell(document, "x", "c").as_deref().and_then(number), Some(2500.0));
    assert_eq!((cell(document, "x", "d"), cell(document, "y", "c")), (None, None));
    assert_eq!(["1_000;", "17 s", "2.0", "x"].map(number), [Some(1000.0), Some(17.0), Some(2.0), None]);
}
