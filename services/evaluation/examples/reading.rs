//! Probe.
#![allow(clippy::unwrap_used, clippy::print_stdout)]
use vibrissa_evaluation::compensation::reading::*;
fn main() {
    let seed: u64 = std::env::args().nth(1).map_or(1, |t| t.parse().unwrap());
    let count: usize = std::env::args().nth(2).map_or(20, |t| t.parse().unwrap());
    let trials = trials(seed, count);
    let all = evaluate(&trials, &|| ());
    let show = |name: &str, of: Vec<&Reading>| {
        let n = of.len() as f64;
        let mean = |f: &dyn Fn(&Reading) -> f64| 100.0 * of.iter().map(|one| f(one)).sum::<f64>() / n;
        let cov = mean(&|o| {
            let (l, h) = o.chosen.predicted_error_interval.unwrap();
            f64::from(u8::from(l <= o.open && o.open <= h))
        });
        let mcov =
            mean(&|o| o.measured.as_ref().map_or(0.0, |m| f64::from(u8::from((m.mean - o.end).abs() <= 1.96 * m.sd))));
        println!(
            "{name:<14} n {n:>4} open {:5.2} (pred {:5.2}, in {cov:5.1}) 300 {:5.2} 800 {:5.2} end {:5.2} best gain {:5.2} moved {:5.1} kPa measured {:5.2} in {mcov:5.1} setpoints {:4.1}",
            mean(&|o| o.open),
            mean(&|o| o.chosen.predicted_error.unwrap()),
            mean(&|o| o.looks[0]),
            mean(&|o| o.looks[1]),
            mean(&|o| o.end),
            mean(&|o| o.best_gain),
            mean(&|o| o.moved_mpa * 10.0),
            mean(&|o| o.measured.as_ref().map_or(0.0, |m| m.mean)),
            mean(&|o| o.setpoints as f64 / 100.0)
        );
    };
    for case in ALL {
        show(&format!("{case:?}"), of(case, &all).collect());
        for l in case.lengths_mm() {
            show(&format!("  {l}"), of(case, &all).filter(|o| o.trial.length_mm == l).collect());
        }
    }
    for l in SHORT_MM {
        show(&format!("self {l}"), of_length(l, &all).collect());
    }
    println!("unserved {}", all.iter().filter(|o| o.is_none()).count());
}
