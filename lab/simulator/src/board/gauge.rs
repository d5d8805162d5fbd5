//! The strain gauge of a whisker and the slide that moves it, sampled all the time: the stream of a board that finds no
//! contacts by itself.

use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use vibrissa_protocol::Contact;

use crate::random::normal;

/// Time between two samples, and samples in a line.
const EVERY_US: u64 = 10_000;
const SAMPLES: u64 = 10;
/// Times from the begin of a touch: the whisker is bent as far as it gets, and the slide begins and ends its way back.
const BENT_US: u64 = 100_000;
const BACK_US: u64 = 150_000;
const END_US: u64 = 250_000;
/// A whisker that slips off its object is free after this time.
const FREE_US: u64 = 10_000;
/// Strain of the whisker at rest, from mounting and amplifier, and standard deviation of a sample.
const REST_STRAIN: f64 = 1e-3;
const NOISE_STRAIN: f64 = 5e-6;
/// Way of the slide at which touches begin, in mm.
const BEGIN_MM: f64 = 20.0;

/// The gauge of one whisker.
#[derive(Debug)]
pub(super) struct Gauge {
    started_us: u64,
    next_us: u64,
    /// Begin and content of the newest touch.
    touch: Option<(u64, Contact)>,
    noise: ChaCha8Rng,
}

impl Gauge {
    pub(super) fn new(noise: ChaCha8Rng, now_us: u64) -> Self {
        Self { started_us: now_us, next_us: now_us, touch: None, noise }
    }

    /// Begins a touch, which ends with a slip-off if it is at the tip.
    pub(super) fn touch(&mut self, at_us: u64, contact: Contact) {
        self.touch = Some((at_us.max(self.next_us), contact));
    }

    /// Time at which the next line is complete.
    pub(super) fn line_at_us(&self) -> u64 {
        self.next_us + SAMPLES * EVERY_US
    }

    /// The next line, with samples up to [`Gauge::line_at_us`].
    pub(super) fn line(&mut self, array: &str, whisker: u16) -> Value {
        let first_us = self.next_us;
        let (mut strains, mut ways_mm) = (Vec::new(), Vec::new());
        for index in 0..SAMPLES {
            let (strain, way_mm) = self.bent(first_us + index * EVERY_US);
            strains.push(((REST_STRAIN + strain + normal(&mut self.noise, NOISE_STRAIN)) * 1e7).round() / 1e7);
            ways_mm.push(((BEGIN_MM + way_mm) * 1e3).round() / 1e3);
        }
        self.next_us = self.line_at_us();
        json!({"type": "strain", "array": array, "whisker": whisker, "t_ms": (first_us - self.started_us) / 1000,
               "every_us": EVERY_US, "strain": strains, "deflection_mm": ways_mm})
    }

    /// Strain and way of the slide at a time, both from rest.
    fn bent(&self, at_us: u64) -> (f64, f64) {
        let Some((begin_us, contact)) = &self.touch else { return (0.0, 0.0) };
        let Some(since_us) = at_us.checked_sub(*begin_us) else { return (0.0, 0.0) };
        let share = |from_us: u64, to_us: u64| {
            (since_us.saturating_sub(from_us) as f64 / (to_us - from_us) as f64).clamp(0.0, 1.0)
        };
        let way = share(0, BENT_US) - share(BACK_US, END_US);
        let held = if contact.tip { share(0, BENT_US) - share(BENT_US, BENT_US + FREE_US) } else { way };
        (contact.strain * held, contact.deflection_mm * way)
    }
}
