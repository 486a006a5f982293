//! No command writes a file that it reads, or writes a file twice. Old files stay until the new files are complete.

use crate::command::{Folder, sample};

const LOG: &str = "(1700000000.000001) can0 701#05\n";

/// A folder with files to be kept, and with the inputs of the commands.
fn folder() -> Folder {
    let folder = Folder::new().with("in.log", LOG).with("kept", "precious").with("waivers.toml", "");
    let eds = concat!(env!("CARGO_MANIFEST_DIR"), "/conformance/device/models/reference-301.eds");
    std::fs::copy(eds, folder.path("dev.eds")).unwrap();
    std::fs::hard_link(folder.path("in.log"), folder.path("link.log")).unwrap();
    folder
}

/// Each of these command lines once overwrote one of its own inputs.
#[test]
fn no_output_is_an_input_or_another_output() {
    let folder = folder();
    for (args, says) in [
        ("convert --force in.log in.log", "in.log is read and can't be written at the same time"),
        ("convert --force in.log link.log", "link.log is read (as in.log)"),
        ("convert --force --device 5=dev.eds in.log dev.eds --to candump", "dev.eds is read"),
        ("convert in.log out.log --quality text --quality-out ./out.log", "as out.log too"),
        ("decode in.log --quality json --quality-out in.log", "in.log is read"),
        ("decode in.log --device 5=dev.eds --quality json --quality-out dev.eds", "dev.eds is read"),
        ("signals in.log --quality json --quality-out link.log", "link.log is read (as in.log)"),
        ("diagnose in.log --force -o in.log", "in.log is read"),
        ("diagnose in.log --device 5=dev.eds --force -o dev.eds", "dev.eds is read"),
        ("diagnose in.log -o x --quality text --quality-out x", "x is to be written twice"),
        ("record sim:dev.eds --force --for 1 dev.eds --to candump", "dev.eds is read"),
        ("record sim:dev.eds --for 1 out.log ./out.log", "as out.log too"),
        ("test sim:dev.eds --report json=dev.eds", "dev.eds is read"),
        ("test sim:reference-301 --device dev.eds --report json=dev.eds", "dev.eds is read"),
        ("test sim:reference-301 --waivers waivers.toml --report json=waivers.toml", "waivers.toml is read"),
        ("test sim:reference-301 --report json=x --report html=x", "x is to be written twice"),
        ("test sim:reference-301 --report json=x.log --record x.log", "x.log is to be written twice"),
        ("fuzz sim:dev.eds --runs 1 --report json=dev.eds", "dev.eds is read"),
        ("fuzz sim:reference-301 --replay in.log --report json=link.log", "link.log is read (as in.log)"),
        ("fuzz sim:reference-301 --runs 1 --regressions r --report json=r", "r is to be written twice"),
        ("simulate dev.eds sim:reference-301 --for 1 --memory dev.eds", "dev.eds is read"),
    ] {
        let (status, _, errors) = folder.run(args);
        assert_eq!((status, errors.contains(says)), (2, true), "{args}: {errors}");
    }
    assert_eq!(folder.read("in.log"), LOG);
    assert!(folder.read("dev.eds").contains("[DeviceInfo]"));
    let names = std::fs::read_dir(folder.path(".")).unwrap().count();
    assert_eq!(names, 5, "nothing was begun");
}

#[cfg(unix)]
#[test]
fn what_the_shell_opened_counts_too() {
    let folder = folder();
    for (shell, says) in [
        ("\"$0\" convert --force - in.log < in.log", "is read (as standard input)"),
        ("\"$0\" test sim:reference-301 --report json=out.json > out.json", "as standard output too"),
    ] {
        let shell = ["-c", shell, env!("CARGO_BIN_EXE_canvass")];
        let output = std::process::Command::new("sh").args(shell).current_dir(folder.path(".")).output().unwrap();
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!((output.status.code(), errors.contains(says)), (Some(2), true), "{errors}");
    }
    assert_eq!(folder.read("in.log"), LOG);
}

#[test]
fn results_and_captures_are_overwritten_only_by_force() {
    let folder = folder();
    for args in ["diagnose in.log -o kept", "record sim:reference-301 --for 1 --to candump kept"] {
        let (status, _, errors) = folder.run(args);
        assert_eq!((status, &*errors), (2, "canvass: kept exists: give --force to overwrite it\n"), "{args}");
    }
    let select = "test sim:reference-301 --select 301/identity/vendor-id";
    let (status, _, errors) = folder.run(&format!("{select} --record link.log"));
    assert_eq!((status, &*errors), (2, "canvass: link.log exists: give --force to overwrite it\n"));
    assert_eq!((folder.read("kept"), folder.read("in.log")), ("precious".to_owned(), LOG.to_owned()));
    assert_eq!(folder.run(&format!("{select} --record link.log --force")).0, 0);
    assert_eq!(folder.run("diagnose in.log --force -o kept").0, 0);
    assert!(folder.read("kept").contains("node"));
}

/// A run without a result, or whose result can't be written, keeps the report of the run before.
#[test]
fn a_report_stays_until_there_is_a_new_one() {
    let folder = folder();
    let unreachable =
        "test sim:reference-301:10 --node 99 --timeout sdo=10ms,boot-up=10ms --report json=kept --report html=new";
    assert_eq!(folder.run(unreachable).0, 3);
    assert_eq!(folder.run("convert --force nosuch.log kept --to candump").0, 2);
    assert_eq!(folder.run("diagnose nosuch.log --force -o kept").0, 2);
    assert_eq!(folder.read("kept"), "precious");
    assert!(!folder.path("new").exists());
    let (status, _, errors) = folder.run("test sim:reference-301 --select 301/identity/vendor-id --report json=kept");
    assert_eq!(status, 0, "{errors}");
    assert!(folder.read("kept").contains("canvass/test/"));
    assert_eq!(std::fs::read_dir(folder.path(".")).unwrap().count(), 5, "nothing is left beside");
}

/// A reader that closes standard output after the first line still gets complete reports, and the status tells the
/// verdict.
#[cfg(unix)]
#[test]
fn a_closed_standard_output_changes_neither_verdicts_nor_reports() {
    let folder = Folder::new();
    std::fs::copy(sample("python-can.log"), folder.path("trace.log")).unwrap();
    let faulty = "sim:reference-301+sdo-toggle-unchecked";
    for (args, report, status) in [
        (format!("test {faulty} --select 301/sdo --report json=r1 --report html=h1"), "r1", 1),
        ("test sim:reference-301 --select 301/sdo/upload --report json=r2".to_owned(), "r2", 0),
        (format!("fuzz {faulty} --target sdo --seed 1 --runs 300 --shrink-budget 5 --report json=r3"), "r3", 1),
    ] {
        // Standard output is closed from the start.
        let mut child = folder.command(&args);
        let mut child = child.stdout(std::process::Stdio::piped()).stderr(std::process::Stdio::null()).spawn().unwrap();
        drop(child.stdout.take());
        assert_eq!(child.wait().unwrap().code(), Some(status), "{args}");
        let whole: serde_json::Value = serde_json::from_str(&folder.read(report)).unwrap();
        assert!(whole["schema"].as_str().unwrap().starts_with("canvass/"), "{args}");
    }
    assert!(folder.read("h1").trim_end().ends_with("</html>"));
    for (args, status) in [
        ("diagnose trace.log --fail-on warning", 1),
        ("compare r2 r1 --allow-missing", 1),
        ("compare r2 r2", 0),
        ("decode trace.log", 0),
    ] {
        let mut child = folder.command(args);
        let mut child = child.stdout(std::process::Stdio::piped()).stderr(std::process::Stdio::null()).spawn().unwrap();
        drop(child.stdout.take());
        assert_eq!(child.wait().unwrap().code(), Some(status), "{args}");
    }
}
