//! Changes of the layout: a new factsheet, or a new whisker in the place of an old one.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::robot::effect::{AlarmKind, CommandState, Condition, Effect, EndReason, Reason, WhiskerIndex};
use crate::robot::event::{ArrayKind, ArraySheet, Factsheet, WhiskerSheet};
use crate::robot::params::Params;
use crate::robot::setpoints::command::state_of;
use crate::robot::state::factsheet::Sheet;
use crate::robot::state::tracked::Whiskers;
use crate::robot::state::whisker::{Air, Desired, Whisker};
use crate::robot::touch_tests::DistanceZero;
use crate::robot::{Array, Compensation, Robot};
use crate::text::ShortText;
use crate::units::Micros;

/// Where the whiskers of a new layout come from, and where those of the old one go.
struct Moves {
    /// By new index: the old one, if the whisker was there.
    from: Vec<Option<WhiskerIndex>>,
    /// By old index.
    to: Vec<Fate>,
}

/// Fate of a whisker in a new layout.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Fate {
    /// It is as it was, at that index.
    Stays(WhiskerIndex),
    /// There is another one in its place, at that index.
    Replaced(WhiskerIndex),
    /// Its place is no more.
    Gone,
}

impl Robot {
    /// Whether a factsheet has the present layout.
    #[must_use]
    pub fn is_as_known(&self, factsheet: &Factsheet) -> bool {
        let sheets = || factsheet.arrays.iter().flat_map(|array| array.whiskers.iter().map(|one| (&array.name, one)));
        let arrays = self.head.arrays.iter().map(|array| (array.name.as_str(), array.kind, array.task));
        self.head.touch_tests == factsheet.touch_tests
            && self.head.applies_gain == factsheet.applies_gain
            && self.head.air_control == factsheet.air_control
            && arrays.eq(factsheet.arrays.iter().map(|array| (array.name.as_str(), array.kind, array.task)))
            && self.whiskers.len() == sheets().count()
            && self.whiskers.iter().zip(sheets()).all(|(one, (array, sheet))| {
                self.head.arrays[usize::from(one.array)].name == **array && one.sheet.is_as_told(sheet)
            })
    }

    /// Takes another layout: unchanged whiskers keep their state, and the compensations between them go on. The others
    /// start anew.
    pub(in crate::robot) fn lay_out(
        &mut self,
        params: &Params,
        now: Micros,
        factsheet: &Factsheet,
        effects: &mut Vec<Effect>,
    ) {
        let moves = self.moves(factsheet);
        self.end_moved(factsheet, &moves, effects);
        let mut old: Vec<Option<Whisker>> = self.whiskers.take().into_iter().map(Some).collect();
        let names: Vec<ShortText> = self.head.arrays.drain(..).map(|array| array.name).collect();
        let mut new = Vec::with_capacity(moves.from.len());
        for array in &factsheet.arrays {
            self.add_array(params, array, &moves, &mut old, &mut new, effects);
        }
        for gone in old.into_iter().flatten() {
            effects.extend(gone.gone(&names));
            effects.extend(gone.abandoned_test(None));
            effects.extend(gone.command.map(|flight| state_of(&flight.command, None, CommandState::Abandoned)));
        }
        share_models(&mut new, params.model_names());
        self.whiskers = Whiskers::changed(new);
        self.renew_index();
        for fate in &moves.to {
            if let Fate::Replaced(index) = *fate {
                self.changed_now(now, index);
            }
        }
        for one in &mut self.head.compensations {
            let moved = |index: WhiskerIndex| moves.to[index].index().unwrap_or(index) as u32;
            (one.target, one.compensator) = (moved(one.target()), moved(one.compensator()));
        }
        self.head.touch_tests = factsheet.touch_tests;
        (self.head.applies_gain, self.head.air_control) = (factsheet.applies_gain, factsheet.air_control);
        self.move_test_times(&moves);
        self.move_misfits(&moves);
        self.head.undecided = true;
    }

    /// Whiskers that stay keep the times of their tests.
    fn move_test_times(&mut self, moves: &Moves) {
        let old = std::mem::take(&mut self.head.test_times);
        if old.is_empty() {
            return;
        }
        let stays = |from: &WhiskerIndex| matches!(moves.to[*from], Fate::Stays(_));
        let time = |from: &Option<WhiskerIndex>| from.filter(stays).and_then(|from| old.get(from).copied());
        self.head.test_times = moves.from.iter().map(|from| time(from).unwrap_or_default()).collect();
    }

    /// Whiskers that stay keep the record of their misfit.
    fn move_misfits(&mut self, moves: &Moves) {
        self.head.called_changes.clear();
        let old = std::mem::take(&mut self.head.misfits);
        let stays = |from: &WhiskerIndex| matches!(moves.to[*from], Fate::Stays(_));
        let misfit = |from: &Option<WhiskerIndex>| from.filter(stays).and_then(|from| old.get(from).copied());
        if !old.is_empty() {
            self.head.misfits = moves.from.iter().map(|from| misfit(from).unwrap_or_default()).collect();
        }
    }

    fn moves(&self, factsheet: &Factsheet) -> Moves {
        let sheets =
            factsheet.arrays.iter().flat_map(|array| array.whiskers.iter().map(|one| (array.name.as_str(), one)));
        let by_name: BTreeMap<(&str, u16), (WhiskerIndex, &WhiskerSheet)> =
            sheets.enumerate().map(|(index, (array, sheet))| ((array, sheet.number), (index, sheet))).collect();
        let fate = |one: &Whisker| {
            let name = self.head.arrays[usize::from(one.array)].name.as_str();
            match by_name.get(&(name, one.sheet.number)) {
                None => Fate::Gone,
                Some(&(index, sheet)) if one.sheet.is_same_whisker(sheet) => Fate::Stays(index),
                Some(&(index, _)) => Fate::Replaced(index),
            }
        };
        let to: Vec<Fate> = self.whiskers.iter().map(fate).collect();
        let mut from = vec![None; by_name.len()];
        for (old, fate) in to.iter().enumerate() {
            if let Some(new) = fate.index() {
                from[new] = Some(old);
            }
        }
        Moves { from, to }
    }

    /// Ends the compensations of whiskers that are gone or replaced, by old indices, and those with a gain that the robot
    /// does not apply any more.
    fn end_moved(&mut self, factsheet: &Factsheet, moves: &Moves, effects: &mut Vec<Effect>) {
        let over: Vec<(u32, EndReason)> = self
            .head
            .compensations
            .iter()
            .filter_map(|one| {
                let fates = [moves.to[one.target()], moves.to[one.compensator()]];
                let is_replaced = fates.iter().any(|fate| matches!(fate, Fate::Replaced(_)));
                let lacks_gain = one.reading_gain().is_some() && !factsheet.applies_gain;
                if fates.contains(&Fate::Gone) || lacks_gain || !self.is_still_allowed(one, factsheet) {
                    Some((one.id, EndReason::LayoutChanged))
                } else {
                    is_replaced.then_some((one.id, EndReason::Replaced))
                }
            })
            .collect();
        for (id, reason) in over {
            self.end(id, reason, effects);
        }
    }

    /// Whether a factsheet has the two as neighbours, who may serve each other.
    fn is_still_allowed(&self, one: &Compensation, factsheet: &Factsheet) -> bool {
        let (target, compensator) = (&self.whiskers[one.target()], &self.whiskers[one.compensator()]);
        if one.target() == one.compensator() {
            return true;
        }
        let name = &self.head.arrays[usize::from(target.array)].name;
        factsheet.arrays.iter().find(|array| *name == *array.name).is_some_and(|array| {
            let sheet = array.whiskers.iter().find(|sheet| sheet.number == target.sheet.number);
            array.kind == ArrayKind::Type1
                && sheet.is_some_and(|sheet| sheet.neighbours.contains(&compensator.sheet.number))
        })
    }

    fn add_array(
        &mut self,
        params: &Params,
        array: &ArraySheet,
        moves: &Moves,
        old: &mut [Option<Whisker>],
        new: &mut Vec<Whisker>,
        effects: &mut Vec<Effect>,
    ) {
        let at = self.head.arrays.len() as u16;
        for sheet in &array.whiskers {
            let index = new.len();
            let from = moves.from[index];
            let stays = from.is_some_and(|from| matches!(moves.to[from], Fate::Stays(_)));
            let keeps_tolerance = stays
                && from
                    .and_then(|from| old[from].as_ref())
                    .is_some_and(|known| known.sheet.length_tolerance_mm == sheet.length_tolerance_mm);
            let mut whisker = match from.and_then(|from| old[from].take()) {
                None => Whisker::new(at, sheet.into(), params),
                Some(known) if stays => Whisker { sheet: sheet.into(), ..known },
                Some(replaced) => {
                    effects.extend(replaced.leaves(index));
                    effects.extend(replaced.abandoned_test(Some(index)));
                    replaced.renewed(sheet.into(), params)
                }
            };
            whisker.array = at;
            // A measured length owes less to it.
            if !keeps_tolerance {
                whisker.keep_tolerance(&params.filter);
            }
            if let Some(flight) = &mut whisker.command {
                flight.command.whisker = index;
            }
            new.push(whisker);
        }
        self.head.arrays.push(Array { name: array.name.as_str().into(), kind: array.kind, task: array.task });
    }

    /// A new whisker in the place of an old one: it is learned anew, and whoever served for it, or whom it
    /// served, is let go.
    pub(in crate::robot) fn replaced(&mut self, params: &Params, index: WhiskerIndex, effects: &mut Vec<Effect>) {
        let concerned =
            self.head.compensations.iter().filter(|one| one.target() == index || one.compensator() == index);
        let over: Vec<u32> = concerned.map(|one| one.id).collect();
        for id in over {
            self.end(id, EndReason::Replaced, effects);
        }
        let old = &self.whiskers[index];
        effects.extend(old.leaves(index));
        effects.extend(old.abandoned_test(Some(index)));
        self.whiskers[index] = old.clone().renewed(old.sheet.clone(), params);
    }
}

impl Fate {
    fn index(self) -> Option<WhiskerIndex> {
        match self {
            Self::Stays(index) | Self::Replaced(index) => Some(index),
            Self::Gone => None,
        }
    }
}

impl Whisker {
    /// The end of its former condition, at its new index.
    fn leaves(&self, index: WhiskerIndex) -> Option<Effect> {
        let (from, to) = (self.condition, Condition::Learning);
        (from != to).then_some(Effect::Condition { whisker: index, from, to })
    }

    /// The alarms that stood for it, when it is on the robot no more; `names` are those of the arrays it was on.
    fn gone(&self, names: &[ShortText]) -> Option<Effect> {
        let alarms: Vec<AlarmKind> = self.standing.kinds().collect();
        let array = names.get(usize::from(self.array))?.as_str().to_owned();
        (!alarms.is_empty()).then_some(Effect::Gone { array, number: self.sheet.number, alarms })
    }

    /// A new whisker on the same chamber: it keeps the present pressure, and shall hold its nominal pressure unless an
    /// operator holds it.
    fn renewed(self, sheet: Sheet, params: &Params) -> Self {
        let release = Desired { pressure: sheet.pressure, reason: Reason::Release, compensation: None, gain: None };
        let mut renewed = Self {
            air: Air { learned_at: self.air.setpoint, ..self.air },
            fault: self.fault,
            heard: self.heard,
            // Dropped at once where that is held already.
            desired: Some(Box::new(release)),
            command: self.command,
            held: self.held,
            // Alarms that are over are cleared at the end of the step.
            standing: self.standing,
            ..Self::new(self.array, sheet, params)
        };
        renewed.gauge.reported = self.gauge.reported;
        // It is the robot's.
        if self.rare.zero != DistanceZero::UNKNOWN {
            renewed.rare.get_or_insert().zero = self.rare.zero;
        }
        renewed
    }
}

/// Whiskers of the same model share its name, if it can be with `names`.
pub(in crate::robot) fn share_models(whiskers: &mut [Whisker], mut names: Vec<Arc<String>>) {
    for model in whiskers.iter_mut().map(|one| &mut one.sheet.model) {
        match names.iter().find(|known| *known == model) {
            Some(known) => *model = Arc::clone(known),
            None => names.push(Arc::clone(model)),
        }
    }
}
