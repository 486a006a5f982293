//! The examples of `docs/json.md` and `docs/outputs.md` equal the output of the program.

use crate::running::run;
use serde_json::Value;

/// The commands of the page, each with its printed output.
fn examples(page: &str) -> Vec<(String, String)> {
    let mut examples: Vec<(String, String)> = Vec::new();
    let blocks = page.split("```console\n").skip(1).filter_map(|rest| rest.split("```").next());
    for line in blocks.flat_map(str::lines) {
        match line.strip_prefix("$ canvass ") {
            Some(command) => examples.push((command.to_owned(), String::new())),
            None => {
                let shown = &mut examples.last_mut().expect("a command comes first").1;
                shown.push_str(line);
                shown.push('\n');
            }
        }
    }
    examples
}

fn page(name: &str) -> String {
    std::fs::read_to_string(format!("{}/docs/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

/// JSON documents one after the other.
fn documents(text: &str) -> Vec<Value> {
    serde_json::Deserializer::from_str(text).into_iter().collect::<Result<_, _>>().unwrap()
}

/// Whether the output contains all values that the page shows, in the same places; lists may have further items.
fn holds(whole: &Value, shown: &Value) -> bool {
    match (whole, shown) {
        (Value::Object(whole), Value::Object(shown)) => {
            shown.iter().all(|(key, value)| whole.get(key).is_some_and(|found| holds(found, value)))
        }
        (Value::Array(whole), Value::Array(shown)) => follow(whole, shown),
        _ => whole == shown,
    }
}

fn follow(whole: &[Value], shown: &[Value]) -> bool {
    let mut rest = whole.iter();
    shown.iter().all(|value| rest.any(|found| holds(found, value)))
}

#[test]
fn the_examples_of_the_contract_are_real() {
    let page = page("json.md");
    let examples = examples(&page);
    assert_eq!(examples.len(), page.lines().filter(|line| line.starts_with("$ canvass ")).count());
    assert!(!examples.is_empty());
    for (command, shown) in examples {
        let ended = run(&command.split(' ').collect::<Vec<_>>());
        assert_eq!(ended.status, 0, "{command}: {}", ended.stderr);
        let (whole, shown) = (documents(&ended.stdout), documents(&shown));
        for value in &shown {
            assert!(whole.iter().any(|found| holds(found, value)), "{command} does not print {value}");
        }
        assert!(follow(&whole, &shown), "{command} prints in another order");
    }
}

#[test]
fn the_examples_of_the_rows_are_real() {
    let examples = examples(&page("outputs.md"));
    assert!(!examples.is_empty());
    for (command, shown) in examples {
        assert_eq!(run(&command.split(' ').collect::<Vec<_>>()).stdout, shown, "{command}");
    }
}

/// An array of rows has no place for the name of its schema.
#[test]
fn every_output_but_arrays_names_its_schema() {
    for command in [
        &["decode", "--format", "json", "docs/examples/commissioning.log"][..],
        &["decode", "--events", "--format", "json", "docs/examples/commissioning.log"],
        &["signals", "--format", "json", "docs/examples/commissioning.log"],
        &["test", "sim:kuebler-sendix-58x8", "--select", "301/nmt/back-to-back", "--format", "json"],
    ] {
        let printed = documents(&run(command).stdout);
        let schema = printed.first().and_then(|first| first["schema"].as_str());
        assert!(schema.is_some_and(|schema| schema.starts_with("canvass/")), "{command:?}: {schema:?}");
    }
}
