//! The tree of every text gives the bytes back, with each part at its place.

use super::*;
use proptest::prelude::*;
use std::path::Path;

/// The text printed from its tree: names, values and everything between them, one after the other.
fn printed(source: &Source<'_>) -> String {
    let mut text = String::new();
    let mut at = 0;
    let mut print = |span: Span| {
        text.push_str(source.text.get(at..span.range().start).expect("things stand in order"));
        text.push_str(source.get(span));
        at = span.range().end;
    };
    for section in source.elements() {
        print(section.name_span());
        for field in section.all_fields() {
            print(field.name_span());
            print(field.value_span());
        }
    }
    print(Span::new(source.text.len(), source.text.len()));
    text
}

fn check(bytes: &[u8]) {
    for format in [Format::Ini, Format::Xml] {
        let source = Source::read_as(format, bytes).unwrap();
        assert_eq!(printed(&source), source.text);
        assert_eq!(source.to_bytes(), bytes);
        for (place, _) in source.text.char_indices().step_by(7) {
            let (line, column) = source.position(place);
            assert!(source.whole_line(line).contains(&place) && column > 0);
            if let Some(section) = source.section_at(place) {
                assert!(section.whole().touches(place) && section.lines().contains(&line));
                assert!(section.field_at(place).is_none_or(|field| field.line() == line));
            }
        }
        let number = source.elements().flat_map(Section::all_fields).count();
        assert_eq!(number, source.tree.fields.len(), "each field is of one section");
    }
}

/// All descriptions of the project, including files of other programs.
#[test]
fn each_sample_is_given_back() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut folders = vec![root.join("tests"), root.join("../conformance"), root.join("../tests")];
    let mut samples = 0;
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let ending = path.extension().unwrap_or_default().to_string_lossy().into_owned();
            if path.is_dir() && !path.is_symlink() {
                folders.push(path);
            } else if ["eds", "dcf", "xdd", "xdc"].contains(&&*ending) {
                check(&std::fs::read(path).unwrap());
                samples += 1;
            }
        }
    }
    assert!(samples > 100, "{samples}");
}

#[test]
fn sections_and_fields_stand_where_they_are() {
    let text = "x=0\n ;c\n[ A ] ; b\n Name = v w \nname=2\nempty=\n[a]\nz=1\r[2000\nü = ä\0";
    let source = Source::of_text(text);
    let shown: Vec<_> = source
        .elements()
        .map(|section| {
            (section.name(), section.all_fields().map(|field| source.get(field.whole())).collect::<Vec<_>>())
        })
        .collect();
    let expected = [("A", vec!["Name = v w", "name=2", "empty="]), ("a", vec!["z=1"]), ("2000", vec!["ü = ä"])];
    assert_eq!(shown, expected);
    let firsts: Vec<_> = source.sections().map(|section| (section.name(), section.fields().count())).collect();
    assert_eq!(firsts, [("A", 2), ("2000", 1)]);
    assert_eq!(source.comments().map(|comment| source.get(comment)).collect::<Vec<_>>(), [";c"]);
    assert_eq!(source.elements().map(|section| source.get(section.whole()).len()).sum::<usize>(), text.len() - 8);
}

#[test]
fn elements_and_attributes_stand_where_they_are() {
    let text = "<a>\n <p:b x='1' y = \"2 > 1\"\n z='&lt;'/><!--c--> t<b/>\n</a>";
    let source = Source::of_text(text);
    let shown: Vec<_> = source.elements().map(|element| (element.name(), source.get(element.whole()))).collect();
    let b = "<p:b x='1' y = \"2 > 1\"\n z='&lt;'/>";
    assert_eq!(shown, [("a", text), ("b", b), ("b", "<b/>")]);
    let root = source.elements().next().unwrap();
    assert_eq!((root.text(), root.inside().count()), ("t", 2));
    let fields = |field: Field<'_>| (field.name().to_owned(), field.value().to_owned(), source.get(field.value_span()));
    let of_b: Vec<_> = root.inside().next().unwrap().fields().map(fields).collect();
    let own = |name: &str, value: &str| (name.to_owned(), value.to_owned());
    let flat: Vec<_> = of_b.iter().map(|(name, value, _)| (name.clone(), value.clone())).collect();
    assert_eq!(flat, [own("x", "1"), own("y", "2 > 1"), own("z", "<")]);
    assert_eq!(of_b.iter().map(|(.., written)| *written).collect::<Vec<_>>(), ["1", "2 > 1", "&lt;"]);
}

/// A problem of a field with neither value nor name is placed at the line.
#[test]
fn each_place_shows_something() {
    let source = Source::of_text("[a]\nname=value\nname=\n=value\n=\n");
    let section = source.section("a").unwrap();
    let shown = |place: Place<'_>| match place.spot {
        Spot::Exact(span) => source.get(span).to_owned(),
        _ => format!("line {}", place.line),
    };
    let values: Vec<_> = section.all_fields().map(|field| shown(field.place())).collect();
    assert_eq!(values, ["value", "name", "value", "line 5"]);
    let names: Vec<_> = section.all_fields().map(|field| shown(field.place_of_name())).collect();
    assert_eq!(names, ["name", "name", "line 4", "line 5"]);
}

/// The first field of a name counts also in a section with many fields.
#[test]
fn the_first_of_many_fields_counts() {
    let fields: String = (0..40).map(|number| format!("{}=x\nDataType={number}\n", number % 20)).collect();
    let source = Source::of_text(format!("[a]\n{fields}"));
    let section = source.section("A").unwrap();
    assert_eq!((section.all_fields().count(), section.fields().count()), (80, 21));
    assert_eq!(section.field(FieldName::DataType).map(Field::value), Some("0"));
}

proptest! {
    #[test]
    fn random_bytes_are_given_back(bytes in prop::collection::vec(any::<u8>(), 0..300), mark in 0..4_usize) {
        let mark: &[u8] = [&b""[..], b"\xEF\xBB\xBF", b"\xFF\xFE", b"\xFE\xFF"][mark];
        check(&[mark, &bytes].concat());
    }

    #[test]
    fn random_lines_are_given_back(text in "(\\[|\\]|=|;|#|//|<<<<<<< | |\t|\r|\n|\r\n|\0|é|[a-c]){0,60}") {
        check(text.as_bytes());
    }

    #[test]
    fn random_elements_are_given_back(
        text in "(<a|<b:c|/>|>|</a>|</b:c>| x=| y =|'|\"|&lt;|&|<!--|-->|<!\\[CDATA\\[|\\]\\]>|\n|é|[a-c ]){0,40}"
    ) {
        check(text.as_bytes());
    }
}
