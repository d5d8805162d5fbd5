//! The place of a touch, from its strain and deflection.
//!
//! The strain per mm of deflection falls from the chamber to the tip. So the place is where the whisker's model, with its
//! learned offset, gives the measured strain. At an equal distance from the base it depends little on the length, because the
//! part beyond the contact carries no load: the place of a trimmed whisker is as certain as that of a whole one.

use super::Robot;
use super::effect::WhiskerIndex;
use super::params::Params;
use super::state::whisker::Whisker;
use crate::estimation::filter::{NoInformation, Observation};
use crate::estimation::spread::ExpectedRatio;
use crate::estimation::{Innovation, LengthEstimate};
use crate::mechanics::root::root;
use crate::mechanics::{Model, Morphology};
use crate::units::{ContactRatio, Megapascal, Millimetre, Strain};

/// Standard deviations of a 95 % interval.
const SD_95: f64 = 1.96;
/// A strain this many standard deviations below that of the tip is no touch of this whisker.
const BEYOND_SD: f64 = 4.0;
/// Tolerance of a contact ratio.
const TOLERANCE: f64 = 1e-6;
/// Least contact ratio that is tried.
const LEAST: f64 = 0.01;
/// Points of a response along a whisker.
const RESPONSE_POINTS: usize = 16;
/// Deflection of a response, mm. The response changes by less than a contact's noise from 1 to 5 mm.
const RESPONSE_DEFLECTION_MM: f64 = 3.0;
/// Strain of a touch that is compared with a response; any has the same response.
const ANY_STRAIN: f64 = 0.01;

/// A touch whose place the robot does not know.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Touch {
    /// Strain as measured, without any gain.
    pub strain: Strain,
    /// Deflection of the whisker at the contact, above 0.
    pub deflection: Millimetre,
    /// Pressure in the chamber; the last measured one, or else the setpoint, if it is `None`.
    pub pressure: Option<Megapascal>,
}

/// Place of a touch on a whisker.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Located {
    /// Most likely distance from the base, without the chamber's elongation, mm.
    pub distance_mm: f64,
    /// 95 % interval of the distance, mm. It ends at the chamber and at the tip.
    pub interval_mm: (f64, f64),
    /// The distance as a share of the present length.
    pub ratio: ContactRatio,
    /// Present length of the whisker.
    pub length: Millimetre,
    /// Pressure in the chamber.
    pub pressure: Megapascal,
}

/// Response of a whisker to touches at one distance from its base.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResponsePoint {
    /// Distance from the base, without the chamber's elongation, mm.
    pub distance_mm: f64,
    /// Strain per mm of deflection, without any gain.
    pub strain_per_mm: f64,
    /// Its standard deviation, with that of a contact's strain.
    pub sd_per_mm: f64,
}

/// Reason for which a touch has no place.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum LocateError {
    /// There is no such whisker.
    #[error("there is no whisker with index {0}")]
    UnknownWhisker(WhiskerIndex),
    /// The whisker's model is not configured.
    #[error("the whisker's model is not known here")]
    UnknownModel,
    /// The strain is negative.
    #[error("the strain is negative: the gauge's wires or its sign are exchanged")]
    Negative,
    /// The strain is close to the noise of the gauge.
    #[error("the strain is too small: touch with more deflection")]
    TooWeak,
    /// Even a touch beside the chamber would give less strain.
    #[error("the strain is larger than that of a touch beside the chamber: the touch was on the chamber")]
    OnChamber,
    /// Even a touch of the tip would give more strain.
    #[error("the strain is smaller than that of a touch at the tip: check the deflection")]
    BeyondTip,
}

impl Robot {
    /// Place of a touch, by the present length, pressure and offset of the whisker.
    ///
    /// # Errors
    /// [`LocateError`]: there is no place on the whisker that explains the strain, or no such whisker.
    pub fn locate(&self, params: &Params, whisker: WhiskerIndex, touch: &Touch) -> Result<Located, LocateError> {
        let one = self.whiskers.get(whisker).ok_or(LocateError::UnknownWhisker(whisker))?;
        let model = one.model(params).ok_or(LocateError::UnknownModel)?;
        let pressure = touch.pressure.or(one.air.measured()).unwrap_or(one.air.setpoint);
        let morphology = model.morphology(pressure);
        let places = Places { whisker: one, model, morphology, params, touch };
        places.find(&one.filter.length())
    }

    /// Response of a whisker at its setpoint, from the chamber to the tip by its present length and offset: with it, a
    /// robot finds the places of touches by itself. Empty for an unknown whisker or model.
    #[must_use]
    pub fn response_curve(&self, params: &Params, whisker: WhiskerIndex) -> Vec<ResponsePoint> {
        let one = self.whiskers.get(whisker);
        let Some((one, model)) = one.and_then(|one| Some((one, one.model(params)?))) else { return Vec::new() };
        let touch = Touch {
            strain: Strain::known(ANY_STRAIN),
            deflection: Millimetre::known(RESPONSE_DEFLECTION_MM),
            pressure: None,
        };
        let morphology = model.morphology(one.air.setpoint);
        let places = Places { whisker: one, model, morphology, params, touch: &touch };
        let length_mm = one.filter.length().length.mm();
        let nearest = places.nearest();
        let points = (0..RESPONSE_POINTS).filter_map(|at| {
            let ratio = nearest + (1.0 - nearest) * at as f64 / (RESPONSE_POINTS - 1) as f64;
            let seen = places.at(ratio).ok()?;
            let strain_per_mm = seen.predicted_sensitivity_per_mm;
            let distance_mm = ratio * length_mm;
            Some(ResponsePoint { distance_mm, strain_per_mm, sd_per_mm: strain_per_mm * seen.variance.sqrt() })
        });
        // The strain of a tapered whisker falls towards the tip; the part that does not tells no place.
        let mut falling: Vec<ResponsePoint> = Vec::with_capacity(RESPONSE_POINTS);
        for point in points {
            while falling.last().is_some_and(|before| before.strain_per_mm <= point.strain_per_mm) {
                falling.pop();
            }
            falling.push(point);
        }
        falling
    }
}

/// The residual of a touch at each place.
struct Places<'a> {
    whisker: &'a Whisker,
    model: &'a Model,
    morphology: Morphology,
    params: &'a Params,
    touch: &'a Touch,
}

impl Places<'_> {
    /// The touch as a contact at this place; its residual rises with the contact ratio.
    fn at(&self, ratio: f64) -> Result<Innovation, LocateError> {
        let ratio = ContactRatio::new(ratio).map_err(|_| LocateError::OnChamber)?;
        // The whisker's noise was learned from contacts with the errors of stated places, and is not known without them.
        let sd = self.whisker.spread.expected(ratio, self.params.noise.ratio).sd;
        let contact = Observation {
            place: ExpectedRatio { sd, ..ExpectedRatio::exact(ratio) },
            informs_length: false,
            deflection_mm: self.touch.deflection.mm(),
            strain: self.touch.strain.ratio(),
            warmer_k: 0.0,
        };
        let (noise, scale) = (&self.params.noise, &self.whisker.noise);
        self.whisker.filter.observe(self.model, &self.morphology, noise, scale, &contact).map_err(|none| match none {
            NoInformation::OnChamber(_) => LocateError::OnChamber,
            NoInformation::Negative => LocateError::Negative,
            NoInformation::TooWeak | NoInformation::Implausible => LocateError::TooWeak,
        })
    }

    /// Contact ratio at the chamber's end, beyond which the model holds.
    fn nearest(&self) -> f64 {
        let length_mm = self.whisker.filter.length().length.mm();
        let chamber_mm = self.model.chamber_end(&self.morphology).mm();
        ((chamber_mm + 1e-3) / (length_mm + self.morphology.elongation_mm)).max(LEAST)
    }

    fn find(&self, length: &LengthEstimate) -> Result<Located, LocateError> {
        let at_tip = self.at(1.0)?;
        let sd = at_tip.variance.sqrt();
        if at_tip.residual < -BEYOND_SD * sd {
            return Err(LocateError::BeyondTip);
        }
        let length_mm = length.length.mm();
        let nearest = self.nearest();
        let at_chamber = self.at(nearest.min(1.0))?;
        if at_chamber.residual > BEYOND_SD * sd {
            return Err(LocateError::OnChamber);
        }
        let ratio_of = |residual: f64| {
            let off = |ratio: f64| self.at(ratio).map_or(f64::NAN, |seen| seen.residual) - residual;
            root((nearest, at_chamber.residual - residual), (1.0, at_tip.residual - residual), TOLERANCE, off)
        };
        let ratio = ratio_of(0.0);
        let sd = self.at(ratio)?.variance.sqrt();
        // A strain that is larger by an error comes from farther out than it seems.
        let interval_mm = (length_mm * ratio_of(-SD_95 * sd), length_mm * ratio_of(SD_95 * sd));
        let ratio = ContactRatio::new(ratio).map_err(|_| LocateError::OnChamber)?;
        Ok(Located {
            distance_mm: length_mm * ratio.a(),
            interval_mm,
            ratio,
            length: length.length,
            pressure: self.morphology.pressure,
        })
    }
}
