//! Which supervisor should own which fleet: a pure function of the membership, so that all supervisors that read the same
//! membership agree.

use std::collections::BTreeMap;

use vibrissa_protocol::Name;

use vibrissa_store::{Membership, Present};

/// The best owner of each fleet. A present owner keeps its fleets, with three exceptions: to even out the numbers, a
/// fleet that it does not hear and another supervisor has proved to hear, and a clock that most others contradict while
/// another supervisor's is not. Fleets without an owner go to the supervisor with the fewest fleets, and only if there is
/// no other one to a supervisor with a wrong clock.
#[must_use]
pub(crate) fn shares(membership: &Membership) -> BTreeMap<Name, String> {
    let mut present: Vec<&Present> = membership.present.iter().collect();
    present.sort_unstable_by_key(|one| one.supervisor.as_str());
    let owners: BTreeMap<&Name, &str> = membership
        .leases
        .iter()
        .filter(|lease| !lease.free)
        .filter_map(|lease| Some((&lease.fleet, lease.owner.as_deref()?)))
        .collect();
    let owner = |fleet: &Name| {
        let owner = owners.get(fleet)?;
        present.iter().find(|one| *owner == one.supervisor && one.fleets.contains(fleet))
    };
    let is_deaf = |one: &Present, fleet: &Name| one.hearing.deaf.contains(fleet);
    // No supervisor acquires a fleet that it does not hear. It takes over from an owner that does not hear the fleet
    // only with proof that it hears it.
    let may = |one: &Present, fleet: &Name| {
        let must_prove = owner(fleet).is_some_and(|owner| is_deaf(owner, fleet));
        one.fleets.contains(fleet) && !is_deaf(one, fleet) && (!must_prove || one.hearing.heard.contains(fleet))
    };
    let mut shares: BTreeMap<Name, String> = BTreeMap::new();
    for fleet in membership.leases.iter().map(|lease| &lease.fleet) {
        if let Some(owner) = owner(fleet)
            && !(is_deaf(owner, fleet) && present.iter().any(|one| may(one, fleet)))
            && !(owner.clock.is_wrong && present.iter().any(|one| may(one, fleet) && !one.clock.is_wrong))
        {
            shares.insert(fleet.clone(), owner.supervisor.clone());
        }
    }
    let mut unowned: Vec<&Name> = membership.leases.iter().map(|lease| &lease.fleet).collect();
    unowned.retain(|fleet| !shares.contains_key(*fleet));
    unowned.sort_unstable();
    for fleet in unowned {
        let able = present.iter().filter(|one| may(one, fleet));
        if let Some(least) = able.min_by_key(|one| (one.clock.is_wrong, held(&shares, &one.supervisor))) {
            shares.insert(fleet.clone(), least.supervisor.clone());
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

/// A move of one fleet to a supervisor that may own it and has at least two fleets fewer than the owner. Each move
/// lowers the sum of squares of the numbers of fleets, so the moves come to an end.
fn step_towards_even(
    shares: &BTreeMap<Name, String>,
    present: &[&Present],
    may: &impl Fn(&Present, &Name) -> bool,
) -> Option<(Name, String)> {
    // In reverse order, so that the first fleets stay where they are.
    shares.iter().rev().find_map(|(fleet, owner)| {
        let to = present
            .iter()
            .filter(|one| may(one, fleet) && !one.clock.is_wrong)
            .map(|one| &one.supervisor)
            .min_by_key(|one| held(shares, one))
            .filter(|one| held(shares, one) + 1 < held(shares, owner))?;
        Some((fleet.clone(), to.clone()))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use vibrissa_store::FleetLease;

    fn fleets(count: usize) -> Vec<Name> {
        (0..count).map(|number| Name::new(&format!("f{number:02}")).unwrap()).collect()
    }

    /// A membership with the given supervisors present, and each fleet's owner.
    fn membership(present: &[&str], owners: &[Option<&str>]) -> Membership {
        let fleets = fleets(owners.len());
        let leases = fleets.iter().zip(owners).map(|(fleet, owner)| FleetLease {
            fleet: fleet.clone(),
            epoch: 1,
            owner: owner.map(str::to_owned),
            holder: owner.map(str::to_owned),
            free: owner.is_none(),
            free_in: None,
        });
        let one = |one: &&str| Present { supervisor: (*one).to_owned(), fleets: fleets.clone(), ..Present::default() };
        let present = present.iter().map(one).collect();
        Membership { leases: leases.collect(), present, database_ahead_us: None }
    }

    fn counts(shares: &BTreeMap<Name, String>, present: &[&str]) -> Vec<usize> {
        present.iter().map(|one| held(shares, one)).collect()
    }

    #[test]
    fn whoever_is_alone_has_everything() {
        assert_eq!(counts(&shares(&membership(&["a"], &[None; 5])), &["a"]), [5]);
    }

    #[test]
    fn whoever_comes_gets_a_share_and_the_others_keep_the_rest() {
        let before = [Some("a"); 5];
        let shares = shares(&membership(&["a", "b"], &before));
        assert_eq!(counts(&shares, &["a", "b"]), [3, 2]);
        assert!(fleets(3).iter().all(|fleet| shares[fleet] == "a"), "{shares:?}");
    }

    #[test]
    fn one_fleet_stays_where_it_is() {
        assert_eq!(counts(&shares(&membership(&["a", "b"], &[Some("b")])), &["a", "b"]), [0, 1]);
    }

    #[test]
    fn whoever_went_is_replaced_at_once() {
        let shares = shares(&membership(&["b", "c"], &[Some("b"), None, None, Some("c"), None]));
        assert_eq!(counts(&shares, &["b", "c"]).iter().sum::<usize>(), 5);
        assert!(counts(&shares, &["b", "c"]).iter().all(|&count| count >= 2));
    }

    #[test]
    fn nobody_gets_a_fleet_that_it_may_not_have() {
        let mut membership = membership(&["a", "b"], &[None, None, None, None]);
        membership.present[1].fleets.truncate(1);
        let shares = shares(&membership);
        assert_eq!(counts(&shares, &["a", "b"]), [3, 1]);
        assert_eq!(shares[&fleets(1)[0]], "b");
    }

    /// Best owner of one fleet. Each character of `said` is a supervisor's hearing report: D deaf, H proved to hear it,
    /// anything else none.
    fn owner_of_one(owner: Option<&str>, said: &str) -> Option<String> {
        let names = ["a", "b", "c"];
        let mut membership = membership(&names[..said.len()], &[owner]);
        for (one, said) in membership.present.iter_mut().zip(said.chars()) {
            match said {
                'D' => one.hearing.deaf = fleets(1),
                'H' => one.hearing.heard = fleets(1),
                _ => {}
            }
        }
        shares(&membership).remove(&fleets(1)[0])
    }

    #[test]
    fn an_owner_that_does_not_hear_gives_way_to_whoever_has_proved_to_hear_and_to_nobody_else() {
        for (owner, said, expected) in [
            (Some("a"), "D-", Some("a")),
            (Some("a"), "DH", Some("b")),
            (Some("a"), "DD", Some("a")),
            (Some("a"), "D-H", Some("c")),
            (Some("a"), "-H", Some("a")),
            // It has given the fleet up: it acquires nothing before it hears again, even if all others are gone.
            (None, "D-", Some("b")),
            (None, "D", None),
            (Some("b"), "D-", Some("b")),
            (Some("b"), "DD", Some("b")),
            (Some("b"), "HD", Some("a")),
        ] {
            assert_eq!(owner_of_one(owner, said).as_deref(), expected, "{owner:?} {said}");
        }
    }

    #[test]
    fn numbers_are_not_evened_out_towards_whoever_does_not_hear() {
        let mut membership = membership(&["a", "b"], &[Some("a"); 4]);
        membership.present[1].hearing.deaf = fleets(4);
        assert_eq!(counts(&shares(&membership), &["a", "b"]), [4, 0]);
        // Without a proof they are not evened out away from an owner that does not hear either.
        membership.present[1].hearing.deaf.clear();
        membership.present[0].hearing.deaf = fleets(4);
        assert_eq!(counts(&shares(&membership), &["a", "b"]), [4, 0]);
        membership.present[1].hearing.heard = fleets(1);
        assert_eq!(shares(&membership)[&fleets(1)[0]], "b");
        assert_eq!(counts(&shares(&membership), &["a", "b"]), [3, 1]);
    }

    #[test]
    fn regress_an_owner_with_a_wrong_clock_gives_way_to_one_with_a_right_clock() {
        // Whose clocks are wrong: W.
        for (owner, clocks, expected) in [
            (Some("a"), "W-", "b"),
            (Some("a"), "WW", "a"),
            (Some("a"), "W", "a"),
            (Some("b"), "W-", "b"),
            (None, "W--", "b"),
            (None, "WW", "a"),
        ] {
            let mut membership = membership(&["a", "b", "c"][..clocks.len()], &[owner]);
            for (one, clock) in membership.present.iter_mut().zip(clocks.chars()) {
                one.clock.is_wrong = clock == 'W';
            }
            assert_eq!(shares(&membership)[&fleets(1)[0]], expected, "{owner:?} {clocks}");
        }
        // Deafness comes first: a fleet that the other one does not hear stays.
        let mut membership = membership(&["a", "b"], &[Some("a"); 4]);
        membership.present[0].clock.is_wrong = true;
        membership.present[1].hearing.deaf = fleets(4);
        assert_eq!(counts(&shares(&membership), &["a", "b"]), [4, 0]);
        membership.present[1].hearing.deaf.clear();
        assert_eq!(counts(&shares(&membership), &["a", "b"]), [0, 4], "numbers are not evened out towards it");
    }

    /// Every membership of up to 4 supervisors and 6 fleets: all fleets have an owner, the numbers are even, and the result
    /// is stable.
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
                let first = shares(&membership(present, &owners));
                let counts = counts(&first, present);
                assert!(counts.iter().max().unwrap() - counts.iter().min().unwrap() <= 1, "{owners:?} {first:?}");
                assert_eq!(first.len(), 6);
                let followed: Vec<Option<&str>> = first.values().map(|owner| Some(owner.as_str())).collect();
                assert_eq!(shares(&membership(present, &followed)), first, "{owners:?}");
            }
        }
    }
}
