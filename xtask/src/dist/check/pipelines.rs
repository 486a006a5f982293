//! The action for GitHub and the component for GitLab: run as their servers run them, from the files of the release.

use super::{absolute, clean, output};
use crate::consent;
use crate::dist::{FOLDER, VERSION, npm, tools};
use crate::packages::{self, Package};
use crate::run::run as run_program;
use anyhow::{Context, Result, ensure};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Runs the steps of a composite action as GitHub's runner does.
const STEPS: &str = "packaging/ci/steps.py";
/// A program that runs pipelines of GitLab, components included; this version is the last one for Node 20. It copies by
/// rsync.
const GITLAB: (&str, &str) = ("gitlab-ci-local", "4.61.1");
const RSYNC: Package = Package { program: "rsync", probe: &["--version"], package: "rsync" };
const TOOLS: &str = "target/dist-gitlab";

/// A job of each kind: its command, its arguments, its exit status, and what its summary tells.
const JOBS: [(&str, &str, i32, &str); 5] = [
    ("test", "sim:kuebler-sendix-58x8 --select 301/sdo/upload", 0, "pass"),
    (
        "test",
        "sim:kuebler-sendix-58x8+sdo-toggle-unchecked --select 301/sdo/download/segment-toggle",
        1,
        "segment-toggle",
    ),
    ("fuzz", "sim:reference-301 --runs 50 --seed 1", 0, "reference-301"),
    ("diagnose", "'a capture.log'", 1, "emcy/raised"),
    ("eds check", "'an encoder.eds' --select eds/pdo", 1, "eds/pdo/length"),
];

/// Runs each job by both.
pub fn run() -> Result<String> {
    tools::VENV.install()?;
    packages::install(&[npm::NPM, RSYNC])?;
    for job in &JOBS {
        by_github(job).with_context(|| format!("GitHub: {} {}", job.0, job.1))?;
    }
    install_gitlab()?;
    for job in &JOBS {
        by_gitlab(job).with_context(|| format!("GitLab: {} {}", job.0, job.1))?;
    }
    Ok("action and component installed the program from the release and ran every command".to_owned())
}

/// A repository with the files of the jobs.
fn repository(name: &str) -> Result<PathBuf> {
    let folder = clean(name)?;
    fs::copy("docs/examples/commissioning.log", folder.join("a capture.log"))?;
    fs::copy("conformance/device/models/kuebler-sendix-f58.eds", folder.join("an encoder.eds"))?;
    Ok(folder)
}

/// A PATH without a canvass, so that the pipeline has to install that of the release.
fn path() -> &'static str {
    "/usr/local/bin:/usr/bin:/bin"
}

fn by_github((command, arguments, status, summary): &(&str, &str, i32, &str)) -> Result<()> {
    let folder = repository("github")?;
    let mut python = Command::new(absolute(tools::VENV.folder.as_ref())? + "/bin/python");
    python.arg(absolute(STEPS.as_ref())?).arg(absolute("action.yml".as_ref())?).current_dir(&folder);
    python.env_clear().env("PATH", path()).env("HOME", &folder);
    for (name, value) in [("command", *command), ("arguments", arguments), ("version", VERSION)] {
        python.arg(format!("{name}={value}"));
    }
    python.arg(format!("address={}", absolute(FOLDER.as_ref())?));
    ended(&mut python, *status)?;
    told(&folder.join("summary.md"), summary)?;
    reports(&folder, command)
}

fn install_gitlab() -> Result<()> {
    let (name, version) = GITLAB;
    if Path::new(TOOLS).join("node_modules/.bin").join(name).exists() {
        return Ok(());
    }
    let package = format!("{name}@{version}");
    consent::ask(&package, &format!("npm install --prefix {TOOLS} {package}"))?;
    run_program(npm::NPM.program, &["install", "--no-audit", "--no-fund", "--prefix", TOOLS, &package])
}

fn by_gitlab((command, arguments, status, summary): &(&str, &str, i32, &str)) -> Result<()> {
    let folder = repository("gitlab")?;
    fs::create_dir_all(folder.join("templates"))?;
    fs::copy("templates/canvass.yml", folder.join("templates/canvass.yml"))?;
    let pipeline = format!(
        "include:\n  - local: templates/canvass.yml\n    inputs:\n      command: {command}\n      arguments: {arguments:?}\n      \
         address: {}\n      version: {VERSION}\n",
        absolute(FOLDER.as_ref())?
    );
    fs::write(folder.join(".gitlab-ci.yml"), pipeline)?;
    // A pipeline belongs to a commit.
    for words in
        [&["init", "-q"][..], &["add", "."], &["-c", "user.name=a", "-c", "user.email=a@b", "commit", "-qm", "a"]]
    {
        output(Command::new("git").args(words).current_dir(&folder))?;
    }
    let program = Path::new(TOOLS).join("node_modules/.bin").join(GITLAB.0);
    let mut gitlab = Command::new(absolute(&program)?);
    gitlab.args(["--force-shell-executor", "--shell-isolation=false", "canvass"]).current_dir(&folder);
    gitlab.env_clear().env("PATH", path()).env("HOME", &folder);
    ended(&mut gitlab, *status)?;
    let report = format!("canvass-reports/{}.md", command.replace(' ', "-"));
    told(&folder.join(report), summary)?;
    reports(&folder, command)
}

/// Runs a program that has to end with this status.
fn ended(command: &mut Command, status: i32) -> Result<()> {
    eprintln!("$ {command:?}");
    let output = command.output().with_context(|| format!("{command:?}"))?;
    let said = [output.stdout, output.stderr].concat();
    let said = String::from_utf8_lossy(&said);
    ensure!(output.status.code() == Some(status), "expected status {status}, found {}: {said}", output.status);
    Ok(())
}

fn told(file: &Path, text: &str) -> Result<()> {
    let found = fs::read_to_string(file).with_context(|| file.display().to_string())?;
    ensure!(found.contains(text), "expected {text:?} in {}, found {found}", file.display());
    Ok(())
}

/// Every job leaves its result as JSON and as JUnit.
fn reports(folder: &Path, command: &str) -> Result<()> {
    for ending in ["json", "xml"] {
        let report = folder.join("canvass-reports").join(format!("{}.{ending}", command.replace(' ', "-")));
        ensure!(report.exists(), "{} is missing", report.display());
    }
    Ok(())
}
