//! Requirements of Grafana beyond the linter's rules: stable identities, panels that do not overlap, and valid links.

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

use serde_json::Value;
use vibrissa_tests::python::environment_if_reachable;

use super::promql::selectors;
use super::{ALL, Dashboard, folder, list, targets, text};
use crate::alerts::named_alerts;

#[test]
fn golden_dashboards_are_what_their_sources_make() {
    let Some(programs) =
        environment_if_reachable("../dashboards/requirements-dashboards.txt", env!("CARGO_TARGET_TMPDIR"))
    else {
        return;
    };
    let run = |program: &str, arguments: &[&str]| {
        let ended = Command::new(programs.join(program)).args(arguments).current_dir(folder()).output().unwrap();
        let said = String::from_utf8_lossy(&ended.stdout) + String::from_utf8_lossy(&ended.stderr);
        assert!(ended.status.success(), "run dashboards/build.py: {said}");
    };
    run("python", &["build.py", "--check"]);
    // The SDK's types know the structure of each kind of panel.
    run("mypy", &["--check-untyped-defs", "--cache-dir=/dev/null", "build.py"]);
}

/// Bookmarks and links depend on these ids.
#[test]
fn identities_last() {
    let uids: Vec<(&str, &str)> = ALL.iter().map(|one| (one.file.as_str(), one.uid())).collect();
    let expected = [
        ("compensation.json", "vibrissa-compensation"),
        ("fleet.json", "vibrissa-fleet"),
        ("robot.json", "vibrissa-robot"),
        ("supervisor.json", "vibrissa-supervisor"),
        ("whisker.json", "vibrissa-whisker"),
    ];
    assert_eq!(uids, expected);
    for dashboard in ALL.iter() {
        // Grafana 12 writes this version; it would migrate an older one on load.
        assert_eq!(dashboard.json["schemaVersion"], 42, "{}", dashboard.file);
        let panels = || list(&dashboard.json["panels"]);
        let numbers: BTreeSet<u64> = panels().map(|panel| panel["id"].as_u64().unwrap()).collect();
        assert_eq!(numbers.len(), panels().count(), "{}: two panels have the same id", dashboard.file);
        for panel in dashboard.panels() {
            let letters: BTreeSet<&str> = targets(panel).map(|(_, target)| text(&target["refId"])).collect();
            assert_eq!(letters.len(), targets(panel).count(), "{}: {}", dashboard.file, panel["title"]);
        }
    }
}

#[test]
fn every_panel_says_what_it_shows_and_in_which_unit() {
    for dashboard in ALL.iter() {
        assert!(dashboard.panels().count() >= 10 && !text(&dashboard.json["description"]).is_empty());
        for panel in dashboard.panels() {
            let place = format!("{}: {}", dashboard.file, panel["title"]);
            assert!(text(&panel["description"]).ends_with('.'), "{place}: no description");
            assert!(!text(&panel["fieldConfig"]["defaults"]["unit"]).is_empty(), "{place}: no unit");
        }
        for variable in dashboard.variables() {
            assert!(!text(&variable["description"]).is_empty(), "{}: {}", dashboard.file, variable["name"]);
        }
    }
}

#[test]
fn no_panel_lies_on_another() {
    for dashboard in ALL.iter() {
        let mut taken = BTreeMap::new();
        for panel in list(&dashboard.json["panels"]) {
            let [x, y, w, h] = ["x", "y", "w", "h"].map(|part| panel["gridPos"][part].as_u64().unwrap());
            assert!(w > 0 && h > 0 && x + w <= 24, "{}: {}", dashboard.file, panel["title"]);
            for cell in (x..x + w).flat_map(|x| (y..y + h).map(move |y| (x, y))) {
                let other = taken.insert(cell, &panel["title"]);
                assert!(other.is_none(), "{}: {} overlaps {other:?}", dashboard.file, panel["title"]);
            }
        }
    }
}

#[test]
fn links_lead_to_dashboards_that_know_their_variables() {
    for dashboard in ALL.iter() {
        let links: Vec<&str> = list(&dashboard.json["links"]).map(|link| text(&link["url"])).collect();
        let others = ALL.iter().filter(|other| other.uid() != dashboard.uid());
        let expected: BTreeSet<String> = others.map(|other| format!("/d/{}", other.uid())).collect();
        assert_eq!(links.iter().map(|&link| link.to_owned()).collect::<BTreeSet<_>>(), expected, "{}", dashboard.file);
        for (panel, link) in drill_downs(dashboard).filter(|(_, link)| !link.starts_with(CONSOLE)) {
            let place = format!("{}: {}: {link}", dashboard.file, panel["title"]);
            let (uid, query) = link.strip_prefix("/d/").and_then(|rest| rest.split_once('?')).expect(&place);
            let target =
                ALL.iter().find(|one| one.uid() == uid).unwrap_or_else(|| panic!("{place}: unknown dashboard"));
            for part in query.split('&') {
                match part.split_once('=') {
                    Some((name, _)) => {
                        let name = name.strip_prefix("var-").expect(&place);
                        assert!(target.variable(name).is_some(), "{place}: the target has no variable {name}");
                    }
                    None => {
                        assert!(part == "${__url_time_range}" || part.ends_with(":queryparam}"), "{place}")
                    }
                }
            }
        }
    }
    let leads_to = |uid: &str| ALL.iter().flat_map(drill_downs).filter(|(_, link)| link.contains(uid)).count();
    assert!(leads_to("/vibrissa-robot?") >= 3 && leads_to("/vibrissa-whisker?") >= 5);
}

/// Links in table cells, each with its panel.
pub(super) fn drill_downs(dashboard: &Dashboard) -> impl Iterator<Item = (&Value, &str)> {
    dashboard.panels().flat_map(|panel| {
        let properties = list(&panel["fieldConfig"]["overrides"]).flat_map(|one| list(&one["properties"]));
        let links =
            properties.filter(|property| property["id"] == "links").flat_map(|property| list(&property["value"]));
        links.map(move |link| (panel, text(&link["url"])))
    })
}

/// Start of the links to the console.
const CONSOLE: &str = "${console:raw}/#/";

/// Panels link to a page of the console, and so do cells that name a robot or a whisker; the address is a variable.
#[test]
fn panels_lead_to_the_console() {
    let is_page = |path: &str| {
        let parts: Vec<&str> = path.split('/').collect();
        matches!(
            parts[..],
            ["alarms"] | ["fleets", _, "robots", _] | ["fleets", _, "robots", _, "arrays", _, "whiskers", _]
        )
    };
    for dashboard in ALL.iter() {
        let address = dashboard.variable("console").expect(&dashboard.file);
        assert_eq!((text(&address["type"]), text(&address["query"])), ("textbox", "http://127.0.0.1:8080"));
        for panel in dashboard.panels() {
            let links: Vec<&str> =
                list(&panel["fieldConfig"]["defaults"]["links"]).map(|link| text(&link["url"])).collect();
            let [link] = links[..] else { panic!("{}: {}: one link", dashboard.file, panel["title"]) };
            assert!(link.strip_prefix(CONSOLE).is_some_and(is_page), "{}: {link}", dashboard.file);
        }
        for (panel, link) in drill_downs(dashboard).filter(|(_, link)| link.contains("console:raw")) {
            assert!(link.strip_prefix(CONSOLE).is_some_and(is_page), "{}: {}: {link}", dashboard.file, panel["title"]);
        }
    }
    let of_cells = ALL.iter().flat_map(drill_downs).filter(|(_, link)| link.starts_with(CONSOLE)).count();
    assert!(of_cells >= 5, "{of_cells}");
}

#[test]
fn grafanas_alerts_lead_to_dashboards() {
    for (alert, rule) in named_alerts() {
        let uid = text(&rule["annotations"]["dashboard"]);
        assert!(ALL.iter().any(|dashboard| dashboard.uid() == uid), "{alert}: {uid} is not a dashboard");
    }
}

#[test]
fn every_variable_that_is_used_is_one() {
    for dashboard in ALL.iter() {
        let queries = dashboard.panels().flat_map(targets).map(|(_, target)| target);
        let annotations = list(&dashboard.json["annotations"]["list"]).map(|one| &one["target"]);
        let texts = queries.chain(annotations).flat_map(|one| [text(&one["expr"]), text(&one["rawSql"])]);
        let queries = dashboard.variables().flat_map(|one| [text(&one["query"]), text(&one["query"]["query"])]);
        let texts = texts.chain(queries);
        for used in texts.flat_map(used_variables) {
            assert!(dashboard.variable(used).is_some(), "{}: {used} is not one of its variables", dashboard.file);
        }
    }
}

/// Names of fleets have no character with a meaning in patterns, so each name is a pattern, too.
#[test]
fn fleets_can_be_several_or_a_pattern() {
    for dashboard in ALL.iter() {
        for (panel, target) in dashboard.promql() {
            for selector in selectors(text(&target["expr"])) {
                let mut matchers = selector.matchers.into_iter().flat_map(|all| all.split(','));
                let is_pattern = matchers.all(|one| !one.starts_with("fleet") || one == r#"fleet=~"${fleet:pipe}""#);
                assert!(is_pattern, "{}: {}", dashboard.file, panel["title"]);
            }
        }
        let Some(fleet) = dashboard.variable("fleet") else { panic!("{}: no fleet", dashboard.file) };
        // A robot is one of one fleet.
        if dashboard.variable("robot").is_none() {
            let properties = ["multi", "includeAll", "allowCustomValue"];
            assert!(properties.iter().all(|&property| fleet[property] == true), "{}: {fleet}", dashboard.file);
        }
    }
}

/// Names after a dollar sign, without Grafana's own variables.
fn used_variables(query: &str) -> impl Iterator<Item = &str> {
    let name = |after: &'_ str| after.trim_start_matches('{').len();
    query
        .split('$')
        .skip(1)
        .map(move |after| {
            let after = &after[after.len() - name(after)..];
            &after[..after.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).unwrap_or(after.len())]
        })
        .filter(|name| !name.starts_with("__"))
}
