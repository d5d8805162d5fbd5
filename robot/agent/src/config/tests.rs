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
fn a_whisker_may_state_which_way_a_touch_moves_its_strain() {
    let text = EXAMPLE.replacen("neighbours = [1]", "neighbours = [1], segmenter.sign = \"FALLS\"", 1);
    let config = Config::from_toml_str(&text, Path::new("")).unwrap();
    let signs: Vec<_> = config.whiskers.values().map(|whisker| whisker.sign).collect();
    assert_eq!(signs, [Some(Sign::Falls), None]);
    let text = EXAMPLE.replacen("neighbours = [1]", "segmenter.sign = \"UP\"", 1);
    let problem = Config::from_toml_str(&text, Path::new("")).unwrap_err().to_string();
    assert!(problem.contains("RISES") && problem.contains("FALLS"), "{problem}");
}

#[test]
fn a_program_that_is_the_driver_needs_no_way_to_it() {
    let folder = std::env::temp_dir().join(format!("vibrissa-robot-driven-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("agent.toml");
    let driver = "[driver]\n    command = [\"python3\", \"driver.py\"]";
    let read = |instead: &str| {
        std::fs::write(&path, EXAMPLE.replacen(driver, instead, 1)).unwrap();
        Config::read_driven_at(&path, PathBuf::from("/run/x")).map_err(|problem| problem.to_string())
    };
    for (instead, silent_us) in
        [("", 5_000_000), (driver, 5_000_000), ("[driver]\nserial = \"x\"\nsilent_s = 2", 2_000_000)]
    {
        let config = read(instead).unwrap();
        let [only] = config.drivers.as_slice() else { panic!("{instead}") };
        assert_eq!((&only.way, only.limits.silent_us), (&Way::Unix(PathBuf::from("/run/x")), silent_us));
    }
    let several =
        "[[driver]]\nwhiskers = [\"left/0\"]\nserial = \"x\"\n[[driver]]\nwhiskers = [\"left/1\"]\nserial = \"y\"";
    let problem = read(several).unwrap_err();
    assert_eq!(problem, "driver: must be one table, because this program is the only driver");
    let problem = read("[driver]\nregulate = true").unwrap_err();
    assert!(problem.starts_with("driver.regulate: must be left out"), "{problem}");
    let either = |instead: &str| {
        std::fs::write(&path, EXAMPLE.replacen(driver, instead, 1)).unwrap();
        Config::read_either(&path).map(|(_, is_driven)| is_driven).map_err(|problem| problem.to_string())
    };
    assert_eq!((either(""), either("[driver]\nsilent_s = 2")), (Ok(true), Ok(true)));
    assert_eq!(either("[driver]\nserial = \"x\""), Ok(false));
    assert!(either(several).is_ok_and(|is_driven| !is_driven));
    assert!(either("[driver]\nregulate = true").is_err_and(|problem| !problem.contains("only driver")));
    let problem = read("[driver]\npassword = \"hunter2").unwrap_err();
    assert!(problem.contains("line") && !problem.contains("hunter2"), "{problem}");
    std::fs::remove_dir_all(&folder).unwrap();
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

/// Each key once, with a value that is in order.
const WHOLE: &str = r#"
fleet = "lab"
robot = "crawler"
model = "m"
on_supervisor_loss = "HOLD"
touch_tests = ["WALL"]
applies_gain = true
air_control = "FILL_AND_VENT"
[broker]
url = "mqtt://127.0.0.1"
[outbox]
messages = 100
bytes = 70000
disk_bytes = 16000000
[contacts]
per_message = 5
message_after_s = 0.1
per_s_max = 100.0
temperature_c = 24.0
[segmenter]
least_strain = 0.001
strain_limit = 0.05
baseline_s = 1.0
longest_s = 30.0
[supervisor]
lost_after_s = 60.0
status_every_s = 2.0
[[driver]]
name = "board"
whiskers = ["left/0"]
serial = "tty"
baud = 9600
restart = true
regulate = false
silent_s = 5.0
repeat_s = 2.0
tolerance_mpa = 0.003
settle_s = 0.5
fail_after_s = 6.0
own_slew_mpa_per_s = 0.02
[[arrays]]
array = "left"
type = "TYPE_1"
task = "RATIO"
[[arrays.whiskers]]
whisker = 0
x_mm = 0.0
y_mm = 0.0
model = "m"
length_mm = 70.0
length_tolerance_mm = 0.3
pressure_mpa = 0.1
pressure_max_mpa = 0.2
neighbours = []
strain_max = 0.01
place = "TIP"
segmenter.sign = "RISES"
pressure_zero_mpa = 0.001
"#;

/// Keys without a default.
const REQUIRED: [&str; 10] =
    ["fleet", "robot", "url", "serial", "array", "type", "whisker", "length_mm", "pressure_mpa", "pressure_max_mpa"];

fn problem_of(text: &str) -> Option<String> {
    Config::from_toml_str(text, Path::new("/etc/x")).err().map(|problem| problem.to_string())
}

#[test]
fn property_each_key_that_is_missing_misspelt_of_another_type_or_out_of_range_is_refused() {
    assert_eq!(problem_of(WHOLE), None);
    let lines: Vec<&str> = WHOLE.lines().collect();
    let mut refused = 0;
    for (at, line) in lines.iter().enumerate() {
        let Some((key, value)) = line.split_once(" = ") else { continue };
        let with = |line: &str| {
            let mut lines = lines.clone();
            lines[at] = line;
            lines.join("\n")
        };
        assert_eq!(problem_of(&with("")).is_some(), REQUIRED.contains(&key), "without {key}");
        let mut bad = vec![format!("{key}x = {value}"), format!("{line}\n{line}")];
        bad.extend(["{ a = 1 }", "1979-05-27", "[[1]]"].map(|value| format!("{key} = {value}")));
        let is_list = value.starts_with('[');
        if is_list || value.starts_with('"') {
            bad.extend(["7", "true"].map(|value| format!("{key} = {value}")));
        } else {
            bad.push(format!("{key} = \"7\""));
        }
        match key {
            "model" => bad.extend(["\"\"", "\"a\\u0007\""].map(|value| format!("{key} = {value}"))),
            "serial" => bad.push(format!("{key} = \"\"")),
            _ if value.starts_with('"') => {
                bad.extend(["\"\"", "\"nothing like it!\""].map(|value| format!("{key} = {value}")));
            }
            "touch_tests" | "whiskers" | "neighbours" => {
                bad.extend(["[\"x\"]", "[0, 0]", "[99]"].map(|value| format!("{key} = {value}")));
            }
            "restart" | "regulate" | "applies_gain" => bad.push(format!("{key} = 1")),
            _ => {
                bad.extend(["nan", "inf", "-inf", "-1e9", "1e15", "-200000"].map(|value| format!("{key} = {value}")));
            }
        }
        for line in bad {
            let problem = problem_of(&with(&line)).unwrap_or_else(|| panic!("{line} is taken"));
            assert!(!problem.is_empty() && problem.len() < 400, "{line}: {problem}");
            refused += 1;
        }
    }
    assert!(refused > 300, "{refused}");
}

#[test]
fn regress_what_contradicts_is_refused() {
    for (from, to, named) in [
        ("settle_s = 0.5", "settle_s = 6.0", "driver board: driver.settle_s: must be below driver.fail_after_s"),
        ("least_strain = 0.001", "least_strain = 0.06", "segmenter.least_strain: must be below segmenter.strain_limit"),
        ("pressure_mpa = 0.1", "pressure_mpa = 0.21", "pressure_mpa is 0.21"),
        ("\"FILL_AND_VENT\"", "\"NONE\"\non_supervisor_loss = \"VENT\"", "duplicate key"),
        ("on_supervisor_loss = \"HOLD\"", "on_supervisor_loss = \"VENT\"", ""),
        ("serial = \"tty\"", "serial = \"tty\"\ntcp = \"127.0.0.1:5\"", "exactly one of command"),
        ("serial = \"tty\"\nbaud = 9600", "tcp = \"127.0.0.1\"", "driver.tcp: must be a host and a port"),
        ("whiskers = [\"left/0\"]", "whiskers = []", "names no whisker"),
        ("whiskers = [\"left/0\"]", "whiskers = [\"left\", \"left/0\"]", "\"left/0\" is named twice"),
        ("whiskers = [\"left/0\"]", "whiskers = [\"right/0\"]", "\"right/0\" is no whisker of the robot"),
        (
            "[[arrays]]",
            "[[driver]]\nname = \"board\"\nserial = \"tty2\"\n[[arrays]]",
            "driver.name: driver board occurs twice",
        ),
        ("[[arrays]]", "[[driver]]\nserial = \"tty\"\nbaud = 9600\n[[arrays]]", "has the way of driver board"),
        (
            "[[arrays.whiskers]]",
            "[[arrays.whiskers]]\nwhisker = 1\nlength_mm = 70\npressure_mpa = 0\npressure_max_mpa = 0\n\
             [[arrays.whiskers]]",
            "no driver serves whisker left/1",
        ),
        (
            "[[arrays.whiskers]]",
            "[[arrays.whiskers]]\nwhisker = 0\nlength_mm = 70\npressure_mpa = 0\npressure_max_mpa = 0\n\
             [[arrays.whiskers]]",
            "has two whiskers with one number",
        ),
    ] {
        let text = WHOLE.replacen(from, to, 1);
        assert_ne!(text, WHOLE, "{from}");
        let problem = problem_of(&text);
        if named.is_empty() {
            assert_eq!(problem, None);
            let text = text.replacen("\"FILL_AND_VENT\"", "\"NONE\"", 1);
            assert!(problem_of(&text).unwrap().starts_with("air_control: NONE allows"));
            continue;
        }
        assert!(problem.as_ref().is_some_and(|problem| problem.contains(named)), "{named}: {problem:?}");
    }
}

#[test]
fn regress_each_path_is_relative_to_the_file() {
    let text = EXAMPLE.replacen("command = [\"python3\", \"driver.py\"]", "WAY", 1);
    for (way, expected) in [
        ("serial = \"board\"", Way::Serial("/etc/x/board".into(), 115_200)),
        ("serial = \"/dev/ttyACM0\"", Way::Serial("/dev/ttyACM0".into(), 115_200)),
        ("unix = \"socket\"", Way::Unix("/etc/x/socket".into())),
        ("command = [\"./driver\", \"a\"]", Way::Command(vec!["/etc/x/./driver".into(), "a".into()])),
        ("command = [\"driver\"]", Way::Command(vec!["driver".into()])),
    ] {
        let config = Config::from_toml_str(&text.replacen("WAY", way, 1), Path::new("/etc/x")).unwrap();
        assert_eq!((&config.drivers[0].way, &*config.drivers[0].folder), (&expected, Path::new("/etc/x")));
    }
}
