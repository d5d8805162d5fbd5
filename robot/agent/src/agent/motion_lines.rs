//! Lines of the motion of a whisker, for the strain that another driver reads.

use super::motion::Point;
use super::strain::{spacing_us, value};
use super::{Agent, Output};
use crate::contract::Now;
use crate::driver::BadLine;
use crate::driver::words::{self, Origin, Samples};

impl Agent {
    /// Takes the motion of a whisker, and gives the strain that waited for it to the segmenter.
    pub(super) fn motion(
        &mut self,
        from: usize,
        line: &words::Motion,
        now: Now,
        out: &mut Vec<Output>,
    ) -> Result<(), BadLine> {
        let values =
            [("deflection_mm", &line.deflection_mm), ("distance_mm", &line.distance_mm), ("ratio", &line.ratio)];
        // One number for all is no list: the longest value counts.
        let longest = values.iter().filter_map(|(name, value)| Some((value.as_ref()?.as_slice().len(), *name)));
        let Some((count, first)) = longest.max_by_key(|(count, _)| *count) else {
            return Err(BadLine::new(
                "neither deflection_mm, distance_mm nor ratio is given",
                "send what the motion knows of the whisker",
            ));
        };
        let every_us = spacing_us(count, line.every_us, first, &values)?;
        let span_us = (count as u64 - 1) * every_us;
        let (at, t_us) = self.place(from, &Origin { span_us, ..line.origin() }, now)?;
        let is_finite = |samples: &Samples| samples.as_slice().iter().all(|value| value.is_finite());
        if !values.iter().filter_map(|(_, value)| value.as_ref()).all(is_finite) {
            return Err(BadLine::new("a value of the motion is too large", "send millimetres, and ratios up to 1"));
        }
        if let Some(other) = self.chambers[at].motion.from(now).filter(|&other| other != from) {
            let problem = format!("{} sends the motion of this whisker already", self.drivers[other].label);
            return Err(BadLine::new(problem, "let one driver send the motion of a whisker"));
        }
        // Without a time the values end now.
        let is_stamped = line.t_us.is_some() || line.t_ms.is_some();
        let first_us = if is_stamped { t_us } else { t_us.saturating_sub(span_us) };
        let points = (0..count).map(|index| Point {
            t_us: first_us + index as u64 * every_us,
            deflection_mm: value(line.deflection_mm.as_ref(), index),
            distance_mm: value(line.distance_mm.as_ref(), index),
            ratio: value(line.ratio.as_ref(), index),
        });
        self.chambers[at].motion.take(from, points, line.test_id.as_deref(), now);
        self.join_motion(at, now, out);
        Ok(())
    }

    /// Gives the strain whose motion is known, or comes no more, to the segmenter.
    pub(super) fn join_motion(&mut self, at: usize, now: Now, out: &mut Vec<Output>) {
        let samples = self.chambers[at].motion.ready(now);
        let Some(from) = self.chambers[at].strain_from else { return };
        if let Err(bad) = self.feel(at, from, samples, None, now, out) {
            self.refuse(from, bad, now, out);
        }
    }

    /// Lets one driver have the gauge of a whisker: samples of two gauges make no contact.
    pub(super) fn hold_gauge(&mut self, at: usize, from: usize) -> Result<(), BadLine> {
        match self.chambers[at].strain_from.filter(|&other| other != from && self.drivers[other].is_there) {
            Some(other) => {
                let problem = format!("{} sends the strain of this whisker already", self.drivers[other].label);
                Err(BadLine::new(problem, "let one driver send the strain of a whisker"))
            }
            None => {
                self.chambers[at].strain_from = Some(from);
                Ok(())
            }
        }
    }
}
