//! Publication of estimates: the present lengths of a robot's whiskers.

use tokio::time::Instant;
use vibrissa_core::robot::ResponsePoint;
use vibrissa_core::robot::event::Link;
use vibrissa_edge as edge;
use vibrissa_edge::clock::wall_clock;
use vibrissa_edge::contract::whisker_condition;
use vibrissa_edge::interval::length_interval_mm;
use vibrissa_protocol::{self as protocol, Name, PAYLOAD_MAX_BYTES, Timestamp, WhiskerCondition, encode};

use super::Worker;
use super::stepper::Stepper;
use crate::engine::robot::KnownRobot;
use crate::engine::robot::estimates::WhiskerState;
use crate::outbox::{Publication, ToRobot};

/// A robot counts as at least this many whiskers against the limit of whiskers at a time.
const WHISKERS_MIN: usize = 8;
/// Range of lengths in the contract, mm; the bounds of an interval are from 0 to [`BOUND_MAX_MM`].
const LENGTH_MM: (f64, f64) = (1.0, 1000.0);
const BOUND_MAX_MM: f64 = 2000.0;
/// Largest size of a whisker in an estimate, bytes of JSON.
const WHISKER_BYTES_MAX: usize = 1024;

impl Worker {
    /// Adds the estimates that are due to the open batch; they are published after the commit. Stops after `most` whiskers,
    /// and continues there the next time. Robots that are not connected get theirs at their birth.
    pub(super) fn publish_estimates(&mut self, now: Instant, most: usize) {
        let count = self.robots.len();
        let first = std::mem::take(&mut self.estimates_resume_at);
        let mut left = most;
        for index in (first..count).chain(0..first.min(count)) {
            let Some((_, known)) = self.robots.get_index_mut(index) else { continue };
            let is_online = known.robot.connection_state().1 == Link::Online;
            if known.rests || !is_online || !known.estimates.is_due(now) {
                continue;
            }
            if left == 0 {
                self.estimates_resume_at = index;
                return;
            }
            if self.stepper.publish_estimate(known, now, self.epoch) {
                left = left.saturating_sub(known.robot.whisker_count().max(WHISKERS_MIN));
            }
        }
    }
}

impl Stepper {
    /// Publishes a robot's estimate if something has changed; returns whether it did.
    fn publish_estimate(&mut self, known: &mut KnownRobot, now: Instant, epoch: u64) -> bool {
        let Some(states) = known.estimates.next(now, &known.robot) else { return false };
        let params = self.params_of(&known.name);
        let whisker = |(at, state): (usize, &WhiskerState)| {
            let view = known.robot.whisker(at)?;
            let response = known.robot.response_curve(params, at);
            entry(Name::new(view.array).ok()?, view.sheet.number, state, &response)
        };
        let whiskers = states.iter().enumerate().filter_map(whisker).collect();
        let seq = known.seqs.next_estimate();
        let mut estimate = protocol::Estimate {
            boot_id: self.boot_id.clone(),
            seq,
            epoch,
            version: seq,
            timestamp: Timestamp(wall_clock().0),
            whiskers,
        };
        shorten(&mut estimate, PAYLOAD_MAX_BYTES);
        self.batch.publish(Publication::new(known.name.clone(), ToRobot::Estimate(estimate)));
        true
    }
}

fn entry(
    array: Name,
    whisker: u16,
    state: &WhiskerState,
    response: &[ResponsePoint],
) -> Option<protocol::WhiskerEstimate> {
    let (low_mm, high_mm) = length_interval_mm(&state.length);
    let length_mm = state.length.length.mm().clamp(LENGTH_MM.0, LENGTH_MM.1);
    let bounds_are_known = low_mm.is_finite() && high_mm.is_finite();
    let (gain, reading_gain) = edge::gain(state.gain.as_deref());
    bounds_are_known.then(|| protocol::WhiskerEstimate {
        array,
        whisker,
        length_mm: rounded(length_mm, 1e3),
        length_low_mm: rounded(low_mm.clamp(0.0, length_mm), 1e3),
        length_high_mm: rounded(high_mm.clamp(length_mm, BOUND_MAX_MM), 1e3),
        condition: whisker_condition(state.condition),
        pressure_mpa: rounded(state.pressure_mpa, 1e5),
        gain: gain.into_iter().map(|(ratio, one)| (ratio, rounded(one, 1e4))).collect(),
        reading_gain: reading_gain.map(|one| rounded(one, 1e4)),
        response: points(response),
    })
}

/// A response as the contract states it: distances and strains differ by more than a digit that is told.
fn points(response: &[ResponsePoint]) -> Vec<(f64, f64, f64)> {
    let mut points: Vec<(f64, f64, f64)> = Vec::with_capacity(response.len());
    for one in response {
        let point = (rounded(one.distance_mm, 1e2), rounded(one.strain_per_mm, 1e7), rounded(one.sd_per_mm, 1e7));
        let is_told = (0.1..=1000.0).contains(&point.0) && point.1 > 0.0 && point.2 > 0.0;
        if is_told && points.last().is_none_or(|last| last.0 < point.0 && last.1 > point.1) {
            points.push(point);
        }
    }
    points
}

/// Shorter texts, without digits beyond any accuracy.
fn rounded(value: f64, per_unit: f64) -> f64 {
    (value * per_unit).round() / per_unit
}

/// Shortens an estimate to at most `most` bytes of JSON. The contract allows robots with more whiskers than one message
/// can list: then the responses are left out, and after them whiskers that work as installed, the last ones first.
fn shorten(estimate: &mut protocol::Estimate, most: usize) {
    if estimate.whiskers.len() * WHISKER_BYTES_MAX > most && encode(estimate).len() > most {
        estimate.whiskers.iter_mut().for_each(|one| one.response.clear());
    }
    while estimate.whiskers.len() * WHISKER_BYTES_MAX > most {
        let bytes = encode(estimate).len();
        if bytes <= most {
            return;
        }
        let kept = (estimate.whiskers.len() * most / bytes).min(estimate.whiskers.len() - 1);
        estimate.whiskers.sort_by_key(|one| {
            let has_gain = !one.gain.is_empty() || one.reading_gain.is_some();
            matches!(one.condition, WhiskerCondition::Healthy | WhiskerCondition::Learning) && !has_gain
        });
        estimate.whiskers.truncate(kept);
    }
}

#[cfg(test)]
mod tests {
    use vibrissa_core::estimation::LengthEstimate;
    use vibrissa_core::mechanics::{CONTACT_RATIOS, Offset};
    use vibrissa_core::robot::effect::Condition;
    use vibrissa_core::units::Millimetre;
    use vibrissa_protocol::{BootId, Message, Topic, decode};

    use super::*;

    fn state(length_mm: f64, sd_mm: f64, condition: Condition) -> WhiskerState {
        let length = LengthEstimate { length: Millimetre::known(length_mm), sd_mm };
        let gain = (condition == Condition::Trimmed).then(|| Box::new(CONTACT_RATIOS.map(|a| 1.473_456 - a)));
        WhiskerState { length, condition, pressure_mpa: 0.051_234_567, gain, offset: Offset::default() }
    }

    /// Sixteen points, of which the last two differ by less than a digit that is told.
    fn response() -> Vec<ResponsePoint> {
        let point = |at: usize| {
            let along = if at < 15 { at as f64 } else { 14.000_1 };
            let strain_per_mm = 0.009_123_456 - 0.000_3 * along;
            ResponsePoint { distance_mm: 15.212_3 + 3.4 * along, strain_per_mm, sd_per_mm: 0.000_312_345 }
        };
        (0..16).map(point).collect()
    }

    fn estimate(states: &[WhiskerState]) -> protocol::Estimate {
        let array = Name::new("left").unwrap();
        let entries =
            states.iter().zip(0..).map(|(state, number)| entry(array.clone(), number, state, &response()).unwrap());
        let boot_id = BootId::new("s").unwrap();
        let whiskers = entries.collect();
        protocol::Estimate { boot_id, seq: 3, epoch: 7, version: 3, timestamp: Timestamp(0), whiskers }
    }

    #[test]
    fn an_estimate_of_any_length_is_a_message_of_the_contract() {
        let topic = Topic::parse("whisker/v1/f/r/estimate").unwrap();
        let lengths = [(70.0, 0.3), (1.0, 5.0), (1000.0, 0.01), (70.0, 1e5), (69.999_6, 1e-9), (0.5, 0.1)];
        let states: Vec<_> = lengths.map(|(length_mm, sd_mm)| state(length_mm, sd_mm, Condition::Trimmed)).into();
        let mut sent = estimate(&states);
        shorten(&mut sent, PAYLOAD_MAX_BYTES);
        let payload = encode(&sent);
        let Message::Estimate(read) = decode(&topic, &payload).unwrap() else { panic!("no estimate") };
        assert_eq!(read, sent);
        assert_eq!(read.whiskers.len(), lengths.len());
        let first = &read.whiskers[0];
        assert_eq!((first.length_low_mm, first.length_mm, first.length_high_mm), (69.412, 70.0, 70.588));
        assert_eq!((first.pressure_mpa, first.gain[0]), (0.051_23, (0.45, 1.0235)));
        assert_eq!(first.reading_gain, None);
        assert_eq!((first.response.len(), first.response[0]), (15, (15.21, 0.009_123_5, 0.000_312_3)));
    }

    #[test]
    fn a_gain_that_is_one_number_is_sent_as_one() {
        let one = WhiskerState {
            gain: Some(Box::new([0.887_12; CONTACT_RATIOS.len()])),
            ..state(65.0, 0.3, Condition::Trimmed)
        };
        let sent = estimate(&[one]);
        assert_eq!((sent.whiskers[0].gain.len(), sent.whiskers[0].reading_gain), (0, Some(0.8871)));
    }

    #[test]
    fn too_long_an_estimate_leaves_out_whiskers_that_work_as_installed() {
        let mut states = vec![state(70.0, 0.3, Condition::Healthy); 3000];
        for trimmed in [7, 2999] {
            states[trimmed] = state(60.0, 0.3, Condition::Trimmed);
        }
        let mut sent = estimate(&states);
        shorten(&mut sent, PAYLOAD_MAX_BYTES);
        let payload = encode(&sent);
        assert!((PAYLOAD_MAX_BYTES * 9 / 10..=PAYLOAD_MAX_BYTES).contains(&payload.len()), "{}", payload.len());
        let trimmed = sent.whiskers.iter().filter(|one| one.condition == WhiskerCondition::Trimmed);
        assert_eq!(trimmed.map(|one| one.whisker).collect::<Vec<_>>(), [7, 2999]);
        assert!(sent.whiskers.iter().all(|one| one.response.is_empty()));
    }
}
