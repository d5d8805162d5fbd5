//! The accessibility rules of axe-core, applied to the visible page.
//!
//! Its script (MPL-2.0) is no part of the project: npm fetches it once into the build folder. Its hash is checked.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;

use ring::digest::{SHA256, digest};

use crate::browser::Browser;

const VERSION: &str = "4.14.1";
/// SHA-256 of `axe.min.js` of that version.
const HASH: &str = "29348999450cdf2849a8e70b7912fc2da85a849da39c0d0d5394f51d4a9ed95c";

/// Only one test fetches the script.
static FETCHING: Mutex<()> = Mutex::new(());

/// The script; `None` if it cannot be fetched, which `tests/run` counts.
pub(crate) fn script() -> Option<String> {
    let _fetching = FETCHING.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("axe-core-{VERSION}"));
    let file = folder.join("package/axe.min.js");
    if !file.exists()
        && let Err(problem) = fetch(&folder)
    {
        eprintln!("axe-core: skipped, {problem}");
        return None;
    }
    let script = std::fs::read_to_string(&file).unwrap();
    let hash: String = digest(&SHA256, script.as_bytes()).as_ref().iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!(hash, HASH, "{} is not the script of version {VERSION}: remove it", file.display());
    Some(script)
}

fn fetch(folder: &Path) -> Result<PathBuf, String> {
    std::fs::create_dir_all(folder).map_err(|problem| problem.to_string())?;
    let run = |command: &mut Command| match command.current_dir(folder).output() {
        Ok(output) if output.status.success() => Ok(()),
        Ok(output) => Err(format!("{command:?}: {}", String::from_utf8_lossy(&output.stderr))),
        Err(problem) => Err(format!("{command:?}: {problem}")),
    };
    run(Command::new("npm").args(["pack", "--silent", &format!("axe-core@{VERSION}")]))?;
    run(Command::new("tar").args([
        "xzf",
        &format!("axe-core-{VERSION}.tgz"),
        "package/axe.min.js",
        "package/LICENSE",
    ]))?;
    Ok(folder.join("package"))
}

/// Violations of all rules on the visible page: the rule, and the elements.
pub(crate) async fn violations(browser: &mut Browser, script: &str) -> Vec<String> {
    if browser.js("typeof axe").await == "undefined" {
        browser.js(&format!("{script};0")).await;
    }
    let finding = "`${one.id} (${one.impact}): ${one.nodes.slice(0, 3).map((node) => \
                `${node.target.join(' ')} ${node.html.slice(0, 160)} ${node.failureSummary}`).join(' | ')}`";
    let options = "{ resultTypes: ['violations'] }";
    let asked = format!("axe.run(document, {options}).then(({{ violations }}) => violations.map((one) => {finding}))");
    let found = browser.js(&asked).await;
    found.as_array().unwrap().iter().map(|one| one.as_str().unwrap().to_owned()).collect()
}
