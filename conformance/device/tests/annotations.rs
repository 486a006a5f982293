//! The values of the devices as the analyzer shows them, with the byte sequences and meanings of their manuals.

#![cfg(test)]

use canvass_analyzer::findings::{Diagnosis, SourceQuality, Thresholds};
use canvass_analyzer::network::Network;
use canvass_analyzer::{Meaning, NodeId};
use canvass_device::models::Model;
use canvass_traces::{ChannelId, Frame, Quality, Record, Timestamp, parse_frame};

fn records<'a>(frames: impl IntoIterator<Item = (i64, &'a str)>) -> Vec<Record> {
    let record = |(ms, frame): (i64, &str)| {
        let frame: Frame = parse_frame(frame).unwrap().frame;
        Record::new(Timestamp(ms as u64 * 1_000_000), ChannelId(0), frame)
    };
    frames.into_iter().map(record).collect()
}

fn every_10_ms<'a>(frames: &[&'a str]) -> Vec<(i64, &'a str)> {
    (0..).map(|n| 1_000 + 10 * n).zip(frames.iter().copied()).collect()
}

/// The texts of frames in a network that decodes with this prior knowledge.
fn read(mut network: Network, frames: &[&str]) -> Vec<String> {
    let text = |record: &Record| {
        let decoded = network.handle(record);
        Meaning::new(record, &decoded, network.bus(record.channel).unwrap()).to_string()
    };
    records(every_10_ms(frames)).iter().map(text).collect()
}

fn known(model: &str, node: u8) -> Network {
    let mut network = Network::new();
    let device = canvass_analyzer::dictionary::KnownDevice::clone(Model::by_id(model).unwrap().device());
    network.describe(NodeId::new(node).unwrap(), device);
    network
}

/// The text of the last frame of a described device.
fn last(model: &str, node: u8, frames: &[&str]) -> String {
    read(known(model, node), frames).pop().unwrap()
}

/// The request that an SDO upload response answers.
fn request(response: &str) -> String {
    format!("601#40{}00000000", &response[2..8])
}

/// The value in an SDO upload response of node 1.
fn value(model: &str, response: &str) -> String {
    let text = last(model, 1, &[&request(response), &format!("581#{response}")]);
    text.split_once(" = ").unwrap().1.to_owned()
}

/// Kübler, manual of C100 and D125, 5.5.2: 1000 mm on channel A.
#[test]
fn draw_wire_encoders_have_two_channels() {
    let of = |model, frame| last(model, 4, &[frame]);
    assert_eq!(
        of("kuebler-d125", "184#10270000B0840000"),
        "TPDO 1: 6020h:00 Position A = 1000 mm, 6020h:00 Position B = 3396.8 mm"
    );
    assert_eq!(
        of("kuebler-c100", "184#D900BFB6"),
        "TPDO 1: 6020h:00 Position A = 21.7 mm, 6020h:00 Position B = 4678.3 mm"
    );
    let angles = "TPDO 2: 5000h:00 Angle Z1 = 10°, 5000h:00 Angle Z2 = 350°";
    assert_eq!(of("kuebler-c100", "284#E803B888"), angles);
    assert_eq!(of("kuebler-d125", "284#E803B88800000000"), angles);
    assert!(of("kuebler-c100", "284#E803B88800000000").ends_with("[length 8, the mapping fills 4]"));
    assert_eq!(
        last("kuebler-sendix-f58", 63, &["4BF#785634127856"]),
        "TPDO 4: 2160h:00 Position raw data #1 = 12345678h, 2160h:00 Position raw data #2 = 5678h (22136)"
    );
}

/// Kübler, manual of C100 and D125, 5.4.8: 3004h = 1 is the range of ±180°.
#[test]
fn the_range_of_an_angle_gives_its_sign() {
    let set = ["604#2F04300001000000", "584#6004300000000000"];
    let of = |before: &[&str], frame| last("kuebler-c100", 4, &[before, &[frame]].concat());
    let read = [&set[..], &["604#4000500000000000"]].concat();
    assert!(of(&read, "584#4B00500018FC0000").ends_with("= -10°"));
    assert!(of(&set, "284#18FCE803").ends_with("Angle Z1 = -10°, 5000h:00 Angle Z2 = 10°"));
    assert!(of(&["604#4004300000000000", "584#4F04300001000000"], "284#18FCE803").contains("Angle Z1 = -10°"));
    assert!(of(&[], "284#E803B888").contains("Angle Z2 = 350°"));
    assert!(
        of(&[&set[..], &["604#2F04300000000000", "584#6004300000000000"]].concat(), "284#E803B888").contains("350°")
    );
}

#[test]
fn whole_values_have_a_meaning() {
    assert_eq!(value("lika-ax58", "43086500FFFFFFFF"), "FFFFFFFFh (not used)");
    assert_eq!(value("tr-lmp30", "43086500FFFFFFFF"), "FFFFFFFFh (not used)");
    assert_eq!(value("lika-ax58", "4307650001030101"), "01010301h (profile 3.1, software 1.01)");
    assert_eq!(value("tr-c65", "4307650040010122"), "22010140h (profile 1.40, software 22.01)");
    assert_eq!(value("kuebler-sendix-f58", "4302600000000000"), "0 (2^32 steps)");
    assert_eq!(value("kuebler-sendix-f58", "4F002100FF000000"), "255 (unconfigured)");
    assert_eq!(
        value("kuebler-sendix-58x8", "4300100096010200"),
        "00020196h (profile 406, multi-turn absolute rotary encoder)"
    );
    assert_eq!(value("kuebler-sendix-58x8", "4F29100202000000"), "2 (stopped)");
    assert_eq!(value("kuebler-sendix-m58", "4B31600102000000"), "2 (raw position, 600Ch)");
    assert_eq!(value("lika-ax58", "43042100F0FF3F00"), "4194288 steps");
}

/// Lika Ax58x, 5.8.1; Kübler R67070.0002, 5.7.5.
#[test]
fn communication_parameters_have_a_meaning() {
    assert_eq!(value("lika-ax58", "4300180180010040"), "40000180h (CAN-ID 180h, valid, no RTR)");
    assert_eq!(value("lika-ax58", "4F01180201000000"), "1 (at every SYNC)");
    assert_eq!(value("kuebler-sendix-58x8", "4F021802FF000000"), "255 (event of the device profile)");
    assert_eq!(value("lika-ax58", "43001A0120000460"), "60040020h (6004h:00, 32 bits)");
    assert_eq!(value("kuebler-sendix-f58", "43161001E8030500"), "000503E8h (node 5, 1000 ms)");
}

/// The bits of 6500h are those of 6000h, the supported alarms and warnings are the alarms and warnings; the manuals
/// leave bits unused that the profile names.
#[test]
fn bits_have_the_names_of_the_manual() {
    assert!(value("kuebler-sendix-f58", "4B00650005500000").contains("Start in operational"));
    assert!(value("kuebler-sendix-f58", "4B04650001800000").contains("Position error, Device error"));
    assert!(value("kuebler-sendix-f58m", "4B06650005C00000").contains("Temperature error, Internal memory error"));
    assert!(value("tr-c65", "4B04650001300000").contains("EEPROM error, Parameter error"));
    assert_eq!(value("kuebler-sendix-f58m", "4B00600002000000"), "2 (Speed format: rpm)");
    assert_eq!(value("lika-ax58", "4B0060000A000000"), "000Ah (10) (Limit switch min: off, Limit switch max: off)");
    assert_eq!(value("kuebler-sendix-f58", "4F00640002000000"), "2");
}

/// Kübler R67070.0002, 5.8.2.
#[test]
fn the_bytes_of_an_emcy_have_a_meaning() {
    let text = last("kuebler-sendix-58x8", 63, &["0BF#004209805620502E"]);
    let fields = "sensor error register 80h, temperature 22 °C, low threshold -32 °C, high threshold 16 °C";
    assert!(text.contains(fields), "{text}");
}

/// The step of a linear encoder is in its sheet and in 6501h: one value, not two.
#[test]
fn a_position_in_millimetres_is_shown_once() {
    assert_eq!(value("tr-lmp30", "43046000BA4C0000"), "196.42 mm");
    let half = ["601#4001650000000000", "581#4301650088130000", "601#4004600000000000", "581#43046000BA4C0000"];
    assert!(last("tr-lmp30", 1, &half).ends_with("= 98.21 mm"), "6501h = 0.005 mm");
}

fn recognising() -> Network {
    let mut network = Network::new();
    network.offer(Model::candidates());
    network
}

const DRAW_WIRE: [&str; 4] =
    ["604#4000100000000000", "584#4300100096010000", "604#4018100200000000", "584#4318100201206858"];

/// The device type, the name and the identity of C100 and D125 are the same; their first PDO tells them apart.
#[test]
fn draw_wire_encoders_are_recognised_by_the_length_of_their_pdos() {
    let vendor = ["604#4018100100000000", "584#4318100113000000"];
    let texts = |frame| read(recognising(), &[&DRAW_WIRE[..], &vendor, &[frame]].concat()).pop().unwrap();
    assert!(texts("184#D900BFB6").contains("Position A = 21.7 mm"));
    assert!(texts("184#10270000B0840000").contains("Position A = 1000 mm"));
    assert!(texts("284#E803B88800000000").contains("Angle Z1 = 10°"));
    assert!(texts("184#102700").contains("mapping not known"));
    // The PDO may also come before the identity.
    let early = [&["184#D900BFB6"][..], &DRAW_WIRE, &vendor, &["184#D900BFB6"]].concat();
    assert!(read(recognising(), &early).pop().unwrap().contains("Position A = 21.7 mm"));
}

/// Sendix 58x8 and F58 have the same identity; only the F58 has 2160h.
#[test]
fn an_f58_is_recognised_by_an_object_that_a_58x8_lacks() {
    let identity = [
        "63F#4000100000000000",
        "5BF#4300100096010200",
        "63F#4018100100000000",
        "5BF#4318100113000000",
        "63F#4018100200000000",
        "5BF#4318100201206858",
    ];
    let raw = ["63F#4060210000000000", "5BF#4360210078563412"];
    let position = "4BF#785634127856";
    let of = |frames: &[&str]| read(recognising(), &[frames, &[position]].concat()).pop().unwrap();
    assert!(of(&identity).contains("mapping not known"));
    assert!(of(&[&identity[..], &raw].concat()).contains("Position raw data #1 = 12345678h"));
    assert!(of(&[&raw[..], &identity].concat()).contains("Position raw data #1 = 12345678h"));
}

/// The findings of a capture at a bit rate, by rule and message.
fn findings(model: &str, node: u8, bit_rate: u32, frames: &[(i64, String)]) -> Vec<String> {
    let mut diagnosis = Diagnosis::new(Thresholds::default());
    diagnosis.set_bit_rate(bit_rate);
    diagnosis.describe(
        NodeId::new(node).unwrap(),
        canvass_analyzer::dictionary::KnownDevice::clone(Model::by_id(model).unwrap().device()),
    );
    for record in records(frames.iter().map(|(ms, frame)| (*ms, frame.as_str()))) {
        diagnosis.record(&record);
    }
    let quality = Quality::default();
    let report = diagnosis.finish(&[SourceQuality { name: "test", quality: &quality }]);
    report.findings.iter().map(|finding| format!("{}: {}", finding.rule.id, finding.message)).collect()
}

fn angles(z2: impl Fn(i64) -> i64) -> Vec<(i64, String)> {
    let pdo = |n: i64| {
        let (a, b) = ((200 + 10 * n) as u16, z2(n).rem_euclid(36_000) as u16);
        (1_000 + 100 * n, format!("284#{:04X}{:04X}", a.swap_bytes(), b.swap_bytes()))
    };
    (0..60).map(pdo).collect()
}

fn has(findings: &[String], rule: &str) -> bool {
    findings.iter().any(|finding| finding.starts_with(rule))
}

/// Kübler, manual of C100 and D125, 5.5.3: Z2 is Z1 with the other sign.
#[test]
fn angles_that_disagree_are_found() {
    let of = |z2: fn(i64) -> i64| findings("kuebler-c100", 4, 250_000, &angles(z2));
    let rule = "encoder/redundant-channels";
    assert!(!has(&of(|n| -200 - 10 * n), rule));
    // The sensors differ by half a degree.
    assert!(!has(&of(|n| -200 - 10 * n + n), rule));
    assert!(has(&of(|n| if n < 40 { -200 - 10 * n } else { -600 + 27 * (n - 40) }), rule));
    // 3005h = 0: both in the same direction.
    let same = [(500, "604#2F05300000000000".to_owned()), (502, "584#6005300000000000".to_owned())];
    let with = |z2: fn(i64) -> i64| findings("kuebler-c100", 4, 250_000, &[&same[..], &angles(z2)].concat());
    assert!(!has(&with(|n| 200 + 10 * n), rule));
    assert!(has(&with(|n| if n < 40 { 200 + 10 * n } else { 600 }), rule));
}

/// Kübler R67070.0002, 5.5.26: 2162h is the CRC-CCITT of 2160h with the start value 1021h.
#[test]
fn raw_positions_that_contradict_each_other_are_found() {
    let of = |values: &[(&str, u32)]| {
        let read = |(n, (object, value)): (usize, &(&str, u32))| {
            let ms = 1_000 + 100 * n as i64;
            let command = if *object == "6221" { "4B" } else { "43" };
            let bytes: String = value.to_le_bytes().iter().map(|byte| format!("{byte:02X}")).collect();
            [(ms, format!("63F#40{object}0000000000")), (ms + 1, format!("5BF#{command}{object}00{bytes}"))]
        };
        let frames: Vec<(i64, String)> = values.iter().enumerate().flat_map(read).collect();
        has(&findings("kuebler-sendix-f58", 63, 250_000, &frames), "encoder/raw-position")
    };
    let crc = u32::from(canvass_analyzer::wire::sdo::crc16(0x1021, &0x1234_5678_u32.to_le_bytes()));
    let (raw, inverse) = (("6021", 0x1234_5678), ("6121", !0x1234_5678_u32));
    assert!(!of(&[raw, inverse, ("6221", crc), raw]));
    assert!(of(&[raw, ("6121", 0x1234_5678)]));
    assert!(of(&[raw, ("6221", 0), raw]));
    // A shaft that turns between two transfers.
    assert!(!of(&[raw, ("6121", !0x1234_6000_u32), ("6221", crc ^ 1), ("6021", 0x1234_7000)]));
}

/// Kübler R67070.0002, 5.1: at least 14 ms at 10 kbit/s, 10 ms at 20 kbit/s, 4 ms at 50 kbit/s.
#[test]
fn event_timers_below_the_limit_of_the_bit_rate_are_found() {
    let of = |bit_rate, timer: u8| {
        let mut frames = vec![
            (1_000, "63F#2F001802FF000000".to_owned()),
            (1_010, "5BF#6000180200000000".to_owned()),
            (1_020, format!("63F#2B001805{timer:02X}000000")),
            (1_030, "5BF#6000180500000000".to_owned()),
            (1_040, "000#013F".to_owned()),
        ];
        frames.extend((0..20).map(|n| (1_100 + i64::from(timer) * n, "1BF#BA4C0000".to_owned())));
        has(&findings("kuebler-sendix-58x8", 63, bit_rate, &frames), "pdo/cycle-too-short")
    };
    assert_eq!([(10_000, 13), (20_000, 9), (50_000, 3)].map(|(rate, timer)| of(rate, timer)), [true; 3]);
    assert_eq!(
        [(10_000, 14), (20_000, 10), (50_000, 4), (250_000, 1)].map(|(rate, timer)| of(rate, timer)),
        [false; 4]
    );
}
