//! What can be mutated: a crate, and its files that are.

use super::covered;
use std::path::{Path, PathBuf};

/// Files below the folder of the sources, or folders, each with the name under which it is counted.
pub type Covered = &'static [(&'static str, &'static str)];

/// All crates of the mutated workspace: those that are not mutated are links.
pub const CRATES: [&str; 7] =
    ["traces", "analyzer", "macros", "conformance/bus", "conformance/device", "conformance/suite", "conformance/fuzz"];
/// What tests read besides.
const READ: [&str; 2] = ["docs", "tests"];

/// A crate that is mutated.
pub struct Area {
    /// How it is asked for.
    pub name: &'static str,
    pub package: &'static str,
    /// The folder of the crate.
    pub folder: &'static str,
    /// The folder that the names of [`Self::covered`] are below.
    pub sources: &'static str,
    pub covered: Covered,
}

/// The simulated devices, whose mutants suite and fuzzer look for.
pub const DEVICE: Area = Area {
    name: "device",
    package: "canvass-device",
    folder: "conformance/device",
    sources: "conformance/device/src",
    covered: &covered::DEVICE,
};

/// What the tests of its own crate have to hold.
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
    /// Where the mutated workspace is built.
    pub fn scratch(&self) -> PathBuf {
        match self.name {
            "device" => PathBuf::from("target/mutants"),
            name => Path::new("target").join(format!("mutants-{name}")),
        }
    }

    /// What is no more than a link in the mutated workspace.
    pub fn linked(&self) -> impl Iterator<Item = &'static str> {
        let (own, within) = (self.folder, format!("{}/", self.folder));
        // What is in a folder that is linked or copied comes with it.
        let is_apart = move |name: &&str| *name != own && !name.starts_with(&within);
        CRATES.into_iter().filter(is_apart).chain(READ)
    }

    /// Under which name a file is counted, by its path below the sources; `None`: it is left as it is.
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
