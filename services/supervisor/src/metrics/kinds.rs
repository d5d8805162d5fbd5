//! Kinds of metrics that each fleet has: registered once for all fleets, with `fleet` as their first label, and then
//! obtained for one fleet. The values of labels are words of the program and never come from robots, so the number of series
//! is bounded.

use std::sync::Arc;

use prometheus::core::Collector;
use prometheus::{
    Gauge, GaugeVec, Histogram, HistogramOpts, HistogramVec, IntCounter, IntCounterVec, IntGauge, IntGaugeVec, Opts,
    Registry, Result,
};

/// First label of each metric.
pub(super) const FLEET: &str = "fleet";

/// A word of the program, as the value of a label.
pub type Word = &'static str;

/// A kind of metric that each fleet has.
pub(super) trait OfFleet: Sized {
    /// The registered family of series, for all fleets.
    type Family: Clone + Collector + 'static;
    /// Further properties, beside name and help text: labels or buckets.
    type Shape: Copy;

    fn declare(opts: Opts, shape: Self::Shape) -> Result<Self::Family>;
    fn of(family: &Self::Family, fleet: &str, shape: Self::Shape) -> Self;

    /// Creates the family and registers it.
    fn register(registry: &Registry, name: &str, help: &str, shape: Self::Shape) -> Result<Self::Family> {
        let family = Self::declare(Opts::new(name, help), shape)?;
        registry.register(Box::new(family.clone()))?;
        Ok(family)
    }
}

/// Labels beside that of the fleet, with all combinations of values whose series exist from the start. (The rate of a series
/// that appears with its first event would miss that event.)
#[derive(Debug, Clone, Copy)]
pub(super) struct Labels<const N: usize> {
    /// Names of the labels.
    pub(super) names: [&'static str; N],
    /// Combinations of the labels' values.
    pub(super) values: fn() -> Vec<[Word; N]>,
}

impl<const N: usize> Labels<N> {
    fn all(self) -> Vec<&'static str> {
        std::iter::once(FLEET).chain(self.names).collect()
    }
}

/// Upper bounds of a histogram's buckets.
pub(super) type Buckets = &'static [f64];

impl OfFleet for IntCounter {
    type Family = IntCounterVec;
    type Shape = ();

    fn declare(opts: Opts, (): ()) -> Result<IntCounterVec> {
        IntCounterVec::new(opts, &[FLEET])
    }

    fn of(family: &IntCounterVec, fleet: &str, (): ()) -> Self {
        family.with_label_values(&[fleet])
    }
}

impl OfFleet for IntGauge {
    type Family = IntGaugeVec;
    type Shape = ();

    fn declare(opts: Opts, (): ()) -> Result<IntGaugeVec> {
        IntGaugeVec::new(opts, &[FLEET])
    }

    fn of(family: &IntGaugeVec, fleet: &str, (): ()) -> Self {
        family.with_label_values(&[fleet])
    }
}

impl OfFleet for Gauge {
    type Family = GaugeVec;
    type Shape = ();

    fn declare(opts: Opts, (): ()) -> Result<GaugeVec> {
        GaugeVec::new(opts, &[FLEET])
    }

    fn of(family: &GaugeVec, fleet: &str, (): ()) -> Self {
        family.with_label_values(&[fleet])
    }
}

impl OfFleet for Histogram {
    type Family = HistogramVec;
    type Shape = Buckets;

    fn declare(opts: Opts, buckets: Buckets) -> Result<HistogramVec> {
        HistogramVec::new(HistogramOpts::from(opts).buckets(buckets.to_vec()), &[FLEET])
    }

    fn of(family: &HistogramVec, fleet: &str, _: Buckets) -> Self {
        family.with_label_values(&[fleet])
    }
}

/// Metrics of one fleet by the values of their labels, found without a lock or an allocation.
#[derive(Debug, Clone)]
pub(super) struct By<M, const N: usize> {
    known: Arc<[([Word; N], M)]>,
}

impl<M: Clone, const N: usize> By<M, N> {
    fn new(labels: Labels<N>, one: impl Fn(&[Word; N]) -> M) -> Self {
        Self { known: (labels.values)().into_iter().map(|values| (values, one(&values))).collect() }
    }

    fn find(&self, values: [Word; N]) -> Option<&M> {
        self.known.iter().find(|(known, _)| *known == values).map(|(_, metric)| metric)
    }
}

fn values<'a>(fleet: &'a str, words: &[Word]) -> Vec<&'a str> {
    std::iter::once(fleet).chain(words.iter().copied()).collect()
}

/// Counters by the values of their labels.
#[derive(Debug, Clone)]
pub struct Counters<const N: usize = 1> {
    by: By<IntCounter, N>,
    family: IntCounterVec,
    fleet: Arc<str>,
}

impl<const N: usize> Counters<N> {
    /// The counter with these values.
    #[must_use]
    pub fn of(&self, words: [Word; N]) -> IntCounter {
        self.by.find(words).cloned().unwrap_or_else(|| self.family.with_label_values(&values(&self.fleet, &words)))
    }

    /// Increments the counter with these values.
    pub fn count(&self, words: [Word; N]) {
        match self.by.find(words) {
            Some(counter) => counter.inc(),
            None => self.of(words).inc(),
        }
    }
}

impl<const N: usize> OfFleet for Counters<N> {
    type Family = IntCounterVec;
    type Shape = Labels<N>;

    fn declare(opts: Opts, labels: Labels<N>) -> Result<IntCounterVec> {
        IntCounterVec::new(opts, &labels.all())
    }

    fn of(family: &IntCounterVec, fleet: &str, labels: Labels<N>) -> Self {
        let by = By::new(labels, |words| family.with_label_values(&values(fleet, words)));
        Self { by, family: family.clone(), fleet: fleet.into() }
    }
}

/// Integer gauges by one label.
#[derive(Debug, Clone)]
pub struct Gauges {
    by: By<IntGauge, 1>,
}

impl Gauges {
    /// Sets each gauge to `count` of its label value.
    pub fn set_all(&self, count: impl Fn(Word) -> i64) {
        for ([word], gauge) in self.by.known.iter() {
            gauge.set(count(word));
        }
    }
}

impl OfFleet for Gauges {
    type Family = IntGaugeVec;
    type Shape = Labels<1>;

    fn declare(opts: Opts, labels: Labels<1>) -> Result<IntGaugeVec> {
        IntGaugeVec::new(opts, &labels.all())
    }

    fn of(family: &IntGaugeVec, fleet: &str, labels: Labels<1>) -> Self {
        Self { by: By::new(labels, |words| family.with_label_values(&values(fleet, words))) }
    }
}

/// Gauges of values that may be unknown, by one label. The series of an unknown value does not exist.
#[derive(Debug, Clone)]
pub struct Quantities {
    family: GaugeVec,
    words: Arc<[[Word; 1]]>,
    fleet: Arc<str>,
}

impl Quantities {
    /// Sets each gauge to `quantity` of its label value; removes the series if it is `None`.
    pub fn set_all(&self, quantity: impl Fn(Word) -> Option<f64>) {
        for words in self.words.iter() {
            let values = values(&self.fleet, words);
            match quantity(words[0]) {
                Some(quantity) => self.family.with_label_values(&values).set(quantity),
                // The series may not exist.
                None => drop(self.family.remove_label_values(&values)),
            }
        }
    }
}

impl OfFleet for Quantities {
    type Family = GaugeVec;
    type Shape = Labels<1>;

    fn declare(opts: Opts, labels: Labels<1>) -> Result<GaugeVec> {
        GaugeVec::new(opts, &labels.all())
    }

    fn of(family: &GaugeVec, fleet: &str, labels: Labels<1>) -> Self {
        Self { family: family.clone(), words: (labels.values)().into(), fleet: fleet.into() }
    }
}

/// Histograms by one label.
#[derive(Debug, Clone)]
pub struct Histograms {
    by: By<Histogram, 1>,
    family: HistogramVec,
    fleet: Arc<str>,
}

impl Histograms {
    /// The histogram with this label value.
    #[must_use]
    pub fn of(&self, word: Word) -> Histogram {
        self.by.find([word]).cloned().unwrap_or_else(|| self.family.with_label_values(&values(&self.fleet, &[word])))
    }
}

impl OfFleet for Histograms {
    type Family = HistogramVec;
    type Shape = (Labels<1>, Buckets);

    fn declare(opts: Opts, (labels, buckets): Self::Shape) -> Result<HistogramVec> {
        HistogramVec::new(HistogramOpts::from(opts).buckets(buckets.to_vec()), &labels.all())
    }

    fn of(family: &HistogramVec, fleet: &str, (labels, _): Self::Shape) -> Self {
        let by = By::new(labels, |words| family.with_label_values(&values(fleet, words)));
        Self { by, family: family.clone(), fleet: fleet.into() }
    }
}
