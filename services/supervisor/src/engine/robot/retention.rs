//! Retention of contacts: which get a row of their own, and which only count in the aggregates of minutes and hours.
//!
//! Deduplication does not depend on the table of contacts but on the robot's state: receipts are the same under every
//! policy.

use std::collections::VecDeque;

use vibrissa_store::batch::ContactRow;

/// Which contacts get a row of their own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ContactRetention {
    /// All contacts.
    #[default]
    All,
    /// The last contacts before a finding or decision, and those of compensators.
    Decisions,
    /// No contacts.
    None,
}

/// Number of contacts remembered per whisker until a decision: a suspicion is raised after about five contacts, and
/// confirmed or dismissed within about ten more.
pub(crate) const REMEMBERED: usize = 32;

/// Applies the policy to the whiskers of one robot. The remembered contacts are not stored: after a restart there are
/// none.
#[derive(Debug)]
pub(crate) struct ContactFilter {
    retention: ContactRetention,
    /// Contacts by whisker index, the newest last, without those already given out. Empty unless the policy needs them.
    rings: Vec<VecDeque<ContactRow>>,
    /// Whisker of the last contact.
    last: Option<usize>,
}

impl ContactFilter {
    /// Applies a policy to a new robot.
    #[must_use]
    pub(crate) fn new(retention: ContactRetention) -> Self {
        Self { retention, rings: Vec::new(), last: None }
    }

    /// Adds a contact; contacts to keep are appended to `rows`.
    pub(crate) fn add_contact(&mut self, whisker: usize, row: ContactRow, rows: &mut Vec<ContactRow>) {
        match self.retention {
            ContactRetention::All => rows.push(row),
            ContactRetention::None => {}
            ContactRetention::Decisions => {
                if self.rings.len() <= whisker {
                    self.rings.resize_with(whisker + 1, VecDeque::new);
                }
                let ring = &mut self.rings[whisker];
                if ring.len() == REMEMBERED {
                    ring.pop_front();
                }
                ring.push_back(row);
                self.last = Some(whisker);
            }
        }
    }

    /// Keeps the last contact, which is one of a compensator.
    pub(crate) fn keep_last(&mut self, rows: &mut Vec<ContactRow>) {
        let ring = self.last.take().and_then(|whisker| self.rings.get_mut(whisker));
        rows.extend(ring.and_then(VecDeque::pop_back));
    }

    /// Keeps the last contacts of a whisker, because a finding or decision was made about it.
    pub(crate) fn keep_recent(&mut self, whisker: usize, rows: &mut Vec<ContactRow>) {
        if let Some(ring) = self.rings.get_mut(whisker) {
            rows.extend(ring.drain(..));
        }
    }

    /// Applies a new layout: `from` has the former index of each whisker that was there before.
    pub(crate) fn laid_out(&mut self, from: &[Option<usize>]) {
        let mut before = std::mem::take(&mut self.rings);
        if !before.is_empty() {
            let mut ring = |was: &Option<usize>| was.and_then(|was| before.get_mut(was)).map(std::mem::take);
            self.rings = from.iter().map(|was| ring(was).unwrap_or_default()).collect();
        }
        self.last = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(whisker: usize, seq: i64) -> ContactRow {
        ContactRow {
            whisker_id: whisker as i64,
            boot: 1,
            seq,
            position: 0,
            t_us: seq,
            received_us: seq,
            place: "RATIO",
            ratio: Some(0.85),
            distance_mm: None,
            deflection_mm: 2.0,
            strain: 0.01,
            pressure_mpa: 0.1,
            temperature_c: 24.0,
            used: "USED",
            residual: None,
            length_mm: 70.0,
            length_sd_mm: 0.2,
        }
    }

    fn seqs(rows: &[ContactRow]) -> Vec<i64> {
        rows.iter().map(|row| row.seq).collect()
    }

    #[test]
    fn all_and_none_are_what_they_say() {
        for (keep, kept) in [(ContactRetention::All, vec![0, 1, 2]), (ContactRetention::None, vec![])] {
            let (mut filter, mut rows) = (ContactFilter::new(keep), Vec::new());
            for seq in 0..3 {
                filter.add_contact(0, row(0, seq), &mut rows);
                filter.keep_last(&mut rows);
            }
            filter.keep_recent(0, &mut rows);
            assert_eq!(seqs(&rows), kept);
            assert!(filter.rings.is_empty(), "no contacts are remembered");
        }
    }

    #[test]
    fn the_last_contacts_before_a_decision_are_kept() {
        let (mut filter, mut rows) = (ContactFilter::new(ContactRetention::Decisions), Vec::new());
        for seq in 0..100 {
            filter.add_contact(usize::from(seq % 2 == 1), row(0, seq), &mut rows);
        }
        assert!(rows.is_empty());
        filter.keep_recent(1, &mut rows);
        let odd: Vec<i64> = (0..100).filter(|seq| seq % 2 == 1).collect();
        assert_eq!(seqs(&rows), odd[odd.len() - REMEMBERED..]);
        rows.clear();
        filter.keep_recent(1, &mut rows);
        filter.keep_recent(9, &mut rows);
        assert!(rows.is_empty(), "none twice, and none of a whisker without contacts");
    }

    #[test]
    fn what_is_remembered_takes_what_the_sizing_says() {
        assert_eq!(size_of::<ContactRow>(), 176);
    }

    #[test]
    fn what_serves_is_kept_once() {
        let (mut filter, mut rows) = (ContactFilter::new(ContactRetention::Decisions), Vec::new());
        filter.add_contact(0, row(0, 0), &mut rows);
        filter.add_contact(0, row(0, 1), &mut rows);
        filter.keep_last(&mut rows);
        filter.keep_last(&mut rows);
        assert_eq!(seqs(&rows), [1]);
        filter.keep_recent(0, &mut rows);
        assert_eq!(seqs(&rows), [1, 0]);
        // A contact kept by a decision is not kept again as the last one.
        filter.add_contact(0, row(0, 2), &mut rows);
        filter.keep_recent(0, &mut rows);
        filter.keep_last(&mut rows);
        assert_eq!(seqs(&rows), [1, 0, 2]);
    }

    #[test]
    fn property_no_contact_is_kept_twice() {
        let (mut filter, mut rows) = (ContactFilter::new(ContactRetention::Decisions), Vec::new());
        let mut noise: u64 = 1;
        for seq in 0..20_000 {
            noise = noise.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let whisker = (noise >> 33) as usize % 5;
            match (noise >> 40) % 8 {
                0 => filter.keep_recent(whisker, &mut rows),
                1 => filter.keep_last(&mut rows),
                2 if seq % 50 == 0 => filter.laid_out(&[Some(1), None, Some(0), Some(4), Some(2)]),
                _ => filter.add_contact(whisker, row(whisker, seq), &mut rows),
            }
        }
        let mut kept = seqs(&rows);
        assert!(kept.len() > 5000);
        kept.sort_unstable();
        kept.dedup();
        assert_eq!(kept.len(), rows.len());
    }

    #[test]
    fn another_layout_takes_what_is_remembered_along() {
        let (mut filter, mut rows) = (ContactFilter::new(ContactRetention::Decisions), Vec::new());
        for whisker in 0..3 {
            filter.add_contact(whisker, row(whisker, whisker as i64), &mut rows);
        }
        filter.laid_out(&[Some(2), None, Some(0)]);
        for whisker in 0..3 {
            filter.keep_recent(whisker, &mut rows);
        }
        assert_eq!(seqs(&rows), [2, 0]);
    }
}
