//! Charts that the HTTP server draws from the database: SVG for light and dark screens of any size.

pub(crate) mod array;
pub mod calibration;
pub(crate) mod console;
pub(crate) mod lines;
pub(crate) mod svg;
pub(crate) mod ticks;
