use crate::frames::*;
use canvass_traces::*;

const CONSOLE: Format = Format::CandumpConsole;

/// A log; the other text is the output of `log2long` of can-utils 2020.11 for it.
const LOG: &str = "(1700000000.123456) can0 123#DEADBEEF
(1700000000.123456) can0 12345678#DEADBEEF
(1700000000.123456) can0 20000088#0000080200000000
(1700000000.123456) can0 123#R
(1700000000.123456) can0 123#R5
(1700000000.123456) can0 123#
(1700000000.123456) can0 123#1122334455667788
(1700000000.123456) can0 123#27
(1700000000.123456) can0 123##4AABBCC
(1700000000.123456) can0 123##4000102030405060708090A0B
";
const LONG: &str = "(1700000000.123456)  can0       123   [4]  DE AD BE EF               '....'
(1700000000.123456)  can0  12345678   [4]  DE AD BE EF               '....'
(1700000000.123456)  can0  20000088   [8]  00 00 08 02 00 00 00 00   ERRORFRAME
(1700000000.123456)  can0       123   [0]  remote request
(1700000000.123456)  can0       123   [5]  remote request
(1700000000.123456)  can0       123   [0]                            ''
(1700000000.123456)  can0       123   [8]  11 22 33 44 55 66 77 88   '.\"3DUfw.'
(1700000000.123456)  can0       123   [1]  27                        '''
(1700000000.123456)  can0       123  [03]  AA BB CC                  '...'
(1700000000.123456)  can0       123  [12]  00 01 02 03 04 05 06 07 08 09 0A 0B
";

#[test]
fn says_the_same_as_the_log() {
    let (long, names, base) = read(CONSOLE, LONG.as_bytes());
    let log = without_places(items(Format::Candump, LOG).into_iter().map(Result::unwrap));
    assert_eq!(without_places(long.into_iter().map(Result::unwrap)), log);
    assert_eq!((names, base), (vec!["can0".to_owned()], TimeBase::Utc));
}

/// The frame of a line in the notation of the log.
fn shown(line: &str) -> String {
    one(CONSOLE, &format!("{line}\n")).notation().to_string()
}

#[test]
fn every_way_to_print_a_frame() {
    for (line, notation) in [
        ("  can0  123   [2]  11 22", "123#1122"),
        (" vcan0  00000123   [2]  11 22", "00000123#1122"),
        ("  can0  123   [2]  22`11", "123#1122"),
        ("  can0  123   [1]  11                        `.`", "123#11"),
        ("  can0  123   [3]  33`22`11                  `3\".`", "123#112233"),
        ("  can0  123   [2]  00010001 00100010", "123#1122"),
        ("  can0  123   [2]  00100010`00010001", "123#1122"),
        ("  can0  123   [2]  10 11", "123#1011"),
        ("  can0  123   {2}  11 22", "123#1122"),
        ("  can0  123   {B}  11 22 33 44 55 66 77 88", "123#1122334455667788_B"),
        ("  can0  123   {C}  remote request", "123#R8_C"),
        ("  can0  123   [8]  remote request", "123#R8"),
        ("  can0  123  [08]  11 22 33 44 55 66 77 88", "123##41122334455667788"),
        ("  can0  RX B E  123  [01]  11", "123##711"),
        ("  can0  RX - E  123  [01]  11", "123##611"),
        ("  can0  123  [0003] (45|81:00:12345678) 11 22 33", "45123#81:00:12345678#112233"),
        ("  can0  20000004   [8]  00 08 00 00 00 00 00 00   ERRORFRAME", "20000004#0008000000000000"),
        (" \x1b[1;31m can0\x1b[0m  123   [1]  11", "123#11"),
        ("  can0  123   [1]  11   '\x1b[0m", "123#11"),
    ] {
        assert_eq!(shown(line), notation, "{line}");
    }
}

/// Logs in documents and reports may have remarks beside the frames.
#[test]
fn a_remark_beside_a_frame_is_passed_over() {
    assert_eq!(shown("  can0  703   [1]  05       # the gateway's heartbeat"), "703#05");
    assert_eq!(shown("  vcan0  084   [8]  00 50 01 2F F3 FF FF FF   # Emergency message."), "084#0050012FF3FFFFFF");
    assert!(items(CONSOLE, "  can0  703   [1]  05#\n")[0].is_err(), "a byte that is damaged");
    assert!(items(CONSOLE, "  can0  703   [2]  05   # one byte is missing\n")[0].is_err());
}

#[test]
fn a_remark_beside_a_frame_becomes_its_comment() {
    for (line, remark) in [
        ("  can0  703   [1]  05       # the gateway's heartbeat", "the gateway's heartbeat"),
        (
            "  can0  201   [7]  37 2F 00 00 00 00 00    <---- only now, after the time-out",
            "only now, after the time-out",
        ),
        ("  can0  703   [1]  05  // no answer", "no answer"),
        ("  can0  703   [1]  05  ; no answer", "no answer"),
        ("  can0  703   [1]  05  -> here", "here"),
        ("  can0  703   [1]  05  this is it", "this is it"),
        ("  can0  080   [0]  <- the first one", "the first one"),
        ("  can0  703   [1]  05  answer is missing", "answer is missing"),
        ("  can0  703   [1]  05  TIMEOUT", "TIMEOUT"),
        ("  can0  703   [1]  05  ← here", "here"),
    ] {
        assert_eq!(one(CONSOLE, &format!("{line}\n")).comment(), Some(remark), "{line}");
    }
    assert_eq!(one(CONSOLE, "  can0  703   [1]  05   '.'\n").comment(), None, "the data as characters");
}

#[test]
fn what_may_be_a_damaged_frame_is_no_remark() {
    for rest in [
        "[0]  remOte request",
        "[1]  05  06",
        "[1]  05  be careful",
        "[1]  05   can0  701   [1]  05",
        "[1]  05  # can0  701   [1]",
    ] {
        assert!(items(CONSOLE, &format!("  can0  703   {rest}\n"))[0].is_err(), "{rest}");
    }
}

#[test]
fn a_terminal_and_a_fence_around_frames_are_passed_over() {
    let text = "```\n$ candump can0\ncan0  605   [1]  40\n^C\n```\n";
    assert_eq!(items(CONSOLE, text).iter().filter(|item| item.is_ok()).count(), 1);
    assert_eq!(items(CONSOLE, text).len(), 1);
    assert!(items(CONSOLE, "$ can0  605   [1]  40\n")[0].is_err(), "a damaged space");
}

#[test]
fn directions() {
    let direction = |info: &str| one(CONSOLE, &format!("  can0  {info}  123   [1]  11\n")).direction;
    assert_eq!(direction("TX - -"), Direction::Tx);
    assert_eq!(direction("RX - -"), Direction::Rx);
}

fn times(text: &str) -> (Vec<u64>, TimeBase) {
    let (items, _, base) = read(CONSOLE, text.as_bytes());
    (items.into_iter().map(|item| item.unwrap().timestamp.nanos() / 1_000_000).collect(), base)
}

#[test]
fn every_kind_of_time() {
    let none = "  can0  123   [1]  11\n  can0  123   [1]  11\n";
    assert_eq!(times(none), (vec![0, 0], TimeBase::None));
    let date = " (2025-01-28 10:47:15.123456)  can0  123   [1]  11\n";
    assert_eq!(times(date), (vec![1_738_061_235_123], TimeBase::Local));
    let zero =
        " (000.000000)  can0  123   [1]  11\n (001.500000)  can0  123   [1]  11\n (002.000000)  can0  123   [1]  11\n";
    assert_eq!(times(zero), (vec![0, 1500, 2000], TimeBase::Start));
    let delta =
        " (000.000000)  can0  123   [1]  11\n (001.500000)  can0  123   [1]  11\n (000.500000)  can0  123   [1]  11\n";
    assert_eq!(times(delta), (vec![0, 1500, 2000], TimeBase::Start));
    assert_eq!(damage(CONSOLE, " (2025-02-30 10:47:15.123456)  can0  123   [1]  11\n").kind, DamageKind::Malformed);
}

#[test]
fn malformed_lines_are_located() {
    for (line, column, expected) in [
        ("  can0  123   [2]  11", 22, "a byte of two hex digits before the line ends"),
        ("  can0  123   [1]  11 22", 23, "the end of the line"),
        ("  can0  123   [9]  11", 16, "one digit (CAN)"),
        ("  can0  123  [09]  11 22 33 44 55 66 77 88 99", 18, "length that this kind"),
        ("  can0  12345   [1]  11", 17, "fits the kind"),
        ("  can0  1234   [1]  11", 9, "3 digits"),
        ("  can0  20000004  [08]  11 22 33 44 55 66 77 88", 19, "fits the kind"),
        (" (yesterday)  can0  123   [1]  11", 3, "a time in seconds or a date"),
    ] {
        let damage = damage(CONSOLE, &format!("{line}\n"));
        assert_eq!((damage.kind, damage.column), (DamageKind::Malformed, Some(column)), "{line}: {damage}");
        assert!(damage.expected.contains(expected), "{line}: {damage}");
    }
}

#[test]
fn losses_and_cut_frames_are_told() {
    let lost = damage(CONSOLE, "DROPCOUNT: dropped 3 CAN frames on 'can0' socket (total drops 3)\n");
    assert_eq!(lost.kind, DamageKind::Dropped(3));
    let bytes = vec!["00"; 64].join(" ");
    let cropped = format!("  can0  123  [0100] (45|81:00:12345678) {bytes} ...\n");
    assert_eq!(damage(CONSOLE, &cropped).kind, DamageKind::Truncated);
}

#[test]
fn the_last_line_without_end() {
    for whole in [
        "[2]  11 22",
        "[8]  11 22 33 44 55 66 77 88",
        "[0]  remote request",
        "[1]  A0",
        "[1]  10010000",
        "[1]  10  '.'",
    ] {
        assert!(items(CONSOLE, &format!("  can0  123   {whole}"))[0].is_ok(), "{whole}");
    }
    for cut in ["[2]  11 2", "[2]  11", "[0]", "[0]  remote", "[1]  10", "[1]  1001"] {
        let damage = items(CONSOLE, &format!("  can0  123   {cut}")).remove(0).expect_err(cut);
        assert!(damage.kind == DamageKind::Truncated || cut == "[0]  remote" || cut == "[1]  1001", "{cut}: {damage}");
    }
}

#[test]
fn recognised() {
    for text in [
        "  can0  123   [2",
        " (1700000000.123456)  can0  123   [2]  11 22\n",
        " (2025-01-28 10:47:15.123456)  can0  TX - -  12345678   {B}",
        "\x1b[31m can0  123   [2]  11 22\n",
    ] {
        assert_eq!(Format::sniff(text.as_bytes()), Some(CONSOLE), "{text}");
    }
    for text in ["can0 123", "(1700000000.123456) can0 123#11\n", "the 123 things\n"] {
        assert_ne!(Format::sniff(text.as_bytes()), Some(CONSOLE), "{text}");
    }
}

#[test]
fn a_frame_with_a_damaged_first_byte_is_no_comment() {
    for line in ["# can0  123   [2]  11 22\n", "; can0  123   [2]  11 22\n", "#1700000000.1)  can0  123   [2]  11 22\n"]
    {
        assert_eq!(damage(CONSOLE, line).kind, DamageKind::Malformed, "{line}");
    }
    assert_eq!(items(CONSOLE, "# can0 123\n# taken (1.5) s later\n"), []);
}
