//! The tests that are left out on Windows: items with `cfg(unix)`, whose line gives the reason.

use anyhow::{Context, Result, bail};
use std::path::Path;

/// Tests that are left out for the same reason.
pub struct Group {
    pub reason: String,
    pub tests: Vec<String>,
}

/// The left-out tests of a folder with a `main.rs`.
///
/// # Errors
/// If a test is left out without a reason.
pub fn read(folder: &str) -> Result<Vec<Group>> {
    let read = |name: &str| {
        let path = Path::new(folder).join(name);
        std::fs::read_to_string(&path).with_context(|| path.display().to_string())
    };
    let mut groups = Vec::new();
    let main = read("main.rs")?;
    for (reason, module) in behind_cfg(&main, "mod ")? {
        let source = read(&format!("{module}.rs"))?;
        let tests = tests(&source);
        groups.push(Group { reason, tests: tests.iter().map(|test| format!("{module}::{test}")).collect() });
    }
    let is_whole = |module: &str| groups.iter().any(|group| group.tests.iter().any(|test| test.starts_with(module)));
    let modules = main.lines().filter_map(|line| line.strip_prefix("mod ")?.strip_suffix(';'));
    let others: Vec<&str> = modules.filter(|module| !is_whole(&format!("{module}::"))).collect();
    for module in others {
        for (reason, test) in behind_cfg(&read(&format!("{module}.rs"))?, "fn ")? {
            groups.push(Group { reason, tests: vec![format!("{module}::{test}")] });
        }
    }
    Ok(groups)
}

/// The names of all tests of a file.
fn tests(source: &str) -> Vec<&str> {
    let lines: Vec<&str> = source.lines().map(str::trim_start).collect();
    let is_test = |at: usize| lines.get(at).is_some_and(|line| *line == "#[test]");
    (0..lines.len())
        .filter(|&at| is_test(at))
        .filter_map(|at| lines.iter().skip(at).find_map(|line| name(line, "fn ")))
        .collect()
}

/// The reason and the name of each item with `cfg(unix)` that has a reason. A test or a module without a reason is an
/// error.
fn behind_cfg(source: &str, declared: &str) -> Result<Vec<(String, String)>> {
    let lines: Vec<&str> = source.lines().collect();
    let mut found = Vec::new();
    for (at, line) in lines.iter().enumerate() {
        let cfg = line.starts_with("#[cfg(unix)]");
        let Some(name) = lines.iter().skip(at).find_map(|line| name(line, declared)).filter(|_| cfg) else { continue };
        let until = lines.iter().skip(at).take_while(|line| self::name(line, declared).is_none());
        let is_test = declared == "mod " || until.clone().any(|line| line.trim() == "#[test]");
        match line.split_once("// ") {
            Some((_, reason)) => found.push((reason.to_owned(), name.to_owned())),
            None if is_test => {
                bail!("{name} is left out on Windows: expected the reason behind cfg(unix), as a comment")
            }
            None => {}
        }
    }
    Ok(found)
}

fn name<'a>(line: &'a str, declared: &str) -> Option<&'a str> {
    line.trim_start().strip_prefix(declared)?.split(['(', ';', '<', ' ']).next()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_test_that_is_left_out_says_why() {
        let source = "#[cfg(unix)] // it needs a signal\n#[test]\nfn waits() {}\n#[test]\nfn goes_on() {}\n#[cfg(unix)]\nfn tool() {}\n";
        assert_eq!(behind_cfg(source, "fn ").unwrap(), [("it needs a signal".to_owned(), "waits".to_owned())]);
        assert_eq!(super::tests(source), ["waits", "goes_on"]);
        let silent = behind_cfg("#[cfg(unix)]\n#[test]\nfn waits() {}\n", "fn ").unwrap_err().to_string();
        assert!(silent.starts_with("waits is left out"), "{silent}");
    }

    #[test]
    fn the_tests_of_the_program_are_read() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/program");
        let groups = read(folder).unwrap();
        let has = |test: &str| groups.iter().any(|group| group.tests.iter().any(|name| name == test));
        assert!(has("terminals::a_dumb_terminal_gets_no_sequences"));
        assert!(has("killed::at_a_terminal_the_next_run_asks_whether_to_put_the_device_back"));
        assert!(groups.iter().all(|group| !group.reason.is_empty() && !group.tests.is_empty()));
    }
}
