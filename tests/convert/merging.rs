//! Several files in one call.

use crate::command::Folder;

const A: &str = "(1700000000.000000) can0 701#00\n(1700000002.000000) can0 701#05\n(1700000003.000000) can1 701#05\n";
const B: &str = "(1700000001.000000) can0 702#00\n(1700000002.000000) can0 702#05\n";

#[test]
fn files_become_one_by_time() {
    let folder = Folder::new().with("a.log", A).with("b.log", B);
    let (status, out, errors) = folder.run("convert a.log b.log - --to candump");
    assert_eq!((status, errors.as_str()), (0, ""));
    assert_eq!(
        out,
        "(1700000000.000000) a.log:can0 701#00\n\
         (1700000001.000000) b.log:can0 702#00\n\
         (1700000002.000000) a.log:can0 701#05\n\
         (1700000002.000000) b.log:can0 702#05\n\
         (1700000003.000000) a.log:can1 701#05\n"
    );
    let (_, same_bus, _) = folder.run("convert a.log b.log - --to candump --same-bus");
    assert_eq!(same_bus, out.replace("a.log:", "").replace("b.log:", ""));
}

#[test]
fn equal_names_of_different_files_are_different_buses() {
    // The same transfer is on both buses: on a single bus, the second request would break the first transfer.
    let log = "(1700000000.000000) can0 605#4000100000000000\n(1700000001.000000) can0 585#4300100091010000\n";
    let folder = Folder::new().with("a.log", log).with("b.log", log);
    let (_, out, _) = folder.run("decode a.log b.log --format json");
    assert_eq!(out.lines().filter(|line| line.contains("\"index\":4096")).count(), 4, "{out}");
    assert!(out.contains("\"channel\":\"a.log:can0\"") && out.contains("\"channel\":\"b.log:can0\""));
}

#[test]
fn channels_are_chosen_by_either_name() {
    let folder = Folder::new().with("a.log", A).with("b.log", B);
    let lines = |args: &str| folder.run(&format!("convert a.log b.log - --to candump {args}")).1.lines().count();
    assert_eq!(lines("--channel can0"), 4);
    assert_eq!(lines("--channel b.log:can0"), 2);
    assert_eq!(lines("--channel can1,b.log:can0"), 3);
}

#[test]
fn files_of_different_formats_and_damage() {
    let folder = Folder::new()
        .with("a.log", A)
        .with("b.log", format!("rubbish\n{B}DROPCOUNT: dropped 7 CAN frames on 'can0' socket (total drops 7)\n"));
    folder.good("convert a.log a.pcapng");
    let (status, out, errors) = folder.run("decode a.pcapng b.log --format json");
    assert_eq!((status, out.lines().count()), (0, 5));
    assert!(errors.contains("b.log:1:1: malformed"), "{errors}");
    assert!(errors.contains("b.log:4: the recorder lost 7 frames here"), "{errors}");
}

#[test]
fn one_unreadable_file_does_not_stop_the_others() {
    let folder = Folder::new().with("a.log", A).with("b.log", B);
    folder.good("convert b.log b.log.gz");
    let mut damaged = std::fs::read(folder.path("b.log.gz")).unwrap();
    // Only the header of the deflated data is left: no data can be read.
    damaged.truncate(18);
    let folder = folder.with("b.log.gz", damaged);
    let (status, out, errors) = folder.run("convert a.log b.log.gz - --to candump --format-in candump");
    assert_eq!(out.lines().count(), 3, "{status} {errors}");
    assert!(errors.contains("b.log.gz:1"), "{errors}");
}

#[test]
fn times_that_do_not_fit_together_are_noticed() {
    let folder = Folder::new().with("a.log", A).with("b.log", "(1.000000) can0 702#00\n");
    let errors = folder.good("convert a.log b.log out.log");
    assert_eq!(
        errors,
        "canvass: times of a.log count from 1970 in UTC, those of b.log from the start of the recording: they are \
         merged as numbers\n"
    );
}
