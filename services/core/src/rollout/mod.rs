//! Staged roll-outs of a policy or calibration: which robots it applies to, and when it goes on or is rolled back.
//!
//! A roll-out has two trial stages, about 5 % and 25 % of the fleet's robots; then the change applies to all. In each stage
//! the measured compensation errors of changed and unchanged robots are compared by [`rank::greater`]. The unit is the
//! robot: errors of one robot depend on each other. There are at most [`LOOKS_PER_STAGE`] looks in each of the
//! [`TRIAL_STAGES`] stages, at fixed numbers of changed robots with an error, and each look gets an equal part of the level
//! (Bonferroni). By the union bound a change that makes no difference is rolled back with at most the stated probability,
//! however the looks depend on each other.

pub mod rank;

/// Number of stages that compare changed robots with unchanged ones.
pub const TRIAL_STAGES: u32 = 2;
/// Most looks at the errors in each stage.
pub const LOOKS_PER_STAGE: u32 = 3;

/// A stage of a roll-out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// About 5 % of the robots are changed.
    Few,
    /// About 25 % of the robots are changed.
    Quarter,
    /// All robots are changed: the change is in force.
    All,
}

impl Stage {
    /// Share of the robots that are changed.
    #[must_use]
    pub const fn share(self) -> f64 {
        match self {
            Self::Few => 0.05,
            Self::Quarter => 0.25,
            Self::All => 1.0,
        }
    }

    /// The next stage; the last one stays.
    #[must_use]
    pub const fn next(self) -> Self {
        match self {
            Self::Few => Self::Quarter,
            Self::Quarter | Self::All => Self::All,
        }
    }
}

/// Place of a robot in the order in which a roll-out changes robots: 0 to 2^32 - 1. It depends only on the roll-out's seed
/// and the robot's name, so every supervisor computes the same, and each roll-out has another order.
#[must_use]
pub fn place(seed: u64, robot: &str) -> u32 {
    // FNV-1a over seed and name; then the finaliser of SplitMix64, because the low bits of FNV hardly mix.
    let bytes = seed.to_le_bytes().into_iter().chain(robot.bytes());
    let mut hash =
        bytes.fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3));
    hash = (hash ^ (hash >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    hash = (hash ^ (hash >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((hash ^ (hash >> 31)) >> 32) as u32
}

/// Greatest place of a robot that a stage changes: that of the robot which completes the share, at least of one robot. It
/// stays for the stage, so robots that join later do not move others. `before` is the limit of the stage before.
#[must_use]
pub fn limit(stage: Stage, places: &mut [u32], before: u32) -> u32 {
    if stage == Stage::All {
        return u32::MAX;
    }
    if places.is_empty() {
        return before.max((stage.share() * f64::from(u32::MAX)) as u32);
    }
    places.sort_unstable();
    let count = (stage.share() * places.len() as f64).ceil() as usize;
    places[count.clamp(1, places.len()) - 1].max(before)
}

/// Rules of a roll-out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rules {
    /// Probability that a change without an effect is rolled back, at most: 0.001 to 0.2.
    pub level: f64,
    /// Number of changed robots with a measured error that complete a stage: 4 to 1000.
    pub robots: u32,
}

impl Rules {
    /// Least and greatest level.
    pub const LEVELS: (f64, f64) = (0.001, 0.2);
    /// Least and greatest number of changed robots with an error.
    pub const ROBOTS: (u32, u32) = (4, 1000);

    /// Probability below which a look rolls the change back.
    #[must_use]
    pub fn threshold(self) -> f64 {
        self.level / f64::from(TRIAL_STAGES * LOOKS_PER_STAGE)
    }

    /// Number of changed robots with an error at which a look of a stage is due: a quarter, a half, and all of `robots`.
    #[must_use]
    pub fn due_at(self, look: u32) -> u32 {
        match look {
            0 => self.robots.div_ceil(4),
            1 => self.robots.div_ceil(2),
            _ => self.robots,
        }
    }
}

/// Result of a comparison.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Verdict {
    /// No look is due: too few robots have a measured error.
    Wait,
    /// Nothing speaks against the change; more robots are needed.
    Continue(Look),
    /// Nothing speaks against the change, and enough robots have an error: the next stage follows.
    Advance(Look),
    /// The changed robots are worse: the change is rolled back.
    RollBack(Look),
}

/// A look at the errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    /// Number of looks in this stage, with this one.
    pub looks: u32,
    /// Probability that chance alone makes the changed robots look so much worse.
    pub probability: f64,
}

/// Compares the errors of changed and unchanged robots, one value for each robot. `looks` is the number of looks in this
/// stage so far. A look that was skipped because many errors came at once is not made up for: the level is not exceeded.
#[must_use]
pub fn review(rules: Rules, looks: u32, changed: &[f64], unchanged: &[f64]) -> Verdict {
    let measured = changed.len() as u32;
    let controls = unchanged.len() as u32;
    if looks >= LOOKS_PER_STAGE || measured < rules.due_at(looks) || controls < rules.due_at(looks) {
        return Verdict::Wait;
    }
    let both = measured.min(controls);
    let reached = (looks..LOOKS_PER_STAGE).rev().find(|&look| both >= rules.due_at(look)).unwrap_or(looks);
    let look = Look { looks: reached + 1, probability: rank::greater(changed, unchanged) };
    if look.probability <= rules.threshold() {
        Verdict::RollBack(look)
    } else if look.looks == LOOKS_PER_STAGE {
        Verdict::Advance(look)
    } else {
        Verdict::Continue(look)
    }
}
