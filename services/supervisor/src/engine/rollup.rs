//! What a whisker felt in each minute and each hour, added up while it lasts and written once when it is over.
//!
//! An [`Open`] has the minute and the hour that are under way. It is stored with the whisker's state, in the same
//! transaction, so that a crash loses nothing of them and adds nothing twice. Nothing here asks for the time.

use borsh::{BorshDeserialize, BorshSerialize};
use vibrissa_core::units::Micros;

use vibrissa_store::Resolution;

/// How long a span stays open beyond its end when nothing comes: what was received in it may still wait.
pub const GRACE: Micros = Micros(2_000_000);

/// Version of the stored bytes.
const VERSION: u8 = 1;

/// What a contact adds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// What it was used for.
    pub used: Use,
    /// ln(measured / predicted sensitivity), if it was used or learned from.
    pub residual: Option<f64>,
    /// Place of the contact along the whisker, 0 at the base, 1 at the tip.
    pub ratio: f64,
    /// Deflection there, above 0 where there is a residual.
    pub deflection_mm: f64,
    /// Strain, m/m.
    pub strain: f64,
    /// Pressure.
    pub pressure_mpa: f64,
    /// Temperature.
    pub temperature_c: f64,
    /// Estimated length after it.
    pub length_mm: f64,
    /// Its standard deviation.
    pub length_sd_mm: f64,
}

/// What contacts are counted by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Use {
    /// Estimation and detection.
    Used,
    /// Estimation in the cold start.
    Learning,
    /// Nothing.
    Unused,
}

/// A span of time that is over: what its row says, means over its contacts unless it is said otherwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rollup {
    /// Which table it belongs to.
    pub resolution: Resolution,
    /// Its begin, by the supervisor's clock.
    pub start: Micros,
    /// Contacts that were used.
    pub used: u32,
    /// Contacts of the cold start.
    pub learning: u32,
    /// Contacts that were not used.
    pub unused: u32,
    /// Of those that were used or learned from; none without any.
    pub response: Option<ResponseMeans>,
    /// Of all contacts; none without any.
    pub contact: Option<ContactMeans>,
    /// The compensation error (Eq. 35, a ratio) that was stated last of a compensation for this whisker.
    pub error: Option<f64>,
}

/// Means over contacts that were used or learned from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResponseMeans {
    /// Mean of ln(measured / predicted sensitivity).
    pub residual_mean: f64,
    /// Its standard deviation over the contacts (n - 1); none of a single one.
    pub residual_sd: Option<f64>,
    /// The least.
    pub residual_min: f64,
    /// The greatest.
    pub residual_max: f64,
    /// Mean of strain by deflection. It depends on where the contacts were: see `ratio`.
    pub sensitivity_per_mm: f64,
    /// Mean contact ratio.
    pub ratio: f64,
}

/// Means over all contacts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactMeans {
    /// Estimated length after the last one.
    pub length_mm: f64,
    /// Its standard deviation.
    pub length_sd_mm: f64,
    /// Mean of the estimated lengths.
    pub length_mean_mm: f64,
    /// Mean pressure.
    pub pressure_mpa: f64,
    /// Mean temperature.
    pub temperature_c: f64,
}

/// The minute and the hour under way of one whisker.
#[derive(Debug, Clone, PartialEq, Default, BorshSerialize, BorshDeserialize)]
pub struct Open {
    minute: Span,
    hour: Span,
}

/// One of them.
#[derive(Debug, Clone, PartialEq, Default, BorshSerialize, BorshDeserialize)]
struct Span {
    /// The span that is open, or else the first one that may be opened: none is ever opened twice, whatever clocks do.
    at: u32,
    sums: Option<Sums>,
}

/// What is added up. Numbers are kept so that the same contacts give the same rows to the last bit after a restart.
#[derive(Debug, Clone, PartialEq, Default, BorshSerialize, BorshDeserialize)]
struct Sums {
    used: u32,
    learning: u32,
    unused: u32,
    residual_mean: f64,
    /// Sum of the squares of the differences from the mean (Welford).
    residual_squares: f64,
    residual_min: f32,
    residual_max: f32,
    sensitivity_per_mm: f64,
    ratio: f64,
    length_mm: f64,
    pressure_mpa: f64,
    temperature_c: f64,
    length_last_mm: f32,
    length_sd_last_mm: f32,
    error: Option<f32>,
}

impl Open {
    /// Of a whisker whose open spans are lost: nothing that may have been written already is opened again.
    #[must_use]
    pub fn after(now: Micros) -> Self {
        let span = |resolution: Resolution| Span { at: resolution.span_of(now).saturating_add(1), sums: None };
        Self { minute: span(Resolution::Minute), hour: span(Resolution::Hour) }
    }

    /// Adds a contact that was received then; what is over by then is closed first.
    pub fn add(&mut self, received: Micros, sample: &Sample, closed: &mut Vec<Rollup>) {
        for resolution in Resolution::ALL {
            self.span(resolution).open(resolution, received, closed).add(sample);
        }
    }

    /// Takes note of a compensation error that was stated then; what is over by then is closed first.
    pub fn state(&mut self, at: Micros, error: f64, closed: &mut Vec<Rollup>) {
        for resolution in Resolution::ALL {
            self.span(resolution).open(resolution, at, closed).error = Some(error as f32);
        }
    }

    /// Closes what has been over for [`GRACE`]. False if there is nothing.
    pub fn close(&mut self, now: Micros, closed: &mut Vec<Rollup>) -> bool {
        let (before, until) = (closed.len(), Micros(now.0.saturating_sub(GRACE.0)));
        for resolution in Resolution::ALL {
            self.span(resolution).close_before(resolution, resolution.span_of(until), closed);
        }
        closed.len() > before
    }

    /// Closes both, because the whisker leaves its robot.
    pub fn end(&mut self, closed: &mut Vec<Rollup>) {
        for resolution in Resolution::ALL {
            self.span(resolution).close_before(resolution, u32::MAX, closed);
        }
    }

    /// When the first of them is over; none if none is open.
    #[must_use]
    pub fn due(&self) -> Option<Micros> {
        let end = |span: &Span, resolution: Resolution| {
            span.sums.as_ref().map(|_| Micros((u64::from(span.at) + 1) * resolution.us()))
        };
        end(&self.minute, Resolution::Minute).into_iter().chain(end(&self.hour, Resolution::Hour)).min()
    }

    /// Its stored form, at most 200 bytes; none if a number is not one.
    #[must_use]
    pub fn to_bytes(&self) -> Option<Vec<u8>> {
        borsh::to_vec(&(VERSION, self)).ok()
    }

    /// From its stored form; none of a whisker that never felt anything. Bytes of another version of the program
    /// cannot be used: then what was open is lost.
    #[must_use]
    pub fn from_bytes(bytes: Option<&[u8]>, now: Micros) -> Self {
        match bytes {
            None => Self::default(),
            Some(bytes) => match borsh::from_slice::<(u8, Self)>(bytes) {
                Ok((VERSION, open)) => open,
                Ok(_) | Err(_) => Self::after(now),
            },
        }
    }

    fn span(&mut self, resolution: Resolution) -> &mut Span {
        match resolution {
            Resolution::Minute => &mut self.minute,
            Resolution::Hour => &mut self.hour,
        }
    }
}

impl Span {
    /// The sums of the span at that time, which is opened if need be; of a later one if that time's was closed.
    fn open(&mut self, resolution: Resolution, at: Micros, closed: &mut Vec<Rollup>) -> &mut Sums {
        let at = resolution.span_of(at);
        self.close_before(resolution, at, closed);
        if self.sums.is_none() {
            self.at = self.at.max(at);
        }
        self.sums.get_or_insert_default()
    }

    fn close_before(&mut self, resolution: Resolution, span: u32, closed: &mut Vec<Rollup>) {
        if self.at >= span {
            return;
        }
        if let Some(sums) = self.sums.take() {
            closed.push(sums.rollup(resolution, Micros(u64::from(self.at) * resolution.us())));
            self.at += 1;
        }
    }
}

impl Sums {
    fn add(&mut self, sample: &Sample) {
        match sample.used {
            Use::Used => self.used += 1,
            Use::Learning => self.learning += 1,
            Use::Unused => self.unused += 1,
        }
        if let Some(residual) = sample.residual {
            let count = f64::from(self.responses());
            let off = residual - self.residual_mean;
            self.residual_mean += off / count;
            self.residual_squares += off * (residual - self.residual_mean);
            let (is_first, residual) = (self.responses() == 1, residual as f32);
            self.residual_min = if is_first { residual } else { self.residual_min.min(residual) };
            self.residual_max = if is_first { residual } else { self.residual_max.max(residual) };
            self.sensitivity_per_mm += sample.strain / sample.deflection_mm;
            self.ratio += sample.ratio;
        }
        self.length_mm += sample.length_mm;
        self.pressure_mpa += sample.pressure_mpa;
        self.temperature_c += sample.temperature_c;
        self.length_last_mm = sample.length_mm as f32;
        self.length_sd_last_mm = sample.length_sd_mm as f32;
    }

    /// Contacts that have a residual.
    fn responses(&self) -> u32 {
        self.used + self.learning
    }

    fn rollup(&self, resolution: Resolution, start: Micros) -> Rollup {
        let responses = f64::from(self.responses());
        let contacts = responses + f64::from(self.unused);
        Rollup {
            resolution,
            start,
            used: self.used,
            learning: self.learning,
            unused: self.unused,
            response: (responses > 0.0).then(|| ResponseMeans {
                residual_mean: self.residual_mean,
                residual_sd: (responses > 1.0).then(|| (self.residual_squares / (responses - 1.0)).sqrt()),
                residual_min: self.residual_min.into(),
                residual_max: self.residual_max.into(),
                sensitivity_per_mm: self.sensitivity_per_mm / responses,
                ratio: self.ratio / responses,
            }),
            contact: (contacts > 0.0).then(|| ContactMeans {
                length_mm: self.length_last_mm.into(),
                length_sd_mm: self.length_sd_last_mm.into(),
                length_mean_mm: self.length_mm / contacts,
                pressure_mpa: self.pressure_mpa / contacts,
                temperature_c: self.temperature_c / contacts,
            }),
            error: self.error.map(f64::from),
        }
    }
}

#[cfg(test)]
mod tests;
