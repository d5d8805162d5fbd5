//! Samples of strain gauges, of which the segmenter makes contacts.

use vibrissa_protocol::PlaceKind;
use vibrissa_segmenter::{Condition, Contact, Counts, Event, Params, Sample, Segmenter};

use super::doubt::Doubt;
use super::motion::Joined;
use super::{Agent, Output};
use crate::config::Sign;
use crate::contract::Now;
use crate::driver::BadLine;
use crate::driver::words::{self, Origin, SAMPLES_MAX, Samples};

/// Shortest and longest time between two samples, in microseconds.
const EVERY_US: (u64, u64) = (500, 100_000);
/// Difference between the expected and the reported time of a sample beyond which lines are missing or the clock was set, in
/// microseconds.
const JUMP_US: u64 = 1_000_000;
/// Longest gap after which the segmenter still knows the levels of the strain, in microseconds.
const REMEMBERED_US: u64 = 60_000_000;
/// Part by which the time of an unstamped line follows that of its receipt: lines come early and late.
const FOLLOWED: i64 = 50;

/// The stream of one whisker's samples.
#[derive(Debug)]
pub(super) struct Stream {
    segmenter: Segmenter,
    /// Time of the newest sample by the stream's clock: the board's, or moments for lines without a time.
    newest_us: Option<u64>,
    doubt: Doubt,
    /// Counts of the segmenter at the last call of [`Stream::left_out`].
    counts: Counts,
}

impl Stream {
    pub(super) fn new(params: Params) -> Self {
        Self { segmenter: Segmenter::new(params), newest_us: None, doubt: Doubt::default(), counts: Counts::default() }
    }

    /// Contacts that the segmenter has left out since the last call, with the reason.
    fn left_out(&mut self) -> [(&'static str, u64); 2] {
        let now = self.segmenter.counts();
        let before = std::mem::replace(&mut self.counts, now);
        [
            ("samples were missing in a contact or right after it", now.interrupted - before.interrupted),
            ("a contact began before it was known which strain is rest", now.doubtful - before.doubtful),
        ]
    }

    /// How far the contacts can be relied on.
    pub(super) fn condition(&self) -> Condition {
        self.segmenter.condition()
    }

    /// Time of the first sample of a line by the stream's clock. After a step back or a long gap the stream begins anew.
    fn first_us(&mut self, stamp_us: Option<u64>, received_us: u64, count: u64, every_us: u64, params: Params) -> u64 {
        let last_us = received_us.saturating_sub((count - 1) * every_us);
        let (first_us, expected_us) =
            (stamp_us.unwrap_or(last_us), self.newest_us.map(|newest_us| newest_us + every_us));
        let Some(expected_us) = expected_us else { return first_us };
        if first_us.abs_diff(expected_us) > JUMP_US {
            if !(expected_us..expected_us + REMEMBERED_US).contains(&first_us) {
                *self = Self::new(params);
            }
            return first_us;
        }
        match stamp_us {
            Some(stamp_us) => stamp_us,
            // A single sample tells no spacing: it has the time of its receipt.
            None if every_us == 0 => first_us.max(expected_us + 1),
            None => expected_us.saturating_add_signed((first_us.cast_signed() - expected_us.cast_signed()) / FOLLOWED),
        }
    }
}

/// A value for each sample: a list, or one for all.
pub(super) fn value(samples: Option<&Samples>, at: usize) -> Option<f64> {
    match samples? {
        Samples::One(one) => Some(*one),
        Samples::Many(many) => many.get(at).copied(),
    }
}

impl Agent {
    /// Takes samples, and sends the contacts that end with them.
    pub(super) fn strain(
        &mut self,
        from: usize,
        line: &words::Strain,
        now: Now,
        out: &mut Vec<Output>,
    ) -> Result<(), BadLine> {
        let every_us = checked(line)?;
        let strains = line.strain.as_slice();
        let span_us = (strains.len() as u64 - 1) * every_us;
        let (at, t_us) = self.place(from, &Origin { span_us, ..line.origin() }, now)?;
        if self.chambers[at].place == PlaceKind::Ratio && !self.is_shared(at) {
            return Err(BadLine::new(
                "strain gives no contact ratio, but agent.toml states place RATIO for the whisker",
                "state place = \"DISTANCE\", \"TIP\" or \"UNKNOWN\" there, or send `contact`",
            ));
        }
        self.hold_gauge(at, from)?;
        let stamp_us = line.t_us.or(line.t_ms.map(|t_ms| t_ms * 1000));
        let driving = self.drives(at);
        let chamber = &mut self.chambers[at];
        let params = Params { sign: chamber.sign.map_or(0.0, Sign::factor), ..self.limits.segmenter };
        let setpoint_mpa = Some(chamber.target_mpa);
        let pressure_mpa = chamber.present_reading().map(|reading| reading.pressure_mpa);
        let (stream, motion) = (&mut chamber.stream, &mut chamber.motion);
        let stream = stream.get_or_insert_with(|| Box::new(Stream::new(params)));
        let first_us = stream.first_us(stamp_us, now.at.as_us(), strains.len() as u64, every_us, params);
        if stream.newest_us.is_none() {
            motion.forget_waiting();
        }
        // From the stream's clock to the robot's.
        let begin_us = if stamp_us.is_some() { first_us } else { now.at.as_us() };
        let offset_us = t_us.cast_signed().saturating_sub(begin_us.cast_signed());
        let is_whole = line.deflection_mm.is_some() || motion.from(now).is_none();
        // What waits comes first.
        let mut samples = if is_whole { motion.flush() } else { Vec::new() };
        for (index, &strain) in strains.iter().enumerate() {
            let sample = Sample {
                t_us: first_us + index as u64 * every_us,
                strain,
                strain_2: value(line.strain_2.as_ref(), index),
                deflection_mm: value(line.deflection_mm.as_ref(), index),
                distance_mm: value(line.distance_mm.as_ref(), index),
                pressure_mpa,
                setpoint_mpa,
                driving,
                ..Sample::default()
            };
            stream.newest_us = Some(sample.t_us);
            if is_whole {
                samples.push((sample, offset_us));
            } else {
                motion.wait(sample, offset_us, now);
            }
        }
        samples.extend(motion.ready(now));
        self.feel(at, from, samples, line.test_id.as_deref(), now, out)
    }

    /// Gives samples to the segmenter, and sends the contacts that end with them; the first problem of one.
    pub(super) fn feel(
        &mut self,
        at: usize,
        from: usize,
        samples: Vec<Joined>,
        test_id: Option<&str>,
        now: Now,
        out: &mut Vec<Output>,
    ) -> Result<(), BadLine> {
        let (mut found, mut findings) = (Vec::new(), Vec::new());
        let chamber = &mut self.chambers[at];
        let gauge_watch = &mut chamber.gauge_watch;
        let Some(stream) = &mut chamber.stream else { return Ok(()) };
        for (sample, offset_us) in samples {
            findings.extend(gauge_watch.sample(sample.strain, sample.deflection_mm, stream.segmenter.reference()));
            let saturated = gauge_watch.is_end(sample.strain);
            if let Some(Event::Contact(contact)) = stream.segmenter.push(Sample { saturated, ..sample }) {
                let saturated = gauge_watch.ended() || contact.saturated;
                found.push((Contact { saturated, ..contact }, offset_us));
            }
        }
        let left_out = stream.left_out();
        let remedy = stream.doubt.watch(stream.segmenter.condition(), now.at);
        if let Some(remedy) = remedy {
            out.push(Output::Warn(format!("whisker {}/{}: {remedy}", chamber.array, chamber.number)));
        }
        findings.into_iter().for_each(|finding| self.warn_of_gauge(at, Some(finding), out));
        for (reason, contacts) in left_out {
            self.counts.contacts_unusable += contacts;
            (0..contacts).for_each(|_| self.chambers[at].count_unused(reason));
        }
        let mut taken = Ok(());
        for (contact, offset_us) in found {
            let t_us = contact.measured_us.saturating_add_signed(offset_us);
            let test_id = test_id.or_else(|| self.chambers[at].motion.test_at(t_us)).map(str::to_owned);
            let sent = match self.segmented(at, &contact, t_us, test_id) {
                Ok(Some(line)) => self.send_contact(from, at, t_us, line, now, out),
                Ok(None) => {
                    self.chambers[at].count_unused("a contact was not at the tip");
                    continue;
                }
                Err(bad) => Err(bad),
            };
            if let Err(bad) = sent {
                self.counts.contacts_unusable += 1;
                self.chambers[at].count_unused(&bad.problem);
                taken = taken.and(Err(bad));
            }
        }
        taken
    }

    /// A contact that the segmenter has found, with the place that `agent.toml` states for the whisker; none if it is
    /// not at that place.
    fn segmented(
        &self,
        at: usize,
        found: &Contact,
        t_us: u64,
        test_id: Option<String>,
    ) -> Result<Option<words::Contact>, BadLine> {
        let chamber = &self.chambers[at];
        let deflection_mm = found.deflection_mm.map(f64::abs).ok_or_else(|| {
            BadLine::new(
                "a contact was found, but not how far the whisker was deflected",
                "send deflection_mm, the position of the motion, with the samples, or as `motion` of another driver",
            )
        })?;
        let gauges = found.distance.map(|distance| (distance.mm, Some(distance.sd_mm)));
        let distance = found.distance_mm.map(|mm| (mm, None)).or(gauges);
        let ratio = chamber.motion.at(t_us).and_then(|point| point.ratio);
        let (distance, tip) = match chamber.place {
            PlaceKind::Unknown if test_id.is_none() => (None, false),
            PlaceKind::Tip if test_id.is_none() && !found.tip => return Ok(None),
            PlaceKind::Tip => (distance, found.tip),
            PlaceKind::Ratio if ratio.is_none() && distance.is_none() => {
                return Err(BadLine::new(
                    "a contact was found, but not its ratio",
                    "let the driver of the motion send ratio, or state another place in agent.toml",
                ));
            }
            PlaceKind::Ratio => (distance.filter(|_| ratio.is_none()), false),
            PlaceKind::Distance | PlaceKind::Unknown if distance.is_none() => {
                return Err(BadLine::new(
                    "a contact was found, but not its distance from the base",
                    "send distance_mm with the samples or the motion, or strain_2 of a second gauge",
                ));
            }
            PlaceKind::Distance | PlaceKind::Unknown => (distance, false),
        };
        Ok(Some(words::Contact {
            array: Some(chamber.array.clone()),
            whisker: chamber.number,
            t_us: None,
            t_ms: None,
            deflection_mm: Some(deflection_mm),
            // The supervisor expects that a touch gives a positive strain.
            strain: Some(found.strain * chamber.sign.map_or(1.0, Sign::factor)),
            saturated: found.saturated,
            ratio: ratio.filter(|_| chamber.place == PlaceKind::Ratio),
            ratio_sd: None,
            distance_mm: distance.map(|(mm, _)| mm),
            distance_sd_mm: distance.and_then(|(_, sd_mm)| sd_mm),
            tip,
            pressure_mpa: None,
            temperature_c: None,
            test_id,
            touched: None,
        }))
    }
}

/// Checks the shape of a line; the time between its samples.
fn checked(line: &words::Strain) -> Result<u64, BadLine> {
    let others =
        [("strain_2", &line.strain_2), ("deflection_mm", &line.deflection_mm), ("distance_mm", &line.distance_mm)];
    spacing_us(line.strain.as_slice().len(), line.every_us, "strain", &others)
}

/// Checks how many values a line has; the time between two of them.
pub(super) fn spacing_us(
    count: usize,
    every_us: Option<u64>,
    first: &str,
    others: &[(&str, &Option<Samples>)],
) -> Result<u64, BadLine> {
    if !(1..=SAMPLES_MAX).contains(&count) {
        return Err(BadLine::new(
            format!("{count} samples, but a line has 1 to {SAMPLES_MAX}"),
            "send shorter lists more often",
        ));
    }
    for (name, samples) in others {
        if let Some(Samples::Many(many)) = samples
            && many.len() != count
        {
            let problem = format!("{name} has {} values, and {first} has {count}", many.len());
            return Err(BadLine::new(problem, "send one value for each sample, or one for all"));
        }
    }
    match every_us {
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
