//! Canvass leaves devices as it found them: python-canopen reads all readable objects of simulated devices before and
//! after runs, with a power cycle in between.

use std::process::Command;

#[test]
fn python_canopen_finds_devices_as_they_were_before_runs() {
    let judged = Command::new(crate::python::PYTHON)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(["tests/peers/as_found", "--lockstep", env!("CARGO_BIN_EXE_lockstep")])
        .output()
        .unwrap_or_else(|error| panic!("{error}; cargo xtask peers installs the peers that these tests need"));
    let told = String::from_utf8_lossy(&judged.stdout);
    assert!(judged.status.success(), "{told}{}", String::from_utf8_lossy(&judged.stderr));
}
