use super::*;

pub(crate) const EXAMPLE: &str = r#"
    fleet = "lab"
    robot = "crawler"
    touch_tests = ["WALL"]
    [broker]
    url = "mqtt://127.0.0.1"
    [driver]
    command = ["python3", "driver.py"]
    [[arrays]]
    array = "left"
    type = "TYPE_1"
    whiskers = [
        { whisker = 0, length_mm = 70.0, pressure_mpa = 0.1, pressure_max_mpa = 0.2, neighbours = [1] },
        { whisker = 1, length_mm = 70.0, pressure_mpa = 0.1, pressure_max_mpa = 0.2 },
    ]
    "#;

#[test]
fn the_smallest_configuration_has_the_defaults() {
    let config = Config::from_toml_str(EXAMPLE, Path::new("/etc/x")).unwrap();
    assert_eq!(config.drivers[0].way, Way::Command(vec!["python3".to_owned(), "driver.py".to_owned()]));
    assert_eq!((config.limits.outbox_bytes, config.drivers[0].limits.silent_us), (1 << 20, 5_000_000));
    assert_eq!(config.facts.arrays[0].whiskers.len(), 2);
    assert!(!config.facts.applies_gain);
    let text = EXAMPLE.replacen("robot = ", "applies_gain = true\nair_control = \"NONE\"\nrobot = ", 1);
    let facts = Config::from_toml_str(&text, Path::new("")).unwrap().facts;
    assert_eq!((facts.applies_gain, facts.air_control), (true, Some(vibrissa_protocol::AirControl::None)));
}

#[test]
fn a_password_in_the_wrong_place_is_not_shown() {
    let text = EXAMPLE.replacen("url = ", "password = \"hunter2\"\nurl = ", 1);
    let problem = Config::from_toml_str(&text, Path::new("")).unwrap_err().to_string();
    assert!(problem.starts_with("line 6: unknown field `password`"), "{problem}");
    assert!(!problem.contains("hunter2"), "{problem}");
}

#[test]
fn a_wrong_key_is_named() {
    for (from, to, named) in [
        ("robot =", "robbot =", "robbot"),
        ("pressure_max_mpa = 0.2 }", "pressure_max_mpa = 0.3 }", "array left whisker 1 pressure_max_mpa is 0.3"),
        ("length_mm = 70.0, pressure_mpa = 0.1", "length_mm = nan, pressure_mpa = 0.1", "whisker 0 length_mm is NaN"),
        ("neighbours = [1]", "neighbours = [2]", "whisker 0 neighbours: 2 is not another whisker"),
        ("mqtt://127", "ftp://127", "broker: invalid broker URL"),
        ("command = [\"python3\", \"driver.py\"]", "", "exactly one of command"),
        ("command = [\"python3\", \"driver.py\"]", "listen = \"0.0.0.0:1\"", "driver.listen: must be a loopback"),
        ("command = [\"python3\", \"driver.py\"]", "tcp = \"board.lan:5\"", "driver.tcp: needs driver.token_file"),
        ("command = [\"python3\", \"driver.py\"]", "tcp = \"[::2]:5\"", "driver.tcp: needs driver.token_file"),
        ("[driver]", "[driver]\nsilent_s = 0.1", "driver.silent_s is 0.1, but must be between 0.5 and 600"),
        ("[driver]", "[driver]\nbaud = 9600", "driver.baud: needs driver.serial"),
        ("[driver]", "[outbox]\nbytes = 5\n[driver]", "outbox.bytes is 5"),
        ("url = ", "username = \"u\"\nurl = ", "broker.username: needs broker.password_file"),
        ("url = ", "ca_file = \"c\"\nurl = ", "broker.ca_file: requires mqtts://"),
        ("url = ", "client_key_file = \"k\"\nurl = ", "broker.client_key_file: needs broker.client_certificate_file"),
        (
            "url = ",
            "client_certificate_file = \"c\"\nclient_key_file = \"k\"\nurl = ",
            "broker.client_certificate_file: needs broker.ca_file",
        ),
        (
            "url = ",
            "username = \"u\"\npassword_file = \"/no/such\"\nurl = ",
            "broker: cannot read the password from /no/such",
        ),
        ("\"WALL\"", "\"WALL\", \"WALL\"", "touch_tests: names a test twice"),
        ("\"crawler\"", "\"supervisor\"", "robot"),
    ] {
        let text = EXAMPLE.replacen(from, to, 1);
        assert_ne!(text, EXAMPLE);
        let problem = Config::from_toml_str(&text, Path::new("")).expect_err(named).to_string();
        assert!(problem.contains(named), "{named}: {problem}");
    }
}
