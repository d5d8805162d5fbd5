//! What a segmenter makes of a scene, against the truth.

use vibrissa_segmenter::{Contact, Event, Params, Segmenter};

use super::scene::{Press, Scene, play};

/// Time after the begin, or after a gap, from which on touches count. s.
pub(crate) const GRACE_S: f64 = 10.0;

#[derive(Clone, Debug, Default)]
pub(crate) struct Verdict {
    pub(crate) hours: f64,
    pub(crate) streams: u32,
    /// At least 90 % of the touches found, nothing inverted, and no more than one false contact in ten.
    pub(crate) right: u32,
    /// With a contact of the wrong sign.
    pub(crate) inverted: u32,
    pub(crate) touches: u32,
    pub(crate) found: u32,
    pub(crate) false_contacts: u32,
    pub(crate) slips: u32,
    pub(crate) slips_found: u32,
    pub(crate) strain: Vec<f64>,
    pub(crate) onset_ms: Vec<f64>,
}

impl Verdict {
    pub(crate) fn add(&mut self, other: &Verdict) {
        self.hours += other.hours;
        self.streams += other.streams;
        self.right += other.right;
        self.inverted += other.inverted;
        self.touches += other.touches;
        self.found += other.found;
        self.false_contacts += other.false_contacts;
        self.slips += other.slips;
        self.slips_found += other.slips_found;
        self.strain.extend(&other.strain);
        self.onset_ms.extend(&other.onset_ms);
    }

    pub(crate) fn found_part(&self) -> f64 {
        f64::from(self.found) / f64::from(self.touches).max(1.0)
    }

    pub(crate) fn right_part(&self) -> f64 {
        f64::from(self.right) / f64::from(self.streams).max(1.0)
    }

    pub(crate) fn slip_part(&self) -> f64 {
        f64::from(self.slips_found) / f64::from(self.slips).max(1.0)
    }

    pub(crate) fn false_per_hour(&self) -> f64 {
        f64::from(self.false_contacts) / self.hours
    }
}

/// Runs several scenes that differ in the seed.
pub(crate) fn judge_all(scene: &Scene, params: Params, streams: u64) -> Verdict {
    let mut verdict = Verdict::default();
    for index in 0..streams {
        verdict.add(&judge(&Scene { seed: scene.seed + index, ..*scene }, params));
    }
    verdict
}

pub(crate) fn judge(scene: &Scene, params: Params) -> Verdict {
    let mut segmenter = Segmenter::new(params);
    let mut contacts: Vec<Contact> = Vec::new();
    let presses = play(scene, |sample| {
        if let Some(Event::Contact(contact)) = segmenter.push(sample) {
            contacts.push(contact);
        }
    });
    let seconds = |us: u64| us as f64 * 1e-6 - 1.0;
    let mut verdict = Verdict { hours: scene.seconds / 3_600.0, streams: 1, ..Verdict::default() };
    let gaps_s = [scene.seconds / 3.0, 2.0 * scene.seconds / 3.0];
    let counts = |press: &Press| {
        let after_gap =
            |at_s: f64| scene.gap_s > 0.0 && press.end_s() > at_s - 0.1 && press.start_s < at_s + scene.gap_s + GRACE_S;
        press.start_s > GRACE_S && press.end_s() < scene.seconds - 0.5 && !gaps_s.into_iter().any(after_gap)
    };
    let mut used = vec![false; contacts.len()];
    let mut inverted = false;
    for press in &presses {
        let is_it = |contact: &Contact| {
            seconds(contact.onset_us) < press.end_s() + 0.05 && seconds(contact.end_us) > press.start_s - 0.01
        };
        let hit = (0..contacts.len())
            .find(|index| !used[*index] && is_it(&contacts[*index]) && contacts[*index].strain.signum() == press.sign);
        let Some(index) = hit else {
            verdict.touches += u32::from(counts(press));
            continue;
        };
        used[index] = true;
        if !counts(press) {
            continue;
        }
        let contact = contacts[index];
        verdict.touches += 1;
        verdict.found += 1;
        verdict.onset_ms.push((seconds(contact.onset_us) - press.start_s).abs() * 1e3);
        if !press.is_slide() || press.slips {
            verdict.strain.push(contact.strain / press.strain() - 1.0);
        }
        verdict.slips += u32::from(press.slips);
        verdict.slips_found += u32::from(press.slips && contact.tip);
    }
    for (contact, used) in contacts.iter().zip(used) {
        let (onset_s, end_s) = (seconds(contact.onset_us), seconds(contact.end_us));
        if used
            || end_s < GRACE_S
            || gaps_s.iter().any(|at_s| end_s > *at_s && onset_s < at_s + scene.gap_s + GRACE_S && scene.gap_s > 0.0)
        {
            continue;
        }
        // What the last touch leaves at the end of the stream is not known.
        if presses.last().is_some_and(|press| onset_s > press.end_s() + 0.3) {
            continue;
        }
        verdict.false_contacts += 1;
        let against = presses.iter().filter(|press| press.start_s < end_s && press.end_s() > onset_s - 1.0);
        inverted |= against.clone().count() > 0 && against.clone().all(|press| press.sign != contact.strain.signum());
    }
    let most_false = (f64::from(verdict.found) / 10.0).max(1.0) as u32;
    verdict.inverted = u32::from(inverted);
    let right = verdict.found_part() >= 0.9 && !inverted && verdict.false_contacts <= most_false;
    verdict.right = u32::from(right || verdict.touches == 0);
    verdict
}
