//! State of a whisker's physics, for the state file.

use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use super::{Baseline, Erosion, GaugeCondition, LengthChange, Plant};
use crate::scenario::Rubber;

/// A whisker's true state, and the positions of its random streams.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PlantState {
    rubber: Rubber,
    length_mm: f64,
    contacts: u64,
    changes: Vec<LengthChange>,
    erosion: Option<Erosion>,
    gauge: GaugeCondition,
    baseline: Baseline,
    deflection_factor: f64,
    sensitivity_factor: f64,
    temperature_c: f64,
    /// Number of 32-bit words drawn from each stream.
    contact_words: u64,
    noise_words: u64,
}

impl Plant {
    pub(crate) fn state(&self) -> PlantState {
        PlantState {
            rubber: self.rubber,
            length_mm: self.length_mm,
            contacts: self.contacts,
            changes: self.changes.clone(),
            erosion: self.erosion,
            gauge: self.gauge,
            baseline: self.baseline,
            deflection_factor: self.deflection_factor,
            sensitivity_factor: self.sensitivity_factor,
            temperature_c: self.temperature_c,
            contact_words: words(&self.contact_stream),
            noise_words: words(&self.noise_stream),
        }
    }

    /// Restores the state of the same whisker.
    ///
    /// # Errors
    /// Names the first invalid value.
    pub(crate) fn take_up(&mut self, state: &PlantState) -> Result<(), String> {
        if !(state.length_mm > 0.0 && state.length_mm <= self.whole_length_mm) {
            return Err(format!("length_mm is {}, but was {} when installed", state.length_mm, self.whole_length_mm));
        }
        for (name, factor) in
            [("deflection_factor", state.deflection_factor), ("sensitivity_factor", state.sensitivity_factor)]
        {
            if factor <= 0.0 {
                return Err(format!("{name} is {factor}, but must be above 0"));
            }
        }
        self.model = state.rubber.model(&self.designed).map_err(|why| format!("rubber: {why}"))?;
        self.rubber = state.rubber;
        self.length_mm = state.length_mm;
        self.contacts = state.contacts;
        self.changes.clone_from(&state.changes);
        self.erosion = state.erosion;
        self.gauge = state.gauge;
        self.baseline = state.baseline;
        self.deflection_factor = state.deflection_factor;
        self.sensitivity_factor = state.sensitivity_factor;
        self.temperature_c = state.temperature_c;
        self.contact_stream.set_word_pos(state.contact_words.into());
        self.noise_stream.set_word_pos(state.noise_words.into());
        Ok(())
    }
}

fn words(stream: &ChaCha8Rng) -> u64 {
    u64::try_from(stream.get_word_pos()).unwrap_or(u64::MAX)
}
