//! Parts that the tests and benchmarks of the core share.

pub mod large_array;
