//! Words that can be chosen, in the configuration and in commands.

use clap::ValueEnum;
use vibrissa_core::mechanics::{Formulation, Objective};
use vibrissa_core::policy::{LongerForShorter, Mode};

use vibrissa_supervisor::engine::Keep;

/// How the paper's factor of eq. 27, 29 and 31 is read.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum FormulationArg {
    /// As printed; gives the paper's setpoints.
    Published,
    /// As Table 2 would have it.
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

/// Who says that a compensation begins.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum ModeArg {
    /// The program.
    Automatic,
    /// An operator, of each that is proposed.
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

/// Which contacts are kept one by one.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum KeepArg {
    /// All.
    All,
    /// Those before something is found or decided, and those of whiskers that serve.
    Decisions,
    /// None.
    None,
}

impl From<KeepArg> for Keep {
    fn from(arg: KeepArg) -> Self {
        match arg {
            KeepArg::All => Self::All,
            KeepArg::Decisions => Self::Decisions,
            KeepArg::None => Self::None,
        }
    }
}

/// What is shown to Prometheus.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SeriesArg {
    /// Fleets as wholes.
    Fleets,
    /// Each robot and whisker, too.
    Whiskers,
}

/// What a setpoint is solved for.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum ObjectiveArg {
    /// Equal sensitivity at the tip, as in the paper.
    Tip,
    /// Least mean error over the contact ratios.
    Mean,
}

impl From<ObjectiveArg> for Objective {
    fn from(arg: ObjectiveArg) -> Self {
        match arg {
            ObjectiveArg::Tip => Self::Tip,
            ObjectiveArg::Mean => Self::Mean,
        }
    }
}

/// Whether a longer whisker may stand in for a shorter one.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum LongerForShorterArg {
    /// Never.
    Never,
    /// Only where nothing else serves.
    LastResort,
    /// Like the others.
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
