//! The areas for mutations: a crate, and its mutated files.

use super::covered;
use std::path::{Path, PathBuf};

/// Files or folders below the sources, each with the name under which it is counted.
pub type Covered = &'static [(&'static str, &'static str)];

/// All crates of the mutated workspace; unmutated crates are links.
pub const CRATES: [&str; 7] =
    ["traces", "analyzer", "macros", "conformance/bus", "conformance/device", "conformance/suite", "conformance/fuzz"];
/// Further folders that tests read.
const READ: [&str; 2] = ["docs", "tests"];

/// A mutated crate.
pub struct Area {
    /// The name of the area on the command line.
    pub name: &'static str,
    pub package: &'static str,
    /// The folder of the crate.
    pub folder: &'static str,
    /// The folder to which the names of [`Self::covered`] are relative.
    pub sources: &'static str,
    pub covered: Covered,
}

/// The simulated devices, whose mutants the suite and the fuzzer must find.
pub const DEVICE: Area = Area {
    name: "device",
    package: "canvass-device",
    folder: "conformance/device",
    sources: "conformance/device/src",
    covered: &covered::DEVICE,
};

/// The areas whose mutants the tests of the crate itself must find.
pub const TESTED: [Area; 2] = [
    Area {
        name: "analyzer",
        package: "canvass-analyzer",
        folder: "analyzer",
        sources: "analyzer/src",
        covered: &covered::ANALYZER,
    },
    Area {
        name: "suite",
        package: "canvass-suite",
        folder: "conformance/suite",
        sources: "conformance/suite/src",
        covered: &covered::SUITE,
    },
];

impl Area {
    /// The folder of the mutated workspace.
    pub fn scratch(&self) -> PathBuf {
        match self.name {
            "device" => PathBuf::from("target/mutants"),
            name => Path::new("target").join(format!("mutants-{name}")),
        }
    }

    /// The links in the mutated workspace.
    pub fn linked(&self) -> impl Iterator<Item = &'static str> {
        let (own, within) = (self.folder, format!("{}/", self.folder));
        // A folder below the copied folder needs no link.
        let is_apart = move |name: &&str| *name != own && !name.starts_with(&within);
        CRATES.into_iter().filter(is_apart).chain(READ)
    }

    /// The name under which a file is counted, by its path below the sources; `None` for an unmutated file.
    pub fn service(&self, path: &str) -> Option<&'static str> {
        let is = |pattern: &str| path == pattern || pattern.ends_with('/') && path.starts_with(pattern);
        let found = self.covered.iter().find(|(pattern, _)| is(pattern)).map(|(_, service)| *service);
        found.filter(|_| !covered::TESTS.iter().any(|pattern| is(pattern)))
    }

    /// All names, in the order of the table.
    pub fn services(&self) -> Vec<&'static str> {
        let mut services: Vec<&str> = Vec::new();
        for (_, service) in self.covered {
            if !services.contains(service) {
                services.push(service);
            }
        }
        services
    }
}
