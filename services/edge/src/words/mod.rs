//! The words of the core's closed enums in the contract, the database, REST and the metrics, with their labels and
//! severities for people.
//!
//! They are declared here only. The query parameters of REST with their OpenAPI schema (`http/words.rs`), the label
//! values of metrics (`metrics/labels.rs`) and the console (`http/console/declared.rs`) derive from this declaration.
//! `tests/integration/deploy/words.rs` names the hand-written places that need a new word: alert rules, dashboards and
//! the glossary.

/// How urgent a word is for people.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Severity {
    /// As it should be.
    Good,
    /// A passing state that needs nobody.
    Info,
    /// Somebody should look at it.
    Warn,
    /// Something is broken, or was refused.
    Bad,
    /// Over, or absent.
    Off,
}

impl Severity {
    /// Name of the severity in the console.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Info => "info",
            Self::Warn => "warn",
            Self::Bad => "bad",
            Self::Off => "off",
        }
    }
}

/// A closed enum with one word for each variant, in upper snake case.
pub trait Word {
    /// The word of this value.
    fn word(self) -> &'static str;
}

/// An enum whose values can be listed.
pub trait Words: Word + Sized + 'static {
    /// Name of the enum.
    const NAME: &'static str;

    /// Every value of the enum, once.
    fn all() -> Vec<Self>;

    /// A few plain words for people; `None` for enums that people see only by their words.
    fn label(self) -> Option<&'static str>;

    /// How urgent the value is for people; `None` for enums whose values are all equally urgent.
    fn severity(self) -> Option<Severity>;
}

/// The value of a word.
pub fn named<T: Words + Copy>(word: &str) -> Option<T> {
    T::all().into_iter().find(|one| one.word() == word)
}

macro_rules! if_any {
    () => {
        None
    };
    ($value:expr) => {
        Some($value)
    };
}

/// Declares each variant's word, and for people its label and severity: `Variant => "WORD" "label" (Severity)`; after
/// a semicolon, the variant that uses the words of another enum.
macro_rules! words {
    ($($enum:ident {
        $($variant:ident $(($inner:path))? => $word:literal $($label:literal)? $(($severity:ident))?),+ $(,)?
        $(; $other:ident($others:ident))?
    })+) => {
        $(impl Word for $enum {
            fn word(self) -> &'static str {
                match self {
                    $($enum::$variant $(($inner))? => $word,)+
                    $($enum::$other(other) => other.word(),)?
                }
            }
        }

        impl Words for $enum {
            const NAME: &'static str = stringify!($enum);

            fn all() -> Vec<Self> {
                let own = [$($enum::$variant $(($inner))?),+];
                own.into_iter()$(.chain($others::all().into_iter().map($enum::$other)))?.collect()
            }

            fn label(self) -> Option<&'static str> {
                match self {
                    $($enum::$variant $(($inner))? => if_any!($($label)?),)+
                    $($enum::$other(other) => other.label(),)?
                }
            }

            fn severity(self) -> Option<Severity> {
                match self {
                    $($enum::$variant $(($inner))? => if_any!($(Severity::$severity)?),)+
                    $($enum::$other(other) => other.severity(),)?
                }
            }
        })+
    };
}

mod actions;
mod commands;
mod compensations;
mod events;
mod whiskers;

#[cfg(test)]
mod tests {
    use vibrissa_core::robot::effect::{AlarmKind, Condition, Fault};
    use vibrissa_protocol::Segmenter;

    use super::*;

    #[test]
    fn each_word_stands_for_one_value() {
        for kind in AlarmKind::all() {
            assert_eq!(named(kind.word()), Some(kind));
        }
        assert!(AlarmKind::all().len() > Fault::all().len());
        assert_eq!(named::<Condition>("LONGER"), None);
    }

    #[test]
    fn words_of_segmenters_are_those_of_the_contract() {
        for &segmenter in Segmenter::ALL {
            assert_eq!((segmenter.word(), named(segmenter.as_str())), (segmenter.as_str(), Some(segmenter)));
        }
        assert_eq!(Segmenter::all().len(), Segmenter::ALL.len());
    }
}
