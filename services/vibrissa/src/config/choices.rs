//! Enumerated values of the configuration and of commands.

use clap::ValueEnum;
use vibrissa_core::mechanics::{Formulation, Objective};
use vibrissa_core::policy::{LongerForShorter, Mode};

use vibrissa_supervisor::engine::ContactRetention;
use vibrissa_supervisor::kafka_options::SaslMechanism;

/// Interpretation of the paper's factor in eq. 27, 29 and 31.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum FormulationArg {
    /// As printed; gives the paper's setpoints.
    Published,
    /// Consistent with Table 2.
    Consistent,
}

impl From<FormulationArg> for Formulation {
    fn from(arg: FormulationArg) -> Self {
        match arg {
            FormulationArg::Published => Self::Published,
            FormulationArg::Consistent => Self::Consistent,
        }
    }
}

/// Whether compensations need approval.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum ModeArg {
    /// Compensations start without approval.
    Automatic,
    /// An operator approves each compensation.
    Advise,
}

impl From<ModeArg> for Mode {
    fn from(arg: ModeArg) -> Self {
        match arg {
            ModeArg::Automatic => Self::Automatic,
            ModeArg::Advise => Self::Advise,
        }
    }
}

/// Single contacts that are stored.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum KeepArg {
    /// All contacts are stored.
    All,
    /// Contacts before a detection or a decision, and those of compensators.
    Decisions,
    /// No single contact is stored.
    None,
}

impl From<KeepArg> for ContactRetention {
    fn from(arg: KeepArg) -> Self {
        match arg {
            KeepArg::All => Self::All,
            KeepArg::Decisions => Self::Decisions,
            KeepArg::None => Self::None,
        }
    }
}

/// Detail of the Prometheus metrics.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SeriesArg {
    /// Totals of each fleet.
    Fleets,
    /// Also each robot and whisker.
    Whiskers,
}

/// Log for other programs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LogArg {
    /// No log.
    None,
    /// Apache Kafka.
    Kafka,
}

/// Where contacts and statuses come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum IngestArg {
    /// The MQTT broker.
    Mqtt,
    /// Apache Kafka.
    Kafka,
}

/// Whether the database is that of an installation that exists.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum InstallationArg {
    /// It knows every owner that the broker retains.
    Known,
    /// It was begun after owners that the broker retains.
    New,
}

/// Contacts that are published.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum PublishContactsArg {
    /// All contacts are published.
    All,
    /// No contact is published.
    None,
}

/// How a password is proved to the log.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum SaslArg {
    /// A proof of the password, with SHA-512.
    #[value(name = "scram-sha-512")]
    ScramSha512,
    /// A proof of the password, with SHA-256.
    #[value(name = "scram-sha-256")]
    ScramSha256,
    /// The password itself.
    Plain,
}

impl From<SaslArg> for SaslMechanism {
    fn from(arg: SaslArg) -> Self {
        match arg {
            SaslArg::ScramSha512 => Self::ScramSha512,
            SaslArg::ScramSha256 => Self::ScramSha256,
            SaslArg::Plain => Self::Plain,
        }
    }
}

/// Objective of the setpoint solver.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum ObjectiveArg {
    /// Equal sensitivity at the tip, as in the paper.
    Tip,
    /// Least mean error over the contact ratios.
    Mean,
    /// Air for the shape and a gain on the readings for the level.
    Shape,
}

impl From<ObjectiveArg> for Objective {
    fn from(arg: ObjectiveArg) -> Self {
        match arg {
            ObjectiveArg::Tip => Self::Tip,
            ObjectiveArg::Mean => Self::Mean,
            ObjectiveArg::Shape => Self::Shape,
        }
    }
}

/// Whether a longer whisker may compensate for a shorter one.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum LongerForShorterArg {
    /// A longer whisker is never used.
    Never,
    /// Only if no other candidate is suitable.
    LastResort,
    /// Like any other candidate.
    Allowed,
}

impl From<LongerForShorterArg> for LongerForShorter {
    fn from(arg: LongerForShorterArg) -> Self {
        match arg {
            LongerForShorterArg::Never => Self::Never,
            LongerForShorterArg::LastResort => Self::LastResort,
            LongerForShorterArg::Allowed => Self::Allowed,
        }
    }
}
