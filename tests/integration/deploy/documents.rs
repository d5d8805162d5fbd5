//! The documents and their two lists: `docs/README.md`, the map for readers of the repository, and `docs/SUMMARY.md`, the
//! chapters of the site that `docs/make-book` builds.

use std::collections::BTreeSet;
use std::fs::{read_dir, read_to_string};
use std::path::{Component, Path, PathBuf};

use crate::project;

/// Documents of a folder and those below it, relative to `docs`.
fn documents(folder: &Path, found: &mut BTreeSet<PathBuf>) {
    for entry in read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            documents(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "md") {
            found.insert(path.strip_prefix(project().join("docs")).unwrap().to_owned());
        }
    }
}

/// Targets of the links in a document, without those to other hosts and without anchors.
fn links(document: &Path) -> BTreeSet<String> {
    let text = read_to_string(document).unwrap();
    let targets = text.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(target, _)| target);
    let files = targets.filter(|target| !target.contains("://")).filter_map(|target| target.split('#').next());
    files.filter(|file| !file.is_empty()).map(str::to_owned).collect()
}

/// The path without `..`.
fn plain(path: &Path) -> PathBuf {
    let mut parts = Vec::new();
    for part in path.components() {
        if part == Component::ParentDir {
            parts.pop();
        } else {
            parts.push(part);
        }
    }
    parts.into_iter().collect()
}

#[test]
fn the_summary_has_each_document_once_and_the_map_names_it() {
    let docs = project().join("docs");
    let mut documents_there = BTreeSet::new();
    documents(&docs, &mut documents_there);
    documents_there.remove(Path::new("SUMMARY.md"));
    let summary = read_to_string(docs.join("SUMMARY.md")).unwrap();
    let map = links(&docs.join("README.md"));
    assert!(documents_there.len() > 60, "{documents_there:?}");
    for document in documents_there {
        let name = document.to_str().unwrap();
        assert_eq!(summary.matches(&format!("]({name})")).count(), 1, "chapters of docs/SUMMARY.md for {name}");
        // The decisions have a list of their own.
        let is_listed = name == "README.md" || name.starts_with("decisions/") || map.contains(name);
        assert!(is_listed, "docs/README.md must link {name}");
    }
}

#[test]
fn the_list_of_decisions_has_each_one() {
    let folder = project().join("docs/decisions");
    let listed = links(&folder.join("README.md"));
    let files = read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    for file in files.filter(|file| file.ends_with(".md") && file != "README.md") {
        assert!(listed.contains(&file), "docs/decisions/README.md must link {file}");
    }
}

/// A link to a document that is no chapter would lead nowhere on the site.
#[test]
fn each_link_of_a_chapter_leads_to_a_file_and_each_linked_document_is_a_chapter() {
    let docs = project().join("docs");
    let chapters: BTreeSet<PathBuf> =
        links(&docs.join("SUMMARY.md")).iter().map(|target| plain(&docs.join(target))).collect();
    for chapter in &chapters {
        for target in links(chapter) {
            let file = plain(&chapter.parent().unwrap().join(&target));
            assert!(file.exists(), "{}: {target} does not exist", chapter.display());
            let is_document = file.extension().is_some_and(|extension| extension == "md");
            let is_chapter = !is_document || chapters.contains(&file);
            assert!(is_chapter, "{}: {target} is missing in docs/SUMMARY.md", chapter.display());
        }
    }
}
