//! Valid example messages, byte for byte as this crate writes them.

/// Birth of a robot.
pub const CONNECTION: &str = r#"{"boot_id":"b7","seq":0,"timestamp":"2026-11-21T08:00:00.000Z","state":"ONLINE"}"#;
/// Last will of the same connection.
pub const CONNECTION_WILL: &str =
    r#"{"boot_id":"b7","seq":1,"timestamp":"2026-11-21T08:00:00.000Z","state":"CONNECTION_BROKEN"}"#;
/// Two whiskers that can compensate for each other.
pub const FACTSHEET: &str = r#"{"boot_id":"b7","seq":0,"timestamp":"2026-11-21T08:00:00.000Z","model":"crawler-2","on_supervisor_loss":"HOLD","arrays":[{"array":"left","type":"TYPE_1","whiskers":[{"whisker":0,"x_mm":0.0,"y_mm":0.0,"model":"nguyen-2021","length_mm":70.0,"pressure_mpa":0.1,"pressure_max_mpa":0.2,"neighbours":[1]},{"whisker":1,"x_mm":25.0,"y_mm":0.0,"model":"nguyen-2021","length_mm":65.0,"pressure_mpa":0.1,"pressure_max_mpa":0.2,"neighbours":[0]}]}]}"#;
/// A robot that multiplies its readings by `reading_gain`.
pub const FACTSHEET_GAIN: &str = r#"{"boot_id":"b7","seq":0,"timestamp":"2026-11-21T08:00:00.000Z","model":"crawler-3","on_supervisor_loss":"NOMINAL","arrays":[{"array":"nose","type":"TYPE_1","whiskers":[{"whisker":0,"x_mm":0.0,"y_mm":0.0,"model":"nguyen-2021","length_mm":70.0,"length_tolerance_mm":0.3,"pressure_mpa":0.1,"pressure_max_mpa":0.2,"neighbours":[],"strain_max":0.02}]}],"applies_gain":true,"software":[{"kind":"AGENT","name":"vibrissa-robot","version":"0.2.0"},{"kind":"FIRMWARE","name":"vibrissa_board","version":"3"}]}"#;
/// A message with one contact.
pub const CONTACTS: &str = r#"{"boot_id":"b7","seq":1812,"contacts":[{"array":"left","whisker":0,"t_us":1795248000123456,"ratio":0.85,"deflection_mm":2.4,"strain":0.009671,"pressure_mpa":0.1002,"temperature_c":24.1}]}"#;
/// A chamber at its setpoint.
pub const STATUS: &str = r#"{"boot_id":"b7","seq":77,"t_us":1795248000123456,"whiskers":[{"array":"left","whisker":0,"pressure_mpa":0.1002,"setpoint_mpa":0.1,"regulator":"OK","gauge":"OK"}]}"#;
/// A chamber on its way to the setpoint, and dropped contacts messages.
pub const STATUS_DROPPED: &str = r#"{"boot_id":"b7","seq":78,"t_us":1795248001123456,"whiskers":[{"array":"left","whisker":0,"pressure_mpa":0.081,"setpoint_mpa":0.048,"regulator":"VENTING","gauge":"OK","segmenter":"NOISY"}],"contacts_dropped":12}"#;
/// All messages below 1810 are committed, and 1811 to 1813 beyond a gap.
pub const RECEIPT: &str = r#"{"boot_id":"s3","seq":410,"robot_boot_id":"b7","next":1810,"held":[[1811,1813]]}"#;
/// A trimmed whisker compensates for itself.
pub const SETPOINT: &str = r#"{"boot_id":"s3","seq":9,"command_id":"0198c5d2-6c1e-7d3b-9a55-3f0f5a1f2c11","epoch":1795248000000,"version":57,"robot_boot_id":"b7","array":"left","whisker":0,"pressure_mpa":0.048,"slew_mpa_per_s":0.02,"issued":"2026-11-21T08:00:01.000Z","expires_us":1795248031000000,"reason":"SELF_COMPENSATION","gain":[[0.45,0.861],[0.7,0.953],[1.0,1.0]]}"#;
/// A trimmed whisker compensates for itself: air for the shape of the response, and one gain for its level.
pub const SETPOINT_GAIN: &str = r#"{"boot_id":"s3","seq":10,"command_id":"0198c5d2-7f10-7b2c-8d41-90ab5c3e7f22","epoch":1795248000000,"version":58,"robot_boot_id":"b7","array":"nose","whisker":0,"pressure_mpa":0.082,"slew_mpa_per_s":0.02,"issued":"2026-11-21T08:00:01.000Z","expires_us":1795248031000000,"reason":"SELF_COMPENSATION","gain":[],"reading_gain":0.887}"#;
/// The chamber has reached the pressure.
pub const SETPOINT_STATE: &str = r#"{"boot_id":"b7","seq":31,"command_id":"0198c5d2-6c1e-7d3b-9a55-3f0f5a1f2c11","state":"APPLIED","t_us":1795248002123456,"pressure_mpa":0.0481}"#;
/// A rejected setpoint with its reason.
pub const SETPOINT_STATE_REJECTED: &str = r#"{"boot_id":"b7","seq":32,"command_id":"0198c5d2-7a42-7c10-8f31-51f2f0b9c6aa","state":"REJECTED","t_us":1795248003123456,"pressure_mpa":0.0481,"error":"STALE"}"#;
/// Asks for the factsheet again.
pub const REQUEST: &str = r#"{"boot_id":"s3","seq":2,"request":"FACTSHEET"}"#;
/// A trimmed whisker that compensates for itself, and a whole one.
pub const ESTIMATE: &str = r#"{"boot_id":"s3","seq":4,"epoch":1795248000000,"version":5,"timestamp":"2026-11-21T08:00:09.000Z","whiskers":[{"array":"left","whisker":0,"length_mm":62.1,"length_low_mm":61.82,"length_high_mm":62.38,"condition":"TRIMMED","pressure_mpa":0.048,"gain":[[0.45,1.02],[1.0,0.99]]},{"array":"left","whisker":1,"length_mm":65.0,"length_low_mm":64.8,"length_high_mm":65.2,"condition":"HEALTHY","pressure_mpa":0.1,"gain":[]}]}"#;
/// A trimmed whisker whose robot multiplies its readings.
pub const ESTIMATE_GAIN: &str = r#"{"boot_id":"s3","seq":5,"epoch":1795248000000,"version":6,"timestamp":"2026-11-21T08:00:10.000Z","whiskers":[{"array":"nose","whisker":0,"length_mm":65.1,"length_low_mm":64.8,"length_high_mm":65.4,"condition":"TRIMMED","pressure_mpa":0.082,"gain":[],"reading_gain":0.887,"response":[[15.2,0.00894,0.00031],[40.1,0.00601,0.0002],[65.1,0.00447,0.00016]]}]}"#;
/// A whisker that erodes, and a new one of which nothing is known.
pub const MAINTENANCE: &str = r#"{"boot_id":"s3","seq":2,"epoch":1795248000000,"timestamp":"2026-11-21T08:05:00.000Z","whiskers":[{"array":"left","whisker":0,"condition":"ERODING","factory_length_mm":70.0,"wear_mm":4.2,"wear_low_mm":3.9,"wear_high_mm":4.5,"last_calibration":"2026-11-20T22:14:03.000Z","contacts_left":5200.0,"contacts_left_low":4100.0,"contacts_left_high":6900.0},{"array":"left","whisker":1,"condition":"LEARNING","factory_length_mm":65.0,"wear_mm":null,"wear_low_mm":null,"wear_high_mm":null,"last_calibration":null,"contacts_left":null,"contacts_left_low":null,"contacts_left_high":null}]}"#;
/// A supervisor owns the fleet.
pub const SUPERVISOR_STATE: &str = r#"{"boot_id":"s3","seq":0,"state":"ONLINE","epoch":1795248000000}"#;
/// Asks every robot of the fleet for its birth and factsheet.
pub const SUPERVISOR_REQUEST: &str =
    r#"{"boot_id":"s3","seq":0,"epoch":1795248000000,"timestamp":"2026-11-21T08:00:00.000Z","request":"BIRTH"}"#;
/// Asks for touches near the tip of a whisker that feels nothing there any more.
pub const REQUEST_TOUCH_TEST: &str = r#"{"boot_id":"s3","seq":3,"request":"TOUCH_TEST","touch_test":{"test_id":"0198c5d2-9b3c-7e21-a4f0-6b7c8d9e0f12","epoch":1795248000000,"version":58,"robot_boot_id":"b7","array":"left","whisker":0,"kind":"WALL","distances_mm":[58.0,62.0,66.0,70.0],"deflections_mm":[1.0,2.0],"contacts":8,"issued":"2026-11-21T08:00:01.000Z","expires_us":1795248031000000,"reason":"SUSPICION"}}"#;
/// Two touches of the test: one came, one did not.
pub const CONTACTS_TOUCH_TEST: &str = r#"{"boot_id":"b7","seq":1813,"contacts":[{"array":"left","whisker":0,"t_us":1795248004123456,"distance_mm":62.0,"distance_sd_mm":0.5,"deflection_mm":2.0,"strain":0.008121,"pressure_mpa":0.1002,"temperature_c":24.1,"test_id":"0198c5d2-9b3c-7e21-a4f0-6b7c8d9e0f12"}],"missed":[{"array":"left","whisker":0,"t_us":1795248006123456,"distance_mm":66.0,"distance_sd_mm":0.5,"test_id":"0198c5d2-9b3c-7e21-a4f0-6b7c8d9e0f12"}]}"#;
/// All touches of the test are sent.
pub const TEST_STATE: &str = r#"{"boot_id":"b7","seq":2,"test_id":"0198c5d2-9b3c-7e21-a4f0-6b7c8d9e0f12","state":"DONE","t_us":1795248012123456}"#;
/// The robot cannot test now.
pub const TEST_STATE_REJECTED: &str = r#"{"boot_id":"b7","seq":3,"test_id":"0198c5d2-a1b2-7c3d-8e4f-5a6b7c8d9e0f","state":"REJECTED","t_us":1795248013123456,"error":"NOT_READY"}"#;
