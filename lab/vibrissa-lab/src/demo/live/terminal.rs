//! Commands that a person types while the demo runs.

use std::io::{BufRead, BufReader, IsTerminal, Read, stdin};

use tokio::sync::mpsc;

use super::incident::{Incident, WhiskerName};

/// Longest line, in bytes; a longer one is read in parts.
const LINE_BYTES_MAX: u64 = 1024;
/// Number of lines that wait to be carried out.
const LINES_WAITING: usize = 16;

/// The commands of the terminal.
pub(super) const MENU: &str = "  cut 5 whisker 2         cut whisker 2 by 5 mm
  cut 22 crawler-1/tail/0 too short for air alone: an alarm with a hint
  erode whisker 1         wear whisker 1 off with each contact
  leak whisker 3          let the chamber of whisker 3 leak
  heat 10                 heat the whiskers of the array by 10 K: no cut must be called
  replace whisker 2       install a new whisker 2, and report it to the supervisor
  help, quit
A whisker of another array has its full name. Without a whisker, the last one is meant.";

/// A typed line.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Command {
    /// Let an incident happen.
    Cause(WhiskerName, Incident),
    /// Show the menu.
    Help,
    /// End the demo.
    Quit,
    /// An empty line.
    Nothing,
}

/// Parses a line. `last` is the whisker that the previous command named.
///
/// # Errors
/// The line is no command; the message says why, and what to type.
pub(super) fn parse(line: &str, last: &WhiskerName) -> Result<Command, String> {
    let lower = line.trim().to_ascii_lowercase();
    let mut words = lower.split_whitespace();
    let Some(verb) = words.next() else { return Ok(Command::Nothing) };
    let incident = match verb {
        "cut" => Incident::Cut { by_mm: number(words.next(), "cut 5", "mm")? },
        "heat" => Incident::Heat { by_k: number(words.next(), "heat 10", "K")? },
        "erode" => Incident::Erode,
        "leak" => Incident::Leak,
        "replace" => Incident::Replace,
        "help" | "?" => return nothing_after(words, Command::Help),
        "quit" | "exit" | "q" => return nothing_after(words, Command::Quit),
        other => {
            return Err(format!("{other:?} is no command: type cut, erode, leak, heat, replace, help or quit"));
        }
    };
    let whisker = match words.next() {
        None => last.clone(),
        Some("whisker") => named(words.next().ok_or("which whisker? For example: whisker 2")?, last)?,
        Some(name) => named(name, last)?,
    };
    nothing_after(words, Command::Cause(whisker, incident))
}

fn number(word: Option<&str>, example: &str, unit: &str) -> Result<f64, String> {
    let word = word.ok_or_else(|| format!("by how many {unit}? For example: {example}"))?;
    let number: Option<f64> = word.parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| format!("{word:?} is not a number of {unit}; for example: {example}"))
}

fn named(word: &str, last: &WhiskerName) -> Result<WhiskerName, String> {
    match word.parse() {
        Ok(whisker) => Ok(WhiskerName { whisker, ..last.clone() }),
        Err(_) => word.parse(),
    }
}

fn nothing_after<'a>(mut words: impl Iterator<Item = &'a str>, command: Command) -> Result<Command, String> {
    match words.next() {
        None => Ok(command),
        Some(word) => Err(format!("{word:?} is too much: one command per line, type help for examples")),
    }
}

/// The lines of standard input, until it is closed. None of a terminal if the demo runs in its background.
pub(super) fn lines() -> mpsc::Receiver<String> {
    let (sender, lines) = mpsc::channel(LINES_WAITING);
    // The terminal would stop a background process that reads from it.
    if stdin().is_terminal() && is_in_background() {
        return lines;
    }
    // A thread of its own: tokio's would keep the program from ending until the next line is typed.
    std::thread::spawn(move || {
        let mut input = BufReader::new(stdin());
        loop {
            let mut line = Vec::new();
            match input.by_ref().take(LINE_BYTES_MAX).read_until(b'\n', &mut line) {
                Ok(0) | Err(_) => return,
                Ok(_) => {}
            }
            if sender.blocking_send(String::from_utf8_lossy(&line).into_owned()).is_err() {
                return;
            }
        }
    });
    lines
}

/// Whether another process group has the terminal; false where the system does not tell.
fn is_in_background() -> bool {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // After the name in parentheses: state, parent, process group, session, terminal, process group of the terminal.
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or_default().split_whitespace().collect();
    matches!((fields.get(2), fields.get(5)), (Some(own), Some(terminal)) if own != terminal)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn last() -> WhiskerName {
        "crawler-1/left/0".parse().unwrap()
    }

    #[test]
    fn commands_name_their_whisker_or_mean_the_last_one() {
        let cut = Incident::Cut { by_mm: 5.0 };
        for (line, whisker, incident) in [
            ("cut 5 whisker 2", "crawler-1/left/2", cut),
            (" CUT  5.0 2\n", "crawler-1/left/2", cut),
            ("cut 5", "crawler-1/left/0", cut),
            ("cut 5 crawler-2/nose/1", "crawler-2/nose/1", cut),
            ("erode", "crawler-1/left/0", Incident::Erode),
            ("leak whisker 3", "crawler-1/left/3", Incident::Leak),
            ("heat -10", "crawler-1/left/0", Incident::Heat { by_k: -10.0 }),
            ("replace crawler-2/nose/0", "crawler-2/nose/0", Incident::Replace),
        ] {
            assert_eq!(parse(line, &last()), Ok(Command::Cause(whisker.parse().unwrap(), incident)), "{line}");
        }
        assert_eq!(parse("help", &last()), Ok(Command::Help));
        assert_eq!(parse("quit\r\n", &last()), Ok(Command::Quit));
        assert_eq!(parse("\n", &last()), Ok(Command::Nothing));
    }

    #[test]
    fn a_wrong_line_is_answered_with_what_to_type() {
        for (line, expected) in [
            ("chop 5", "\"chop\" is no command: type cut, erode"),
            ("cut", "by how many mm? For example: cut 5"),
            ("cut five", "\"five\" is not a number of mm"),
            ("cut NaN", "\"nan\" is not a number of mm"),
            ("heat warm", "\"warm\" is not a number of K"),
            ("cut 5 whisker", "which whisker? For example: whisker 2"),
            ("cut 5 left/2", "\"left/2\" is not a whisker: write ROBOT/ARRAY/NUMBER"),
            ("cut 5 whisker -1", "\"-1\" is not a whisker"),
            ("cut 5 whisker 2 now", "\"now\" is too much"),
            ("quit now", "\"now\" is too much"),
        ] {
            let problem = parse(line, &last()).unwrap_err();
            assert!(problem.contains(expected), "{line}: {problem}");
        }
    }
}
