//! Programs and segmenters of a robot, for people; no decision depends on them.

use std::collections::BTreeMap;

use vibrissa_protocol::{Segmenter, Software, WhiskerStatus};

/// Programs of a robot by its newest factsheet, and its segmenters by the newest status.
#[derive(Debug)]
pub(crate) struct Told {
    /// JSON list of the programs, as the robot's row has it.
    software: String,
    /// State of each whisker's segmenter, by the whisker's number in the database. Whiskers without one are absent.
    segmenters: BTreeMap<i64, Segmenter>,
}

impl Default for Told {
    fn default() -> Self {
        Self { software: "[]".to_owned(), segmenters: BTreeMap::new() }
    }
}

impl Told {
    /// From the rows of the robot and of its whiskers.
    pub(crate) fn restored<'s>(software: String, segmenters: impl Iterator<Item = (i64, &'s Option<String>)>) -> Self {
        let known =
            |(whisker_id, word): (i64, &Option<String>)| Some((whisker_id, Segmenter::from_word(word.as_deref()?)?));
        Self { software, segmenters: segmenters.filter_map(known).collect() }
    }

    /// JSON list of the programs.
    pub(crate) fn software(&self) -> &str {
        &self.software
    }

    /// State of a whisker's segmenter; `None` if the robot states none.
    pub(crate) fn segmenter(&self, whisker_id: i64) -> Option<Segmenter> {
        self.segmenters.get(&whisker_id).copied()
    }

    /// Takes the programs of a factsheet. Returns whether they are others than before.
    pub(crate) fn take_software(&mut self, software: &[Software]) -> bool {
        let Ok(text) = serde_json::to_string(software) else { return false };
        let is_other = text != self.software;
        self.software = text;
        is_other
    }

    /// Takes the segmenters of a status. `id_of` is the number of an entry's whisker, if the robot has it.
    pub(crate) fn take_segmenters(&mut self, entries: &[WhiskerStatus], id_of: impl Fn(&WhiskerStatus) -> Option<i64>) {
        for entry in entries {
            // Most robots state none.
            if entry.segmenter.is_none() && self.segmenters.is_empty() {
                continue;
            }
            match (id_of(entry), entry.segmenter) {
                (Some(whisker_id), Some(segmenter)) => self.segmenters.insert(whisker_id, segmenter),
                (Some(whisker_id), None) => self.segmenters.remove(&whisker_id),
                (None, _) => None,
            };
        }
    }

    /// Forgets the segmenters of whiskers that are not on the robot any more.
    pub(crate) fn keep_only(&mut self, whisker_ids: &[i64]) {
        self.segmenters.retain(|whisker_id, _| whisker_ids.contains(whisker_id));
    }
}
