//! Samples of strain gauges, of which the segmenter makes contacts.

use vibrissa_protocol::PlaceKind;
use vibrissa_segmenter::{Contact, Event, Params, Sample, Segmenter};

use super::{Agent, Output};
use crate::contract::Now;
use crate::driver::BadLine;
use crate::driver::words::{self, SAMPLES_MAX, Samples};

/// Shortest and longest time between two samples, in microseconds.
const EVERY_US: (u64, u64) = (500, 100_000);
/// Difference between the expected and the reported time of a sample beyond which a stream begins anew, in microseconds.
const JUMP_US: u64 = 1_000_000;
/// Part by which the time of an unstamped line follows that of its receipt: lines come early and late.
const FOLLOWED: i64 = 50;

/// The stream of one whisker's samples.
#[derive(Debug)]
pub(super) struct Stream {
    segmenter: Segmenter,
    /// Time of the newest sample by the stream's clock: the board's, or moments for lines without a time.
    newest_us: Option<u64>,
}

impl Stream {
    pub(super) fn new(params: Params) -> Self {
        Self { segmenter: Segmenter::new(params), newest_us: None }
    }

    /// Time of the first sample of a line by the stream's clock. After a jump the stream begins anew.
    fn first_us(&mut self, stamp_us: Option<u64>, received_us: u64, count: u64, every_us: u64, params: Params) -> u64 {
        let last_us = received_us.saturating_sub((count - 1) * every_us);
        let (first_us, expected_us) =
            (stamp_us.unwrap_or(last_us), self.newest_us.map(|newest_us| newest_us + every_us));
        let Some(expected_us) = expected_us else { return first_us };
        if first_us.abs_diff(expected_us) > JUMP_US {
            *self = Self::new(params);
            return first_us;
        }
        match stamp_us {
            Some(stamp_us) => stamp_us,
            None => expected_us.saturating_add_signed((first_us.cast_signed() - expected_us.cast_signed()) / FOLLOWED),
        }
    }
}

/// A value for each sample: a list, or one for all.
fn value(samples: Option<&Samples>, at: usize) -> Option<f64> {
    match samples? {
        Samples::One(one) => Some(*one),
        Samples::Many(many) => many.get(at).copied(),
    }
}

impl Agent {
    /// Takes samples, and sends the contacts that end with them.
    pub(super) fn strain(&mut self, line: &words::Strain, now: Now, out: &mut Vec<Output>) -> Result<(), BadLine> {
        let (at, t_us) = self.place(&line.origin(), now)?;
        if self.chambers[at].place == PlaceKind::Ratio {
            return Err(BadLine::new(
                "strain gives no contact ratio, but agent.toml states place RATIO for the whisker",
                "state place = \"DISTANCE\", \"TIP\" or \"UNKNOWN\" there, or send `contact`",
            ));
        }
        let every_us = checked(line)?;
        let strains = line.strain.as_slice();
        let stamp_us = line.t_us.or(line.t_ms.map(|t_ms| t_ms * 1000));
        let params = self.limits.segmenter;
        let setpoint_mpa = Some(self.chambers[at].target_mpa);
        let stream = &mut self.chambers[at].stream;
        let stream = stream.get_or_insert_with(|| Box::new(Stream::new(params)));
        let first_us = stream.first_us(stamp_us, now.at.as_us(), strains.len() as u64, every_us, params);
        // From the stream's clock to the robot's.
        let begin_us = if stamp_us.is_some() { first_us } else { now.at.as_us() };
        let offset_us = t_us.cast_signed().saturating_sub(begin_us.cast_signed());
        let mut found = Vec::new();
        for (index, &strain) in strains.iter().enumerate() {
            let sample = Sample {
                t_us: first_us + index as u64 * every_us,
                strain,
                strain_2: value(line.strain_2.as_ref(), index),
                deflection_mm: value(line.deflection_mm.as_ref(), index),
                distance_mm: value(line.distance_mm.as_ref(), index),
                setpoint_mpa,
                ..Sample::default()
            };
            stream.newest_us = Some(sample.t_us);
            if let Some(Event::Contact(contact)) = stream.segmenter.push(sample) {
                found.push(contact);
            }
        }
        let mut taken = Ok(());
        for contact in found {
            if let Err(problem) = self.segmented(at, &contact, offset_us, line.test_id.clone(), now, out) {
                self.counts.contacts_unusable += 1;
                taken = taken.and(Err(problem));
            }
        }
        taken
    }

    /// Sends a contact that the segmenter has found, with the place that `agent.toml` states for the whisker.
    fn segmented(
        &mut self,
        at: usize,
        found: &Contact,
        offset_us: i64,
        test_id: Option<String>,
        now: Now,
        out: &mut Vec<Output>,
    ) -> Result<(), BadLine> {
        let chamber = &self.chambers[at];
        if found.saturated {
            return Err(BadLine::new("a contact was beyond the limit of the gauge", "touch more softly"));
        }
        let deflection_mm = found.deflection_mm.map(f64::abs).ok_or_else(|| {
            BadLine::new(
                "a contact was found, but not how far the whisker was deflected",
                "send deflection_mm with the samples: the position of the motion, with any offset",
            )
        })?;
        let gauges = found.distance.map(|distance| (distance.mm, Some(distance.sd_mm)));
        let distance = found.distance_mm.map(|mm| (mm, None)).or(gauges);
        let (distance, tip) = match chamber.place {
            // Refused before; a ratio would need the present length.
            PlaceKind::Ratio => return Ok(()),
            PlaceKind::Unknown if test_id.is_none() => (None, false),
            PlaceKind::Tip if test_id.is_none() && !found.tip => return Ok(()),
            PlaceKind::Tip => (distance, found.tip),
            PlaceKind::Distance | PlaceKind::Unknown if distance.is_none() => {
                return Err(BadLine::new(
                    "a contact was found, but not its distance from the base",
                    "send distance_mm with the samples, or strain_2 of a second gauge",
                ));
            }
            PlaceKind::Distance | PlaceKind::Unknown => (distance, false),
        };
        let contact = words::Contact {
            array: Some(chamber.array.clone()),
            whisker: chamber.number,
            t_us: Some(now.system_time_of(found.measured_us.saturating_add_signed(offset_us))),
            t_ms: None,
            deflection_mm: Some(deflection_mm),
            strain: Some(found.strain),
            ratio: None,
            ratio_sd: None,
            distance_mm: distance.map(|(mm, _)| mm),
            distance_sd_mm: distance.and_then(|(_, sd_mm)| sd_mm),
            tip,
            pressure_mpa: None,
            temperature_c: None,
            test_id,
            touched: None,
        };
        self.contact(contact, now, out)
    }
}

/// Checks the shape of a line; the time between its samples.
fn checked(line: &words::Strain) -> Result<u64, BadLine> {
    let count = line.strain.as_slice().len();
    if !(1..=SAMPLES_MAX).contains(&count) {
        return Err(BadLine::new(
            format!("{count} samples, but a line has 1 to {SAMPLES_MAX}"),
            "send shorter lists more often",
        ));
    }
    for (name, samples) in
        [("strain_2", &line.strain_2), ("deflection_mm", &line.deflection_mm), ("distance_mm", &line.distance_mm)]
    {
        if let Some(Samples::Many(many)) = samples
            && many.len() != count
        {
            let problem = format!("{name} has {} values, and strain has {count}", many.len());
            return Err(BadLine::new(problem, "send one value for each sample, or one for all"));
        }
    }
    match line.every_us {
        None if count == 1 => Ok(0),
        None => {
            Err(BadLine::new("several samples need every_us", "send the time between two samples, in microseconds"))
        }
        Some(every_us) if (EVERY_US.0..=EVERY_US.1).contains(&every_us) => Ok(every_us),
        Some(every_us) => Err(BadLine::new(
            format!("every_us is {every_us}, but must be between {} and {}", EVERY_US.0, EVERY_US.1),
            "sample at 10 to 2000 Hz; the segmenter is made for 50 to 1000 Hz",
        )),
    }
}
