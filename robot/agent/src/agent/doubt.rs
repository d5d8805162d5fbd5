//! A segmenter that reports no contacts, or only some: for how long, and the remedy.

use vibrissa_protocol::Gauge;
use vibrissa_segmenter::{Condition, Missing};

use crate::contract::Moment;

/// Time after which a person is warned, in microseconds. A whisker that is touched learns within seconds.
const WARNED_AFTER_US: u64 = 30_000_000;

/// Time since the segmenter was ready.
#[derive(Debug, Default)]
pub(super) struct Doubt {
    since: Option<Moment>,
    is_warned: bool,
}

impl Doubt {
    /// Takes the present condition. Returns the remedy, once, if the segmenter has not been ready for too long.
    pub(super) fn watch(&mut self, condition: Condition, at: Moment) -> Option<&'static str> {
        let Some(remedy) = remedy(condition) else {
            *self = Self::default();
            return None;
        };
        let since = *self.since.get_or_insert(at);
        if self.is_warned || at.since(since) < WARNED_AFTER_US {
            return None;
        }
        self.is_warned = true;
        Some(remedy)
    }
}

/// Advice about a condition; `None` if contacts are reported.
pub(super) fn remedy(condition: Condition) -> Option<&'static str> {
    Some(match condition {
        Condition::Ready => return None,
        Condition::Learning(Missing::Rate) => {
            "strain comes too seldom to find contacts: send at least 10 samples a second"
        }
        Condition::Learning(Missing::Stillness) => {
            "the strain has not been still yet, so no contact is found: leave the whisker alone for a second"
        }
        Condition::Learning(Missing::Rest) => {
            "it is not known yet which strain is rest, so no contact is reported: send deflection_mm with the samples, or \
             touch and release the whisker some times"
        }
        Condition::Lost => {
            "it is no longer known which strain is rest, so no contact is reported: release the whisker, then touch it again"
        }
        Condition::Clipped => {
            "the last contact was beyond the gauge's limit: amplify the gauge less, or touch more softly"
        }
        Condition::Noisy => {
            "the whisker shakes, or the converter has many glitches, so only strong touches are found: check the wires and \
             the supply of the converter"
        }
    })
}

/// Advice about a gauge as its driver reports it; `None` if it is in order. The supervisor uses no contact of another
/// one.
pub(super) fn gauge_remedy(gauge: Gauge) -> Option<&'static str> {
    Some(match gauge {
        Gauge::Ok => return None,
        Gauge::Saturated => "amplify the gauge less, or touch more softly: its converter is at its end",
        Gauge::Open => "check the wires of the gauge and of its converter: it does not answer",
        Gauge::Short => "check the wires of the gauge: it is short-circuited",
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_person_is_warned_once_after_half_a_minute_and_anew_after_the_next_loss() {
        let at = |s: u64| Moment::of_us(s * 1_000_000);
        let mut doubt = Doubt::default();
        let warned: Vec<u64> = (0..200)
            .filter(|s| {
                let condition = if (100..110).contains(s) { Condition::Ready } else { Condition::Lost };
                doubt.watch(condition, at(*s)).is_some()
            })
            .collect();
        assert_eq!(warned, [30, 140]);
    }
}
