//! Table 1: the shape of a whisker at zero pressure.

use super::model_error::ModelError;

/// Dimensions of a whisker before pressurization (Table 1, Fig. 3A), in mm.
///
/// The body consists of three truncated cones on one axis x, from the base (x = 0): the cap (region 1, up to
/// `c_mm`), the chamber (region 2, up to `l_mm`) and the solid body (region 3). Each cone is given by the diameter
/// of its large end and by the length of the full cone to its apex. The paper's capital and small letters become
/// `_large` and `_small`; a bar becomes `_mid` (mid-wall).
///
/// Checked by [`super::Model::new`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Geometry {
    /// D1: outer diameter of the cap at x = 0.
    pub d1_large_mm: f64,
    /// L1: length of the cap's cone from x = 0 to its point.
    pub l1_mm: f64,
    /// D2: outer diameter of the chamber at x = c.
    pub d2_large_mm: f64,
    /// L2: length of the chamber's outer cone from x = c to its point.
    pub l2_mm: f64,
    /// D3: outer diameter of the body at x = l.
    pub d3_large_mm: f64,
    /// L3: length of the body's cone from x = l to its point.
    pub l3_mm: f64,
    /// Mid-wall diameter of the chamber at x = c (D2 with a bar).
    pub d2_mid_large_mm: f64,
    /// Mid-wall diameter of the chamber at x = l (d2 with a bar; Table 1 prints it as a second d2).
    pub d2_mid_small_mm: f64,
    /// Length of the mid-wall cone from x = c to its point (L2 with a bar).
    pub l2_mid_mm: f64,
    /// Dm: inner diameter of the chamber. Table 1 measures it, and `lm_mm`, from x = 0; eq. 23 and 24 use it from x
    /// = c. This code uses it from x = c there too, because those equations assume that.
    pub dm_large_mm: f64,
    /// dm: inner diameter of the chamber at x = l, where the air pressure acts (eq. 22).
    pub dm_small_mm: f64,
    /// Lm: length of the chamber's inner cone to its point.
    pub lm_mm: f64,
    /// c: end of the cap, start of the chamber.
    pub c_mm: f64,
    /// t: thickness of the chamber's wall.
    pub t_mm: f64,
    /// l: end of the chamber, start of the solid body.
    pub l_mm: f64,
    /// e: length of the strain gauge's measuring grid.
    pub e_mm: f64,
    /// `x_ss`: start of the gauge's grid.
    pub xss_mm: f64,
    /// Poisson's ratio of the rubber, above 0 and at most 0.5.
    pub poisson_ratio: f64,
}

impl Geometry {
    /// The paper's prototypes (Table 1), without their length: 70 mm intact, 65 mm trimmed.
    #[must_use]
    pub const fn nguyen_2021() -> Self {
        Self {
            d1_large_mm: 18.0,
            l1_mm: 180.0,
            d2_large_mm: 17.8,
            l2_mm: 178.0,
            d3_large_mm: 16.5,
            l3_mm: 165.0,
            d2_mid_large_mm: 14.8,
            d2_mid_small_mm: 13.5,
            l2_mid_mm: 148.0,
            dm_large_mm: 12.0,
            dm_small_mm: 10.5,
            lm_mm: 120.0,
            c_mm: 2.0,
            t_mm: 3.0,
            l_mm: 15.0,
            e_mm: 2.0,
            xss_mm: 6.0,
            poisson_ratio: 0.49,
        }
    }

    /// Share of the second moment of area that the thin wall of eq. 5 and 6 leaves out, at the chamber's large and small
    /// end: `1 - I2 / I2 exact`, with the wall between D2 (bar) - t and D2 (bar) + t.
    #[must_use]
    pub fn thin_wall_errors(&self) -> [f64; 2] {
        [self.d2_mid_large_mm, self.d2_mid_small_mm].map(|mid_mm| {
            let exact = ((mid_mm + self.t_mm).powi(4) - (mid_mm - self.t_mm).powi(4)) / 64.0;
            1.0 - mid_mm.powi(3) * self.t_mm / 8.0 / exact
        })
    }

    /// Checks all conditions of the formulas; the error names the first that fails.
    pub(super) fn check(&self) -> Result<(), ModelError> {
        for (name, value) in self.named_sizes() {
            if !(value.is_finite() && value > 0.0) {
                return Err(ModelError::NotPositive { name, value });
            }
        }
        let conditions: [(&'static str, bool); 11] = [
            ("Poisson's ratio must be at most 0.5", self.poisson_ratio <= 0.5),
            ("chamber end l must lie beyond the cap c", self.l_mm > self.c_mm),
            ("the cap's cone L1 must be longer than the cap c", self.l1_mm > self.c_mm),
            ("the mid-wall cone L2 (bar) must be longer than the chamber, l - c", self.l2_mid_mm > self.chamber_mm()),
            ("the chamber's outer cone L2 must be longer than the chamber, l - c", self.l2_mm > self.chamber_mm()),
            ("the chamber's inner cone Lm must be longer than the chamber, l - c", self.lm_mm > self.chamber_mm()),
            ("the gauge must start on the chamber: x_ss beyond the cap c", self.xss_mm >= self.c_mm),
            ("the gauge must end on the chamber: x_ss + e not beyond l", self.xss_mm + self.e_mm <= self.l_mm),
            ("the chamber's wall must have a positive thickness: D2 above Dm at both ends", self.wall_is_solid()),
            (
                "the mid-wall diameter must fall along the chamber: D2 (bar) above d2 (bar)",
                self.d2_mid_large_mm > self.d2_mid_small_mm,
            ),
            (
                "mid-wall sizes must agree within 1 %: d2 (bar) = dm + t, L2 (bar) = D2 (bar) (l - c) / (D2 (bar) - d2 (bar))",
                self.mid_wall_agrees(),
            ),
        ];
        match conditions.into_iter().find(|(_, holds)| !holds) {
            Some((condition, _)) => Err(ModelError::Geometry(condition)),
            None => Ok(()),
        }
    }

    /// l - c: length of the chamber.
    pub(super) fn chamber_mm(&self) -> f64 {
        self.l_mm - self.c_mm
    }

    fn wall_is_solid(&self) -> bool {
        let outer_at_end_mm = self.d2_large_mm * (1.0 - self.chamber_mm() / self.l2_mm);
        let inner_at_end_mm = self.dm_large_mm * (1.0 - self.chamber_mm() / self.lm_mm);
        self.d2_large_mm > self.dm_large_mm && outer_at_end_mm > inner_at_end_mm
    }

    /// Table 2 computes the mid-wall sizes from the wall thickness; at zero pressure it must reproduce Table 1.
    fn mid_wall_agrees(&self) -> bool {
        let close = |a: f64, b: f64| (a - b).abs() <= 0.01 * b.abs();
        let fall_mm = self.d2_mid_large_mm - self.d2_mid_small_mm;
        close(self.dm_small_mm + self.t_mm, self.d2_mid_small_mm)
            && close(self.d2_mid_large_mm * self.chamber_mm() / fall_mm, self.l2_mid_mm)
    }

    fn named_sizes(&self) -> [(&'static str, f64); 18] {
        [
            ("D1", self.d1_large_mm),
            ("L1", self.l1_mm),
            ("D2", self.d2_large_mm),
            ("L2", self.l2_mm),
            ("D3", self.d3_large_mm),
            ("L3", self.l3_mm),
            ("D2 (bar)", self.d2_mid_large_mm),
            ("d2 (bar)", self.d2_mid_small_mm),
            ("L2 (bar)", self.l2_mid_mm),
            ("Dm", self.dm_large_mm),
            ("dm", self.dm_small_mm),
            ("Lm", self.lm_mm),
            ("c", self.c_mm),
            ("t", self.t_mm),
            ("l", self.l_mm),
            ("e", self.e_mm),
            ("x_ss", self.xss_mm),
            ("Poisson's ratio", self.poisson_ratio),
        ]
    }
}
