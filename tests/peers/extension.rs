//! The extension for Visual Studio Code, run in Node with its real library for language clients: it starts this program
//! and receives its findings.

use std::path::Path;
use std::process::Command;

#[test]
fn the_extension_starts_the_server_and_shows_what_it_finds() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let output = Command::new("node")
        .arg(root.join("tests/peers/extension.js"))
        .arg(root.join("editors/vscode"))
        .env("CANVASS", env!("CARGO_BIN_EXE_canvass"))
        .output()
        .unwrap_or_else(|error| panic!("node: {error}; cargo xtask ci installs the peers that these tests need"));
    let told = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{told}{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(told.lines().collect::<Vec<_>>(), ["findings of eds", "hover", "edits", "symbols", "ended"]);
}
