//! Which supervisor should have which fleet: a pure function of the roll, so that all who see the same roll come
//! to the same answer.

use std::collections::BTreeMap;

use vibrissa_protocol::Name;

use crate::store::Roll;

/// Who should have each fleet. Owners that are there keep what they have, except what evens out the numbers;
/// fleets without one go to whoever has the fewest.
#[must_use]
pub(crate) fn shares(roll: &Roll) -> BTreeMap<Name, String> {
    let mut present: Vec<(&str, &[Name])> =
        roll.present.iter().map(|(supervisor, fleets)| (supervisor.as_str(), fleets.as_slice())).collect();
    present.sort_unstable();
    let may = |supervisor: &str, fleet: &Name| {
        present.iter().any(|(one, fleets)| *one == supervisor && fleets.contains(fleet))
    };
    let mut shares: BTreeMap<Name, String> = BTreeMap::new();
    for lease in roll.leases.iter().filter(|lease| !lease.free) {
        if let Some(owner) = lease.owner.as_deref().filter(|owner| may(owner, &lease.fleet)) {
            shares.insert(lease.fleet.clone(), owner.to_owned());
        }
    }
    let mut unowned: Vec<&Name> = roll.leases.iter().map(|lease| &lease.fleet).collect();
    unowned.retain(|fleet| !shares.contains_key(*fleet));
    unowned.sort_unstable();
    for fleet in unowned {
        let least =
            present.iter().map(|(one, _)| *one).filter(|one| may(one, fleet)).min_by_key(|one| held(&shares, one));
        if let Some(least) = least {
            shares.insert(fleet.clone(), least.to_owned());
        }
    }
    while let Some((fleet, to)) = step_towards_even(&shares, &present, &may) {
        shares.insert(fleet, to);
    }
    shares
}

fn held(shares: &BTreeMap<Name, String>, supervisor: &str) -> usize {
    shares.values().filter(|owner| *owner == supervisor).count()
}

/// A fleet of somebody who has at least two more than another who may have it. Each step lowers the sum of
/// squares of the numbers, so that they come to an end.
fn step_towards_even(
    shares: &BTreeMap<Name, String>,
    present: &[(&str, &[Name])],
    may: &impl Fn(&str, &Name) -> bool,
) -> Option<(Name, String)> {
    // From behind: the fleets that come first stay where they are.
    shares.iter().rev().find_map(|(fleet, owner)| {
        let to = present
            .iter()
            .map(|(one, _)| *one)
            .filter(|one| may(one, fleet))
            .min_by_key(|one| held(shares, one))
            .filter(|one| held(shares, one) + 1 < held(shares, owner))?;
        Some((fleet.clone(), to.to_owned()))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::FleetLease;

    fn fleets(count: usize) -> Vec<Name> {
        (0..count).map(|number| Name::new(&format!("f{number:02}")).unwrap()).collect()
    }

    /// Supervisors that are there, and each fleet's owner.
    fn roll(present: &[&str], owners: &[Option<&str>]) -> Roll {
        let fleets = fleets(owners.len());
        let leases = fleets.iter().zip(owners).map(|(fleet, owner)| FleetLease {
            fleet: fleet.clone(),
            epoch: 1,
            owner: owner.map(str::to_owned),
            holder: owner.map(str::to_owned),
            free: owner.is_none(),
            free_in: None,
        });
        let present = present.iter().map(|one| ((*one).to_owned(), fleets.clone())).collect();
        Roll { leases: leases.collect(), present }
    }

    fn counts(shares: &BTreeMap<Name, String>, present: &[&str]) -> Vec<usize> {
        present.iter().map(|one| held(shares, one)).collect()
    }

    #[test]
    fn whoever_is_alone_has_everything() {
        assert_eq!(counts(&shares(&roll(&["a"], &[None; 5])), &["a"]), [5]);
    }

    #[test]
    fn whoever_comes_gets_a_share_and_the_others_keep_the_rest() {
        let before = [Some("a"); 5];
        let shares = shares(&roll(&["a", "b"], &before));
        assert_eq!(counts(&shares, &["a", "b"]), [3, 2]);
        assert!(fleets(3).iter().all(|fleet| shares[fleet] == "a"), "{shares:?}");
    }

    #[test]
    fn one_fleet_stays_where_it_is() {
        assert_eq!(counts(&shares(&roll(&["a", "b"], &[Some("b")])), &["a", "b"]), [0, 1]);
    }

    #[test]
    fn whoever_went_is_replaced_at_once() {
        let shares = shares(&roll(&["b", "c"], &[Some("b"), None, None, Some("c"), None]));
        assert_eq!(counts(&shares, &["b", "c"]).iter().sum::<usize>(), 5);
        assert!(counts(&shares, &["b", "c"]).iter().all(|&count| count >= 2));
    }

    #[test]
    fn nobody_gets_a_fleet_that_it_may_not_have() {
        let mut roll = roll(&["a", "b"], &[None, None, None, None]);
        roll.present[1].1.truncate(1);
        let shares = shares(&roll);
        assert_eq!(counts(&shares, &["a", "b"]), [3, 1]);
        assert_eq!(shares[&fleets(1)[0]], "b");
    }

    /// Every roll of up to 4 supervisors and 6 fleets: all owned, even, and at rest once it was followed.
    #[test]
    fn brute_force_every_share_is_even_and_final() {
        let all = ["a", "b", "c", "d"];
        for supervisors in 1..=all.len() {
            let present = &all[..supervisors];
            for code in 0..(supervisors + 1).pow(6) {
                let owners: Vec<Option<&str>> = (0..6)
                    .map(|place| code / (supervisors + 1).pow(place) % (supervisors + 1))
                    .map(|owner| present.get(owner).copied())
                    .collect();
                let first = shares(&roll(present, &owners));
                let counts = counts(&first, present);
                assert!(counts.iter().max().unwrap() - counts.iter().min().unwrap() <= 1, "{owners:?} {first:?}");
                assert_eq!(first.len(), 6);
                let followed: Vec<Option<&str>> = first.values().map(|owner| Some(owner.as_str())).collect();
                assert_eq!(shares(&roll(present, &followed)), first, "{owners:?}");
            }
        }
    }
}
