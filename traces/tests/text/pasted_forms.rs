//! Further forms that other tools write, and random frames in each form.

use crate::pasted::{given, gives};
use canvass_traces::*;
use proptest::prelude::*;
use std::fmt::Write;

const REQUEST: &str = "605#4000100000000000";
const ANSWER: &str = "585#4300100092010200";
const BEAT: &str = "705#05";

/// Texts in the forms of tools, each with the tool and a request, its answer, and perhaps a heartbeat.
const FORMS: &[(&str, &str)] = &[
    (
        "python-can 4, print",
        "Timestamp:        0.100000    ID:      605    S Tx                DL:  8    40 00 10 00 00 00 00 00     Channel: can0
Timestamp:        0.101000    ID:      585    S Rx                DL:  8    43 00 10 00 92 01 02 00     Channel: can0
Timestamp:        0.500000    ID:      705    S Rx                DL:  1    05                          Channel: can0\n",
    ),
    (
        "python-can 2, print",
        "Timestamp:        0.100000    ID: 0605    000    DLC: 8    40 00 10 00 00 00 00 00
Timestamp:        0.101000    ID: 0585    000    DLC: 8    43 00 10 00 92 01 02 00
Timestamp:        0.500000    ID: 0705    000    DLC: 1    05\n",
    ),
    (
        "CRTD of OVMS",
        "1320745424.100000 CXX OVMS CRTD
1320745424.100000 T11 605 40 00 10 00 00 00 00 00
1320745424.101000 R11 585 43 00 10 00 92 01 02 00
1320745424.500000 R11 705 05\n",
    ),
    (
        "CRTD with bus numbers",
        "1320745424.100000 1T11 605 40 00 10 00 00 00 00 00
1320745424.101000 1R11 585 43 00 10 00 92 01 02 00
1320745424.500000 1R11 705 05\n",
    ),
    (
        "arduino-CAN, labels with equal signs",
        "ID=0x605  DLC=8  DATA=40 00 10 00 00 00 00 00 \nID=0x585  DLC=8  DATA=43 00 10 00 92 01 02 00 \nID=0x705  DLC=1  DATA=05 \n",
    ),
    (
        "arduino-CAN, short labels",
        "ID:0x605,L:8,D:0x40 0x0 0x10 0x0 0x0 0x0 0x0 0x0 \nID:0x585,L:8,D:0x43 0x0 0x10 0x0 0x92 0x1 0x2 0x0 \nID:0x705,L:1,D:0x5 \n",
    ),
    (
        "mcp_can, without length",
        "ID: 605  Data: 40 00 10 00 00 00 00 00 \nID: 585  Data: 43 00 10 00 92 01 02 00 \nID: 705  Data: 05 \n",
    ),
    (
        "PEAK TRC 2.1 without head",
        "      1       100.100 DT 1      0605 Tx -  8    40 00 10 00 00 00 00 00
      2       101.000 DT 1      0585 Rx -  8    43 00 10 00 92 01 02 00
      3       500.000 DT 1      0705 Rx -  1    05\n",
    ),
    (
        "PEAK TRC 1.3 without head",
        "     1)       100.100 1  Tx        0605 -  8    40 00 10 00 00 00 00 00
     2)       101.000 1  Rx        0585 -  8    43 00 10 00 92 01 02 00
     3)       500.000 1  Rx        0705 -  1    05\n",
    ),
    (
        "candump before 2010",
        "  can0  <0x605> [8] 40 00 10 00 00 00 00 00\n  can0  <0x585> [8] 43 00 10 00 92 01 02 00\n  can0  <0x705> [1] 05\n",
    ),
    (
        "CSS Electronics, CSV",
        "TimestampEpoch;BusChannel;ID;IDE;DLC;DataLength;Dir;EDL;BRS;DataBytes
1593687602.100000;1;605;0;8;8;1;0;0;4000100000000000
1593687602.101000;1;585;0;8;8;0;0;0;4300100092010200
1593687602.500000;1;705;0;1;1;0;0;0;05\n",
    ),
    (
        "CSS Electronics CL1000",
        "# Logger type: CL1000\n# Value separator: \";\"\nTimestamp;Type;ID;Data
30T104423567;0;605;4000100000000000\n30T104423568;0;585;4300100092010200\n30T104423967;0;705;05\n",
    ),
    (
        "SavvyCAN without direction",
        "Time Stamp,ID,Extended,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8
100100,00000605,false,0,8,40,00,10,00,00,00,00,00\n101000,00000585,false,0,8,43,00,10,00,92,01,02,00\n500000,00000705,false,0,1,05\n",
    ),
    (
        "BUSMASTER's window",
        "12:00:00:1001 Tx 1 0x605 s 8 40 00 10 00 00 00 00 00 \n12:00:00:1010 Rx 1 0x585 s 8 43 00 10 00 92 01 02 00 \n12:00:00:5000 Rx 1 0x705 s 1 05 \n",
    ),
    (
        "a table in Markdown",
        "| id | len | data |\n|---|---|---|\n| 605 | 8 | 40 00 10 00 00 00 00 00 |\n| 585 | 8 | 43 00 10 00 92 01 02 00 |\n| 705 | 1 | 05 |\n",
    ),
    (
        "cansniffer, cangen -v: bytes with commas",
        "605, 8, 40, 00, 10, 00, 00, 00, 00, 00\n585, 8, 43, 00, 10, 00, 92, 01, 02, 00\n705, 1, 05\n",
    ),
    (
        "a log of a program",
        "[2024-03-01 12:00:00.100] can0 TX 0x605 [8] 40 00 10 00 00 00 00 00
[2024-03-01 12:00:00.101] can0 RX 0x585 [8] 43 00 10 00 92 01 02 00
[2024-03-01 12:00:00.500] can0 RX 0x705 [1] 05\n",
    ),
    (
        "times as ISO 8601 writes them",
        "2024-03-01T12:00:00.100Z 605h 8 40 00 10 00 00 00 00 00\n2024-03-01T12:00:00.101Z 585h 8 43 00 10 00 92 01 02 00\n2024-03-01T12:00:00.500Z 705h 1 05\n",
    ),
    (
        "arrows",
        "→ 605 40 00 10 00 00 00 00 00\n← 585 43 00 10 00 92 01 02 00\n← 705 05\n",
    ),
    (
        "a list",
        "- 605: 40 00 10 00 00 00 00 00\n- 585: 43 00 10 00 92 01 02 00\n- 705: 05\n",
    ),
    (
        "bytes together",
        "0.100000 605 8 4000100000000000\n0.101000 585 8 4300100092010200\n0.500000 705 1 05\n",
    ),
    (
        "decimal numbers",
        "1541 8 64 0 16 0 0 0 0 0\n1413 8 67 0 16 0 146 1 2 0\n1797 1 5\n",
    ),
    (
        "SLCAN with times",
        "t605840001000000000001234\nt585843001000920102001238\nt7051051300\n",
    ),
    (
        "Windows tools with tabs",
        "1\t0.100100\tTx\t605\t8\t40 00 10 00 00 00 00 00\n2\t0.101000\tRx\t585\t8\t43 00 10 00 92 01 02 00\n3\t0.500000\tRx\t705\t1\t05\n",
    ),
    (
        "identifiers with x and quotes",
        "\"605\";\"8\";\"40 00 10 00 00 00 00 00\"\n\"585\";\"8\";\"43 00 10 00 92 01 02 00\"\n\"705\";\"1\";\"05\"\n",
    ),
];

#[test]
fn each_form_gives_the_dialogue() {
    let mut wrong = Vec::new();
    for (tool, text) in FORMS {
        match crate::pasted::open_with(text, None) {
            Ok(given) if given.frames == [REQUEST, ANSWER, BEAT] && given.damages.is_empty() => {}
            Ok(given) => {
                wrong.push(format!("{tool}: {:?} {:?} {:?}", given.frames, given.damages, given.interpretation));
            }
            Err(error) => wrong.push(format!("{tool}: {error}")),
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn each_form_has_the_same_times() {
    for (tool, text) in FORMS {
        let given = given(text);
        if given.base == TimeBase::None {
            continue;
        }
        let [first, second, last] = &given.records[..] else { panic!("{tool}") };
        let gaps = [second.timestamp - first.timestamp, last.timestamp - first.timestamp];
        let close = |gap: Duration, millis: u64| gap.nanos().abs_diff(millis * 1_000_000) <= 1_000_000;
        assert!(close(gaps[0], 1) && close(gaps[1], 400), "{tool}: {gaps:?}");
    }
}

#[test]
fn identifiers_of_29_bits() {
    for text in [
        "0.1000 18FF1234x 3 01 02 03\n0.2000 605 1 05\n",
        "18FF1234 [3] 01 02 03\n605 [1] 05\n",
        "ID: 18ff1234    X Rx                DL:  3    01 02 03\nID: 605    S Rx                DL:  1    05\n",
        "12:00:00:0001 Rx 1 0x18FF1234 x 3 01 02 03 \n12:00:00:0002 Rx 1 0x605 s 1 05 \n",
        "T18FF12343010203\nt605105\n",
        "18FF1234#010203\n605#05\n",
        "1.0000 1R29 18FF1234 01 02 03\n2.0000 1R11 605 05\n",
    ] {
        gives(text, &["18FF1234#010203", "605#05"]);
    }
    gives(
        "Extended ID: 0x00000605 DLC: 1 Data: 0x05\nExtended ID: 0x18FF1234 DLC: 1 Data: 0x06\n",
        &["00000605#05", "18FF1234#06"],
    );
}

#[test]
fn remote_frames() {
    gives("Rx 605 8 40 00 10 00 00 00 00 00\nTx 705 1 RTR\n", &[REQUEST, "705#R1"]);
    gives("605 [8] 40 00 10 00 00 00 00 00\n705 [1]  remote request\n", &[REQUEST, "705#R1"]);
    gives("t60584000100000000000\nr7051\n", &[REQUEST, "705#R1"]);
}

#[test]
fn can_fd() {
    let bytes = (0..12).map(|n| format!("{n:02X}")).collect::<Vec<_>>();
    gives(
        &format!("FD 605 12 {}\nFD 605 8 40 00 10 00 00 00 00 00\n", bytes.join(" ")),
        &[&format!("605##4{}", bytes.concat()), "605##44000100000000000"],
    );
}

/// The ways to write a frame of the property tests.
const WAYS: usize = 10;

fn write_frame(way: usize, n: usize, record: &Record) -> String {
    let (frame, mut text) = (&record.frame, String::new());
    let id = frame.id().raw();
    let spaced = hex::spaced(frame.data()).to_string();
    let len = frame.len();
    let x = if frame.id().is_extended() { "x" } else { "" };
    let kind = if frame.id().is_extended() { "X" } else { "S" };
    let time = format!("{}.{:06}", n / 10, n % 10 * 100_000);
    match way {
        0 => write!(text, "   {time} 1  {id:X}{x}             Rx   d {len} {spaced}"),
        1 => write!(text, "Timestamp: {time}    ID: {id:08x}    {kind} Rx                DL: {len}    {spaced}"),
        2 => write!(text, "12:00:{:02}:{:04} Rx 1 0x{id:03X} {} {len} {spaced}", n / 60, n, kind.to_lowercase()),
        3 => write!(text, "> {} {} [{len}] {spaced}", ["can0", "can1"][n % 2], frame.id()),
        4 => write!(text, "{}", record.notation()),
        5 => {
            let letter = if x.is_empty() { 't' } else { 'T' };
            write!(text, "{letter}{}{len}{}", frame.id(), hex::compact(frame.data()))
        }
        6 => {
            let bytes: Vec<String> = frame.data().iter().map(|byte| format!("0x{byte:02X}")).collect();
            write!(
                text,
                "ID: 0x{id:08X}, {}, DLC: {len}, Data: {}",
                if x.is_empty() { "Std" } else { "Ext" },
                bytes.join(" ")
            )
        }
        7 => {
            let bytes: Vec<String> = frame.data().iter().map(|byte| format!(",{byte:02X}")).collect();
            write!(text, "{},{id:08X},{},Rx,0,{len}{}", n * 100_000, !x.is_empty(), bytes.concat())
        }
        8 => write!(text, "{time} ; {id:0width$X} ; {len} ; {spaced}", width = if x.is_empty() { 3 } else { 8 }),
        _ => write!(text, "{n}) {time} {} {len} {spaced}   <-- remark {n}", frame.id()),
    }
    .unwrap();
    text.push('\n');
    text
}

fn frames() -> impl Strategy<Value = Vec<Frame>> {
    let id =
        prop_oneof![(0..0x800_u32).prop_map(CanId::standard_masked), any::<u32>().prop_map(CanId::extended_masked)];
    let frame = (id, prop::collection::vec(any::<u8>(), 0..=8)).prop_map(|(id, data)| Frame::new(id, &data).unwrap());
    prop::collection::vec(frame, 1..20)
}

proptest! {
    /// Two frames that show what the columns mean come first.
    #[test]
    fn random_frames_in_each_form_come_back(frames in frames(), way in 0..WAYS) {
        let known = ["585#43001000FA010203", "18FF1234#0A0B"].map(|text| parse_frame(text).unwrap().frame);
        let records: Vec<Record> =
            known.into_iter().chain(frames).map(|frame| Record::new(Timestamp(0), ChannelId(0), frame)).collect();
        let head = if way == 7 { "Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8\n" } else { "" };
        let lines: Vec<String> = records.iter().enumerate().map(|(n, record)| write_frame(way, n, record)).collect();
        let given = given(&format!("{head}{}", lines.concat()));
        let written: Vec<String> = records.iter().map(|record| record.notation().to_string()).collect();
        prop_assert_eq!(&given.frames, &written, "{}", lines.concat());
        prop_assert!(given.damages.is_empty());
        if way == WAYS - 1 {
            let remarks: Vec<_> = given.records.iter().map(|record| record.comment().unwrap_or_default()).collect();
            prop_assert_eq!(remarks, (0..records.len()).map(|n| format!("remark {n}")).collect::<Vec<_>>());
        }
    }
}
