//! Evaluation of a whisker's contacts: from place and strain to an innovation and the detector's verdict.

use crate::detection::{Checks, Detector, Situation, Verdict};
use crate::estimation::filter::{LENGTH, NoInformation, Observation, Wander};
use crate::estimation::leak::Source;
use crate::estimation::spread::Deviation;
use crate::estimation::{ErosionWatch, Innovation, Temperatures, Warmth};
use crate::mechanics::{Model, compensable_range};
use crate::robot::effect::{Condition, ContactUse};
use crate::robot::event::Contact;
use crate::robot::health::array_shift::{ABSORBED, UNSTEADY_SHARE};
use crate::robot::params::Params;
use crate::robot::state::place::Placed;
use crate::robot::state::whisker::Whisker;
use crate::units::{ContactRatio, Megapascal, Micros};

/// Factor on the largest usual deflection with each contact: half is forgotten after 700.
const FORGETS_DEFLECTION: f32 = 0.999;

/// Result of one contact.
pub(in crate::robot) struct ContactResult {
    /// Contact ratio; `None` if the place is not known.
    pub ratio: Option<ContactRatio>,
    pub used: ContactUse,
    pub innovation: Option<Innovation>,
    pub verdict: Verdict,
    /// Found change of the gain, log sensitivity, that is no change of the whisker; 0 for most contacts.
    pub wandered: f64,
}

impl ContactResult {
    fn unused(used: ContactUse) -> Self {
        Self { ratio: None, used, innovation: None, verdict: Verdict::Quiet, wandered: 0.0 }
    }
}

impl Whisker {
    /// Takes one contact in: its use, its innovation and the detector's verdict.
    pub(in crate::robot) fn feel(
        &mut self,
        params: &Params,
        model: &Model,
        contact: &Contact<'_>,
        checks: Checks,
    ) -> ContactResult {
        let placed = Placed::on(&self.filter.length(), contact.place);
        let result = self.feel_at(params, model, contact, placed, checks);
        ContactResult { ratio: placed.ok().map(|placed| placed.ratio), ..result }
    }

    fn feel_at(
        &mut self,
        params: &Params,
        model: &Model,
        contact: &Contact<'_>,
        placed: Result<Placed, ContactUse>,
        checks: Checks,
    ) -> ContactResult {
        self.air.measure(contact.pressure);
        let off_by_mpa = (contact.pressure.mpa() - self.air.setpoint.mpa()).abs();
        if off_by_mpa > params.health.settled_within_mpa {
            return ContactResult::unused(ContactUse::Unsettled);
        }
        // 0 stands for a time that is not trusted.
        if self.command.is_none() && contact.robot_time > Micros(0) {
            self.leak.read(&params.health.leak, Source::Contact, contact.robot_time, contact.pressure);
        }
        let placed = match placed {
            Ok(placed) => placed,
            Err(used) => return ContactResult::unused(used),
        };
        self.learn_deflection(contact.deflection.mm());
        if contact.saturated {
            return ContactResult::unused(ContactUse::Saturated);
        }
        let morphology = model.morphology(contact.pressure);
        let stated_sd = placed.ratio_sd.unwrap_or(params.noise.ratio);
        let expected = self.spread.expected(placed.ratio, stated_sd);
        let Warmth { warmer_k, moved_k } = self.warmth(contact.temperature_c);
        self.filter.temperature_moved(moved_k, &params.filter);
        let observation = Observation {
            place: expected,
            informs_length: placed.informs_length,
            deflection_mm: contact.deflection.mm(),
            strain: contact.strain.ratio(),
            warmer_k,
        };
        let seen = self.filter.observe(model, &morphology, &params.noise, &self.noise, &observation);
        let is_negative = matches!(seen, Err(NoInformation::Negative));
        if self.gauge.watch(&observation, seen.as_ref().ok(), is_negative, params.health.gauge_contacts) {
            return ContactResult::unused(ContactUse::GaugeFault);
        }
        match seen {
            Err(NoInformation::OnChamber(_)) => ContactResult::unused(ContactUse::OnChamber),
            Err(NoInformation::Negative) => ContactResult::unused(ContactUse::NegativeStrain),
            Err(NoInformation::TooWeak) => ContactResult::unused(ContactUse::TooWeak),
            Err(NoInformation::Implausible) => ContactResult::unused(ContactUse::Implausible),
            Ok(seen) => {
                self.learn_places(placed.ratio, stated_sd, &seen);
                self.take(params, &placed, &seen, checks)
            }
        }
    }

    /// Follows the largest usual deflection if the factsheet states the range of the gauge. Readings at the end of that range
    /// count, too.
    fn learn_deflection(&mut self, deflection_mm: f64) {
        if self.sheet.strain_max.is_none() {
            return;
        }
        let largest_mm = &mut self.rare.get_or_insert().largest_deflection_mm;
        *largest_mm = (*largest_mm * FORGETS_DEFLECTION).max(deflection_mm as f32);
    }

    /// Takes in a stated contact ratio, and what the contact tells of its error.
    fn learn_places(&mut self, stated: ContactRatio, stated_sd: f64, seen: &Innovation) {
        if let Some(per_ratio) = seen.tells_errors {
            let variance = seen.variance / seen.seen.sound.max(1e-3);
            let seen = Deviation { residual: seen.residual, variance, per_ratio };
            self.spread.learn_errors(stated, stated_sd, &seen);
        }
        self.spread.learn(stated, stated_sd);
    }

    /// Temperature of a contact; that of the first one if it is not known.
    fn warmth(&mut self, temperature_c: Option<f64>) -> Warmth {
        let Some(temperature_c) = temperature_c.filter(|one| one.is_finite()) else { return Warmth::default() };
        self.temperatures.get_or_insert(Temperatures::of(temperature_c as f32)).feel(temperature_c)
    }

    fn take(&mut self, params: &Params, placed: &Placed, seen: &Innovation, checks: Checks) -> ContactResult {
        self.contacts += 1;
        self.tell(seen);
        self.follow_first(seen);
        let learning = self.condition == Condition::Learning;
        // While learning, a scale of the noise that is not known yet is the likeliest cause of a little doubt.
        let calm = (self.detector.is_calm() || learning && self.detector.has_little_doubt())
            && self.rare.pending_trim.is_none();
        if self.detector.is_suspicious() || self.rare.pending_trim.is_some() {
            self.noise.forget_doubtful();
        } else {
            self.noise.correlate(seen.alone.standardised, seen.alone.noise_share, calm);
        }
        if calm {
            self.learn_noise(params, seen);
            let may_be_cut = self.rare.length_test.as_ref().is_some_and(|test| test.is_for_change());
            if matches!(self.condition, Condition::Learning | Condition::Healthy)
                && self.is_at_nominal_pressure()
                && !may_be_cut
            {
                // Against the model at whole length: the residual is against the present estimate.
                let shift = seen.row[LENGTH] * self.filter.log_length();
                let deviation = seen.residual + self.filter.whole_offset().at(seen.ratio) + shift;
                // An outlier gets a larger variance.
                let variance = seen.noise_variance / seen.seen.sound.max(1e-3);
                let walk = self.walks.doubt().rate;
                self.whole_waiting.add(&mut self.whole, seen.ratio, deviation, variance, walk);
            }
        }
        // Wear is known to change the sensitivity: a gain that wanders instead would keep the length from following.
        if self.contacts > params.detection.followed_from.into() && self.condition != Condition::Eroding {
            self.walks.see(seen);
        }
        let mut verdict = self.judge(params, seen, learning, checks);
        if !self.filter.learn(seen, self.wander(params)) {
            return ContactResult::unused(ContactUse::Implausible);
        }
        self.renew_whole_offset();
        let wandered = self.follow_gain(verdict);
        // After another verdict the detector starts anew, and its caller moves the state first.
        if matches!(verdict, Verdict::Quiet | Verdict::Looking | Verdict::Unconfirmed)
            && let Some(length) = placed.tip.and_then(|tip| self.filter.observe_length(&self.noise, tip.at, tip.sd_mm))
        {
            verdict = self.judge(params, &length, learning, checks);
            // The random walk of this contact is in the state already. An implausible length changes nothing.
            let _ = self.filter.learn(&length, Wander { length_mm: 0.0, baseline_strain: 0.0, offset: 0.0 });
        }
        if let Some(rare) = self.rare.get_mut() {
            rare.unsteady = rare.unsteady.and_then(|unsteady| unsteady.after_contact());
        }
        self.shift_told &= self.rare.unsteady.is_some();
        self.follow_erosion(params);
        let used = if learning { ContactUse::Learning } else { ContactUse::Used };
        ContactResult { ratio: None, used, innovation: Some(*seen), verdict, wandered }
    }

    /// Adds the information of a contact about a change of log length before the last alarm in the array.
    ///
    /// The filter absorbs such a change. With a state of variance V and noise R per unit of log length, n contacts leave the
    /// share u = R / (R + n V) of it, and have told I = n / (R + n V). Both follow from I and the state's present variance
    /// V u: I V u = u (1 - u). Once half is absorbed, contacts tell too little.
    fn tell(&mut self, seen: &Innovation) {
        let square = seen.row[LENGTH].powi(2);
        if square <= 0.0 || self.told_since_alarm < 0.0 {
            return;
        }
        let state = (seen.variance - seen.noise_variance) / square;
        let absorbed = 1.0 - 4.0 * f64::from(self.told_since_alarm) * state;
        if absorbed <= 0.0 {
            self.told_since_alarm = ABSORBED;
            return;
        }
        let left = 0.5 * (1.0 + absorbed.sqrt());
        self.told_since_alarm += (left.powi(2) * square / seen.variance) as f32;
    }

    /// Verdict on an innovation; none while learning.
    fn judge(&mut self, params: &Params, seen: &Innovation, learning: bool, checks: Checks) -> Verdict {
        let detection = &params.detection;
        if !learning {
            let eroding = self.condition == Condition::Eroding;
            let situation = Situation {
                eroding,
                checks,
                wandering: self.walks.evidence(),
                noise: self.noise.of_mean(&params.noise),
                lasting: self.noise.is_lasting(&params.noise),
            };
            return self.detector.update(detection, seen, &situation);
        }
        if self.contacts > detection.followed_from.into() {
            self.detector.follow(seen);
        }
        Verdict::Quiet
    }

    /// Takes the rate at which the gain wanders from the contacts that show no change. Returns the change of the gain that was
    /// found with it, log sensitivity.
    pub(in crate::robot) fn follow_gain(&mut self, verdict: Verdict) -> f64 {
        let moved = match verdict {
            Verdict::Changed(_) | Verdict::Shared(_) => {
                self.walks.changed();
                None
            }
            Verdict::Wandered => Some(self.walks.wandered()),
            // A change while learning is called later; it must not pass for a walk.
            Verdict::Quiet if !matches!(self.condition, Condition::Learning | Condition::Eroding) => {
                self.walks.quiet(self.detector.is_calm(), self.detector.log_ratio_max())
            }
            Verdict::Quiet | Verdict::Looking | Verdict::Unconfirmed | Verdict::Alarm | Verdict::Dismissed => None,
        };
        let Some(moved) = moved else { return 0.0 };
        let is_moved = self.filter.wandered(moved);
        self.detector = Detector::default();
        self.cannot_deny();
        if is_moved { moved.by } else { 0.0 }
    }

    fn learn_noise(&mut self, params: &Params, seen: &Innovation) {
        let alone = &seen.alone;
        let factor = self.noise.learn(alone.standardised, alone.sound, alone.noise_share, seen.by_play);
        if self.condition == Condition::Learning {
            self.filter.rescale(factor, &params.filter);
        }
    }

    fn wander(&self, params: &Params) -> Wander {
        let eroding = self.condition == Condition::Eroding;
        let (filter, drifting) = (&params.filter, self.drifting);
        Wander {
            length_mm: if eroding {
                self.rare.erosion.as_ref().map_or(filter.erosion_wander_mm, |watch| watch.wander_mm())
            } else {
                filter.wander_mm
            },
            baseline_strain: if drifting {
                filter.drifting_baseline_wander_strain
            } else {
                filter.baseline_wander_strain
            },
            offset: self.rare.unsteady.map_or(0.0, |unsteady| UNSTEADY_SHARE * unsteady.log_shift).hypot(if eroding {
                0.0
            } else {
                self.walks.rate()
            }),
        }
    }

    /// While it erodes: how fast, and how long it will still do.
    fn follow_erosion(&mut self, params: &Params) {
        if self.condition != Condition::Eroding {
            if let Some(rare) = self.rare.get_mut() {
                rare.erosion = None;
            }
            return;
        }
        if self.rare.erosion.is_none() {
            self.begin_erosion(params, 0.0);
        }
        let contact_sd_mm = self.contact_sd_mm(params);
        let length = self.filter.relative_length();
        if let Some(watch) = self.rare.get_mut().and_then(|rare| rare.erosion.as_mut()) {
            watch.follow(&length, contact_sd_mm, params.filter.erosion_wander_mm);
        }
    }

    /// It loses so many mm per contact by the verdict.
    pub(in crate::robot) fn begin_erosion(&mut self, params: &Params, told_mm: f64) {
        let Some(model) = self.model(params) else { return };
        let (target, max) = (self.target(), self.sheet.pressure_max);
        let shortest = compensable_range(model, target, Megapascal::ZERO, max).0;
        let watch = ErosionWatch::new(target.length, shortest, params.filter.erosion_wander_mm, told_mm);
        self.rare.get_or_insert().erosion = Some(Box::new(watch));
    }
}
