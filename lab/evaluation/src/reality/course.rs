//! The course of a robot's life that its whiskers share: time, habits, temperature, scale.

use std::f64::consts::TAU;

use rand::Rng;
use rand_chacha::ChaCha8Rng;

use super::nuisances::{DEFLECTION_MAX_MM, Nuisances};
use super::whisker::{Habit, stream};

/// Rounds of contacts between two pauses.
const ROUNDS_A_BOUT: u64 = 40;
/// Mean pause between two bouts, s.
const PAUSE_S: f64 = 80.0;
/// Shortest and longest time from a touch to its reading, s: equally likely on a logarithmic scale.
const HELD_S: (f64, f64) = (0.1, 3.0);
/// Time between two rounds of a bout, s.
const BETWEEN_S: f64 = 0.2;
/// Amplitude of the daily swing of the temperature, K.
const SWING_K: f64 = 5.0;
const DAY_S: f64 = 86_400.0;
/// Rounds between two changes of habit.
const HABIT_ROUNDS: (u64, u64) = (500, 2500);
/// Rounds between two steps of the scale.
const STEP_ROUNDS: (u64, u64) = (300, 5000);
/// Rounds that a slow movement of the camera takes.
const CAMERA_ROUNDS: u64 = 2000;
/// Random stream of the camera.
const CAMERA_STREAM: u64 = u64::MAX - 20;
/// Period, in rounds, with which `heading_deg` swings to both sides.
const TURN_ROUNDS: f64 = 6000.0;
/// Temperature at installation, degrees Celsius.
const INSTALLED_C: f64 = 24.0;
/// Share of the steps that the temperature causes, so that the thermometer shows them. Nothing shows the others.
const WARM_STEPS: f64 = 0.5;
/// Change of the temperature in a warm step, K per log sensitivity of its size: that of a rubber with 0.5 % per K.
/// Whiskers with coefficients of their own respond to this change by those instead.
const STEP_K: f64 = 200.0;
/// Ranges of contact ratios among which habits change.
const ZONES: [(f64, f64); 2] = [(0.8, 0.9), (0.5, 0.6)];
/// Ranges of deflections among which habits change.
const DEFLECTIONS_MM: [(f64, f64); 3] = [(0.2, DEFLECTION_MAX_MM), (0.2, 2.0), (3.0, DEFLECTION_MAX_MM)];

/// Circumstances that the whiskers of a robot share.
#[derive(Debug, Clone)]
pub struct Course {
    nuisances: Nuisances,
    random: ChaCha8Rng,
    /// Number of rounds so far.
    pub round: u64,
    /// Time since the installation, s.
    pub now_s: f64,
    /// Time between the last two rounds, s.
    pub pause_s: f64,
    /// Time from the touches of this round to their readings, s.
    pub held_s: f64,
    /// Where and how hard the robot touches.
    pub habit: Habit,
    /// Change of all sensitivities, in log sensitivity, apart from each whisker's coefficient of temperature.
    pub log_shift: f64,
    /// Present error of all contact ratios.
    pub ratio_off: f64,
    /// Largest change of `ratio_off` in a round, until it is `ratio_goal`.
    ratio_moves: f64,
    ratio_goal: f64,
    /// Round in which the camera moves next.
    next_move: u64,
    camera: ChaCha8Rng,
    /// Present angle of the robot's contacts to the direction in which it drives, degrees.
    pub heading_deg: f64,
    /// Deviation that a warm step shows on the thermometer, K.
    step_k: f64,
    /// Phase of the daily swing and of the heading at the start, rad.
    phase: f64,
    zone: usize,
    next_habit: u64,
    next_step: u64,
}

impl Course {
    /// The start of a robot's life.
    #[must_use]
    pub fn new(nuisances: Nuisances, seed: u64) -> Self {
        let mut random = stream(seed, u64::MAX);
        let phase = random.random_range(0.0..TAU);
        let zone = random.random_range(0..ZONES.len() * DEFLECTIONS_MM.len());
        let next_habit = random.random_range(HABIT_ROUNDS.0..=HABIT_ROUNDS.1);
        let next_step = random.random_range(STEP_ROUNDS.0..=STEP_ROUNDS.1);
        let mut camera = stream(seed, CAMERA_STREAM);
        let next_move = camera.random_range(STEP_ROUNDS.0..=STEP_ROUNDS.1);
        let mut course = Self {
            nuisances,
            random,
            round: 0,
            now_s: 0.0,
            pause_s: 60.0,
            held_s: HELD_S.0,
            habit: Habit::ANY,
            log_shift: 0.0,
            ratio_off: 0.0,
            ratio_moves: 0.0,
            ratio_goal: 0.0,
            next_move,
            camera,
            heading_deg: 0.0,
            step_k: 0.0,
            phase,
            // The deflections begin with their full range.
            zone: zone % ZONES.len(),
            next_habit,
            next_step,
        };
        course.take_up_habit(0);
        course
    }

    /// Goes on to the readings of the next round.
    pub fn go_on(&mut self) {
        self.round += 1;
        let [held, pause]: [f64; 2] = std::array::from_fn(|_| self.random.random());
        self.held_s = HELD_S.0 * (HELD_S.1 / HELD_S.0).powf(held);
        self.pause_s = if self.round.is_multiple_of(ROUNDS_A_BOUT) { -PAUSE_S * (1.0 - pause).ln() } else { BETWEEN_S };
        self.now_s += self.pause_s + self.held_s;
        if self.round >= self.next_habit {
            self.next_habit += self.random.random_range(HABIT_ROUNDS.0..=HABIT_ROUNDS.1);
            self.zone += 1;
            let deflections = self.random.random_range(0..DEFLECTIONS_MM.len());
            self.take_up_habit(deflections);
        }
        if self.round >= self.next_step {
            self.next_step += self.random.random_range(STEP_ROUNDS.0..=STEP_ROUNDS.1);
            self.step();
        }
        if self.nuisances.ratio_off > 0.0 {
            self.follow_camera();
        }
        let turn = TAU * self.round as f64 / TURN_ROUNDS;
        self.heading_deg = self.nuisances.turn_deg * (turn + self.phase).sin();
    }

    /// The camera moves away or back, at once or slowly.
    fn follow_camera(&mut self) {
        if self.round >= self.next_move {
            self.next_move += CAMERA_ROUNDS + self.camera.random_range(STEP_ROUNDS.0..=STEP_ROUNDS.1);
            let [up, slow]: [f64; 2] = std::array::from_fn(|_| self.camera.random());
            let away = if up < 0.5 { self.nuisances.ratio_off } else { -self.nuisances.ratio_off };
            self.ratio_goal = if self.ratio_goal == 0.0 { away } else { 0.0 };
            let rounds = if slow < 0.5 { CAMERA_ROUNDS as f64 } else { 1.0 };
            self.ratio_moves = (self.ratio_goal - self.ratio_off).abs() / rounds;
        }
        let left = self.ratio_goal - self.ratio_off;
        self.ratio_off += left.clamp(-self.ratio_moves, self.ratio_moves);
    }

    fn take_up_habit(&mut self, deflections: usize) {
        if self.nuisances.zones {
            self.habit.ratios = ZONES[self.zone % ZONES.len()];
        }
        if self.nuisances.curvature_per_mm > 0.0 {
            self.habit.deflections_mm = DEFLECTIONS_MM[deflections];
        }
    }

    /// Steps away from the state at the installation, or back to it.
    fn step(&mut self) {
        let [up, warm]: [f64; 2] = std::array::from_fn(|_| self.random.random());
        if self.log_shift != 0.0 || self.step_k != 0.0 {
            (self.log_shift, self.step_k) = (0.0, 0.0);
            return;
        }
        let log_shift = if up < 0.5 { self.nuisances.step } else { -self.nuisances.step };
        let is_warm = warm < WARM_STEPS;
        self.step_k = if is_warm { STEP_K * log_shift } else { 0.0 };
        self.log_shift = if is_warm && self.has_coefficients() { 0.0 } else { log_shift };
    }

    /// Deviation of the temperature from that at installation, K, to which whiskers with a coefficient respond.
    #[must_use]
    pub fn warmer_k(&self) -> f64 {
        if !self.has_coefficients() {
            return 0.0;
        }
        let at = |seconds: f64| SWING_K * (TAU * seconds / DAY_S + self.phase).sin();
        at(self.now_s) - at(0.0) + self.step_k
    }

    /// Whether the whiskers have temperature coefficients of their own. A warm step acts through them then.
    fn has_coefficients(&self) -> bool {
        self.nuisances.temperature > 0.0
    }

    /// Temperature that the robot reports, degrees Celsius.
    #[must_use]
    pub fn temperature_c(&self) -> f64 {
        INSTALLED_C + if self.has_coefficients() { self.warmer_k() } else { self.step_k }
    }
}
