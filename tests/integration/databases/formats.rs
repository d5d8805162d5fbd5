//! Stored bytes of open minute and hour aggregates, by format version.
//!
//! A test fails if the bytes change. In that case raise the version, keep a decoder of the old one, and add a file for
//! the new one.

use vibrissa_core::units::Micros;
use vibrissa_supervisor::engine::rollup::Open;

#[test]
fn golden_a_minute_and_an_hour_of_version_1_are_read_and_written_as_they_were() {
    let bytes = include_bytes!("../../data/formats/rollup-1.bin");
    let open = Open::from_bytes(Some(bytes), Micros::default());
    assert!(open.due().is_some());
    assert_eq!(open.to_bytes().unwrap(), bytes);
}
