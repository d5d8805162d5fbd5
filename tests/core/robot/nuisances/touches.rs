//! A robot that does touch tests on request: it presses a whisker against a wall at distances that it knows to 0.5 mm, or sweeps it up to
//! its tip.

use super::rig::{ARRAY, BOOT, Rig, Tests};
use rand_distr::{Distribution, StandardNormal};
use vibrissa_core::robot::Event;
use vibrissa_core::robot::effect::{TestKind, TouchTest};
use vibrissa_core::robot::event::{Contact, ContactPlace, Distance, MissedTouch, Rejection, TestReport};
use vibrissa_core::units::Millimetre;

/// Standard deviation of the robot's distances, mm.
const SD_MM: f64 = 0.5;

impl Rig {
    pub(super) fn answer(&mut self, test: &TouchTest) {
        let report = match self.tests {
            Tests::NotOffered | Tests::Ignores => return,
            Tests::Rejects => TestReport::Rejected(Rejection::OutOfRange),
            Tests::Empty => TestReport::Done,
            Tests::Does | Tests::Sweeps => {
                self.touch(test);
                TestReport::Done
            }
        };
        self.step(&Event::TouchTest { boot_id: BOOT, test: test.key, report, robot_time: self.now() });
    }

    fn touch(&mut self, test: &TouchTest) {
        let (mut contacts, mut missed) = (Vec::new(), Vec::new());
        let length_mm = self.whiskers[test.whisker].length_mm;
        for turn in 0..usize::from(test.contacts) {
            let off: f64 = StandardNormal.sample(&mut self.random);
            if test.kind == TestKind::Tip {
                let at = Millimetre::known(length_mm - self.off_mm + SD_MM * off);
                let contact = self.contact_at(test.whisker, Some(1.0));
                let place = ContactPlace::Tip(Some(Distance { at, sd_mm: SD_MM }));
                contacts.push(Contact { place, is_test: true, ..contact });
                continue;
            }
            let stated_mm = test.distances_mm[turn % test.distances_mm.len()];
            let at = Distance { at: Millimetre::known(stated_mm), sd_mm: SD_MM };
            let ratio = (stated_mm + self.off_mm + SD_MM * off) / length_mm;
            if ratio <= 1.0 {
                let contact = self.contact_at(test.whisker, Some(ratio));
                contacts.push(Contact { place: ContactPlace::Distance(at), is_test: true, ..contact });
            } else {
                missed.push(MissedTouch { array: ARRAY, whisker: test.whisker as u16, robot_time: self.now(), at });
            }
        }
        let seq = self.rounds;
        self.rounds += 1;
        self.step(&Event::Contacts { boot_id: BOOT, seq, contacts: &contacts, missed: &missed });
    }
}
