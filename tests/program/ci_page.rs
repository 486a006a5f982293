//! The recipes of docs/ci.md: what stands there works.

use crate::running::run;
use std::path::Path;
use std::process::Command;

const PAGE: &str = include_str!("../../docs/ci.md");

/// A node that starts, is started, and sends heartbeats.
const GOOD: &str = "\
(1.000000) can0 705#00
(1.100000) can0 000#0105
(1.200000) can0 705#05
(1.300000) can0 705#05
(1.400000) can0 705#05
";

/// The same, with an error that the node reports.
const BAD: &str = "(1.500000) can0 085#1042090000000000\n";

/// The commands in the code of the page that judge captures, with the lines that they go on in.
fn commands() -> Vec<String> {
    all_commands().into_iter().filter(|command| command.starts_with("canvass diagnose ")).collect()
}

fn all_commands() -> Vec<String> {
    let code = PAGE.split("```").skip(1).step_by(2).map(|block| block.replace("\\\n", " ")).collect::<Vec<_>>();
    let lines = code.iter().flat_map(|block| block.lines());
    let bare = lines.map(|line| line.trim().trim_start_matches("- ").trim_start_matches("run: "));
    bare.filter(|line| line.starts_with("canvass ")).map(str::to_owned).collect()
}

/// What a shell gives of a command, in a folder with that capture.
fn status(command: &str, capture: &str) -> Option<i32> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("bench.log"), capture).unwrap();
    let program = Path::new(env!("CARGO_BIN_EXE_canvass")).parent().unwrap();
    let path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap());
    let mut shell = Command::new("sh");
    shell.args(["-ec", command]).current_dir(folder.path()).env("PATH", path);
    shell.env("GITHUB_STEP_SUMMARY", folder.path().join("summary.md"));
    shell.output().unwrap().status.code()
}

#[test]
fn every_command_of_the_recipes_works() {
    let commands = commands();
    assert!(commands.len() >= 8, "{commands:?}");
    for command in &commands {
        assert_eq!(status(command, GOOD), Some(0), "{command}");
        let judges = !command.contains("--fail-on never") && !command.contains("||");
        assert_eq!(status(command, &format!("{GOOD}{BAD}")), Some(i32::from(judges)), "{command}");
        assert_eq!(
            status(command, "no capture at all\n"),
            Some(if command.contains("||") { 1 } else { 2 }),
            "{command}"
        );
    }
}

/// The commands of one recipe, one after the other: findings end the job, and only they.
#[test]
fn each_recipe_fails_for_findings() {
    for name in ["GitHub Actions", "GitLab"] {
        let recipe = PAGE.split("\n## ").find(|part| part.starts_with(name)).unwrap();
        let own: Vec<String> = commands().into_iter().filter(|command| recipe.contains(command.as_str())).collect();
        assert!(own.len() >= 3, "{name}: {own:?}");
        assert_eq!(status(&own.join("\n"), GOOD), Some(0), "{name}");
        assert_eq!(status(&own.join("\n"), &format!("{GOOD}{BAD}")), Some(1), "{name}");
    }
}

/// The commands that the text and the code name.
#[test]
fn what_the_page_names_is_known() {
    let text = PAGE.split('`').filter(|text| text.starts_with("canvass ") && !text.contains('\n'));
    for command in text.map(str::to_owned).chain(all_commands()) {
        let name = command.split_whitespace().nth(1).unwrap();
        let help = run(&[name, "--help"]);
        assert_eq!(help.status, 0, "{command}");
        for option in command.split_whitespace().filter(|word| word.starts_with("--")) {
            assert!(help.stdout.contains(option), "{command}: {option} is unknown");
        }
    }
}
