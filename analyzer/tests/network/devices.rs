//! Recognised devices, devices whose own objects set their node-ID or bit rate, and devices that speak LMT.

use crate::trace::Trace;
use crate::{events, node};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::dictionary::{DeviceDescription, KnownDevice, Settings};
use canvass_analyzer::network::{Candidate, Candidates, Event, Fact};
use canvass_traces::{ChannelId, Duration};
use std::sync::Arc;

const EDS: &str = "\
[FileInfo]
FileName=x.eds
[DeviceInfo]
VendorName=x
[1000]
ParameterName=Device type
ObjectType=7
DataType=7
AccessType=ro
DefaultValue=0x00020196
[1018]
ParameterName=Identity
ObjectType=9
SubNumber=2
[1018sub1]
ParameterName=Vendor-ID
ObjectType=7
DataType=7
AccessType=ro
DefaultValue=0x13
[1018sub2]
ParameterName=Product code
ObjectType=7
DataType=7
AccessType=ro
DefaultValue=0x58682001
[1800]
ParameterName=TPDO 1
ObjectType=9
SubNumber=2
[1800sub1]
ParameterName=COB-ID
ObjectType=7
DataType=7
AccessType=rw
DefaultValue=$NODEID+0x180
[1A00]
ParameterName=TPDO 1 mapping
ObjectType=9
SubNumber=2
[1A00sub0]
ParameterName=Count
ObjectType=7
DataType=5
AccessType=rw
DefaultValue=1
[1A00sub1]
ParameterName=Entry
ObjectType=7
DataType=7
AccessType=rw
DefaultValue=0x21500010
[2150]
ParameterName=Chip temperature
ObjectType=7
DataType=3
AccessType=ro
PDOMapping=1
";

fn described() -> KnownDevice {
    let mut device = KnownDevice::described(DeviceDescription::read(EDS.as_bytes()).unwrap());
    device.manual.settings = Settings {
        node_id: Some(Multiplexer::new(0x2101, 0)),
        bit_rate: Some(Multiplexer::new(0x2100, 0)),
        bit_rates: vec![(5, 250_000), (6, 500_000)],
        shortest_cycles: Vec::new(),
        layer_management: false,
        padded_tpdos: Vec::new(),
    };
    device
}

fn offering() -> Trace {
    let mut trace = Trace::new();
    trace.network.offer(Candidates::new(|| [Candidate::of("model", Arc::new(described()))].into()));
    trace
}

#[test]
fn a_model_is_recognised_by_its_identity() {
    let mut trace = offering();
    assert_eq!(trace.say("1BF#03 01").text, "TPDO 1, 2 bytes, mapping not known");
    trace.say("63F#40 18 10 01 00 00 00 00");
    trace.say("5BF#43 18 10 01 13 00 00 00");
    trace.say("63F#40 18 10 02 00 00 00 00");
    let said = events(&mut trace, "5BF#43 18 10 02 01 20 68 58");
    assert_eq!(said, [Event::TransferEnded, Event::Recognised(node(63))]);
    assert_eq!(trace.say("1BF#03 01").text, "TPDO 1: 2150h:00 Chip temperature = 259");
    assert_eq!(trace.say("63F#40 50 21 00 00 00 00 00").text, "read 2150h:00 Chip temperature");
    let bus = trace.network.bus(ChannelId(0)).unwrap();
    let recognition = bus.node(node(63)).unwrap().recognition.as_ref().unwrap();
    assert_eq!((&*recognition.model, recognition.by.len()), ("model", 2));
    // A repeated read causes no event, and other nodes are not recognised.
    trace.say("63F#40 18 10 02 00 00 00 00");
    assert_eq!(events(&mut trace, "5BF#43 18 10 02 01 20 68 58"), [Event::TransferEnded]);
    assert_eq!(trace.say("181#03 01").text, "TPDO 1, 2 bytes, mapping not known");
}

#[test]
fn another_product_is_not_recognised() {
    let mut trace = offering();
    for frame in ["63F#40 18 10 01 00 00 00 00", "5BF#43 18 10 01 13 00 00 00", "63F#40 18 10 02 00 00 00 00"] {
        trace.say(frame);
    }
    assert_eq!(events(&mut trace, "5BF#43 18 10 02 02 20 68 58"), [Event::TransferEnded]);
}

/// COB-IDs and mappings that the trace has shown override the defaults of the model.
#[test]
fn the_trace_knows_better_than_a_model() {
    let mut trace = offering();
    for frame in [
        "63F#23 00 18 01 0A 01 00 00",
        "5BF#60 00 18 01 00 00 00 00",
        "63F#23 00 1A 01 20 00 04 60",
        "5BF#60 00 1A 01 00 00 00 00",
        "63F#40 18 10 01 00 00 00 00",
        "5BF#43 18 10 01 13 00 00 00",
        "63F#40 18 10 02 00 00 00 00",
    ] {
        trace.say(frame);
    }
    assert_eq!(events(&mut trace, "5BF#43 18 10 02 01 20 68 58")[1], Event::Recognised(node(63)));
    assert_eq!(trace.say("1BF#03 01").service(), "unknown");
    assert_eq!(trace.say("10A#BA 4C 00 00").text, "TPDO 1: 6004h:00 Position value = 19642 steps");
}

/// A description that the user gave is not replaced.
#[test]
fn what_the_user_says_is_not_doubted() {
    let mut trace = offering();
    trace.network.describe(node(63), KnownDevice::default());
    for frame in ["63F#40 18 10 01 00 00 00 00", "5BF#43 18 10 01 13 00 00 00", "63F#40 18 10 02 00 00 00 00"] {
        trace.say(frame);
    }
    assert_eq!(events(&mut trace, "5BF#43 18 10 02 01 20 68 58"), [Event::TransferEnded]);
}

/// The model is recognised by device type and name; the name comes in segments.
#[test]
fn a_model_is_recognised_by_its_name() {
    let mut candidate = Candidate::of("named", Arc::new(described()));
    candidate.set(Multiplexer::new(0x1008, 0), Fact::Begins("Sendix".to_owned()));
    let mut trace = Trace::new();
    trace.network.offer(Candidates::new(move || [candidate].into()));
    for frame in [
        "605#40 00 10 00 00 00 00 00",
        "585#43 00 10 00 96 01 02 00",
        "605#40 08 10 00 00 00 00 00",
        "585#41 08 10 00 07 00 00 00",
        "605#60 00 00 00 00 00 00 00",
    ] {
        assert!(!events(&mut trace, frame).contains(&Event::Recognised(node(5))));
    }
    assert!(events(&mut trace, "585#01 53 65 6E 64 69 78 31").contains(&Event::Recognised(node(5))));
}

/// 2101h and 2100h of Sendix encoders: the device starts with the written settings, and its description moves with it.
#[test]
fn a_node_id_and_a_bit_rate_that_were_written_take_effect_at_the_start() {
    let mut trace = Trace::new();
    trace.network.describe(node(63), described());
    for frame in [
        "63F#2F 01 21 00 2A 00 00 00",
        "5BF#60 01 21 00 00 00 00 00",
        "63F#2F 00 21 00 06 00 00 00",
        "5BF#60 00 21 00 00 00 00 00",
        "000#81 3F",
    ] {
        trace.say(frame);
    }
    let changed =
        Event::NodeIdChanged { from: Some(node(63)), to: node(42), object: Some(Multiplexer::new(0x2101, 0)) };
    let rate = Event::BitRateChanged { node: Some(node(42)), bit_rate: Some(500_000), delay: Duration::ZERO };
    let started = events(&mut trace, "72A#00");
    assert!(started.contains(&changed) && started.contains(&rate), "{started:?}");
    assert_eq!(trace.say("1AA#03 01").text, "TPDO 1: 2150h:00 Chip temperature = 259");
    assert!(!events(&mut trace, "72A#00").contains(&changed), "it has it since then");
}

/// The device refuses the write, or does not keep the value.
#[test]
fn what_did_not_take_effect_is_forgotten() {
    let mut trace = Trace::new();
    trace.network.describe(node(63), described());
    trace.say("63F#2F 01 21 00 00 00 00 00");
    trace.say("5BF#80 01 21 00 30 00 09 06");
    assert_eq!(events(&mut trace, "72A#00").len(), 1);
    trace.say("63F#2F 01 21 00 2B 00 00 00");
    trace.say("5BF#60 01 21 00 00 00 00 00");
    trace.say("73F#00");
    assert_eq!(events(&mut trace, "72B#00").len(), 1, "node 63 still had its node-ID");
}

/// Both protocols have "configure bit timing"; their tables differ from code 5 on.
#[test]
fn lmt_is_known_from_the_description() {
    let mut lmt = KnownDevice::default();
    lmt.manual.settings.layer_management = true;
    let mut trace = Trace::new();
    trace.network.describe(node(5), lmt.clone());
    let said = trace.say("7E5#13 00 05 00 00 00 00 00");
    assert_eq!((said.service(), said.text.as_str()), ("lmt", "LMT configure bit timing: 50 kbit/s"));
    // A message that only LSS has shows that the bus uses LSS.
    trace.say("7E5#5E 00 00 00 00 00 00 00");
    assert_eq!(trace.say("7E5#13 00 05 00 00 00 00 00").service(), "lss");

    let mut lss = KnownDevice::default();
    lss.description.device.lss_supported = true;
    let mut trace = Trace::new();
    trace.network.describe(node(5), lmt);
    trace.network.describe(node(6), lss);
    assert_eq!(trace.say("7E5#13 00 05 00 00 00 00 00").service(), "lss", "it may be either");
}

const SRDO: &str = "\
[DeviceInfo]
VendorName=x
[1301]
ParameterName=SRDO 1
ObjectType=9
SubNumber=7
[1301sub1]
ParameterName=Direction
ObjectType=7
DataType=5
AccessType=rw
DefaultValue=1
[1301sub5]
ParameterName=COB-ID 1
ObjectType=7
DataType=7
AccessType=rw
DefaultValue=$NODEID+0x10A
[1301sub6]
ParameterName=COB-ID 2
ObjectType=7
DataType=7
AccessType=rw
DefaultValue=$NODEID+0x10B
";

/// The trace shows the parameters of an SRDO. The SRDO is then known without its inverted twin, and its mapping names
/// the data.
#[test]
fn an_srdo_is_known_by_its_parameters() {
    let mut trace = Trace::new();
    for (object, answer) in [
        ("00 10 00", "96 01 02 00"),
        ("01 13 05", "41 01 00 00"),
        ("01 13 06", "42 01 00 00"),
        ("81 13 00", "02 00 00 00"),
        ("81 13 01", "20 00 04 60"),
        ("81 13 02", "20 00 04 61"),
    ] {
        trace.say(&format!("605#40 {object} 00 00 00 00"));
        trace.say(&format!("585#43 {object} {answer}"));
    }
    let said = trace.say("141#BA 4C 00 00");
    assert_eq!(said.decoded.node, Some(node(5)));
    assert_eq!((said.service(), said.text.as_str()), ("srdo", "SRDO 1 data: 6004h:00 Position value = 19642 steps"));
    assert_eq!(trace.say("142#45 B3 FF FF").text, "SRDO 1 inverted data");
    assert_eq!(trace.say("142#45 B3 FF FF").text, "SRDO 1 inverted data, without the data before it");
    // The SRDO is switched off.
    trace.say("605#2F 01 13 01 00 00 00 00");
    trace.say("585#60 01 13 01 00 00 00 00");
    assert_eq!(trace.say("141#BA 4C 00 00").service(), "unknown");
}

#[test]
fn an_srdo_of_a_description_belongs_to_its_sender() {
    let mut trace = Trace::new();
    let device = KnownDevice::described(DeviceDescription::read(SRDO.as_bytes()).unwrap());
    trace.network.describe(node(5), device);
    let said = trace.say("110#11");
    assert_eq!((said.service(), said.decoded.node), ("srdo", Some(node(5))), "{}", said.text);
    // Node 9 receives the SRDO.
    for frame in [
        "609#2F 01 13 01 02 00 00 00",
        "589#60 01 13 01 00 00 00 00",
        "609#23 01 13 06 10 01 00 00",
        "589#60 01 13 06 00 00 00 00",
    ] {
        trace.say(frame);
    }
    assert_eq!(trace.say("110#11").decoded.node, Some(node(5)));
}
