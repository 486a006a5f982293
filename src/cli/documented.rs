//! Test: the program accepts every command that the documentation prints.

use super::*;
use clap::error::ErrorKind;
use std::fs;
use std::path::{Path, PathBuf};

/// Values for variables of a pipeline whose form the program checks.
const VARIABLES: [(&str, &str); 3] = [("$CI_MERGE_REQUEST_IID", "7"), ("$SPAN", "3m"), ("${FUZZ_FOR:-3m}", "3m")];
/// A page in which lines of code begin with the program's name without being commands.
const DRAWINGS: &str = "architecture.md";

fn pages() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let docs = fs::read_dir(root.join("docs")).unwrap().map(|entry| entry.unwrap().path());
    let top = ["README.md", "CONTRIBUTING.md", "SECURITY.md"].map(|name| root.join(name));
    let is_page = |path: &PathBuf| path.extension().is_some_and(|extension| extension == "md");
    docs.filter(is_page).filter(|path| !path.ends_with(DRAWINGS)).chain(top).collect()
}

/// The commands in the code blocks of a page, each as one line.
fn commands(page: &str) -> Vec<String> {
    let mut commands = Vec::new();
    for block in page.split("\n```").skip(1).step_by(2) {
        let folded = block.replace("\\\n", " ");
        let mut lines = folded.lines().peekable();
        while let Some(line) = lines.next() {
            let depth = line.len() - line.trim_start().len();
            // YAML folds the lines below `>` of the same depth into the command.
            let is_folded = line.trim_end().ends_with("- >");
            let bare = line.trim().trim_start_matches("$ ").trim_start_matches("- ").trim_start_matches("run: ");
            let mut command = if is_folded { String::new() } else { bare.to_owned() };
            while let Some(more) = lines.next_if(|more| is_folded && more.len() - more.trim_start().len() > depth) {
                command = format!("{command} {}", more.trim());
            }
            // In printed reports the name stands in a column of its own, followed by more than one space.
            let is_command = |command: &String| command.starts_with("canvass ") && !command.starts_with("canvass  ");
            commands.extend(Some(command.trim().to_owned()).filter(is_command));
        }
    }
    commands
}

/// The words of a command, without the shell's operators and comments.
fn words(command: &str) -> Vec<String> {
    let command = VARIABLES.iter().fold(command.to_owned(), |text, (name, value)| text.replace(name, value));
    let command = command.split("     ").next().unwrap_or_default();
    let (mut words, mut word, mut quote) = (Vec::new(), String::new(), None);
    for c in command.chars().chain([' ']) {
        match (c, quote) {
            ('\'' | '"', None) => quote = Some(c),
            (c, Some(open)) if c == open => quote = None,
            (' ', None) if !word.is_empty() => words.push(std::mem::take(&mut word)),
            (' ', None) => {}
            (c, _) => word.push(c),
        }
    }
    let is_own = |word: &String| !["||", "|", ">", ">>", "#", "&"].contains(&word.as_str());
    words.into_iter().take_while(is_own).collect()
}

/// The error with which the program refuses a command of a page. With `bus_is_named`, the page has set the bus for its
/// commands.
fn mistake(command: &str, bus_is_named: bool) -> Option<clap::Error> {
    let mut words = words(command);
    let parsed = |words: &[String]| Cli::described().try_get_matches_from(words).err();
    let first = parsed(&words)?;
    if bus_is_named && first.kind() == ErrorKind::MissingRequiredArgument {
        words.insert(2, "can0".to_owned());
        return parsed(&words);
    }
    let is_help = matches!(first.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion);
    Some(first).filter(|_| !is_help)
}

#[test]
fn every_command_in_a_block_of_code_is_taken() {
    let mut count = 0;
    for path in pages() {
        let page = fs::read_to_string(&path).unwrap();
        let bus_is_named = page.contains(BUS_VARIABLE);
        for command in commands(&page) {
            count += 1;
            if let Some(mistake) = mistake(&command, bus_is_named) {
                panic!("{}: {command}\n{mistake}", path.display());
            }
        }
    }
    assert!(count > 60, "{count}");
}

/// Commands in running text contain placeholders, so the test checks only the names of commands and options, and
/// whether options exclude each other.
#[test]
fn every_command_in_the_text_is_known() {
    let mut count = 0;
    for path in pages() {
        let page = fs::read_to_string(&path).unwrap().replace('\n', " ");
        let quoted = page.split('`').skip(1).step_by(2).filter(|text| text.starts_with("canvass "));
        for command in quoted.filter(|command| !command.starts_with("canvass fleet")) {
            count += 1;
            // Takes the first of several alternatives.
            let first = |word: &str| word.split('|').next().unwrap_or_default().trim_end_matches('\\').to_owned();
            let command = command.split_whitespace().map(first).collect::<Vec<_>>().join(" ");
            if let Some(mistake) = mistake(&command, false) {
                let is_wrong = [ErrorKind::UnknownArgument, ErrorKind::InvalidSubcommand, ErrorKind::ArgumentConflict];
                assert!(!is_wrong.contains(&mistake.kind()), "{}: {command}\n{mistake}", path.display());
            }
        }
    }
    assert!(count > 60, "{count}");
}

#[test]
fn commands_are_found_in_all_their_forms() {
    let page = "x\n```yaml\n  - canvass decode a\n  script:\n    - >\n      canvass test\n      can0 --node 5\n    - run: canvass \
                decode \\\n  'b c' || x\n```\n`canvass decode d`\n```console\n$ canvass list cases\n```\n";
    let found: Vec<Vec<String>> = commands(page).iter().map(|command| words(command)).collect();
    let expected: [&[&str]; 4] = [
        &["canvass", "decode", "a"],
        &["canvass", "test", "can0", "--node", "5"],
        &["canvass", "decode", "b c"],
        &["canvass", "list", "cases"],
    ];
    assert_eq!(found, expected);
    assert!(mistake("canvass decode a --no-such-option", false).is_some());
    assert!(mistake("canvass test --node 5", false).is_some() && mistake("canvass test --node 5", true).is_none());
}
