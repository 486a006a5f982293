//! Lines as the sources and manuals of other tools print them.

use crate::pasted::{asks, directions, given, gives, micros, open_with};
use canvass_traces::*;

const REQUEST: &str = "605#4000100000000000";
const ANSWER: &str = "585#4300100092010200";
const BEAT: &str = "705#05";

/// Lines, the tool that prints them, and the frames in them.
const TOOLS: &[(&str, &str, &[&str])] = &[
    (
        "mcp_can, the sketch for receiving",
        "MCP2515 Library Receive Example...
Standard ID: 0x605       DLC: 8  Data: 0x40 0x00 0x10 0x00 0x00 0x00 0x00 0x00
Extended ID: 0x18FF1234  DLC: 2  Data: 0x01 0x02
Standard ID: 0x705       DLC: 1  Data: REMOTE REQUEST FRAME\n",
        &[REQUEST, "18FF1234#0102", "705#R1"],
    ),
    (
        "BUSMASTER with identifiers of 29 bits",
        "13:33:13:9593 Rx 1 0xDC3C68F x 2 00 F8 \n13:33:13:9614 Rx 1 0xDC3CA87 x 2 00 15 \n13:33:14:0201 Rx 1 0xD07DABF x 4 47 00 00 00 \n",
        &["0DC3C68F#00F8", "0DC3CA87#0015", "0D07DABF#47000000"],
    ),
    (
        "CANHacker with decimal commas",
        "Time   ID     DLC Data                    Comment
18,876000 070      8 00 B0 C8 64 9D B0 01 D6 \n18,877000 605      8 40 00 10 00 00 00 00 00 \n",
        &["070#00B0C8649DB001D6", REQUEST],
    ),
    (
        "CANwise",
        "EV NUM/ERR F/F ID     LEN R/D   D0  D1  D2  D3  D4  D5  D6  D7 TIMESTAMP  DD MM YYYY TIME          
RX 0000318 EFF 14FF1605 8 HEX   7D  7D  7D  7D  EE  00  E8  03 0033299735 07.05.2022 14:10:08.135 0030958108 0675314032
RX 0000319 EFF 14FF2503 8 HEX   00  FF  FF  FF  FF  FF  FF  FF 0033300335 07.05.2022 14:10:08.135 0030958108 0675314032
RX 0000320 EFF 14FF0F07 8 HEX   00  F4  00  00  00  00  00  00 0033301510 07.05.2022 14:10:08.235 0030958108 0675314032\n",
        &["14FF1605#7D7D7D7DEE00E803", "14FF2503#00FFFFFFFFFFFFFF", "14FF0F07#00F4000000000000"],
    ),
    (
        "CAR BUS Analyzer, version 3",
        "@ TEXT @ 3 @ 64 @ 0 @ 13958 @ 16478 @ 00:00:16.478 @
# $LocalTime=15:35:15.917
27,337000\t1\t00000004\t3D8\t8\t00 00 04 00 00 00 00 00\t00000000\t        \t
27,350000\t1\t00000004\t5F2\t2\t02 00                  \t00000000\t        \t
27,372000\t1\t00000005\t17333210\t3\t3C A6 00               \t00000000\t<       \t\n",
        &["3D8#0000040000000000", "5F2#0200", "17333210#3CA600"],
    ),
    (
        "IXXAT canAnalyser",
        "Start Time  Thursday May 01 2025 10:47:15\nBitrate   500 kbit/s\nOperating Mode  Std ErrDet TxPass\nDriver Version  4.1.212.0
\"Bus\",\"No\",\"Time\",\"State\",\"ID (hex)\",\"DLC\",\"Data (hex)\",\"ASCII\"
\"USB-to-CAN V2 compact  CAN-1\",\"1\",\"00:00:00.083\",\"      \",\"19D\",\"8\",\"40 00 3F FF 00 0E BD FF\",\"@.?.....\"
\"USB-to-CAN V2 compact  CAN-1\",\"2\",\"00:00:00.083\",\"      \",\"1AF\",\"2\",\"00 00\",\"..\"
\"USB-to-CAN V2 compact  CAN-1\",\"1,000\",\"00:00:00.752\",\"      \",\"0C1\",\"8\",\"40 00 00 00 40 00 00 00\",\"@...@...\"\n",
        &["19D#40003FFF000EBDFF", "1AF#0000", "0C1#4000000040000000"],
    ),
    (
        "socketcand",
        "< hi >\n< ok >\n< frame 605 1620000000.100000 4000100000000000 >\n< frame 585 1620000000.101000 4300100092010200 >\n< frame 705 1620000000.500000 05 >\n",
        &[REQUEST, ANSWER, BEAT],
    ),
    (
        "python-can, print of CAN FD",
        "Timestamp: 1620000000.100000        ID:      605    S Rx    F BS          DL: 12    00 01 02 03 04 05 06 07 08 09 0a 0b     Channel: can0
Timestamp: 1620000000.101000        ID: 18ff1234    X Tx    F BS EI       DL:  2    00 01                       Channel: can0\n",
        &["605##5000102030405060708090A0B", "18FF1234##70001"],
    ),
    (
        "python-can, print of remote frames",
        "Timestamp: 1620000000.200000        ID:      605    S Rx                DL:  8    40 00 10 00 00 00 00 00     Channel: can0
Timestamp: 1620000000.300000        ID:      701    S Rx   R            DL:  1                                Channel: can0\n",
        &[REQUEST, "701#R1"],
    ),
    (
        "a sketch for TWAI",
        "CAN Receiver @ 500 kbps\nID : 0x605 | Data : 40 00 10 00 00 00 00 00 \nID : 0x585 | Data : 43 00 10 00 92 01 02 00 \n",
        &[REQUEST, ANSWER],
    ),
    (
        "STM32's HAL",
        "StdId: 0x605, IDE: 0, RTR: 0, DLC: 8, Data: 40 00 10 00 00 00 00 00\nStdId: 0x705, IDE: 0, RTR: 0, DLC: 1, Data: 05\n",
        &[REQUEST, BEAT],
    ),
    (
        "candump -x -a -td",
        " (000.000000)  can0  TX - -  605   [8]  40 00 10 00 00 00 00 00   '@.......'\n (000.001000)  can0  RX - -  585   [8]  43 00 10 00 92 01 02 00   'C.......'\n",
        &[REQUEST, ANSWER],
    ),
    (
        "candump -ta, quoted in a mail",
        "> > (1620000000.100000)  can0  605   [8]  40 00 10 00 00 00 00 00\n> > (1620000000.101000)  can0  585   [8]  43 00 10 00 92 01 02 00\n",
        &[REQUEST, ANSWER],
    ),
    (
        "candump with CAN FD",
        " (2024-12-11 09:27:19.445269)  can0  TX B -  077  [12]  00 01 02 03 04 05 06 07 08 09 0A 0B\n",
        &["077##5000102030405060708090A0B"],
    ),
    (
        "rows of CANoe's trace window",
        "0.100100\tCAN 1\t605\t\tCAN Frame\tTx\t8\t8\t40 00 10 00 00 00 00 00\n0.101000\tCAN 1\t585\t\tCAN Frame\tRx\t8\t8\t43 00 10 00 92 01 02 00\n0.500000\tCAN 1\t705\t\tCAN Frame\tRx\t1\t1\t05\n",
        &[REQUEST, ANSWER, BEAT],
    ),
    (
        "rows of ASC with lengths of bits",
        "   0.100100 1  605             Rx   d 8 40 00 10 00 00 00 00 00  Length = 240000 BitCount = 124 ID = 1541
   0.101000 1  585             Rx   d 8 43 00 10 00 92 01 02 00  Length = 240000 BitCount = 124 ID = 1413\n",
        &[REQUEST, ANSWER],
    ),
    (
        "PCAN-View, a trace with an empty frame",
        "    30)      3769.9  Rx     0FFFE0C0  0  \n    31)      3773.1  Rx     10002040  4  09 01 35 72 \n    32)      3779.0  Rx         0605  8  40 00 10 00 00 00 00 00 \n",
        &["0FFFE0C0#", "10002040#09013572", REQUEST],
    ),
    (
        "PCAN-View, the list of what is sent",
        "CAN-ID\tType\tLength\tData\tCycle Time\tCount\tTrigger\tComment
605h\t\t8\t40 00 10 00 00 00 00 00\t100\t12\tTime\tread type
000h\t\t2\t01 05\tWait\t1\tManual\tstart\n",
        &[REQUEST, "000#0105"],
    ),
    (
        "ZLG CANTest",
        "0\t0x605\t10:00:00.100.1\tSend\tData\tStandard\t8\t40 00 10 00 00 00 00 00\n1\t0x585\t10:00:00.101.3\tReceive\tData\tStandard\t8\t43 00 10 00 92 01 02 00\n",
        &[REQUEST, ANSWER],
    ),
    (
        "USB-CAN analysers with a column for each byte",
        "Index,Time,Channel,Dir,ID,Type,Format,DLC,D0,D1,D2,D3,D4,D5,D6,D7
0,10:00:00.100,0,Tx,0x605,DATA,STANDARD,8,40,00,10,00,00,00,00,00\n1,10:00:00.500,0,Rx,0x705,DATA,STANDARD,1,05,00,00,00,00,00,00,00\n",
        &[REQUEST, BEAT],
    ),
    (
        "asammdf, CSV",
        "timestamps,CAN_DataFrame.BusChannel,CAN_DataFrame.ID,CAN_DataFrame.IDE,CAN_DataFrame.DLC,CAN_DataFrame.DataLength,CAN_DataFrame.DataBytes
0.1001,1,1541,0,8,8,[64 0 16 0 0 0 0 0]\n0.1010,1,1413,0,8,8,[67 0 16 0 146 1 2 0]\n",
        &[REQUEST, ANSWER],
    ),
    (
        "Vehicle Spy, CSV",
        "Line,Abs Time(Sec),Rel Time (Sec),Status,Er,Tx,Description,Network,Node,Arb ID,Remote,Xtd,Type,B1,B2,B3,B4,B5,B6,B7,B8
1,0.100100,0.000000,1,F,T,HS CAN $605,HS CAN,,605,F,F,,40,00,10,00,00,00,00,00\n2,0.101000,0.000900,1,F,F,HS CAN $585,HS CAN,,585,F,F,,43,00,10,00,92,01,02,00\n",
        &[REQUEST, ANSWER],
    ),
    (
        "Kvaser's memorator tools, text",
        "       Time Chan Identifier Flags  DLC  Data                      Counter
   0.100100    1        605         8  40 00 10 00 00 00 00 00          1\n   0.101000    1        585  Tx     8  43 00 10 00 92 01 02 00          2\n   0.500000    1        705         1  05                               3\n",
        &[REQUEST, ANSWER, BEAT],
    ),
    ("an adapter of Lawicel, with answers", "O\r\rz\rt60584000100000000000\rz\rt58584300100092010200A1B2\r", &[REQUEST, ANSWER]),
];

#[test]
fn lines_of_tools() {
    let mut wrong = Vec::new();
    for (tool, text, frames) in TOOLS {
        match open_with(text, None) {
            Ok(given) if given.frames == *frames && given.damages.is_empty() => {}
            Ok(given) => {
                wrong.push(format!("{tool}: {:?} {:?} {:?}", given.frames, given.damages, given.interpretation));
            }
            Err(error) => wrong.push(format!("{tool}: {error}")),
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The lines of a tool.
fn lines(tool: &str) -> &'static str {
    TOOLS.iter().find(|(name, ..)| *name == tool).map(|(_, text, _)| *text).unwrap()
}

#[test]
fn times_and_directions_of_tools() {
    let canwise = given(lines("CANwise"));
    assert_eq!((canwise.base, micros(&canwise)[2] - micros(&canwise)[0]), (TimeBase::Local, 100_000));
    assert_eq!(directions(&canwise), [Direction::Rx; 3]);
    assert_eq!(micros(&given(lines("CAR BUS Analyzer, version 3"))), [27_337_000, 27_350_000, 27_372_000]);
    let socketcand = given(lines("socketcand"));
    assert_eq!((socketcand.base, micros(&socketcand)[0]), (TimeBase::Utc, 1_620_000_000_100_000));
    assert_eq!(micros(&given(lines("IXXAT canAnalyser"))), [83_000, 83_000, 752_000]);
    assert_eq!(given(lines("IXXAT canAnalyser")).channels, ["USB-to-CAN V2 compact  CAN-1"]);
    assert_eq!(directions(&given(lines("ZLG CANTest"))), [Direction::Tx, Direction::Rx]);
    assert_eq!(given(lines("PCAN-View, the list of what is sent")).base, TimeBase::None);
}

/// Forms of tools that do not say all: which unit their times have, or how long their identifiers are.
#[test]
fn lines_of_tools_that_are_asked_for() {
    let battery: &[&str] = &["54A#1000700200 00002B", "50B#000002C00060", "1DB#FFC0B9EA000003D8"];
    let battery: Vec<String> = battery.iter().map(|frame| frame.replace(' ', "")).collect();
    let battery: Vec<&str> = battery.iter().map(String::as_str).collect();
    asks(
        "7556  54A  8  10 0 70 2 0 0 0 2B \n7575  50B  6  0 0 2 C0 0 60 \n7577  1DB  8  FF C0 B9 EA 0 0 3 D8 \n",
        [("time[s],id,len,data", &battery), ("time[ms],id,len,data", &battery)],
    );
    asks(
        "ID,Data Bytes\n0000021A,FE 36 12 FE 69 05 07 AD \n0000027A,30 30 0D 8C 09 15 00 \n0000048C,00 \n",
        [
            ("id[11],data", &["21A#FE3612FE690507AD", "27A#30300D8C091500", "48C#00"]),
            ("id[29],data", &["0000021A#FE3612FE690507AD", "0000027A#30300D8C091500", "0000048C#00"]),
        ],
    );
    asks(
        "0.000000000\t0x00000605\t8\t4000100000000000\n0.001000000\t0x18FF1234\t8\t4300100092010200\n",
        [
            ("time[s],id[11],len,data", &[REQUEST, "18FF1234#4300100092010200"]),
            ("time[s],id[29],len,data", &["00000605#4000100000000000", "18FF1234#4300100092010200"]),
        ],
    );
    let microchip = "//---------------------------------\nMicrochip Technology Inc.\nCAN BUS Analyzer\n//---------------------------------
166064;RX;0x0000021A;8;0xFE;0x36;0x12;0xFE;0x69;0x05;0x07;0xAD;\n166074;RX;0x0000048C;1;0x00;\n166084;RX;0x000002A2;7;0x00;0x00;0x11;0x96;0x00;0x10;0x70;\n";
    assert!(matches!(open_with(microchip, None), Err(OpenError::Ambiguous { .. })));
    let given = open_with(microchip, Some("time[ms],id[11],len,data")).unwrap();
    assert_eq!(given.frames, ["21A#FE3612FE690507AD", "48C#00", "2A2#00001196001070"]);
    assert_eq!((micros(&given)[2], directions(&given)[0]), (166_084_000, Direction::Rx));
    let log = "I (12345) TWAI: ID: 0x605, DLC: 8, Data: 0x40 0x00 0x10 0x00 0x00 0x00 0x00 0x00
W (12800) TWAI: bus recovered, TX error count 12\nI (12845) TWAI: ID: 0x705, DLC: 1, Data: 0x05\n";
    let frames: &[&str] = &[REQUEST, BEAT];
    let question = open_with(log, None).err().unwrap().to_string();
    assert!(question.contains("time[ms]"), "{question}");
    let given = open_with(log, Some("time[ms],id,len,data")).unwrap();
    assert_eq!(
        (given.frames.as_slice(), micros(&given)[1]),
        (&frames.iter().map(|f| (*f).to_owned()).collect::<Vec<_>>()[..], 12_845_000)
    );
    gives("605#4000100000000000\n585#4300100092010200\n", &[REQUEST, ANSWER]);
}
