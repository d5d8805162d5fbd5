//! Simulated streams of strain, after the stand-ins for a real whisker: creep, loop, drift, noise, mains, converter;
//! and the comparison of what the segmenter finds with the truth.

pub(crate) mod scene;
pub(crate) mod verdict;

use vibrissa_segmenter::{Contact, DistanceFusion, Event, Params, Sample, Segmenter};

/// Strain of a full response: 10 mm of deflection at 45 mm from the base.
pub(crate) const FULL: f64 = 0.005;
const LENGTH_MM: f64 = 70.0;
/// Part of the elastic response that is in the middle of creep and loop.
const MIDDLE: f64 = 0.94;
/// Step of the simulation. s.
const DT_S: f64 = 0.000_5;

/// Random numbers by SplitMix64.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    pub(crate) fn normal(&mut self) -> f64 {
        (-2.0 * (1.0 - self.unit()).ln()).sqrt() * (std::f64::consts::TAU * self.unit()).cos()
    }

    fn log_between(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.unit())
    }
}

/// What kind of stream.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plan {
    pub(crate) seed: u64,
    pub(crate) rate_hz: f64,
    pub(crate) two_gauges: bool,
    pub(crate) motion: bool,
    pub(crate) seconds: f64,
    /// Whether anything is touched.
    pub(crate) touches: bool,
}

/// A touch as it was.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Truth {
    pub(crate) start_s: f64,
    pub(crate) end_s: f64,
    pub(crate) depth_mm: f64,
    pub(crate) distance_mm: f64,
    pub(crate) slips: bool,
    /// Response without noise and variation, in the middle of creep and loop.
    pub(crate) strain: f64,
}

/// One gauge's rubber and electronics.
struct Channel {
    creep: [f64; 2],
    plays: [f64; 4],
    coloured: f64,
    white: f64,
    mains: f64,
    drift: f64,
    drift_s: f64,
    phase: f64,
    step: f64,
}

impl Channel {
    fn new(random: &mut Random) -> Channel {
        Channel {
            creep: [0.0; 2],
            plays: [0.0; 4],
            coloured: 0.0,
            white: FULL * random.log_between(0.000_3, 0.002),
            mains: FULL * random.between(0.0, 0.001),
            drift: FULL * random.between(-0.04, 0.04),
            drift_s: random.between(100.0, 400.0),
            phase: random.between(0.0, std::f64::consts::TAU),
            step: FULL / if random.unit() < 0.5 { 2_000.0 } else { 50_000.0 },
        }
    }

    /// The rubber's answer to an elastic strain.
    fn respond(&mut self, elastic: f64) -> f64 {
        let mut strain = elastic;
        for (state, time_s) in self.creep.iter_mut().zip([1.0, 30.0]) {
            *state += (elastic - *state) * DT_S / time_s;
            strain += 0.02 * *state;
        }
        let radii = [0.05, 0.1, 0.2, 0.4].map(|part| part * FULL);
        let mut loops = 0.0;
        for (play, radius) in self.plays.iter_mut().zip(radii) {
            *play = play.clamp(elastic - radius, elastic + radius);
            loops += *play / 4.0;
        }
        strain + 0.1 * (loops - elastic)
    }

    fn measure(&mut self, random: &mut Random, t_s: f64, strain: f64) -> f64 {
        let tau = std::f64::consts::TAU;
        // 10 K a day.
        let kelvin = 5.0 * (tau * t_s / 86_400.0 + self.phase).sin();
        let drift =
            self.drift * ((tau * t_s / self.drift_s + self.phase).sin() + t_s / 2_000.0) + FULL * 0.001 * kelvin;
        let mains = self.mains * (tau * 50.02 * t_s + self.phase).sin();
        let noise = self.white * random.normal() + self.coloured;
        let volts = strain * (1.0 + 0.005 * kelvin) + drift + mains + noise + 0.3 * FULL;
        (volts / self.step).round() * self.step
    }
}

/// Deflection and motion over time of one touch.
struct Course {
    truth: Truth,
    speed: f64,
    back: f64,
    hold_s: f64,
    sign: f64,
    gain: f64,
    gain_2: f64,
}

impl Course {
    fn random(random: &mut Random, start_s: f64, habit: (f64, f64)) -> Course {
        let kind = random.unit();
        let slips = kind < 0.3;
        let depth_mm = if slips { random.log_between(1.5, 10.0) } else { random.log_between(0.5, 10.0) };
        let distance_mm = if slips { LENGTH_MM } else { random.between(30.0, LENGTH_MM) };
        let speed = random.log_between(5.0, 40.0);
        let back = speed * random.between(0.7, 1.5);
        let hold_s = if slips || kind < 0.5 { 0.03 } else { random.log_between(0.15, 4.0) };
        let rise_s = depth_mm / speed;
        let end_s = start_s + rise_s + if slips { 0.0 } else { hold_s + depth_mm / back };
        let sign = if random.unit() < 0.5 { -1.0 } else { 1.0 };
        let strain = sign * sensitivity(distance_mm) * depth_mm;
        // The middle of creep and loop is the response that repeats.
        let truth = Truth { start_s, end_s, depth_mm, distance_mm, slips, strain: MIDDLE * strain };
        Course { truth, speed, back, hold_s, sign, gain: 1.0 + habit.0, gain_2: 1.0 + habit.1 }
    }

    /// When the robot is back where it began, without a touch for a while.
    fn over_s(&self) -> f64 {
        self.truth.end_s
            + if self.truth.slips { 0.2 + (self.truth.depth_mm + 0.2 * self.speed) / self.back } else { 0.3 }
    }

    /// The movement of the base against the object; negative before the touch.
    fn motion_mm(&self, t_s: f64) -> f64 {
        let since_s = t_s - self.truth.start_s;
        let top_s = self.truth.depth_mm / self.speed + if self.truth.slips { 0.2 } else { 0.0 };
        let hold_s = if self.truth.slips { 0.0 } else { self.hold_s };
        if since_s < top_s {
            (since_s.max(-0.3)) * self.speed
        } else {
            let back_s = (since_s - top_s - hold_s).max(0.0);
            (top_s * self.speed - back_s * self.back).max(-0.3 * self.speed)
        }
    }

    fn deflection_mm(&self, t_s: f64) -> f64 {
        if t_s < self.truth.end_s || !self.truth.slips {
            return self.motion_mm(t_s).max(0.0);
        }
        // Springs back and swings.
        let since_s = t_s - self.truth.end_s;
        self.truth.depth_mm * (-since_s / 0.025).exp() * (std::f64::consts::TAU * 20.0 * since_s).cos()
    }
}

/// Strain per mm of deflection.
fn sensitivity(distance_mm: f64) -> f64 {
    FULL / 10.0 * (45.0 / distance_mm).powf(2.4)
}

fn ratio(distance_mm: f64) -> f64 {
    let table = Params::default().ratios;
    let upper = table.iter().position(|(at, _)| *at > distance_mm).unwrap_or(5).max(1);
    let ((mm_0, ratio_0), (mm_1, ratio_1)) = (table[upper - 1], table[upper]);
    ratio_0 + (ratio_1 - ratio_0) * (distance_mm - mm_0) / (mm_1 - mm_0)
}

/// Runs a stream; calls `each` with each sample, and returns the touches.
pub(crate) fn stream(plan: &Plan, mut each: impl FnMut(Sample)) -> Vec<Truth> {
    let mut random = Random(plan.seed);
    let mut channels = [Channel::new(&mut random), Channel::new(&mut random)];
    let (mut habit, mut habit_2) = (0.0, 0.0);
    let shared = 1.0 + 0.01 * random.normal();
    let mut truths = Vec::new();
    let next = |random: &mut Random, habit: (f64, f64), from_s: f64| {
        let start_s = from_s + random.between(0.5, 4.0);
        Course::random(random, start_s, habit)
    };
    let mut course = plan.touches.then(|| next(&mut random, (0.0, 0.0), 2.0));
    let (mut sample_s, mut t_s) = (0.0, 0.0);
    while t_s < plan.seconds {
        t_s += DT_S;
        let mut elastic = [0.0; 2];
        let mut motion_mm = 0.0;
        if let Some(now) = &course {
            let strain = now.sign * sensitivity(now.truth.distance_mm) * now.deflection_mm(t_s);
            elastic = [strain * now.gain, strain * ratio(now.truth.distance_mm) * shared * now.gain_2];
            motion_mm = now.motion_mm(t_s);
            if t_s > now.over_s() {
                truths.push(now.truth);
                habit = 0.7 * habit + 0.02 * 0.714 * random.normal();
                habit_2 = 0.7 * habit_2 + 0.02 * 0.714 * random.normal();
                // What both gauges share, and what the second has of its own.
                course = Some(next(&mut random, (habit, habit + 1.5 * habit_2), t_s));
            }
        }
        let strains = [channels[0].respond(elastic[0]), channels[1].respond(elastic[1])];
        for channel in &mut channels {
            // Coloured noise with 50 ms.
            let white = channel.white;
            channel.coloured +=
                -channel.coloured * DT_S / 0.05 + 0.5 * white * (2.0 * DT_S / 0.05).sqrt() * random.normal();
        }
        if t_s < sample_s {
            continue;
        }
        sample_s += 1.0 / plan.rate_hz;
        let mut measured = [0, 1].map(|index| channels[index].measure(&mut random, t_s, strains[index]));
        // A glitch about once a minute.
        if random.unit() < 1.0 / (60.0 * plan.rate_hz) {
            measured[0] += FULL * random.between(-2.0, 2.0);
        }
        let jitter_us = random.between(-0.05, 0.05) / plan.rate_hz * 1e6;
        each(Sample {
            t_us: (1_000_000.0 + t_s * 1e6 + jitter_us) as u64,
            strain: measured[0],
            strain_2: plan.two_gauges.then_some(measured[1]),
            deflection_mm: plan.motion.then_some(motion_mm + 0.02 * random.normal()),
            ..Sample::default()
        });
    }
    truths
}

/// How well the segmenter did.
#[derive(Clone, Debug, Default)]
pub(crate) struct Score {
    pub(crate) hours: f64,
    /// Touches, and those that were found, of 0.5 to 1, 1 to 3, and 3 to 10 mm.
    pub(crate) touches: [u32; 3],
    pub(crate) found: [u32; 3],
    pub(crate) false_contacts: u32,
    pub(crate) slips: u32,
    pub(crate) slips_found: u32,
    pub(crate) others: u32,
    pub(crate) false_slips: u32,
    /// Absolute errors of the onset, and delays of its event. ms.
    pub(crate) onset_ms: Vec<f64>,
    pub(crate) delay_ms: Vec<f64>,
    /// Relative errors of the strain, and how many are within two standard deviations.
    pub(crate) strain: Vec<f64>,
    pub(crate) strain_within: u32,
    pub(crate) deflection_mm: Vec<f64>,
    pub(crate) distances: u32,
    pub(crate) distances_within: u32,
    pub(crate) distance_sd_mm: f64,
}

impl Score {
    pub(crate) fn found_part(&self) -> f64 {
        f64::from(self.found.iter().sum::<u32>()) / f64::from(self.touches.iter().sum::<u32>()).max(1.0)
    }

    pub(crate) fn false_per_hour(&self) -> f64 {
        f64::from(self.false_contacts) / self.hours
    }

    pub(crate) fn slip_part(&self) -> f64 {
        f64::from(self.slips_found) / f64::from(self.slips).max(1.0)
    }

    pub(crate) fn false_slip_part(&self) -> f64 {
        f64::from(self.false_slips) / f64::from(self.others).max(1.0)
    }

    pub(crate) fn add(&mut self, other: Score) {
        self.hours += other.hours;
        for index in 0..3 {
            self.touches[index] += other.touches[index];
            self.found[index] += other.found[index];
        }
        self.false_contacts += other.false_contacts;
        self.slips += other.slips;
        self.slips_found += other.slips_found;
        self.others += other.others;
        self.false_slips += other.false_slips;
        self.onset_ms.extend(other.onset_ms);
        self.delay_ms.extend(other.delay_ms);
        self.strain.extend(other.strain);
        self.strain_within += other.strain_within;
        self.deflection_mm.extend(other.deflection_mm);
        self.distances += other.distances;
        self.distances_within += other.distances_within;
        self.distance_sd_mm += other.distance_sd_mm;
    }
}

/// The value below which this part of the values lies.
pub(crate) fn quantile(values: &[f64], part: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(((sorted.len() as f64 - 1.0) * part).round() as usize).copied().unwrap_or(f64::NAN)
}

/// Runs a segmenter on a stream and compares.
pub(crate) fn evaluate(plan: &Plan, params: Params) -> Score {
    let mut segmenter = Segmenter::new(params);
    let mut onsets: Vec<u64> = Vec::new();
    let mut contacts: Vec<(Contact, u64)> = Vec::new();
    let truths = stream(plan, |sample| match segmenter.push(sample) {
        Some(Event::Onset { found_us, .. }) => onsets.push(found_us),
        Some(Event::Contact(contact)) => contacts.push((contact, onsets.last().copied().unwrap_or(0))),
        None => {}
    });
    let mut score = Score { hours: plan.seconds / 3_600.0, ..Score::default() };
    let mut used = vec![false; contacts.len()];
    let seconds = |us: u64| us as f64 * 1e-6 - 1.0;
    let last_end_s = truths.last().map_or(plan.seconds, |truth| truth.end_s + 0.5);
    for truth in &truths {
        let class = if truth.depth_mm < 1.0 { 0 } else { usize::from(truth.depth_mm >= 3.0) + 1 };
        score.touches[class] += 1;
        let hit = contacts.iter().enumerate().position(|(index, (contact, _))| {
            !used[index] && seconds(contact.onset_us) < truth.end_s + 0.05 && seconds(contact.end_us) > truth.start_s
        });
        let Some(index) = hit else {
            continue;
        };
        used[index] = true;
        score.found[class] += 1;
        let (contact, found_us) = contacts[index];
        compare(&mut score, truth, &contact, seconds(found_us));
    }
    score.false_contacts = used
        .iter()
        .zip(&contacts)
        .filter(|(used, (contact, _))| !**used && seconds(contact.end_us) < last_end_s)
        .count() as u32;
    score
}

fn compare(score: &mut Score, truth: &Truth, contact: &Contact, found_s: f64) {
    let onset_s = contact.onset_us as f64 * 1e-6 - 1.0;
    score.onset_ms.push((onset_s - truth.start_s).abs() * 1e3);
    score.delay_ms.push((found_s - truth.start_s) * 1e3);
    let error = contact.strain - truth.strain;
    score.strain.push(error / truth.strain);
    score.strain_within += u32::from(error.abs() < 2.0 * contact.strain_sd);
    if truth.slips {
        score.slips += 1;
        score.slips_found += u32::from(contact.tip);
    } else {
        score.others += 1;
        score.false_slips += u32::from(contact.tip);
    }
    if let Some(mm) = contact.deflection_mm {
        score.deflection_mm.push(mm - truth.depth_mm);
    }
    if let Some(distance) = contact.distance {
        score.distances += 1;
        score.distances_within += u32::from((distance.mm - truth.distance_mm).abs() < 2.0 * distance.sd_mm);
        score.distance_sd_mm += distance.sd_mm;
    }
}

/// Fuses the ratios of ten contacts at one distance: (fused, within two standard deviations, sum of the sds).
pub(crate) fn fused(seed: u64, rounds: u32, params: &Params) -> (u32, u32, f64) {
    let mut random = Random(seed);
    let (mut within, mut sds) = (0, 0.0);
    for _ in 0..rounds {
        let mm = random.between(30.0, 70.0);
        let shared = 1.0 + params.ratio_shared_sd * random.normal();
        let mut fusion = DistanceFusion::default();
        for _ in 0..10 {
            let sd = ratio(mm) * params.ratio_sd;
            fusion.add(ratio(mm) * shared + sd * random.normal(), sd);
        }
        let distance = fusion.distance(params).expect("ten contacts");
        within += u32::from((distance.mm - mm).abs() < 2.0 * distance.sd_mm);
        sds += distance.sd_mm;
    }
    (rounds, within, sds)
}
