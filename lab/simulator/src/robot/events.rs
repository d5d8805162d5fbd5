//! Applies the events of the scenario to a robot.

use vibrissa_protocol::Name;
use vibrissa_robot::contract::{Commands, EstimateOrder, TouchTests, Voice};

use super::{Outgoing, Robot, boot_id};
use crate::link::FaultKind;
use crate::plant::GaugeCondition;
use crate::scenario::{BadScenario, Change, Event, Misbehaviour};

impl Robot {
    /// Sorts the scenario's events by their triggers.
    pub(super) fn plan_events(&mut self) {
        let mut timed = Vec::new();
        for event in self.config.robot.events.clone() {
            match (event.at_contact, self.place(&event)) {
                (Some(contact), Some(at)) => self.whiskers[at].events.push_back((contact, event.change)),
                (_, _) => {
                    let after_us = (event.at_s.unwrap_or(0.0) * 1e6) as u64;
                    timed.push((self.start_us + after_us, event));
                }
            }
        }
        // The sort is stable: of simultaneous events, the first one in the scenario comes first.
        timed.sort_by_key(|&(at_us, _)| at_us);
        self.events = timed.into();
        for whisker in &mut self.whiskers {
            whisker.events.make_contiguous().sort_by_key(|&(contact, _)| contact);
        }
    }

    /// Index of the whisker of an event, if it has one.
    fn place(&self, event: &Event) -> Option<usize> {
        self.places.get(&(event.array.clone()?, event.whisker?)).copied()
    }

    /// Applies the events that are due before a whisker's next contact.
    pub(super) fn happen_by_contact(&mut self, at: usize, at_us: u64) {
        while let Some(whisker) = self.whiskers.get_mut(at) {
            match whisker.events.front() {
                Some(&(contact, change)) if contact <= whisker.plant.contacts() => {
                    whisker.events.pop_front();
                    self.happen_to_whisker(at, change, at_us);
                }
                Some(_) | None => return,
            }
        }
    }

    /// Applies a timed event of the scenario.
    pub(super) fn happen(&mut self, event: &Event, at_us: u64, out: &mut Vec<Outgoing>) {
        let until_us = |for_s: f64| at_us.saturating_add((for_s * 1e6) as u64);
        self.has_changed = true;
        match event.change {
            Change::Lose { fraction, for_s } => self.link.set(FaultKind::Lose, fraction, until_us(for_s)),
            Change::Repeat { fraction, for_s } => self.link.set(FaultKind::Repeat, fraction, until_us(for_s)),
            Change::Reorder { fraction, for_s } => self.link.set(FaultKind::Reorder, fraction, until_us(for_s)),
            Change::SupplyLow { supply_mpa } => self.supply_mpa = supply_mpa,
            Change::Restart => self.restart(out),
            Change::Temperature { .. } | Change::DeflectionScale { .. } => {
                for at in 0..self.whiskers.len() {
                    if event.array.as_ref().is_none_or(|array| array == self.whiskers[at].array()) {
                        self.happen_to_whisker(at, event.change, at_us);
                    }
                }
            }
            Change::Trim { .. }
            | Change::Erode { .. }
            | Change::Leak { .. }
            | Change::ValvesBroken
            | Change::ValvesOk
            | Change::GaugeOpen
            | Change::GaugeShort
            | Change::GaugeSaturated { .. }
            | Change::GaugeOk
            | Change::Replace
            | Change::BaselineDrift { .. }
            | Change::Silent { .. } => {
                if let Some(at) = self.place(event) {
                    self.happen_to_whisker(at, event.change, at_us);
                }
            }
        }
    }

    fn happen_to_whisker(&mut self, at: usize, change: Change, at_us: u64) {
        let Some(whisker) = self.whiskers.get_mut(at) else {
            return;
        };
        self.has_changed = true;
        match change {
            Change::Trim { length_mm } => whisker.plant.trim(at_us, length_mm),
            Change::Erode { rate_mm_per_contact, until_length_mm } => {
                whisker.plant.erode(at_us, rate_mm_per_contact, until_length_mm);
            }
            Change::Leak { rate_mpa_per_s } => whisker.leak_mpa_per_s = rate_mpa_per_s,
            Change::ValvesBroken => whisker.regulator.set_broken(true),
            Change::ValvesOk => whisker.regulator.set_broken(false),
            Change::GaugeOpen => whisker.plant.set_gauge(GaugeCondition::Open),
            Change::GaugeShort => whisker.plant.set_gauge(GaugeCondition::Short),
            Change::GaugeSaturated { limit_strain } => {
                whisker.plant.set_gauge(GaugeCondition::Saturated { limit_strain });
            }
            Change::GaugeOk => whisker.plant.set_gauge(GaugeCondition::Ok),
            Change::Replace => {
                whisker.plant.replace(at_us);
                whisker.leak_mpa_per_s = 0.0;
            }
            Change::BaselineDrift { strain_per_contact, until_strain } => {
                whisker.plant.drift(strain_per_contact, until_strain);
            }
            Change::Silent { for_s } => whisker.silent_until_us = at_us.saturating_add((for_s * 1e6) as u64),
            Change::DeflectionScale { factor } => whisker.plant.set_deflection_factor(factor),
            Change::Temperature { sensitivity_factor, temperature_c } => {
                whisker.plant.set_temperature(sensitivity_factor, temperature_c);
            }
            // These affect the robot as a whole.
            Change::Lose { .. }
            | Change::Repeat { .. }
            | Change::Reorder { .. }
            | Change::Restart
            | Change::SupplyLow { .. } => {}
        }
        self.report_change(at_us);
    }

    /// Lets something happen at the next poll: to a whisker, to an array, or to the robot, as [`Change`] states.
    ///
    /// # Errors
    /// The change is invalid, or the robot has no such array or whisker.
    pub fn happen_soon(
        &mut self,
        array: Option<Name>,
        whisker: Option<u16>,
        change: Change,
        now_us: u64,
    ) -> Result<(), BadScenario> {
        let event = Event { at_s: Some(0.0), at_contact: None, array, whisker, change };
        event.check("incident", &self.config.robot)?;
        let place = self.events.partition_point(|&(at_us, _)| at_us <= now_us);
        self.events.insert(place, (now_us, event));
        Ok(())
    }

    /// Restarts at the next poll, as after a power cut: without a farewell, in a new boot.
    pub fn restart_soon(&mut self) {
        let restart = Event { at_s: None, at_contact: None, array: None, whisker: None, change: Change::Restart };
        self.events.push_front((0, restart));
    }

    /// Restarts without a farewell: a new boot without the memory of the old one.
    pub(super) fn restart(&mut self, out: &mut Vec<Outgoing>) {
        self.connected = false;
        out.push(Outgoing::Restart);
        if self.breaks(Misbehaviour::KeepsBootId) {
            return;
        }
        self.boots += 1;
        let boot_id = boot_id(self.seed, &self.config.robot.robot, self.start_us, self.boots);
        let before = std::mem::replace(&mut self.voice, Voice::new(boot_id.clone()));
        if self.breaks(Misbehaviour::KeepsCounting) {
            self.voice = before.counting_on(boot_id);
        }
        self.commands = Commands::default();
        self.estimates = EstimateOrder::default();
        self.outbox.restart();
        self.dropped_newest = 0;
        self.batch.clear();
        self.missed.clear();
        self.touch_tests = TouchTests::default();
        self.tests_under_way.clear();
        self.batch_until_us = None;
        self.supervision.restart();
        self.whiskers.iter_mut().for_each(super::Whisker::restart);
    }
}
