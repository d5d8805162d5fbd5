//! The simulation of docs/scale.md gives what the page shows.

use std::process::Command;

use crate::project;

#[test]
fn the_small_simulation_gives_the_output_of_the_page() {
    let page = std::fs::read_to_string(project().join("docs/scale.md")).unwrap();
    let command = page.lines().find(|line| line.contains("simulate.py --plan small")).unwrap();
    let (program, arguments) = command.split_once(' ').unwrap();
    let output = Command::new(program).args(arguments.split(' ')).current_dir(project()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let printed = String::from_utf8(output.stdout).unwrap();
    let shown = page.split("```text\n").nth(1).unwrap().split("```").next().unwrap();
    assert_eq!(printed, shown, "docs/scale.md is out of date");
}

#[test]
fn the_pages_costs_are_those_of_the_simulation() {
    let page = std::fs::read_to_string(project().join("docs/scale.md")).unwrap();
    let script = std::fs::read_to_string(project().join("docs/scale/simulate.py")).unwrap();
    for (constant, value) in [
        ("BROKER_S_PER_MESSAGE = 14.2 * US", "| 14.2 us"),
        ("SUPERVISOR_S_PER_MESSAGE = 4.1 * US", "| 4.1 us |"),
        ("SUPERVISOR_S_PER_FURTHER_CONTACT = 2.0 * US", "| 2.0 us |"),
        ("COPY_S_PER_CONTACT = 1.8 * US", "| 1.8 us in commits"),
        ("INSERT_S_PER_CONTACT = 3.0 * US", "else 3.0 us"),
        ("WAL_BYTES_PER_CONTACT = 130", "| 130 and 149 bytes |"),
        ("STATES_PER_S = 111_000", "111,000 whiskers per second"),
    ] {
        assert!(script.contains(constant), "{constant} is not in the script");
        assert!(page.contains(value), "{value} is not in the page");
    }
}
