//! Writes `contacts` messages in CBOR, for generators and tests.

use cbor4ii::core::enc::Encode;
use cbor4ii::core::types::{Array, Map};
use cbor4ii::core::utils::BufWriter;

use crate::{Contact, Contacts, MissedTouch};

/// Writes fields of a map, each as its name and value; absent ones are left out.
struct Fields {
    out: BufWriter,
    count: usize,
}

impl Fields {
    fn new() -> Self {
        Self { out: BufWriter::new(Vec::new()), count: 0 }
    }

    fn put(&mut self, name: &str, value: impl Encode) -> &mut Self {
        // Writing into memory cannot fail.
        let _ = name.encode(&mut self.out);
        let _ = value.encode(&mut self.out);
        self.count += 1;
        self
    }

    fn put_some<T: Encode>(&mut self, name: &str, value: Option<T>) -> &mut Self {
        if let Some(value) = value {
            self.put(name, value);
        }
        self
    }

    fn put_list<T>(&mut self, name: &str, list: &[T], of: fn(&T) -> Fields) -> &mut Self {
        let _ = name.encode(&mut self.out);
        let _ = Array::bounded(list.len(), &mut self.out);
        for one in list {
            of(one).into_map(&mut self.out);
        }
        self.count += 1;
        self
    }

    fn into_map(self, out: &mut BufWriter) {
        let _ = Map::bounded(self.count, out);
        let _ = cbor4ii::core::enc::Write::push(out, self.out.buffer());
    }
}

/// The message in CBOR, with the fields in the order of the JSON message.
pub(in crate::decode) fn contacts(message: &Contacts) -> Vec<u8> {
    let mut fields = Fields::new();
    fields.put("boot_id", message.boot_id.as_str()).put("seq", message.seq);
    fields.put_list("contacts", &message.contacts, contact);
    if !message.missed.is_empty() {
        fields.put_list("missed", &message.missed, missed);
    }
    let mut out = BufWriter::new(Vec::new());
    fields.into_map(&mut out);
    out.into_inner()
}

fn contact(one: &Contact) -> Fields {
    let mut fields = Fields::new();
    fields.put("array", one.array.as_str()).put("whisker", one.whisker).put("t_us", one.t_us);
    fields.put_some("ratio", one.ratio).put_some("ratio_sd", one.ratio_sd);
    fields.put_some("distance_mm", one.distance_mm).put_some("distance_sd_mm", one.distance_sd_mm);
    fields.put_some("tip", one.tip.then_some(true));
    fields.put("deflection_mm", one.deflection_mm).put("strain", one.strain);
    fields.put_some("saturated", one.saturated.then_some(true));
    fields.put("pressure_mpa", one.pressure_mpa).put("temperature_c", one.temperature_c);
    fields.put_some("angle_deg", one.angle_deg).put_some("angle_sd_deg", one.angle_sd_deg);
    fields.put_some("test_id", one.test_id.as_deref());
    fields
}

fn missed(one: &MissedTouch) -> Fields {
    let mut fields = Fields::new();
    fields.put("array", one.array.as_str()).put("whisker", one.whisker).put("t_us", one.t_us);
    fields.put("distance_mm", one.distance_mm).put_some("distance_sd_mm", one.distance_sd_mm);
    fields.put_some("test_id", one.test_id.as_deref());
    fields
}
