//! Parameters with defaults.

/// Parameters of a [`crate::Segmenter`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Params {
    /// A change of strain below this is no contact, however small the noise is. m/m.
    pub least_strain: f64,
    /// Strain at which a gauge is at its limit. m/m.
    pub strain_limit: f64,
    /// Which way a touch moves the strain: 1 or -1; 0 if that is not known, or may be both.
    pub sign: f64,
    /// Fewest samples a second with which contacts can be told. Hz.
    pub least_rate_hz: f64,
    /// A sample is a jump if it is this many mean differences of neighbours away.
    pub glitch_sds: f64,
    /// Threshold of the onset in standard deviations of the noise; two consecutive bins must exceed it.
    pub onset_sds: f64,
    /// Time constant of the baseline while nothing touches. s.
    pub baseline_s: f64,
    /// Part of the largest strain below which a contact has ended: more than creep and loop leave behind.
    pub release: f64,
    /// Longest contact that is certain without a deflection: a longer one may be a baseline that has moved. s.
    pub longest_s: f64,
    /// A gap after which rest is learned anew. s.
    pub forget_s: f64,
    /// Longest time that a slip-off takes. s.
    pub slip_s: f64,
    /// A slip-off falls faster than this part of the time of the rise.
    pub slip_of_rise: f64,
    /// With motion: a slip-off is a fall of the strain while less than this part of the deflection goes back.
    pub slip_of_deflection: f64,
    /// Time without samples after which a contact is given up. s.
    pub gap_s: f64,
    /// Standard deviation of a response from its history (creep, loop, repetition), relative.
    pub history_sd: f64,
    /// Standard deviation of the ratio of the gauges from contact to contact, relative.
    pub ratio_sd: f64,
    /// Standard deviation of the ratio that all contacts of a whisker share (gains of the gauges), relative.
    pub ratio_shared_sd: f64,
    /// Ratio of the gauges by distance of the contact from the base, in mm, rising.
    pub ratios: [(f64, f64); 6],
    /// Nearest and farthest possible contact. mm.
    pub distances_mm: (f64, f64),
}

impl Default for Params {
    fn default() -> Params {
        Params {
            least_strain: 0.0,
            strain_limit: 0.05,
            sign: 0.0,
            least_rate_hz: 9.0,
            glitch_sds: 10.0,
            onset_sds: 4.7,
            baseline_s: 1.0,
            release: 0.12,
            longest_s: 30.0,
            forget_s: 60.0,
            slip_s: 0.045,
            slip_of_rise: 0.4,
            slip_of_deflection: 0.3,
            gap_s: 0.15,
            history_sd: 0.044,
            ratio_sd: 0.05,
            ratio_shared_sd: 0.01,
            // From the model for gauges at x = 3 and 11 mm; the first and the last are extended in a straight line.
            ratios: [(25.0, 0.70), (35.0, 0.82), (50.0, 0.92), (60.0, 0.96), (70.0, 0.99), (80.0, 1.01)],
            distances_mm: (25.0, 75.0),
        }
    }
}
