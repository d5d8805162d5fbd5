//! Messages of mapped topics as lines for the agent.

use std::sync::Arc;

use ros2_client::builtin_interfaces::Time;

use super::{Bridge, Output};
use crate::lifecycle::Activity;
use crate::lines::{span_us, strain_line};
use crate::mapping::{MappedTopic, Mapping, Number, Path, Quantity, Use, Value};
use crate::messages::{Header, Strain};
use crate::words::ToAgent;

/// Time without a message, or without an element of this name in the messages, after which that is reported, seconds.
const TOPIC_SILENT_S: f64 = 10.0;
/// Interval of readings that are constant, seconds.
const CONSTANT_EVERY_S: f64 = 1.0;
/// Age from which a distance or a ratio is not joined with a new deflection, seconds: the touch has moved on.
const PLACE_STALE_S: f64 = 1.0;
/// Lowest level of diagnostics that is a fault: ERROR.
const FAULT_LEVEL: f64 = 2.0;

/// Something that must come again and again.
#[derive(Debug)]
struct Awaited {
    /// Index of the topic.
    topic: usize,
    /// A value with a name; `None` for any message of the topic.
    value: Option<Path>,
    heard_at_s: f64,
    /// Whether its silence was logged.
    is_logged: bool,
}

impl Awaited {
    fn heard(&mut self, now_s: f64) {
        (self.heard_at_s, self.is_logged) = (now_s, false);
    }
}

/// The mapped topics of a robot whose whiskers are known.
#[derive(Debug)]
pub(super) struct Mapped {
    pub(super) mapping: Arc<Mapping>,
    /// Messages of each topic, and values with names: others may publish on `/diagnostics` or `/joint_states`, too.
    awaited: Vec<Awaited>,
    /// Deflection and distance of each whisker, m, and its contact ratio, each with the time of its message.
    motions: Vec<[Option<(f64, f64)>; 3]>,
    /// Whether the robot moves, by the last line to the agent.
    driving: Option<bool>,
    /// The same of whether it is in a task.
    task: Option<bool>,
    constants_at_s: f64,
}

impl Mapped {
    pub(super) fn new(mapping: Mapping, whiskers: usize, now_s: f64) -> Self {
        let mut awaited = Vec::new();
        for (topic, mapped) in mapping.topics.iter().enumerate() {
            let mut values: Vec<Option<Path>> = vec![None];
            for path in mapped.named() {
                if !values.iter().flatten().any(|known| known == path) {
                    values.push(Some(path.clone()));
                }
            }
            let new = |value| Awaited { topic, value, heard_at_s: now_s, is_logged: false };
            awaited.extend(values.into_iter().map(new));
        }
        let motions = vec![[None; 3]; whiskers];
        let constants_at_s = f64::NEG_INFINITY;
        Self { mapping: Arc::new(mapping), awaited, motions, driving: None, task: None, constants_at_s }
    }

    /// Lines of the states that the last messages gave.
    pub(super) fn states(&self) -> impl Iterator<Item = ToAgent> {
        let driving = self.driving.map(|driving| ToAgent::Driving { driving });
        driving.into_iter().chain(self.task.map(|task| ToAgent::Task { task }))
    }

    fn silence(&self, awaited: &Awaited, now_s: f64) -> Option<String> {
        let age_s = now_s - awaited.heard_at_s;
        let MappedTopic { topic, kind, .. } = self.mapping.topics.get(awaited.topic)?;
        if age_s < TOPIC_SILENT_S {
            return None;
        }
        let Some(value) = &awaited.value else {
            return Some(format!(
                "no message for {age_s:.0} s from {topic} ({kind}): is it published, with this type?"
            ));
        };
        let is_topic = |one: &&Awaited| one.topic == awaited.topic && one.value.is_none();
        let is_silent = self.awaited.iter().find(is_topic).is_some_and(|one| now_s - one.heard_at_s >= TOPIC_SILENT_S);
        (!is_silent).then(|| {
            format!(
                "no {value} for {age_s:.0} s in the messages of {topic}: does its publisher run, and is the name right?"
            )
        })
    }

    /// Topics and values that are silent.
    pub(super) fn silent(&self, now_s: f64) -> Vec<String> {
        self.awaited.iter().filter_map(|one| self.silence(one, now_s)).collect()
    }

    /// Those that have become silent since the last call.
    fn newly_silent(&mut self, now_s: f64) -> Vec<String> {
        let silent: Vec<Option<String>> = self.awaited.iter().map(|one| self.silence(one, now_s)).collect();
        let both = self.awaited.iter_mut().zip(silent);
        both.filter_map(|(one, silence)| silence.filter(|_| !std::mem::replace(&mut one.is_logged, true))).collect()
    }

    /// A message of a topic has come.
    fn hear(&mut self, topic: usize, message: &Value, now_s: f64) {
        for one in self.awaited.iter_mut().filter(|one| one.topic == topic) {
            let has = |value: &Path| !matches!(value.numbers(message), Ok(None));
            if one.value.as_ref().is_none_or(has) {
                one.heard(now_s);
            }
        }
    }
}

impl Bridge {
    /// Takes a message of the mapped topic with this index.
    pub(super) fn mapped_message(
        &mut self,
        now_s: f64,
        now: Time,
        index: usize,
        message: Result<Value, String>,
    ) -> Result<Vec<Output>, String> {
        let Some(mapped) = &mut self.mapped else { return Err("a message of a topic that is not mapped".to_owned()) };
        let mapping = Arc::clone(&mapped.mapping);
        let topic = mapping.topics.get(index).ok_or("a message of a topic that is not mapped")?;
        let message = message.map_err(|problem| {
            format!("an unreadable message of {}: {problem}; is its type {}?", topic.topic, topic.kind)
        })?;
        mapped.hear(index, &message, now_s);
        self.counts.mapped += 1;
        let stamp = topic.stamp_of(&message);
        let mut outputs = Vec::new();
        let driving = topic.driving.as_ref().map(|number| state_of(number, &message)).transpose();
        let task = topic.task.as_ref().map(|number| state_of(number, &message)).transpose();
        let is_new =
            |known: &mut Option<bool>, now: Option<bool>| now.is_some() && std::mem::replace(known, now) != now;
        match (driving.map(Option::flatten), task.map(Option::flatten)) {
            (Ok(driving), Ok(task)) => {
                let new = [is_new(&mut mapped.driving, driving), is_new(&mut mapped.task, task)];
                let driving = driving.filter(|_| new[0]).map(|driving| ToAgent::Driving { driving });
                let task = task.filter(|_| new[1]).map(|task| ToAgent::Task { task });
                outputs.extend(driving.into_iter().chain(task).map(Output::Line));
            }
            (Err(problem), _) | (_, Err(problem)) => {
                outputs.push(self.refuse(format!("{}: {problem}", topic.topic)));
            }
        }
        for one in &topic.uses {
            match self.use_value(now_s, now, stamp, one, &message) {
                Ok(line) => outputs.extend(line.map(Output::Line)),
                Err(problem) => outputs.push(self.refuse(format!("{}: {problem}", topic.topic))),
            }
        }
        Ok(outputs)
    }

    fn use_value(
        &mut self,
        now_s: f64,
        now: Time,
        stamp: Option<Time>,
        one: &Use,
        message: &Value,
    ) -> Result<Option<ToAgent>, String> {
        let (Some(index), Some(mapped)) = (one.index, &mut self.mapped) else { return Ok(None) };
        let Some(values) = one.number.of(message)? else { return Ok(None) };
        let first = values.first().copied().ok_or_else(|| format!("{}: the list is empty", one.number.path))?;
        match &one.quantity {
            Quantity::Strain { second, every_us } => {
                let strain_2 = second.as_ref().map(|second| second.of(message)).transpose()?;
                let strain_2 = match strain_2 {
                    Some(None) => return Ok(None),
                    Some(Some(strain_2)) => strain_2,
                    None => Vec::new(),
                };
                let header = Header { stamp: stamp.unwrap_or(Time::ZERO), frame_id: String::new() };
                let samples = Strain {
                    header,
                    strain: values,
                    strain_2,
                    every_us: every_us.unwrap_or_default(),
                    deflection_m: Vec::new(),
                    distance_m: Vec::new(),
                    test_id: String::new(),
                };
                let named = self.whiskers[index].named().clone();
                let span_us = i64::from(span_us(&self.whiskers[index].name(), &samples)?);
                let t_us = stamp.and_then(|stamp| self.time_of(now, stamp, span_us));
                // The last sample has been taken now.
                let begun_us = u64::try_from(now.to_nanos() / 1000 - span_us).unwrap_or_default();
                let line = strain_line(&named, samples, t_us.unwrap_or(begun_us))?;
                self.counts.strains += 1;
                Ok(Some(ToAgent::Strain(line)))
            }
            Quantity::Deflection | Quantity::Distance | Quantity::Ratio => {
                let motion = &mut mapped.motions[index];
                let is_deflection = one.quantity == Quantity::Deflection;
                let place = if is_deflection { 0 } else { 1 + usize::from(one.quantity == Quantity::Ratio) };
                motion[place] = Some((first, now_s));
                // A line has all values. It goes with the deflection, if there is one.
                if !is_deflection && motion[0].is_some() {
                    return Ok(None);
                }
                let is_fresh = |(_, at_s): &(f64, f64)| now_s - at_s < PLACE_STALE_S;
                let [deflection, distance, ratio] = motion.map(|value| value.filter(is_fresh).map(|(value, _)| value));
                let t_us = stamp.and_then(|stamp| self.time_of(now, stamp, 0));
                let named = self.whiskers[index].named();
                let (array, whisker) = (named.array.clone(), named.whisker);
                let [deflection_mm, distance_mm] =
                    [deflection, distance].map(|metres| metres.map(|metres| metres * 1e3));
                Ok(Some(ToAgent::Motion { array, whisker, t_us, deflection_mm, distance_mm, ratio }))
            }
            Quantity::Pressure => {
                let t_us = stamp.and_then(|stamp| self.time_of(now, stamp, 0));
                let pressure_mpa = self.settings.pressures.gauge_mpa(first)?;
                self.counts.pressures += 1;
                Ok(self.whiskers[index].read(now_s, t_us, pressure_mpa))
            }
            Quantity::Regulator => {
                let regulator = if first < FAULT_LEVEL { "OK" } else { "FAULT" };
                let whisker = &mut self.whiskers[index];
                Ok((whisker.regulator() != Some(regulator)).then(|| whisker.report([None, Some(regulator)])))
            }
        }
    }

    /// Constant readings that are due, and topics that have become silent.
    pub(super) fn mapped_tick(&mut self, now_s: f64) -> Vec<Output> {
        let Some(mapped) = &mut self.mapped else { return Vec::new() };
        if self.activity == Activity::Idle {
            // Nobody listens.
            mapped.awaited.iter_mut().for_each(|one| one.heard(now_s));
            return Vec::new();
        }
        let mut outputs: Vec<Output> = mapped.newly_silent(now_s).into_iter().map(Output::Log).collect();
        if now_s - mapped.constants_at_s < CONSTANT_EVERY_S {
            return outputs;
        }
        mapped.constants_at_s = now_s;
        let mapping = Arc::clone(&mapped.mapping);
        for constant in &mapping.constants {
            let Some(index) = constant.index else { continue };
            match self.settings.pressures.gauge_mpa(constant.pa) {
                Ok(mpa) => outputs.extend(self.whiskers[index].read(now_s, None, mpa).map(Output::Line)),
                Err(problem) => outputs.push(self.refuse(format!("{}: {problem}", self.whiskers[index].name()))),
            }
        }
        outputs
    }
}

/// Whether a number of a message is not 0.
fn state_of(number: &Number, message: &Value) -> Result<Option<bool>, String> {
    number.of(message).map(|values| values.and_then(|values| values.first().map(|value| *value != 0.0)))
}
