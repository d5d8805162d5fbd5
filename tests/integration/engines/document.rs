//! The table in docs/brokers.md.

use std::collections::BTreeMap;
use std::path::Path;

use crate::engine::Engine;
use crate::feature::Feature;

/// Words of a cell: the feature works, or does not.
const WORDS: [&str; 2] = ["no", "yes"];

/// Whether each feature works on this engine, as docs/brokers.md states it. Footnotes may follow the word.
pub(crate) fn stated(engine: Engine) -> BTreeMap<&'static str, bool> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/brokers.md");
    let text = std::fs::read_to_string(path).unwrap();
    let rows: Vec<Vec<&str>> = text
        .lines()
        .filter(|line| line.starts_with('|'))
        .map(|line| line.trim_matches('|').split('|').map(str::trim).collect())
        .collect();
    let head = rows.iter().find(|row| row[0] == "feature").expect("a table of features");
    let column =
        head.iter().position(|title| *title == engine.title()).unwrap_or_else(|| panic!("{engine:?} in {head:?}"));
    let cell = |feature: &Feature| {
        let title = feature.title();
        let row = rows.iter().find(|row| row[0] == title).unwrap_or_else(|| panic!("docs/brokers.md lacks {title:?}"));
        let word = row[column].split(' ').next().unwrap_or_default();
        let at = WORDS.iter().position(|known| *known == word);
        (title, at.unwrap_or_else(|| panic!("{title}: {word:?} is neither yes nor no")) == 1)
    };
    Feature::EVERY.iter().map(cell).collect()
}

#[test]
fn the_table_has_a_row_for_each_feature_and_a_column_for_each_engine() {
    for engine in Engine::EVERY {
        assert_eq!(stated(engine).len(), Feature::EVERY.len());
    }
}
