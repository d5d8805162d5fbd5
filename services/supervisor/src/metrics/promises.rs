//! Ages of the open promises of each fleet, computed when Prometheus asks.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use prometheus::core::{Collector, Desc};
use prometheus::proto::MetricFamily;
use prometheus::{GaugeVec, Opts, Result};

use super::kinds::{FLEET, OfFleet};
use crate::promises::{Promise, Promises};

/// The promises of all fleets, and their gauges.
#[derive(Debug, Clone)]
pub(super) struct PromiseAges {
    seconds: GaugeVec,
    by_fleet: Arc<Mutex<BTreeMap<String, Promises>>>,
}

impl Collector for PromiseAges {
    fn desc(&self) -> Vec<&Desc> {
        self.seconds.desc()
    }

    fn collect(&self) -> Vec<MetricFamily> {
        for (fleet, promises) in self.by_fleet.lock().unwrap_or_else(PoisonError::into_inner).iter() {
            for promise in Promise::ALL {
                let age = promises.age(promise).unwrap_or_default();
                self.seconds.with_label_values(&[fleet.as_str(), promise.word()]).set(age.as_secs_f64());
            }
        }
        self.seconds.collect()
    }
}

impl OfFleet for Promises {
    type Family = PromiseAges;
    type Shape = ();

    fn declare(opts: Opts, (): ()) -> Result<PromiseAges> {
        let seconds = GaugeVec::new(opts, &[FLEET, "promise"])?;
        Ok(PromiseAges { seconds, by_fleet: Arc::default() })
    }

    fn of(family: &PromiseAges, fleet: &str, (): ()) -> Self {
        let mut by_fleet = family.by_fleet.lock().unwrap_or_else(PoisonError::into_inner);
        by_fleet.entry(fleet.to_owned()).or_default().clone()
    }
}
