//! Every form contains the whole document, and neutralises control characters and markup in its texts.

use super::*;

const HOSTILE: &str = "\x1b[2J<script>|`\u{202e}```";

struct Example;

impl Report for Example {
    fn document(&self, depth: Depth) -> Document {
        let code = Code { title: "the log", language: "text", text: format!("{HOSTILE}\n601#40") };
        let row = Row { data: vec![("case", HOSTILE.to_owned())], ..Row::of(["7", HOSTILE]) };
        let table = Table { is_framed: depth == Depth::Screen, ..Table::of(["number", HOSTILE], [row]) };
        let finding = Finding {
            tone: Tone::Bad,
            badge: "violation".to_owned(),
            title: HOSTILE.to_owned(),
            id: "rule/id".to_owned(),
            body: vec![Block::Facts(vec![fact("expected", "silence"), fact("found", HOSTILE)]), Block::Code(code)],
            ..Finding::default()
        };
        let fold = Block::fold(HOSTILE, vec![Block::Note("careful".to_owned())]);
        let lists = Block::Items(vec![HOSTILE.to_owned()]);
        let blocks = vec![Block::Finding(finding), Block::Table(table), fold, lists, Block::Text(HOSTILE.to_owned())];
        Document {
            command: "example",
            title: HOSTILE.to_owned(),
            outcome: "1 violation".to_owned(),
            facts: vec![fact("seed", &7), fact("bus", HOSTILE)],
            sections: vec![Section { id: "all", title: HOSTILE.to_owned(), blocks }],
            ..Document::default()
        }
    }

    fn json(&self, _: &mut dyn Write) -> io::Result<()> {
        Ok(())
    }
}

fn written(form: Form) -> String {
    let mut out = Vec::new();
    Example.write(form, &mut out).unwrap();
    String::from_utf8(out).unwrap()
}

const TEXT: Form = Form::Text(Style { color: false, width: None });

#[test]
fn every_form_says_all_of_it_and_harms_nobody() {
    for form in [TEXT, Form::Markdown, Form::Html] {
        let text = written(form);
        for told in ["violation", "rule/id", "silence", "601#40", "careful", "seed", "number"] {
            assert!(text.to_lowercase().contains(told), "{form:?} lacks {told}: {text}");
        }
        assert!(!text.contains(|c| c != '\n' && crate::escape::acts(c)), "{form:?}: {text}");
    }
    assert!(!written(Form::Html).contains("<script>|"));
    let markdown = written(Form::Markdown);
    assert!(markdown.contains("\n````text\n"), "a longer fence than any inside: {markdown}");
    let is_markup = |line: &&str| line.contains("<script>") && !line.starts_with("\\x1B[2J<script>|`");
    assert_eq!(markdown.lines().find(is_markup), None);
}

#[test]
fn a_terminal_shows_the_outcome_last() {
    let text = written(TEXT);
    let (before, after) = text.split_once("\n1 violation\n").unwrap();
    assert!(before.contains("violation  ") && before.contains("  expected  silence\n"), "{text}");
    assert!(after.starts_with("seed         7\n"), "{text}");
}

#[test]
fn a_badge_is_painted_where_colours_are_wanted() {
    let text = written(Form::Text(Style { color: true, width: None }));
    assert!(text.contains("\x1b[31mviolation\x1b[0m  \\x1B[2J"), "{text}");
}

#[test]
fn columns_are_as_wide_as_their_cells() {
    let columns = [Column::new("case"), Column::new("empty"), Column::right("count")];
    let mut table = Table::new(columns, [Row::of(["a", "", "7"]), Row::of(["long", "", "120"])]);
    table.rows.push(Row { lines: vec!["a line of its own".to_owned()], ..Row::default() });
    let sections = vec![Section { blocks: vec![Block::Table(table)], ..Section::default() }];
    let mut out = Vec::new();
    text::render(&Document { sections, ..Document::default() }, Style::default(), &mut out).unwrap();
    let text = String::from_utf8(out).unwrap();
    assert!(text.starts_with("a       7\nlong  120\na line of its own\n"), "{text}");
}
