//! pytest-lsp, a client of language servers, has sessions with `canvass lsp` in the manner of several editors.

use std::process::Command;

const PYTHON: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/target/peers-venv/bin/python");
const SESSIONS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/peers/language_server.py");

#[test]
fn a_foreign_client_has_sessions_as_editors_have_them() {
    let folder = tempfile::tempdir().unwrap();
    let output = Command::new(PYTHON)
        .args(["-m", "pytest", "-q", "-p", "no:cacheprovider", "-W", "error::pytest_lsp.LspSpecificationWarning"])
        .arg(SESSIONS)
        .env("CANVASS", env!("CARGO_BIN_EXE_canvass"))
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .current_dir(folder.path())
        .output()
        .unwrap_or_else(|error| panic!("{PYTHON}: {error}; cargo xtask ci installs the peers that these tests need"));
    let told = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{told}{}", String::from_utf8_lossy(&output.stderr));
    // Each of four tests runs with the capabilities of four editors.
    assert!(told.contains("16 passed"), "{told}");
}
