//! The quality of captures, as the program prints it.

use crate::command::Folder;
use crate::recording;

const LOG: &str = "\
(1700000000.000000) can0 123#11
DROPCOUNT: dropped 7 CAN frames on 'can0' socket (total drops 7)
(1700000001.010000) can1 12345678#11
rubbish
(1700000000.500000) can0 123#R
(1700000060.500000) can0 20000080#0000000000000000
";

fn json(folder: &Folder, file: &str) -> serde_json::Value {
    serde_json::from_str(&folder.read(file)).unwrap()
}

#[test]
fn as_json_in_a_file() {
    let folder = Folder::new().with("a.log", LOG).with("b.log", recording::log());
    let (status, out, _) = folder.run("decode a.log b.log --format json --quality json --quality-out q.json");
    assert_eq!((status, out.lines().count()), (0, 4 + recording::FRAMES));
    let quality = json(&folder, "q.json");
    assert_eq!(quality["schema"], "canvass/quality/1");
    let a = &quality["sources"][0];
    assert_eq!(a["frames"], 4);
    let kinds = serde_json::json!({ "standard": 1, "extended": 1, "remote": 1, "error": 1, "fd": 0, "xl": 0 });
    assert_eq!(a["kinds"], kinds);
    assert_eq!(a["damages"]["malformed"], 1);
    assert_eq!(a["damages"]["dropped"], 7);
    assert_eq!(a["resolution_ns"], 10_000_000);
    assert_eq!(a["clock_steps_back"]["count"], 1);
    assert_eq!(a["clock_steps_back"]["largest_ns"], 510_000_000);
    assert_eq!(a["clock_steps_back"]["first"]["number"], 5);
    assert_eq!(a["gaps"]["count"], 1);
    assert_eq!(a["gaps"]["largest"]["length_ns"], 60_000_000_000_u64);
    assert_eq!(a["duration_ns"], 60_500_000_000_u64);
    assert_eq!(a["channels"][0], serde_json::json!({ "name": "a.log:can0", "frames": 3 }));
    let b = &quality["sources"][1];
    assert_eq!((&b["resolution_ns"], &b["gaps"]["count"]), (&1.into(), &0.into()));
    assert_eq!(quality["total"]["frames"], 4 + recording::FRAMES as u64);
}

#[test]
fn as_text_behind_everything_else() {
    let folder = Folder::new().with("a.log", LOG);
    let errors = folder.good("convert a.log out.log --quality");
    let summary = &errors[errors.find("capture quality").unwrap()..];
    assert_eq!(
        summary,
        "capture quality\n\
         a.log (candump)\n\
         \x20 frames     4: 1 standard, 1 extended, 1 remote, 1 error\n\
         \x20 channels   can0 3, can1 1\n\
         \x20 time       1700000000.000000000 to 1700000060.500000000, 60.5 s, resolution 10 ms\n\
         \x20 damage     1 malformed, 7 dropped\n\
         \x20 clock      1 step back, the largest 510 ms, the first at a.log:5\n\
         \x20 gaps       1, the largest 60 s until a.log:6, where at most 1.25 s was usual\n\
         \x20 warning    times are no finer than 10 ms: the order and delays of frames are not certain\n\
         \x20 warning    the recorder lost 7 frames\n\
         \x20 warning    the clock stepped back: times before and after can't be compared\n"
    );
    let (_, out, _) = folder.run_with_input("decode - --quality text --quality-out -", LOG.as_bytes());
    assert!(out.contains("capture quality\n- (candump)\n"), "{out}");
}

#[test]
fn cuts_do_not_change_it() {
    let folder = Folder::new().with("a.log", LOG);
    folder.good("convert a.log out.log --from +50 --channel can0 --quality=json --quality-out q.json");
    assert_eq!(json(&folder, "q.json")["total"]["frames"], 4);
}
