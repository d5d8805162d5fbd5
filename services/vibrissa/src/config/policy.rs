//! Reads the policy from the configuration, and another policy for comparisons from a file with some keys of
//! `[policy]`.

use std::path::PathBuf;

use vibrissa_core::policy::PolicyParams;

use super::choices::{LongerForShorterArg, ModeArg, ObjectiveArg};
use super::keys::Key;
use super::layers::{Layers, Sources};
use super::problem::Problems;
use super::reader::Reader;

/// The only section that the file of another policy may have.
const SECTION: &str = "policy";

/// The policy of the configuration; `None` if a value is wrong, which `reader` has noted.
pub(super) fn policy(reader: &mut Reader) -> Option<PolicyParams> {
    let mode = reader.word::<ModeArg>(Key::PolicyMode);
    let objective = reader.word::<ObjectiveArg>(Key::PolicyObjective);
    let longer_for_shorter = reader.word::<LongerForShorterArg>(Key::PolicyLongerForShorter);
    let numbers: Vec<_> = Key::POLICY_NUMBERS.iter().map(|&key| reader.number(key)).collect();
    let mut policy = PolicyParams {
        mode: mode?.into(),
        objective: objective?.into(),
        longer_for_shorter: longer_for_shorter?.into(),
        ..PolicyParams::default()
    };
    for (number, value) in PolicyParams::NUMBERS.iter().zip(numbers) {
        *(number.of_mut)(&mut policy) = value?;
    }
    Some(policy)
}

/// The policy `base`, overridden by the keys in the file. `path` names the file in problems, `text` is its content. The
/// mode stays that of `base`.
///
/// # Errors
/// All problems of the file. Keys of other sections and the key `mode` are refused.
pub fn policy_over(base: PolicyParams, path: PathBuf, text: String) -> Result<PolicyParams, Problems> {
    let sources = Sources { file: Some((path, text)), ..Sources::default() };
    let mut reader = Reader::new(Layers::new(&sources));
    let others = Key::ALL.iter().copied().filter(|key| key.section().0 != Some(SECTION));
    for key in others.filter(|&key| reader.is_explicit(key)).collect::<Vec<_>>() {
        reader.refuse(key, "is not a policy key: only keys of [policy] are compared");
    }
    if reader.is_explicit(Key::PolicyMode) {
        reader
            .refuse(Key::PolicyMode, "is not compared: both policies have the mode of the configuration; leave it out");
    }
    let mut policy = base;
    if reader.is_explicit(Key::PolicyObjective)
        && let Some(word) = reader.word::<ObjectiveArg>(Key::PolicyObjective)
    {
        policy.objective = word.into();
    }
    if reader.is_explicit(Key::PolicyLongerForShorter)
        && let Some(word) = reader.word::<LongerForShorterArg>(Key::PolicyLongerForShorter)
    {
        policy.longer_for_shorter = word.into();
    }
    for (&key, number) in Key::POLICY_NUMBERS.iter().zip(PolicyParams::NUMBERS) {
        if reader.is_explicit(key)
            && let Some(value) = reader.number(key)
        {
            *(number.of_mut)(&mut policy) = value;
        }
    }
    if reader.problems.is_empty() { Ok(policy) } else { Err(Problems(reader.problems)) }
}

#[cfg(test)]
mod tests {
    use vibrissa_core::mechanics::Objective;
    use vibrissa_core::policy::LongerForShorter;

    use super::*;

    fn over(text: &str) -> Result<PolicyParams, Problems> {
        let base = PolicyParams { change_margin: 0.07, ..PolicyParams::default() };
        policy_over(base, "other.toml".into(), text.to_owned())
    }

    #[test]
    fn a_file_changes_what_it_says_and_nothing_else() {
        let text = "[policy]\nobjective = \"mean\"\nlonger_for_shorter = \"never\"\nown_role_cost = 0";
        let policy = over(text).unwrap();
        let expected = PolicyParams {
            objective: Objective::Mean,
            longer_for_shorter: LongerForShorter::Never,
            own_role_cost: 0.0,
            change_margin: 0.07,
            ..PolicyParams::default()
        };
        assert_eq!(policy, expected);
    }

    #[test]
    fn keys_of_other_sections_and_wrong_values_are_refused_with_their_names() {
        let problems = over("fleets = [\"f\"]\n[policy]\nmode = \"advise\"\nobjective = \"best\"\nmargin = 1")
            .unwrap_err()
            .to_string();
        let mode = "policy.mode (file other.toml): is not compared";
        for part in ["fleets (file other.toml): is not a policy key", mode, "policy.objective", "policy.margin"] {
            assert!(problems.contains(part), "{problems}");
        }
    }
}
