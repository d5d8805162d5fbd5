//! The Kalman filter that estimates a whisker's length.
//!
//! State: x = (o0, o1, lambda, b, t, c). `o0 + o1 (a - 0.725)` is the whisker's offset from the model in log
//! sensitivity, which is smooth in the contact ratio; `lambda = ln(length / whole length)`, as the model would have it; `b` is the gauge's
//! baseline, its strain without deflection; `t` is the change of log sensitivity per kelvin and `c` per mm of
//! deflection, the curvature of the rubber's response. One contact at contact ratio a, deflection d, pressure Q and
//! T kelvin above the reference observes
//! `ln strain = ln(d s_model(a, L e^lambda, Q) e^(o0 + o1 (a - 0.725) + t T + c (d - 3 mm)) + b) + noise`.
//!
//! A cut does not change the whisker between base and contact. So the offset belongs to the distance from the base, and at
//! a contact ratio it moves with the length, by `o1 a lambda`. The filter takes that for a part of the change of length, in
//! a share of o1 that is nearly the same for all whiskers. The stated length is corrected for it ([`Self::length`]).
//! Another modulus of the rubber makes a slope of the offset, and with it a cut of another size for the same change of
//! sensitivity.
//!
//! Priors separate offset and length. At the start the length is known from the factsheet and the offset is not.
//! Afterwards the length may wander (erosion, trims) and the offset does not, except when the pressure changes,
//! which changes the model's error but not the length. The deflection separates the baseline, which matters at
//! small deflections; the other states follow from the slope of strain against deflection. Gauges drift under
//! cyclic load by many times their noise.
//!
//! The filter never stops learning. So its standardised innovations are independent and of unit variance while
//! nothing changes, from the first contact on: the error of the learned state is part of their variance.
//! [`crate::detection`] relies on that. It also tracks exactly how much of a real change the filter has absorbed
//! meanwhile (Willsky and Jones, IEEE Trans. Automat. Contr. 21 (1976) 108).

use borsh::io::{Error, Read, Write};
use borsh::{BorshDeserialize, BorshSerialize};

use super::gain_walk::Moved;
use super::innovation::VARIANCES;
pub use super::innovation::{Alone, Innovation, NoInformation, Observation, STATES, Wander};
use super::noise::{NoiseScale, SensorNoise};
use super::outlier::InnovationDensity;
use super::spread::ExpectedRatio;
use super::symmetric::Symmetric;
use crate::encoding;
use crate::mechanics::{Model, Morphology, Offset};
use crate::units::{ContactRatio, Millimetre};
pub use stated::LengthEstimate;
use stated::Untold;

/// Index of the slope of the offset in the state.
const SLOPE: usize = 1;
/// Index of lambda in the state.
pub const LENGTH: usize = 2;
/// Index of the baseline in the state.
pub const BASELINE: usize = 3;
/// Index of the temperature coefficient in the state.
const PER_K: usize = 4;
/// Index of the curvature in the state.
const BEND: usize = 5;
/// Number of states before version 7 of the stored whisker: those before the temperature coefficient.
pub const STATES_BEFORE_7: usize = PER_K;
/// Deflection at which the offset is stated, mm: the middle of the usual ones.
const CENTRE_MM: f64 = 3.0;
/// Relative uncertainty of the share that an error of the ratios takes from their distance to the mean: the error itself
/// is known to a factor of two, and it counts squared.
const SHARE_DOUBT: f64 = 1.5;
/// Usual size of the offset's slope, log sensitivity per unit of contact ratio.
const SLOPE_SD: f64 = 0.2;
/// Least weight of an outlier, so that the filter can never lock itself out.
const LEAST_SOUND: f64 = 1e-3;
/// Share of the offset's slope in the change of log length: contact ratio over d ln s / d ln L. Over moduli of 0.5 to 2.5 MPa,
/// calibrations 10 % off, both formulations and cuts of 2 to 16 mm it is 0.325 to 0.335.
const OFFSET_SHARE: f64 = 0.33;
/// Least factor that the slope may make of a change of length.
const LEAST_SHARE: f64 = 0.5;
/// Least share of the expected strain that must come from deflection.
const LEAST_BY_DEFLECTION: f64 = 0.2;
/// Bounds of the state and of its variances: e^20 is 5e8.
const STATE_MAX: f32 = 20.0;
const STATE_VARIANCE_MAX: f64 = 1e6;

/// Prior and process noise, as standard deviations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilterParams {
    /// Initial uncertainty of the offset, log sensitivity.
    pub offset_level: f64,
    /// Initial uncertainty of the offset's slope, log sensitivity per unit of contact ratio.
    pub offset_slope: f64,
    /// Initial uncertainty of the whole length, mm.
    pub length_mm: f64,
    /// Random walk of the length of a healthy whisker, mm per square root of a contact.
    pub wander_mm: f64,
    /// Random walk of the length of a whisker known to erode, mm per square root of a contact.
    pub erosion_wander_mm: f64,
    /// Added uncertainty of the offset after a change of pressure, log sensitivity per MPa.
    pub offset_per_mpa: f64,
    /// Initial uncertainty of the baseline, m/m.
    pub baseline_strain: f64,
    /// Random walk of the baseline, m/m per square root of a contact.
    pub baseline_wander_strain: f64,
    /// Random walk of the baseline of a gauge known to drift, m/m per square root of a contact.
    pub drifting_baseline_wander_strain: f64,
    /// Initial uncertainty of the temperature coefficient, log sensitivity per K: silicones have 0.3 to 1 %, of either
    /// sign with the gauge's own.
    pub per_k: f64,
    /// Added uncertainty of the offset after a sudden change of temperature, log sensitivity per K. The coefficient is learned
    /// from slow changes, in which the gain wanders, too, so that it is less certain than its variance says.
    pub offset_per_k: f64,
    /// Initial uncertainty of the curvature, log sensitivity per mm of deflection.
    pub bend_per_mm: f64,
}

impl Default for FilterParams {
    fn default() -> Self {
        Self {
            offset_level: 0.15,
            offset_slope: 0.2,
            length_mm: 0.1,
            wander_mm: 2e-4,
            erosion_wander_mm: 0.03,
            offset_per_mpa: 1.0,
            baseline_strain: 2e-5,
            baseline_wander_strain: 5e-7,
            drifting_baseline_wander_strain: 1e-5,
            per_k: 0.007,
            offset_per_k: 0.006,
            bend_per_mm: 0.02,
        }
    }
}

/// The filter's state for one whisker.
#[derive(Debug, Clone, PartialEq, BorshSerialize, BorshDeserialize)]
pub struct LengthFilter {
    #[borsh(serialize_with = "write_whole", deserialize_with = "read_whole")]
    whole_length_mm: f64,
    /// State vector, in single precision like the covariance: a contact reduces the uncertainty of a state by a
    /// ten-thousandth or more, well above rounding.
    mean: [f32; STATES],
    covariance: Symmetric,
    /// Stored as a part of the whisker, or follows from the factsheet.
    #[borsh(skip)]
    untold: Untold,
}

fn write_whole<W: Write>(whole_length_mm: &f64, writer: &mut W) -> Result<(), Error> {
    encoding::write_number(*whole_length_mm, writer)
}

fn read_whole<R: Read>(reader: &mut R) -> Result<f64, Error> {
    encoding::read_number(reader)
}

impl LengthFilter {
    /// Reads a filter as it was stored before version 7: temperature coefficient and curvature are unknown.
    ///
    /// # Errors
    /// The bytes end, or hold a NaN where none can be.
    pub fn read_before_7<R: Read>(reader: &mut R) -> Result<Self, Error> {
        let whole_length_mm = read_whole(reader)?;
        let length = Millimetre::new(whole_length_mm).map_err(|_| encoding::invalid("no length of a whisker"))?;
        let mut read = Self::new(length, &FilterParams::default());
        read.whole_length_mm = whole_length_mm;
        for mean in &mut read.mean[..STATES_BEFORE_7] {
            *mean = f32::deserialize_reader(reader)?;
        }
        read.covariance.read_first(STATES_BEFORE_7, reader)?;
        Ok(read)
    }
}

/// Contact ratio at which a contact tells of the offset's slope.
///
/// Within a narrow range of contacts the slope depends on the size of their ratios' errors, which is hardly known: the
/// errors take a share of the distance from the mean, and that share is doubtful. If the doubt exceeds the slope's own
/// uncertainty, contacts tell only of the range's mean.
fn slope_at(place: &ExpectedRatio, per_ratio: f64) -> ContactRatio {
    let doubt = SHARE_DOUBT * place.lost * per_ratio;
    if doubt.abs() < SLOPE_SD { place.ratio } else { place.mean }
}

impl LengthFilter {
    /// Filter of a new whisker: the length is known from the factsheet, the offset is not.
    #[must_use]
    pub fn new(whole_length: Millimetre, params: &FilterParams) -> Self {
        let length = params.length_mm / whole_length.mm();
        let prior = [
            params.offset_level,
            params.offset_slope,
            length,
            params.baseline_strain,
            params.per_k,
            params.bend_per_mm,
        ];
        let covariance = Symmetric::diagonal(prior.map(|sd| sd.powi(2)));
        Self { whole_length_mm: whole_length.mm(), mean: [0.0; STATES], covariance, untold: Untold::default() }
    }

    /// Keeps the length, the slope for which it is corrected, and their uncertainty. Forgets level of the offset and baseline.
    #[must_use]
    pub fn learned_anew(&self, params: &FilterParams) -> Self {
        let mut anew = Self::new(Millimetre::known(self.whole_length_mm), params);
        anew.untold = self.untold;
        for kept in [SLOPE, LENGTH] {
            anew.mean[kept] = self.mean[kept];
            anew.covariance.widen(kept, self.covariance.variance(kept) - anew.covariance.variance(kept));
        }
        anew
    }

    /// Change of the whisker's log length for a change of lambda.
    #[must_use]
    pub fn per_log(&self) -> f64 {
        1.0 / (1.0 - OFFSET_SHARE * f64::from(self.mean[SLOPE])).max(LEAST_SHARE)
    }

    /// Length by the model alone, mm, which goes with an offset at the contact ratio.
    fn model_length(&self) -> Millimetre {
        Millimetre::known((self.whole_length_mm * self.log_length().exp()).clamp(1.0, 1000.0))
    }

    /// ln(length / whole length).
    #[must_use]
    pub fn log_length(&self) -> f64 {
        self.mean[LENGTH].into()
    }

    /// Present offset from the model at the present length.
    #[must_use]
    pub fn offset(&self) -> Offset {
        self.whole_offset().shortened(self.share_left())
    }

    /// The offset that it would have at whole length.
    #[must_use]
    pub fn whole_offset(&self) -> Offset {
        Offset { level: self.mean[0].into(), slope: self.mean[SLOPE].into() }
    }

    /// Present length as a share of the whole one.
    fn share_left(&self) -> f64 {
        self.length().length.mm() / self.whole_length_mm
    }

    /// Present baseline and its standard deviation, m/m.
    #[must_use]
    pub fn baseline_strain(&self) -> (f64, f64) {
        (self.mean[BASELINE].into(), self.covariance.variance(BASELINE).max(0.0).sqrt())
    }

    /// Standard deviation of the offset's level, log sensitivity.
    #[must_use]
    pub fn offset_sd(&self) -> f64 {
        self.covariance.variance(0).max(0.0).sqrt()
    }

    /// Variance of the response that the filter predicts, in log sensitivity, where length moves it by `log_slope` per unit of
    /// log length.
    #[must_use]
    pub fn response_variance(&self, ratio: ContactRatio, log_slope: f64) -> f64 {
        let row = [1.0, ratio.a() - Offset::CENTRE, log_slope, 0.0, 0.0, 0.0];
        let spread = self.covariance.times(&row);
        row.iter().zip(spread).map(|(row, spread)| row * spread).sum::<f64>().max(0.0)
    }

    /// Compares one contact with the prediction, without learning from it.
    ///
    /// # Errors
    /// [`NoInformation`] if the contact cannot be used.
    pub fn observe(
        &self,
        model: &Model,
        morphology: &Morphology,
        noise: &SensorNoise,
        scale: &NoiseScale,
        contact: &Observation,
    ) -> Result<Innovation, NoInformation> {
        // A contact at a known distance lies where it lies, whatever is beyond it.
        let (length, offset) = if contact.informs_length {
            (self.model_length(), self.whole_offset())
        } else {
            (self.length().length, self.offset())
        };
        let ratio = contact.place.ratio;
        let (model_per_mm, log_slope) = model.sensitivity_and_slope(ratio, length, morphology)?;
        let beyond_mm = contact.deflection_mm - CENTRE_MM;
        let by_circumstances = f64::from(self.mean[PER_K]) * contact.warmer_k + f64::from(self.mean[BEND]) * beyond_mm;
        let per_ratio = log_slope / ratio.a();
        let slope_at = slope_at(&contact.place, per_ratio);
        let predicted = model_per_mm * (offset.at(slope_at) + by_circumstances).exp();
        let by_deflection = predicted * contact.deflection_mm;
        let expected_strain = by_deflection + f64::from(self.mean[BASELINE]);
        let least = noise.least_strain().max(LEAST_BY_DEFLECTION * by_deflection);
        if contact.strain <= -least && by_deflection >= least {
            return Err(NoInformation::Negative);
        }
        if expected_strain < least || by_deflection < least || contact.strain <= 0.0 {
            return Err(NoInformation::TooWeak);
        }
        let residual = (contact.strain / expected_strain).ln();
        // Contact distance A = a (L + elongation), so d ln A / d ln L is a little less than one.
        let elongated_mm = length.mm() + morphology.elongation_mm;
        let share = by_deflection / expected_strain;
        let row = [
            share,
            share * (slope_at.a() - Offset::CENTRE),
            if contact.informs_length { share * log_slope * length.mm() / elongated_mm } else { 0.0 },
            1.0 / expected_strain,
            share * contact.warmer_k,
            share * beyond_mm,
        ];
        let by_ratio = per_ratio * contact.place.sd;
        let configured = noise.log_variance(expected_strain) + by_ratio.powi(2);
        let (noise_variance, by_play) = scale.of_contact(configured, contact.deflection_mm);
        let seen = self.innovation(residual, row, (noise_variance, scale.inflation()), scale.density());
        let tells_errors = (slope_at != ratio).then_some(per_ratio);
        let seen = Innovation {
            ratio,
            by_play,
            tells_errors,
            by_circumstances,
            predicted_sensitivity_per_mm: predicted,
            ..seen
        };
        if seen.is_bounded() { Ok(seen) } else { Err(NoInformation::Implausible) }
    }

    /// Compares a measured length with the estimate, as a contact at the tip tells it with its distance from the base.
    /// `None` if no real whisker has that length.
    #[must_use]
    pub fn observe_length(&self, scale: &NoiseScale, measured: Millimetre, sd_mm: f64) -> Option<Innovation> {
        let mut row = [0.0; STATES];
        row[LENGTH] = self.per_log();
        let length_mm = self.length().length.mm();
        let noise_variance = (sd_mm / length_mm).powi(2).max(*VARIANCES.start());
        let seen = self.innovation((measured.mm() / length_mm).ln(), row, (noise_variance, 1.0), scale.density());
        seen.is_bounded().then_some(seen)
    }

    /// The innovation of a measurement of the length, or of a contact whose place is added.
    fn innovation(
        &self,
        residual: f64,
        row: [f64; STATES],
        (own_variance, inflation): (f64, f64),
        density: InnovationDensity,
    ) -> Innovation {
        let noise_variance = own_variance * inflation;
        let spread = self.covariance.times(&row);
        let state_variance: f64 = row.iter().zip(spread).map(|(row, spread)| row * spread).sum();
        let variance = state_variance + noise_variance;
        let standardised = residual / variance.sqrt();
        let seen = density.at(standardised);
        let own_sd = (state_variance + own_variance).sqrt();
        let alone = Alone {
            standardised: residual / own_sd,
            sound: if inflation > 1.0 { density.at(residual / own_sd).sound } else { seen.sound },
            noise_share: own_variance / own_sd.powi(2),
        };
        let gain_noise_variance = noise_variance / seen.sound.max(LEAST_SOUND);
        let gain = spread.map(|spread| spread / (state_variance + gain_noise_variance));
        Innovation {
            residual,
            variance,
            noise_variance,
            standardised,
            alone,
            density,
            seen,
            ratio: ContactRatio::TIP,
            tells_errors: None,
            by_play: 0.0,
            row,
            gain,
            gain_noise_variance,
            by_circumstances: 0.0,
            predicted_sensitivity_per_mm: 0.0,
        }
    }

    /// Updates the state with a contact (Joseph form, which keeps the covariance positive) and adds the random
    /// walk. Returns false and changes nothing if the state would leave its bounds.
    pub fn learn(&mut self, seen: &Innovation, wander: Wander) -> bool {
        let mut after = self.clone();
        for (mean, gain) in after.mean.iter_mut().zip(seen.gain) {
            *mean = (f64::from(*mean) + gain * seen.residual) as f32;
        }
        after.covariance = self.covariance.after_reading(&seen.row, &seen.gain, seen.gain_noise_variance);
        after.covariance.widen(0, wander.offset.powi(2));
        after.covariance.widen(LENGTH, (wander.length_mm / self.whole_length_mm).powi(2));
        after.covariance.widen(BASELINE, wander.baseline_strain.powi(2));
        self.become_if_sound(after)
    }

    /// Whether mean and covariance are finite and within their bounds, and no variance is negative.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        self.mean.iter().all(|mean| mean.abs() <= STATE_MAX) && self.covariance.is_within(STATE_VARIANCE_MAX)
    }

    fn become_if_sound(&mut self, after: Self) -> bool {
        let is_sound = after.is_sound();
        if is_sound {
            *self = after;
        }
        is_sound
    }

    /// Scales the variances after a corrected noise estimate by `factor`, its change of variance.
    ///
    /// Only for the cold start, and only for states that contacts have determined better than the prior.
    pub fn rescale(&mut self, factor: f64, params: &FilterParams) {
        let prior =
            [params.offset_level, params.offset_slope, 0.0, params.baseline_strain, params.per_k, params.bend_per_mm];
        let by: [f64; STATES] = std::array::from_fn(|state| {
            let is_determined = self.covariance.variance(state) < 0.5 * prior[state].powi(2);
            if is_determined { factor.sqrt() } else { 1.0 }
        });
        self.covariance.scale(&by);
    }

    /// Applies a detected change: adds `lacking` times `size`, where `size` has the given variance.
    ///
    /// The model is linearised at the old length, so a tenth of the change of lambda is added to its standard
    /// deviation; the next contacts reduce it again.
    ///
    /// Returns false and changes nothing if the state would leave its bounds.
    pub fn jump(&mut self, size: f64, variance: f64, lacking: [f64; STATES]) -> bool {
        let mut after = self.clone();
        for (mean, lacks) in after.mean.iter_mut().zip(lacking) {
            *mean = (f64::from(*mean) + lacks * size) as f32;
        }
        after.covariance.add_square(&lacking, variance);
        after.covariance.widen(LENGTH, (0.1 * size * lacking[LENGTH]).powi(2));
        self.become_if_sound(after)
    }

    /// Applies a detected change of sensitivity that is no change of length: takes back what the states have absorbed of
    /// it as a change of `size` in log length, of which they lack `lacking` per unit, and moves the offset instead.
    /// `log_shift` is the change of log sensitivity. The offset becomes uncertain by `log_sd`; the length does not.
    ///
    /// Returns false and changes nothing if the state would leave its bounds.
    pub fn rescaled(&mut self, size: f64, lacking: [f64; STATES], log_shift: f64, log_sd: f64) -> bool {
        let mut after = self.clone();
        for (state, (mean, lacks)) in after.mean.iter_mut().zip(lacking).enumerate() {
            let unit = if state == LENGTH { 1.0 } else { 0.0 };
            *mean = (f64::from(*mean) - (unit - lacks) * size) as f32;
        }
        after.mean[0] = (f64::from(after.mean[0]) + log_shift) as f32;
        after.shared_shift(log_sd);
        self.become_if_sound(after)
    }

    /// The length was measured otherwise, with this standard deviation. The other states stay: they were learned from
    /// contacts that say nothing about the length.
    ///
    /// Returns false and changes nothing if the state would leave its bounds.
    pub fn measured_length(&mut self, length: Millimetre, sd_mm: f64) -> bool {
        let mut after = self.clone();
        after.mean[LENGTH] = ((length.mm() / self.whole_length_mm).ln() / self.per_log()) as f32;
        after.covariance.scale(&std::array::from_fn(|state| if state == LENGTH { 0.0 } else { 1.0 }));
        after.covariance.widen(LENGTH, (sd_mm / length.mm() / self.per_log()).powi(2));
        self.become_if_sound(after)
    }

    /// The pressure has changed permanently: the offset becomes more uncertain, the length does not.
    pub fn pressure_moved(&mut self, by_mpa: f64, params: &FilterParams) {
        let sd = params.offset_per_mpa * by_mpa;
        self.covariance.widen(0, sd.powi(2));
        self.covariance.widen(SLOPE, sd.powi(2));
    }

    /// The temperature has moved suddenly by so many K: the offset becomes more uncertain.
    pub fn temperature_moved(&mut self, by_k: f64, params: &FilterParams) {
        if by_k != 0.0 {
            self.covariance.widen(0, (params.offset_per_k * by_k).powi(2));
        }
    }

    /// The gain has wandered: the offset moves, and becomes uncertain by this variance.
    ///
    /// Returns false and changes nothing if the state would leave its bounds.
    pub fn wandered(&mut self, moved: Moved) -> bool {
        let mut after = self.clone();
        after.mean[0] = (f64::from(after.mean[0]) + moved.by) as f32;
        after.covariance.widen(0, moved.variance);
        self.become_if_sound(after)
    }

    /// Adds an uncertainty of the gain, log sensitivity, that the length has compensated for. `log_slope` is the change of log
    /// sensitivity with the length. The prediction is as certain as before.
    pub fn doubt_gain(&mut self, log_sd: f64, log_slope: f64) {
        let mut after = self.clone();
        let mut direction = [0.0; STATES];
        (direction[0], direction[LENGTH]) = (1.0, -1.0 / log_slope);
        after.covariance.add_square(&direction, log_sd.powi(2));
        self.become_if_sound(after);
    }

    /// The length while whole was never known better than by this standard deviation, mm: the offset was learned with the same
    /// error. `log_slope` is the change of log sensitivity with log length in the middle of the contact ratios, and at the tip.
    /// The prediction is as certain as before.
    pub fn doubt_whole(&mut self, sd_mm: f64, (middle, tip): (f64, f64)) {
        let mut after = self.clone();
        let mut direction = [0.0; STATES];
        let bend = (tip - middle) / (ContactRatio::TIP.a() - Offset::CENTRE);
        (direction[0], direction[1], direction[LENGTH]) = (-middle, -bend, 1.0);
        after.covariance.add_square(&direction, (sd_mm / self.whole_length_mm).powi(2));
        self.become_if_sound(after);
    }

    /// Adds an uncertainty of the model, log sensitivity, that the length has compensated for: its level, as
    /// [`Self::doubt_gain`], and its slope over the contact ratio, which would tell level and length apart otherwise.
    pub fn doubt_model(&mut self, log_sd: f64, log_slope: f64) {
        self.doubt_gain(log_sd, log_slope);
        self.covariance.widen(SLOPE, log_sd.powi(2));
    }

    /// All whiskers of the array have shifted by about this much in log sensitivity, which is no change of length.
    ///
    /// The offset may already have absorbed part of the shift, so only its uncertainty grows and contacts determine
    /// it anew.
    pub fn shared_shift(&mut self, log_shift: f64) {
        self.covariance.widen(0, log_shift.powi(2));
        self.covariance.widen(SLOPE, log_shift.powi(2));
    }
}

mod stated;
#[cfg(test)]
mod tests;
