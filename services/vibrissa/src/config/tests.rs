use super::layers::FILE_MAX_BYTES;
use super::*;
use vibrissa_core::units::Micros;

fn from_file(text: &str) -> Sources {
    Sources { file: Some(("v.toml".into(), text.to_owned())), ..Sources::default() }
}

fn from_environment(variables: &[(&str, &str)]) -> Sources {
    let environment = variables.iter().map(|&(name, text)| (name.to_owned(), text.to_owned())).collect();
    Sources { environment, ..Sources::default() }
}

/// All problems, one line each.
fn wrong(sources: &Sources) -> Vec<String> {
    match read(sources).config {
        Ok(config) => panic!("no problem in {config:?}"),
        Err(problems) => problems.0.iter().map(ToString::to_string).collect(),
    }
}

fn one_wrong(sources: &Sources) -> String {
    let mut lines = wrong(sources);
    assert_eq!(lines.len(), 1, "{lines:#?}");
    lines.remove(0)
}

#[test]
fn the_defaults_are_a_good_configuration() {
    let reading = read(&Sources::default());
    let config = reading.config.unwrap();
    assert!(reading.warnings.is_empty());
    assert_eq!(config.fleets, [Name::new("fleet").unwrap()]);
    assert_eq!(config.database.to_string(), "sqlite:vibrissa.sqlite3");
    assert_eq!((config.mqtt_port, config.broker), (1883, None));
    assert_eq!(config.lease_time_to_live, Duration::from_secs(2));
    let core = Params::nguyen_2021(Formulation::default());
    assert!(config.access.token.is_none() && config.access.oidc.is_none());
    assert_eq!(config.traces, None);
    assert_eq!(config.history, HistoryOptions::default());
    assert_eq!(config.policy, core.policy);
    assert_eq!(config.contacts_between_false_alarms, core.detection.contacts_between_false_alarms);
    assert_eq!(config.cold_start_contacts, core.detection.cold_start_contacts);
    assert_eq!(config.contact_angle_deg_max, core.detection.contact_angle_deg_max);
    assert_eq!(config.touch_tests, core.touch_tests);
}

#[test]
fn the_angle_of_contacts_reaches_the_core() {
    let detection = read(&from_file("detection.contact_angle_deg_max = 25")).config.unwrap().params().detection;
    assert_eq!(detection.contact_angle_deg_max, 25.0);
    let line = one_wrong(&from_file("detection.contact_angle_deg_max = 61"));
    assert!(line.contains("must be from 0.0 to 60.0, not 61.0"), "{line}");
}

#[test]
fn limits_of_touch_tests_reach_the_core() {
    let text = "[touch_tests]\nper_hour = 6\nin_a_row = 2\nretry_after_s = 60\ncontact_time_s = 2.5\n\
                contacts_between_suspicions = 2e5\nafter_pause_s = 3600\nevery_s = 86400\nzero_sd_mm = 0.8\n";
    let limits = read(&from_file(text)).config.unwrap().params().touch_tests;
    assert_eq!((limits.per_hour, limits.in_a_row, limits.pause), (6, 2, Micros::from_s(60.0)));
    assert_eq!((limits.contact_time, limits.contacts_between_false_alarms), (Micros::from_s(2.5), 2e5));
    assert_eq!((limits.after_pause, limits.every), (Micros::from_s(3600.0), Micros::from_s(86_400.0)));
    assert_eq!(limits.zero_sd_mm, 0.8);
    let line = one_wrong(&from_file("touch_tests.in_a_row = 0"));
    assert!(line.contains("must be a whole number from 1 to 20, not 0"), "{line}");
}

#[cfg(feature = "archive")]
#[test]
fn an_archive_needs_all_contacts_in_the_database() {
    let line = one_wrong(&from_file("contacts.keep = \"none\"\n[archive]\nurl = \"file:///srv/a\"\n"));
    assert!(line.contains("archive.url") && line.contains("contacts.keep = \"all\""), "{line}");
}

#[test]
fn every_key_is_shown_and_has_a_default_or_none_by_intent() {
    let shown = show::effective(&Sources::default(), None);
    for key in Key::ALL {
        assert!(shown.contains(&format!("{} ", key.section().1)), "{key}");
        let is_optional = matches!(key, Key::Name | Key::MqttUrl | Key::HttpMonitoringListen | Key::HttpRunbooksUrl)
            || key.path().contains("_file");
        let is_credential =
            matches!(key, Key::MqttUsername | Key::MqttPassword | Key::KafkaUsername | Key::MailUsername);
        let is_engine = matches!(
            key,
            Key::KafkaUrl | Key::ArchiveUrl | Key::ArchiveS3Endpoint | Key::ArchiveS3Region | Key::ArchiveS3AccessKey
        );
        let is_provider = matches!(
            key,
            Key::HttpOidcIssuer
                | Key::HttpOidcAudience
                | Key::HttpOidcJwksUrl
                | Key::HttpOidcClientId
                | Key::HttpPublicUrl
        );
        let is_collector = matches!(key, Key::TracesOtlpEndpoint | Key::MailUrl | Key::MailSender);
        let is_unset = is_optional || is_credential || is_engine || is_provider || is_collector;
        assert_eq!(key.default().is_none(), is_unset, "{key}");
    }
}

#[test]
fn a_wrong_type_is_told_with_an_example() {
    for (text, expected) in [
        ("name = 5", "name (file v.toml): must be a text, such as name = \"...\", but is a number"),
        ("name = 1979-05-27", "but is a date or time"),
        ("fleets = \"lab\"", "such as fleets = [\"a\", \"b\"], but is a text"),
        ("fleets = [1]", "but is a list with something else"),
        ("mqtt.port = 1883.0", "must be a whole number, such as port = 10, but is a number"),
        ("mqtt.port = 65536", "must be a whole number from 0 to 65535, not 65536"),
        ("mqtt.port = -1", "not -1"),
        ("lease.time_to_live_s = true", "but is true or false"),
        ("lease.time_to_live_s = 0.4", "must be from 0.5 to 60.0, not 0.4"),
        ("lease.time_to_live_s = nan", "not NaN"),
        ("lease.time_to_live_s = inf", "not inf"),
        ("policy.objective = \"best\"", "must be tip or mean or shape, not \"best\""),
        ("http.listen = \"8080\"", "must be an address and a port such as 127.0.0.1:8080"),
        ("http.monitoring_listen = \"9464\"", "must be an address and a port such as 127.0.0.1:9464"),
        ("http.monitoring_listen = \"127.0.0.1:8080\"", "must be another address or port than http.listen"),
        ("http.connections_max = 0", "must be a whole number from 16 to 1000000, not 0"),
        ("log = \"vibrissa=loud\"", "\"loud\" in \"vibrissa=loud\" is not a level"),
        ("fleets = []", "at least one"),
        ("fleets = [\"a\", \"a\"]", "twice"),
        ("fleets = [\"a b\"]", "is not a valid name"),
        ("name = \"\"", "must not be empty"),
        ("traces.otlp_endpoint = \"h:4318\"", "must begin with http:// or https://: write http://HOST:4318"),
        ("traces.sample_ratio = 1.5", "must be from 0.0 to 1.0, not 1.5"),
        ("calibrations = [\"nowhere.toml\"]", "nowhere.toml cannot be read"),
    ] {
        let line = one_wrong(&from_file(text));
        assert!(line.contains(expected) && line.contains("(file v.toml)"), "{text}: {line}");
    }
    let line = one_wrong(&from_environment(&[("VIBRISSA_MQTT_PORT", "x")]));
    assert_eq!(line, "mqtt.port (environment VIBRISSA_MQTT_PORT): must be a whole number, such as 10, not \"x\"");
    let line = one_wrong(&from_environment(&[("VIBRISSA_MQTT_PORT", "tcp://10.0.0.1:1883")]));
    assert!(line.contains("enableServiceLinks"), "{line}");
}

#[test]
fn a_whole_number_is_a_number_too() {
    assert_eq!(read(&from_file("lease.time_to_live_s = 3")).config.unwrap().lease_time_to_live.as_secs(), 3);
}

#[test]
fn what_does_not_go_together_is_told_at_the_key_that_is_too_many() {
    let exists = env!("CARGO_MANIFEST_PATH");
    for (text, key) in [
        ("mqtt.url = \"mqtt://h\"\nmqtt.port = 1883", "mqtt.port"),
        ("mqtt.url = \"mqtt://h\"\nmqtt.username = \"u\"", "mqtt.username"),
        ("mqtt.url = \"mqtt://h\"\nmqtt.password = \"p\"", "mqtt.password"),
        ("mqtt.url = \"mqtt://h\"\nmqtt.ca_file = FILE", "mqtt.ca_file"),
        ("mqtt.url = \"mqtts://h\"\nmqtt.client_key_file = FILE", "mqtt.client_key_file"),
        ("mqtt.url = \"mqtts://h\"\nmqtt.client_certificate_file = FILE", "mqtt.client_certificate_file"),
        ("mqtt.url = \"mqtts://h\"\nmqtt.ca_file = \"/nowhere\"", "mqtt.ca_file"),
        ("mqtt.url = \"mqtts://h\"\nmqtt.ca_file = \"/\"", "mqtt.ca_file"),
        ("mqtt.ca_file = FILE", "mqtt.ca_file"),
    ] {
        let lines = wrong(&from_file(&text.replace("FILE", &format!("{exists:?}"))));
        assert!(lines.iter().any(|line| line.starts_with(&format!("{key} (file v.toml): "))), "{text}: {lines:#?}");
    }
}

#[test]
fn user_and_password_without_an_external_broker_are_those_of_the_embedded_one() {
    let config = read(&from_file("mqtt.username = \"u\"\nmqtt.password = \"p\"")).config.unwrap();
    assert_eq!(config.broker, None);
    assert_eq!(config.mqtt_credentials.map(|one| one.username).as_deref(), Some("u"));
}

#[test]
fn an_unknown_key_is_told_with_the_nearest_one() {
    let line = one_wrong(&from_file("[mqtt]\nca_fil = \"x\""));
    assert_eq!(line, "mqtt.ca_fil (file v.toml): no such key; did you mean mqtt.ca_file?");
    let line = one_wrong(&from_file("[databse]\nurl = \"sqlite:x\""));
    assert!(line.contains("no such section; did you mean database?"), "{line}");
    assert!(one_wrong(&from_file("mqtt = 5")).contains("[mqtt]"));
    assert!(!one_wrong(&from_file("zzz = 5")).contains("did you mean"));
    for text in ["[fleet]\nshards = 4", "fleet.shards = 1"] {
        let line = one_wrong(&from_file(text));
        assert!(line.starts_with("fleet.shards (file v.toml): a fleet has one owner"), "{line}");
        assert!(line.contains("several fleets"), "{line}");
    }
}

#[test]
fn a_file_that_is_no_toml_is_told_by_its_line_which_is_not_shown() {
    for text in ["[mqtt]\npassword = \"hunter2", "[mqtt]\npassword = hunter2", "a = 1\npassword \"hunter2\""] {
        let line = one_wrong(&from_file(text));
        assert!(line.starts_with("file v.toml: line 2: ") && !line.contains("hunter2"), "{line}");
    }
    let line = one_wrong(&from_file(&"#".repeat(FILE_MAX_BYTES + 1)));
    assert!(line.contains("larger than 64 KiB"), "{line}");
}

#[test]
fn the_mask_is_no_password() {
    let text =
        "database.url = \"postgres://u:***@h/d\"\n[mqtt]\nurl = \"mqtt://h\"\nusername = \"u\"\npassword = \"***\"";
    let lines = wrong(&from_file(text));
    assert_eq!(lines.len(), 2, "{lines:#?}");
    assert!(lines.iter().all(|line| line.contains("hidden password")), "{lines:#?}");
}

#[test]
fn variables_that_nobody_knows_only_warn() {
    let reading = read(&from_environment(&[
        ("VIBRISSA_DATABASE_URI", "x"),
        ("VIBRISSA_SERVICE_HOST", "10.0.0.1"),
        ("VIBRISSA_CONFIG", "x"),
        ("VIBRISSA_SCENARIO", "x"),
        ("OTHER", "x"),
        ("VIBRISSA_MQTT_URL", ""),
    ]));
    assert!(reading.config.is_ok());
    assert_eq!(reading.warnings.len(), 2, "{:?}", reading.warnings);
    assert!(reading.warnings[0].ends_with("; did you mean VIBRISSA_DATABASE_URL?"), "{:?}", reading.warnings);
}

#[test]
fn everything_is_told_at_once_and_one_problem_is_one_line() {
    let problems = read(&from_file("name = 5\nmqtt.port = -1\nnonsense = 1")).config.unwrap_err();
    let text = problems.to_string();
    assert!(text.starts_with("the configuration has 3 problems:\n  "), "{text}");
    assert_eq!(text.lines().count(), 4);
    let one = read(&from_file("\"a\\nb\" = 5")).config.unwrap_err().to_string();
    assert_eq!(one.lines().count(), 1, "{one}");
}

#[test]
fn the_example_uncommented_is_the_defaults() {
    // An unset key has no value, so its line stays a comment.
    let example = show::example();
    let lines = example.lines().map(|line| match line.strip_prefix('#') {
        Some(setting) if !setting.starts_with(' ') && !setting.ends_with("\"\"") => setting.to_owned(),
        _ => line.to_owned(),
    });
    let text = lines.collect::<Vec<_>>().join("\n");
    let [written, built_in] = [from_file(&text), Sources::default()].map(|sources| read(&sources).config.unwrap());
    assert_eq!(format!("{written:?}"), format!("{built_in:?}"));
    for key in Key::ALL.iter().filter(|key| key.default().is_some()) {
        let layers = Layers::new(&from_file(&text));
        let (value, origin) = layers.find(*key);
        assert!(value.is_some() && origin.is_explicit(), "{key} is missing in the example");
    }
}
