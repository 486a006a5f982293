//! Lines that are easily misread: each is read as it is meant, told, or asked for.

use crate::pasted::{asks, directions, given, gives, micros, open_with, tells};
use canvass_traces::*;

const REQUEST: &str = "605#4000100000000000";
const ANSWER: &str = "585#4300100092010200";
const BEAT: &str = "705#05";
const BOTH: &[&str] = &[REQUEST, ANSWER];

#[test]
fn short_numbers_after_frames_are_no_frames() {
    for line in ["1 10 minutes later", "2 12 V", "123", "Tel: 0345 67 89 00 12", "12:30 12 40"] {
        let given = given(&format!("{}\n{}\n705 05\n{line}\n705 05\n", ID_BYTES[0], ID_BYTES[1]));
        assert_eq!(given.frames, [REQUEST, ANSWER, BEAT, BEAT], "{line}");
    }
    // It may be a page, or a frame without data.
    tells("605 40 00 10 00 00 00 00 00\n123\n585 43 00 10 00 92 01 02 00\n", BOTH, &[2]);
    gives("605 40 00 10 00 00 00 00 00\n585 43 00 10 00 92 01 02 00\n705 05\n080\n", &[REQUEST, ANSWER, BEAT, "080#"]);
    let long = "605 8 40 00 10 00 00 00 00 00\n585 8 43 00 10 00 92 01 02 00\n".repeat(5);
    tells(&format!("{long}1 1 10 minutes later\n"), &BOTH.repeat(5), &[11]);
}

const ID_BYTES: [&str; 2] = ["605 40 00 10 00 00 00 00 00", "585 43 00 10 00 92 01 02 00"];

/// A frame that is wrapped to the next line: the remainder is reported as damage, and the numbers are still read as
/// hexadecimal.
#[test]
fn wrapped_lines_do_not_change_the_radix() {
    let whole = "605 40 00 10 00 00 00 00 00\n585 43 00 10 00 92 01 02 00\n181 05 06 07 08\n705 05\n";
    let frames = [REQUEST, ANSWER, "181#05060708", BEAT].repeat(3);
    let given = given(&format!("{}585 43 00 10 00 92 01\n02 00\n123\n1 10 minutes later\n2 12 V\n", whole.repeat(3)));
    assert_eq!(&given.frames[..12], frames);
    assert_eq!((given.frames.len(), given.damages[0].place.number), (13, 14));
}

#[test]
fn two_frames_in_a_line_are_both_kept_and_told() {
    for text in [
        "605#4000100000000000 585#4300100092010200\n705#05\n",
        "605 8 40 00 10 00 00 00 00 00 585 8 43 00 10 00 92 01 02 00\n705 1 05\n605 8 40 00 10 00 00 00 00 00\n",
        "t60584000100000000000 t58584300100092010200\nt705105\n",
    ] {
        let given = given(text);
        assert_eq!(&given.frames[..2], [REQUEST, BEAT], "{text}");
        assert_eq!(given.records[0].comment(), None, "{text}");
        let [damage] = &given.damages[..] else { panic!("{text}: {:?}", given.damages) };
        assert_eq!(damage.place.number, 1);
        let second = damage.salvaged.as_ref().map(|record| record.notation().to_string());
        assert_eq!(second.as_deref(), Some(ANSWER), "{text}");
    }
    let given = given("605 8 40 00 10 00 00 00 00 00 ; 585 8 43 00 10 00 92 01 02 00\n705 1 05\n");
    assert_eq!((given.frames.as_slice(), given.damages.len()), (&[REQUEST, BEAT].map(String::from)[..], 1));
}

#[test]
fn error_frames_are_no_data_frames() {
    let print = "Timestamp:        0.100000    ID:      605    S Tx                DL:  8    40 00 10 00 00 00 00 00     Channel: can0
Timestamp:        0.101000    ID:      004    S Rx E              DL:  8    00 08 00 00 00 00 60 00     Channel: can0\n";
    gives(print, &[REQUEST, "20000004#0008000000006000"]);
    gives(
        "Time,ID,Type,DLC,Data\n0.100100,004,Error Frame,8,00 08 00 00 00 00 60 00\n0.101000,585,CAN Frame,8,43 00 10 00 92 01 02 00\n",
        &["20000004#0008000000006000", ANSWER],
    );
    let given = gives(
        "Chn Identifier Flg   DLC  D0...1...2...3...4...5...6..D7       Time     Dir
 0       605           8  40  00  10  00  00  00  00  00      10.123450 T
 0    ErrorFrame                                              10.200000 R
 0       705           1  05                                  10.500000 R\n",
        &[REQUEST, "20000080#", BEAT],
    );
    assert_eq!(given.records[1].direction, Direction::Rx);
}

#[test]
fn flags_have_values() {
    for line in [
        "ID 605 EXT 0 LEN 8 DATA 40 00 10 00 00 00 00 00",
        "ID 605 RTR 0 LEN 8 DATA 40 00 10 00 00 00 00 00",
        "ID 0x605 EXT 0 RTR 0 DLC 8 DATA 40 00 10 00 00 00 00 00",
        "id=0x605 ext=false rtr=false dlc=8 data=40 00 10 00 00 00 00 00",
        "id=0x605 is_extended=False dlc=8 data=40 00 10 00 00 00 00 00",
        "StdId: 0x605, IDE: 0, RTR: 0, DLC: 8, Data: 40 00 10 00 00 00 00 00",
        "r 605 8 40 00 10 00 00 00 00 00",
        "R 605 8 40 00 10 00 00 00 00 00",
        "605 R 8 40 00 10 00 00 00 00 00",
    ] {
        gives(&format!("{line}\n{line}\n"), &[REQUEST, REQUEST]);
    }
    let wide = "id=0x605 is_extended=True dlc=8 data=40 00 10 00 00 00 00 00\n";
    gives(&wide.repeat(2), &["00000605#4000100000000000"; 2]);
    let with_data = "ID: 605 RTR: 1 DLC: 2 Data: 01 02\nID: 605 RTR: 0 DLC: 2 Data: 01 02\n";
    tells(with_data, &["605#0102"], &[1]);
    gives("ID: 0x605 IDE: 1 RTR: 1 DLC: 4\nID: 0x605 IDE: 0 RTR: 0 DLC: 2 Data: 01 02\n", &["00000605#R4", "605#0102"]);
    let given = gives(
        "t 605 8 40 00 10 00 00 00 00 00\nr 585 8 43 00 10 00 92 01 02 00\nr 705 1 05\n",
        &[REQUEST, ANSWER, BEAT],
    );
    assert_eq!(directions(&given), [Direction::Tx, Direction::Rx, Direction::Rx]);
    gives(
        "0.1 605 8 40 00 10 00 00 00 00 00\n0.2 705 R\n0.35 705 RTR 1\n0.4123 705 1 RTR\n",
        &[REQUEST, "705#R", "705#R1", "705#R1"],
    );
}

/// Texts whose numbers look like frames.
const INVENTED: &[(&str, &str)] = &[
    ("a timetable", "Bus 605 05 15 25 35 45 55\nBus 606 08 18 28 38 48 58\n"),
    ("a timetable without words", "601 05 12 23 34 41 07\n602 01 09 14 22 38 40\n603 08 11 19 27 33 45\n"),
    ("lottery", "Draw results\n601 05 12 23 34 41 07\n602 01 09 14 22 38 40\n603 08 11 19 27 33 45\n"),
    ("telephones", "Office: 0345 67 89 00 12\nTel: 0145 67 89 01 23\n"),
    ("one telephone", "Hello,\ncall me: Tel: 0345 67 89 00 12\nRegards\n"),
    ("an array", "  0x01, 0x02, 0x40, 0x10,\n  0x605, 0x02, 0x40, 0x10,\n  0x100, 0x04, 0x10, 0x20, 0x30, 0x40,\n"),
    ("an array with short lines", "0x605, 0x01, 0x02,\n0x100, 0x01, 0xA2,\n"),
    ("registers", "100: 0A 00 00 01\n101: 00 FF 00 00\n102: 11 22 33 44\n"),
    ("registers of 16 bits", "100: 1234 00ff\n102: 5678 0a0b\n"),
    ("registers by four", "100: 0A 00 00 01\n104: 00 FF 00 00\n108: 11 22 33 44\n"),
    (
        "a dump with a gap",
        "00000000: 40 00 10 00 00 00 00 00\n00000008: 43 00 10 00 92 01 02 00\n*\n00000040: 05 ff ff ff ff ff ff ff\n00000048: 05 ff ff ff ff ff ff ff\n",
    ),
    (
        "a short dump with a gap",
        "100: 40 00 10 00 00 00 00 00\n108: 43 00 10 00 92 01 02 00\n*\n140: 05 ff ff ff ff ff ff ff\n148: 05 ff ff ff ff ff ff ff\n",
    ),
    ("hashes", "abc 0123456789abcdef\n1de fedcba9876543210\n"),
    ("more hashes", "1de fedcba9876543210\n1aa 0123456789abcdef\n5cd 8f14e45fceea167a\n"),
    ("nm", "00000100 0000000000000010\n00000400 00000000000000ff\n00001000 0000000000001234\n"),
    ("sensors", "time,id,size,data\n0.1,101,2,1234\n0.2,102,2,5678\n0.3,103,2,9012\n"),
    ("orders", "Order ID,Type,Size,Date,Data\n4711,A,3,2023-05-01,12 05 06\n4712,B,2,2023-05-02,12 05\n"),
    ("issues", "see owner/repo#123 and 123#45 for the details\nfee#12 see note\n123#45 is fixed\n"),
    ("LIN", "0.100 LIN1 13C 8 01 02 03 04 05 06 07 08\n0.200 LIN1 17D 8 01 02 03 04 05 06 07 ff\n"),
    ("I2C", "0.001 W 50 2 00 10\n0.002 R 50 4 AA BB CC DD\n"),
    ("Modbus", "TX 01 03 00 00 00 0A C5 CD\nRX 01 03 04 00 01 00 02 2A 32\n"),
    ("S-records", "S00600004844521B\nS1130000285F245F2212226A000424290008237C2A\nS9030000FC\n"),
    (
        "Intel hex",
        ":10010000214601360121470136007EFE09D2190140\n:100110002146017E17C20001FF5F16002148011928\n:00000001FF\n",
    ),
    (
        "lspci",
        "00: 86 80 00 0c 06 00 10 00 06 00 00 06 00 00 00 00\n10: 04 00 00 f6 00 00 00 00 00 00 00 00 00 00 00 00\n100: 01 00 00 00\n",
    ),
    ("prices", "Pos 100 2 10 12\nItem 300 3 05 06 07\n"),
    ("section numbers", "see section 123 [4] of the manual\nsection 123 [4]\n"),
    ("scores", "100 3 10 20 30\n200 3 11 21 31\n300 3 12 22 32\n"),
];

#[test]
fn no_frames_are_invented() {
    let wrong: Vec<String> = INVENTED
        .iter()
        .filter_map(|(what, text)| {
            let given = open_with(text, None).ok()?;
            Some(format!("{what}: {:?} {:?}", given.frames, given.interpretation))
        })
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn identifiers_in_tables_may_be_decimal() {
    gives("Time (s),ID (dec),DLC,Data\n0.1,1541,8,4000100000000000\n0.2,385,1,43\n", &[REQUEST, "181#43"]);
    gives("Time (s),ID (hex),DLC,Data\n0.1,605,8,4000100000000000\n0.2,385,1,43\n", &[REQUEST, "385#43"]);
    gives(
        "Time (s),ID,Extended,DLC,Data\n0.1,1541,false,8,4000100000000000\n0.2,385,false,1,43\n",
        &[REQUEST, "181#43"],
    );
    let decimal = "timestamp,id,dlc,data\n0.100100,1541,8,4000100000000000\n0.101000,1413,8,4300100092010200\n";
    asks(
        decimal,
        [("id[hex],data", &["00001541#4000100000000000", "00001413#4300100092010200"]), ("id[dec],data", BOTH)],
    );
}

#[test]
fn labelled_identifiers_may_be_decimal() {
    let text = "id=1541 len=8 data=40 00 10 00 00 00 00 00\nid=1413 len=8 data=43 00 10 00 92 01 02 00\n";
    asks(
        text,
        [("id[hex],len,data", &["00001541#4000100000000000", "00001413#4300100092010200"]), ("id[dec],len,data", BOTH)],
    );
    gives("id=0x605 len=8 data=40 00 10 00 00 00 00 00\nid=0x1541 len=1 data=43\n", &[REQUEST, "00001541#43"]);
    let mixed = "385 4 00 01 A2 00\n641 4 12 00 0C 01\n385 4 00 02 A2 00\n1541 8 40 00 10 00 00 00 00 00\n1413 8 43 00 10 00 92 01 02 00\n";
    let error = open_with(mixed, None).err().unwrap().to_string();
    assert!(error.contains("id[dec]"), "{error}");
    let one =
        "385 8 0 1 A2 0 0 FF 3 0\n641 4 12 0 C 1\n128 0\n1797 1 5\n385 8 0 2 A2 0 0 FF 3 0\n641 4 12 0 C 1\n128 0\n";
    assert!(open_with(one, None).err().unwrap().to_string().contains("id[dec]"), "a single one of four digits");
    let given = open_with(mixed, Some("id[dec],len,data")).unwrap();
    assert_eq!(given.frames, ["181#0001A200", "281#12000C01", "181#0002A200", REQUEST, ANSWER]);
}

#[test]
fn groups_of_bytes_after_a_label_are_all_read() {
    for text in [
        "ID: 605 Data: 4000 1000 0000 0000\nID: 585 Data: 4300 1000 9201 0200\n",
        "ID: 605 Data: 40001000 00000000\nID: 585 Data: 43001000 92010200\n",
        "ID: 605 DLC: 8 Data: 40001000 00000000\nID: 585 DLC: 8 Data: 43001000 92010200\n",
    ] {
        gives(text, BOTH);
    }
}

#[test]
fn counters_after_the_frame_are_no_bytes() {
    let row = |n: usize, beat: usize| {
        format!("   0.{n:03}000    1        705         1  05                              {beat:4}\n")
    };
    let rows: String = (0..30).map(|n| row(n, n + 1)).collect();
    let head = "       Time Chan Identifier Flags  DLC  Data                      Counter\n";
    let given = gives(&format!("{head}{rows}"), &[BEAT; 30]);
    assert_eq!(micros(&given)[29], 29_000);
}

#[test]
fn words_of_digits_after_the_frame_are_no_bytes() {
    let given = gives("605 [8] 40 00 10 00 00 00 00 00\n705 [1] 05 be careful\n", &[REQUEST, BEAT]);
    assert_eq!(given.records[1].comment(), Some("be careful"));
    tells("605 40 00 10 00 00 00 00 00\n705 05 de nuevo operativo\n705 7F\n", &[REQUEST, "705#7F"], &[2]);
}

#[test]
fn decimal_bytes_in_tables() {
    let head = "Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8\n";
    gives(
        &format!("{head}100100,605,false,Tx,0,8,64,0,16,0,0,0,0,0\n101000,585,false,Rx,0,8,67,0,16,0,146,1,2,0\n"),
        BOTH,
    );
    gives(
        &format!("{head}100100,605,false,Tx,0,8,40,0,10,0,0,0,0,0\n101000,585,false,Rx,0,8,43,0,10,0,92,1,2,F\n"),
        &[REQUEST, "585#430010009201020F"],
    );
    let doubtful =
        format!("{head}100100,605,false,Tx,0,8,40,0,10,0,0,0,0,0\n101000,585,false,Rx,0,8,43,0,10,0,92,1,2,0\n");
    asks(&doubtful, [("id,data[hex]", BOTH), ("id,data[dec]", &["605#28000A0000000000", "585#2B000A005C010200"])]);
    gives(
        "Index,Time,Channel,Dir,ID,Type,Format,DLC,D0,D1,D2,D3,D4,D5,D6,D7\n0,10:00:00.100,0,Tx,0x605,DATA,STANDARD,8,40,00,10,00,00,00,00,00\n1,10:00:00.500,0,Rx,0x705,DATA,STANDARD,1,05,00,00,00,00,00,00,00\n",
        &[REQUEST, BEAT],
    );
}

#[test]
fn characters_before_the_channel() {
    let given = gives(
        "Timestamp: 1620000000.100000        ID:      605    S Tx                DL:  8    40 00 10 00 00 00 00 00     Channel: can0
Timestamp: 1620000000.200000        ID:      705    S Rx                DL:  4    41 42 43 44                 'ABCD' Channel: can1
Timestamp: 1620000000.300000        ID:      705    S Rx                DL:  4    41 20 43 2C                 'A C,' Channel: can1\n",
        &[REQUEST, "705#41424344", "705#4120432C"],
    );
    assert_eq!(given.channels, ["can0", "can1"]);
    assert_eq!(given.records.iter().map(|record| record.channel.0).collect::<Vec<_>>(), [0, 1, 1]);
    assert!(given.records.iter().all(|record| record.comment().is_none()));
}

#[test]
fn eight_digits_beside_wide_identifiers_are_asked() {
    let text = "0.100100 00000605 8 40 00 10 00 00 00 00 00\n0.101000 00000585 8 43 00 10 00 92 01 02 00\n0.500000 18FF1234 1 05\n";
    asks(
        text,
        [
            ("time[s],id[11],len,data", &[REQUEST, ANSWER, "18FF1234#05"]),
            ("time[s],id[29],len,data", &["00000605#4000100000000000", "00000585#4300100092010200", "18FF1234#05"]),
        ],
    );
}

fn bytes(text: Vec<u8>) -> Vec<String> {
    let capture = Capture::from_source("pasted", Source::from_bytes(text), &ReadOptions::default());
    let frame = |record: Record| record.notation().to_string();
    capture.unwrap().map(|item| item.map_or_else(|damage| damage.to_string(), frame)).collect()
}

#[test]
fn texts_of_other_editors() {
    let text = "605#4000100000000000\r\n585#4300100092010200\r\n";
    let little: Vec<u8> = [0xFF, 0xFE].into_iter().chain(text.encode_utf16().flat_map(u16::to_le_bytes)).collect();
    let big: Vec<u8> = [0xFE, 0xFF].into_iter().chain(text.encode_utf16().flat_map(u16::to_be_bytes)).collect();
    assert_eq!(bytes(little), BOTH, "UTF-16, as Windows writes it");
    assert_eq!(bytes(big), BOTH);
    assert_eq!(
        bytes(b"t60584000100000000000\rt58584300100092010200\rt705105\r".to_vec()),
        [REQUEST, ANSWER, BEAT],
        "CR"
    );
    let hard = "605\u{a0}8\u{a0}40\u{a0}00 10 00 00 00 00 00\n585\u{a0}8\u{a0}43 00 10 00 92 01 02 00\n";
    assert_eq!(bytes(hard.as_bytes().to_vec()), BOTH, "blanks that do not break");
}

#[test]
fn columns_open_lines_of_a_console_too() {
    let text = "can0 605 [8] 40 00 10 00 00 00 00 00\ncan0 585 [8] 43 00 10 00 92 01 02 00\n";
    let given = open_with(text, Some("channel,id,len,data")).unwrap();
    assert_eq!(
        (given.format, given.frames.as_slice()),
        (Format::Pasted, &BOTH.iter().map(|s| (*s).to_owned()).collect::<Vec<_>>()[..])
    );
    // One line like candump's in a text of others does not decide.
    let most =
        "see can0 123 [4] 01 02 03 04\n".to_owned() + &"12:00:01.100 605 [8] 40 00 10 00 00 00 00 00\n".repeat(4);
    assert_eq!(given_format(&most), Format::Pasted);
}

fn given_format(text: &str) -> Format {
    given(text).format
}
