//! The extension of Visual Studio Code: a package for each system, with the program in it.

use super::npm::NPM;
use super::{FOLDER, VERSION, scratch, system};
use crate::packages;
use crate::run::run;
use anyhow::{Context, Result, ensure};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The source of the extension.
const SOURCE: &str = "editors/vscode";

/// Fetches the tools of the extension, as its lock file names them.
pub fn prepare() -> Result<()> {
    ensure!(system::AARCH64.program().exists(), "it holds the programs for Linux: cargo xtask dist linux");
    ensure!(system::program_for_windows().exists(), "it holds the program for Windows: cargo xtask dist windows");
    packages::install(&[NPM])?;
    if Path::new(SOURCE).join("node_modules/.bin/vsce").exists() {
        return Ok(());
    }
    crate::consent::ask("the tools of the extension", "npm ci --prefix editors/vscode")?;
    run(NPM.program, &["ci", "--no-audit", "--no-fund", "--prefix", SOURCE])
}

/// Visual Studio Code's name of each system, and the program for it.
fn programs() -> Vec<(String, PathBuf)> {
    let linux = system::LINUX.iter().map(|system| (format!("{}-{}", system.node.0, system.node.1), system.program()));
    linux.chain([("win32-x64".to_owned(), system::program_for_windows())]).collect()
}

/// A package for each system.
pub fn make() -> Result<Vec<String>> {
    programs().into_iter().map(|(target, program)| package(&target, &program)).collect()
}

fn package(target: &str, program: &Path) -> Result<String> {
    let folder = std::env::current_dir()?.join(scratch("vsix")?);
    for file in ["package.json", "README.md", "icon.png", "language-configuration.json", ".vscodeignore"] {
        fs::copy(Path::new(SOURCE).join(file), folder.join(file)).context(file)?;
    }
    for file in ["LICENSE-MIT", "LICENSE-APACHE"] {
        fs::copy(file, folder.join(file)).context(file)?;
    }
    fs::create_dir_all(folder.join("server"))?;
    fs::copy(program, folder.join("server").join(program.file_name().context("the program")?))?;
    run("cp", &["-r", &format!("{SOURCE}/syntaxes"), &folder.to_string_lossy()])?;
    bundle(&folder.join("dist/extension.js"))?;
    describe(&folder.join("package.json"))?;
    let file = format!("canvass-eds-{VERSION}-{target}.vsix");
    let output = std::env::current_dir()?.join(FOLDER).join(&file);
    let vsce = std::env::current_dir()?.join(SOURCE).join("node_modules/.bin/vsce");
    let mut vsce = Command::new(vsce);
    vsce.args(["package", "--no-dependencies", "--allow-missing-repository", "--target", target, "--out"]).arg(output);
    let status = vsce.current_dir(&folder).status().context("vsce")?;
    ensure!(status.success(), "vsce ended with {status}");
    Ok(file)
}

/// Puts the extension and the libraries that it uses into one file.
fn bundle(to: &Path) -> Result<()> {
    let esbuild = format!("{SOURCE}/node_modules/.bin/esbuild");
    let source = format!("{SOURCE}/extension.js");
    let output = format!("--outfile={}", to.display());
    let options =
        ["--bundle", "--platform=node", "--external:vscode", "--target=node18", "--minify", "--log-level=warning"];
    run(&esbuild, &[&[source.as_str()], &options[..], &[&output]].concat())
}

/// Writes the description of the packed extension: the version is that of the release, and the libraries are in the one
/// file.
fn describe(file: &Path) -> Result<()> {
    let mut about: Value = serde_json::from_slice(&fs::read(file)?).context("package.json")?;
    about["version"] = VERSION.into();
    about["main"] = "./dist/extension.js".into();
    let fields = about.as_object_mut().context("package.json: an object")?;
    fields.remove("dependencies");
    fields.remove("devDependencies");
    fs::write(file, serde_json::to_vec_pretty(&about)?)?;
    Ok(())
}
