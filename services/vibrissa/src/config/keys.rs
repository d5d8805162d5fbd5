//! The closed table of keys: everything that can be set is listed here, and nowhere else.
//!
//! The names follow from the path: `mqtt.ca_file` in the file is `VIBRISSA_MQTT_CA_FILE` in the environment and
//! `--mqtt-ca-file` on the command line.

use std::fmt;
use std::sync::LazyLock;

/// What a value looks like; what it means is checked where it is used.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// A text.
    Text,
    /// A text that is never shown, and not taken from the command line.
    Secret,
    /// A URL whose password is never shown.
    DatabaseUrl,
    /// A file's name.
    File,
    /// Several texts; commas part them in the environment and in flags.
    Texts,
    /// Several files, in the same way.
    Files,
    /// A number in a range, both ends included.
    Number {
        /// Lowest.
        min: f64,
        /// Highest.
        max: f64,
    },
    /// A whole number in a range, both ends included.
    Whole {
        /// Lowest.
        min: u32,
        /// Highest.
        max: u32,
    },
}

impl Kind {
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
    kind: Kind,
    /// In TOML; none for a key that is unset by default.
    default: Option<&'static str>,
    help: &'static str,
}

/// Spells out the enum and its table, so that neither can have a key that the other has not.
macro_rules! keys {
    ($($key:ident: $path:literal, $kind:expr, $default:expr, $help:literal;)+) => {
        /// A key of the configuration.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
        pub enum Key {
            $(#[doc = $help] $key,)+
        }

        impl Key {
            /// All of them; those of one section are neighbours, those without a section come first.
            pub const ALL: &[Self] = &[$(Self::$key),+];

            const fn row(self) -> Row {
                match self {
                    $(Self::$key => Row { path: $path, kind: $kind, default: $default, help: $help },)+
                }
            }
        }
    };
}

keys! {
    Name: "name", Kind::Text, None,
        "What this supervisor is called, for people; the host's name if left out";
    Fleets: "fleets", Kind::Texts, Some(r#"["fleet"]"#),
        "The fleets to supervise: the second level of their topics";
    Calibrations: "calibrations", Kind::Files, Some("[]"),
        "Calibration files of `vibrissa calibrate`";
    Log: "log", Kind::Text, Some(r#""info""#),
        "What is logged, such as warn or info,vibrissa=debug; RUST_LOG wins over it";
    DatabaseUrl: "database.url", Kind::DatabaseUrl, Some(r#""sqlite:vibrissa.sqlite3""#),
        "The database: sqlite:FILE, or postgres://USER@HOST:5432/DATABASE to share fleets with other supervisors";
    DatabasePasswordFile: "database.password_file", Kind::File, None,
        "A file with the password for PostgreSQL";
    LeaseTimeToLiveS: "lease.time_to_live_s", Kind::Number { min: 0.5, max: 60.0 }, Some("2.0"),
        "How long a fleet stays this supervisor's without a word from it, seconds";
    ContactsKeep: "contacts.keep", Kind::Text, Some(r#""all""#),
        "Which contacts are kept one by one: all, decisions (before something is found or decided, and of whiskers that serve) or none; minutes and hours of each whisker always are";
    ContactsDays: "contacts.days", Kind::Whole { min: 0, max: 36_500 }, Some("30"),
        "Days after which contacts are removed; 0 keeps them for ever";
    RollupsMinutesDays: "rollups.minutes_days", Kind::Whole { min: 0, max: 36_500 }, Some("400"),
        "Days after which the minutes of whiskers are removed, 0 keeps them for ever; hours are always kept";
    LimitsRobotsPerFleet: "limits.robots_per_fleet", Kind::Whole { min: 1, max: 10_000 }, Some("10000"),
        "Robots of a fleet that are supervised; further ones are refused";
    LimitsNewRobotsPerMinute: "limits.new_robots_per_minute", Kind::Whole { min: 1, max: 10_000 }, Some("3000"),
        "Robots of a fleet that become known in a minute; the others are asked again later";
    LimitsRobotsFile: "limits.robots_file", Kind::File, None,
        "A file with the robots that are allowed, FLEET/ROBOT on each line, read again when it changes; a list set over HTTP adds to it";
    MqttUrl: "mqtt.url", Kind::Text, None,
        "An external broker, mqtt://HOST:1883 or mqtts://HOST:8883, instead of the embedded one";
    MqttPort: "mqtt.port", Kind::Whole { min: 0, max: 65_535 }, Some("1883"),
        "The embedded broker's port on 127.0.0.1; 0 takes any free one";
    MqttUsername: "mqtt.username", Kind::Text, None,
        "As whom to connect to the external broker";
    MqttPassword: "mqtt.password", Kind::Secret, None,
        "The password for it; better kept in a file. It is not taken from the command line, which others can read";
    MqttPasswordFile: "mqtt.password_file", Kind::File, None,
        "A file with the password for it";
    MqttCaFile: "mqtt.ca_file", Kind::File, None,
        "PEM certificates of the authorities that the broker's may come from; the system's if left out";
    MqttClientCertificateFile: "mqtt.client_certificate_file", Kind::File, None,
        "This supervisor's own certificate, PEM, for brokers that ask for one";
    MqttClientKeyFile: "mqtt.client_key_file", Kind::File, None,
        "The private key of that certificate, PEM";
    MqttDeafReleaseAfterS: "mqtt.deaf_release_after_s", Kind::Number { min: 1.0, max: 3600.0 }, Some("10.0"),
        "After how many seconds without hearing its robots a fleet is given to another supervisor that hears them, if there is one";
    HttpListen: "http.listen", Kind::Text, Some(r#""127.0.0.1:8080""#),
        "Where HTTP listens; port 0 takes any free one. Beyond loopback a token is asked for";
    HttpMonitoringListen: "http.monitoring_listen", Kind::Text, None,
        "Where /livez, /readyz and /metrics are served as well, without a token, such as 127.0.0.1:9464; only machines that monitor should reach it. Without it, /readyz and /metrics ask for a token beyond loopback";
    HttpConnectionsMax: "http.connections_max", Kind::Whole { min: 16, max: 1_000_000 }, Some("2048"),
        "Connections to http.listen that may be open at once; when there are more, the one that has waited longest for a request is closed. The limit of open files must allow them";
    HttpConnectionsPerAddressMax: "http.connections_per_address_max", Kind::Whole { min: 4, max: 1_000_000 }, Some("512"),
        "The same for one client address; behind a proxy all clients have the proxy's address";
    HttpTokenFile: "http.token_file", Kind::File, None,
        "A file with a token of at least 32 characters that has every right: for programs that set a supervisor up";
    HttpOidcIssuer: "http.oidc_issuer", Kind::Text, None,
        "An OpenID provider whose tokens are taken: its issuer, https://...";
    HttpOidcAudience: "http.oidc_audience", Kind::Text, None,
        "The audience that its tokens must name";
    HttpOidcJwksUrl: "http.oidc_jwks_url", Kind::Text, None,
        "Where its keys are; asked of the issuer if left out";
    HttpOidcRoleClaim: "http.oidc_role_claim", Kind::Text, Some(r#""vibrissa_role""#),
        "The claim with the role: viewer, operator, engineer or admin, or a list with one of them";
    HttpOidcFleetsClaim: "http.oidc_fleets_claim", Kind::Text, Some(r#""vibrissa_fleets""#),
        "The claim with the fleets: a list of names, or * for all";
    MetricsSeries: "metrics.series", Kind::Text, Some(r#""fleets""#),
        "What is shown to Prometheus: fleets (as wholes) or whiskers (each robot and whisker too: four series a whisker)";
    TracesOtlpEndpoint: "traces.otlp_endpoint", Kind::Text, None,
        "A collector for OpenTelemetry traces, http://HOST:4318 (OTLP as protobuf over HTTP); no traces if left out";
    TracesSampleRatio: "traces.sample_ratio", Kind::Number { min: 0.0, max: 1.0 }, Some("0.1"),
        "Share of the HTTP requests that only look which is traced; what changes something and setpoints always are";
    ModelFormulation: "model.formulation", Kind::Text, Some(r#""published""#),
        "How the paper's equations are read: published (as printed) or consistent (as its Table 2 would have it)";
    PolicyMode: "policy.mode", Kind::Text, Some(r#""automatic""#),
        "Who says that a compensation begins: automatic, or advise (an operator approves each); a policy set over HTTP wins";
    PolicyObjective: "policy.objective", Kind::Text, Some(r#""tip""#),
        "What a setpoint is solved for: tip (equal sensitivity there) or mean (least mean error over the contact ratios)";
    PolicyLongerForShorter: "policy.longer_for_shorter", Kind::Text, Some(r#""last-resort""#),
        "Whether a longer whisker may stand in for a shorter one: never, last-resort or allowed";
    PolicyPredictedErrorMax: "policy.predicted_error_max", Kind::Number { min: 0.0, max: 10.0 }, Some("0.5"),
        "Highest mean predicted error of a compensation, as a ratio";
    PolicyOwnRoleCost: "policy.own_role_cost", Kind::Number { min: 0.0, max: 10.0 }, Some("0.25"),
        "What it costs that a neighbour gives up its own role, in units of mean error: the trimmed whisker itself comes first unless a neighbour is better by more";
    PolicyChangeMargin: "policy.change_margin", Kind::Number { min: 0.0, max: 10.0 }, Some("0.1"),
        "An assignment in force is changed only for a gain above this, in units of mean error, for each whisker that changes";
    DetectionContactsBetweenFalseAlarms:
        "detection.contacts_between_false_alarms", Kind::Number { min: 1e3, max: 1e12 }, Some("1e6"),
        "Mean number of contacts of a healthy whisker between false alarms";
    DetectionColdStartContacts:
        "detection.cold_start_contacts", Kind::Whole { min: 20, max: 100_000 }, Some("150"),
        "Contacts in which a whisker's offset and noise are learned before anything is called";
}

/// The names that follow from a path.
struct Names {
    environment: String,
    flag: String,
}

/// In the order of [`Key::ALL`].
static NAMES: LazyLock<Vec<Names>> = LazyLock::new(|| {
    let names = |key: &Key| Names {
        environment: format!("{ENVIRONMENT_PREFIX}{}", key.path().replace('.', "_").to_ascii_uppercase()),
        flag: key.path().replace(['.', '_'], "-"),
    };
    Key::ALL.iter().map(names).collect()
});

/// What the names of all environment variables begin with.
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

    /// Its flag without the dashes: `mqtt-ca-file`. That of a secret only tells what to use instead.
    #[must_use]
    pub fn flag(self) -> &'static str {
        &NAMES[self as usize].flag
    }

    /// Shorter names of the flag.
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

    /// What a value looks like.
    #[must_use]
    pub const fn kind(self) -> Kind {
        self.row().kind
    }

    /// Its default, in TOML.
    #[must_use]
    pub const fn default(self) -> Option<&'static str> {
        self.row().default
    }

    /// What it is for, in one line.
    #[must_use]
    pub const fn help(self) -> &'static str {
        self.row().help
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
