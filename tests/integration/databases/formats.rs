//! Stored bytes of deferred transactions and of open minute and hour aggregates, by format version.
//!
//! A test fails if the bytes change. In that case raise the version, keep a decoder of the old one, and add a file for
//! the new one.

use vibrissa_core::units::Micros;
use vibrissa_store::Batch;
use vibrissa_store::batch::ContactRow;
use vibrissa_supervisor::engine::rollup::Open;

#[test]
fn golden_a_batch_of_version_1_is_read_and_becomes_version_2() {
    let of_version_1 = include_bytes!("../../data/formats/batch-1.bin");
    let of_version_2 = include_bytes!("../../data/formats/batch-2.bin");
    let mut batch = Batch::from_bytes(of_version_1).unwrap();
    assert!(!batch.records.is_empty() && !batch.whiskers.is_empty(), "{batch:?}");
    // The batch of version 1 has no contacts; one of version 1 with contacts is read in the store's own tests.
    batch.contacts = vec![contact("RATIO", Some(0.7), None), contact("UNKNOWN", None, None)];
    batch.contacts.push(contact("DISTANCE", Some(0.8), Some(52.5)));
    if std::env::var_os("VIBRISSA_WRITE_DOCS").is_some() {
        std::fs::write("data/formats/batch-2.bin", batch.to_bytes().unwrap()).unwrap();
    }
    assert!(batch.to_bytes().unwrap() == of_version_2, "the bytes have changed");
    assert_eq!(format!("{:?}", Batch::from_bytes(of_version_2).unwrap()), format!("{batch:?}"));
}

fn contact(place: &'static str, ratio: Option<f64>, distance_mm: Option<f64>) -> ContactRow {
    ContactRow {
        whisker_id: 1,
        boot: 2,
        seq: 3,
        position: 4,
        t_us: 5,
        received_us: 6,
        place,
        ratio,
        distance_mm,
        deflection_mm: 2.0,
        strain: 0.01,
        pressure_mpa: 0.1,
        temperature_c: 24.0,
        used: "USED",
        residual: Some(0.1),
        length_mm: 70.0,
        length_sd_mm: 0.2,
    }
}

#[test]
fn golden_a_minute_and_an_hour_of_version_1_are_read_and_written_as_they_were() {
    let bytes = include_bytes!("../../data/formats/rollup-1.bin");
    let open = Open::from_bytes(Some(bytes), Micros::default());
    assert!(open.due().is_some());
    assert_eq!(open.to_bytes().unwrap(), bytes);
}
