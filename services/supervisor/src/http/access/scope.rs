//! The fleets that a caller may access.

use std::collections::BTreeSet;

use vibrissa_edge::fleets::FleetPattern;
use vibrissa_store::list::Filter;

/// Fleets that a caller may access.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Scope {
    /// Every fleet, including future ones.
    All,
    /// The fleets of these names and patterns only. A pattern includes future fleets that match it.
    Only(BTreeSet<FleetPattern>),
}

impl Scope {
    /// The fleets of these names and patterns. The pattern `*` is every fleet.
    #[must_use]
    pub fn of(fleets: impl IntoIterator<Item = FleetPattern>) -> Self {
        let fleets: BTreeSet<_> = fleets.into_iter().collect();
        if fleets.iter().any(FleetPattern::is_all) { Self::All } else { Self::Only(fleets) }
    }

    /// Whether the scope includes the fleet.
    #[must_use]
    pub fn covers(&self, fleet: &str) -> bool {
        match self {
            Self::All => true,
            Self::Only(fleets) => fleets.iter().any(|one| one.matches(fleet)),
        }
    }

    /// Whether one name or pattern of the scope includes all fleets that this one matches, also future ones.
    #[must_use]
    pub fn includes(&self, fleets: &FleetPattern) -> bool {
        match self {
            Self::All => true,
            Self::Only(own) => own.iter().any(|one| one.includes(fleets)),
        }
    }

    /// Limits a list to these fleets by the column of that name; `None` for all fleets.
    #[must_use]
    pub fn filter(&self, column: &'static str) -> Option<Filter> {
        match self {
            Self::All => None,
            Self::Only(fleets) => Some(Filter::fleets(column, fleets)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scope_gives_no_more_than_it_has() {
        let scope = |fleets: &[&str]| Scope::of(fleets.iter().map(|fleet| FleetPattern::new(fleet).unwrap()));
        let may_give = |own: &[&str], given| scope(own).includes(&FleetPattern::new(given).unwrap());
        assert!(may_give(&["hall-*"], "hall-*") && may_give(&["hall-*"], "hall-1*") && may_give(&["hall-*"], "hall-7"));
        assert!(!may_give(&["hall-*"], "hall*") && !may_give(&["hall-*"], "*") && !may_give(&["hall-1"], "hall-*"));
        assert!(may_give(&["lab", "h*"], "hall-*") && !may_give(&[], "lab") && may_give(&["*"], "*"));
        assert_eq!((scope(&["lab", "*"]), scope(&[]).covers("lab")), (Scope::All, false));
        assert!(scope(&["hall-*"]).covers("hall-9") && !scope(&["hall-*"]).covers("hall-*"));
    }
}
