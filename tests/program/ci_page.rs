//! The recipes of docs/ci.md work.

use crate::running::run;
use std::path::Path;
use std::process::Command;

const PAGE: &str = include_str!("../../docs/ci.md");

/// A node that boots, is started, and sends heartbeats.
const GOOD: &str = "\
(1.000000) can0 705#00
(1.100000) can0 000#0105
(1.200000) can0 705#05
(1.300000) can0 705#05
(1.400000) can0 705#05
";

/// A line in which the node reports an error.
const BAD: &str = "(1.500000) can0 085#1042090000000000\n";

/// The commands in the code of the page that judge captures, with their continuation lines.
fn commands() -> Vec<String> {
    all_commands().into_iter().filter(|command| command.starts_with("canvass diagnose ")).collect()
}

fn all_commands() -> Vec<String> {
    let code = PAGE.split("```").skip(1).step_by(2).map(|block| block.replace("\\\n", " ")).collect::<Vec<_>>();
    let lines = code.iter().flat_map(|block| block.lines());
    let bare = lines.map(|line| line.trim().trim_start_matches("- ").trim_start_matches("run: "));
    bare.filter(|line| line.starts_with("canvass ")).map(str::to_owned).collect()
}

/// The exit status of a command in a shell, in a folder with this capture.
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
    assert!(commands.len() >= 3, "{commands:?}");
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

/// The commands of one recipe, one after the other: the job fails for findings and for nothing else.
#[test]
fn each_recipe_fails_for_findings() {
    for name in ["GitHub Actions", "GitLab"] {
        let recipe = PAGE.split("\n## ").find(|part| part.starts_with(name)).unwrap().replace("\\\n", " ");
        let own: Vec<String> = commands().into_iter().filter(|command| recipe.contains(command.as_str())).collect();
        assert!(!own.is_empty(), "{name}");
        assert_eq!(status(&own.join("\n"), GOOD), Some(0), "{name}");
        assert_eq!(status(&own.join("\n"), &format!("{GOOD}{BAD}")), Some(1), "{name}");
    }
}

/// The program knows the commands and options in the text and the code of the page.
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

/// The script of the page.
fn script() -> &'static str {
    PAGE.split("```sh\n").nth(1).unwrap().split("```").next().unwrap()
}

/// A repository with the script, in which `canvass` runs the program; `of_test` is inserted before the arguments of
/// `test`.
struct Repository(tempfile::TempDir);

impl Repository {
    fn new(of_test: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
        write("conformance.sh", script());
        write("waivers.toml", "");
        write("firmware.eds", include_str!("../../conformance/device/models/reference-301.eds"));
        let program = env!("CARGO_BIN_EXE_canvass");
        let wrapper = format!(
            "#!/bin/sh\ncase $1 in test) shift; exec {program} test {of_test} \"$@\";; *) exec {program} \"$@\";; esac\n"
        );
        write("canvass", &wrapper);
        let made = Command::new("chmod").arg("+x").arg(folder.path().join("canvass")).status().unwrap();
        assert!(made.success());
        Self(folder)
    }

    /// Runs the script as a pipeline does.
    fn run(&self, bus: &str, firmware: &str) -> (Option<i32>, String) {
        let path = format!("{}:{}", self.0.path().display(), std::env::var("PATH").unwrap());
        let variables = [("CANVASS_BUS", bus), ("FIRMWARE", firmware), ("FUZZ_FOR", "300ms"), ("PATH", &path)];
        let mut shell = Command::new("sh");
        let ended = shell.arg("conformance.sh").current_dir(&self.0).envs(variables).output().unwrap();
        (ended.status.code(), String::from_utf8_lossy(&[ended.stdout, ended.stderr].concat()).into_owned())
    }

    fn accept(&self) {
        std::fs::copy(self.0.path().join("new.json"), self.0.path().join("release.json")).unwrap();
    }

    fn has(&self, files: &[&str]) {
        for file in files {
            assert!(self.0.path().join(file).metadata().is_ok_and(|file| file.len() > 0), "{file}");
        }
    }
}

const REPORTS: [&str; 9] = [
    "new.json",
    "test.xml",
    "test.html",
    "evidence.zip",
    "compare.xml",
    "compare.md",
    "fuzz.json",
    "fuzz.xml",
    "fuzz.html",
];

/// The first release has no earlier release to compare with. The same firmware passes again; a worse firmware fails,
/// and all its reports are written.
#[test]
fn the_script_of_the_pipelines_holds_up_a_bad_release() {
    let repository = Repository::new("--select 301/boot-up,301/identity");
    assert_eq!(repository.run("sim:reference-301", "").0, Some(1));
    repository.accept();
    let (status, said) = repository.run("sim:reference-301", "");
    assert_eq!(status, Some(0), "{said}");
    let (status, said) = repository.run("sim:reference-301+boot-up-twice", "");
    assert_eq!(status, Some(1), "{said}");
    assert!(said.contains("worse  verdict    301/boot-up/reset-node: pass -> fail"), "{said}");
    repository.has(&REPORTS);
}

/// A firmware in the loop: the script starts it, and waits until it answers.
#[test]
fn the_script_starts_the_firmware() {
    let address = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let repository = Repository::new("--select 301/identity/vendor-id --journal none");
    let firmware = format!("canvass simulate reference-301 slcan:listen://{address} --node 5");
    let bus = format!("slcan:tcp://{address}");
    repository.run(&bus, &firmware);
    repository.accept();
    let (status, said) = repository.run(&bus, &firmware);
    assert_eq!(status, Some(0), "{said}");
    repository.has(&REPORTS);
}

/// The three pipelines run the script, and keep its outputs.
#[test]
fn the_pipelines_run_the_script() {
    for (name, language) in [("GitHub", "yaml"), ("GitLab", "yaml"), ("Jenkins", "groovy")] {
        let part = PAGE.split("\n### ").find(|part| part.starts_with(&format!("{name}\n"))).unwrap();
        let code = part.split(&format!("```{language}\n")).nth(1).unwrap().split("```").next().unwrap();
        for told in
            ["sh ci/conformance.sh", "CANVASS_BUS", "FIRMWARE", "FUZZ_FOR", "VERSION", "evidence.zip", "new.json"]
        {
            assert!(code.contains(told), "{name}: {told}");
        }
        assert!(script().contains("${VERSION:-") && script().contains("${FUZZ_FOR:-"));
    }
}
