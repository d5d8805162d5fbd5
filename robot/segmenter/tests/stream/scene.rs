//! Scenes: a robot with a habit, seen from any moment on, with the disturbances of real converters and robots.

use super::{Channel, DT_S, FULL, LENGTH_MM, Random, sensitivity};
use vibrissa_segmenter::Sample;

/// How a robot touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Habit {
    /// 1 s in 3, always equally deep.
    OneInThree,
    /// Ten taps at 5 Hz, always equally deep, and a pause.
    Tapping,
    /// 30 to 120 s.
    LongHolds,
    /// Along an object, to the tip or back.
    Slides,
    /// Each 5 to 20 s, of any kind.
    Rare,
    /// Never.
    Nothing,
}

pub(crate) const HABITS: [Habit; 5] = [Habit::OneInThree, Habit::Tapping, Habit::LongHolds, Habit::Slides, Habit::Rare];

/// What the robot tells of the base's way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Motion {
    None,
    /// Only while it presses: zero before and after.
    Pressed,
    /// The whole way, with the approach.
    Way,
}

/// Which way strains go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Polarity {
    Plus,
    Minus,
    Mixed,
}

/// Glitches of one to three samples.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Glitches {
    /// Part of the samples.
    pub(crate) part: f64,
    pub(crate) longest: u32,
    /// At this strain; otherwise anywhere up to two full responses.
    pub(crate) at: Option<f64>,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Scene {
    pub(crate) seed: u64,
    pub(crate) rate_hz: f64,
    pub(crate) habit: Habit,
    pub(crate) motion: Motion,
    pub(crate) polarity: Polarity,
    /// Seconds that are seen, after a beginning at any moment.
    pub(crate) seconds: f64,
    /// Gaps at a third and two thirds of the time. s.
    pub(crate) gap_s: f64,
    pub(crate) glitches: Option<Glitches>,
    /// Shaking while driving, of a full response; and whether the robot tells that it drives.
    pub(crate) driving: f64,
    pub(crate) tells_driving: bool,
    /// Steps of air, told with the samples.
    pub(crate) air: bool,
}

impl Default for Scene {
    fn default() -> Scene {
        Scene {
            seed: 1,
            rate_hz: 80.0,
            habit: Habit::Rare,
            motion: Motion::Way,
            polarity: Polarity::Plus,
            seconds: 130.0,
            gap_s: 0.0,
            glitches: None,
            driving: 0.0,
            tells_driving: false,
            air: false,
        }
    }
}

/// A touch: in, along the object, and out or off the tip.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Press {
    pub(crate) start_s: f64,
    pub(crate) rise_s: f64,
    pub(crate) hold_s: f64,
    pub(crate) fall_s: f64,
    pub(crate) depth_mm: f64,
    /// Distance of the object from the base at the begin and at the end of the hold.
    pub(crate) distance_mm: (f64, f64),
    pub(crate) slips: bool,
    pub(crate) sign: f64,
    /// Shortest rest after it.
    pub(crate) rest_s: f64,
}

impl Press {
    pub(crate) fn end_s(&self) -> f64 {
        self.start_s + self.rise_s + self.hold_s + if self.slips { 0.0 } else { self.fall_s }
    }

    /// When the base is back.
    fn over_s(&self) -> f64 {
        self.end_s() + if self.slips { 0.2 + self.fall_s } else { 0.0 } + self.rest_s
    }

    /// Way of the base against the object; negative before and after.
    fn way_mm(&self, t_s: f64) -> f64 {
        let since_s = t_s - self.start_s;
        let speed = self.depth_mm / self.rise_s;
        let top_s = self.rise_s + self.hold_s + if self.slips { 0.2 } else { 0.0 };
        let rising = since_s.max(-0.3) * speed;
        let falling = self.depth_mm - (since_s - top_s) * self.depth_mm / self.fall_s;
        rising.min(self.depth_mm).min(falling).max(-0.3 * speed)
    }

    fn deflection_mm(&self, t_s: f64) -> f64 {
        let since_s = t_s - self.end_s();
        if self.slips && since_s > 0.0 {
            return self.depth_mm * (-since_s / 0.025).exp() * (std::f64::consts::TAU * 20.0 * since_s).cos();
        }
        self.way_mm(t_s).max(0.0)
    }

    fn distance_mm(&self, t_s: f64) -> f64 {
        let part = ((t_s - self.start_s - self.rise_s) / self.hold_s.max(0.01)).clamp(0.0, 1.0);
        self.distance_mm.0 + part * (self.distance_mm.1 - self.distance_mm.0)
    }

    fn elastic(&self, t_s: f64) -> f64 {
        let distance_mm = self.distance_mm(t_s);
        let slides = (self.distance_mm.0 - self.distance_mm.1).abs() > 1.0;
        // A slide sticks and slips a little.
        let rough = if slides && t_s < self.end_s() { 1.0 + 0.03 * (60.0 * t_s).sin() } else { 1.0 };
        self.sign * sensitivity(distance_mm) * self.deflection_mm(t_s) * rough
    }

    /// Strain that a measurement should find: at the slip-off, or in the hold.
    pub(crate) fn strain(&self) -> f64 {
        super::MIDDLE * self.sign * sensitivity(self.distance_mm.1) * self.depth_mm
    }

    pub(crate) fn is_slide(&self) -> bool {
        (self.distance_mm.0 - self.distance_mm.1).abs() > 1.0
    }
}

/// Touches of a habit, one after the other.
struct Habits {
    habit: Habit,
    polarity: Polarity,
    depth_mm: f64,
    mm: f64,
    taps: u32,
}

impl Habits {
    fn next(&mut self, random: &mut Random, over_s: f64) -> Press {
        let polarity = match self.polarity {
            Polarity::Plus => 1.0,
            Polarity::Minus => -1.0,
            Polarity::Mixed if random.unit() < 0.5 => -1.0,
            Polarity::Mixed => 1.0,
        };
        let mut press =
            Press { depth_mm: self.depth_mm, distance_mm: (self.mm, self.mm), rest_s: 0.3, ..Press::default() };
        press.sign = polarity;
        // The shortest rest comes before the pause.
        let pause_s = match self.habit {
            Habit::OneInThree => {
                (press.rise_s, press.hold_s, press.fall_s) = (0.15, 0.7, 0.15);
                1.7
            }
            Habit::Tapping => {
                (press.rise_s, press.hold_s, press.fall_s) = (0.035, 0.03, 0.035);
                press.rest_s = 0.05;
                self.taps += 1;
                if self.taps.is_multiple_of(10) { random.between(1.0, 3.0) } else { 0.05 }
            }
            Habit::LongHolds => {
                let speed = random.log_between(5.0, 40.0);
                press.depth_mm = random.between(1.0, 6.0);
                press.rise_s = press.depth_mm / speed;
                press.hold_s = random.log_between(30.0, 120.0);
                press.fall_s = press.rise_s * random.between(0.7, 1.5);
                random.between(2.0, 10.0)
            }
            Habit::Slides => {
                let from_mm = random.between(35.0, 55.0);
                press.slips = random.unit() < 0.7;
                press.distance_mm =
                    (from_mm, if press.slips { LENGTH_MM } else { random.between(from_mm + 5.0, 65.0) });
                press.depth_mm = random.between(2.0, 6.0);
                press.rise_s = press.depth_mm / random.log_between(5.0, 40.0);
                press.hold_s = random.log_between(0.5, 3.0);
                press.fall_s = press.rise_s * random.between(0.7, 1.5);
                random.between(0.5, 3.0)
            }
            Habit::Rare | Habit::Nothing => {
                press.slips = random.unit() < 0.3;
                press.depth_mm = random.log_between(if press.slips { 1.5 } else { 0.8 }, 10.0);
                let mm = if press.slips { LENGTH_MM } else { random.between(30.0, LENGTH_MM) };
                press.distance_mm = (mm, mm);
                press.rise_s = press.depth_mm / random.log_between(5.0, 40.0);
                press.hold_s = if press.slips { 0.03 } else { random.log_between(0.05, 4.0) };
                press.fall_s = press.rise_s * random.between(0.7, 1.5);
                random.between(5.0, 20.0)
            }
        };
        press.start_s = over_s + pause_s;
        press
    }
}

/// Runs a scene; calls `each` with each sample, and returns the touches, in seconds of the samples.
pub(crate) fn play(scene: &Scene, mut each: impl FnMut(Sample)) -> Vec<Press> {
    let mut random = Random(scene.seed.wrapping_mul(0x9e37_79b9).wrapping_add(17));
    let mut channel = Channel::new(&mut random);
    let mut habits = Habits {
        habit: scene.habit,
        polarity: scene.polarity,
        depth_mm: random.log_between(1.0, 6.0),
        mm: random.between(35.0, 60.0),
        taps: (random.unit() * 10.0) as u32,
    };
    // The robot has touched for a while, and the stream begins at any moment.
    let begin_s =
        if scene.habit == Habit::LongHolds { random.between(130.0, 400.0) } else { random.between(5.0, 40.0) };
    let touches = scene.habit != Habit::Nothing;
    let first_s = random.between(0.0, 3.0);
    let mut press = habits.next(&mut random, first_s);
    let mut presses = Vec::new();
    let (mut habit, mut sample_s, mut t_s) = (0.0, begin_s, 0.0);
    let (mut glitch_left, mut glitch) = (0, 0.0);
    let mut drive = (0.0, 0.0, 30.0, 0.0);
    let mut air = (random.between(10.0, 30.0), 0.1, 0.1, 0.1, 0.0, 0.2);
    while t_s < begin_s + scene.seconds {
        t_s += DT_S;
        if t_s > press.over_s() {
            presses.push(press);
            habit = 0.7 * habit + 0.02 * 0.714 * random.normal();
            press = habits.next(&mut random, press.over_s());
        }
        // Air: next step, setpoint, pressure, told pressure, shift of the baseline per MPa, time constant.
        if scene.air && t_s > air.0 {
            air.0 = t_s + random.between(20.0, 40.0);
            air.1 = random.between(0.05, 0.15);
            air.5 = random.between(0.1, 0.4);
            air.4 = if air.4 == 0.0 { FULL * random.between(-4.0, 4.0) } else { air.4 };
        }
        air.2 += (air.1 - air.2) * DT_S / air.5;
        let elastic = if touches { press.elastic(t_s) * (1.0 + habit) } else { 0.0 };
        let strain = channel.respond(elastic) + air.4 * (air.2 - 0.1);
        let white = channel.white;
        channel.coloured +=
            -channel.coloured * DT_S / 0.05 + 0.5 * white * (2.0 * DT_S / 0.05).sqrt() * random.normal();
        if t_s < sample_s {
            continue;
        }
        sample_s += 1.0 / scene.rate_hz;
        let mut measured = channel.measure(&mut random, t_s, strain);
        // Driving: end of the burst, begin of the next, frequency, phase.
        if scene.driving > 0.0 && t_s > drive.0 {
            drive = (t_s + 20.0, t_s + random.between(2.0, 6.0), random.between(27.0, 33.0), random.between(0.0, 6.0));
            drive.0 = drive.1 + random.between(1.0, 4.0);
        }
        let drives = scene.driving > 0.0 && t_s > drive.1;
        if drives {
            let swing = (std::f64::consts::TAU * drive.2 * (t_s - drive.1) + drive.3).sin();
            measured += FULL * scene.driving * (0.8 * swing + 0.2 * random.normal());
        }
        if let Some(glitches) = scene.glitches {
            let mean = f64::from(glitches.longest + 1) / 2.0;
            if glitch_left == 0 && random.unit() < glitches.part / mean {
                glitch_left = 1 + (random.unit() * f64::from(glitches.longest)) as u32;
                glitch = glitches.at.unwrap_or_else(|| measured + FULL * random.between(-2.0, 2.0));
            }
            if glitch_left > 0 {
                glitch_left -= 1;
                measured = glitch;
            }
        }
        // Pressure is read four times a second.
        if ((t_s * 4.0) as u64) != (((t_s - 1.0 / scene.rate_hz) * 4.0) as u64) {
            air.3 = air.2;
        }
        let seen_s = t_s - begin_s;
        let in_gap = [1.0, 2.0].iter().any(|third| {
            let at_s = third * scene.seconds / 3.0;
            seen_s >= at_s && seen_s < at_s + scene.gap_s
        });
        if in_gap {
            continue;
        }
        let way_mm = if touches { press.way_mm(t_s) } else { 0.0 };
        each(Sample {
            t_us: (1_000_000.0 + (seen_s + random.between(-0.05, 0.05) / scene.rate_hz) * 1e6) as u64,
            strain: measured,
            deflection_mm: match scene.motion {
                Motion::None => None,
                Motion::Pressed => Some(way_mm.max(0.0)),
                Motion::Way => Some(way_mm + 0.02 * random.normal()),
            },
            pressure_mpa: scene.air.then_some(air.3),
            setpoint_mpa: scene.air.then_some(air.1),
            driving: scene.tells_driving.then_some(drives),
            ..Sample::default()
        });
    }
    if !touches {
        return Vec::new();
    }
    presses.into_iter().map(|press| Press { start_s: press.start_s - begin_s, ..press }).collect()
}
