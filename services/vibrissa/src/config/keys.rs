//! The table of all configuration keys: everything that can be set is listed here, and only here; but for the numbers
//! of the policy, which `vibrissa_core::policy_numbers!` declares.
//!
//! The names follow from the path: `mqtt.ca_file` in the file is `VIBRISSA_MQTT_CA_FILE` in the environment and
//! `--mqtt-ca-file` on the command line.

use std::fmt;
use std::sync::LazyLock;

use vibrissa_core::policy_numbers;

/// Type and range of a value. Its meaning is checked where it is used.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ValueKind {
    /// A text that may be shown.
    Text,
    /// A text that is never shown and is refused on the command line.
    Secret,
    /// A URL whose password is never shown.
    DatabaseUrl,
    /// A file name.
    File,
    /// A list of texts, separated by commas in the environment and in flags.
    Texts,
    /// A list of files, in the same format.
    Files,
    /// A number in a range, both ends included.
    Number {
        /// Lowest allowed value.
        min: f64,
        /// Highest allowed value.
        max: f64,
    },
    /// A whole number in a range, both ends included.
    Whole {
        /// Lowest allowed value.
        min: u32,
        /// Highest allowed value.
        max: u32,
    },
}

impl ValueKind {
    /// Whether it is a list.
    #[must_use]
    pub const fn is_list(self) -> bool {
        matches!(self, Self::Texts | Self::Files)
    }
}

/// One row of the table.
#[derive(Debug, Clone, Copy)]
struct Row {
    path: &'static str,
    kind: ValueKind,
    /// Default in TOML; `None` for a key that is unset by default.
    default: Option<&'static str>,
    help: &'static str,
}

/// Defines the enum and its table together, so that both have the same keys: those before the policy's numbers, the
/// numbers as `policy_numbers!` declares them, and those after.
macro_rules! keys {
    (
        [$($name:ident {
            key: $number:ident, default: $value:tt, min: $min:tt, max: $max:tt, unit: $unit:tt, title: $title:tt,
            doc: $doc:tt,
        })+]
        { $($before:tt)* }
        { $($after:tt)* }
    ) => {
        keys! {
            $($before)*
            $($number: concat!("policy.", stringify!($name)), ValueKind::Number { min: $min, max: $max },
                Some(stringify!($value)), $doc;)+
            $($after)*
        }

        impl Key {
            /// The keys of the policy's numbers, in the order of `PolicyParams::NUMBERS`.
            pub const POLICY_NUMBERS: &[Self] = &[$(Self::$number),+];
        }
    };
    ($($key:ident: $path:expr, $kind:expr, $default:expr, $help:tt;)+) => {
        /// A key of the configuration.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
        pub enum Key {
            $(#[doc = $help] $key,)+
        }

        impl Key {
            /// All keys. Those of a section are adjacent; those without a section come first.
            pub const ALL: &[Self] = &[$(Self::$key),+];

            const fn row(self) -> Row {
                match self {
                    $(Self::$key => Row { path: $path, kind: $kind, default: $default, help: $help },)+
                }
            }
        }
    };
}

policy_numbers! { keys {
    Name: "name", ValueKind::Text, None,
        "Name of this supervisor, for people; default: the host's name";
    Fleets: "fleets", ValueKind::Texts, Some(r#"["fleet"]"#),
        "Fleets to supervise; their topics begin with whisker/v1/FLEET/";
    Calibrations: "calibrations", ValueKind::Files, Some("[]"),
        "Calibration files written by `vibrissa-lab calibrate`";
    Log: "log", ValueKind::Text, Some(r#""info""#),
        "Log filter, such as warn or info,vibrissa=debug; RUST_LOG overrides it";
    Ingest: "ingest", ValueKind::Text, Some(r#""mqtt""#),
        "Where contacts and statuses come from: mqtt, or kafka (see the section [kafka]); all else comes over MQTT";
    Publish: "publish", ValueKind::Text, Some(r#""none""#),
        "Events for other programs: none, or kafka (see the section [kafka])";
    DatabaseUrl: "database.url", ValueKind::DatabaseUrl, Some(r#""sqlite:vibrissa.sqlite3""#),
        "Database: sqlite:FILE, or postgres://USER@HOST:5432/DATABASE to share fleets with other supervisors; \
        postgres://USER@HOST1:5432,HOST2:5432/DATABASE for servers that fail over";
    DatabasePasswordFile: "database.password_file", ValueKind::File, None,
        "File with the password for PostgreSQL";
    DatabaseInstallation: "database.installation", ValueKind::Text, Some(r#""known""#),
        "known, or new: supervise fleets although the MQTT broker retains owners of them that the database does not know";
    LeaseTimeToLiveS: "lease.time_to_live_s", ValueKind::Number { min: 0.5, max: 60.0 }, Some("2.0"),
        "Seconds without renewal after which another supervisor may take over a fleet";
    ContactsKeep: "contacts.keep", ValueKind::Text, Some(r#""all""#),
        "Single contacts to store: all, decisions (those before a detection or decision, and those of compensators) or \
         none; minute and hour aggregates are always stored";
    ContactsDays: "contacts.days", ValueKind::Whole { min: 0, max: 36_500 }, Some("30"),
        "Days after which single contacts are deleted; 0 keeps all";
    ArchiveUrl: "archive.url", ValueKind::Text, None,
        "Archive of all contacts as Parquet files: file:///FOLDER or s3://BUCKET/PREFIX; contacts are deleted from the \
         database only when they are archived; default: no archive";
    ArchiveEveryS: "archive.every_s", ValueKind::Whole { min: 1, max: 86_400 }, Some("600"),
        "Seconds of contacts in a file of the archive; no file has contacts of two days";
    ArchiveS3Endpoint: "archive.s3_endpoint", ValueKind::Text, None,
        "URL of the S3 server, https://HOST; default: that of AWS";
    ArchiveS3Region: "archive.s3_region", ValueKind::Text, None,
        "Region of the bucket; default: AWS_REGION of the environment, or us-east-1";
    ArchiveS3AccessKey: "archive.s3_access_key", ValueKind::Text, None,
        "Identifier of the access key; default: AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY of the environment, or the \
         role of the machine";
    ArchiveS3SecretKeyFile: "archive.s3_secret_key_file", ValueKind::File, None,
        "File with the secret of that access key";
    RollupsMinutesDays: "rollups.minutes_days", ValueKind::Whole { min: 0, max: 36_500 }, Some("400"),
        "Days after which minute aggregates are deleted, 0 keeps all; hour aggregates are always kept";
    BlackBoxSeconds: "black_box.seconds", ValueKind::Whole { min: 0, max: 600 }, Some("60"),
        "Seconds before and after a trim, fault or alarm whose messages a black box of the robot has; 0 for no black boxes";
    BlackBoxMemoryMib: "black_box.memory_mib", ValueKind::Whole { min: 1, max: 65_536 }, Some("256"),
        "Maximum memory for the messages of all robots in MiB; each robot has the same share, at most 1 MiB";
    BlackBoxDays: "black_box.days", ValueKind::Whole { min: 0, max: 36_500 }, Some("90"),
        "Days after which black boxes are deleted, 0 keeps all; each robot keeps its newest 20";
    RecordsDays: "records.days", ValueKind::Whole { min: 0, max: 36_500 }, Some("400"),
        "Days after which finished records are deleted, 0 keeps all: cleared alarms, changes of health, touch tests";
    LimitsRobotsPerFleet: "limits.robots_per_fleet", ValueKind::Whole { min: 1, max: 10_000 }, Some("10000"),
        "Maximum number of robots supervised per fleet; further ones are refused";
    LimitsNewRobotsPerMinute: "limits.new_robots_per_minute", ValueKind::Whole { min: 1, max: 10_000 }, Some("3000"),
        "Maximum number of new robots per fleet and minute; the others are requested again later";
    LimitsRobotsFile: "limits.robots_file", ValueKind::File, None,
        "File of allowed robots, one FLEET/ROBOT per line, read again when it changes; a list set over HTTP adds to it";
    MqttUrl: "mqtt.url", ValueKind::Text, None,
        "External broker, mqtt://HOST:1883 or mqtts://HOST:8883, instead of the embedded one; the nodes of a cluster \
         separated by commas";
    MqttPort: "mqtt.port", ValueKind::Whole { min: 0, max: 65_535 }, Some("1883"),
        "Port of the embedded broker on 127.0.0.1; 0 takes any free port";
    MqttUsername: "mqtt.username", ValueKind::Text, None,
        "User name for the external broker, or of the clients of the embedded one: supervisor, robots and tools";
    MqttPassword: "mqtt.password", ValueKind::Secret, None,
        "Password of that user; better kept in a file. It is refused on the command line, which other users \
         can read";
    MqttPasswordFile: "mqtt.password_file", ValueKind::File, None,
        "File with the password of that user. The embedded broker needs one as soon as HTTP requires a token";
    MqttCaFile: "mqtt.ca_file", ValueKind::File, None,
        "CA certificates (PEM) that may sign the broker's certificate; default: the system's";
    MqttClientCertificateFile: "mqtt.client_certificate_file", ValueKind::File, None,
        "Client certificate (PEM) of this supervisor, for brokers that require one";
    MqttClientKeyFile: "mqtt.client_key_file", ValueKind::File, None,
        "Private key (PEM) of the client certificate";
    MqttDeafReleaseAfterS: "mqtt.deaf_release_after_s", ValueKind::Number { min: 1.0, max: 3600.0 }, Some("10.0"),
        "Seconds without reception of its robots' topics after which a fleet is handed to another supervisor that \
         receives them, if there is one";
    MqttMaintenanceEveryS: "mqtt.maintenance_every_s", ValueKind::Whole { min: 0, max: 86_400 }, Some("0"),
        "Least seconds between two messages with the wear of a robot's whiskers on whisker/v1/FLEET/ROBOT/maintenance, such \
        as 300; 0 for no such messages";
    HttpListen: "http.listen", ValueKind::Text, Some(r#""127.0.0.1:8080""#),
        "Address and port of the HTTP listener; port 0 takes any free port. Beyond loopback a token is required";
    HttpMonitoringListen: "http.monitoring_listen", ValueKind::Text, None,
        "Additional listener for /livez, /readyz and /metrics without a token, such as 127.0.0.1:9464; only monitoring \
         should reach it. Without it, /readyz and /metrics require a token beyond loopback";
    HttpConnectionsMax: "http.connections_max", ValueKind::Whole { min: 16, max: 1_000_000 }, Some("2048"),
        "Maximum number of open connections to http.listen; beyond it, the one that has waited longest for a request \
         is closed. The limit of open files must allow them";
    HttpConnectionsPerAddressMax: "http.connections_per_address_max", ValueKind::Whole { min: 4, max: 1_000_000 },
        Some("512"),
        "The same per address of a connection; behind a proxy all clients have the proxy's address";
    HttpTrustedProxies: "http.trusted_proxies", ValueKind::Texts, Some("[]"),
        "Addresses or networks of proxies, such as 10.1.0.0/16, whose X-Forwarded-For names the client: limits by address \
         then count clients, not the proxy";
    HttpTokenFile: "http.token_file", ValueKind::File, None,
        "File with a token of at least 32 characters that has every right, for programs that set up a supervisor";
    HttpOidcIssuer: "http.oidc_issuer", ValueKind::Text, None,
        "Issuer of an OpenID provider whose tokens are accepted, https://...";
    HttpOidcAudience: "http.oidc_audience", ValueKind::Text, None,
        "Audience that its tokens must name";
    HttpOidcJwksUrl: "http.oidc_jwks_url", ValueKind::Text, None,
        "URL of its keys; default: discovered from the issuer";
    HttpOidcRoleClaim: "http.oidc_role_claim", ValueKind::Text, Some(r#""vibrissa_role""#),
        "Claim with the role: viewer, operator, engineer or admin, or a list with one of them";
    HttpOidcFleetsClaim: "http.oidc_fleets_claim", ValueKind::Text, Some(r#""vibrissa_fleets""#),
        "Claim with the fleets: a list of names and patterns such as hall-*, or * for all";
    HttpOidcClientId: "http.oidc_client_id", ValueKind::Text, None,
        "Identifier of this service at the OpenID provider, for people who sign in at the console; default: no sign-in";
    HttpOidcClientSecretFile: "http.oidc_client_secret_file", ValueKind::File, None,
        "File with the secret of that client; leave it out for a public client";
    HttpOidcScopes: "http.oidc_scopes", ValueKind::Texts, Some(r#"["profile"]"#),
        "Scopes that the sign-in asks for besides openid. Add offline_access for a provider that gives refresh tokens only for \
         it: otherwise a session ends with its first access token";
    HttpPublicUrl: "http.public_url", ValueKind::Text, None,
        "Address at which browsers reach the console, such as https://vibrissa.example, or https://hall.example/vibrissa \
         behind a proxy with a path; needed for the sign-in";
    HttpRunbooksUrl: "http.runbooks_url", ValueKind::Text, None,
        "Address of the runbooks that alarms link to, such as https://wiki.example/runbooks; default: /runbooks of this \
         service";
    KafkaUrl: "kafka.url", ValueKind::Text, None,
        "Brokers of Apache Kafka, kafka://HOST:9092,HOST:9092, or kafkas://HOST:9093 for TLS";
    KafkaUsername: "kafka.username", ValueKind::Text, None,
        "User name for the brokers";
    KafkaPasswordFile: "kafka.password_file", ValueKind::File, None,
        "File with the password for the brokers";
    KafkaSasl: "kafka.sasl", ValueKind::Text, Some(r#""scram-sha-512""#),
        "How the password is proved: scram-sha-512, scram-sha-256 or plain";
    KafkaCaFile: "kafka.ca_file", ValueKind::File, None,
        "CA certificates (PEM) that may sign the brokers' certificates; default: the system's";
    KafkaIngestTopic: "kafka.ingest_topic", ValueKind::Text, Some(r#""vibrissa.messages""#),
        "Topic of contacts and statuses, with any number of partitions; {fleet} stands for the name of the fleet";
    KafkaEventsTopic: "kafka.events_topic", ValueKind::Text, Some(r#""vibrissa.events""#),
        "Topic of trims, decisions, setpoints, errors and alarms";
    KafkaContactsTopic: "kafka.contacts_topic", ValueKind::Text, Some(r#""vibrissa.contacts""#),
        "Topic of contacts";
    KafkaPublishContacts: "kafka.publish_contacts", ValueKind::Text, Some(r#""all""#),
        "Contacts to publish: all or none";
    KafkaWaitingMibMax: "kafka.waiting_mib_max", ValueKind::Whole { min: 1, max: 1_048_576 }, Some("4096"),
        "MiB of a fleet's events that wait for Kafka, in the database; beyond them contacts are left out";
    WebhooksAllowedHosts: "webhooks.allowed_hosts", ValueKind::Texts, Some("[]"),
        "Hosts that webhooks may reach at private addresses, as in their URLs: names such as hooks.lan, or addresses";
    MailUrl: "mail.url", ValueKind::Text, None,
        "Mail server for webhooks whose URL is mailto:NAME@HOST: smtps://HOST for TLS, starttls://HOST for STARTTLS, or \
         smtp://HOST without encryption, each with :PORT if it is not the usual one; default: no mails";
    MailSender: "mail.sender", ValueKind::Text, None,
        "Sender of the mails, such as Vibrissa <vibrissa@example.org>";
    MailUsername: "mail.username", ValueKind::Text, None,
        "User name for the mail server";
    MailPasswordFile: "mail.password_file", ValueKind::File, None,
        "File with the password for the mail server";
    MailGatherS: "mail.gather_s", ValueKind::Whole { min: 0, max: 300 }, Some("60"),
        "Seconds for which the first event of a mail waits for others, which the same mail tells";
    MailPerHourMax: "mail.per_hour_max", ValueKind::Whole { min: 6, max: 3600 }, Some("20"),
        "Most mails per hour to one address, at equal distances; events between two mails are in the next one";
    MetricsSeries: "metrics.series", ValueKind::Text, Some(r#""fleets""#),
        "Detail of the Prometheus metrics: fleets (totals) or whiskers (also each robot and whisker: four series per \
         whisker)";
    TracesOtlpEndpoint: "traces.otlp_endpoint", ValueKind::Text, None,
        "Collector for OpenTelemetry traces, http://HOST:4318 (OTLP as protobuf over HTTP); default: no traces";
    TracesSampleRatio: "traces.sample_ratio", ValueKind::Number { min: 0.0, max: 1.0 }, Some("0.1"),
        "Share of the read-only HTTP requests that are traced; changes and setpoints are always traced";
    ModelFormulation: "model.formulation", ValueKind::Text, Some(r#""published""#),
        "Interpretation of the paper's equations: published (as printed) or consistent (with its Table 2)";
    PolicyMode: "policy.mode", ValueKind::Text, Some(r#""automatic""#),
        "Start of compensations: automatic, or advise (an operator approves each); a policy set over HTTP overrides it";
    PolicyObjective: "policy.objective", ValueKind::Text, Some(r#""shape""#),
        "Objective of the setpoint solver: tip (equal sensitivity at the tip, as in the paper), mean (least mean error \
         over the contact ratios) or shape (air for the shape over the contact ratios, and a gain on the readings for \
         the level: for robots whose factsheet says applies_gain; the others get tip)";
    PolicyLongerForShorter: "policy.longer_for_shorter", ValueKind::Text, Some(r#""last-resort""#),
        "Whether a longer whisker may compensate for a shorter one: never, last-resort or allowed";
} {
    DetectionContactsBetweenFalseAlarms:
        "detection.contacts_between_false_alarms", ValueKind::Number { min: 1e3, max: 1e12 }, Some("1e6"),
        "Mean number of contacts of a healthy whisker between false alarms";
    DetectionColdStartContacts:
        "detection.cold_start_contacts", ValueKind::Whole { min: 20, max: 100_000 }, Some("150"),
        "Number of contacts for learning a whisker's offset and noise, before anything is reported";
    DetectionContactAngleDegMax:
        "detection.contact_angle_deg_max", ValueKind::Number { min: 0.0, max: 60.0 }, Some("0.0"),
        "Largest angle in degrees between a contact's deflection and the plane of the gauge, where contacts state no \
        angle_deg: a change that such a turn explains is no trim and no loss; 0 if contacts keep their direction";
    TouchTestsPerHour: "touch_tests.per_hour", ValueKind::Whole { min: 0, max: 1000 }, Some("30"),
        "Maximum number of touch tests that are requested from a robot per hour, also those of operators; 0 for none";
    TouchTestsInARow: "touch_tests.in_a_row", ValueKind::Whole { min: 1, max: 20 }, Some("3"),
        "Touch tests of a whisker that follow each other without a pause while its length is not decided";
    TouchTestsRetryAfterS: "touch_tests.retry_after_s", ValueKind::Number { min: 1.0, max: 86_400.0 }, Some("600.0"),
        "Seconds until the next touch test after one that failed or was rejected, or after a row that decided nothing";
    TouchTestsContactTimeS: "touch_tests.contact_time_s", ValueKind::Number { min: 0.1, max: 3600.0 }, Some("10.0"),
        "Longest time in seconds that a robot may take for each touch of a test; a test that takes longer expires";
    TouchTestsContactsBetweenSuspicions:
        "touch_tests.contacts_between_suspicions", ValueKind::Number { min: 1e3, max: 1e12 }, Some("1e5"),
        "Mean number of contacts of a sound whisker with steady habits between suspicions of a lost reach, which request \
         a touch test";
    TouchTestsAfterPauseS: "touch_tests.after_pause_s", ValueKind::Number { min: 0.0, max: 31_536_000.0 }, Some("0.0"),
        "Seconds without contacts after which a whisker gets a touch test with its next contact; it gets one after each \
         restart of its robot, too. Only whiskers whose contacts state no ratio; 0 for neither";
    TouchTestsEveryS: "touch_tests.every_s", ValueKind::Number { min: 0.0, max: 31_536_000.0 }, Some("0.0"),
        "Seconds after the last touch test of a whisker until the next one by the schedule. Only whiskers whose contacts \
         state no ratio; 0 for no schedule";
    TouchTestsEveryWithoutPlaceS:
        "touch_tests.every_without_place_s", ValueKind::Number { min: 0.0, max: 31_536_000.0 }, Some("3600.0"),
        "The same where contacts state no place, so that only tests tell the whisker's length, and every_s is 0; 0 for no \
         schedule";
    TouchTestsZeroSdMm: "touch_tests.zero_sd_mm", ValueKind::Number { min: 0.0, max: 20.0 }, Some("1.5"),
        "Standard deviation in mm of the error that all distances of a robot share, until a test of a whole whisker has \
         measured it: before, no test calls a cut within five of them; 0 if the distances are right, without such a test";
} }

/// Environment variable and flag of a key.
struct Names {
    environment: String,
    flag: String,
}

/// Names in the order of [`Key::ALL`].
static NAMES: LazyLock<Vec<Names>> = LazyLock::new(|| {
    let names = |key: &Key| Names {
        environment: format!("{ENVIRONMENT_PREFIX}{}", key.path().replace('.', "_").to_ascii_uppercase()),
        flag: key.path().replace(['.', '_'], "-"),
    };
    Key::ALL.iter().map(names).collect()
});

/// Prefix of all environment variables.
pub const ENVIRONMENT_PREFIX: &str = "VIBRISSA_";

impl Key {
    /// Its path in the file: `mqtt.ca_file`.
    #[must_use]
    pub const fn path(self) -> &'static str {
        self.row().path
    }

    /// Its section and its name there: `mqtt` and `ca_file`.
    #[must_use]
    pub fn section(self) -> (Option<&'static str>, &'static str) {
        self.path().split_once('.').map_or((None, self.path()), |(section, name)| (Some(section), name))
    }

    /// Its environment variable: `VIBRISSA_MQTT_CA_FILE`.
    #[must_use]
    pub fn environment(self) -> &'static str {
        &NAMES[self as usize].environment
    }

    /// Its flag without the dashes: `mqtt-ca-file`. The flag of a secret only names the alternatives.
    #[must_use]
    pub fn flag(self) -> &'static str {
        &NAMES[self as usize].flag
    }

    /// Shorter alias of the flag, if it has one.
    #[must_use]
    pub const fn flag_alias(self) -> Option<&'static str> {
        #[allow(clippy::wildcard_enum_match_arm, reason = "few keys have one")]
        match self {
            Self::Fleets => Some("fleet"),
            Self::MqttUrl => Some("broker"),
            Self::Calibrations => Some("calibration"),
            Self::HttpListen => Some("http"),
            _ => None,
        }
    }

    /// Type and range of its value.
    #[must_use]
    pub const fn kind(self) -> ValueKind {
        self.row().kind
    }

    /// Its default, in TOML.
    #[must_use]
    pub const fn default(self) -> Option<&'static str> {
        self.row().default
    }

    /// Its description, in one line without a full stop.
    #[must_use]
    pub fn help(self) -> &'static str {
        let help = self.row().help;
        help.strip_suffix('.').filter(|start| !start.ends_with('.')).unwrap_or(help)
    }

    /// The key with that path.
    #[must_use]
    pub fn at(path: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|key| key.path() == path)
    }
}

impl fmt::Display for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.path())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_follow_from_the_path() {
        let key = Key::MqttCaFile;
        assert_eq!(
            (key.path(), key.environment(), key.flag()),
            ("mqtt.ca_file", "VIBRISSA_MQTT_CA_FILE", "mqtt-ca-file")
        );
        assert_eq!(Key::at("mqtt.ca_file"), Some(key));
        assert_eq!(Key::LeaseTimeToLiveS.environment(), "VIBRISSA_LEASE_TIME_TO_LIVE_S");
    }

    #[test]
    fn no_two_keys_share_a_name_and_sections_are_together() {
        let mut names: Vec<&str> = Key::ALL.iter().flat_map(|key| [key.environment(), key.flag()]).collect();
        names.extend(Key::ALL.iter().filter_map(|key| key.flag_alias()));
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count);
        let mut sections: Vec<_> = Key::ALL.iter().map(|key| key.section().0).collect();
        sections.dedup();
        assert_eq!(sections.first(), Some(&None));
        let count = sections.len();
        sections.sort_unstable();
        sections.dedup();
        assert_eq!(sections.len(), count, "a section is interrupted");
    }
}
