//! Calibration files: `vibrissa-lab calibrate` writes them, and the supervisor and simulated whiskers read them.
//!
//! ```toml
//! name = "left-front"              # the model's name in factsheets
//! c = 0.4693                       # k2 = c + a exp(-b Q)
//! a = 1.6234
//! b_per_mpa = 9.3977
//! youngs_modulus_mpa = 1.1134
//! elongation_gain_mm = 8.6766      # delta_l = G Q / (k2 E)
//! # [geometry] is required for dimensions other than the paper's, and must be complete.
//! ```

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use vibrissa_core::mechanics::{Calibration, Formulation, Geometry, Model, ModelError};
use vibrissa_protocol::text_file::read_text;
use vibrissa_protocol::{BadName, Name, plain};

/// Size limit of a file, bytes.
const FILE_BYTES_MAX: u64 = 1024 * 1024;

/// A calibration with its name, as stored in the file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct CalibrationFile {
    /// The name that factsheets use for the model: 1 to 64 letters, digits, `_` or `-`.
    pub name: String,
    /// Limit of k2 at high pressure, above 0: k2 = c + a exp(-b Q).
    pub c: f64,
    /// Excess of k2 over `c` at zero pressure, not below 0.
    pub a: f64,
    /// Decay rate b of k2 with pressure, 1/MPa, above 0.
    pub b_per_mpa: f64,
    /// Young's modulus E of the rubber, MPa, above 0.
    pub youngs_modulus_mpa: f64,
    /// Elongation gain G of the chamber, mm, not below 0: delta_l = G Q / (k2 E).
    pub elongation_gain_mm: f64,
    /// Dimensions of the whisker; those of the paper (Table 1) if omitted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub geometry: Option<GeometrySection>,
}

/// A calibration with its number in the database: the parameters of an action that activates it.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Activation {
    /// Its number in the database.
    pub calibration_id: i64,
    /// Its numbers and its name.
    pub calibration: CalibrationFile,
}

/// Why a calibration file is refused.
#[derive(Debug, thiserror::Error)]
pub enum CalibrationFileError {
    /// The file cannot be read.
    #[error("calibration file {path} cannot be read: {}", plain::io(reason))]
    Read {
        /// Path of the file.
        path: PathBuf,
        /// The error of the operating system.
        reason: std::io::Error,
    },
    /// The file is not TOML, or a key is missing, unknown or of the wrong type: the reason names it.
    #[error("calibration file {path}: {reason}")]
    Parse {
        /// Path of the file.
        path: PathBuf,
        /// Position and cause.
        reason: String,
    },
    /// The name is invalid.
    #[error("calibration file {path}, key `name`: {reason}")]
    Name {
        /// Path of the file.
        path: PathBuf,
        /// The rule for names.
        reason: BadName,
    },
    /// The numbers do not give a valid model.
    #[error("calibration file {path}: {reason}")]
    Model {
        /// Path of the file.
        path: PathBuf,
        /// The violated condition.
        reason: ModelError,
    },
}

/// Reads and checks a calibration file. Returns the model's name and the model.
///
/// # Errors
/// The file cannot be read, a key is wrong, or its numbers do not give a valid model.
pub fn load(path: &Path, formulation: Formulation) -> Result<(String, Model), CalibrationFileError> {
    let text = read_text(path, FILE_BYTES_MAX)
        .map_err(|reason| CalibrationFileError::Read { path: path.to_owned(), reason })?;
    let file: CalibrationFile = toml::from_str(&text)
        .map_err(|problem| plain::in_file(&text, problem.span(), problem.message()))
        .map_err(|reason| CalibrationFileError::Parse { path: path.to_owned(), reason })?;
    let name = Name::new(&file.name).map_err(|reason| CalibrationFileError::Name { path: path.to_owned(), reason })?;
    let model =
        file.model(formulation).map_err(|reason| CalibrationFileError::Model { path: path.to_owned(), reason })?;
    Ok((name.as_str().to_owned(), model))
}

impl CalibrationFile {
    /// The file for a calibration. The paper's geometry is omitted.
    #[must_use]
    pub fn new(name: &Name, geometry: &Geometry, calibration: &Calibration) -> Self {
        Self {
            name: name.as_str().to_owned(),
            c: calibration.c,
            a: calibration.a,
            b_per_mpa: calibration.b_per_mpa,
            youngs_modulus_mpa: calibration.youngs_modulus_mpa,
            elongation_gain_mm: calibration.elongation_gain_mm,
            geometry: (*geometry != Geometry::nguyen_2021()).then(|| (*geometry).into()),
        }
    }

    /// The mechanics of a whisker with this calibration.
    ///
    /// # Errors
    /// The numbers do not give a valid model.
    pub fn model(&self, formulation: Formulation) -> Result<Model, ModelError> {
        Model::new(self.geometry(), self.calibration(), formulation)
    }

    /// The geometry of the file, or the paper's.
    #[must_use]
    pub fn geometry(&self) -> Geometry {
        self.geometry.map_or_else(Geometry::nguyen_2021, Into::into)
    }

    /// The five parameters of the calibration.
    #[must_use]
    pub fn calibration(&self) -> Calibration {
        Calibration {
            c: self.c,
            a: self.a,
            b_per_mpa: self.b_per_mpa,
            youngs_modulus_mpa: self.youngs_modulus_mpa,
            elongation_gain_mm: self.elongation_gain_mm,
        }
    }
}

/// A section with the keys of [`Geometry`], where they are explained, and conversions in both directions.
macro_rules! geometry_section {
    ($($key:ident),+ $(,)?) => {
        /// The dimensions of [`Geometry`], under the same names.
        #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
        #[serde(deny_unknown_fields)]
        #[allow(missing_docs, reason = "the fields are Geometry's, and explained there")]
        pub struct GeometrySection { $(pub $key: f64),+ }

        impl From<Geometry> for GeometrySection {
            fn from(geometry: Geometry) -> Self {
                Self { $($key: geometry.$key),+ }
            }
        }

        impl From<GeometrySection> for Geometry {
            fn from(section: GeometrySection) -> Self {
                Self { $($key: section.$key),+ }
            }
        }
    };
}

geometry_section! {
    d1_large_mm, l1_mm, d2_large_mm, l2_mm, d3_large_mm, l3_mm, d2_mid_large_mm, d2_mid_small_mm, l2_mid_mm,
    dm_large_mm, dm_small_mm, lm_mm, c_mm, t_mm, l_mm, e_mm, xss_mm, poisson_ratio,
}
