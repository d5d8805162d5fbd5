//! Measures the decoding of `contacts` messages in both encodings.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use vibrissa_protocol::{BootId, Contact, Contacts, Name, decode_contacts, encode, encode_cbor};

fn message(contacts: usize) -> Contacts {
    let contact = |number: usize| Contact {
        array: Name::new("left").expect("a name"),
        whisker: (number % 10) as u16,
        t_us: 1_795_248_000_123_456 + number as u64,
        // Numbers with all digits, as measurements have them.
        ratio: Some(0.5 + 0.5 * (number as f64 * 0.618_034).fract()),
        ratio_sd: None,
        distance_mm: None,
        distance_sd_mm: None,
        tip: false,
        deflection_mm: 2.4,
        strain: 0.009_671_234_567,
        saturated: false,
        pressure_mpa: 0.100_2,
        temperature_c: 24.1,
        angle_deg: None,
        angle_sd_deg: None,
        test_id: None,
    };
    let boot_id = BootId::new("5c0e1fb08d6b4fb1a8e2").expect("a boot id");
    Contacts { boot_id, seq: 1812, contacts: (0..contacts).map(contact).collect(), missed: Vec::new() }
}

fn decoding(c: &mut Criterion) {
    for contacts in [1, 2, 5, 20, 100] {
        let message = message(contacts);
        let mut group = c.benchmark_group(format!("{contacts} contacts"));
        group.throughput(Throughput::Elements(contacts as u64));
        for (name, payload) in [("JSON", encode(&message)), ("CBOR", encode_cbor(&message))] {
            let mut list = Vec::new();
            group.bench_function(format!("{name}, {} bytes", payload.len()), |b| {
                b.iter(|| {
                    let read =
                        decode_contacts(black_box(&payload), std::mem::take(&mut list)).expect("a valid message");
                    list = black_box(read).contacts;
                });
            });
        }
        group.finish();
    }
}

criterion_group!(benches, decoding);
criterion_main!(benches);
