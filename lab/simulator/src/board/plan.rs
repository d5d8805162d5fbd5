//! Options of the simulated board.

use std::path::PathBuf;

use clap::Args;

/// Options of `vibrissa-simulator board`.
#[derive(Debug, Clone, Args)]
pub struct BoardPlan {
    /// Scenario with the robot, in TOML; its events are left out
    #[arg(long, value_name = "FILE")]
    pub scenario: PathBuf,
    /// Robot of the scenario; default: its first one
    #[arg(long, value_name = "NAME")]
    pub robot: Option<String>,
    /// Connect to an agent that listens here, instead of using stdin and stdout; stdin is the control channel then
    #[arg(long, value_name = "HOST:PORT", group = "way")]
    pub connect: Option<String>,
    /// Listen here for the agent; stdin is the control channel then
    #[arg(long, value_name = "HOST:PORT", group = "way")]
    pub listen: Option<String>,
    /// Make a pseudo-terminal, as a serial device, and a symbolic link to it here; stdin is the control channel then
    #[arg(long, value_name = "LINK", group = "way")]
    pub pty: Option<PathBuf>,
    /// Send samples of the gauges instead of contacts: 100 a second, with the way of the slide. Touches at the tip slip off
    #[arg(long)]
    pub strain: bool,
    /// Have no regulator, but valves that the agent opens for short times (driver.regulate = true), and read the pressures 50
    /// times a second
    #[arg(long)]
    pub valves: bool,
    /// Pressure of the supply of those valves, in MPa
    #[arg(long, default_value_t = 0.25, value_name = "MPA", requires = "valves")]
    pub supply_mpa: f64,
    /// Leak of the first chamber of those valves at 0.1 MPa, in MPa/s
    #[arg(long, default_value_t = 0.0, value_name = "MPA_PER_S", requires = "valves")]
    pub leak_mpa_per_s: f64,
    /// Contact ratio of all touches; default: random ones
    #[arg(long, value_name = "RATIO", value_parser = vibrissa_program::options::number(0.5..=1.0))]
    pub touch_ratio: Option<f64>,
    /// File to which the board appends its own log, as JSON lines
    #[arg(long, value_name = "FILE")]
    pub log_file: Option<PathBuf>,
    /// Number of the whisker that SIGUSR1 cuts, in the first array
    #[arg(long, default_value_t = 0, value_name = "NUMBER")]
    pub cut_whisker: u16,
    /// Length of that whisker after the cut, in mm
    #[arg(long, default_value_t = 60.0, value_name = "MM")]
    pub cut_mm: f64,
    /// Time without a line from the agent after which all chambers are vented, in seconds
    #[arg(long, default_value_t = 30.0, value_name = "S")]
    pub watchdog_s: f64,
}
