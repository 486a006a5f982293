//! The content of PDOs and SRDOs by their mappings (CiA 301, 7.5.2.36 and 7.5.2.38), and its units (CiA 406).

use crate::trace::Trace;
use canvass_analyzer::dictionary::{DeviceDescription, KnownDevice};
use canvass_analyzer::network::Event;
use canvass_analyzer::{NodeId, PdoNumber};
use canvass_traces::ChannelId;

/// Node 5 answers an upload with four bytes.
fn shown(trace: &mut Trace, index: u16, sub: u8, value: u32) {
    let ([low, high], [a, b, c, d]) = (index.to_le_bytes(), value.to_le_bytes());
    trace.say(&format!("605#40 {low:02X} {high:02X} {sub:02X} 00 00 00 00"));
    trace.say(&format!("585#43 {low:02X} {high:02X} {sub:02X} {a:02X} {b:02X} {c:02X} {d:02X}"));
}

fn changed(trace: &Trace) -> Option<PdoNumber> {
    trace.network.bus(ChannelId(0)).unwrap().events().iter().find_map(|event| match event {
        Event::MappingChanged(_, pdo) => Some(*pdo),
        _ => None,
    })
}

/// The four PDOs of each direction that have default CAN-IDs, and one of each direction that has none.
const PDOS: [(u16, u16, PdoNumber); 10] = [
    (0x1A00, 0x185, PdoNumber::Transmit(1)),
    (0x1A01, 0x285, PdoNumber::Transmit(2)),
    (0x1A02, 0x385, PdoNumber::Transmit(3)),
    (0x1A03, 0x485, PdoNumber::Transmit(4)),
    (0x1A04, 0x195, PdoNumber::Transmit(5)),
    (0x1600, 0x205, PdoNumber::Receive(1)),
    (0x1601, 0x305, PdoNumber::Receive(2)),
    (0x1602, 0x405, PdoNumber::Receive(3)),
    (0x1603, 0x505, PdoNumber::Receive(4)),
    (0x1604, 0x196, PdoNumber::Receive(5)),
];

#[test]
fn each_pdo_has_its_own_mapping() {
    let mut trace = Trace::new();
    shown(&mut trace, 0x1804, 1, 0x195);
    shown(&mut trace, 0x1404, 1, 0x196);
    for (n, (index, _, pdo)) in PDOS.into_iter().enumerate() {
        // A layout that was requested while the mapping was unknown is computed once the mapping is known.
        for (_, id, pdo) in &PDOS[n..] {
            assert_eq!(trace.say(&format!("{id:03X}#01")).text, format!("{pdo}, 1 byte, mapping not known"));
        }
        shown(&mut trace, index, 0, 1);
        assert_eq!(changed(&trace), None, "{pdo}: the entry is not known");
        shown(&mut trace, index, 1, (0x2100 + n as u32) << 16 | 8);
        assert_eq!(changed(&trace), Some(pdo));
        shown(&mut trace, index, 1, (0x2100 + n as u32) << 16 | 8);
        assert_eq!(changed(&trace), None, "{pdo}: it was known");
        for (n, (_, id, pdo)) in PDOS[..=n].iter().enumerate() {
            let text = trace.say(&format!("{id:03X}#2A")).text;
            assert_eq!(text, format!("{pdo}: {:04X}h:00 = 42 (2Ah)", 0x2100 + n), "{id:03X}");
        }
    }
}

/// A count of 0 disables the mapping; 64 is the highest count.
#[test]
fn a_mapping_has_up_to_64_entries() {
    let mut trace = Trace::new();
    for sub in 1..=65 {
        shown(&mut trace, 0x1A00, sub, 0x2100_0001);
    }
    let bits = |trace: &mut Trace| {
        trace.say("185#00 00 00 00 00 00 00 00");
        let node = trace.network.bus(ChannelId(0)).unwrap().node(NodeId::new(5).unwrap()).unwrap();
        node.known_layout(PdoNumber::Transmit(1)).map(|layout| (layout.signals.len(), layout.length()))
    };
    for (count, known) in
        [(0, None), (1, Some((1, 1))), (8, Some((8, 1))), (9, Some((9, 2))), (64, Some((64, 8))), (65, None)]
    {
        shown(&mut trace, 0x1A00, 0, count);
        assert_eq!(bits(&mut trace), known, "{count}");
    }
}

/// Signals follow each other without gaps, bit by bit. A data type in place of an object is a gap.
#[test]
fn signals_follow_each_other() {
    let mut trace = Trace::new();
    for (sub, entry) in [(1, 0x2100_0004), (2, 0x0005_0008), (3, 0x2101_020C)] {
        shown(&mut trace, 0x1A00, sub, entry);
    }
    shown(&mut trace, 0x1A00, 0, 3);
    trace.say("185#5A 23 B1");
    let node = trace.network.bus(ChannelId(0)).unwrap().node(NodeId::new(5).unwrap()).unwrap();
    let layout = node.known_layout(PdoNumber::Transmit(1)).unwrap();
    let payload = [0x5A, 0x23, 0xB1];
    let signals: Vec<_> = layout.signals.iter().map(|signal| (signal.offset, signal.bits, signal.is_dummy())).collect();
    assert_eq!(signals, [(0, 4, false), (4, 8, true), (12, 12, false)]);
    let raw: Vec<_> = layout.signals.iter().map(|signal| signal.raw(&payload)).collect();
    assert_eq!(raw, [Some(0xA), Some(0x35), Some(0xB12)]);
    assert_eq!(layout.signals[2].raw(&payload[..2]), None);
}

/// Entries of an SRDO come in pairs: the data, and its inverted twin (EN 50325-5).
#[test]
fn the_mapping_of_an_srdo_comes_in_pairs() {
    for (count, text) in [
        (1, "SRDO 1 data"),
        (2, "SRDO 1 data: 2100h:00 = 17 (11h) [length 2, the mapping fills 1]"),
        (4, "SRDO 1 data: 2100h:00 = 17 (11h), 2101h:00 = 34 (22h)"),
        (129, "SRDO 1 data"),
    ] {
        let mut trace = Trace::new();
        shown(&mut trace, 0x1301, 5, 0x141);
        shown(&mut trace, 0x1301, 6, 0x142);
        // The layout is requested once while the mapping is unknown.
        assert_eq!(trace.say("141#11 22").text, "SRDO 1 data");
        for (sub, entry) in [(1, 0x2100_0008), (2, 0x2200_0008), (3, 0x2101_0008), (4, 0x2201_0008)] {
            shown(&mut trace, 0x1381, sub, entry);
        }
        shown(&mut trace, 0x1381, 0, count);
        assert_eq!(trace.say("141#11 22").text, text, "{count}");
    }
}

/// An encoder of the type `kind`, with 3600 scaled steps and 8192 physical steps in a turn.
fn encoder(kind: u32) -> Trace {
    let mut trace = Trace::new();
    shown(&mut trace, 0x1000, 0, kind << 16 | 0x0196);
    shown(&mut trace, 0x6001, 0, 3_600);
    shown(&mut trace, 0x6501, 0, 8_192);
    trace
}

fn answer(trace: &mut Trace, index: u16, sub: u8) -> String {
    let [low, high] = index.to_le_bytes();
    trace.say(&format!("605#40 {low:02X} {high:02X} {sub:02X} 00 00 00 00"));
    trace.say(&format!("585#43 {low:02X} {high:02X} {sub:02X} 10 0E 00 00")).text
}

/// The physical value at the end of a line: `… = 3600 steps (360°)`, `… = 360°`.
fn physical(text: &str) -> &str {
    let text = text.split(" [").next().unwrap_or_default();
    text.rsplit(['(', '=']).next().unwrap_or_default().trim().trim_end_matches(')')
}

/// A turn has 3600 scaled steps; 3600 of 8192 physical steps are 158.203125 degrees.
#[test]
fn positions_of_every_kind_are_degrees() {
    const SCALED: &str = "360°";
    const RAW: &str = "158.203125°";
    let mut trace = encoder(2);
    for (objects, sub, unit) in [
        (&[0x6003, 0x6004, 0x6509][..], 0, Some(SCALED)),
        (&[0x600C], 0, Some(RAW)),
        (&[0x6010, 0x6020, 0x6310, 0x6317, 0x6320, 0x6327, 0x6330, 0x6337, 0x6401, 0x6402], 1, Some(SCALED)),
        (&[0x6003, 0x6004, 0x6509, 0x600C], 1, None),
        (&[0x6010, 0x6020, 0x6310, 0x6317, 0x6320, 0x6327, 0x6330, 0x6337, 0x6401, 0x6402], 0, None),
        (&[0x6002, 0x600B, 0x6040, 0x630F, 0x6318, 0x6328, 0x6338, 0x6400, 0x6403, 0x2100], 1, None),
    ] {
        for object in objects {
            let text = answer(&mut trace, *object, sub);
            match unit {
                Some(unit) => assert_eq!(physical(&text), unit, "{text}"),
                None => assert!(!text.contains('°'), "{text}"),
            }
        }
    }
}

/// Rotary encoders have the types 1 to 5, and Bh in newer devices; linear encoders have 8 and 9 (CiA 406, device type).
#[test]
fn the_device_type_tells_rotary_from_linear() {
    for kind in 0..=0x0D {
        let text = answer(&mut encoder(kind), 0x6004, 0);
        match kind {
            1..=5 | 0xB => assert_eq!(physical(&text), "360°", "{kind}"),
            // 3600 steps of 8192 × 0.001 µm = 8.192 µm each.
            8 | 9 => assert_eq!(physical(&text), "29.4912 mm", "{kind}"),
            _ => assert!(!text.contains('°') && !text.contains("mm"), "{kind}: {text}"),
        }
    }
    // Profiles other than CiA 406 have other objects at these indexes.
    let mut trace = Trace::new();
    shown(&mut trace, 0x1000, 0, 0x0002_0195);
    shown(&mut trace, 0x6001, 0, 3_600);
    assert!(!answer(&mut trace, 0x6004, 0).contains('°'));
}

/// Bit 2 of 6000h switches scaling on; if 6000h is not known, bit 2 of 6500h shows the same.
#[test]
fn the_operating_status_tells_whether_scaling_is_on() {
    for (operating, status, unit) in [
        (None, None, "360°"),
        (Some(4), None, "360°"),
        (Some(3), None, "158.203125°"),
        (None, Some(4), "360°"),
        (None, Some(0xFB), "158.203125°"),
        (Some(0), Some(4), "158.203125°"),
        (Some(4), Some(0), "360°"),
    ] {
        let mut trace = encoder(1);
        if let Some(operating) = operating {
            shown(&mut trace, 0x6000, 0, operating);
        }
        if let Some(status) = status {
            shown(&mut trace, 0x6500, 0, status);
        }
        let text = answer(&mut trace, 0x6004, 0);
        assert_eq!(physical(&text), unit, "{operating:?} {status:?}");
    }
}

/// 6005h:01 is the configured step of the position; the raw position has the step of the device, 6501h.
#[test]
fn a_linear_encoder_has_two_steps() {
    let mut trace = encoder(8);
    shown(&mut trace, 0x6005, 1, 1_000);
    assert_eq!(physical(&answer(&mut trace, 0x6004, 0)), "3.6 mm");
    assert_eq!(physical(&answer(&mut trace, 0x600C, 0)), "29.4912 mm");
    shown(&mut trace, 0x6501, 0, 0);
    assert!(!answer(&mut trace, 0x600C, 0).contains("mm"));
}

/// Every object that determines the unit also changes the unit of process data with a known layout.
#[test]
fn process_data_follow_every_parameter() {
    let mut trace = encoder(2);
    shown(&mut trace, 0x1A00, 0, 1);
    shown(&mut trace, 0x1A00, 1, 0x6004_0020);
    let position = |trace: &mut Trace| trace.say("185#10 0E 00 00").text;
    for (object, value, unit) in [
        (0x6001, 7_200, "180°"),
        (0x6500, 0, "158.203125°"),
        (0x6501, 3_600, "360°"),
        (0x6000, 4, "180°"),
        (0x6001, 3_600, "360°"),
        (0x1000, 0x0008_0196, "12.96 mm"),
    ] {
        position(&mut trace);
        shown(&mut trace, object, 0, value);
        assert_eq!(physical(&position(&mut trace)), unit, "{object:04X}h");
    }
    shown(&mut trace, 0x6005, 1, 1_000);
    assert_eq!(physical(&position(&mut trace)), "3.6 mm");
}

/// The description has a mapping of two entries, and another mapping is read entry by entry: until the last entry is
/// read, the mapping is not known.
#[test]
fn a_mapping_that_is_read_is_not_mixed_with_the_description() {
    let entry = "ParameterName=x\nObjectType=7\nAccessType=rw\n";
    let eds = format!(
        "[DeviceInfo]\nVendorName=x\n[1A00]\nParameterName=x\nObjectType=9\nSubNumber=3\n\
         [1A00sub0]\n{entry}DataType=5\nDefaultValue=2\n[1A00sub1]\n{entry}DataType=7\nDefaultValue=0x21000010\n\
         [1A00sub2]\n{entry}DataType=7\nDefaultValue=0x21010010\n"
    );
    let device = KnownDevice::described(DeviceDescription::read(eds.as_bytes()).unwrap());
    let mut trace = Trace::new();
    trace.network.describe(NodeId::new(5).unwrap(), device);
    let text = |trace: &mut Trace| trace.say("185#01 00 02 00").text;
    assert!(text(&mut trace).contains("2100h"), "the mapping of the description");
    shown(&mut trace, 0x1A00, 0, 2);
    assert!(text(&mut trace).contains("2100h"), "what was read is as described");
    shown(&mut trace, 0x1A00, 1, 0x2200_0010);
    assert!(text(&mut trace).contains("mapping not known"), "{}", text(&mut trace));
    shown(&mut trace, 0x1A00, 2, 0x2201_0010);
    let read = text(&mut trace);
    assert!(read.contains("2200h") && read.contains("2201h"), "{read}");
}
