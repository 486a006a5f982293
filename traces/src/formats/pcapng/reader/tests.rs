//! The quick reader for usual packets gives the same records as the full reader.

use super::*;
use pcap_file::pcapng::blocks::{ENHANCED_PACKET_BLOCK, INTERFACE_DESCRIPTION_BLOCK, SECTION_HEADER_BLOCK};
use proptest::prelude::*;

const EPB_FLAGS: u16 = 2;
const EPB_DROPCOUNT: u16 = 4;

/// A block of this type, in either byte order, with its length at both ends.
fn framed(big: bool, kind: u32, body: &[u8]) -> Vec<u8> {
    let length = word(big, 12 + body.len() as u32);
    [&word(big, kind)[..], &length, body, &length].concat()
}

fn word(big: bool, number: u32) -> [u8; 4] {
    if big { number.to_be_bytes() } else { number.to_le_bytes() }
}

fn half(big: bool, number: u16) -> [u8; 2] {
    if big { number.to_be_bytes() } else { number.to_le_bytes() }
}

/// A section with two interfaces, of link types 227 and 113.
fn section(big: bool) -> Vec<u8> {
    let header = [&word(big, 0x1A2B_3C4D)[..], &half(big, 1), &half(big, 0), &[0xFF; 8]].concat();
    let interface = |link| framed(big, INTERFACE_DESCRIPTION_BLOCK, &[&half(big, link)[..], &[0; 6]].concat());
    [framed(big, SECTION_HEADER_BLOCK, &header), interface(227), interface(113)].concat()
}

fn packet(big: bool, interface: u32, cut: u32, data: &[u8], options: &[u8]) -> Vec<u8> {
    let filled = [data, &vec![0; data.len().next_multiple_of(4) - data.len()]].concat();
    let captured = data.len() as u32;
    let words = [interface, 0x0006_1234, 0x8765_4321, captured, captured + cut].map(|number| word(big, number));
    framed(big, ENHANCED_PACKET_BLOCK, &[words.as_flattened(), &filled, options].concat())
}

/// Packet options: flags alone, or with another option, which makes the packet unusual.
fn options(big: bool) -> impl Strategy<Value = Vec<u8>> {
    let flags = move |value: u32| [&half(big, EPB_FLAGS)[..], &half(big, 4), &word(big, value)].concat();
    let drops = [&half(big, EPB_DROPCOUNT)[..], &half(big, 8), &[0; 3], &[1], &[0; 4]].concat();
    prop_oneof![
        Just(Vec::new()),
        (0..4_u32).prop_map(move |value| [&flags(value)[..], &[0; 4]].concat()),
        (0..4_u32).prop_map(flags),
        Just([&drops[..], &[0; 4]].concat()),
        proptest::collection::vec(any::<u8>(), 0..16).prop_map(|mut bytes| {
            bytes.truncate(bytes.len() / 4 * 4);
            bytes
        }),
    ]
}

/// The items that the reader gives, with or without the quick reader.
fn read(bytes: &[u8], usual: bool) -> Vec<String> {
    let mut reader = PcapngReader::new(Source::from_bytes(bytes));
    let mut seen = Vec::new();
    while seen.len() < 100 && !reader.done {
        if usual && let Some(record) = reader.usual_block() {
            seen.push(format!("{record:?}"));
            continue;
        }
        let Yield::Content(Content { damage, record }) = reader.block() else { break };
        let fatal = damage.as_ref().is_some_and(|damage| damage.kind.is_fatal());
        seen.extend(damage.map(|damage| format!("{damage:?}")));
        seen.extend(record.map(|record| format!("{record:?}")));
        if fatal {
            break;
        }
    }
    seen
}

proptest! {
    #[test]
    fn usual_packets_are_read_as_all_others(
        (bytes, changed, value) in any::<bool>().prop_flat_map(|big| {
            let data = prop_oneof![
                (any::<u32>(), 0..10_u8, 0..10_usize).prop_map(|(id, len, more)| {
                    [&id.to_be_bytes()[..], &[len, 0, 0, 0], &vec![0xA5; more]].concat()
                }),
                proptest::collection::vec(any::<u8>(), 0..24),
            ];
            let packets = (0..3_u32, 0..10_u32, data, options(big)).prop_map(move |(interface, cut, data, options)| {
                packet(big, interface, cut.saturating_sub(8), &data, &options)
            });
            let packets = proptest::collection::vec(packets, 1..6);
            let bytes = packets.prop_map(move |packets| [section(big), packets.concat()].concat());
            (bytes, any::<prop::sample::Index>(), any::<u8>())
        })
    ) {
        prop_assert_eq!(read(&bytes, true), read(&bytes, false));
        let mut damaged = bytes;
        let at = changed.index(damaged.len());
        damaged[at] = value;
        prop_assert_eq!(read(&damaged, true), read(&damaged, false));
        damaged.truncate(at);
        prop_assert_eq!(read(&damaged, true), read(&damaged, false));
    }
}
