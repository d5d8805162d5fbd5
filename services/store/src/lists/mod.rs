//! The lists of the REST API: each has its row, its query, and the columns that may sort it.

pub mod actions;
pub mod alarms;
pub mod black_boxes;
pub mod board;
pub mod bulk;
pub mod calibrations;
pub mod compensations;
pub mod contacts;
mod counts;
pub mod errors;
pub mod fleets;
pub mod happenings;
pub mod history;
pub mod notes;
pub mod policies;
pub mod quarantine;
pub mod refusals;
pub mod robots;
pub mod rollouts;
pub mod setpoints;
pub mod timeline;
pub mod touch_tests;
pub mod whiskers;

/// Defines the sort keys of a list as a closed enum; the first one is the default.
macro_rules! sorts {
    ($(#[$meta:meta])* pub enum $name:ident {
        $($(#[$variant_meta:meta])* $variant:ident = $column:tt $kind:ident $way:ident,)+
    }) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize, utoipa::ToSchema)]
        pub enum $name { $($(#[$variant_meta])* #[serde(rename = $column)] $variant,)+ }

        impl $name {
            /// The columns of all sort keys.
            pub const SORTS: &'static [$crate::list::Sort] = &[$($crate::list::Sort {
                column: $column,
                kind: $crate::list::ColumnKind::$kind,
                descending: $crate::list::Way::$way.is_descending(),
            },)+];

            /// Column and default direction of this sort key.
            #[must_use]
            pub fn sort(self) -> $crate::list::Sort {
                Self::SORTS[self as usize]
            }
        }
    };
}
use sorts;
