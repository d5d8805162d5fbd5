//! The mapping file, in YAML.

use std::collections::BTreeMap;
use std::path::Path as FilePath;
use std::sync::Arc;

use serde::Deserialize;
use serde_saphyr::Spanned;

use super::definitions::{Definitions, Layout, package_and_name};
use super::path::Path;
use super::{Constant, MappedSetpoint, MappedTopic, Mapping, Number, Quantity, SetpointType, Use};

/// Size limit of a file, bytes.
const FILE_MAX: u64 = 1 << 20;
/// Time between samples that the agent takes, us.
const EVERY_US: std::ops::RangeInclusive<u32> = 500..=100_000;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    whiskers: BTreeMap<String, Spanned<FileWhisker>>,
    #[serde(default)]
    driving: Option<Spanned<Source>>,
    #[serde(default)]
    task: Option<Spanned<Source>>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct FileWhisker {
    strain: Option<Spanned<Source>>,
    strain_2: Option<Spanned<Source>>,
    deflection: Option<Spanned<Source>>,
    distance: Option<Spanned<Source>>,
    ratio: Option<Spanned<Source>>,
    pressure: Option<Spanned<Source>>,
    regulator: Option<Spanned<Source>>,
    setpoint: Option<Spanned<Source>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Source {
    topic: Option<Spanned<String>>,
    #[serde(rename = "type")]
    kind: Option<Spanned<String>>,
    field: Option<Spanned<String>>,
    scale: Option<Spanned<f64>>,
    offset: Option<Spanned<f64>>,
    every_us: Option<Spanned<u32>>,
    constant: Option<Spanned<f64>>,
}

/// A source whose topic, type and place are known.
struct Found {
    topic: String,
    kind: String,
    number: Number,
    layout: Arc<Layout>,
}

fn at<T>(line: &Spanned<T>, key: &str, why: impl std::fmt::Display) -> String {
    format!("line {}: {key}: {why}", line.referenced.line())
}

fn finite(value: Option<&Spanned<f64>>, key: &str, otherwise: f64, allows_zero: bool) -> Result<f64, String> {
    let Some(given) = value else { return Ok(otherwise) };
    if given.value.is_finite() && (allows_zero || given.value != 0.0) {
        return Ok(given.value);
    }
    Err(at(
        given,
        key,
        format!("is {}, but must be a finite number{}", given.value, if allows_zero { "" } else { " other than 0" }),
    ))
}

impl Source {
    fn find(source: &Spanned<Source>, key: &str, definitions: &Definitions) -> Result<Found, String> {
        let Source { topic, kind, field, scale, offset, .. } = &source.value;
        let missing = |name: &str| at(source, key, format!("`{name}` is missing; a source has topic, type and field"));
        let topic = topic.as_ref().ok_or_else(|| missing("topic"))?;
        let kind = kind.as_ref().ok_or_else(|| missing("type"))?;
        let field = field.as_ref().ok_or_else(|| missing("field"))?;
        let layout = definitions.layout(&kind.value).map_err(|why| at(kind, &format!("{key}.type"), why))?;
        let path = Path::find(&field.value, &layout).map_err(|why| at(field, &format!("{key}.field"), why))?;
        let scale = finite(scale.as_ref(), &format!("{key}.scale"), 1.0, false)?;
        let offset = finite(offset.as_ref(), &format!("{key}.offset"), 0.0, true)?;
        let number = Number { path, scale, offset };
        Ok(Found { topic: topic.value.clone(), kind: kind.value.clone(), number, layout })
    }
}

fn only_for<T>(given: Option<&Spanned<T>>, key: &str, name: &str, quantity: &str) -> Result<(), String> {
    given.map_or(Ok(()), |given| Err(at(given, key, format!("`{name}` is only for {quantity}"))))
}

/// The array and the number in `left/0`.
fn place(name: &str) -> Option<(String, u16)> {
    let (array, number) = name.rsplit_once('/')?;
    Some((array.to_owned(), number.parse().ok()?)).filter(|(array, _)| !array.is_empty())
}

impl Mapping {
    /// Reads a mapping file.
    ///
    /// # Errors
    /// It cannot be read, or is wrong; the error names file, line and key.
    pub fn read(path: &FilePath, definitions: &Definitions) -> Result<Self, String> {
        let wrong = |problem: String| format!("the mapping {}: {problem}", path.display());
        let length = std::fs::metadata(path).map_err(|problem| wrong(problem.to_string()))?.len();
        if length > FILE_MAX {
            return Err(wrong(format!("has {length} bytes; at most {FILE_MAX} are read")));
        }
        let text = std::fs::read_to_string(path).map_err(|problem| wrong(problem.to_string()))?;
        Self::parse(&text, definitions).map_err(wrong)
    }

    /// Reads the text of a mapping file.
    ///
    /// # Errors
    /// It is wrong; the error names line and key.
    pub fn parse(text: &str, definitions: &Definitions) -> Result<Self, String> {
        // The library's text goes on with a picture of the place.
        let file: File = serde_saphyr::from_str(text)
            .map_err(|problem| problem.to_string().lines().next().unwrap_or_default().to_owned())?;
        if file.whiskers.is_empty() {
            return Err("whiskers: names no whisker".to_owned());
        }
        let mut mapping = Self::default();
        for (name, whisker) in &file.whiskers {
            let key = format!("whiskers.{name}");
            let place = place(name).ok_or_else(|| at(whisker, &key, "write array and number, as left/0"))?;
            mapping.add(place, whisker, &key, definitions)?;
        }
        if let Some(driving) = &file.driving {
            let (topic, number) = mapping.state(driving, "driving", definitions)?;
            topic.driving = Some(number);
        }
        if let Some(task) = &file.task {
            let (topic, number) = mapping.state(task, "task", definitions)?;
            topic.task = Some(number);
        }
        Ok(mapping)
    }

    fn add(
        &mut self,
        place: (String, u16),
        whisker: &Spanned<FileWhisker>,
        key: &str,
        definitions: &Definitions,
    ) -> Result<(), String> {
        let FileWhisker { strain, strain_2, deflection, distance, ratio, pressure, regulator, setpoint } =
            &whisker.value;
        let sources = [
            ("strain", strain),
            ("deflection", deflection),
            ("distance", distance),
            ("ratio", ratio),
            ("pressure", pressure),
            ("regulator", regulator),
        ];
        let is_none = sources.iter().all(|(_, source)| source.is_none()) && setpoint.is_none() && strain_2.is_none();
        if is_none {
            let allowed = "strain, strain_2, deflection, distance, ratio, pressure, regulator, setpoint";
            return Err(at(whisker, key, format!("has no value; allowed are {allowed}")));
        }
        if let (Some(second), None) = (strain_2, strain) {
            return Err(at(second, &format!("{key}.strain_2"), "needs strain, too"));
        }
        for (name, source) in sources {
            let Some(source) = source else { continue };
            let key = format!("{key}.{name}");
            if name != "strain" {
                only_for(source.value.every_us.as_ref(), &key, "every_us", "strain")?;
            }
            if let Some(constant) = &source.value.constant {
                if name != "pressure" {
                    return Err(at(constant, &key, "`constant` is only for pressure"));
                }
                if source.value.topic.is_some() {
                    return Err(at(constant, &key, "give either `constant` or `topic`"));
                }
                let pa = finite(Some(constant), &key, 0.0, true)?;
                self.constants.push(Constant { place: place.clone(), index: None, pa });
                continue;
            }
            let found = Source::find(source, &key, definitions)?;
            let every_us = source.value.every_us.as_ref();
            if let Some(every_us) = every_us.filter(|every_us| !EVERY_US.contains(&every_us.value)) {
                return Err(at(every_us, &key, format!("every_us is {}, but must be 500 to 100000", every_us.value)));
            }
            if found.number.path.is_list() && every_us.is_none() {
                let why = if name == "strain" {
                    "leads to a list: name one element, such as data[0], or give `every_us` if they are samples in turn"
                } else {
                    "leads to a list: name one element, such as data[0]"
                };
                return Err(at(source, &format!("{key}.field"), why));
            }
            let quantity = match name {
                "deflection" => Quantity::Deflection,
                "distance" => Quantity::Distance,
                "ratio" => Quantity::Ratio,
                "pressure" => Quantity::Pressure,
                "regulator" => Quantity::Regulator,
                _ => {
                    let second =
                        strain_2.as_ref().map(|second| Self::second(second, &found, key.as_str(), definitions));
                    Quantity::Strain { second: second.transpose()?, every_us: every_us.map(|every_us| every_us.value) }
                }
            };
            self.read_from(found, place.clone(), quantity)?;
        }
        if let Some(setpoint) = setpoint {
            self.write_to(place, setpoint, &format!("{key}.setpoint"), definitions)?;
        }
        Ok(())
    }

    /// The second gauge, whose samples must be in the messages of the first.
    fn second(second: &Spanned<Source>, first: &Found, key: &str, definitions: &Definitions) -> Result<Number, String> {
        let key = format!("{key}_2");
        only_for(second.value.every_us.as_ref(), &key, "every_us", "strain")?;
        only_for(second.value.constant.as_ref(), &key, "constant", "pressure")?;
        let found = Source::find(second, &key, definitions)?;
        if (&found.topic, &found.kind) != (&first.topic, &first.kind) {
            return Err(at(
                second,
                &key,
                format!("must be in the messages of strain, {} on {}", first.kind, first.topic),
            ));
        }
        if found.number.path.is_list() != first.number.path.is_list() {
            return Err(at(second, &key, "must lead to as many numbers as strain"));
        }
        Ok(found.number)
    }

    fn read_from(&mut self, found: Found, place: (String, u16), quantity: Quantity) -> Result<(), String> {
        let number = found.number.clone();
        self.topic_of(found)?.uses.push(Use { place, index: None, quantity, number });
        Ok(())
    }

    /// Topic and number of a state of the whole robot.
    fn state(
        &mut self,
        source: &Spanned<Source>,
        key: &str,
        definitions: &Definitions,
    ) -> Result<(&mut MappedTopic, Number), String> {
        only_for(source.value.every_us.as_ref(), key, "every_us", "strain")?;
        only_for(source.value.constant.as_ref(), key, "constant", "pressure")?;
        let found = Source::find(source, key, definitions)?;
        if found.number.path.is_list() {
            let field = format!("{key}.field");
            return Err(at(source, &field, "leads to a list: name one element, such as data[0]"));
        }
        let number = found.number.clone();
        Ok((self.topic_of(found)?, number))
    }

    fn topic_of(&mut self, found: Found) -> Result<&mut MappedTopic, String> {
        let Found { topic, kind, layout, .. } = found;
        let known = self.topics.iter().position(|known| known.topic == topic);
        let index = known.unwrap_or(self.topics.len());
        if known.is_none() {
            let stamp = MappedTopic::stamp_in(&layout);
            let (topic, kind) = (topic.clone(), kind.clone());
            self.topics.push(MappedTopic { topic, kind, layout, stamp, uses: Vec::new(), driving: None, task: None });
        }
        let known = &mut self.topics[index];
        if known.kind != kind {
            return Err(format!("the topic {topic} has two types: {} and {kind}", known.kind));
        }
        Ok(known)
    }

    fn write_to(
        &mut self,
        place: (String, u16),
        source: &Spanned<Source>,
        key: &str,
        definitions: &Definitions,
    ) -> Result<(), String> {
        only_for(source.value.every_us.as_ref(), key, "every_us", "strain")?;
        only_for(source.value.constant.as_ref(), key, "constant", "pressure")?;
        let Found { topic, kind, number, .. } = Source::find(source, key, definitions)?;
        let written = match (package_and_name(&kind), number.path.to_string().as_str()) {
            (Some(("std_msgs", "Float64")), "data") => SetpointType::Float64,
            (Some(("std_msgs", "Float32")), "data") => SetpointType::Float32,
            (Some(("sensor_msgs", "FluidPressure")), "fluid_pressure") => SetpointType::FluidPressure,
            _ => {
                let allowed =
                    "data of std_msgs/msg/Float64 or Float32, or fluid_pressure of sensor_msgs/msg/FluidPressure";
                return Err(at(source, key, format!("a setpoint is {allowed}")));
            }
        };
        if let Some(other) = self.setpoints.iter().find(|other| other.topic == topic) {
            let (array, whisker) = &other.place;
            return Err(at(source, key, format!("the topic {topic} has the setpoints of {array}/{whisker} already")));
        }
        self.setpoints.push(MappedSetpoint { place, index: None, topic, written, number });
        Ok(())
    }
}
