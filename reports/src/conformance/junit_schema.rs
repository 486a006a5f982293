//! The JUnit document against its schema, with a device that calls itself whatever harms.
//!
//! Understands as much of XML Schema as `reports/tests/junit.xsd` uses.

use super::hostile::play;
use super::{Document, junit};
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use std::collections::BTreeMap;

const SCHEMA: &str = include_str!("../../tests/junit.xsd");

/// An element with its attributes and what is in it.
#[derive(Debug, Default)]
struct Element {
    name: String,
    attributes: BTreeMap<String, String>,
    children: Vec<Element>,
    text: String,
}

impl Element {
    fn of(start: &BytesStart<'_>) -> Self {
        let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
        let attributes = start.attributes().map(|attribute| {
            let attribute = attribute.unwrap();
            (text(attribute.key.as_ref()), quick_xml::escape::unescape(&text(&attribute.value)).unwrap().into_owned())
        });
        Self { name: text(start.name().as_ref()), attributes: attributes.collect(), ..Self::default() }
    }

    /// The root of a document.
    fn parse(xml: &str) -> Self {
        let mut reader = Reader::from_str(xml);
        let mut open = vec![Self::default()];
        loop {
            match reader.read_event().unwrap() {
                Event::Start(start) => open.push(Self::of(&start)),
                Event::Empty(start) => open.last_mut().unwrap().children.push(Self::of(&start)),
                Event::End(_) => {
                    let closed = open.pop().unwrap();
                    open.last_mut().unwrap().children.push(closed);
                }
                Event::Text(text) => open.last_mut().unwrap().text.push_str(&text.decode().unwrap()),
                Event::Eof => return open.pop().unwrap().children.pop().unwrap(),
                _ => {}
            }
        }
    }

    fn get(&self, attribute: &str) -> &str {
        self.attributes.get(attribute).map_or("", String::as_str)
    }

    fn child(&self, name: &str) -> Option<&Self> {
        self.children.iter().find(|child| child.name == name)
    }

    fn all(&self, name: &str) -> Vec<&Self> {
        let below = self.children.iter().flat_map(|child| child.all(name));
        (self.name == name).then_some(self).into_iter().chain(below).collect()
    }
}

/// What an element breaks of its declaration, in itself and below.
fn check(schema: &Element, element: &Element, wrong: &mut Vec<String>) {
    let declared = schema.children.iter().find(|it| it.name == "xs:element" && it.get("name") == element.name);
    let Some(declared) = declared else {
        wrong.push(format!("<{}> is not declared", element.name));
        return;
    };
    let Some(complex) = declared.child("xs:complexType") else {
        if !element.children.is_empty() || !element.attributes.is_empty() {
            wrong.push(format!("<{}> is text only", element.name));
        }
        return;
    };
    if complex.get("mixed") != "true" && !element.text.trim().is_empty() {
        wrong.push(format!("<{}> holds text", element.name));
    }
    attributes(schema, complex, element, wrong);
    let names: Vec<&str> = element.children.iter().map(|child| child.name.as_str()).collect();
    let used = complex
        .children
        .iter()
        .filter(|it| it.name != "xs:attribute")
        .try_fold(0, |at, particle| take(particle, &names[at..]).map(|used| at + used));
    if used != Some(names.len()) {
        wrong.push(format!("<{}> holds {names:?}", element.name));
    }
    element.children.iter().for_each(|child| check(schema, child, wrong));
}

fn attributes(schema: &Element, complex: &Element, element: &Element, wrong: &mut Vec<String>) {
    let declared: Vec<&Element> = complex.children.iter().filter(|it| it.name == "xs:attribute").collect();
    for attribute in &declared {
        match element.attributes.get(attribute.get("name")) {
            None if attribute.get("use") == "required" => {
                wrong.push(format!("<{}> lacks {}", element.name, attribute.get("name")));
            }
            Some(value) if !is_of(schema, attribute.get("type"), value) => {
                wrong.push(format!("{}=\"{value}\" of <{}>", attribute.get("name"), element.name));
            }
            _ => {}
        }
    }
    for name in element.attributes.keys().filter(|name| !declared.iter().any(|it| it.get("name") == **name)) {
        wrong.push(format!("<{}> has {name}", element.name));
    }
}

fn is_of(schema: &Element, kind: &str, value: &str) -> bool {
    match kind {
        "xs:string" | "xs:token" => true,
        "xs:int" => value.parse::<i32>().is_ok(),
        "xs:decimal" => value.bytes().all(|byte| byte.is_ascii_digit() || byte == b'.'),
        own => {
            let declared =
                schema.children.iter().find(|it| it.name == "xs:simpleType" && it.get("name") == own).unwrap();
            let restriction = declared.child("xs:restriction").unwrap();
            is_of(schema, restriction.get("base"), value)
                && restriction.children.iter().all(|facet| match facet.name.as_str() {
                    "xs:minLength" => value.len() >= facet.get("value").parse().unwrap(),
                    _ => fits(facet.get("value"), value),
                })
        }
    }
}

/// Patterns of digits, with `{n}` and `+`, and of characters that stand for themselves.
fn fits(pattern: &str, value: &str) -> bool {
    let mut rest = value;
    let mut pattern = pattern;
    while !pattern.is_empty() {
        if let Some(after) = pattern.strip_prefix("[0-9]") {
            let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
            let (count, after) = match after.strip_prefix('{') {
                Some(count) => {
                    let (count, after) = count.split_once('}').unwrap();
                    (count.parse().unwrap(), after)
                }
                None => (digits.max(1), after.strip_prefix('+').unwrap()),
            };
            if digits < count {
                return false;
            }
            (rest, pattern) = (&rest[count..], after);
        } else {
            let literal = pattern.strip_prefix('\\').unwrap_or(pattern);
            let Some(after) = rest.strip_prefix(&literal[..1]) else { return false };
            (rest, pattern) = (after, &literal[1..]);
        }
    }
    rest.is_empty()
}

/// How many of the names a sequence, choice or element takes; `None` if it can't be satisfied.
fn take(particle: &Element, names: &[&str]) -> Option<usize> {
    let least = if particle.get("minOccurs") == "0" { 0 } else { 1 };
    let most = if particle.get("maxOccurs") == "unbounded" { usize::MAX } else { 1 };
    let once = |names: &[&str]| match particle.name.as_str() {
        "xs:element" => (names.first() == Some(&particle.get("ref"))).then_some(1),
        "xs:choice" => particle.children.iter().find_map(|child| take(child, names).filter(|&used| used > 0)),
        _ => particle.children.iter().try_fold(0, |at, child| take(child, &names[at..]).map(|used| at + used)),
    };
    let (mut at, mut times) = (0, 0);
    while times < most
        && let Some(used) = once(&names[at..]).filter(|&used| used > 0)
    {
        (at, times) = (at + used, times + 1);
    }
    let empty = particle.name == "xs:sequence" && once(&[]) == Some(0);
    (times >= least || empty).then_some(at)
}

fn document() -> String {
    let mut out = Vec::new();
    play(&mut Document::new(&mut out, junit::render));
    String::from_utf8(out).unwrap()
}

fn wrong_with(xml: &str) -> Vec<String> {
    let mut wrong = Vec::new();
    check(&Element::parse(SCHEMA), &Element::parse(xml), &mut wrong);
    wrong
}

#[test]
fn the_document_is_valid() {
    let xml = document();
    assert_eq!(wrong_with(&xml), Vec::<String>::new(), "{xml}");
}

#[test]
fn the_counts_are_right() {
    let root = Element::parse(&document());
    let sum = |attribute: &str| -> usize {
        root.children.iter().map(|suite| suite.get(attribute).parse::<usize>().unwrap()).sum()
    };
    assert_eq!(
        (sum("tests"), sum("failures"), sum("errors"), sum("skipped")),
        (7, 1, 1, 2),
        "one that could not be run is in quarantine"
    );
    assert_eq!((root.all("testcase").len(), root.all("failure").len(), root.all("error").len()), (7, 1, 1));
    assert_eq!(root.children.iter().map(|suite| suite.get("id")).collect::<Vec<_>>()[0], "0");
    // What both schemas have no place for in a case that passes stands in the output of its suite.
    let output: String = root.all("system-out").iter().map(|output| output.text.as_str()).collect();
    assert!(output.contains("tolerated: ") && output.contains("waiver: "), "{output}");
}

/// A check that finds nothing wrong must be able to.
#[test]
fn what_is_not_valid_is_found() {
    let xml = document();
    for (from, to) in [
        ("<properties>", "<properties><oops/>"),
        (" hostname=\"localhost\"", ""),
        (" hostname=\"localhost\"", " hostname=\"\""),
        (" package=\"canvass\"", " package=\"canvass\" disabled=\"0\""),
        ("<system-err/>", ""),
        ("<system-err/>", "<system-err/><properties></properties>"),
        ("T00:00:00\"", "T00:00:00Z\""),
        ("<testcase ", "<testcase time=\"soon\" "),
        ("type=\"fail\"", "kind=\"fail\""),
    ] {
        let changed = xml.replacen(from, to, 1);
        assert!(changed != xml, "{from}: {xml}");
        // A second attribute of the same name is no XML at all.
        let wrong = std::panic::catch_unwind(|| wrong_with(&changed)).unwrap_or_else(|_| vec!["no XML".to_owned()]);
        assert!(!wrong.is_empty(), "{from} -> {to}");
    }
}
