//! Places for requests that last: limits in total, per fleet and per caller, so that nobody takes the places of others.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::access::Scope;
use super::fleets::FleetFilter;
use super::problem::{Kind, Problem};

/// Most places that are taken at once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PlaceLimits {
    /// Of all callers.
    pub total_max: usize,
    /// About one fleet. Those about several fleets have a share of their own.
    pub per_fleet_max: usize,
    /// Of one caller.
    pub per_caller_max: usize,
}

/// A caller or a fleet with a share of the places.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Sharer {
    Caller(String),
    Fleet(Option<String>),
}

type Taken = Arc<Mutex<BTreeMap<Sharer, usize>>>;

/// Places, and by whom they are taken.
#[derive(Debug, Clone)]
pub struct Places {
    /// Plural name of what takes a place.
    what: &'static str,
    limits: PlaceLimits,
    taken: Taken,
}

/// A taken place; dropping it frees the place.
#[derive(Debug)]
pub struct TakenPlace {
    sharers: Vec<Sharer>,
    taken: Taken,
}

/// The fleet that a request is about: the only one that it names, or the only one of its caller; `None` for several,
/// and for a pattern.
pub(super) fn fleet_of<'a>(scope: &'a Scope, named: Option<&'a FleetFilter>) -> Option<&'a str> {
    let only = match scope {
        Scope::All => None,
        Scope::Only(fleets) => fleets.first().filter(|first| fleets.len() == 1 && first.is_name()),
    };
    named.and_then(|named| named.only()).or(only.map(|only| only.as_str()))
}

impl Places {
    /// Places of which none is taken.
    #[must_use]
    pub fn new(what: &'static str, limits: PlaceLimits) -> Self {
        Self { what, limits, taken: Arc::default() }
    }

    /// Number of taken places.
    #[must_use]
    pub fn count(&self) -> usize {
        total(&lock(&self.taken))
    }

    /// Takes a place for a caller, about each of these fleets. An empty list stands for several fleets.
    ///
    /// # Errors
    /// The caller, a fleet, or all together have reached the limit.
    pub fn take<'a>(&self, caller: &str, fleets: impl IntoIterator<Item = &'a str>) -> Result<TakenPlace, Problem> {
        let Self { what, limits: PlaceLimits { total_max, per_fleet_max, per_caller_max }, .. } = *self;
        let mut fleets: Vec<Option<&str>> = fleets.into_iter().map(Some).collect();
        if fleets.is_empty() {
            fleets.push(None);
        }
        let of_fleets = fleets.iter().map(|fleet| Sharer::Fleet(fleet.map(ToOwned::to_owned)));
        let sharers: Vec<Sharer> = std::iter::once(Sharer::Caller(caller.to_owned())).chain(of_fleets).collect();
        let mut taken = lock(&self.taken);
        let count = |sharer: &Sharer| taken.get(sharer).copied().unwrap_or_default();
        let refused = |detail: String| Err(Problem::new(Kind::TooManyRequests, detail));
        if sharers.first().is_some_and(|caller| count(caller) >= per_caller_max) {
            return refused(format!(
                "{caller} has {per_caller_max} {what}, the limit per caller: end one, or try again later"
            ));
        }
        let full = sharers.iter().skip(1).zip(fleets).find(|(sharer, _)| count(sharer) >= per_fleet_max);
        if let Some((_, fleet)) = full {
            let about = fleet.map_or_else(|| "about several fleets".to_owned(), |fleet| format!("about fleet {fleet}"));
            return refused(format!("there are {per_fleet_max} {what} {about}, the limit: try again later"));
        }
        if total(&taken) >= total_max {
            return refused(format!("there are {total_max} {what}, the limit of this service: try again later"));
        }
        for sharer in &sharers {
            *taken.entry(sharer.clone()).or_default() += 1;
        }
        Ok(TakenPlace { sharers, taken: self.taken.clone() })
    }
}

impl Drop for TakenPlace {
    fn drop(&mut self) {
        let mut taken = lock(&self.taken);
        for sharer in &self.sharers {
            if let Some(count) = taken.get_mut(sharer) {
                *count -= 1;
                if *count == 0 {
                    taken.remove(sharer);
                }
            }
        }
    }
}

/// Each place has one caller.
fn total(taken: &BTreeMap<Sharer, usize>) -> usize {
    taken.iter().filter(|(sharer, _)| matches!(sharer, Sharer::Caller(_))).map(|(_, count)| count).sum()
}

/// The counts are consistent even if a holder of the lock panicked.
fn lock(taken: &Taken) -> MutexGuard<'_, BTreeMap<Sharer, usize>> {
    taken.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_caller_has_its_share_and_all_together_the_total() {
        let places = Places::new("streams", PlaceLimits { total_max: 3, per_fleet_max: 3, per_caller_max: 2 });
        let first = places.take("a", None).unwrap();
        let _second = places.take("a", Some("f")).unwrap();
        let third = places.take("a", None).unwrap_err();
        assert!(third.kind == Kind::TooManyRequests && third.detail.contains("a has 2 streams"), "{third:?}");
        let others = places.take("b", None).unwrap();
        assert!(places.take("c", None).unwrap_err().detail.contains("3 streams, the limit of this service"));
        assert_eq!(places.count(), 3);
        drop(others);
        drop(first);
        let _again = places.take("a", None).unwrap();
        assert_eq!(places.count(), 2);
    }

    #[test]
    fn regress_the_callers_of_one_fleet_leave_places_for_another_fleet() {
        let places =
            Places::new("tests of webhooks", PlaceLimits { total_max: 10, per_fleet_max: 4, per_caller_max: 2 });
        let of_a: Vec<_> = (0..10).filter_map(|caller| places.take(&caller.to_string(), Some("a")).ok()).collect();
        assert_eq!(of_a.len(), 4);
        let detail = places.take("x", Some("a")).unwrap_err().detail;
        assert!(detail.contains("4 tests of webhooks about fleet a"), "{detail}");
        let of_b: Vec<_> = (0..10).filter_map(|caller| places.take(&caller.to_string(), Some("b")).ok()).collect();
        let of_several: Vec<_> = (20..30).filter_map(|caller| places.take(&caller.to_string(), None).ok()).collect();
        assert_eq!((of_b.len(), of_several.len()), (4, 2));
        drop((of_a, of_b, of_several));
        assert_eq!(places.count(), 0);
    }

    #[test]
    fn regress_a_request_about_two_fleets_takes_a_place_of_each() {
        let places = Places::new("tests", PlaceLimits { total_max: 10, per_fleet_max: 2, per_caller_max: 10 });
        let of_both = places.take("x", ["a", "b"]).unwrap();
        let _of_a = places.take("y", ["a"]).unwrap();
        let detail = places.take("z", ["b", "a"]).unwrap_err().detail;
        assert!(detail.contains("2 tests about fleet a"), "{detail}");
        let of_b = places.take("z", ["b"]).unwrap();
        assert!(places.take("z", ["b"]).is_err());
        assert_eq!(places.count(), 3);
        drop((of_both, of_b));
        assert!(places.take("z", ["b", "a"]).is_ok(), "a refusal takes no place");
    }

    #[test]
    fn a_request_is_about_the_fleet_that_it_names_or_its_callers_only_one() {
        let only = |fleets: &[&str]| Scope::of(fleets.iter().map(|name| name.parse().unwrap()));
        let named = |text: &str| FleetFilter(text.parse().unwrap());
        assert_eq!(fleet_of(&Scope::All, None), None);
        assert_eq!(fleet_of(&Scope::All, Some(&named("a"))), Some("a"));
        assert_eq!(fleet_of(&Scope::All, Some(&named("a,b"))), None);
        assert_eq!(fleet_of(&Scope::All, Some(&named("a*"))), None);
        assert_eq!(fleet_of(&only(&["a*"]), None), None);
        assert_eq!(fleet_of(&only(&["a"]), Some(&named("a*"))), Some("a"));
        assert_eq!(fleet_of(&only(&["a"]), None), Some("a"));
        assert_eq!(fleet_of(&only(&["a", "b"]), None), None);
    }
}
