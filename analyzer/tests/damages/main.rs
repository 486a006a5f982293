//! Checks every rule of device descriptions with random damage. A test takes a correct file and changes it at a random
//! place so that it breaks one rule. `check` must then report this rule at this place.
//!
//! The right files are random descriptions, which have no finding at all, and the descriptions of the built-in models.

// `cfg(test)` changes nothing here, but tells clippy that a test may unwrap.
#![cfg(test)]

mod dice;
mod eds;
mod entry;
mod field;
mod info;
mod list;
mod module;
mod number;
mod pdo;
mod right;
mod section;
mod standard;
mod text;
mod xml;

use canvass_analyzer::dictionary::check::{Finding, Folder, check_in};
use canvass_analyzer::dictionary::{DeviceDescription, rules, xdd};
use dice::Dice;
use eds::Eds;
use proptest::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

const NAME: &str = "example.eds";

/// The place where a finding must be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// In this line, from 0.
    Line(usize),
    /// In no line: a whole section is missing.
    File,
}

/// The bytes of a file, and the place where they break a rule.
type Broken = (Vec<u8>, Place);

/// Breaks one rule at a random place; `None` if the file has no place for it.
#[derive(Clone, Copy)]
pub enum Damage {
    /// Changes the lines.
    Lines(fn(&mut Eds, &mut Dice) -> Option<Place>),
    /// Changes the bytes.
    Bytes(fn(&mut Eds, &mut Dice) -> Option<Broken>),
}
use Damage::{Bytes, Lines};

impl Damage {
    fn of(self, text: &str, dice: &mut Dice) -> Option<Broken> {
        let mut eds = Eds::new(text);
        match self {
            Lines(damage) => damage(&mut eds, dice).map(|place| (eds.text().into_bytes(), place)),
            Bytes(damage) => damage(&mut eds, dice),
        }
    }
}

fn damages() -> Vec<(&'static str, Damage)> {
    let families = [
        text::DAMAGES,
        section::DAMAGES,
        field::DAMAGES,
        info::DAMAGES,
        number::DAMAGES,
        list::DAMAGES,
        entry::DAMAGES,
        pdo::DAMAGES,
        standard::DAMAGES,
        module::DAMAGES,
    ];
    families.concat()
}

/// The folder of the files, with an EDS of another device and a file to download.
struct Beside;

/// The EDS of another device in the same folder.
pub const ANOTHER_EDS: &str = "another.eds";

impl Folder for Beside {
    fn has(&self, name: &str) -> bool {
        name == "program.bin"
    }

    fn read(&self, name: &str) -> Option<Vec<u8>> {
        let text = "[OptionalObjects]\nSupportedObjects=1\n1=0x1FFE\n[1FFE]\nParameterName=Another\nDataType=0x0005\nAccessType=ro\n";
        (name == ANOTHER_EDS).then(|| text.as_bytes().to_vec())
    }
}

fn findings(bytes: &[u8]) -> Vec<Finding> {
    check_in(bytes, Some(NAME), Some(&Beside)).unwrap().findings
}

fn is_found(findings: &[Finding], rule: &str, place: Place) -> bool {
    let line = match place {
        Place::Line(line) => line as u32 + 1,
        Place::File => 0,
    };
    findings.iter().any(|finding| finding.problem.rule.id == rule && finding.line == line)
}

/// The finding that a file lacks, as text: rule, place, and the findings instead; `None` if the file has the finding.
fn missed(rule: &str, bytes: &[u8], place: Place) -> Option<String> {
    let found = findings(bytes);
    if is_found(&found, rule, place) {
        return None;
    }
    let text = String::from_utf8_lossy(bytes);
    let line = match place {
        Place::Line(line) => {
            let section = text.lines().take(line).filter(|line| line.starts_with('[')).last().unwrap_or_default();
            format!("{section} {}", text.lines().nth(line).unwrap_or_default())
        }
        Place::File => String::new(),
    };
    let others: Vec<_> = found.iter().map(|finding| (finding.problem.rule.id, finding.line)).take(5).collect();
    Some(format!("{rule} at {place:?} {line:?}; found {others:?}"))
}

#[test]
fn no_rule_lacks_a_damage() {
    let damaged: Vec<&str> =
        damages().iter().map(|(id, _)| *id).chain(xml::DAMAGES.iter().map(|(id, _)| *id)).collect();
    let all: BTreeSet<&str> = rules::all().map(|rule| rule.id).collect();
    assert_eq!(damaged.iter().copied().collect::<BTreeSet<_>>(), all);
    assert_eq!(damaged.len(), all.len());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 8, max_shrink_iters: 0, ..ProptestConfig::default() })]

    #[test]
    fn what_is_right_is_spared(seed in any::<u64>()) {
        for is_configuration in [false, true] {
            let text = right::right(&mut Dice(seed), is_configuration);
            let found: Vec<String> = findings(text.as_bytes()).iter().map(|finding| finding.problem.to_string()).collect();
            prop_assert!(found.is_empty(), "{found:#?}\n{text}");
        }
    }

    #[test]
    fn each_rule_finds_a_random_damage(seed in any::<u64>()) {
        let files = [false, true].map(|is_configuration| right::right(&mut Dice(seed), is_configuration));
        let (mut wrong, mut untried) = (Vec::new(), Vec::new());
        for (rule, damage) in damages() {
            let mut dice = Dice(seed ^ 1);
            let tried: Vec<_> = files.iter().filter_map(|text| damage.of(text, &mut dice)).collect();
            if tried.is_empty() {
                untried.push(rule);
            }
            wrong.extend(tried.iter().filter_map(|(bytes, place)| missed(rule, bytes, *place)));
        }
        prop_assert!(wrong.is_empty(), "{wrong:#?}");
        prop_assert!(untried.is_empty(), "{untried:?}");
    }

    #[test]
    fn each_rule_of_xml_finds_a_random_damage(seed in any::<u64>()) {
        let text = right::right(&mut Dice(seed), seed.is_multiple_of(2));
        let xml = xdd::write(&DeviceDescription::read(text.as_bytes()).unwrap()).0;
        let found: Vec<String> = findings(xml.as_bytes()).iter().map(|finding| finding.problem.to_string()).collect();
        prop_assert!(found.is_empty(), "{found:#?}");
        for (rule, damage) in xml::DAMAGES {
            let mut damaged = xml.clone();
            let line = damage(&mut damaged, &mut Dice(seed ^ 1)).unwrap();
            let missed = missed(rule, damaged.as_bytes(), Place::Line(line));
            prop_assert!(missed.is_none(), "{missed:?}");
        }
    }
}

/// The built-in models under another file name, with the findings that they have anyway.
fn models() -> Vec<(String, String)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../conformance/device/models");
    let paths = std::fs::read_dir(folder).unwrap().map(|file| file.unwrap().path());
    let read = |path: std::path::PathBuf| {
        let name = path.file_name()?.to_string_lossy().into_owned();
        let text = name.ends_with(".eds").then(|| std::fs::read_to_string(&path).unwrap())?;
        Some((name.clone(), text.replace(&format!("FileName={name}"), &format!("FileName={NAME}"))))
    };
    paths.filter_map(read).collect()
}

#[test]
fn each_rule_finds_a_random_damage_of_the_models() {
    let mut wrong = Vec::new();
    let mut tried: BTreeMap<&str, usize> = BTreeMap::new();
    for (name, text) in models() {
        let before = findings(text.as_bytes());
        for (number, (rule, damage)) in (1..).zip(damages()) {
            // If the model breaks the rule anyway, the damage can't be distinguished.
            if before.iter().any(|finding| finding.problem.rule.id == rule) {
                continue;
            }
            let Some((bytes, place)) = damage.of(&text, &mut Dice(number)) else { continue };
            *tried.entry(rule).or_default() += 1;
            wrong.extend(missed(rule, &bytes, place).map(|missed| format!("{name}: {missed}")));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(tried.len() > 80, "{}", tried.len());
}
