//! The invariants have the checkers that they name.

use vibrissa_edge::invariants::{Checker, Invariant};

use crate::project;
use crate::structure::{code, rust_files};

/// Folder of a checker's code.
fn folder(checker: Checker) -> &'static str {
    match checker {
        Checker::Simulation => "lab/simulation/src",
        Checker::Chaos => "tests/chaos",
        Checker::Production => "services/supervisor/src",
    }
}

#[test]
fn each_checker_names_the_invariants_that_it_is_said_to_check_and_no_others() {
    for checker in Checker::ALL {
        let code: String = rust_files(&project().join(folder(checker))).iter().map(|path| code(path)).collect();
        let words: Vec<&str> = code.split(|c: char| !c.is_alphanumeric()).collect();
        for invariant in Invariant::ALL {
            let is_named = words.contains(&format!("{invariant:?}").as_str());
            let is_said = invariant.is_checked_by(checker);
            assert_eq!(
                is_named,
                is_said,
                "{invariant:?}: correct its checkers in services/edge/src/invariants.rs, because {} {} it",
                folder(checker),
                if is_named { "checks" } else { "does not check" }
            );
        }
    }
}
