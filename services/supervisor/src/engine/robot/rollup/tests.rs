use super::*;

/// Pseudorandom numbers with a fixed seed (SplitMix64).
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^ (mixed >> 31)
    }

    fn below(&mut self, end: u64) -> u64 {
        self.next() % end
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// 2026-11-21T08:00:00Z.
const START: u64 = 1_795_248_000_000_000;
const SECOND: u64 = 1_000_000;

fn sample(noise: &mut Noise) -> Sample {
    let used = [Use::Used, Use::Learning, Use::Unused][noise.below(3) as usize];
    Sample {
        used,
        residual: (used != Use::Unused).then(|| noise.between(-0.2, 0.2)),
        ratio: noise.between(0.45, 1.0),
        deflection_mm: noise.between(0.5, 4.0),
        strain: noise.between(0.001, 0.02),
        pressure_mpa: noise.between(0.0, 0.2),
        temperature_c: noise.between(10.0, 40.0),
        length_mm: noise.between(40.0, 70.0),
        length_sd_mm: noise.between(0.1, 0.5),
    }
}

/// Contacts in order of time, over some hours and with pauses.
fn contacts(seed: u64) -> Vec<(Micros, Sample)> {
    let mut noise = Noise(seed);
    let mut at = START + noise.below(3600 * SECOND);
    let next = |_| {
        let pause = if noise.below(33) == 0 { 4000 * SECOND } else { 9 * SECOND };
        at += noise.below(pause);
        (Micros(at), sample(&mut noise))
    };
    (0..800).map(next).collect()
}

/// The row of a span, computed from all its contacts at once.
fn brute_force(resolution: Resolution, start: u64, of: &[&Sample]) -> Rollup {
    let count = |used| of.iter().filter(|one| one.used == used).count() as u32;
    let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
    let each = |which: fn(&Sample) -> f64| mean(&of.iter().map(|one| which(one)).collect::<Vec<_>>());
    let heard: Vec<&&Sample> = of.iter().filter(|one| one.residual.is_some()).collect();
    let residuals: Vec<f64> = heard.iter().filter_map(|one| one.residual).collect();
    let middle = mean(&residuals);
    let squares: f64 = residuals.iter().map(|one| (one - middle).powi(2)).sum();
    let last = of[of.len() - 1];
    Rollup {
        resolution,
        start: Micros(start),
        used: count(Use::Used),
        learning: count(Use::Learning),
        unused: count(Use::Unused),
        response: (!residuals.is_empty()).then(|| ResponseMeans {
            residual_mean: middle,
            residual_sd: (residuals.len() > 1).then(|| (squares / (residuals.len() - 1) as f64).sqrt()),
            residual_min: residuals.iter().copied().fold(f64::INFINITY, f64::min),
            residual_max: residuals.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            sensitivity_per_mm: mean(&heard.iter().map(|one| one.strain / one.deflection_mm).collect::<Vec<_>>()),
            ratio: mean(&heard.iter().map(|one| one.ratio).collect::<Vec<_>>()),
        }),
        contact: Some(ContactMeans {
            length_mm: last.length_mm,
            length_sd_mm: last.length_sd_mm,
            length_mean_mm: each(|one| one.length_mm),
            pressure_mpa: each(|one| one.pressure_mpa),
            temperature_c: each(|one| one.temperature_c),
        }),
        error: None,
    }
}

fn close_to(one: f64, other: f64) {
    assert!((one - other).abs() <= 1e-6 * other.abs().max(1e-3), "{one} {other}");
}

fn same(one: &Rollup, other: &Rollup) {
    assert_eq!((one.resolution, one.start), (other.resolution, other.start));
    assert_eq!((one.used, one.learning, one.unused), (other.used, other.learning, other.unused));
    assert_eq!((one.response.is_some(), one.contact.is_some()), (other.response.is_some(), other.contact.is_some()));
    if let (Some(one), Some(other)) = (&one.response, &other.response) {
        assert_eq!(one.residual_sd.is_some(), other.residual_sd.is_some());
        close_to(one.residual_sd.unwrap_or_default(), other.residual_sd.unwrap_or_default());
        close_to(one.residual_mean, other.residual_mean);
        close_to(one.residual_min, other.residual_min);
        close_to(one.residual_max, other.residual_max);
        close_to(one.sensitivity_per_mm, other.sensitivity_per_mm);
        close_to(one.ratio, other.ratio);
    }
    if let (Some(one), Some(other)) = (&one.contact, &other.contact) {
        close_to(one.length_mm, other.length_mm);
        close_to(one.length_sd_mm, other.length_sd_mm);
        close_to(one.length_mean_mm, other.length_mean_mm);
        close_to(one.pressure_mpa, other.pressure_mpa);
        close_to(one.temperature_c, other.temperature_c);
    }
}

#[test]
fn brute_force_rows_are_those_of_all_contacts_at_once() {
    for seed in 0..20 {
        let contacts = contacts(seed);
        let (mut open, mut closed) = (Open::default(), Vec::new());
        for (at, sample) in &contacts {
            open.add(*at, sample, &mut closed);
            // Storing and reading it back at any time must change nothing.
            open = Open::from_bytes(Some(&open.to_bytes().unwrap()), *at);
        }
        open.end(&mut closed);
        for resolution in Resolution::ALL {
            let rows: Vec<&Rollup> = closed.iter().filter(|row| row.resolution == resolution).collect();
            let mut starts: Vec<u64> =
                contacts.iter().map(|(at, _)| at.0 / resolution.us() * resolution.us()).collect();
            starts.dedup();
            assert_eq!(rows.iter().map(|row| row.start.0).collect::<Vec<_>>(), starts);
            for row in rows {
                let here = contacts.iter().filter(|(at, _)| at.0 / resolution.us() * resolution.us() == row.start.0);
                let here: Vec<&Sample> = here.map(|(_, sample)| sample).collect();
                same(row, &brute_force(resolution, row.start.0, &here));
            }
        }
    }
}

#[test]
fn the_stored_form_is_small() {
    let mut noise = Noise(1);
    let (mut open, mut closed) = (Open::default(), Vec::new());
    assert!(open.to_bytes().unwrap().len() < 20);
    open.add(Micros(START), &sample(&mut noise), &mut closed);
    open.state(Micros(START), 0.2, &mut closed);
    let bytes = open.to_bytes().unwrap();
    assert!(bytes.len() <= 200, "{}", bytes.len());
    assert_eq!(size_of::<Open>(), 208, "docs/sizing.md states this size");
    assert_eq!(Open::from_bytes(Some(&bytes), Micros(START)), open);
}

#[test]
fn what_is_over_is_closed_after_a_grace_and_once() {
    let mut noise = Noise(2);
    let (mut open, mut closed) = (Open::default(), Vec::new());
    open.add(Micros(START + 10 * SECOND), &sample(&mut noise), &mut closed);
    assert!(!open.close(Micros(START + 61 * SECOND), &mut closed));
    assert!(open.close(Micros(START + 62 * SECOND), &mut closed));
    assert!(!open.close(Micros(START + 63 * SECOND), &mut closed));
    assert!(open.close(Micros(START + 3602 * SECOND), &mut closed));
    assert!(!open.close(Micros(START + 9999 * SECOND), &mut closed));
    let intervals: Vec<_> = closed.iter().map(|row| (row.resolution, row.start.0)).collect();
    assert_eq!(intervals, [(Resolution::Minute, START), (Resolution::Hour, START)]);
}

#[test]
fn property_no_span_is_written_twice_whatever_the_clock_does() {
    for seed in 0..50 {
        let mut noise = Noise(seed);
        let (mut open, mut closed, mut sent) = (Open::default(), Vec::new(), 0);
        for _ in 0..400 {
            // Random times within four hours, forward and backward.
            let at = Micros(START + noise.below(4 * 3600 * SECOND));
            match noise.below(6) {
                0 => drop(open.close(at, &mut closed)),
                1 => open.end(&mut closed),
                2 => open.state(at, 0.1, &mut closed),
                _ => {
                    open.add(at, &sample(&mut noise), &mut closed);
                    sent += 1;
                }
            }
        }
        open.end(&mut closed);
        for resolution in Resolution::ALL {
            let rows: Vec<&Rollup> = closed.iter().filter(|row| row.resolution == resolution).collect();
            assert!(rows.windows(2).all(|pair| pair[0].start < pair[1].start));
            assert_eq!(rows.iter().map(|row| row.used + row.learning + row.unused).sum::<u32>(), sent);
        }
    }
}

#[test]
fn an_error_is_kept_without_contacts_and_the_last_one_counts() {
    let (mut open, mut closed) = (Open::default(), Vec::new());
    open.state(Micros(START), 0.5, &mut closed);
    open.state(Micros(START + SECOND), 0.25, &mut closed);
    open.end(&mut closed);
    assert_eq!(closed.len(), 2);
    for row in closed {
        assert_eq!((row.error, row.response, row.contact), (Some(0.25), None, None));
    }
}

#[test]
fn bytes_that_cannot_be_read_open_nothing_that_may_be_written() {
    for bytes in [&b""[..], b"x", &[2; 30]] {
        assert_eq!(Open::from_bytes(Some(bytes), Micros(START)), Open::after(Micros(START)));
    }
    let (mut open, mut closed) = (Open::after(Micros(START)), Vec::new());
    open.state(Micros(START + SECOND), 0.1, &mut closed);
    open.end(&mut closed);
    let starts: Vec<u64> = closed.iter().map(|row| row.start.0).collect();
    assert_eq!(starts, [START + 60 * SECOND, START + 3600 * SECOND]);
}
