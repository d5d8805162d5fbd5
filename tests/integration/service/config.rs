//! The configuration from the user's point of view: precedence of sources, origin of values, and problems.

use std::path::Path;
use std::process::Output;

use tempfile::TempDir;
use vibrissa::config::Key;
use vibrissa::config::keys::ValueKind;

use crate::program::PROGRAM;

/// A password that must not appear in any output, warning or error.
const PASSWORD: &str = "hunter2-is-secret";

/// Runs the program in a folder with only these environment variables.
fn vibrissa(folder: &Path, arguments: &[&str], environment: &[(&str, &str)]) -> Output {
    let mut command = assert_cmd::Command::new(PROGRAM);
    command.args(arguments).env_clear().envs(environment.iter().copied()).current_dir(folder).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// Output of `vibrissa config`.
fn shown(folder: &Path, arguments: &[&str], environment: &[(&str, &str)]) -> String {
    let arguments: Vec<&str> = ["config"].iter().chain(arguments).copied().collect();
    let ended = vibrissa(folder, &arguments, environment);
    assert!(ended.status.success(), "{}", text(&ended.stderr));
    assert_eq!(text(&ended.stderr), "");
    text(&ended.stdout)
}

/// Problems reported by `vibrissa config`.
fn refused(folder: &Path, arguments: &[&str], environment: &[(&str, &str)]) -> String {
    let arguments: Vec<&str> = ["config"].iter().chain(arguments).copied().collect();
    let ended = vibrissa(folder, &arguments, environment);
    assert_eq!(ended.status.code(), Some(1), "{}", text(&ended.stdout));
    assert_eq!(text(&ended.stdout), "");
    text(&ended.stderr)
}

/// The line of a key in the output.
fn line(shown: &str, key: Key) -> String {
    let (section, name) = key.section();
    let mut here = None;
    for line in shown.lines() {
        if let Some(opened) = line.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) {
            here = Some(opened.to_owned());
        }
        let is_key = line.trim_start_matches("# ").strip_prefix(name).is_some_and(|rest| rest.starts_with([' ', '=']));
        if here.as_deref() == section && is_key {
            return line.to_owned();
        }
    }
    panic!("{key} is missing:\n{shown}");
}

/// A folder with files to which keys can refer.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for number in 0..3 {
        let calibration = format!(
            "name = \"own-{number}\"\nc = 0.4693\na = 1.6234\nb_per_mpa = 9.3977\n\
             youngs_modulus_mpa = 1.1134\nelongation_gain_mm = 8.6766\n"
        );
        std::fs::write(folder.path().join(format!("calibration{number}.toml")), calibration).unwrap();
        std::fs::write(folder.path().join(format!("file{number}")), format!("{PASSWORD}\n")).unwrap();
        std::fs::write(folder.path().join(format!("token{number}")), "t".repeat(32)).unwrap();
        std::fs::write(folder.path().join(format!("robots{number}")), "vibrissa/crawler\n").unwrap();
    }
    folder
}

/// Three valid values of a key other than its default, as written in the environment.
fn values(key: Key) -> [&'static str; 3] {
    match key {
        Key::Name => ["one", "two", "three"],
        Key::Fleets => ["a", "b", "c"],
        Key::Calibrations => ["calibration0.toml", "calibration1.toml", "calibration2.toml"],
        Key::Log => ["error", "warn", "debug"],
        Key::DatabaseUrl => ["postgres://u@h0/d", "postgres://u@h1/d", "postgres://u@h2/d"],
        Key::DatabaseInstallation => ["new", "known", "new"],
        Key::LeaseTimeToLiveS => ["3.5", "4.5", "5.5"],
        Key::ContactsKeep => ["decisions", "none", "all"],
        Key::ContactsDays | Key::RollupsMinutesDays => ["0", "7", "90"],
        Key::ArchiveUrl => ["file:///a0", "s3://b1", "s3://b2/prefix"],
        Key::ArchiveS3Endpoint => ["https://s0.example", "http://127.0.0.1:9000", "https://s2.example"],
        Key::ArchiveS3Region | Key::ArchiveS3AccessKey => ["a-0", "a-1", "a-2"],
        Key::ArchiveS3SecretKeyFile => ["file0", "file1", "file2"],
        Key::ArchiveEveryS => ["5", "50", "500"],
        Key::BlackBoxSeconds | Key::BlackBoxMemoryMib | Key::BlackBoxDays => ["5", "50", "500"],
        Key::LimitsRobotsPerFleet | Key::LimitsNewRobotsPerMinute => ["5", "50", "500"],
        Key::LimitsRobotsFile => ["robots0", "robots1", "robots2"],
        Key::MqttDeafReleaseAfterS => ["3.5", "4.5", "5.5"],
        Key::HttpMonitoringListen => ["127.0.0.1:84", "127.0.0.1:85", "[::1]:86"],
        Key::HttpConnectionsMax | Key::HttpConnectionsPerAddressMax => ["100", "200", "300"],
        Key::MqttUrl => ["mqtts://h0:8883", "mqtts://h1:8884", "mqtts://h2"],
        Key::MqttPort => ["1884", "1885", "1886"],
        Key::MqttUsername | Key::MqttPassword => ["user-0", "user-1", "user-2"],
        Key::DatabasePasswordFile
        | Key::HttpOidcClientSecretFile
        | Key::MqttPasswordFile
        | Key::MqttCaFile
        | Key::MqttClientCertificateFile
        | Key::MqttClientKeyFile => ["file0", "file1", "file2"],
        Key::Publish | Key::Ingest => ["kafka", "kafka", "kafka"],
        Key::KafkaUrl => ["kafka://h0:9092", "kafkas://h1:9093,h2:9093", "kafka://[::1]:1"],
        Key::KafkaUsername => ["user-0", "user-1", "user-2"],
        Key::KafkaPasswordFile | Key::KafkaCaFile => ["file0", "file1", "file2"],
        Key::KafkaSasl => ["plain", "scram-sha-256", "plain"],
        Key::KafkaIngestTopic | Key::KafkaEventsTopic | Key::KafkaContactsTopic => ["t0", "t1", "t2"],
        Key::KafkaPublishContacts => ["none", "all", "none"],
        Key::KafkaWaitingMibMax | Key::RecordsDays => ["5", "50", "500"],
        Key::HttpListen => ["127.0.0.1:81", "127.0.0.1:82", "[::1]:83"],
        Key::HttpTokenFile => ["token0", "token1", "token2"],
        Key::HttpOidcIssuer | Key::HttpOidcJwksUrl => ["https://i0.example", "https://i1.example", "http://[::1]:9"],
        Key::HttpRunbooksUrl => ["https://wiki.example/r0", "http://wiki.example/r1", "http://[::1]:9/r2"],
        Key::HttpOidcAudience
        | Key::HttpOidcClientId
        | Key::HttpOidcRoleClaim
        | Key::HttpOidcFleetsClaim
        | Key::HttpOidcScopes => ["c0", "c1", "c2"],
        Key::HttpPublicUrl => ["https://c0.example", "https://c1.example:8443", "http://127.0.0.1:8080"],
        Key::HttpTrustedProxies => ["10.1.0.0/16", "127.0.0.1", "::1"],
        Key::WebhooksAllowedHosts => ["hooks.lan", "10.0.0.7", "::1"],
        Key::MailUrl => ["smtps://h0", "starttls://h1:2587", "smtp://[::1]:2525"],
        Key::MailSender => ["a@h0.example", "Vibrissa <a@h1.example>", "b@h2.example"],
        Key::MailUsername => ["user-0", "user-1", "user-2"],
        Key::MailPasswordFile => ["file0", "file1", "file2"],
        Key::MailGatherS | Key::MailPerHourMax => ["7", "70", "250"],
        Key::MqttMaintenanceEveryS => ["60", "600", "3600"],
        Key::TracesOtlpEndpoint => ["http://h0:4318", "https://h1/otlp", "http://[::1]:4318"],
        Key::TracesSampleRatio => ["0.0", "0.5", "1.0"],
        Key::PolicyMode => ["advise", "automatic", "advise"],
        Key::MetricsSeries => ["whiskers", "fleets", "whiskers"],
        Key::ModelFormulation => ["consistent", "published", "consistent"],
        Key::PolicyObjective => ["mean", "tip", "mean"],
        Key::PolicyLongerForShorter => ["never", "allowed", "last-resort"],
        Key::DetectionContactsBetweenFalseAlarms => ["10000.0", "100000.0", "10000000.0"],
        Key::DetectionColdStartContacts => ["20", "30", "40"],
        Key::TouchTestsPerHour | Key::TouchTestsInARow => ["5", "10", "15"],
        Key::TouchTestsRetryAfterS
        | Key::TouchTestsContactTimeS
        | Key::TouchTestsAfterPauseS
        | Key::TouchTestsEveryS
        | Key::TouchTestsEveryWithoutPlaceS => ["1.5", "60.0", "3600.0"],
        Key::DetectionContactAngleDegMax => ["0.0", "20.0", "60.0"],
        Key::TouchTestsZeroSdMm => ["0.0", "0.5", "3.0"],
        Key::TouchTestsContactsBetweenSuspicions => ["10000.0", "1000000.0", "10000000.0"],
        key if Key::POLICY_NUMBERS.contains(&key) => ["0.125", "0.75", "1.5"],
        key => panic!("{key} needs values"),
    }
}

/// Further flags that the key requires.
fn companions(key: Key) -> &'static [&'static str] {
    match key {
        Key::DatabasePasswordFile => &["--database-url=postgres://u@h/d"],
        Key::MqttUsername => &["--mqtt-url=mqtt://h", "--mqtt-password-file=file0"],
        Key::MqttPassword | Key::MqttPasswordFile => &["--mqtt-url=mqtt://h", "--mqtt-username=u"],
        Key::MqttCaFile => &["--mqtt-url=mqtts://h"],
        Key::MqttClientCertificateFile => &["--mqtt-url=mqtts://h", "--mqtt-client-key-file=file0"],
        Key::MqttClientKeyFile => &["--mqtt-url=mqtts://h", "--mqtt-client-certificate-file=file0"],
        Key::Publish | Key::Ingest => &["--kafka-url=kafka://h:9092"],
        Key::KafkaUrl => &["--publish=kafka"],
        Key::KafkaIngestTopic => &["--ingest=kafka", "--kafka-url=kafka://h:9092"],
        Key::KafkaUsername => &["--publish=kafka", "--kafka-url=kafka://h:9092", "--kafka-password-file=file0"],
        Key::KafkaPasswordFile => &["--publish=kafka", "--kafka-url=kafka://h:9092", "--kafka-username=u"],
        Key::KafkaCaFile => &["--publish=kafka", "--kafka-url=kafkas://h:9093"],
        Key::KafkaSasl
        | Key::KafkaEventsTopic
        | Key::KafkaContactsTopic
        | Key::KafkaPublishContacts
        | Key::KafkaWaitingMibMax => &["--publish=kafka", "--kafka-url=kafka://h:9092"],
        Key::MailUrl => &["--mail-sender=a@h.example"],
        Key::MailSender => &["--mail-url=smtps://h"],
        Key::MailUsername => &["--mail-url=smtps://h", "--mail-sender=a@h.example", "--mail-password-file=file0"],
        Key::MailPasswordFile => &["--mail-url=smtps://h", "--mail-sender=a@h.example", "--mail-username=u"],
        Key::HttpOidcIssuer => &["--http-oidc-audience=a"],
        Key::HttpOidcAudience => &["--http-oidc-issuer=https://i.example"],
        Key::HttpOidcClientId => {
            &["--http-oidc-issuer=https://i.example", "--http-oidc-audience=a", "--http-public-url=https://c.example"]
        }
        Key::HttpOidcClientSecretFile => &[
            "--http-oidc-issuer=https://i.example",
            "--http-oidc-audience=a",
            "--http-public-url=https://c.example",
            "--http-oidc-client-id=c",
        ],
        Key::HttpOidcJwksUrl | Key::HttpOidcRoleClaim | Key::HttpOidcFleetsClaim => {
            &["--http-oidc-issuer=https://i.example", "--http-oidc-audience=a"]
        }
        _ => &[],
    }
}

/// A value in TOML.
fn toml(key: Key, value: &str) -> String {
    match key.kind() {
        ValueKind::Number { .. } | ValueKind::Whole { .. } => value.to_owned(),
        ValueKind::Texts | ValueKind::Files => format!("[{value:?}]"),
        ValueKind::Text | ValueKind::Secret | ValueKind::DatabaseUrl | ValueKind::File => format!("{value:?}"),
    }
}

#[test]
fn for_every_key_flags_win_over_the_environment_over_the_file_over_the_default() {
    let folder = folder();
    for &key in Key::ALL {
        let [in_file, in_environment, in_flag] = values(key);
        std::fs::write(folder.path().join("v.toml"), format!("{key} = {}\n", toml(key, in_file))).unwrap();
        let flag = format!("--{}={in_flag}", key.flag());
        let (variable, file) = ([(key.environment(), in_environment)], ["--config", "v.toml"]);
        let holds = |flags: &[&str], variables: &[(&str, &str)], value: &str, from: &str| {
            let shown = shown(folder.path(), &[&file[..], flags, companions(key)].concat(), variables);
            let expected = match key.kind() {
                ValueKind::Secret => format!("# {} = \"***\"  # {from}", key.section().1),
                _ => format!("{} = {}  # {from}", key.section().1, toml(key, value)),
            };
            assert_eq!(line(&shown, key), expected);
        };
        holds(&[], &[], in_file, "file v.toml");
        holds(&[], &variable, in_environment, &format!("environment {}", key.environment()));
        if key.kind() == ValueKind::Secret {
            let said = refused(folder.path(), &[&file[..], &[&flag], companions(key)].concat(), &variable);
            assert!(said.contains("is refused on the command line") && !said.contains(in_flag), "{said}");
        } else {
            holds(&[&flag], &variable, in_flag, &format!("flag --{}", key.flag()));
        }
    }
}

#[test]
fn what_nobody_has_set_is_the_default_or_a_comment() {
    let folder = folder();
    let shown = shown(folder.path(), &[], &[]);
    for &key in Key::ALL {
        let line = line(&shown, key);
        match key.default() {
            Some(_) => assert!(line.ends_with("  # default") && !line.starts_with('#'), "{line}"),
            None if key == Key::Name => assert!(line.ends_with("  # default"), "{line}"),
            None => assert_eq!(line, format!("# {} is not set", key.section().1)),
        }
    }
}

#[test]
fn what_is_shown_is_a_file_that_gives_the_same() {
    let folder = folder();
    let flags = [
        "--fleets=a,b",
        "--fleet=c",
        "--calibration=calibration0.toml",
        "--calibration=calibration1.toml",
        "--database-url=postgres://u@h/d",
        "--database-password-file=file0",
        "--mqtt-url=mqtts://h",
        "--mqtt-username=u",
        "--mqtt-password-file=file1",
        "--mqtt-ca-file=file2",
        "--mqtt-client-certificate-file=file0",
        "--mqtt-client-key-file=file1",
        "--http=127.0.0.1:0",
        "--detection-contacts-between-false-alarms=1e12",
        "--name=a \"b\" \\ c # d",
    ];
    for flags in [&flags[..], &[]] {
        let first = shown(folder.path(), flags, &[]);
        std::fs::write(folder.path().join("again.toml"), &first).unwrap();
        let again = shown(folder.path(), &["--config", "again.toml"], &[]);
        let values = |shown: &str| -> Vec<String> {
            shown.lines().map(|line| line.rsplit_once("  # ").map_or(line, |(value, _)| value).to_owned()).collect()
        };
        assert_eq!(values(&first), values(&again));
        assert!(again.lines().filter(|line| line.contains(" = ")).all(|line| line.ends_with("  # file again.toml")));
    }
}

#[test]
fn all_problems_are_told_at_once_with_where_each_came_from() {
    let folder = folder();
    std::fs::write(folder.path().join("v.toml"), "naem = 1\n[lease]\ntime_to_live_s = 0.1\n").unwrap();
    let said = refused(
        folder.path(),
        &["--config", "v.toml", "--fleets", "a,a", "--detection-cold-start-contacts", "-1"],
        &[("VIBRISSA_HTTP_LISTEN", "here"), ("VIBRISSA_MQTT_CA_FILE", "/nowhere/ca.pem")],
    );
    let lines: Vec<&str> = said.lines().collect();
    assert_eq!(lines[0], "vibrissa: the configuration has 7 problems:", "{said}");
    for expected in [
        "  naem (file v.toml): no such key; did you mean name?",
        "  fleets (flag --fleets): names the fleet a twice",
        "  lease.time_to_live_s (file v.toml): must be from 0.5 to 60.0, not 0.1",
        "  http.listen (environment VIBRISSA_HTTP_LISTEN): must be an address and a port",
        "  mqtt.ca_file (environment VIBRISSA_MQTT_CA_FILE): the file /nowhere/ca.pem cannot be read",
        "  mqtt.ca_file (environment VIBRISSA_MQTT_CA_FILE): has no effect without mqtt.url",
        "  detection.cold_start_contacts (flag --detection-cold-start-contacts): must be a whole number from 20",
    ] {
        assert_eq!(lines.iter().filter(|line| line.starts_with(expected)).count(), 1, "{expected}\n{said}");
    }
    assert_eq!(lines.len(), 8, "{said}");
}

#[test]
fn the_service_is_told_the_same_and_does_not_start() {
    let folder = folder();
    let ended = vibrissa(folder.path(), &["run", "--mqtt-url", "h:1883", "--mqtt-port", "1883"], &[]);
    let said = text(&ended.stderr);
    assert_eq!(ended.status.code(), Some(1));
    assert!(said.starts_with("vibrissa: the configuration has 2 problems:\n  mqtt.url (flag --mqtt-url): "), "{said}");
    assert!(!folder.path().join("vibrissa.sqlite3").exists(), "the database must not be opened");
}

#[test]
fn one_problem_is_one_line() {
    let folder = folder();
    for (arguments, expected) in [
        (&["--mqtt-port", "x"][..], "vibrissa: mqtt.port (flag --mqtt-port): must be a whole number"),
        (&["--config", "nowhere.toml"], "vibrissa: file nowhere.toml: the configuration file cannot be read"),
        (&["--lease-time-to-live-s=-1"], "vibrissa: lease.time_to_live_s (flag --lease-time-to-live-s): must be from"),
        (&["--calibration=file0"], "vibrissa: calibrations (flag --calibrations): calibration file file0"),
    ] {
        let said = refused(folder.path(), arguments, &[]);
        assert!(said.starts_with(expected) && said.lines().count() == 1, "{said}");
    }
}

#[test]
fn variables_that_nobody_knows_warn_and_do_not_stop() {
    let folder = folder();
    let environment = [("VIBRISSA_FLEET", "a"), ("VIBRISSA_CONFIG", "v.toml"), ("VIBRISSA_TEST_FAULT", "")];
    std::fs::write(folder.path().join("v.toml"), "name = \"from the file\"\n").unwrap();
    let ended = vibrissa(folder.path(), &["config"], &environment);
    assert!(ended.status.success());
    let said = text(&ended.stderr);
    let expected =
        "vibrissa: the environment variable VIBRISSA_FLEET is unknown and ignored; did you mean VIBRISSA_FLEETS?";
    assert_eq!(said.trim_end(), expected);
    assert!(text(&ended.stdout).contains("name = \"from the file\"  # file v.toml"));
}

#[test]
fn that_rust_log_wins_is_shown() {
    let folder = folder();
    let shown = shown(folder.path(), &[], &[("RUST_LOG", "trace")]);
    assert!(shown.contains("log = \"info\"  # default\n# RUST_LOG overrides it: trace\n"), "{shown}");
}

#[test]
fn no_password_is_ever_printed() {
    let folder = folder();
    let file = |text: &str| std::fs::write(folder.path().join("v.toml"), text.replace("SECRET", PASSWORD)).unwrap();
    let said = |arguments: &[&str], environment: &[(&str, &str)]| {
        let ended = vibrissa(folder.path(), &[&["config"], arguments].concat(), environment);
        let said = text(&ended.stdout) + &text(&ended.stderr);
        assert!(!said.contains(PASSWORD), "{said}");
        (ended.status.success(), said)
    };
    for (toml, is_good) in [
        ("[mqtt]\nurl = \"mqtt://h\"\nusername = \"u\"\npassword = \"SECRET\"", true),
        ("database.url = \"postgres://u:SECRET@h/d\"", true),
        ("database.url = \"postgres://u@h/d?password=SECRET\"", true),
        ("database.url = \"postgres://u:SECRET@h\"", false),
        ("database.url = \"mysql://u:SECRET@h/d\"", false),
        ("database.url = \"u:SECRET@h/d\"", false),
        ("database.url = \"postgres://u:SECRET@h:x/d\"", false),
        ("database.url = \"postgres://u:SECRET@h/d?sslmode=SECRET\"", false),
        ("database.url = \"postgres://u:SECRET@h/d\"\ndatabase.password_file = \"file0\"", false),
        ("mqtt.url = \"mqtt://u:SECRET@h\"", false),
        ("mqtt.url = \"u:SECRET@h\"", false),
        ("mqtt.url = \"mqtt://h/SECRET\"", false),
        ("mqtt.password = \"SECRET\"", false),
        ("mqtt.password = [\"SECRET\"]", false),
        ("mqtt.password = { is = \"SECRET\" }", false),
        ("mqtt.pasword = \"SECRET\"", false),
        ("mqtt.password = SECRET", false),
        ("mqtt.password = \"SECRET", false),
        ("mqtt.password = \"SECRET\" x", false),
        ("mqtt.password = 'SECRET\n'", false),
        ("calibrations = [\"file0\"]", false),
        ("mqtt.url = \"mqtt://h\"\nmqtt.username = \"u\"\nmqtt.password_file = \"file0\"", true),
    ] {
        file(toml);
        assert_eq!(said(&["--config", "v.toml"], &[]).0, is_good, "{toml}");
    }
    // The password file used as a configuration file.
    assert!(!said(&["--config", "file0"], &[]).0);
    let in_environment = [("VIBRISSA_MQTT_PASSWORD", PASSWORD)];
    let (is_good, shown) = said(&["--mqtt-url=mqtt://h", "--mqtt-username=u"], &in_environment);
    assert!(is_good && shown.contains("# password = \"***\"  # environment VIBRISSA_MQTT_PASSWORD"), "{shown}");
    let secret = format!("--mqtt-password={PASSWORD}");
    assert!(!said(&["--mqtt-url=mqtt://h", "--mqtt-username=u", &secret], &[]).0);
    let misspelt = format!("--mqtt-pasword={PASSWORD}");
    assert!(!said(&[&misspelt], &[]).0);
    let url = format!("postgres://vibrissa:{PASSWORD}@db/vibrissa");
    let (_, shown) = said(&[], &[("VIBRISSA_DATABASE_URL", &url), ("VIBRISSA_DATABSE_URL", &url)]);
    let expected = "url = \"postgres://vibrissa:***@db/vibrissa\"  # environment VIBRISSA_DATABASE_URL\n";
    assert!(shown.contains(expected), "{shown}");
}

#[test]
fn a_password_file_is_one_line() {
    let folder = folder();
    let flags = ["--mqtt-url=mqtt://h", "--mqtt-username=u", "--mqtt-password-file=p"];
    for (content, is_good) in
        [("p", true), ("p\n", true), ("p\r\n", true), (" p \n", true), ("", false), ("\n", false), ("p\nq\n", false)]
    {
        std::fs::write(folder.path().join("p"), content).unwrap();
        let ended = vibrissa(folder.path(), &[&["config"], &flags[..]].concat(), &[]);
        assert_eq!(ended.status.success(), is_good, "{content:?}: {}", text(&ended.stderr));
    }
    std::fs::write(folder.path().join("p"), "x".repeat(5000)).unwrap();
    assert!(refused(folder.path(), &flags, &[]).contains("longer than 4096 bytes"));
}
