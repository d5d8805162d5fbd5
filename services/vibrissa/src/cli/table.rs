//! Text tables for the command line.

use std::fmt;

/// A table with columns as wide as their content; numbers are aligned to the right.
#[derive(Debug)]
pub struct Table<const N: usize> {
    heads: [&'static str; N],
    rows: Vec<[String; N]>,
}

impl<const N: usize> Table<N> {
    /// A table without rows.
    #[must_use]
    pub fn new(heads: [&'static str; N]) -> Self {
        Self { heads, rows: Vec::new() }
    }

    /// Appends a row.
    pub fn row(&mut self, cells: [String; N]) {
        self.rows.push(cells);
    }
}

impl<const N: usize> fmt::Display for Table<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let widest = |column: usize| {
            let cells = self.rows.iter().map(|row| row[column].chars().count());
            cells.chain([self.heads[column].len()]).max().unwrap_or_default()
        };
        let widths: Vec<usize> = (0..N).map(widest).collect();
        let is_numeric = |column: usize| {
            let mut cells = self.rows.iter().map(|row| row[column].as_str()).filter(|cell| !matches!(*cell, "" | "-"));
            cells.clone().next().is_some()
                && cells.all(|cell| cell.starts_with(|c: char| c.is_ascii_digit() || c == '-'))
        };
        let right: Vec<bool> = (0..N).map(is_numeric).collect();
        let heads = self.heads.map(ToOwned::to_owned);
        for row in std::iter::once(&heads).chain(&self.rows) {
            let mut line = String::new();
            for (column, cell) in row.iter().enumerate() {
                let pad = " ".repeat(widths[column] - cell.chars().count());
                line += &if right[column] { format!("{pad}{cell}  ") } else { format!("{cell}{pad}  ") };
            }
            writeln!(f, "{}", line.trim_end())?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stand_to_the_right_and_nothing_trails() {
        let mut table = Table::new(["NAME", "MM"]);
        table.row(["a".to_owned(), "7.5".to_owned()]);
        table.row(["long name".to_owned(), "70.0".to_owned()]);
        table.row(["c".to_owned(), "-".to_owned()]);
        assert_eq!(table.to_string(), "NAME         MM\na           7.5\nlong name  70.0\nc             -\n");
    }
}
