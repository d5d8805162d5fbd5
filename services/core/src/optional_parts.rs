//! Names of the parts of stored types that not every value has.

/// A stored type with parts that not every value has.
pub(crate) trait OptionalParts<const N: usize> {
    /// Names of the parts.
    const NAMES: [&'static str; N];
    /// Whether this value has each of them.
    fn has(&self) -> [bool; N];
}

/// Implements [`OptionalParts`] for a struct. All fields must be listed: first those that every value has, then the
/// others, each with the condition under which a value has it.
macro_rules! optional_fields {
    ($type:ty: $($always:ident),*; $($field:ident: $has:expr),+ $(,)?) => {
        impl $crate::optional_parts::OptionalParts<{ [$(stringify!($field)),+].len() }> for $type {
            const NAMES: [&'static str; [$(stringify!($field)),+].len()] = [$(stringify!($field)),+];

            fn has(&self) -> [bool; [$(stringify!($field)),+].len()] {
                let Self { $($always: _,)* $($field),+ } = self;
                [$($has),+]
            }
        }
    };
}
pub(crate) use optional_fields;
