//! The bundle of a run on a real bus is verified without the bus.

use crate::interface::Interface;
use crate::running::{run, simulate, text};

#[test]
fn a_bundle_of_vcan_is_verified_offline() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.zip").display().to_string();
    let bus = Interface::new("vbundle");
    let device = simulate("reference-301", bus.name(), &["--fault", "boot-up-twice"]);
    let select = "301/boot-up,301/identity,301/heartbeat,301/sdo/upload";
    let args = ["test", bus.name(), "--device", "reference-301", "--select", select, "--bundle", &path];
    let tested = run(&args);
    assert_eq!(tested.status.code(), Some(1), "{}{}", text(&tested.stdout), text(&tested.stderr));
    drop((device, bus));
    let verified = run(&["verify", &path]);
    assert_eq!(verified.status.code(), Some(0), "{}{}", text(&verified.stdout), text(&verified.stderr));
    let mut archive = std::fs::read(&path).unwrap();
    let place = archive.windows(12).position(|window| window == b"result.json{").unwrap();
    archive[place + 30] ^= 1;
    std::fs::write(&path, archive).unwrap();
    let refused = run(&["verify", &path]);
    assert_eq!(refused.status.code(), Some(1), "{}", text(&refused.stderr));
    assert!(text(&refused.stderr).contains("result.json was changed"), "{}", text(&refused.stderr));
}
