//! What robots say to setpoints that nobody sent them.
//!
//! A recording holds the setpoints of the supervisor of that time, under its names, and the robots' answers to
//! them. A setpoint of the replay takes the answers of the recorded one for the same whisker that is seen while it is
//! under way. One that was never recorded, as with another policy, is taken to be applied once the robot has
//! had the time for it; from then on the robot's `status` is corrected by the difference. What its whiskers would have
//! felt at that pressure nobody knows: their recorded contacts are at another one, and count as UNSETTLED.

use std::collections::{BTreeMap, VecDeque};

use vibrissa_core::robot::Robot;
use vibrissa_core::robot::effect::{Command, CommandKey};
use vibrissa_core::units::{Megapascal, Micros};
use vibrissa_protocol::{Setpoint, SetpointOutcome, SetpointState};

/// Pressures closer than this are the same, MPa.
const SAME_MPA: f64 = 1e-4;
/// Recorded setpoints of one whisker that are remembered.
const REMEMBERED: usize = 4;

/// A whisker by array and number.
pub(super) type Place = (String, u16);

/// The answers of one boot of one robot.
#[derive(Debug, Default)]
pub(super) struct Answers {
    places: BTreeMap<Place, Chamber>,
}

#[derive(Debug, Default)]
struct Chamber {
    recorded: VecDeque<Link>,
    /// Where the replay's setpoints have brought it; none for its nominal pressure.
    own: Option<Megapascal>,
    /// Where the recorded ones have.
    told: Option<Megapascal>,
    /// The replay's setpoint that no recorded one stands for, and when it is taken to be applied.
    assumed: Option<(Command, Micros)>,
}

/// A recorded setpoint, and the replay's that takes its answers.
#[derive(Debug)]
struct Link {
    command_id: String,
    pressure_mpa: f64,
    key: Option<CommandKey>,
}

/// An answer to a setpoint of the replay.
pub(super) struct Answer {
    pub key: CommandKey,
    /// The replay's pressure, if it is not the recorded one.
    pub instead: Option<Megapascal>,
}

impl Answers {
    /// The recording supervisor has sent this.
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

    /// The replay has sent this. It is taken to be applied when the robot has had the time, unless a recorded one
    /// turns up meanwhile.
    pub(super) fn commanded(&mut self, place: Place, command: &Command, from: Megapascal, patience: Micros) {
        let way_mpa = (command.pressure.mpa() - from.mpa()).abs();
        let slewing = Micros::from_s(way_mpa / command.slew_mpa_per_s);
        let chamber = self.places.entry(place).or_default();
        // One that came before, and whose answers may still come.
        if let Some(link) = chamber.recorded.back_mut().filter(|link| link.key.is_none()) {
            link.key = Some(command.key);
        }
        chamber.assumed = Some((command.clone(), command.issued.after(slewing.max(patience))));
    }

    /// What a recorded answer says to the replay's setpoint, if there is one under way.
    pub(super) fn answer(&mut self, state: &SetpointState, robot: &Robot) -> Option<Answer> {
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
            chamber.told = recorded;
        }
        let command = robot.commands_under_way().find(|command| Some(command.key) == link.key)?;
        if moves {
            chamber.own = Some(command.pressure);
            chamber.assumed = None;
        }
        let is_same = (command.pressure.mpa() - link.pressure_mpa).abs() < SAME_MPA;
        Some(Answer { key: command.key, instead: (!is_same).then_some(command.pressure) })
    }

    /// The setpoints that are taken to be applied by now.
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

    /// Where the replay has a chamber that the recorded supervisor has elsewhere: (there, here).
    pub(super) fn moved(&self, place: &Place, nominal: Megapascal) -> Option<(Megapascal, Megapascal)> {
        let chamber = self.places.get(place)?;
        let (told, own) = (chamber.told.unwrap_or(nominal), chamber.own.unwrap_or(nominal));
        ((told.mpa() - own.mpa()).abs() >= SAME_MPA).then_some((told, own))
    }

    /// The robot has started anew: its chambers are where it says.
    pub(super) fn forget(&mut self) {
        self.places.clear();
    }
}
