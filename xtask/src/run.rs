//! Running programs.

use anyhow::{Context, Result, bail};
use std::path::PathBuf;
use std::process::Command;

/// Runs a program with its output on the console; an exit status other than 0 is an error.
pub fn run(program: &str, args: &[&str]) -> Result<()> {
    eprintln!("$ {program} {}", args.join(" "));
    let status = Command::new(program).args(args).status().with_context(|| format!("can't run {program}"))?;
    if !status.success() {
        bail!("{program} {} ended with {status}", args.join(" "));
    }
    Ok(())
}

/// A call of cargo for another workspace, without the variables that this cargo sets: build scripts that depend on
/// these variables would rebuild everything whenever the two workspaces are built in turn.
pub fn cargo() -> Command {
    let mut cargo = Command::new("cargo");
    let of_cargo = |name: &str| {
        name.starts_with("CARGO_PKG_") || name.starts_with("CARGO_MANIFEST_") || name == "CARGO_TARGET_DIR"
    };
    for (name, _) in std::env::vars_os() {
        if name.to_str().is_some_and(of_cargo) {
            cargo.env_remove(name);
        }
    }
    cargo
}

/// The build folder of cargo: `target`, or the folder in its variable.
pub fn target_folder() -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| PathBuf::from("target"), PathBuf::from)
}

/// Whether a program can be run with these arguments.
pub fn is_there(program: &str, args: &[&str]) -> bool {
    Command::new(program).args(args).output().is_ok_and(|output| output.status.success())
}

/// The path of this program. If the program was rebuilt while it runs, the kernel adds a mark to the path; without the
/// mark, it is the path of the new program.
pub fn this_program() -> Result<PathBuf> {
    let path = std::env::current_exe()?;
    Ok(path.to_string_lossy().trim_end_matches(" (deleted)").into())
}

/// A word quoted for the shell, whatever characters it has.
pub fn quoted(word: &str) -> String {
    format!("'{}'", word.replace('\'', r"'\''"))
}
