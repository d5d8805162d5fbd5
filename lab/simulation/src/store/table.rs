//! Tables whose changes can be undone.

use std::collections::BTreeMap;
use std::ops::RangeBounds;

/// Something that takes part in transactions. They may be nested.
pub(super) trait Undo {
    fn begin(&mut self);
    fn end(&mut self, is_kept: bool);
}

/// Rows by their key.
#[derive(Debug, Clone)]
pub(super) struct Table<K, V> {
    rows: BTreeMap<K, V>,
    /// The former rows of the open transactions.
    former: Vec<(K, Option<V>)>,
    /// Lengths of `former` at the begins of the open transactions.
    begins: Vec<usize>,
}

impl<K, V> Default for Table<K, V> {
    fn default() -> Self {
        Self { rows: BTreeMap::new(), former: Vec::new(), begins: Vec::new() }
    }
}

impl<K: Ord + Clone, V: Clone> Table<K, V> {
    pub(super) fn get(&self, key: &K) -> Option<&V> {
        self.rows.get(key)
    }

    pub(super) fn has(&self, key: &K) -> bool {
        self.rows.contains_key(key)
    }

    pub(super) fn iter(&self) -> impl DoubleEndedIterator<Item = (&K, &V)> {
        self.rows.iter()
    }

    pub(super) fn range(&self, range: impl RangeBounds<K>) -> impl DoubleEndedIterator<Item = (&K, &V)> {
        self.rows.range(range)
    }

    /// Keys of the rows that are meant.
    pub(super) fn keys_of(&self, is_meant: impl Fn(&K, &V) -> bool) -> Vec<K> {
        self.rows.iter().filter(|(key, row)| is_meant(key, row)).map(|(key, _)| key.clone()).collect()
    }

    pub(super) fn set(&mut self, key: K, row: V) {
        let former = self.rows.insert(key.clone(), row);
        self.note(key, former);
    }

    pub(super) fn remove(&mut self, key: &K) {
        let former = self.rows.remove(key);
        self.note(key.clone(), former);
    }

    /// Changes a row, if it exists.
    pub(super) fn change(&mut self, key: &K, change: impl FnOnce(&mut V)) {
        if let Some(row) = self.rows.get_mut(key) {
            let former = row.clone();
            change(row);
            self.note(key.clone(), Some(former));
        }
    }

    fn note(&mut self, key: K, former: Option<V>) {
        if !self.begins.is_empty() {
            self.former.push((key, former));
        }
    }
}

impl<K: Ord, V> Undo for Table<K, V> {
    fn begin(&mut self) {
        self.begins.push(self.former.len());
    }

    fn end(&mut self, is_kept: bool) {
        let begin = self.begins.pop().unwrap_or_default();
        if !is_kept {
            for (key, former) in self.former.drain(begin..).rev() {
                match former {
                    Some(row) => self.rows.insert(key, row),
                    None => self.rows.remove(&key),
                };
            }
        }
        if self.begins.is_empty() {
            self.former.clear();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_of_a_transaction_is_undone_alone() {
        let mut table = Table::default();
        table.set(1, "a");
        table.begin();
        table.set(2, "b");
        table.begin();
        table.change(&1, |row| *row = "c");
        table.remove(&2);
        table.set(3, "d");
        table.end(false);
        assert_eq!(table.iter().collect::<Vec<_>>(), [(&1, &"a"), (&2, &"b")]);
        table.end(true);
        table.begin();
        table.remove(&1);
        table.end(false);
        assert_eq!(table.iter().collect::<Vec<_>>(), [(&1, &"a"), (&2, &"b")]);
    }
}
