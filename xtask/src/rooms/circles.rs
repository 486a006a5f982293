//! Folders, and files beside them, that use each other.

use super::modules::{Crate, ModulePath};
use std::collections::{BTreeMap, BTreeSet};

/// The uses between the files and folders of one level: for each name and each name that it uses, one example of a
/// using and a used module.
type Level<'a> = BTreeMap<String, BTreeMap<String, (&'a [String], ModulePath)>>;

/// The circles of a crate that contain a folder, as text.
pub fn of(read: &Crate) -> Vec<String> {
    let mut levels: BTreeMap<ModulePath, Level<'_>> = BTreeMap::new();
    for (user, used) in read.uses() {
        let common = user.iter().zip(&used).take_while(|(a, b)| a == b).count();
        // A module may use the modules above and below it.
        if let (Some(from), Some(to)) = (user.get(common), used.get(common)) {
            let level = levels.entry(user[..common].to_vec()).or_default();
            level.entry(from.clone()).or_default().entry(to.clone()).or_insert((user, used.clone()));
        }
    }
    levels.iter().flat_map(|(folder, level)| circles(read, folder, level)).collect()
}

/// The circles of one level, each circle once: the shortest way from its first name back to this name.
fn circles(read: &Crate, folder: &[String], level: &Level<'_>) -> Vec<String> {
    let mut known: BTreeSet<BTreeSet<&str>> = BTreeSet::new();
    let mut found = Vec::new();
    for name in level.keys() {
        let Some(way) = way_back(level, name) else { continue };
        let is_folder = |name: &&str| read.is_folder(&[folder, &[(*name).to_owned()]].concat());
        if way.iter().any(is_folder) && known.insert(way.iter().copied().collect()) {
            found.push(words(folder, level, &way));
        }
    }
    found
}

/// The shortest way from a name back to itself.
fn way_back<'a>(level: &'a Level<'_>, name: &'a str) -> Option<Vec<&'a str>> {
    let mut ways = vec![vec![name]];
    let mut seen = BTreeSet::new();
    while !ways.is_empty() {
        let mut longer = Vec::new();
        for way in ways {
            let next = way.last().and_then(|last| level.get(*last));
            for to in next.into_iter().flat_map(BTreeMap::keys) {
                if to == name {
                    return Some(way);
                }
                if seen.insert(to) {
                    longer.push([&way[..], &[to]].concat());
                }
            }
        }
        ways = longer;
    }
    None
}

fn words(folder: &[String], level: &Level<'_>, way: &[&str]) -> String {
    let steps = way.iter().zip(way.iter().cycle().skip(1)).filter_map(|(from, to)| {
        let (user, used) = level.get(*from)?.get(*to)?;
        Some(format!("{} uses {}", user.join("/"), used.join("/")))
    });
    let steps: Vec<String> = steps.collect();
    let place = if folder.is_empty() { "the crate".to_owned() } else { folder.join("/") };
    format!("circle in {place}: {}", steps.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(files: &[(&str, &str)]) -> Vec<String> {
        let mut read = Crate::default();
        for (path, text) in files {
            let path = path.split('/').filter(|part| !part.is_empty()).map(str::to_owned).collect();
            read.add(path, text).unwrap();
        }
        of(&read)
    }

    #[test]
    fn two_folders_that_use_each_other_are_a_circle() {
        let circle =
            found(&[("a/x", "use crate::b::y::Y;"), ("b/y", "fn f() { crate::a::x::g() }"), ("a", ""), ("b", "")]);
        assert_eq!(circle, ["circle in the crate: a/x uses b/y, b/y uses a/x"]);
        assert!(found(&[("a/x", "use crate::b::y::Y;"), ("b/y", "use crate::c::Z;"), ("c", "")]).is_empty());
    }

    #[test]
    fn what_is_passed_on_counts_from_where_it_is() {
        let files = [
            ("", "mod a; mod b; pub use b::y::Y;"),
            ("a", "mod x; pub use x::X as Other;"),
            ("a/x", "use crate::Y;"),
            ("b", "pub mod y;"),
            ("b/y", "use super::super::a::{self, Other};"),
        ];
        assert_eq!(found(&files), ["circle in the crate: a/x uses b/y, b/y uses a"]);
    }

    #[test]
    fn a_circle_may_go_by_way_of_others_and_a_file_beside_a_folder_may_close_it() {
        let files = [
            ("n/bus", "use super::c::C;"),
            ("n/c", "use super::d::x::X;"),
            ("n/d/x", "use crate::n::bus::Bus;"),
            ("n", ""),
        ];
        assert_eq!(found(&files), ["circle in n: n/bus uses n/c, n/c uses n/d/x, n/d/x uses n/bus"]);
    }

    #[test]
    fn files_of_one_folder_children_and_tests_are_none() {
        assert!(found(&[("n/a", "use super::b::B;"), ("n/b", "use super::a::A;"), ("n", "")]).is_empty());
        assert!(found(&[("n", "mod a; use a::A;"), ("n/a", "use super::N;")]).is_empty());
        let test = "#[cfg(test)] mod tests { use crate::b::y::Y; }";
        assert!(found(&[("a/x", test), ("b/y", "use crate::a::x::X;")]).is_empty());
        let file = "#![cfg(test)] use crate::b::y::Y;";
        assert!(found(&[("a/x", file), ("b/y", "use crate::a::x::X;")]).is_empty());
    }
}
