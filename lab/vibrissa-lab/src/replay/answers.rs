//! Robots' answers to setpoints that were never sent to them.
//!
//! A recording contains the original supervisor's setpoints, with its own command IDs, and the robots' answers to them.
//! A setpoint of the replay gets the answers of the recorded setpoint for the same whisker that appears while it is
//! under way. If no such setpoint was recorded, for example because of another policy, it is assumed to be applied once
//! the robot has had time for it; from then on the robot's `status` is corrected by the difference. Nobody knows the
//! strains at that pressure: the recorded contacts are at another one, and count as UNSETTLED.

use std::collections::{BTreeMap, VecDeque};

use vibrissa_core::robot::Robot;
use vibrissa_core::robot::effect::{Command, CommandKey};
use vibrissa_core::units::{Megapascal, Micros};
use vibrissa_edge::ids::command_id;
use vibrissa_protocol::{Name, Setpoint, SetpointOutcome, SetpointState};

/// Pressures closer than this are equal, MPa.
const SAME_MPA: f64 = 1e-4;
/// Number of recorded setpoints remembered per whisker.
const REMEMBERED: usize = 4;

/// A whisker by array and number.
pub(super) type WhiskerKey = (String, u16);

/// Answers of one boot of one robot.
#[derive(Debug, Default)]
pub(super) struct Answers {
    places: BTreeMap<WhiskerKey, Chamber>,
}

#[derive(Debug, Default)]
struct Chamber {
    recorded: VecDeque<Link>,
    /// Pressure set by the replay; `None` for the nominal pressure.
    own: Option<Megapascal>,
    /// Pressure set by the recorded setpoints; `None` for the nominal pressure.
    recorded_pressure: Option<Megapascal>,
    /// The replay's setpoint without a recorded counterpart, and the time at which it is assumed to be applied.
    assumed: Option<(Command, Micros)>,
}

/// A recorded setpoint, and the replay's setpoint that gets its answers.
#[derive(Debug)]
struct Link {
    command_id: String,
    pressure_mpa: f64,
    key: Option<CommandKey>,
}

/// An answer to a setpoint of the replay.
pub(super) struct ReplayAnswer {
    pub key: CommandKey,
    /// The replay's pressure, if it differs from the recorded one.
    pub instead: Option<Megapascal>,
}

impl Answers {
    /// Notes a setpoint of the recorded supervisor.
    pub(super) fn recorded(&mut self, setpoint: &Setpoint, robot: &Robot) {
        let index = robot.find(setpoint.array.as_str(), setpoint.whisker);
        let under_way = robot.commands_under_way().find(|command| Some(command.whisker) == index);
        let key = under_way.map(|command| command.key);
        let chamber = self.places.entry((setpoint.array.to_string(), setpoint.whisker)).or_default();
        if key.is_some() {
            chamber.assumed = None;
        }
        if let Some(known) = chamber.recorded.iter_mut().find(|link| link.command_id == setpoint.command_id) {
            known.key = key.or(known.key);
            return;
        }
        if chamber.recorded.len() >= REMEMBERED {
            chamber.recorded.pop_front();
        }
        let (command_id, pressure_mpa) = (setpoint.command_id.clone(), setpoint.pressure_mpa);
        chamber.recorded.push_back(Link { command_id, pressure_mpa, key });
    }

    /// Notes the setpoints that a restored robot has under way: a black box has their answers, and not the setpoints.
    pub(super) fn restored(&mut self, (fleet, name): (&Name, &Name), robot: &Robot) {
        for command in robot.commands_under_way() {
            let Some(view) = robot.whisker(command.whisker) else { continue };
            let chamber = self.places.entry((view.array.to_owned(), view.sheet.number)).or_default();
            let command_id = command_id(fleet, name, command.key);
            let pressure_mpa = command.pressure.mpa();
            chamber.recorded.push_back(Link { command_id, pressure_mpa, key: Some(command.key) });
        }
    }

    /// Notes a setpoint of the replay. It is assumed to be applied once the robot has had time for it, unless a
    /// recorded setpoint appears meanwhile.
    pub(super) fn commanded(&mut self, place: WhiskerKey, command: &Command, from: Megapascal, patience: Micros) {
        let way_mpa = (command.pressure.mpa() - from.mpa()).abs();
        let slewing = Micros::from_s(way_mpa / command.slew_mpa_per_s);
        let chamber = self.places.entry(place).or_default();
        // An earlier recorded setpoint, whose answers may still come.
        if let Some(link) = chamber.recorded.back_mut().filter(|link| link.key.is_none()) {
            link.key = Some(command.key);
        }
        chamber.assumed = Some((command.clone(), command.issued.after(slewing.max(patience))));
    }

    /// The recorded answer for the replay's setpoint, if one is under way.
    pub(super) fn answer(&mut self, state: &SetpointState, robot: &Robot) -> Option<ReplayAnswer> {
        let mut found = self.places.values_mut().filter_map(|chamber| {
            let at = chamber.recorded.iter().position(|link| link.command_id == state.command_id)?;
            Some((chamber, at))
        });
        let (chamber, at) = found.next()?;
        let link = &chamber.recorded[at];
        let moves = match state.state {
            SetpointOutcome::Received | SetpointOutcome::Applying | SetpointOutcome::Applied => true,
            SetpointOutcome::Rejected | SetpointOutcome::Failed | SetpointOutcome::Superseded => false,
        };
        let recorded = Megapascal::new(link.pressure_mpa).ok();
        if moves {
            chamber.recorded_pressure = recorded;
        }
        let command = robot.commands_under_way().find(|command| Some(command.key) == link.key)?;
        if moves {
            chamber.own = Some(command.pressure);
            chamber.assumed = None;
        }
        let is_same = (command.pressure.mpa() - link.pressure_mpa).abs() < SAME_MPA;
        Some(ReplayAnswer { key: command.key, instead: (!is_same).then_some(command.pressure) })
    }

    /// Setpoints that are assumed to be applied by now.
    pub(super) fn due(&mut self, now: Micros, robot: &Robot) -> Vec<(CommandKey, Megapascal)> {
        let mut due = Vec::new();
        for chamber in self.places.values_mut() {
            let Some((command, _)) = chamber.assumed.take_if(|(_, due)| *due <= now) else { continue };
            if robot.commands_under_way().any(|one| one.key == command.key) {
                chamber.own = Some(command.pressure);
                due.push((command.key, command.pressure));
            }
        }
        due
    }

    /// Pressures of a chamber that differ between recording and replay: (recorded, replayed).
    pub(super) fn moved(&self, place: &WhiskerKey, nominal: Megapascal) -> Option<(Megapascal, Megapascal)> {
        let chamber = self.places.get(place)?;
        let (recorded, own) = (chamber.recorded_pressure.unwrap_or(nominal), chamber.own.unwrap_or(nominal));
        ((recorded.mpa() - own.mpa()).abs() >= SAME_MPA).then_some((recorded, own))
    }

    /// Forgets all chambers after a restart of the robot: they are where its status says.
    pub(super) fn forget(&mut self) {
        self.places.clear();
    }
}
