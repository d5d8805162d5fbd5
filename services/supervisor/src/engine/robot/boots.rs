//! Numbers of a robot's boots in the database.

use std::collections::BTreeMap;

use vibrissa_core::text::ShortText;

/// Numbers of a robot's boots. The newest is stored inline, because nearly every message belongs to it.
#[derive(Debug, Default)]
pub(crate) struct Boots {
    newest: Option<(ShortText, i64)>,
    older: BTreeMap<String, i64>,
}

impl Boots {
    /// Number of a boot, if it has one.
    pub(crate) fn get(&self, boot_id: &str) -> Option<i64> {
        match &self.newest {
            Some((newest, boot)) if *newest == *boot_id => Some(*boot),
            Some(_) | None => self.older.get(boot_id).copied(),
        }
    }

    /// Number of the newest boot.
    pub(crate) fn newest(&self) -> Option<i64> {
        self.newest.as_ref().map(|(_, boot)| *boot)
    }

    /// Whether a boot has a number and another boot has a higher one. Such a boot does not come back.
    pub(crate) fn is_old(&self, boot_id: &str) -> bool {
        self.older.contains_key(boot_id)
    }

    /// Adds a boot, which becomes the newest.
    pub(crate) fn insert(&mut self, boot_id: &str, boot: i64) {
        if let Some((before, boot)) = self.newest.replace((boot_id.into(), boot)) {
            self.older.insert(before.as_str().to_owned(), boot);
        }
    }

    /// All boots by number.
    pub(crate) fn by_number(&self) -> BTreeMap<i64, String> {
        let newest = self.newest.iter().map(|(boot_id, boot)| (*boot, boot_id.as_str().to_owned()));
        newest.chain(self.older.iter().map(|(boot_id, &boot)| (boot, boot_id.clone()))).collect()
    }
}

/// Numbers increase, so the newest boot has the highest one.
impl From<BTreeMap<String, i64>> for Boots {
    fn from(numbers: BTreeMap<String, i64>) -> Self {
        let mut ascending: Vec<(String, i64)> = numbers.into_iter().collect();
        ascending.sort_unstable_by_key(|&(_, boot)| boot);
        let mut boots = Self::default();
        for (boot_id, boot) in &ascending {
            boots.insert(boot_id, *boot);
        }
        boots
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_boot_has_its_number_wherever_it_lies() {
        let stored = BTreeMap::from([("new".to_owned(), 9), ("old".to_owned(), 7), ("older".to_owned(), 3)]);
        let mut boots = Boots::from(stored);
        assert_eq!(boots.newest, Some(("new".into(), 9)));
        boots.insert("newest", 12);
        let known = ["newest", "new", "old", "older", "never"].map(|boot_id| boots.get(boot_id));
        assert_eq!(known, [Some(12), Some(9), Some(7), Some(3), None]);
        let old = ["newest", "new", "older", "never"].map(|boot_id| boots.is_old(boot_id));
        assert_eq!(old, [false, true, true, false]);
        assert_eq!(boots.by_number().into_keys().collect::<Vec<_>>(), [3, 7, 9, 12]);
    }
}
