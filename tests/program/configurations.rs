//! `canvass dcf`: configurations are read, written, compared, converted and kept, on simulated devices that are
//! processes of their own.

use crate::live::Device;
use crate::running::{Run, command, finished, run};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::Duration;

/// A model with its node-ID.
type OfModel = (&'static str, u8, Changes);

/// Settings that differ from those as delivered: sections of a DCF with their values.
type Changes = &'static [(&'static str, &'static str)];

/// 6200h and the event timer of the first TPDO are one value.
const OF_SENDIX: Changes =
    &[("1017", "777"), ("1800sub5", "200"), ("6200", "200"), ("6001", "1024"), ("1801sub2", "5")];
const OF_DRAW_WIRES: Changes = &[("1017", "500"), ("1800sub5", "200")];
/// Only the COB-ID of SYNC is stored by these.
const OF_TR: Changes = &[("1005", "0x81")];

const MODELS: [OfModel; 11] = [
    ("kuebler-sendix-58x8", 63, OF_SENDIX),
    ("kuebler-sendix-f58", 63, OF_SENDIX),
    ("kuebler-sendix-m58", 63, OF_SENDIX),
    ("kuebler-sendix-f58m", 63, &[("1017", "777"), ("1800sub5", "200"), ("6001", "1024"), ("1801sub2", "5")]),
    ("kuebler-c100", 4, OF_DRAW_WIRES),
    ("kuebler-d125", 4, OF_DRAW_WIRES),
    ("lika-ax58", 1, &[("1800sub2", "3"), ("6200", "50")]),
    ("tr-c65", 1, OF_TR),
    ("tr-lmp30", 1, OF_TR),
    ("reference-301", 10, &[("1017", "777"), ("1800sub5", "200"), ("1A00sub1", "0x20410010"), ("2011", "press")]),
    (
        "reference-406",
        20,
        &[("1017", "777"), ("1800sub5", "200"), ("6200", "200"), ("6001", "3600"), ("1006", "20000")],
    ),
];

fn path(folder: &Path, name: &str) -> String {
    folder.join(name).to_str().unwrap().to_owned()
}

fn device(model: &str, node: u8) -> Device {
    let device = Device::of(model, &["--node", &node.to_string()]);
    pre_operational(&device.bus, node);
    device
}

/// A self-starting device is operational, and refused.
fn pre_operational(bus: &str, node: u8) {
    assert_eq!(run(&["nmt", bus, "pre-operational", &node.to_string(), "--wait", "50ms"]).status, 0);
}

/// The program in a folder of its own, for journals.
fn run_in(folder: &Path, args: &[&str]) -> Run {
    finished(command(args).current_dir(folder).stdin(Stdio::null()).output().unwrap())
}

fn expect(status: i32, run: &Run) -> &Run {
    assert_eq!(run.status, status, "{}{}", run.stdout, run.stderr);
    run
}

/// The text of a DCF with another value in a section.
fn changed(dcf: &str, section: &str, value: &str) -> String {
    let at = dcf.find(&format!("[{section}]\r\n")).unwrap_or_else(|| panic!("[{section}]"));
    let line = at + dcf[at..].find("ParameterValue=").unwrap();
    let end = line + dcf[line..].find("\r\n").unwrap();
    assert!(!dcf[at + 1..line].contains('['), "[{section}] has a value");
    format!("{}ParameterValue={value}{}", &dcf[..line], &dcf[end..])
}

fn read(bus: &str, node: u8, file: &str) -> String {
    read_with(bus, node, file, &[])
}

fn read_with(bus: &str, node: u8, file: &str, more: &[&str]) -> String {
    expect(0, &run(&[&["dcf", "read", bus, "--node", &node.to_string(), "-o", file], more].concat()));
    fs::read_to_string(file).unwrap()
}

/// A configuration that was read from one device makes another one equal, and neither position moves.
#[test]
fn every_model_takes_the_configuration_of_another() {
    // Most of the time is waiting.
    std::thread::scope(|scope| MODELS.iter().for_each(|of| drop(scope.spawn(|| takes_the_configuration(of)))));
}

fn takes_the_configuration(&(model, node, changes): &OfModel) {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    {
        let [as_delivered, wanted, kept] =
            ["new", "wanted", "kept"].map(|name| path(folder, &format!("{model}-{name}.dcf")));
        let (first, second) = (device(model, node), device(model, node));
        let position =
            |device: &Device| run(&["sdo", "read", &device.bus, &node.to_string(), "6004", "--device", model]).stdout;
        let at = position(&second);
        // C100 and D125 differ in nothing that a request shows.
        let known: &[&str] = if changes == OF_DRAW_WIRES { &["--device", model] } else { &[] };
        let dcf = read_with(&first.bus, node, &as_delivered, known);
        let dcf = changes.iter().fold(dcf, |dcf, (section, value)| changed(&dcf, section, value));
        fs::write(&wanted, dcf).unwrap();
        expect(1, &run(&["dcf", "diff", &wanted, &first.bus]));
        expect(0, &run_in(folder, &["dcf", "write", &wanted, &first.bus]));
        expect(0, &run(&["dcf", "diff", &wanted, &first.bus]));
        read_with(&first.bus, node, &kept, known);
        let stored = run_in(folder, &["dcf", "write", &kept, &second.bus, "--store"]);
        expect(0, &stored);
        expect(0, &run(&["dcf", "diff", &kept, &second.bus]));
        if !changes.iter().any(|(section, _)| *section == "6001") {
            assert_eq!(position(&second), at, "{model}");
        }
        // The configuration was stored: a restart keeps it.
        expect(0, &run(&["nmt", &second.bus, "reset-node", &node.to_string(), "--wait", "50ms"]));
        let again = (0..20).any(|_| run(&["dcf", "diff", &kept, &second.bus, "--timeout", "300ms"]).status == 0);
        assert!(again, "{model}: {}", run(&["dcf", "diff", &kept, &second.bus]).stdout);
        assert!(
            !folder.read_dir().unwrap().any(|file| file.unwrap().path().extension().is_some_and(|it| it == "journal"))
        );
    }
}

/// Number of writes that are killed, and of devices that they are for.
const KILLED: u64 = 30;
const DEVICES: u64 = 6;

/// A write that is killed leaves a journal, by which `canvass restore` brings back all settings.
#[test]
fn what_a_killed_write_has_changed_is_restored() {
    let restored: u32 = std::thread::scope(|scope| {
        let devices: Vec<_> = (0..DEVICES).map(|first| scope.spawn(move || kill_writes(first))).collect();
        devices.into_iter().map(|device| device.join().unwrap()).sum()
    });
    assert!(restored > 5, "only {restored} writes had changed anything");
}

/// Kills writes on one device. Returns the number of them that had changed something.
fn kill_writes(first: u64) -> u32 {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let device = device("reference-301", 10);
    let [before, wanted, after] = ["before.dcf", "wanted.dcf", "after.dcf"].map(|name| path(folder, name));
    let dcf = read(&device.bus, 10, &before);
    let others = ["1400", "1401", "1402", "1403", "1800", "1801", "1802", "1803"].map(|index| format!("{index}sub2"));
    let dcf = others.iter().fold(dcf, |dcf, section| changed(&dcf, section, "1"));
    let dcf = [("1017", "777"), ("1006", "20000"), ("1A00sub1", "0x20410010"), ("2011", "press"), ("1019", "9")]
        .iter()
        .fold(dcf, |dcf, (section, value)| changed(&dcf, section, value));
    fs::write(&wanted, dcf).unwrap();
    let journal = folder.join("journal");
    let journal_path = journal.to_str().unwrap();
    let mut restored = 0;
    for kill in (first..KILLED).step_by(DEVICES as usize) {
        let args = ["dcf", "write", &wanted, &device.bus, "--journal", journal_path];
        let mut child = command(&args).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        while !journal.exists() && child.try_wait().unwrap().is_none() {
            std::thread::sleep(Duration::from_millis(1));
        }
        std::thread::sleep(Duration::from_millis(kill * 3));
        child.kill().unwrap();
        child.wait().unwrap();
        assert!(journal.exists(), "kill {kill}");
        restored += u32::from(run(&["dcf", "diff", &before, &device.bus]).status == 1);
        let put_back = run(&["restore", &device.bus, "--journal", journal_path]);
        expect(0, &put_back);
        assert!(!journal.exists());
        expect(0, &run(&["dcf", "diff", &before, &device.bus]));
        pre_operational(&device.bus, 10);
    }
    read(&device.bus, 10, &after);
    expect(0, &run(&["dcf", "diff", &before, &after]));
    restored
}

/// What must not be written is refused before anything is written, and says what would allow it.
#[test]
fn dangerous_writes_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let device = device("reference-301", 10);
    let [dcf, other] = ["as-found.dcf", "other.dcf"].map(|name| path(folder, name));
    let text = read(&device.bus, 10, &dcf);
    let refused = |text: String, more: &[&str], says: &str| {
        fs::write(&other, text).unwrap();
        let refused = run_in(folder, &[&["dcf", "write", &other, &device.bus], more].concat());
        assert!(refused.status == 2 && refused.stderr.contains(says), "{says}: {}{}", refused.status, refused.stderr);
        expect(0, &run(&["dcf", "diff", &dcf, &device.bus]));
    };
    let of_another = changed(&text, "1018sub2", "0x99");
    refused(of_another, &[], "expected the product code 00000099h (1018h:02)");
    refused(changed(&text, "1005", "0x40000080"), &[], "produce SYNC: --allow sync");
    refused(changed(&text, "1800sub1", "0x1A2"), &["--node", "11"], "the CAN-ID 1A2h is for node 10");
    assert_eq!(run(&["nmt", &device.bus, "start", "10", "--wait", "50ms"]).status, 0);
    refused(changed(&text, "1017", "50"), &[], "pre-operational 10");
    pre_operational(&device.bus, 10);
    // A dry run shows what it would write.
    fs::write(&other, changed(&text, "1017", "50")).unwrap();
    let dry = run_in(folder, &["dcf", "write", &other, &device.bus, "--dry-run"]);
    assert!(expect(0, &dry).stdout.contains("1017h:00"), "{}", dry.stdout);
    expect(0, &run(&["dcf", "diff", &dcf, &device.bus]));
}

/// A refusal stops the write, says what was done, and leaves the journal that undoes it.
#[test]
fn a_refusal_can_be_undone() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let device = device("reference-301", 10);
    let [dcf, other] = ["as-found.dcf", "other.dcf"].map(|name| path(folder, name));
    let text = read(&device.bus, 10, &dcf);
    // An object that is not there can't be mapped.
    let text = changed(&changed(&text, "1017", "50"), "1A00sub1", "0x5FFF0010");
    fs::write(&other, text).unwrap();
    let refused = run_in(folder, &["dcf", "write", &other, &device.bus, "--journal", "undo"]);
    expect(1, &refused);
    assert!(refused.stderr.contains("1A00h:01 = 10 00 FF 5F was refused: abort 0602 0000h"), "{}", refused.stderr);
    assert!(refused.stderr.contains("--journal undo` undoes what was written"), "{}", refused.stderr);
    expect(1, &run(&["dcf", "diff", &dcf, &device.bus]));
    expect(0, &run_in(folder, &["restore", &device.bus, "--journal", "undo"]));
    expect(0, &run(&["dcf", "diff", &dcf, &device.bus]));
}

/// A write with a journal that is kept can be undone although it went well.
#[test]
fn a_kept_journal_undoes_a_good_write() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let device = device("kuebler-sendix-58x8", 63);
    let [dcf, other] = ["as-found.dcf", "other.dcf"].map(|name| path(folder, name));
    let text = read(&device.bus, 63, &dcf);
    fs::write(&other, changed(&changed(&text, "1017", "50"), "1800sub5", "20")).unwrap();
    expect(0, &run_in(folder, &["dcf", "write", &other, &device.bus, "--store", "--journal", "undo"]));
    expect(1, &run(&["dcf", "diff", &dcf, &device.bus]));
    expect(0, &run_in(folder, &["restore", &device.bus, "--journal", "undo"]));
    expect(0, &run(&["dcf", "diff", &dcf, &device.bus]));
    // The memory, too: a restart changes nothing.
    expect(0, &run(&["nmt", &device.bus, "reset-node", "63", "--wait", "50ms"]));
    assert!((0..20).any(|_| run(&["dcf", "diff", &dcf, &device.bus, "--timeout", "300ms"]).status == 0));
}

/// DCF, XDC and concise DCF have the same values.
#[test]
fn formats_hold_the_same_values() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let [dcf, xdc, concise, again] = ["a.dcf", "a.xdc", "a.cdc", "b.dcf"].map(|name| path(folder, name));
    let bus = "sim:kuebler-sendix-58x8";
    expect(0, &run(&["dcf", "read", bus, "-o", &dcf]));
    expect(0, &run(&["dcf", "convert", &dcf, &xdc]));
    expect(0, &run(&["dcf", "diff", &dcf, &xdc]));
    expect(0, &run(&["dcf", "convert", &xdc, &concise]));
    let unknown = run(&["dcf", "convert", &concise, &again, "--node", "63"]);
    assert!(expect(2, &unknown).stderr.contains("--device"), "{}", unknown.stderr);
    let model = ["--device", "kuebler-sendix-58x8", "--node", "63"];
    expect(0, &run(&[&["dcf", "convert", &concise, &again], &model[..]].concat()));
    expect(0, &run(&["dcf", "diff", &dcf, &again]));
    expect(0, &run(&[&["dcf", "diff", &concise, bus], &model[2..]].concat()));
    expect(0, &run(&[&["dcf", "write", &concise, bus], &model[2..]].concat()));
    // The description of a type of device has no values.
    let eds: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("conformance/device/models/kuebler-sendix-58x8.eds");
    let none = run(&["dcf", "write", eds.to_str().unwrap(), bus]);
    assert!(expect(2, &none).stderr.contains("no configured values"), "{}", none.stderr);
    let wrong = run(&["eds", "from-device", bus, "-o", &path(folder, "x.dcf")]);
    assert!(expect(2, &wrong).stderr.contains("canvass dcf read"), "{}", wrong.stderr);
}

/// A backup has each node of a network, and is written back by its project file.
#[test]
fn a_network_is_kept_and_written_back() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let bus = "sim:kuebler-sendix-58x8:5+lika-ax58:6+reference-301:7";
    expect(0, &run_in(folder, &["dcf", "backup", bus, "monday", "--network", "line 3"]));
    let list = fs::read_to_string(folder.join("monday/nodelist.cpj")).unwrap();
    assert!(list.contains("NetName=line 3") && list.contains("Node6DCFName=node6.dcf"), "{list}");
    expect(2, &run_in(folder, &["dcf", "backup", bus, "monday"]));
    let text = fs::read_to_string(folder.join("monday/node6.dcf")).unwrap();
    fs::write(folder.join("monday/node6.dcf"), changed(&text, "1800sub2", "3")).unwrap();
    let written = run_in(folder, &["dcf", "write", "monday/nodelist.cpj", bus, "--dry-run"]);
    let told = &expect(0, &written).stdout;
    assert!(told.contains("node 5 on sim") && told.contains("1800h:02") && told.contains("node 7 on sim"), "{told}");
    expect(0, &run_in(folder, &["dcf", "write", "monday/nodelist.cpj", bus]));
    // The file of one node serves another one.
    expect(0, &run_in(folder, &["dcf", "write", "monday/node5.dcf", "sim:kuebler-sendix-58x8:9", "--node", "9"]));
}
