//! The extension of Visual Studio Code: its files, and the language server that it starts.

use super::{archives, bare, clean, output};
use crate::dist::{VERSION, files, system};
use anyhow::{Context, Result, ensure};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

/// Unpacks the package of each system; starts the server of those for Linux.
pub fn unpack() -> Result<String> {
    for package in files("vsix")? {
        let folder = clean("vsix")?;
        output(bare("unzip").arg("-q").arg(package.canonicalize()?).arg("-d").arg(&folder))?;
        let folder = folder.join("extension");
        let about: Value = serde_json::from_slice(&fs::read(folder.join("package.json"))?)?;
        ensure!(about["version"] == VERSION, "expected version {VERSION}, found {}", about["version"]);
        for field in ["main", "icon"] {
            let file = folder.join(about[field].as_str().context(field)?);
            ensure!(file.exists(), "{field}: {} is missing", file.display());
        }
        output(bare("node").arg("--check").arg(folder.join("dist/extension.js")))?;
        let name = package.to_string_lossy().into_owned();
        let node = |system: &system::System| format!("{}-{}", system.node.0, system.node.1);
        match system::LINUX.into_iter().find(|system| name.contains(&node(system))) {
            Some(system) => serves(system, &folder.join("server/canvass"))?,
            None => ensure!(folder.join("server/canvass.exe").exists(), "{name}: the server is missing"),
        }
    }
    Ok("unpacked; its server answers".to_owned())
}

/// The server answers the first request of an editor, and ends when it is told to.
fn serves(system: &system::System, server: &Path) -> Result<()> {
    let message = |text: &str| format!("Content-Length: {}\r\n\r\n{text}", text.len());
    let asked = [
        r#"{"jsonrpc":"2.0","id":1,"method":"initialize","params":{"processId":null,"rootUri":null,"capabilities":{}}}"#,
        r#"{"jsonrpc":"2.0","method":"initialized","params":{}}"#,
        r#"{"jsonrpc":"2.0","id":2,"method":"shutdown"}"#,
        r#"{"jsonrpc":"2.0","method":"exit"}"#,
    ];
    let input = clean("vsix-input")?.join("asked");
    fs::write(&input, asked.map(message).concat())?;
    let mut command: Command = archives::runner(system, server, &["lsp"]);
    let told = output(command.stdin(Stdio::from(fs::File::open(input)?)))?;
    ensure!(told.contains("completionProvider"), "expected the capabilities of the server, found {told}");
    Ok(())
}
