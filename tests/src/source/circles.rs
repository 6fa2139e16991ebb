//! Circles of files that use each other.

use std::collections::{BTreeMap, BTreeSet};

use super::{Target, Use};

/// One file, and another that it uses.
pub type Edge = (String, String);

/// The uses without which there would be no circle: each from a file to one that leads back to it.
#[must_use]
pub fn edges_on_circles(uses: &BTreeSet<Use>) -> Vec<Edge> {
    let mut next: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for used in uses {
        if let Target::File(file) = &used.target {
            next.entry(&used.file).or_default().push(file);
        }
    }
    let edges = next
        .iter()
        .flat_map(|(&from, files)| files.iter().map(move |&to| (from, to)));
    let leads_back = |&(from, to): &(&str, &str)| reached(&next, to).contains(from);
    edges
        .filter(leads_back)
        .map(|(from, to)| (from.to_owned(), to.to_owned()))
        .collect()
}

fn reached<'a>(next: &BTreeMap<&'a str, Vec<&'a str>>, from: &'a str) -> BTreeSet<&'a str> {
    let (mut seen, mut waiting) = (BTreeSet::from([from]), vec![from]);
    while let Some(file) = waiting.pop() {
        let files = next.get(file).into_iter().flatten();
        waiting.extend(files.filter(|&&file| seen.insert(file)));
    }
    seen
}
