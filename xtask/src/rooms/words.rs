//! Words that no file of the core may contain: the names of device profiles and of manufacturers.
//!
//! Code of a profile is in the folder `profiles` of a crate, peculiarities of a manufacturer are in the data of its
//! models. Comments count, too. Tests do not count: they may use any device as an example.

use anyhow::{Context, Result};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// The crates whose core names no profile and no manufacturer.
pub const CORES: [&str; 5] =
    ["analyzer", "conformance/bus", "conformance/device", "conformance/suite", "conformance/fuzz"];

/// Words of profiles and manufacturers, in lower case.
const NAMES: [&str; 13] = [
    "402",
    "406",
    "cam",
    "cams",
    "encoder",
    "encoders",
    "inclinometer",
    "kuebler",
    "kübler",
    "lika",
    "shaft",
    "tr-electronic",
    "wachendorff",
];

/// Files where such a word has another meaning or is the subject: file, words, reason.
const EXCEPTIONS: [(&str, &[&str], &str); 7] = [
    ("analyzer/src/lib.rs", &["encoder"], "the inverse of a parser"),
    ("analyzer/src/wire/mod.rs", &["encoder"], "the inverse of a parser"),
    ("conformance/device/src/models/mod.rs", &["406", "kuebler", "lika"], "the list of models: file names"),
    (
        "conformance/device/src/liberty/catalogue.rs",
        &["kuebler", "kübler", "lika", "tr-electronic"],
        "evidence: devices that take a liberty",
    ),
    (
        "conformance/device/src/fault.rs",
        &["406", "cam", "encoder", "shaft", "kuebler", "lika"],
        "the one list of faults, of profiles too, each with a model that shows it",
    ),
    ("conformance/device/src/fault/unfuzzed.rs", &["406", "shaft"], "why the fuzzer can't find faults of that list"),
    ("conformance/suite/src/zero_point.rs", &["shaft"], "what turns under a position, in a text for users"),
];

/// A forbidden word in a file.
#[derive(PartialEq, Eq, Debug)]
pub struct Named {
    pub file: PathBuf,
    pub line: usize,
    pub word: &'static str,
}

/// The words in the core of a crate, and the obsolete exceptions.
pub fn check(root: &Path, krate: &str) -> Result<Vec<String>> {
    let mut used = BTreeSet::new();
    let mut found = Vec::new();
    for file in files(&root.join(krate).join("src"))? {
        let text = std::fs::read_to_string(&file).with_context(|| file.display().to_string())?;
        let file = file.strip_prefix(root).unwrap_or(&file).to_path_buf();
        for (line, word) in words(&text) {
            match exception(&file, word) {
                Some(place) => drop(used.insert((place, word))),
                None => found.push(Named { file: file.clone(), line, word }),
            }
        }
    }
    let told = found.iter().map(|Named { file, line, word }| {
        format!(
            "{}:{line}: the core names \"{word}\": move it to the folder of its profile, or into data",
            file.display()
        )
    });
    let idle = EXCEPTIONS.iter().enumerate().filter(|(_, (file, ..))| file.starts_with(&format!("{krate}/src/")));
    let idle = idle.flat_map(|(place, (file, words, _))| words.iter().map(move |word| (place, *file, *word)));
    let idle = idle.filter(|(place, _, word)| !used.contains(&(*place, *word)));
    let idle = idle.map(|(_, file, word)| format!("{file}: the exception for \"{word}\" is needed no more"));
    Ok(told.chain(idle).collect())
}

fn exception(file: &Path, word: &str) -> Option<usize> {
    EXCEPTIONS.iter().position(|(of, words, _)| file == Path::new(of) && words.contains(&word))
}

/// The files of the core below a folder: neither profiles nor tests.
fn files(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        let entries = std::fs::read_dir(&folder).with_context(|| folder.display().to_string())?;
        let mut tests = Vec::new();
        for entry in entries {
            let path = entry?.path();
            let name = path.file_stem().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
            if path.is_dir() {
                folders.extend(Some(path).filter(|_| !matches!(&*name, "profiles" | "tests")));
            } else if path.extension().is_some_and(|extension| extension == "rs") && name != "tests" {
                tests.extend(test_modules(&std::fs::read_to_string(&path)?));
                files.push(path);
            }
        }
        files.retain(|file| {
            file.parent() != Some(&folder) || !tests.iter().any(|name| file.ends_with(format!("{name}.rs")))
        });
    }
    files.sort_unstable();
    Ok(files)
}

/// The test-only modules in files of their own.
fn test_modules(text: &str) -> Vec<String> {
    let after = text.match_indices("#[cfg(test)]\n").map(|(at, mark)| &text[at + mark.len()..]);
    let declared = after.filter_map(|rest| rest.lines().next()?.strip_suffix(';')?.rsplit_once("mod "));
    declared.map(|(_, name)| name.to_owned()).collect()
}

/// The names in a text, each with its line, up to `#[cfg(test)] mod tests`.
fn words(text: &str) -> Vec<(usize, &'static str)> {
    let core = text.split("#[cfg(test)]\nmod tests").next().unwrap_or(text);
    let of_line = |(n, line): (usize, &str)| {
        let parts = parts(line);
        let is_there = move |name: &&'static str| {
            let named: Vec<&str> = name.split('-').collect();
            parts.windows(named.len()).any(|window| window.iter().zip(&named).all(|(part, word)| part == word))
        };
        NAMES.into_iter().filter(is_there).map(move |name| (n + 1, name)).collect::<Vec<_>>()
    };
    core.lines().enumerate().flat_map(of_line).collect()
}

/// The words of a line in lower case: capital letters and underscores separate the words of an identifier.
fn parts(line: &str) -> Vec<String> {
    let mut parts = vec![String::new()];
    let mut before = ' ';
    for letter in line.chars() {
        if !letter.is_alphanumeric() || letter.is_uppercase() && before.is_lowercase() {
            parts.push(String::new());
        }
        if letter.is_alphanumeric() {
            parts.last_mut().into_iter().for_each(|part| part.extend(letter.to_lowercase()));
        }
        before = letter;
    }
    parts.retain(|part| !part.is_empty());
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_found_in_code_comments_and_texts() {
        let text =
            "/// An encoder.\nlet isEncoder = EncoderKind::X;\n// of TR-Electronic\nconst CAM_STATE: u8 = 406;\n";
        assert_eq!(words(text), [(1, "encoder"), (2, "encoder"), (3, "tr-electronic"), (4, "406"), (4, "cam")]);
        let other = "it came with 4061 shafts; an encoded trace of electronics\n#[cfg(test)]\nmod tests { encoder }";
        assert_eq!(words(other), []);
    }

    #[test]
    fn modules_for_tests_are_told() {
        assert_eq!(test_modules("mod a;\n#[cfg(test)]\npub(crate) mod documentation;\nmod b;"), ["documentation"]);
    }

    #[test]
    fn the_core_names_no_profile_and_no_manufacturer() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
        for krate in CORES {
            let found = check(root, krate).unwrap();
            assert!(found.is_empty(), "{krate}:\n{}", found.join("\n"));
        }
    }
}
