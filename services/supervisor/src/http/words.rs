//! Words of the contract that requests may name.

/// A closed enum of words, as JSON and the database write them.
macro_rules! words {
    ($(#[$meta:meta])* pub enum $name:ident { $($(#[$variant_meta:meta])* $variant:ident = $word:tt,)+ }) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize, serde::Serialize, utoipa::ToSchema)]
        pub enum $name { $($(#[$variant_meta])* #[serde(rename = $word)] $variant,)+ }

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(match self { $(Self::$variant => $word,)+ })
            }
        }
    };
}
pub(super) use words;

words! {
    /// Mechanical condition of a whisker.
    pub enum ConditionWord {
        /// Cold start.
        Learning = "LEARNING",
        /// As the factsheet says.
        Healthy = "HEALTHY",
        /// An alarm of the detector is being looked into.
        Suspected = "SUSPECTED",
        /// Shorter than whole, by a cut.
        Trimmed = "TRIMMED",
        /// Becoming shorter.
        Eroding = "ERODING",
        /// Less sensitive, which no trim explains.
        SensitivityLoss = "SENSITIVITY_LOSS",
    }
}
