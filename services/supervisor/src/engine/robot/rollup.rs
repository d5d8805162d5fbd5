//! Aggregates of each whisker's minutes and hours: accumulated while a span lasts, and written once after its end.
//!
//! An [`Open`] holds the open minute and the open hour. It is stored with the whisker's checkpoint in the same
//! transaction, so that a crash loses no contact and counts none twice. Nothing here reads the clock.

use borsh::{BorshDeserialize, BorshSerialize};
use vibrissa_core::units::Micros;

use vibrissa_store::Resolution;

/// How long a span stays open after its end without a later contact: messages received in it may still wait in the
/// inbox.
pub const GRACE: Micros = Micros(2_000_000);

/// Version of the stored form.
const VERSION: u8 = 1;

/// A contact's contribution to the aggregates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// How the core used the contact.
    pub used: Use,
    /// ln(measured / predicted sensitivity), if the contact was used or learned from.
    pub residual: Option<f64>,
    /// Contact ratio: position along the whisker, 0 at the base, 1 at the tip.
    pub ratio: f64,
    /// Deflection at the contact, above 0 if there is a residual.
    pub deflection_mm: f64,
    /// Measured strain, m/m.
    pub strain: f64,
    /// Pressure in the chamber.
    pub pressure_mpa: f64,
    /// Temperature at the whisker.
    pub temperature_c: f64,
    /// Estimated length after the contact.
    pub length_mm: f64,
    /// Standard deviation of the estimated length.
    pub length_sd_mm: f64,
}

/// Classes by which contacts are counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Use {
    /// Used for estimation and detection.
    Used,
    /// Used for estimation in the cold start.
    Learning,
    /// Not used.
    Unused,
}

/// The finished aggregate of a span: one row. Values are means over its contacts unless stated otherwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rollup {
    /// Length of the span: minute or hour, each with its own table.
    pub resolution: Resolution,
    /// Start of the span by the supervisor's clock.
    pub start: Micros,
    /// Number of contacts used for estimation and detection.
    pub used: u32,
    /// Number of contacts used in the cold start.
    pub learning: u32,
    /// Number of contacts not used.
    pub unused: u32,
    /// Means over the contacts that were used or learned from; `None` if there are none.
    pub response: Option<ResponseMeans>,
    /// Means over all contacts; `None` if there are none.
    pub contact: Option<ContactMeans>,
    /// Last measured compensation error (Eq. 35, a ratio) of a compensation for this whisker.
    pub error: Option<f64>,
}

/// Means over contacts that were used or learned from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResponseMeans {
    /// Mean of ln(measured / predicted sensitivity).
    pub residual_mean: f64,
    /// Standard deviation of the residual over the contacts (n - 1); `None` for a single one.
    pub residual_sd: Option<f64>,
    /// Smallest residual of a contact.
    pub residual_min: f64,
    /// Largest residual of a contact.
    pub residual_max: f64,
    /// Mean of strain divided by deflection. It depends on the positions of the contacts: see `ratio`.
    pub sensitivity_per_mm: f64,
    /// Mean contact ratio.
    pub ratio: f64,
}

/// Means over all contacts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactMeans {
    /// Estimated length after the last contact.
    pub length_mm: f64,
    /// Standard deviation of that length.
    pub length_sd_mm: f64,
    /// Mean of the estimated lengths.
    pub length_mean_mm: f64,
    /// Mean chamber pressure.
    pub pressure_mpa: f64,
    /// Mean measured temperature.
    pub temperature_c: f64,
}

/// The open minute and the open hour of one whisker.
#[derive(Debug, Clone, PartialEq, Default, BorshSerialize, BorshDeserialize)]
pub struct Open {
    minute: Span,
    hour: Span,
}

/// An open minute or hour.
#[derive(Debug, Clone, PartialEq, Default, BorshSerialize, BorshDeserialize)]
struct Span {
    /// Number of the open span, or the first one that may be opened. No span is ever opened twice, even if the clock is
    /// set back.
    at: u32,
    sums: Option<Sums>,
}

/// Sums of a span. The precision is chosen so that a restart does not change a bit of the rows.
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
    /// For a whisker whose open spans are lost: spans that may have been written already are not opened again.
    #[must_use]
    pub fn after(now: Micros) -> Self {
        let span = |resolution: Resolution| Span { at: resolution.span_of(now).saturating_add(1), sums: None };
        Self { minute: span(Resolution::Minute), hour: span(Resolution::Hour) }
    }

    /// Adds a contact received at `received`, and closes the spans that ended before.
    pub fn add(&mut self, received: Micros, sample: &Sample, closed: &mut Vec<Rollup>) {
        for resolution in Resolution::ALL {
            self.span(resolution).open(resolution, received, closed).add(sample);
        }
    }

    /// Adds a compensation error measured at `at`, and closes the spans that ended before.
    pub fn state(&mut self, at: Micros, error: f64, closed: &mut Vec<Rollup>) {
        for resolution in Resolution::ALL {
            self.span(resolution).open(resolution, at, closed).error = Some(error as f32);
        }
    }

    /// Closes the spans that ended at least [`GRACE`] ago. Returns false if there are none.
    pub fn close(&mut self, now: Micros, closed: &mut Vec<Rollup>) -> bool {
        let (before, until) = (closed.len(), Micros(now.0.saturating_sub(GRACE.0)));
        for resolution in Resolution::ALL {
            self.span(resolution).close_before(resolution, resolution.span_of(until), closed);
        }
        closed.len() > before
    }

    /// Closes both spans, because the whisker leaves its robot.
    pub fn end(&mut self, closed: &mut Vec<Rollup>) {
        for resolution in Resolution::ALL {
            self.span(resolution).close_before(resolution, u32::MAX, closed);
        }
    }

    /// End of the span that ends first; `None` if none is open.
    #[must_use]
    pub fn due(&self) -> Option<Micros> {
        let end = |span: &Span, resolution: Resolution| {
            span.sums.as_ref().map(|_| Micros((u64::from(span.at) + 1) * resolution.us()))
        };
        end(&self.minute, Resolution::Minute).into_iter().chain(end(&self.hour, Resolution::Hour)).min()
    }

    /// Durable form, at most 200 bytes; `None` if a number is NaN.
    #[must_use]
    pub fn to_bytes(&self) -> Option<Vec<u8>> {
        borsh::to_vec(&(VERSION, self)).ok()
    }

    /// Reads the stored form; `None` is that of a whisker without contacts so far. Bytes of another version of the
    /// program cannot be read: then the open spans are lost.
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
    /// The sums of the span at time `at`, which is opened if necessary; those of a later span if that one was closed.
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

    /// Number of contacts with a residual.
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
