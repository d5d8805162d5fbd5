//! Contacts: joined from what several drivers say, checked, and sent.

use vibrissa_protocol::{BootId, Contact, Contacts, MissedTouch, PlaceKind, decode_contacts, encode};

use super::chamber::Chamber;
use super::gauge_watch::Finding;
use super::lines::RANGES;
use super::partial::{fill_from, is_part};
use super::{Agent, Output};
use crate::contract::Now;
use crate::driver::BadLine;
use crate::driver::words::{self, cut};

const PLACES: &str = "send the place that agent.toml states for the whisker as `place`, or change it there";

impl Agent {
    /// Takes a contact, whole or a part of it.
    pub(super) fn contact(
        &mut self,
        from: usize,
        mut line: words::Contact,
        now: Now,
        out: &mut Vec<Output>,
    ) -> Result<(), BadLine> {
        let (at, mut t_us) = self.place(from, &line.origin(), now)?;
        if is_part(&line) && self.is_shared(at) {
            if line.strain.is_some()
                && let Some(point) = self.chambers[at].motion.at(t_us)
            {
                line.test_id = line.test_id.or_else(|| self.chambers[at].motion.test_at(t_us).map(str::to_owned));
                fill_from(&mut line, point);
            }
            if is_part(&line) {
                let Some(whole) = self.chambers[at].partials.join(from, line, t_us, now) else { return Ok(()) };
                (line, t_us) = whole;
            }
        }
        let taken = self.send_contact(from, at, t_us, line, now, out);
        taken.inspect_err(|bad| self.chambers[at].count_unused(&bad.problem))
    }

    pub(super) fn send_contact(
        &mut self,
        from: usize,
        at: usize,
        t_us: u64,
        mut line: words::Contact,
        now: Now,
        out: &mut Vec<Output>,
    ) -> Result<(), BadLine> {
        let test = self.test_at(line.test_id.as_deref(), Some(at))?;
        if test.is_some_and(|test| self.under_way[test].touches_left == 0) {
            return Err(BadLine::new("the touch test has all its touches", "send test_state DONE"));
        }
        line.pressure_mpa = line.pressure_mpa.map(|mpa| self.above_zero(at, mpa, out));
        let message = match line.touched {
            Some(false) => self.missed_of(line, at, t_us)?,
            Some(true) | None => self.contact_of(line, at, t_us, test.is_some())?,
        };
        // The contract's own check, so that no supervisor refuses the message.
        decode_contacts(&encode(&message), Vec::new()).map_err(|why| BadLine::new(cut(&why.to_string()), RANGES))?;
        if !self.drivers[from].contact_rate.takes(now.at) {
            let problem = format!("more than {} contacts a second", self.limits.contacts_per_s);
            return Err(BadLine::new(problem, "send fewer, or raise contacts.per_s_max in agent.toml"));
        }
        self.counts.contacts += 1;
        self.chambers[at].contact_at = Some(now.at);
        if let Some(test) = test {
            self.under_way[test].driver = Some(from);
            self.run_test(test, now, out);
            self.under_way[test].touches_left -= 1;
        }
        for contact in &message.contacts {
            let finding = self.chambers[at].gauge_watch.contact(contact.strain);
            self.warn_of_gauge(at, finding, out);
        }
        self.batch.extend(message.contacts);
        self.missed.extend(message.missed);
        if self.batch.len() + self.missed.len() >= self.limits.contacts_per_message {
            self.flush(now, out);
        } else {
            self.batch_until.get_or_insert(now.at + self.limits.message_after_us);
        }
        Ok(())
    }

    /// Description of touches that go the other way, with the remedy.
    pub(super) fn reversal(&self, at: usize) -> String {
        match self.chambers[at].sign.filter(|_| self.chambers[at].stream.is_some()) {
            None => "touches are compressions, which the supervisor cannot use: swap the two wires of the gauge, or state segmenter.sign = \"FALLS\" for \
                     the whisker, if the agent makes its contacts"
                .to_owned(),
            Some(_) => "touches move the strain against segmenter.sign, so the supervisor cannot use them: the gauge or the board was changed, so measure it \
                        anew (vibrissa-robot calibrate)"
                .to_owned(),
        }
    }

    /// Warns a person of a faulty gauge.
    pub(super) fn warn_of_gauge(&self, at: usize, finding: Option<Finding>, out: &mut Vec<Output>) {
        let Some(finding) = finding else { return };
        let Chamber { array, number, .. } = &self.chambers[at];
        let what = match finding {
            Finding::Reversed => self.reversal(at),
            Finding::Clipped(strain) => format!(
                "the strain stays at {strain} while the deflection goes on: the amplifier or the converter ends there, \
                 and the supervisor does not use such contacts; amplify less and raise the strain per volt of the board, or touch more softly"
            ),
        };
        out.push(Output::Warn(format!("whisker {array}/{number}: {what}")));
    }

    /// Gives up values that have waited in vain for those of another driver, and strain for its motion.
    pub(super) fn miss_values(&mut self, now: Now, out: &mut Vec<Output>) {
        for at in 0..self.chambers.len() {
            while let Some(part) = self.chambers[at].partials.overdue(now) {
                self.counts.contacts_unusable += 1;
                let lacking = if part.line.strain.is_none() { "strain" } else { "deflection_mm" };
                let problem = format!("no driver has said the {lacking} of a contact");
                self.chambers[at].count_unused(&problem);
                let remedy =
                    "send all values of a contact, or let another driver send the rest within 0.3 s of its time";
                self.refuse(part.from, BadLine::new(problem, remedy), now, out);
            }
            if self.chambers[at].motion.until().is_some_and(|until| until <= now.at) {
                self.join_motion(at, now, out);
            }
        }
    }

    fn contact_of(&self, line: words::Contact, at: usize, t_us: u64, is_test: bool) -> Result<Contacts, BadLine> {
        let chamber = &self.chambers[at];
        let missing =
            |name| BadLine::new(format!("missing field `{name}`"), "compare the line with docs/driver-interface.md");
        let place = match (line.ratio, line.tip, line.distance_mm) {
            (Some(_), ..) => PlaceKind::Ratio,
            (None, true, _) => PlaceKind::Tip,
            (None, false, Some(_)) => PlaceKind::Distance,
            (None, false, None) => PlaceKind::Unknown,
        };
        // A driver that divides by the length has no ratio before the first estimate, nor beyond the length. A touch test has
        // its own places.
        let lacks_length = (chamber.place, place) == (PlaceKind::Ratio, PlaceKind::Distance);
        if place != chamber.place && !lacks_length && !is_test {
            let problem = format!("the place is {place}, but agent.toml states {} for the whisker", chamber.place);
            return Err(BadLine::new(problem, PLACES));
        }
        let pressure_mpa = line.pressure_mpa.or(chamber.present_reading().map(|reading| reading.pressure_mpa));
        let contact = Contact {
            array: chamber.array.clone(),
            whisker: chamber.number,
            t_us,
            ratio: line.ratio,
            ratio_sd: line.ratio_sd,
            distance_mm: line.distance_mm,
            distance_sd_mm: line.distance_sd_mm,
            tip: line.tip,
            deflection_mm: line.deflection_mm.ok_or_else(|| missing("deflection_mm"))?,
            strain: line.strain.ok_or_else(|| missing("strain"))?,
            saturated: line.saturated,
            pressure_mpa: pressure_mpa.ok_or_else(|| {
                BadLine::new(
                    "no pressure of the whisker is known",
                    "send `pressure` before contacts, or pressure_mpa with each",
                )
            })?,
            temperature_c: line.temperature_c.or(chamber.temperature_c).unwrap_or(self.limits.temperature_c),
            angle_deg: None,
            angle_sd_deg: None,
            test_id: line.test_id,
        };
        Ok(self.alone(vec![contact], vec![]))
    }

    fn missed_of(&self, line: words::Contact, at: usize, t_us: u64) -> Result<Contacts, BadLine> {
        let chamber = &self.chambers[at];
        let distance_mm = line.distance_mm.ok_or_else(|| {
            BadLine::new(
                "a touch that did not come needs distance_mm",
                "send the distance at which it should have come",
            )
        })?;
        let missed = MissedTouch {
            array: chamber.array.clone(),
            whisker: chamber.number,
            t_us,
            distance_mm,
            distance_sd_mm: line.distance_sd_mm,
            test_id: line.test_id,
        };
        Ok(self.alone(vec![], vec![missed]))
    }

    /// A message without a number: to check a contact, or for the disk.
    pub(super) fn alone(&self, contacts: Vec<Contact>, missed: Vec<MissedTouch>) -> Contacts {
        let boot_id: BootId = self.voice.boot_id().clone();
        Contacts { boot_id, seq: 0, contacts, missed }
    }
}
