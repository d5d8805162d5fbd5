//! Writes `docs/schema.md`: the meanings of tables and columns, from the texts beside this file, with their types from a
//! migrated database and their retention from [`TABLES`].
//!
//! A text has a part for each table: a heading, a description, and an entry `- `column`: meaning` for each column, or for
//! several columns of one type. `{Condition}` stands for all words of that enum.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use sqlx::sqlite::{SqlitePool, SqlitePoolOptions};
use vibrissa_core::mechanics::Objective;
use vibrissa_core::policy::{Case, LongerForShorter, Mode, Refused};
use vibrissa_core::robot::effect::{
    AlarmKind, CommandState, Condition, ContactUse, EndReason, Fault, Origin, Reason, RefinementOutcome, TestKind,
    TestReason, TestState,
};
use vibrissa_core::robot::event::{ArrayKind, Link, Rejection};
use vibrissa_core::rollout::Stage;
use vibrissa_edge::actions::{ActionKind, RecordedKind};
use vibrissa_edge::events::{Audience, EventKind};
use vibrissa_edge::guidance::Level;
use vibrissa_edge::words::{Word, Words};
use vibrissa_protocol::Segmenter;

use crate::database::Pool;
use crate::retention::tables::{Kept, TABLES};

const INTRODUCTION: &str = include_str!("introduction.md");

/// The subjects in the order of the document.
const SUBJECTS: [(&str, &str); 5] = [
    ("Robots and whiskers", include_str!("robots.md")),
    ("Contacts and their history", include_str!("contacts.md")),
    ("Decisions", include_str!("decisions.md")),
    ("Operators", include_str!("operators.md")),
    ("Operation of the service", include_str!("service.md")),
];

/// Longest line of the document, except rows of its tables.
const WIDTH: usize = 120;

/// A table of the texts.
struct Table {
    name: String,
    description: String,
    entries: Vec<Entry>,
}

/// Columns with one meaning.
struct Entry {
    columns: Vec<String>,
    meaning: String,
}

/// Type of each column, by table and column.
type Types = BTreeMap<String, BTreeMap<String, String>>;

fn tables_of(text: &str) -> Vec<Table> {
    text.split("## ").filter(|part| !part.trim().is_empty()).map(table_of).collect()
}

fn table_of(part: &str) -> Table {
    let (name, rest) = part.split_once('\n').unwrap();
    let (description, entries) = rest.split_once("\n\n").unwrap();
    let one_line = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let entries = format!("\n{entries}").split("\n- ").skip(1).map(|entry| entry_of(&one_line(entry))).collect();
    Table { name: name.to_owned(), description: one_line(description), entries }
}

fn entry_of(line: &str) -> Entry {
    let (columns, meaning) = line.split_once(": ").unwrap_or_else(|| panic!("no meaning: {line}"));
    let columns = columns.split(", ").map(|column| column.trim_matches('`').to_owned()).collect();
    Entry { columns, meaning: meaning.to_owned() }
}

fn words_of<T: Words>() -> (&'static str, Vec<&'static str>) {
    (T::NAME, T::all().into_iter().map(Word::word).collect())
}

/// Replaces each `{Enum}` by the words of the enum.
fn with_words(meaning: &str) -> String {
    let all = [
        words_of::<ActionKind>(),
        words_of::<AlarmKind>(),
        words_of::<ArrayKind>(),
        words_of::<Audience>(),
        words_of::<Case>(),
        words_of::<CommandState>(),
        words_of::<Condition>(),
        words_of::<ContactUse>(),
        words_of::<EndReason>(),
        words_of::<EventKind>(),
        words_of::<Fault>(),
        words_of::<Level>(),
        words_of::<Link>(),
        words_of::<LongerForShorter>(),
        words_of::<Mode>(),
        words_of::<Objective>(),
        words_of::<Origin>(),
        words_of::<Reason>(),
        words_of::<RecordedKind>(),
        words_of::<RefinementOutcome>(),
        words_of::<Refused>(),
        words_of::<Rejection>(),
        words_of::<Segmenter>(),
        words_of::<Stage>(),
        words_of::<TestKind>(),
        words_of::<TestReason>(),
        words_of::<TestState>(),
    ];
    let mut text = meaning.to_owned();
    for (name, words) in all {
        let words: Vec<String> = words.into_iter().map(|word| format!("`{word}`")).collect();
        text = text.replace(&format!("{{{name}}}"), &words.join(", "));
    }
    assert!(!text.contains('{'), "an enum without words: {text}");
    text
}

/// The sentence about the removal of a table's rows.
fn removal(table: &str) -> String {
    match TABLES.iter().find(|(name, _)| *name == table).map(|(_, kept)| kept) {
        Some(Kept::Days(setting)) => format!("Rows are removed after the days of the setting `{setting}`."),
        Some(Kept::Until(then)) => format!("Rows are removed {then}."),
        Some(Kept::For(bound)) => format!("Rows have no time limit; bound of their number: {bound}."),
        None => "Rows have no time limit.".to_owned(),
    }
}

/// The text in lines of at most [`WIDTH`] characters, the later ones behind `indent`.
fn wrapped(text: &str, indent: &str) -> String {
    let (mut lines, mut line) = (Vec::new(), String::new());
    for word in text.split(' ') {
        if line.is_empty() {
            line = word.to_owned();
        } else if line.chars().count() + 1 + word.chars().count() <= WIDTH {
            line = format!("{line} {word}");
        } else {
            lines.push(std::mem::replace(&mut line, format!("{indent}{word}")));
        }
    }
    lines.push(line);
    lines.join("\n")
}

/// The document; `types` are those of the database.
fn document(types: &Types) -> String {
    let mut text = format!("{INTRODUCTION}\n## Tables\n");
    for (subject, tables) in SUBJECTS {
        let names: Vec<String> =
            tables_of(tables).into_iter().map(|table| format!("[{0}](#{0})", table.name)).collect();
        let _ = writeln!(text, "{}", wrapped(&format!("- {subject}: {}", names.join(", ")), "  "));
    }
    for (subject, tables) in SUBJECTS {
        let _ = writeln!(text, "\n## {subject}");
        for table in tables_of(tables) {
            let Table { name, description, entries } = &table;
            let description = format!("{} {}", with_words(description), removal(name));
            let _ = writeln!(text, "\n### {name}\n{}\n", wrapped(&description, ""));
            let _ = writeln!(text, "| column | type | meaning |\n| --- | --- | --- |");
            for Entry { columns, meaning } in entries {
                // A column that the database does not have fails the other test.
                let kind_of =
                    |column| types.get(name).and_then(|columns| columns.get(column)).map_or("", String::as_str);
                let kinds: BTreeSet<&str> = columns.iter().map(kind_of).collect();
                assert_eq!(kinds.len(), 1, "{name}: {columns:?} have several types, so they need several entries");
                let kind = kinds.first().copied().unwrap_or_default();
                let names: Vec<String> = columns.iter().map(|column| format!("`{column}`")).collect();
                let _ = writeln!(text, "| {} | {kind} | {} |", names.join(", "), with_words(meaning));
            }
        }
    }
    text
}

async fn migrated() -> SqlitePool {
    // Each connection to `:memory:` has a database of its own.
    let pool = SqlitePoolOptions::new().max_connections(1).connect("sqlite::memory:").await.unwrap();
    Pool::Sqlite(pool.clone()).migrate("in memory").await.unwrap();
    pool
}

/// Types of all columns. SQLite's own tables are left out.
async fn types_of(pool: &SqlitePool) -> Types {
    const SQL: &str = "SELECT m.name, p.name, p.type || CASE WHEN p.pk > 0 THEN ', key' WHEN p.\"notnull\" THEN '' \
         ELSE ', NULL' END || coalesce((SELECT ' → ' || f.\"table\" FROM pragma_foreign_key_list(m.name) f \
         WHERE f.\"from\" = p.name), '') FROM sqlite_master m JOIN pragma_table_info(m.name) p \
         WHERE m.type = 'table' AND m.name NOT LIKE 'sqlite\\_%' ESCAPE '\\'";
    let rows: Vec<(String, String, String)> = sqlx::query_as(SQL).fetch_all(pool).await.unwrap();
    let mut types = Types::new();
    for (table, column, kind) in rows {
        types.entry(table).or_default().insert(column, kind);
    }
    types
}

#[tokio::test]
async fn each_table_and_column_has_one_meaning_and_each_meaning_a_column() {
    let columns = types_of(&migrated().await).await.into_iter();
    let mut there: Vec<(String, String)> =
        columns.flat_map(|(table, columns)| columns.into_keys().map(move |column| (table.clone(), column))).collect();
    let tables = SUBJECTS.iter().flat_map(|(_, text)| tables_of(text));
    let mut meant: Vec<(String, String)> = tables
        .flat_map(|Table { name, entries, .. }| {
            entries.into_iter().flat_map(|entry| entry.columns).map(move |column| (name.clone(), column))
        })
        .collect();
    there.sort();
    meant.sort();
    let only = |some: &[(String, String)], others: &[(String, String)]| -> Vec<String> {
        let only = some.iter().filter(|one| !others.contains(one));
        only.map(|(table, column)| format!("{table}.{column}")).collect()
    };
    assert_eq!(only(&there, &meant), [""; 0], "without a meaning in services/store/src/schema");
    assert_eq!(only(&meant, &there), [""; 0], "in services/store/src/schema, and not in the database");
    assert_eq!(there, meant, "a column has two meanings");
}

#[tokio::test]
async fn the_document_says_what_the_tables_mean() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/schema.md");
    let text = document(&types_of(&migrated().await).await);
    if std::env::var_os("VIBRISSA_WRITE_DOCS").is_some() {
        std::fs::write(path, &text).unwrap();
    }
    let written = std::fs::read_to_string(path).unwrap_or_default();
    assert!(written == text, "docs/schema.md is out of date: VIBRISSA_WRITE_DOCS=1 writes it again");
}
