//! Converting a part of a capture.

use crate::command::Folder;

/// Nodes 5 and 6 on two channels, with a frame every 10 s.
const LOG: &str = "\
(1700000000.000000) can0 705#00
(1700000010.000000) can1 706#00
(1700000020.000000) can0 605#4000100000000000
(1700000030.000000) can0 585#4300100091010000
(1700000040.000000) can0 080#
";

fn kept(args: &str) -> Vec<usize> {
    let folder = Folder::new().with("in.log", LOG);
    let (status, out, errors) = folder.run(&format!("convert in.log - --to candump {args}"));
    assert_eq!((status, errors.as_str()), (0, ""), "{args}");
    out.lines().map(|line| LOG.lines().position(|known| known == line).unwrap()).collect()
}

#[test]
fn by_time() {
    assert_eq!(kept("--from +10 --to +20"), [1, 2]);
    assert_eq!(kept("--from 1700000030"), [3, 4]);
    assert_eq!(kept("--to 2023-11-14T22:13:20Z"), [0]);
}

#[test]
fn by_channel() {
    assert_eq!(kept("--channel can1"), [1]);
    assert_eq!(kept("--channel can1,can0"), [0, 1, 2, 3, 4]);
    let folder = Folder::new().with("in.log", LOG);
    let (status, out, errors) = folder.run("convert in.log - --to candump --channel can7");
    assert_eq!((status, out.as_str()), (0, ""));
    assert_eq!(errors, "canvass: no channel is named can7; there were: can0, can1\n");
}

#[test]
fn by_node_and_filter() {
    assert_eq!(kept("--node 5"), [0, 2, 3]);
    assert_eq!(kept("--node 0x05,6"), [0, 1, 2, 3]);
    assert_eq!(kept("--filter service=sdo"), [2, 3]);
    assert_eq!(kept("--node 5 --from +20 --channel can0"), [2, 3]);
}

#[test]
fn what_was_cut_off_is_still_understood() {
    // The SYNC's COB-ID is moved to 85h before the part that is kept.
    let log = "(1.000000) can0 605#2305100085000000\n(2.000000) can0 585#6005100000000000\n(3.000000) can0 085#\n";
    let folder = Folder::new().with("in.log", log);
    let (_, out, _) = folder.run("convert in.log - --to candump --from +2 --filter service=sync");
    assert_eq!(out.lines().count(), 1);
}
