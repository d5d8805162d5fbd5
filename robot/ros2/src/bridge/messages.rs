//! Messages of ROS as lines for the agent.

use ros2_client::builtin_interfaces::Time;

use super::{Bridge, Output};
use crate::lines::{contact_line, span_us, states_of, strain_line};
use crate::messages::{Contact, Fault, FluidPressure, Header, Strain};
use crate::stamps::{Stamp, judge};
use crate::touch::Progress;
use crate::words::ToAgent;

impl Bridge {
    /// The time of a message for the agent; `None` if the time of receipt counts.
    fn time(&mut self, now: Time, header: &Header, extra_us: i64) -> Option<u64> {
        self.time_of(now, header.stamp, extra_us)
    }

    /// The time that a stamp tells; `None` if the time of receipt counts.
    pub(super) fn time_of(&mut self, now: Time, stamp: Time, extra_us: i64) -> Option<u64> {
        match judge(stamp, now, extra_us) {
            Stamp::Good(t_us) => return Some(t_us),
            Stamp::Unset => self.counts.unstamped += 1,
            Stamp::Implausible => self.counts.misstamped += 1,
        }
        None
    }

    pub(super) fn contact(&mut self, now: Time, contact: Result<Contact, String>) -> Result<Vec<Output>, String> {
        let contact = contact.map_err(|problem| {
            format!("an unreadable contact: {problem}; are the vibrissa_msgs of this version built?")
        })?;
        Ok(vec![self.contact_of(now, 0, contact)?])
    }

    fn contact_of(&mut self, now: Time, extra_us: i64, contact: Contact) -> Result<Output, String> {
        self.find(&contact.array, contact.whisker)?;
        let t_us = self.time(now, &contact.header, extra_us);
        let line = contact_line(contact, t_us)?;
        self.counts.contacts += 1;
        Ok(Output::Line(ToAgent::Contact(line)))
    }

    pub(super) fn pressure(
        &mut self,
        now_s: f64,
        now: Time,
        index: usize,
        reading: Result<FluidPressure, String>,
    ) -> Result<Vec<Output>, String> {
        let reading = reading.map_err(|problem| format!("an unreadable pressure: {problem}"))?;
        let t_us = self.time(now, &reading.header, 0);
        let whisker = self.whiskers.get_mut(index).ok_or("a pressure of an unknown whisker")?;
        let pressure_mpa = self.settings.pressures.gauge_mpa(reading.fluid_pressure);
        let pressure_mpa = pressure_mpa.map_err(|problem| format!("{}: {problem}", whisker.name()))?;
        self.counts.pressures += 1;
        Ok(whisker.read(now_s, t_us, pressure_mpa).map(Output::Line).into_iter().collect())
    }

    pub(super) fn strain(
        &mut self,
        now: Time,
        index: usize,
        samples: Result<Strain, String>,
    ) -> Result<Vec<Output>, String> {
        let samples = samples.map_err(|problem| format!("an unreadable message of strain: {problem}"))?;
        let whisker = self.whiskers.get(index).ok_or("strain of an unknown whisker")?.named().clone();
        let name = format!("{}/{}", whisker.array, whisker.whisker);
        let span_us = i64::from(span_us(&name, &samples)?);
        let t_us = self.time(now, &samples.header, span_us);
        // The last sample has been taken now.
        let begun_us = u64::try_from(now.to_nanos() / 1000 - span_us).unwrap_or_default();
        let line = strain_line(&whisker, samples, t_us.unwrap_or(begun_us))?;
        self.counts.strains += 1;
        Ok(vec![Output::Line(ToAgent::Strain(line))])
    }

    pub(super) fn fault(&mut self, fault: Result<Fault, String>) -> Result<Vec<Output>, String> {
        let fault = fault.map_err(|problem| format!("an unreadable fault: {problem}"))?;
        let index = self.find(&fault.array, fault.whisker)?;
        let states = states_of(&fault)?;
        Ok(vec![Output::Line(self.whiskers[index].report(states))])
    }

    pub(super) fn test(&mut self, now: Time, test_id: &str, progress: Progress) -> Vec<Output> {
        let state = |state: &'static str| Output::Line(ToAgent::TestState { test_id: test_id.to_owned(), state });
        match progress {
            Progress::Running => vec![state("RUNNING")],
            Progress::Failed(problem) => {
                let problem = format!("the touch test {test_id:.64} has failed: {problem}");
                vec![self.refuse(problem), state("FAILED")]
            }
            Progress::Done { contacts, took_s } => {
                // A contact of a long test may be as old as the test.
                let extra_us = (took_s * 1e6) as i64;
                let mut outputs = Vec::new();
                for contact in contacts {
                    let contact = Contact { test_id: test_id.to_owned(), ..contact };
                    let output = self.contact_of(now, extra_us, contact);
                    outputs.push(output.unwrap_or_else(|problem| self.refuse(problem)));
                }
                outputs.push(state("DONE"));
                outputs
            }
        }
    }
}
