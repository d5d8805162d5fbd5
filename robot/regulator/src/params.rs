//! Parameters, with defaults for a chamber of a few millilitres, a 10-bit sensor and small solenoid valves.

/// Parameters of a [`crate::Regulator`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Params {
    /// Highest setpoint; a reading above it by more than a step opens the vent valve. MPa.
    pub max_mpa: f32,
    /// Step of the pressure sensor: 1.22 kPa for a 10-bit converter with MPa = (V - 1) / 4.
    pub sensor_step_mpa: f32,
    /// Readings below this are a fault of the sensor. MPa.
    pub reading_low_mpa: f32,
    /// Readings above this are a fault of the sensor. MPa.
    pub reading_high_mpa: f32,
    /// Pressure of the supply if no reading of it is given. MPa.
    pub supply_mpa: f32,
    /// The supply must exceed the setpoint by this much. MPa.
    pub supply_margin_mpa: f32,
    /// Gain assumed at first, per second: the rate of the fastest chamber, so that the first pulse never overshoots.
    pub gain_first_per_s: f32,
    /// Gain of the slowest chamber, per second: a valve that does less does nothing.
    pub gain_least_per_s: f32,
    /// Time from the command until the valve opens, as assumed at first. µs.
    pub dead_first_us: f32,
    /// Longest believable dead time. µs.
    pub dead_most_us: f32,
    /// Longest pulse. µs.
    pub pulse_most_us: u32,
    /// Pause after each pulse, of which readings of the second half are averaged. µs.
    pub settle_us: u32,
    /// Fewest readings to average after a pulse.
    pub settle_readings: u32,
    /// Shortest time between two pulses while holding. µs.
    pub hold_interval_us: u32,
    /// Shortest time between two pulses while holding against a leak or a disturbance. µs.
    pub refill_interval_us: u32,
    /// Time constant of the filter on readings while holding. µs.
    pub filter_us: f32,
    /// Pause after a setpoint is reached until leaks are measured: the air cools, and silicone creeps. µs.
    pub leak_after_us: u32,
    /// Leaks above this are reported. MPa per second.
    pub leak_report_mpa_per_s: f32,
    /// Leaks above this are a burst chamber: a fault. MPa per second.
    pub leak_burst_mpa_per_s: f32,
    /// A setpoint towards which nothing moves for this long has a reason. µs.
    pub reach_us: u32,
    /// Bad readings for this long are a fault, good ones for this long end it. µs.
    pub sensor_us: u32,
    /// Pause between attempts to fill from a supply that gave nothing. µs.
    pub retry_us: u32,
    /// Whether a fault opens the vent valve until the chamber is empty; otherwise both valves stay closed.
    pub vent_on_fault: bool,
    /// Longest total opening of the vent valve in a fault. µs.
    pub vent_on_fault_us: u32,
}

impl Default for Params {
    fn default() -> Params {
        Params {
            max_mpa: 0.2,
            sensor_step_mpa: 0.001_220_703_1,
            reading_low_mpa: -0.02,
            reading_high_mpa: 0.5,
            supply_mpa: 0.25,
            supply_margin_mpa: 0.005,
            gain_first_per_s: 12.0,
            gain_least_per_s: 0.3,
            dead_first_us: 5_000.0,
            dead_most_us: 30_000.0,
            pulse_most_us: 1_000_000,
            settle_us: 80_000,
            settle_readings: 6,
            hold_interval_us: 2_000_000,
            refill_interval_us: 250_000,
            filter_us: 300_000.0,
            leak_after_us: 3_000_000,
            leak_report_mpa_per_s: 0.000_05,
            leak_burst_mpa_per_s: 0.02,
            reach_us: 10_000_000,
            sensor_us: 300_000,
            retry_us: 10_000_000,
            vent_on_fault: true,
            vent_on_fault_us: 20_000_000,
        }
    }
}
