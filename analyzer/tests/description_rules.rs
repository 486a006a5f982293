//! Each rule of device descriptions finds its failing example, laid over every built-in model, and has no finding for
//! its passing example.

// `cfg(test)` changes nothing here, but tells clippy that a test may unwrap.
#![cfg(test)]

use canvass_analyzer::dictionary::check::{Folder, check, check_in};
use canvass_analyzer::dictionary::rules::{self, Rule};
use canvass_analyzer::dictionary::{DeviceDescription, Severity};
use std::path::Path;

#[path = "description_rules/overlay.rs"]
mod overlay;
use overlay::overlay;

const NAME: &str = "example.eds";

/// The name and text of each built-in model. The first one is without fault.
fn models() -> Vec<(String, String)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../conformance/device/models");
    let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|file| file.unwrap().path()).collect();
    files.retain(|path| path.extension().is_some_and(|extension| extension == "eds"));
    files.sort_by_key(|path| !path.ends_with("reference-406.eds"));
    let read = |path: &Path| {
        let text = String::from_utf8(std::fs::read(path).unwrap()).unwrap();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        (name.clone(), text.replace(&format!("FileName={name}"), &format!("FileName={NAME}")))
    };
    files.iter().map(|path| read(path)).collect()
}

/// The folder of the files, with a file to download and the EDS of another device.
struct Beside;

impl Folder for Beside {
    fn has(&self, name: &str) -> bool {
        name == "program.bin"
    }

    fn read(&self, name: &str) -> Option<Vec<u8>> {
        let text = "[OptionalObjects]\nSupportedObjects=1\n1=0x1FFE\n[1FFE]\nParameterName=Another\nDataType=0x0005\nAccessType=ro\n";
        (name == "another.eds").then(|| text.as_bytes().to_vec())
    }
}

fn found(bytes: &[u8]) -> Vec<&'static str> {
    let checked = check_in(bytes, Some(NAME), Some(&Beside)).unwrap();
    assert!(checked.description.is_ok(), "{:?}", checked.description.err());
    checked.findings.iter().map(|finding| finding.problem.rule.id).collect()
}

/// The text with a damage that can't be laid over it as sections.
fn damaged(rule: &Rule, base: &str) -> Option<Vec<u8>> {
    Some(match rule.id {
        "eds/text/byte-order-mark" => [b"\xEF\xBB\xBF", base.as_bytes()].concat(),
        "eds/text/utf-16" => [0xFF, 0xFE].into_iter().chain(base.encode_utf16().flat_map(u16::to_le_bytes)).collect(),
        "eds/text/half-read" => format!("{base}\n{}", "text\n".repeat(base.lines().count())).into_bytes(),
        "eds/text/too-much" => format!("{base}{}", "\n".repeat(1_000_001)).into_bytes(),
        _ => return None,
    })
}

fn of_eds() -> impl Iterator<Item = &'static Rule> {
    rules::all().filter(|rule| rule.id.starts_with("eds/"))
}

#[test]
fn each_rule_finds_its_example_on_every_model() {
    let models = models();
    assert!(models.len() > 10);
    let mut missed = Vec::new();
    for rule in of_eds() {
        // A file of a million lines takes long, and the model makes no difference.
        let models = if rule.id == "eds/text/too-much" { &models[..1] } else { &models[..] };
        for (name, text) in models {
            let bytes = damaged(rule, text).unwrap_or_else(|| overlay(text, rule.fails).into_bytes());
            if !found(&bytes).contains(&rule.id) {
                missed.push(format!("{} on {name}", rule.id));
            }
        }
    }
    assert!(missed.is_empty(), "{missed:#?}");
}

#[test]
fn each_rule_spares_what_keeps_it() {
    let (_, reference) = &models()[0];
    let of = |text: &str, rule: &Rule| found(text.as_bytes()).into_iter().filter(|id| *id == rule.id).count();
    let mut wrong = Vec::new();
    for rule in of_eds().filter(|rule| damaged(rule, "").is_none()) {
        // The reference model itself has findings of severity hint.
        let before = of(reference, rule);
        if of(&overlay(reference, rule.passes), rule) > before || of(&overlay(reference, rule.fails), rule) <= before {
            wrong.push(rule.id);
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// A description in XML with this object.
fn xdd(object: &str) -> String {
    format!(
        "<?xml version=\"1.0\"?>\n<ISO15745ProfileContainer><ISO15745Profile><ProfileBody>\n<CANopenObjectList>\n\
         {object}\n</CANopenObjectList></ProfileBody></ISO15745Profile></ISO15745ProfileContainer>\n"
    )
}

#[test]
fn each_rule_of_xml_finds_its_example_and_spares_what_keeps_it() {
    let mut wrong = Vec::new();
    for rule in rules::all().filter(|rule| rule.id.starts_with("xdd/")) {
        let finds = |example: &str| found(xdd(example).as_bytes()).contains(&rule.id);
        if !finds(rule.fails) || finds(rule.passes) {
            wrong.push(rule.id);
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// No model has an error, except those whose manuals map 16 bits of an object of 32 bits.
#[test]
fn the_models_have_no_errors() {
    for (name, text) in models() {
        let checked = check(text.as_bytes(), Some(NAME)).unwrap();
        let errors: Vec<_> = checked.findings.iter().filter(|finding| finding.severity() == Severity::Error).collect();
        let errors: Vec<_> =
            errors.iter().map(|finding| (&*finding.problem.section, &*finding.problem.found)).collect();
        let by_manual: &[_] = match name.as_str() {
            "kuebler-sendix-f58.eds" => &[("1A03sub2", "2160h:00 with 16 bits")],
            "kuebler-c100.eds" => &[("1A00sub1", "6020h:00 with 16 bits"), ("1A00sub2", "6020h:00 with 16 bits")],
            _ => &[],
        };
        assert_eq!(errors, by_manual, "{name}");
        assert!(DeviceDescription::read(text.as_bytes()).is_ok());
    }
}

/// The line and column of each finding lie within the text, at the marked characters.
#[test]
fn places_are_those_of_the_text() {
    let (_, reference) = &models()[0];
    for rule in of_eds() {
        let text = overlay(reference, rule.fails);
        let checked = check(text.as_bytes(), Some(NAME)).unwrap();
        for finding in &checked.findings {
            let lines: Vec<&str> = text.split('\n').collect();
            let marked = checked.source.text.get(finding.span.clone()).unwrap();
            if finding.line > 0 {
                let line = lines[finding.line as usize - 1];
                let begin: String = line.chars().skip(finding.column as usize - 1).collect();
                assert!(begin.starts_with(marked), "{}: {marked:?} in {line:?}", rule.id);
            }
        }
    }
}
