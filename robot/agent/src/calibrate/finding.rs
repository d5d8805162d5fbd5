//! Findings of a calibration, and the file that keeps them until `agent.toml` is written.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::Write as _;
use std::os::unix::fs::{MetadataExt, OpenOptionsExt, fchown};
use std::path::{Path, PathBuf};

use anyhow::{Context, ensure};
use serde::{Deserialize, Serialize};
use vibrissa_protocol::text_file::read_text;

/// Size limit of the file, bytes.
const FILE_BYTES_MAX: u64 = 1024 * 1024;

/// A part of the calibration of one whisker.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub(super) enum Step {
    /// The gauge at rest: zero, noise, rate.
    Rest,
    /// The way in which a touch moves the strain.
    Sign,
    /// The end of the converter.
    Scale,
    /// The travel of the slide.
    Slide,
    /// The zero of the pressure sensor.
    Pressure,
    /// Times of the valves.
    Valves,
}

impl Step {
    pub(super) const ALL: [Step; 6] = [Step::Rest, Step::Sign, Step::Scale, Step::Slide, Step::Pressure, Step::Valves];
}

/// Meaning of a finding for the person.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub(super) enum Verdict {
    /// As it should be.
    Good,
    /// It works, but look at it.
    Check,
    /// It does not work.
    Bad,
    /// It could not be measured.
    Skipped,
}

impl Verdict {
    fn word(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Check => "CHECK",
            Self::Bad => "BAD",
            Self::Skipped => "skipped",
        }
    }
}

/// One measured property with its verdict.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Finding {
    /// Name of the measured property.
    pub(super) what: String,
    /// Value with its unit; empty if it could not be measured.
    pub(super) value: String,
    pub(super) verdict: Verdict,
    /// Reason of the verdict, and the remedy.
    pub(super) text: String,
    /// Key of the whisker in `agent.toml`, and its value as TOML; without a value the key goes.
    pub(super) change: Option<(String, String)>,
}

impl Finding {
    pub(super) fn new(what: &str, value: String, verdict: Verdict, text: impl Into<String>) -> Self {
        Self { what: what.to_owned(), value, verdict, text: text.into(), change: None }
    }

    pub(super) fn skipped(what: &str, text: &str) -> Self {
        Self::new(what, String::new(), Verdict::Skipped, text)
    }

    /// With a value for `agent.toml`.
    pub(super) fn writes(self, key: &str, value: String) -> Self {
        Self { change: Some((key.to_owned(), value)), ..self }
    }

    /// Without a key in `agent.toml` that is wrong now.
    pub(super) fn removes(self, key: &str) -> Self {
        self.writes(key, String::new())
    }

    /// The line that is printed.
    pub(super) fn line(&self, whisker: &str) -> String {
        let value = if self.value.is_empty() { String::new() } else { format!(" {}", self.value) };
        let text = if self.text.is_empty() { String::new() } else { format!(": {}", self.text) };
        format!("{whisker} {}{value} - {}{text}", self.what, self.verdict.word())
    }
}

/// Findings by whisker (`ARRAY/NUMBER`) and step.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Findings(pub(super) BTreeMap<String, BTreeMap<Step, Vec<Finding>>>);

impl Findings {
    /// The file beside `agent.toml`.
    pub(super) fn path(config: &Path) -> PathBuf {
        let mut name = config.as_os_str().to_owned();
        name.push(".calibration");
        PathBuf::from(name)
    }

    /// Those of a calibration that was stopped; none without a file.
    pub(super) fn read(path: &Path) -> anyhow::Result<Self> {
        if !path.exists() {
            return Ok(Self::default());
        }
        let text = read_text(path, FILE_BYTES_MAX).with_context(|| path.display().to_string())?;
        let advice = || format!("{} is no file of this program: use --again to begin anew", path.display());
        serde_json::from_str(&text).with_context(advice)
    }

    pub(super) fn write(&self, path: &Path) -> anyhow::Result<()> {
        let mut text = serde_json::to_string_pretty(self)?;
        text.push('\n');
        ensure!(!path.is_symlink(), "{} is a symbolic link: move it away", path.display());
        replace(path, &text)
    }

    /// Whether a step is done: one that failed, or could not be measured, is done again after a repair.
    pub(super) fn is_done(&self, whisker: &str, step: Step) -> bool {
        let is_known = |finding: &Finding| matches!(finding.verdict, Verdict::Good | Verdict::Check);
        self.0.get(whisker).and_then(|steps| steps.get(&step)).is_some_and(|found| found.iter().all(is_known))
    }

    pub(super) fn add(&mut self, whisker: &str, step: Step, findings: Vec<Finding>) {
        self.0.entry(whisker.to_owned()).or_default().insert(step, findings);
    }
}

/// Replaces a file as a whole: after a power cut the old or the new one is there. It keeps its mode and its owner, and the
/// file behind a link is the one that is replaced. No other file is touched.
pub(super) fn replace(path: &Path, text: &str) -> anyhow::Result<()> {
    let written = || -> std::io::Result<()> {
        let path = if path.is_symlink() { path.canonicalize()? } else { path.to_owned() };
        let mut name = path.as_os_str().to_owned();
        name.push(format!(".{}.new", std::process::id()));
        let new = PathBuf::from(name);
        let mut file = OpenOptions::new().write(true).create_new(true).mode(0o600).open(&new)?;
        let done = fill(&mut file, &path, text).and_then(|()| std::fs::rename(&new, &path));
        done.inspect_err(|_| drop(std::fs::remove_file(&new)))
    };
    written().with_context(|| format!("cannot write {}", path.display()))
}

/// Writes the new file, with mode and owner of the old one.
fn fill(file: &mut File, old: &Path, text: &str) -> std::io::Result<()> {
    file.write_all(text.as_bytes())?;
    if let Ok(old) = std::fs::metadata(old) {
        let own = file.metadata()?;
        if (old.uid(), old.gid()) != (own.uid(), own.gid()) {
            fchown(&*file, Some(old.uid()), Some(old.gid()))?;
        }
        file.set_permissions(old.permissions())?;
    }
    file.sync_all()
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::PermissionsExt as _;

    use super::*;

    #[test]
    fn regress_findings_survive_the_end_of_the_program_and_failed_steps_are_not_done() {
        let folder = std::env::temp_dir().join(format!("vibrissa-findings-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = Findings::path(&folder.join("agent.toml"));
        assert_eq!(Findings::read(&path).unwrap(), Findings::default());
        let mut findings = Findings::default();
        let finding = Finding::new("sign", "FALLS".to_owned(), Verdict::Good, "")
            .writes("segmenter.sign", "\"FALLS\"".to_owned());
        assert_eq!(finding.line("left/0"), "left/0 sign FALLS - good");
        findings.add("left/0", Step::Sign, vec![finding]);
        findings.add("left/0", Step::Slide, vec![Finding::skipped("slide", "no line has deflection_mm")]);
        findings.add("left/0", Step::Valves, vec![Finding::new("valves", String::new(), Verdict::Bad, "")]);
        findings.write(&path).unwrap();
        let again = Findings::read(&path).unwrap();
        assert_eq!(again, findings);
        // What failed or was skipped was never done again, and the second run said nothing of it.
        let done = Step::ALL.into_iter().filter(|step| again.is_done("left/0", *step));
        assert_eq!(done.collect::<Vec<_>>(), [Step::Sign]);
        assert!(!again.is_done("left/1", Step::Sign));
        std::fs::write(&path, "{").unwrap();
        assert!(Findings::read(&path).unwrap_err().to_string().contains("--again"));
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn regress_only_the_file_itself_is_replaced_and_keeps_its_mode() {
        let folder = std::env::temp_dir().join(format!("vibrissa-replaced-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let file = |name: &str| folder.join(name);
        let text = |name: &str| std::fs::read_to_string(file(name)).unwrap();
        for name in ["agent.toml", "agent.toml.new", "kept"] {
            std::fs::write(file(name), "mine").unwrap();
        }
        std::fs::set_permissions(file("agent.toml"), std::fs::Permissions::from_mode(0o640)).unwrap();
        std::os::unix::fs::symlink(file("agent.toml"), file("link")).unwrap();
        replace(&file("link"), "new").unwrap();
        assert_eq!((text("agent.toml"), text("agent.toml.new")), ("new".to_owned(), "mine".to_owned()));
        assert_eq!(std::fs::metadata(file("agent.toml")).unwrap().mode() & 0o777, 0o640);
        assert!(file("link").is_symlink());
        // Findings are the program's own file, and follow no link.
        std::os::unix::fs::symlink(file("kept"), file("findings")).unwrap();
        assert!(Findings::default().write(&file("findings")).is_err());
        assert_eq!(text("kept"), "mine");
        Findings::default().write(&file("new")).unwrap();
        assert_eq!(std::fs::metadata(file("new")).unwrap().mode() & 0o777, 0o600);
        assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 6, "nothing else is left");
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
