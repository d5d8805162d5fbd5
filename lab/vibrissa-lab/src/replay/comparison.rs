//! Compares two policies on the same traffic: differing decisions and totals.

use std::fmt;
use std::io::{self, Write};
use std::sync::Arc;

use vibrissa_core::robot::effect::{Decision, Effect};
use vibrissa_core::robot::{Params, Robot};
use vibrissa_core::units::Micros;
use vibrissa_edge::words::Word;
use vibrissa_protocol::Name;

use super::refusals::Refusals;
use super::replayer::{Happened, Replayer, What};
use vibrissa_edge::recording::Recorded;

/// Two replays that run in step.
pub struct Comparison {
    sides: [Side; 2],
    differing: u64,
}

struct Side {
    name: String,
    replayer: Replayer,
    sums: Sums,
}

/// Totals of a policy.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sums {
    /// Number of decisions with a compensator.
    pub served: u64,
    /// Number of decisions without a compensator.
    pub unserved: u64,
    /// Number of compensations that ended.
    pub ended: u64,
    /// Number of setpoints that were sent.
    pub setpoints: u64,
    predicted_error: f64,
}

impl Sums {
    /// Mean predicted error of the decisions with a compensator, as a ratio; `None` without such decisions.
    #[must_use]
    pub fn mean_predicted_error(&self) -> Option<f64> {
        (self.served > 0).then(|| self.predicted_error / self.served as f64)
    }
}

/// One decision, for the comparison.
#[derive(Debug, Clone, PartialEq)]
struct Decided {
    at: Micros,
    /// The target whisker: `fleet/robot/array/3`.
    target: String,
    target_length_mm: f64,
    chosen: Option<Chosen>,
}

#[derive(Debug, Clone, PartialEq)]
struct Chosen {
    whisker: u16,
    case: &'static str,
    pressure_mpa: Option<f64>,
    predicted_error: Option<f64>,
}

impl Comparison {
    /// A comparison of two policies, each with a name and parameters.
    #[must_use]
    pub fn new(sides: [(String, Arc<Params>); 2], fleets: Option<&std::collections::BTreeSet<Name>>) -> Self {
        let side =
            |(name, params)| Side { name, replayer: Replayer::new(params, fleets.cloned()), sums: Sums::default() };
        Self { sides: sides.map(side), differing: 0 }
    }

    /// Passes a message to both replays, and writes the decisions in which they differ.
    ///
    /// # Errors
    /// The output cannot be written.
    pub fn take(&mut self, recorded: &Recorded, out: &mut dyn Write) -> io::Result<()> {
        let [first, second] = &mut self.sides;
        let (mut ours, mut theirs) = (first.take(recorded)?, second.take(recorded)?);
        while !ours.is_empty() || !theirs.is_empty() {
            let (one, other) = next_pair(&mut ours, &mut theirs);
            if one.as_ref().map(|one| &one.chosen) != other.as_ref().map(|other| &other.chosen) {
                self.differing += 1;
                self.write(one.as_ref(), other.as_ref(), out)?;
            }
        }
        Ok(())
    }

    fn write(&self, one: Option<&Decided>, other: Option<&Decided>, out: &mut dyn Write) -> io::Result<()> {
        let Some(decided) = one.or(other) else { return Ok(()) };
        let (at, target, length_mm) = (decided.at.0, &decided.target, decided.target_length_mm);
        writeln!(out, "{at} {target} ({length_mm} mm)")?;
        for (side, decided) in self.sides.iter().zip([one, other]) {
            match decided {
                None => writeln!(out, "  {}: no decision", side.name)?,
                Some(Decided { chosen: None, .. }) => writeln!(out, "  {}: not compensated", side.name)?,
                Some(Decided { chosen: Some(chosen), .. }) => writeln!(out, "  {}: {chosen}", side.name)?,
            }
        }
        Ok(())
    }

    /// Writes the final table.
    ///
    /// # Errors
    /// The output cannot be written.
    pub fn summary(&self, out: &mut dyn Write) -> io::Result<()> {
        let width = self.sides.iter().map(|side| side.name.chars().count()).max().unwrap_or_default().max(6);
        writeln!(
            out,
            "\n{:<width$} {:>7} {:>8} {:>6} {:>15} {:>9} {:>10}",
            "policy", "served", "unserved", "ended", "mean error (%)", "setpoints", "in force"
        )?;
        for side in &self.sides {
            let Sums { served, unserved, ended, setpoints, .. } = side.sums;
            let error = side.sums.mean_predicted_error().map_or("-".to_owned(), |mean| format!("{:.2}", 100.0 * mean));
            let in_force: usize = side.replayer.robots().map(|(_, _, robot)| robot.compensations().len()).sum();
            let name = &side.name;
            writeln!(
                out,
                "{name:<width$} {served:>7} {unserved:>8} {ended:>6} {error:>15} {setpoints:>9} {in_force:>10}"
            )?;
        }
        writeln!(
            out,
            "\nserved and unserved count decisions; the error is predicted (Eq. 35); decisions that differ: {}",
            self.differing
        )
    }

    /// Refusals of the replay with the first policy. The other replay gets the same messages.
    #[must_use]
    pub fn refusals(&self) -> &Refusals {
        self.sides[0].replayer.refusals()
    }

    /// Totals of both policies so far.
    #[must_use]
    pub fn sums(&self) -> [Sums; 2] {
        [self.sides[0].sums, self.sides[1].sums]
    }
}

/// The next decision of each side about the same whisker at the same time; `None` for a side without one.
fn next_pair(ours: &mut Vec<Decided>, theirs: &mut Vec<Decided>) -> (Option<Decided>, Option<Decided>) {
    if ours.is_empty() {
        return (None, Some(theirs.remove(0)));
    }
    let one = ours.remove(0);
    let at = theirs.iter().position(|other| (other.at, &other.target) == (one.at, &one.target));
    let other = at.map(|at| theirs.remove(at));
    (Some(one), other)
}

impl Side {
    fn take(&mut self, recorded: &Recorded) -> io::Result<Vec<Decided>> {
        let mut decisions = Vec::new();
        let sums = &mut self.sums;
        self.replayer.take(recorded, &mut |happened: &Happened<'_>| {
            if let (Some((fleet, name, robot)), What::Effect { effect, .. }) = (happened.robot, &happened.what) {
                sums.count(effect);
                if let Effect::Decided(decision) = effect {
                    decisions.extend(decided(happened.at, (fleet, name, robot), decision));
                }
            }
            Ok(())
        })?;
        Ok(decisions)
    }
}

impl Sums {
    #[expect(clippy::wildcard_enum_match_arm, reason = "counts a few of many effects")]
    fn count(&mut self, effect: &Effect) {
        match effect {
            Effect::Decided(decision) => match decision.chosen.and_then(|at| decision.candidates[at].predicted_error) {
                Some(error) => {
                    self.served += 1;
                    self.predicted_error += error;
                }
                None => self.unserved += 1,
            },
            Effect::Ended { .. } => self.ended += 1,
            Effect::Command(_) => self.setpoints += 1,
            _ => {}
        }
    }
}

fn decided(at: Micros, (fleet, name, robot): (&Name, &Name, &Robot), decision: &Decision) -> Option<Decided> {
    let target = robot.whisker(decision.target)?;
    let chosen = decision.chosen.and_then(|at| {
        let one = &decision.candidates[at];
        Some(Chosen {
            whisker: robot.whisker(one.whisker)?.sheet.number,
            case: one.case.word(),
            pressure_mpa: one.pressure.map(|pressure| pressure.mpa()),
            predicted_error: one.predicted_error,
        })
    });
    Some(Decided {
        at,
        target: format!("{fleet}/{name}/{}/{}", target.array, target.sheet.number),
        target_length_mm: decision.target_length.mm(),
        chosen,
    })
}

impl fmt::Display for Chosen {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "whisker {} ({})", self.whisker, self.case)?;
        if let Some(pressure_mpa) = self.pressure_mpa {
            write!(f, " at {pressure_mpa:.4} MPa")?;
        }
        match self.predicted_error {
            Some(error) => write!(f, ", {:.2} % predicted", 100.0 * error),
            None => Ok(()),
        }
    }
}
