//! Runs plans.
#![allow(clippy::all, clippy::unwrap_used, clippy::disallowed_methods)]
use vibrissa_simulation::plan::{Plan, Sizes};
fn main() {
    let mut args = std::env::args().skip(1).map(|a| a.parse::<u64>().unwrap());
    let first = args.next().unwrap();
    let count = args.next().unwrap_or(1);
    for seed in first..first + count {
        let plan = Plan::draw(seed, Sizes::default());
        let begun = std::time::Instant::now();
        let outcome = vibrissa_simulation::world::run(&plan);
        println!("seed {seed}: {} sup {} fleets {} robots {} strikes {:.2}/s: {:.1} s simulated in {:.2} s, {:?}, hash {:x}", plan.supervisors, plan.fleets, plan.robots, plan.strikes.len(), plan.contacts_per_second, outcome.simulated.as_secs_f64(), begun.elapsed().as_secs_f64(), outcome.counts, outcome.hash);
        for v in &outcome.violations { println!("   {v}"); }
        if count == 1 { for l in &outcome.lines { println!("{}", l.chars().take(230).collect::<String>()); } }
    }
}
