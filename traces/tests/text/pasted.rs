//! A dialogue with a drive in the forms in which people paste it.

use canvass_traces::*;

/// What a text gives: format, frames in candump's notation, direction letters, remarks, damages.
pub struct Given {
    pub format: Format,
    pub frames: Vec<String>,
    pub records: Vec<Record>,
    pub damages: Vec<Damage>,
    pub channels: Vec<String>,
    pub base: TimeBase,
    pub interpretation: Option<String>,
}

/// Rows with brackets are candump's only if an interface is before the identifier.
#[test]
fn times_and_directions_are_no_interfaces() {
    for before in ["12:00:01.100", "0.100", "[12:00:01.100]", "Rx", "1000"] {
        let text = format!(
            "{before} 605 [8] 40 00 10 00 00 00 00 00\n{before} 585 [8] 43 00 10 00 92 01 02 00\n{before} 705 [1] 05\n"
        );
        let Ok(given) = open_with(&text, Some("time[ms],id,len,data")).or_else(|_| open_with(&text, None)) else {
            panic!("{text}")
        };
        assert_eq!(given.format, Format::Pasted, "{before}");
    }
}

/// Columns that fit no line, and texts without frames, are told.
#[test]
fn columns_that_fit_nothing_are_told() {
    let text = "0.100 605 8 40 00 10 00 00 00 00 00\n";
    let error = open_with(text, Some("id[dec],len,data[dec]")).err().unwrap();
    assert!(matches!(error, OpenError::Misfit { .. }), "{error}");
    let options = ReadOptions { format: Some(Format::Pasted), ..ReadOptions::default() };
    let error = Capture::from_source("prose", Source::from_bytes("No frame is here.\n"), &options).err().unwrap();
    assert!(matches!(error, OpenError::Misfit { .. }), "{error}");
}

/// Times beyond all units do not stop the program.
#[test]
fn immense_times_are_read_or_told() {
    let row = |time: &str| format!("{time} 605 8 40 00 10 00 00 00 00 00\n");
    let text =
        [row("9999999999999999999.5").repeat(50), (row("1.5") + &row("9999999999999999999.5")).repeat(8)].concat();
    let _ = open_with(&text, None);
}

pub fn open_with(text: &str, columns: Option<&str>) -> Result<Given, OpenError> {
    let columns = columns.map(|columns| columns.parse().unwrap());
    let options = ReadOptions { columns, ..ReadOptions::default() };
    let mut capture = Capture::from_source("pasted", Source::from_bytes(text), &options)?;
    let (mut records, mut damages) = (Vec::new(), Vec::new());
    for item in capture.by_ref() {
        match item {
            Ok(record) => records.push(record),
            Err(damage) => damages.push(damage),
        }
    }
    Ok(Given {
        format: capture.format(),
        frames: records.iter().map(|record| record.notation().to_string()).collect(),
        records,
        damages,
        channels: capture.channels().names().map(String::from).collect(),
        base: capture.time_base(),
        interpretation: capture.interpretation(),
    })
}

pub fn given(text: &str) -> Given {
    open_with(text, None).unwrap_or_else(|error| panic!("{text}\n{error}"))
}

const REQUEST: &str = "605#4000100000000000";
const ANSWER: &str = "585#4300100092010200";
const BEAT: &str = "705#05";

/// Checks the frames of a text, and that nothing is damaged.
#[track_caller]
pub fn gives(text: &str, frames: &[&str]) -> Given {
    let given = given(text);
    assert_eq!(given.frames, frames, "{text}\n{:?}", given.interpretation);
    assert_eq!(given.damages, [], "{text}");
    assert_eq!(given.format == Format::Pasted, given.interpretation.is_some(), "{text}");
    given
}

pub fn micros(given: &Given) -> Vec<u64> {
    given.records.iter().map(|record| record.timestamp.nanos() / 1_000).collect()
}

pub fn directions(given: &Given) -> Vec<Direction> {
    given.records.iter().map(|record| record.direction).collect()
}

#[test]
fn printed_by_a_sketch() {
    gives(
        "Standard ID: 0x605  DLC: 8  Data: 0x40 0x00 0x10 0x00 0x00 0x00 0x00 0x00\n\
         Standard ID: 0x585  DLC: 8  Data: 0x43 0x00 0x10 0x00 0x92 0x01 0x02 0x00\n",
        &[REQUEST, ANSWER],
    );
}

#[test]
fn rows_of_asc_without_head() {
    let given = gives(
        "   0.100100 1  605             Tx   d 8 40 00 10 00 00 00 00 00\n\
         \u{20}  0.101000 1  585             Rx   d 8 43 00 10 00 92 01 02 00\n\
         \u{20}  0.500000 1  705             Rx   d 1 05\n",
        &[REQUEST, ANSWER, BEAT],
    );
    assert_eq!(micros(&given), [100_100, 101_000, 500_000]);
    assert_eq!(given.channels, ["1"]);
}

#[test]
fn busmaster() {
    let given = gives(
        "***BUSMASTER Ver 3.2.2***\n***PROTOCOL CAN***\n***NOTE: PLEASE DO NOT EDIT THIS DOCUMENT***\n\
         ***[START LOGGING SESSION]***\n***START DATE AND TIME 8:1:2024 19:7:12:345***\n***HEX***\n***SYSTEM MODE***\n\
         ***START CHANNEL BAUD RATE***\n***CHANNEL 1 - Kvaser - Leaf Light - 500000 bps***\n\
         ***END CHANNEL BAUD RATE***\n***START DATABASE FILES***\n***END DATABASE FILES***\n\
         ***<Time><Tx/Rx><Channel><CAN ID><Type><DLC><DataBytes>***\n\
         19:07:12:3500 Tx 1 0x605 s 8 40 00 10 00 00 00 00 00 \n19:07:12:3510 Rx 1 0x585 s 8 43 00 10 00 92 01 02 00 \n\
         19:07:12:8510 Rx 1 0x705 s 1 05 \n***END DATE AND TIME 8:1:2024 19:7:13:0***\n***[STOP LOGGING SESSION]***\n",
        &[REQUEST, ANSWER, BEAT],
    );
    let seconds = 19 * 3600 + 7 * 60 + 12;
    assert_eq!(micros(&given), [350_000, 351_000, 851_000].map(|micros| seconds * 1_000_000 + micros));
    assert_eq!(directions(&given), [Direction::Tx, Direction::Rx, Direction::Rx]);
}

#[test]
fn canking() {
    let given = gives(
        "Chn Identifier Flg   DLC  D0...1...2...3...4...5...6..D7       Time     Dir\n\
         \u{20}0    00000605         8  40  00  10  00  00  00  00  00      10.123450 T\n\
         \u{20}0    00000585         8  43  00  10  00  92  01  02  00      10.124100 R\n\
         \u{20}0    00000705         1  05                                  10.500000 R\n",
        &[REQUEST, ANSWER, BEAT],
    );
    assert_eq!(micros(&given), [10_123_450, 10_124_100, 10_500_000]);
    assert_eq!(directions(&given), [Direction::Tx, Direction::Rx, Direction::Rx]);
    assert!(given.records.iter().all(|record| record.comment().is_none()));
}

#[test]
fn trace_window_of_canoe() {
    let given = gives(
        "Time\tChn\tID\tName\tEvent Type\tDir\tDLC\tData length\tData\n\
         0.100100\tCAN 1\t605\t\tCAN Frame\tTx\t8\t8\t40 00 10 00 00 00 00 00\n\
         0.101000\tCAN 1\t585\t\tCAN Frame\tRx\t8\t8\t43 00 10 00 92 01 02 00\n",
        &[REQUEST, ANSWER],
    );
    assert_eq!(micros(&given), [100_100, 101_000]);
    assert_eq!(directions(&given), [Direction::Tx, Direction::Rx]);
    assert_eq!(given.channels, ["CAN 1"]);
}

#[test]
fn lines_for_cansend() {
    let given = gives("605#4000100000000000\n585#4300100092010200\n705#05\n", &[REQUEST, ANSWER, BEAT]);
    assert_eq!(given.base, TimeBase::None);
    gives("cansend can0 605#4000100000000000\ncansend can0 585#4300100092010200\n", &[REQUEST, ANSWER]);
}

#[test]
fn canalyst() {
    let given = gives(
        "Index,System Time,Time Stamp,Channel,Direction,Frame ID,Type,Format,DLC,Data\n\
         0,\"=\"\"15:20:43.123\"\"\",0x2,ch1,Send,0x0605,Data,Standard,0x08,x| 40 00 10 00 00 00 00 00 \n\
         1,\"=\"\"15:20:43.124\"\"\",0x3,ch1,Receive,0x0585,Data,Standard,0x08,x| 43 00 10 00 92 01 02 00 \n",
        &[REQUEST, ANSWER],
    );
    assert_eq!(directions(&given), [Direction::Tx, Direction::Rx]);
    assert_eq!(given.records[1].timestamp - given.records[0].timestamp, Duration::from_millis(1));
}

/// Semicolons between numbers separate columns; one behind a frame begins a remark.
#[test]
fn semicolons_between_columns() {
    gives(
        "605 ; 8 ; 40 00 10 00 00 00 00 00\n585 ; 8 ; 43 00 10 00 96 01 0A 00\n",
        &["605#4000100000000000", "585#4300100096010A00"],
    );
    gives(
        "0.100000 ; 605 ; 8 ; 40 00 10 00 00 00 00 00\n0.102000 ; 585 ; 8 ; 43 00 10 00 96 01 0A 00\n",
        &["605#4000100000000000", "585#4300100096010A00"],
    );
    gives(
        "605 8 40 00 10 00 00 00 00 00 ; 1000h ; 5\n585 8 43 00 10 00 96 01 0A 00 ; answer; device 5\n",
        &["605#4000100000000000", "585#4300100096010A00"],
    );
}

#[test]
fn identifier_and_bytes() {
    gives("605 40 00 10 00 00 00 00 00\n585 43 00 10 00 92 01 02 00\n705 05\n080\n", &[REQUEST, ANSWER, BEAT, "080#"]);
    gives(
        "0x605 [8] 0x40 0x00 0x10 0x00 0x00 0x00 0x00 0x00\n0x585 [8] 0x43 0x00 0x10 0x00 0x92 0x01 0x02 0x00\n",
        &[REQUEST, ANSWER],
    );
    gives(
        "ID: 605, DLC: 8, Data: 40 00 10 00 00 00 00 00\nID: 585, DLC: 8, Data: 43 00 10 00 92 01 02 00\n",
        &[REQUEST, ANSWER],
    );
}

#[test]
fn numbered_and_quoted_lines() {
    let given = gives(
        "line 2: (001.999987)  can0  605   [8]  40 00 10 00 00 00 00 00\n\
         line 3: (002.000987)  can0  585   [8]  43 00 10 00 92 01 02 00\n",
        &[REQUEST, ANSWER],
    );
    assert_eq!((micros(&given), &given.channels[..]), (vec![1_999_987, 2_000_987], &["can0".to_owned()][..]));
    gives(
        "> can0  605   [8]  40 00 10 00 00 00 00 00\n> can0  585   [8]  43 00 10 00 92 01 02 00\n",
        &[REQUEST, ANSWER],
    );
}

#[test]
fn a_list_of_the_last_frames() {
    let given = gives(
        "CAN-ID   Type  Length  Data                     Cycle Time  Count\n\
         585h           8       43 00 10 00 92 01 02 00  100.1       12\n\
         705h           1       05                       1000.0      7\n",
        &[ANSWER, BEAT],
    );
    assert_eq!(given.base, TimeBase::None);
    assert!(given.interpretation.unwrap().contains("last frame of each id"));
    assert!(given.records.iter().all(|record| record.comment().is_none()));
}

#[test]
fn rows_of_trc_without_head() {
    let given = gives(
        "     1)       100.1  Tx         0605  8  40 00 10 00 00 00 00 00 \n\
         \u{20}    2)       101.0  Rx         0585  8  43 00 10 00 92 01 02 00 \n\
         \u{20}    3)       500.0  Rx         0705  1  05 \n",
        &[REQUEST, ANSWER, BEAT],
    );
    assert_eq!(micros(&given), [100_100, 101_000, 500_000]);
}

#[test]
fn savvycan() {
    let given = gives(
        "Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8,\n\
         100100,00000605,false,Tx,0,8,40,00,10,00,00,00,00,00,\n101000,00000585,false,Rx,0,8,43,00,10,00,92,01,02,00,\n",
        &[REQUEST, ANSWER],
    );
    assert_eq!(micros(&given), [100_100, 101_000]);
    assert_eq!(directions(&given), [Direction::Tx, Direction::Rx]);
}

#[test]
fn direction_first() {
    let given = gives("Tx 605 8 40 00 10 00 00 00 00 00\nRx 585 8 43 00 10 00 92 01 02 00\n", &[REQUEST, ANSWER]);
    assert_eq!(directions(&given), [Direction::Tx, Direction::Rx]);
}

#[test]
fn slcan() {
    gives("t60584000100000000000\nt58584300100092010200\nt705105\n", &[REQUEST, ANSWER, BEAT]);
}

#[test]
fn what_shows_no_bytes_says_so() {
    let packets = "    1   0.000000              →              CANopen 32 p2p (0x605) SDO Upload request\n\
                   \u{20}   2   0.001000              →              CANopen 32 p2p (0x585) SDO Upload response\n";
    let error = open_with(packets, None).err().unwrap();
    assert!(matches!(error, OpenError::Unread { reason: Unread::NoBytes, .. }), "{error}");
    assert!(error.to_string().contains("no data bytes"), "{error}");
    let error = open_with("MDF     3.30    Vector\0", None).err().unwrap();
    assert!(error.to_string().contains("a version before 4"), "{error}");
}

/// The forms that other readers know, with what people write around them.
#[test]
fn the_forms_of_candump() {
    for (text, frames) in [
        (" (2023-05-01 10:00:00.000000)  can0  605   [8]  40 00 10 00 00 00 00 00\n", REQUEST),
        (" (000.000000)  slcan0  605   [8]  40 00 10 00 00 00 00 00\n", REQUEST),
        (" (001.999987)  can0  TX - -  605   [8]  40 00 10 00 00 00 00 00   '@.......'\n", REQUEST),
        ("(1620000000.101000) can0 585#43.00.10.00.92.01.02.00\n", ANSWER),
        ("```\n$ candump can0\ncan0  605   [8]  40 00 10 00 00 00 00 00\n^C\n```\n", REQUEST),
    ] {
        gives(text, &[frames]);
    }
}

#[test]
fn a_remark_beside_a_frame_is_kept() {
    let given = gives(
        "  can0  080   [0] \n  can0  201   [7]  37 2F 00 00 00 00 00    <---- only now, after the time-out\n",
        &["080#", "201#372F0000000000"],
    );
    assert_eq!(given.records[1].comment(), Some("only now, after the time-out"));
    for (remark, text) in
        [("// no answer", "no answer"), ("; why?", "why?"), ("-> here", "here"), ("this one", "this one")]
    {
        for line in ["605 40 00 10 00 00 00 00 00", "Tx 605 8 40 00 10 00 00 00 00 00", "605#4000100000000000"] {
            let given = gives(&format!("{line}   {remark}\n{line}\n"), &[REQUEST, REQUEST]);
            assert_eq!(given.records[0].comment(), Some(text), "{line} {remark}");
            assert_eq!(given.records[1].comment(), None, "{line}");
        }
    }
}

#[test]
fn prose_around_the_frames_is_passed_over() {
    let text = "Hello,\nmy drive does not answer after 3 tries, this is what I see:\n\n\
                605 40 00 10 00 00 00 00 00\n585 43 00 10 00 92 01 02 00\n\nAny idea? It worked in 2019.\n-- \nBob\n";
    gives(text, &[REQUEST, ANSWER]);
}

#[test]
fn a_line_that_is_nearly_a_frame_is_malformed() {
    let rest = "605 8 40 00 10 00 00 00 00 00\n585 8 43 00 10 00 92 01 02 00\n705 1 05\n";
    for line in ["605 8 40 00 10 00 00 00 00", "605 8 40 00 10 00 00 00 00 00 00", "6x5 1 05", "805 1 05", "605 9 40"] {
        let given = given(&format!("{rest}{line}\n"));
        assert_eq!(given.frames, [REQUEST, ANSWER, BEAT], "{line}");
        assert_eq!(
            given.damages.iter().map(|damage| (damage.kind, damage.place.number)).collect::<Vec<_>>(),
            [(DamageKind::Malformed, 4)]
        );
    }
}

#[test]
fn a_last_line_that_may_go_on_is_not_read() {
    let given = given("605 40 00 10 00 00 00 00 00\n585 43 00 10 00 92 01 02 00\n705 05");
    assert_eq!((given.frames.len(), given.damages[0].kind), (2, DamageKind::Truncated));
    gives("605 8 40 00 10 00 00 00 00 00\n705 1 05", &[REQUEST, BEAT]);
    gives("605#4000100000000000", &[REQUEST]);
}

#[test]
fn a_last_line_that_may_become_a_frame_is_told_and_prose_is_not() {
    let rows = "605 8 40 00 10 00 00 00 00 00\n585 8 43 00 10 00 92 01 02 00\n";
    let table = "id,len,data\n605,8,40 00 10 00 00 00 00 00\n585,8,43 00 10 00 92 01 02 00\n";
    for (text, ends) in [(rows, ["5", "585", "585 8", "585 8 43 0"]), (table, ["5", "585", "585,8,", "585,8,43 0"])] {
        for end in ends {
            let given = given(&format!("{text}{end}"));
            let kinds: Vec<_> = given.damages.iter().map(|damage| damage.kind).collect();
            assert_eq!((given.frames.len(), &kinds[..]), (2, &[DamageKind::Truncated][..]), "{end}");
        }
    }
    for end in ["Any idea?", "Thanks", "```", "-- "] {
        gives(&format!("{rows}{end}"), &[REQUEST, ANSWER]);
        gives(&format!("{table}{end}"), &[REQUEST, ANSWER]);
    }
}

#[test]
fn only_rows_of_a_table_can_be_damaged() {
    let table = "# Logged: 2024-03-01, 3 files\nid,len,data\n605,8,40 00 10 00 00 00 00 00\n";
    gives(&format!("{table}585,8,43 00 10 00 92 01 02 00\n\nWell, I wonder\n"), &[REQUEST, ANSWER]);
    let given = given(&format!("{table}585,8,43 00 10 00 92 01 02 0x\n"));
    assert_eq!((given.frames.len(), given.damages[0].place.number), (1, 4));
}

/// Checks the frames, and the lines that are told as damage.
#[track_caller]
pub fn tells(text: &str, frames: &[&str], lines: &[u64]) {
    let given = given(text);
    assert_eq!(given.frames, frames, "{text}\n{:?}\n{:?}", given.interpretation, given.damages);
    let told: Vec<u64> = given.damages.iter().map(|damage| damage.place.number).collect();
    assert_eq!(told, lines, "{text}\n{:?}", given.damages);
}

/// Checks that the text fits two readings, and what each of them gives.
#[track_caller]
pub fn asks(text: &str, readings: [(&str, &[&str]); 2]) {
    let error = open_with(text, None).err().unwrap_or_else(|| panic!("{text}: {:?}", given(text).interpretation));
    let OpenError::Ambiguous { ref question, .. } = error else { panic!("{text}: {error}") };
    assert!(error.to_string().contains("--columns "), "{error}");
    assert_eq!(question.columns(), readings.map(|(columns, _)| columns), "{text}");
    for (columns, frames) in readings {
        let given = open_with(text, Some(columns)).unwrap_or_else(|error| panic!("{text}: {error}"));
        assert_eq!(given.frames, frames, "{text}: {columns}");
    }
}

#[test]
fn what_fits_two_readings_is_asked() {
    let both: &[&str] = &[REQUEST, ANSWER];
    asks(
        "1000 605 8 40 00 10 00 00 00 00 00\n2000 585 8 43 00 10 00 92 01 02 00\n",
        [("time[ms],id,len,data", both), ("time[us],id,len,data", both)],
    );
    asks(
        "00000605 8 40 00 10 00 00 00 00 00\n00000585 8 43 00 10 00 92 01 02 00\n",
        [("id[11],len,data", both), ("id[29],len,data", &["00000605#4000100000000000", "00000585#4300100092010200"])],
    );
    asks(
        "605 8 40 0 10 0 0 0 0 0\n585 8 43 0 10 0 92 1 2 0\n",
        [("id,len,data[hex]", both), ("id,len,data[dec]", &["605#28000A0000000000", "585#2B000A005C010200"])],
    );
    asks(
        "605 02 40 00\n585 02 43 00\n",
        [("id,len,data", &["605#4000", "585#4300"]), ("id,data", &["605#024000", "585#024300"])],
    );
}

#[test]
fn given_columns_decide() {
    let text = "2.5 605 8 64 0 16 0 0 0 0 0\n3.5 585 8 67 0 16 0 146 1 2 0\n";
    assert!(open_with(text, None).is_err());
    let given = open_with(text, Some("time[s],id[hex],len,data[dec]")).unwrap();
    assert_eq!(
        (given.frames.as_slice(), micros(&given)),
        (&[REQUEST, ANSWER].map(String::from)[..], vec![2_500_000, 3_500_000])
    );
    let given = open_with("1 605 1 1\n", Some("line,id,len,data[dec]")).unwrap();
    assert_eq!(given.frames, ["605#01"]);
}

#[test]
fn what_was_inferred_is_said() {
    let said = |text: &str| given(text).interpretation.unwrap();
    assert_eq!(
        said("  1)  100.1  Tx  0605  8  40 00 10 00 00 00 00 00\n  2)  101.0  Rx  0585  8  43 00 10 00 92 01 02 00\n"),
        "time in ms, id in hex, length, bytes in hex"
    );
    assert_eq!(said("605#4000100000000000\n"), "frames in candump's notation");
    assert_eq!(given("(1.0) can0 605#40\n").interpretation, None, "a known format needs no inference");
}
