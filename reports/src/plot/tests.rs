//! Curves of a capture, as text and as a picture.

use super::{Curves, contains_word};
use crate::signals::Sampler;
use canvass_analyzer::dictionary::{DeviceDescription, KnownDevice};
use canvass_analyzer::network::Network;
use canvass_analyzer::{Meaning, NodeId};
use canvass_traces::{Channels, Record, Timestamp, parse_frame};

const MAPPED: &str = "
[DeviceInfo]
VendorName=none
[OptionalObjects]
SupportedObjects=3
1=0x1800
2=0x1A00
3=0x6004
[1800]
ParameterName=TPDO 1
ObjectType=0x9
SubNumber=3
[1800sub0]
ParameterName=count
DataType=5
AccessType=const
DefaultValue=2
[1800sub1]
ParameterName=COB-ID
DataType=7
AccessType=rw
DefaultValue=$NODEID+0x180
[1800sub2]
ParameterName=type
DataType=5
AccessType=rw
DefaultValue=254
[1A00]
ParameterName=mapping
ObjectType=0x9
SubNumber=2
[1A00sub0]
ParameterName=count
DataType=5
AccessType=rw
DefaultValue=1
[1A00sub1]
ParameterName=first
DataType=7
AccessType=rw
DefaultValue=0x60040020
[6004]
ParameterName=Position <b>
DataType=7
AccessType=ro
PDOMapping=1
";

/// The curves of a position that rises by 10 a second, of the nodes 5 and 15.
fn curves(wishes: &[&str]) -> (Curves, Sampler) {
    let described = DeviceDescription::read(MAPPED.as_bytes()).unwrap();
    let mut network = Network::new();
    for node in [5, 15] {
        network.describe(NodeId::new(node).unwrap(), KnownDevice::described(described.clone()));
    }
    let wishes: Vec<String> = wishes.iter().map(|&wish| wish.to_owned()).collect();
    let (mut curves, mut sampler, mut channels) = (Curves::new(&wishes), Sampler::new(None), Channels::new());
    let channel = channels.intern("can0");
    for n in 0..=100_u32 {
        for node in [5, 15] {
            let text = format!("{:03X}#{}", 0x180 + node, canvass_traces::hex::compact(&n.to_le_bytes()));
            let record = Record::new(Timestamp(u64::from(n) * 100_000_000), channel, parse_frame(&text).unwrap().frame);
            let decoded = network.handle(&record);
            let meaning = Meaning::new(&record, &decoded, network.bus(channel).unwrap());
            sampler.frame(&record, &channels, &decoded, &meaning, &mut curves, &mut Vec::new()).unwrap();
        }
    }
    (curves, sampler)
}

#[test]
fn wishes_choose_columns_by_words() {
    let chosen = |wishes: &[&str]| curves(wishes).0.chosen.len();
    assert_eq!([chosen(&[]), chosen(&["node 5"]), chosen(&["position 15"]), chosen(&["speed"])], [2, 1, 1, 0]);
    assert!(contains_word("node 15 position", "15") && !contains_word("node 15 position", "5"));
}

#[test]
fn a_rising_value_is_a_rising_line() {
    let (curves, sampler) = curves(&["node 5"]);
    let plot = curves.plot(sampler.columns(), |_| "10:47:15".to_owned()).unwrap();
    let text = plot.text(60);
    let lines: Vec<&str> = text.lines().collect();
    assert!(lines[0].contains("node 5 Position <b>"), "{text}");
    assert!(lines[1].trim_start().starts_with("100") && lines[10].trim_start().starts_with("0 │"), "{text}");
    // The line begins at the lower left and ends at the upper right.
    let drawn = |line: &str| {
        line.chars()
            .enumerate()
            .filter(|(_, c)| ('\u{2801}'..='\u{28FF}').contains(c))
            .map(|(at, _)| at)
            .collect::<Vec<_>>()
    };
    let lefts: Vec<usize> = lines[1..=10].iter().map(|line| drawn(line)[0]).collect();
    assert!(lefts.windows(2).all(|pair| pair[0] > pair[1]), "{text}");
    assert!(lines[11].ends_with("10 s") && lines[12].ends_with("0 s is 10:47:15"), "{text}");
    assert!(text.lines().all(|line| line.chars().count() <= 60), "{text}");
}

#[test]
fn the_picture_has_the_values_and_escapes_names() {
    let (curves, sampler) = curves(&["node 5"]);
    let svg = curves.plot(sampler.columns(), |_| String::new()).unwrap().svg();
    assert!(svg.contains("Position &lt;b&gt;") && !svg.contains("<b>"), "{svg}");
    let path = svg.split(" d=\"").nth(1).unwrap().split('"').next().unwrap();
    assert!(path.starts_with("M90.0 ") && path.matches('L').count() == 100, "{path}");
    let mut parser = quick_xml::Reader::from_str(&svg);
    while !matches!(parser.read_event().unwrap(), quick_xml::events::Event::Eof) {}
}
