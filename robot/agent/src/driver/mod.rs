//! The interface between the agent and a driver, version 1: docs/driver-interface.md. A driver reads gauges and sensors and
//! moves valves; it is a program in any language.

mod admission;
pub mod lines;
pub(crate) mod link;
pub mod told;
pub mod words;

pub use lines::{LINE_MAX_BYTES, Lines};
pub use told::{Opening, ToDriver};
pub use words::{BadLine, FromDriver, Samples};

/// Version of the interface.
pub const VERSION: u32 = 1;
