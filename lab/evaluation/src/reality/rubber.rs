//! Memory of the rubber: creep, and a loop (hysteresis) between the way in and the way out.

use super::nuisances::{DEFLECTION_MAX_MM, Nuisances};

/// Time constants of the Prony series, s.
const CREEP_S: [f64; 2] = [1.0, 30.0];
/// Radii of the play operators that form the loop, mm.
const PLAY_MM: [f64; 3] = [0.1, 0.3, 0.6];

/// One contact as the rubber feels it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Press {
    /// Deflection at the reading, mm.
    pub deflection_mm: f64,
    /// Largest deflection before the reading, at least `deflection_mm`: larger on the way out.
    pub peak_mm: f64,
    /// Time since the end of the last contact, s.
    pub pause_s: f64,
    /// Time from the touch to the reading, s.
    pub held_s: f64,
}

/// State of the rubber of one whisker.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Rubber {
    /// Deflection that each Prony term has followed, mm.
    followed_mm: [f64; 2],
    /// State of each play operator, mm.
    play_mm: [f64; 3],
}

impl Rubber {
    /// Deflection that the gauge feels at a contact, mm.
    pub(super) fn press(&mut self, nuisances: &Nuisances, press: &Press) -> f64 {
        let deflection_mm = press.deflection_mm;
        let mut felt_mm = deflection_mm;
        if nuisances.creep > 0.0 {
            // In the pause each term recovers, and in the hold it follows the deflection.
            for (followed_mm, tau_s) in self.followed_mm.iter_mut().zip(CREEP_S) {
                *followed_mm *= (-press.pause_s / tau_s).exp();
                *followed_mm = deflection_mm + (*followed_mm - deflection_mm) * (-press.held_s / tau_s).exp();
                felt_mm -= nuisances.creep * *followed_mm;
            }
        }
        if nuisances.loop_mm > 0.0 {
            // Far from the ends of the loop, its width is twice the weighted sum of the radii.
            let weight = 0.5 * nuisances.loop_mm / PLAY_MM.iter().sum::<f64>();
            for (play_mm, radius_mm) in self.play_mm.iter_mut().zip(PLAY_MM) {
                for at_mm in [press.peak_mm.min(DEFLECTION_MAX_MM), deflection_mm] {
                    *play_mm = play_mm.clamp(at_mm - radius_mm, at_mm + radius_mm);
                }
                felt_mm += weight * (*play_mm - deflection_mm);
                // Between two contacts the deflection is 0.
                *play_mm = play_mm.clamp(-radius_mm, radius_mm);
            }
        }
        felt_mm
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The ways in and out of a full deflection, from rest.
    fn ways(nuisances: &Nuisances, deflection_mm: f64) -> (f64, f64) {
        let way = |peak_mm: f64| {
            let mut rubber = Rubber::default();
            let press = |deflection_mm, peak_mm| Press { deflection_mm, peak_mm, pause_s: 1e3, held_s: 1e-3 };
            rubber.press(nuisances, &press(0.0, DEFLECTION_MAX_MM));
            rubber.press(nuisances, &press(deflection_mm, peak_mm))
        };
        (way(deflection_mm), way(DEFLECTION_MAX_MM))
    }

    #[test]
    fn property_the_loop_is_4_per_cent_of_the_full_range_wide() {
        let nuisances = Nuisances { loop_mm: 0.24, ..Nuisances::NONE };
        let (way_in, way_out) = ways(&nuisances, 3.0);
        assert!((way_out - way_in - 0.24).abs() < 1e-12, "{way_in} {way_out}");
        let width = |deflection_mm: f64| {
            let (way_in, way_out) = ways(&nuisances, deflection_mm);
            way_out - way_in
        };
        assert!((0..=60).all(|tenth| width(0.1 * f64::from(tenth)) < 0.24 + 1e-12));
        assert!(width(DEFLECTION_MAX_MM).abs() < 1e-12 && width(0.05) < 0.15);
    }

    #[test]
    fn property_a_hold_creeps_by_its_two_terms_and_recovers() {
        let nuisances = Nuisances { creep: 0.02, ..Nuisances::NONE };
        let mut rubber = Rubber::default();
        let mut felt = |pause_s: f64, held_s: f64| {
            rubber.press(&nuisances, &Press { deflection_mm: 2.0, peak_mm: 2.0, pause_s, held_s })
        };
        let after_9_s = felt(1e4, 9.0) / 2.0;
        // 2 % (1 - exp(-9)) + 2 % (1 - exp(-0.3)).
        assert!((after_9_s - (1.0 - 0.02 * (0.999_877 + 0.259_182))).abs() < 1e-6, "{after_9_s}");
        let soon = felt(1.0, 1e-6) / 2.0;
        let late = felt(1e4, 1e-6) / 2.0;
        assert!(soon < 0.99 && (late - 1.0).abs() < 1e-6, "{soon} {late}");
    }
}
