//! Definitions of ROS messages: the usual ones are built in, others come from the installed ROS.

use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Definitions of messages whose values may be those of a whisker, and of their parts.
const BUILT_IN: [(&str, &str); 33] = [
    ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec"),
    ("builtin_interfaces/Duration", "int32 sec\nuint32 nanosec"),
    ("std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id"),
    ("std_msgs/Bool", "bool data"),
    ("std_msgs/Float32", "float32 data"),
    ("std_msgs/Float64", "float64 data"),
    ("std_msgs/Int8", "int8 data"),
    ("std_msgs/Int16", "int16 data"),
    ("std_msgs/Int32", "int32 data"),
    ("std_msgs/Int64", "int64 data"),
    ("std_msgs/UInt8", "uint8 data"),
    ("std_msgs/UInt16", "uint16 data"),
    ("std_msgs/UInt32", "uint32 data"),
    ("std_msgs/UInt64", "uint64 data"),
    ("std_msgs/String", "string data"),
    ("std_msgs/MultiArrayDimension", "string label\nuint32 size\nuint32 stride"),
    ("std_msgs/MultiArrayLayout", "MultiArrayDimension[] dim\nuint32 data_offset"),
    ("std_msgs/Float32MultiArray", "MultiArrayLayout layout\nfloat32[] data"),
    ("std_msgs/Float64MultiArray", "MultiArrayLayout layout\nfloat64[] data"),
    ("std_msgs/Int16MultiArray", "MultiArrayLayout layout\nint16[] data"),
    ("std_msgs/Int32MultiArray", "MultiArrayLayout layout\nint32[] data"),
    ("std_msgs/UInt16MultiArray", "MultiArrayLayout layout\nuint16[] data"),
    ("geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z"),
    ("geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z"),
    ("geometry_msgs/PointStamped", "std_msgs/Header header\nPoint point"),
    ("geometry_msgs/Vector3Stamped", "std_msgs/Header header\nVector3 vector"),
    ("geometry_msgs/Wrench", "Vector3 force\nVector3 torque"),
    ("geometry_msgs/WrenchStamped", "std_msgs/Header header\nWrench wrench"),
    ("sensor_msgs/FluidPressure", "std_msgs/Header header\nfloat64 fluid_pressure\nfloat64 variance"),
    (
        "sensor_msgs/JointState",
        "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort",
    ),
    ("diagnostic_msgs/KeyValue", "string key\nstring value"),
    (
        "diagnostic_msgs/DiagnosticStatus",
        "byte OK=0\nbyte level\nstring name\nstring message\nstring hardware_id\nKeyValue[] values",
    ),
    ("diagnostic_msgs/DiagnosticArray", "std_msgs/Header header\nDiagnosticStatus[] status"),
];
/// Most messages within each other.
const DEPTH_MAX: usize = 16;
/// Size limit of a definition in a file, bytes.
const FILE_MAX: u64 = 1 << 20;

/// Kind of a field.
#[derive(Debug, Clone, PartialEq)]
pub enum Kind {
    /// True or false, as 1 or 0.
    Bool,
    /// An integer of this many bits.
    Signed(u8),
    /// An integer of this many bits that is not negative.
    Unsigned(u8),
    /// A number of 32 bits.
    Float32,
    /// A number of 64 bits.
    Float64,
    /// A text in UTF-8.
    Text,
    /// A message within the message.
    Message(Arc<Layout>),
    /// A list of any length.
    List(Box<Kind>),
    /// A list of this length.
    Array(Box<Kind>, usize),
}

impl Kind {
    /// Whether a value of it is a number.
    pub(crate) fn is_number(&self) -> bool {
        match self {
            Self::Bool | Self::Signed(_) | Self::Unsigned(_) | Self::Float32 | Self::Float64 => true,
            Self::Text | Self::Message(_) | Self::List(_) | Self::Array(..) => false,
        }
    }

    /// The kind of the elements of a list.
    pub(crate) fn element(&self) -> Option<&Kind> {
        match self {
            Self::List(element) | Self::Array(element, _) => Some(element),
            Self::Bool
            | Self::Signed(_)
            | Self::Unsigned(_)
            | Self::Float32
            | Self::Float64
            | Self::Text
            | Self::Message(_) => None,
        }
    }
}

/// The fields of a message, in their order.
#[derive(Debug, Clone, PartialEq)]
pub struct Layout {
    /// Package and name, such as `std_msgs/Header`.
    pub name: String,
    /// Names and kinds of the fields.
    pub fields: Vec<(String, Kind)>,
}

impl Layout {
    /// Place and kind of a field.
    pub(crate) fn field(&self, name: &str) -> Option<(usize, &Kind)> {
        self.fields.iter().enumerate().find(|(_, field)| field.0 == name).map(|(at, field)| (at, &field.1))
    }
}

/// Where definitions are.
#[derive(Debug, Clone, Default)]
pub struct Definitions {
    /// Folders of ROS, as of `AMENT_PREFIX_PATH`.
    prefixes: Vec<PathBuf>,
}

/// Package and name of a type written as `package/msg/Name` or `package/Name`.
pub(crate) fn package_and_name(kind: &str) -> Option<(&str, &str)> {
    let is_word = |word: &str| {
        word.starts_with(|first: char| first.is_ascii_alphabetic())
            && word.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_')
    };
    let (package, rest) = kind.split_once('/')?;
    let name = rest.strip_prefix("msg/").unwrap_or(rest);
    (is_word(package) && is_word(name)).then_some((package, name))
}

impl Definitions {
    /// Definitions in the folders of `AMENT_PREFIX_PATH`, which are separated by colons.
    #[must_use]
    pub fn new(ament_prefix_path: &str) -> Self {
        Self { prefixes: ament_prefix_path.split(':').filter(|path| !path.is_empty()).map(PathBuf::from).collect() }
    }

    /// The fields of a type such as `sensor_msgs/msg/JointState`.
    ///
    /// # Errors
    /// The type is not known, or its definition cannot be read.
    pub fn layout(&self, kind: &str) -> Result<Arc<Layout>, String> {
        let (package, name) = package_and_name(kind)
            .ok_or_else(|| format!("{kind:.64} is no type: write it as sensor_msgs/msg/JointState"))?;
        self.nested(package, name, 0)
    }

    fn text(&self, package: &str, name: &str) -> Result<String, String> {
        let full = format!("{package}/{name}");
        if let Some((_, text)) = BUILT_IN.iter().find(|(known, _)| *known == full) {
            return Ok((*text).to_owned());
        }
        let file = |prefix: &PathBuf| prefix.join("share").join(package).join("msg").join(format!("{name}.msg"));
        let Some(path) = self.prefixes.iter().map(file).find(|path| path.is_file()) else {
            let near: Vec<&str> =
                BUILT_IN.iter().map(|(known, _)| *known).filter(|known| known.starts_with(package)).collect();
            let known = if near.is_empty() { "the usual ones of ROS".to_owned() } else { near.join(", ") };
            let remedy =
                "source the setup file of a ROS that has it, so that AMENT_PREFIX_PATH leads to its definition";
            return Err(format!("the type {package}/msg/{name} is unknown. Built in are {known}; {remedy}"));
        };
        read(&path).map_err(|problem| format!("the definition {}: {problem}", path.display()))
    }

    fn nested(&self, package: &str, name: &str, depth: usize) -> Result<Arc<Layout>, String> {
        if depth > DEPTH_MAX {
            return Err(format!("the type {package}/msg/{name} has more than {DEPTH_MAX} messages within each other"));
        }
        let text = self.text(package, name)?;
        let mut fields = Vec::new();
        for line in text.lines() {
            let line = line.split('#').next().unwrap_or_default().trim();
            let mut words = line.split_whitespace();
            let (Some(kind), Some(field)) = (words.next(), words.next()) else { continue };
            // A constant has no place in a message.
            if field.contains('=') || words.next().is_some_and(|word| word.starts_with('=')) {
                continue;
            }
            let kind = self.kind(package, kind, depth).map_err(|why| format!("{package}/msg/{name}, {line}: {why}"))?;
            fields.push((field.to_owned(), kind));
        }
        if fields.is_empty() {
            // DDS has no empty messages.
            fields.push(("structure_needs_at_least_one_member".to_owned(), Kind::Unsigned(8)));
        }
        Ok(Arc::new(Layout { name: format!("{package}/{name}"), fields }))
    }

    fn kind(&self, package: &str, text: &str, depth: usize) -> Result<Kind, String> {
        if let Some((element, length)) = text.strip_suffix(']').and_then(|text| text.rsplit_once('[')) {
            let element = Box::new(self.kind(package, element, depth)?);
            if length.is_empty() || length.starts_with("<=") {
                return Ok(Kind::List(element));
            }
            let length = length.parse().map_err(|_| format!("{length} is no length of a list"))?;
            return Ok(Kind::Array(element, length));
        }
        Ok(match text.split("<=").next().unwrap_or_default() {
            "bool" => Kind::Bool,
            "byte" | "char" | "uint8" => Kind::Unsigned(8),
            "uint16" => Kind::Unsigned(16),
            "uint32" => Kind::Unsigned(32),
            "uint64" => Kind::Unsigned(64),
            "int8" => Kind::Signed(8),
            "int16" => Kind::Signed(16),
            "int32" => Kind::Signed(32),
            "int64" => Kind::Signed(64),
            "float32" => Kind::Float32,
            "float64" => Kind::Float64,
            "string" => Kind::Text,
            "wstring" => return Err("wide texts are not read".to_owned()),
            "Header" => Kind::Message(self.nested("std_msgs", "Header", depth + 1)?),
            other => {
                let (package, name) = package_and_name(other).unwrap_or((package, other));
                Kind::Message(self.nested(package, name, depth + 1)?)
            }
        })
    }
}

fn read(path: &Path) -> Result<String, String> {
    let length = std::fs::metadata(path).map_err(|problem| problem.to_string())?.len();
    if length > FILE_MAX {
        return Err(format!("has {length} bytes; at most {FILE_MAX} are read"));
    }
    std::fs::read_to_string(path).map_err(|problem| problem.to_string())
}
