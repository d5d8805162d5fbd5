//! Closed forms of the integrals over tapered sections; tests compare each with quadrature.

use super::geometry::Geometry;

impl Geometry {
    /// G: elongation of the whole chamber in mm for Q = E2, by eq. 24 from c to l:
    /// `delta_l(l) = G * Q / (k2 * E)`.
    #[must_use]
    pub fn elongation_gain_mm(&self) -> f64 {
        self.elongation_gain_between_mm(self.c_mm, self.l_mm)
    }

    /// Eq. 24 between two cross sections instead of from c, for Q = E2, in mm.
    pub(super) fn elongation_gain_between_mm(&self, from_mm: f64, to_mm: f64) -> f64 {
        axial_compliance_mm(self, to_mm) - axial_compliance_mm(self, from_mm)
    }

    /// Axial strain of the gauge's grid for Q = E2 (eq. 32), dimensionless.
    pub(super) fn axial_gain(&self) -> f64 {
        self.elongation_gain_between_mm(self.xss_mm, self.xss_mm + self.e_mm) / self.e_mm
    }
}

/// Eq. 24 from c to `x_mm` without the factor Q / E2: elongation of the chamber up to `x_mm`, in mm.
///
/// `d_m^2 L2^2 Lm^2 * integral of dx / (D2^2 Lm^2 (L2 - x + c)^2 - Dm^2 L2^2 (Lm - x + c)^2)`. The denominator is a
/// difference of squares, (p - q)(p + q), with both factors linear in X = x - c: `(alpha - beta X)(gamma - eta X)`.
/// Partial fractions give a logarithm of `1 + X (eta alpha - beta gamma) / ((gamma - eta X) alpha)`. Written as
/// `ln(1 + z) / z` it also holds for equal tapers (`beta` = 0, the paper's whisker) and in the limit of equal cones
/// (z = 0).
pub(super) fn axial_compliance_mm(g: &Geometry, x_mm: f64) -> f64 {
    let along_mm = x_mm - g.c_mm;
    let outer = g.d2_large_mm * g.lm_mm;
    let inner = g.dm_large_mm * g.l2_mm;
    let alpha = g.l2_mm * g.lm_mm * (g.d2_large_mm - g.dm_large_mm);
    let gamma = g.l2_mm * g.lm_mm * (g.d2_large_mm + g.dm_large_mm);
    let (beta, eta) = (outer - inner, outer + inner);
    let divisor = (gamma - eta * along_mm) * alpha;
    let z = along_mm * (eta * alpha - beta * gamma) / divisor;
    let integral = along_mm / divisor * ln_1p_over(z);
    g.dm_small_mm.powi(2) * g.l2_mm.powi(2) * g.lm_mm.powi(2) * integral
}

/// ln(1 + z) / z, which is 1 at z = 0.
fn ln_1p_over(z: f64) -> f64 {
    if z == 0.0 { 1.0 } else { z.ln_1p() / z }
}

/// Polynomial of second degree in the contact distance A: value and slope.
///
/// A bending moment is linear in A, so the derivative of an energy is quadratic in A, and each cone contributes
/// three numbers. The expansion is about `pole_mm`, the apex of the cone: with w = pole - A the polynomial is
/// `s0 - s1 w + s2 w^2`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Quadratic {
    pub(super) pole_mm: f64,
    pub(super) s0: f64,
    pub(super) s1: f64,
    pub(super) s2: f64,
}

impl Quadratic {
    pub(super) fn at(&self, contact_mm: f64) -> f64 {
        let w = self.pole_mm - contact_mm;
        (self.s2 * w - self.s1) * w + self.s0
    }

    pub(super) fn slope_at(&self, contact_mm: f64) -> f64 {
        let w = self.pole_mm - contact_mm;
        self.s1 - 2.0 * self.s2 * w
    }
}

/// Eq. 10 and 26 as a polynomial: `64 L1^4 / D1^4 * integral of (A - x)^2 / (L1 - x)^4` over the cap.
pub(super) fn cap_delta1(g: &Geometry) -> Quadratic {
    let scale = 64.0 * (g.l1_mm / g.d1_large_mm).powi(4);
    let (near, far) = (1.0 / g.l1_mm, 1.0 / (g.l1_mm - g.c_mm));
    let step = far - near;
    Quadratic {
        pole_mm: g.l1_mm,
        s0: scale * step,
        s1: scale * step * (far + near),
        s2: scale * step * (far * far + far * near + near * near) / 3.0,
    }
}

/// Eq. 11 and 27 as a polynomial, without the factor before the bracket:
/// `integral of (A - x)^2 / (L - x + c)^3` from c to `end_mm`, L being the length of the mid-wall cone.
pub(super) fn chamber_delta2(cone_mm: f64, c_mm: f64, end_mm: f64) -> Quadratic {
    let (near, far) = (1.0 / cone_mm, 1.0 / (cone_mm + c_mm - end_mm));
    let step = far - near;
    Quadratic { pole_mm: cone_mm + c_mm, s0: (cone_mm * far).ln(), s1: 2.0 * step, s2: 0.5 * step * (far + near) }
}

/// Eq. 16 and 30 as a polynomial (of first degree): the integral over the gauge's grid,
/// `((D / L) (L - x + c) + t) (A - x) / (L - x + c)^3` from `start_mm` over `grid_mm`.
pub(super) fn gauge_kappa(
    (diameter_mm, cone_mm): (f64, f64),
    wall_mm: f64,
    c_mm: f64,
    start_mm: f64,
    grid_mm: f64,
) -> Quadratic {
    let pole_mm = cone_mm + c_mm;
    let (near, far) = (1.0 / (pole_mm - start_mm), 1.0 / (pole_mm - start_mm - grid_mm));
    let step = grid_mm * near * far;
    let taper = diameter_mm / cone_mm;
    Quadratic {
        pole_mm,
        s0: taper * (grid_mm * far).ln_1p() + wall_mm * step,
        s1: taper * step + wall_mm * 0.5 * step * (far + near),
        s2: 0.0,
    }
}

/// Eq. 12 and 28: `64 L3 / (3 D3^4) * y^3 / (L3 - y)` and its slope, where y = A - l is the distance of the contact
/// beyond the chamber. y is less than L3; the value grows without bound toward the apex of the cone.
pub(super) fn body_delta3(g: &Geometry, beyond_mm: f64) -> (f64, f64) {
    let left_mm = g.l3_mm - beyond_mm;
    let scale = 64.0 * g.l3_mm / (3.0 * g.d3_large_mm.powi(4));
    let value = scale * beyond_mm.powi(3) / left_mm;
    let slope = scale * beyond_mm.powi(2) * (3.0 * left_mm + beyond_mm) / left_mm.powi(2);
    (value, slope)
}
