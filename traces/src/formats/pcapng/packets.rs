//! The content of a section's blocks: interfaces, packets, and reports of lost frames.

use super::block::{self, options_of_packet};
use super::interface::{self, Interface};
use crate::formats::socketcan::{self, LINK_TYPES};
use crate::{Channels, Damage, DamageKind, Direction, Place, Record, Timestamp};
use pcap_file::pcapng::blocks::enhanced_packet::{EnhancedPacketBlock, EnhancedPacketOption};
use pcap_file::pcapng::blocks::interface_description::{
    InterfaceDescriptionBlock, InterfaceDescriptionOption, InterfaceTsResolution,
};
use pcap_file::pcapng::blocks::interface_statistics::{InterfaceStatisticsBlock, InterfaceStatisticsOption};
use pcap_file::pcapng::blocks::opt_common::CommonOption;
use pcap_file::pcapng::blocks::packet::{PacketBlock, PacketOption};
use pcap_file::pcapng::blocks::section_header::SectionHeaderBlock;
use pcap_file::pcapng::blocks::simple_packet::SimplePacketBlock;
use pcap_file::pcapng::blocks::{
    ENHANCED_PACKET_BLOCK, INTERFACE_DESCRIPTION_BLOCK, INTERFACE_STATISTIC_BLOCK, PACKET_BLOCK, SIMPLE_PACKET_BLOCK,
};
use pcap_file::pcapng::{BlockContentParseError, ContentValidationError, PcapNgBlock, PcapNgState};
use pcap_file::{DataLink, Endianness};
use std::borrow::Cow;
use std::time::Duration;

/// Maximum number of interfaces in a section.
const MOST_INTERFACES: usize = 65_536;

/// The state of a section, as far as it was read.
#[derive(Default)]
pub(crate) struct Section {
    /// The state of the crate's parser.
    state: PcapNgState,
    /// The interfaces; `None` for an interface with an unreadable description.
    pub(crate) interfaces: Vec<Option<Interface>>,
    pub(crate) latest: Option<Timestamp>,
    /// Whether a packet without time has occurred.
    pub(crate) untimed: bool,
}

/// The content of a block; the damage is reported before the frame.
#[derive(Default)]
pub(crate) struct Content {
    pub(crate) damage: Option<Damage>,
    pub(crate) record: Option<Record>,
}

impl From<Damage> for Content {
    fn from(damage: Damage) -> Self {
        Self { damage: Some(damage), record: None }
    }
}

/// A packet from a packet block of any of the three kinds.
struct Packet<'a> {
    interface: u32,
    /// The time in units of the interface; `None` for a simple packet block.
    time: Option<Duration>,
    original: u32,
    data: Cow<'a, [u8]>,
    direction: Direction,
    /// Number of frames lost before this packet.
    drops: u64,
    comment: Option<Cow<'a, str>>,
    /// Whether the options of the packet are readable.
    whole: bool,
}

impl Section {
    /// Begins a section, without interfaces yet.
    pub(crate) fn begin(&mut self, endianness: Endianness) {
        let header = SectionHeaderBlock { endianness, ..SectionHeaderBlock::default() };
        self.state.update_from_block(&header.into_block());
        self.interfaces.clear();
    }

    /// The content of a block other than a section header.
    pub(crate) fn content(
        &mut self,
        order: Endianness,
        kind: u32,
        body: &[u8],
        place: Place,
        channels: &mut Channels,
    ) -> Content {
        let packet = match kind {
            ENHANCED_PACKET_BLOCK => enhanced_packet(order, &self.state, body),
            PACKET_BLOCK => packet(order, &self.state, body),
            SIMPLE_PACKET_BLOCK => simple_packet(order, &self.state, body),
            INTERFACE_DESCRIPTION_BLOCK => return self.describe(order, body, place, channels),
            INTERFACE_STATISTIC_BLOCK => return self.statistics(order, body, place),
            _ if block::is_aside(order, &self.state, kind, body) => return Content::default(),
            _ => {
                let found = format!("type {kind:08X}h");
                let expected = "a block of a known type, with its content";
                return Damage::new(DamageKind::Unsupported, place, expected, found.as_bytes()).into();
            }
        };
        match packet {
            Ok(packet) => self.packet(order, place, &packet, channels),
            Err(BlockContentParseError::Validation(
                ContentValidationError::InvalidInterfaceId(_) | ContentValidationError::NoInterface,
            )) => {
                let expected = format!("one of the section's {} interfaces", self.interfaces.len());
                Damage::new(DamageKind::Malformed, place, expected, b"another").into()
            }
            Err(error) => unreadable(place, "a packet that fits into its block", &error.to_string()),
        }
    }

    /// Adds an interface. An interface with an unreadable description keeps its number.
    fn describe(&mut self, order: Endianness, body: &[u8], place: Place, channels: &mut Channels) -> Content {
        let number = self.interfaces.len();
        if number >= MOST_INTERFACES {
            return unreadable(place, "at most 65536 interfaces", "");
        }
        // The crate refuses a block for a reserved bit or an invalid option; so the fields are read here.
        let fields = body.first_chunk::<8>().map(|&[l0, l1, _, _, s0, s1, s2, s3]| [l0, l1, 0, 0, s0, s1, s2, s3]);
        let description = fields.and_then(|fields| {
            let (read, _) = block::content::<InterfaceDescriptionBlock<'_>>(order, &self.state, &fields, 8).ok()?;
            Some((read.linktype, read.snaplen))
        });
        let (linktype, snaplen) = description.unwrap_or((DataLink::NULL, 0));
        // The crate gets the resolution of a nanosecond for each interface, so that it returns times unconverted (see
        // the module's docs).
        let options = vec![InterfaceDescriptionOption::IfTsResol(InterfaceTsResolution::NANO)];
        self.state.update_from_block(&InterfaceDescriptionBlock { linktype, snaplen, options }.into_block());
        if description.is_none() {
            self.interfaces.push(None);
            return unreadable(place, "an interface description", "");
        }
        // The field has 16 bits.
        let link = u32::from(linktype) as u16;
        let options = body.get(8..).unwrap_or_default();
        let (interface, readable) = interface::described(order, link, options, number, channels);
        self.interfaces.push(Some(interface));
        if readable && body.get(2..4) == Some(&[0; 2]) {
            return Content::default();
        }
        unreadable(place, "an interface description with options that fit into it", "")
    }

    /// Reports lost packets that only the interface's statistics mention.
    fn statistics(&mut self, order: Endianness, body: &[u8], place: Place) -> Content {
        let read = block::content::<InterfaceStatisticsBlock<'_>>(order, &self.state, body, 12);
        let Ok((statistics, whole)) = read else { return unreadable(place, "interface statistics", "") };
        let dropped = statistics.options.iter().fold(0_u64, |sum, option| match option {
            InterfaceStatisticsOption::IsbIfDrop(n) | InterfaceStatisticsOption::IsbOsDrop(n) => sum.saturating_add(*n),
            _ => sum,
        });
        let Some(Some(interface)) = self.interfaces.get_mut(statistics.interface_id as usize) else {
            return unreadable(place, "statistics of an interface that is described", "");
        };
        if dropped > interface.dropped {
            let more = dropped - std::mem::replace(&mut interface.dropped, dropped);
            return Damage::dropped(more, place).into();
        }
        if whole { Content::default() } else { unreadable(place, "interface statistics, and nothing after them", "") }
    }

    /// The frame of a packet, and the damage that precedes it.
    fn packet(&mut self, order: Endianness, place: Place, packet: &Packet<'_>, channels: &mut Channels) -> Content {
        let (drops, whole) = (packet.drops, packet.whole);
        let interface = packet.interface as usize;
        let (record, damage) = match self.frame(order, place, packet, channels) {
            Ok(record) => match &packet.comment {
                Some(comment) => (Some(record.with_comment(comment)), None),
                None => (Some(record), None),
            },
            Err(damage) => (None, Some(damage)),
        };
        if drops > 0 {
            if let Some(Some(interface)) = self.interfaces.get_mut(interface) {
                interface.dropped = interface.dropped.saturating_add(drops);
            }
            // If there are two damages, the frame's own is reported: it says more than the loss before the frame.
            let dropped = Damage::dropped(drops, place);
            return Content { damage: Some(damage.unwrap_or(dropped)), record };
        }
        let options = (!whole).then(|| malformed(place, "packet options that fit into their block", ""));
        Content { damage: damage.or(options), record }
    }

    fn frame(
        &mut self,
        order: Endianness,
        place: Place,
        packet: &Packet<'_>,
        channels: &mut Channels,
    ) -> Result<Record, Damage> {
        let damage =
            |kind, expected: Cow<'static, str>, found: &str| Damage::new(kind, place, expected, found.as_bytes());
        let Some(Some(interface)) = self.interfaces.get(packet.interface as usize) else {
            let expected = "an interface whose description can be read".into();
            return Err(damage(DamageKind::Malformed, expected, &packet.interface.to_string()));
        };
        let Some(link) = interface.link else {
            let found = format!("link type {}", interface.link_number);
            return Err(damage(DamageKind::Unsupported, LINK_TYPES.into(), &found));
        };
        if packet.data.len() < packet.original as usize {
            let expected = format!("a packet of {} bytes", packet.original);
            return Err(damage(DamageKind::Truncated, expected.into(), &format!("cut to {}", packet.data.len())));
        }
        let nom_order = match order {
            Endianness::Big => nom::number::Endianness::Big,
            Endianness::Little => nom::number::Endianness::Little,
        };
        let seen = socketcan::decode(link, nom_order, &packet.data).map_err(|flaw| flaw.damage(place))?;
        let mut record = seen.record;
        record.channel = match seen.interface {
            Some(index) => channels.intern(&format!("if{index}")),
            None => interface.channel,
        };
        record.place = place;
        if packet.direction != Direction::Unknown {
            record.direction = packet.direction;
        }
        // A packet without time, between packets with times, gets the latest time before it.
        record.timestamp = self.latest.unwrap_or_default();
        match packet.time {
            None => self.untimed = true,
            Some(time) => {
                let number = u64::try_from(time.as_nanos()).unwrap_or(u64::MAX);
                let Some(timestamp) = interface.clock.timestamp(number) else {
                    let (expected, found) = ("a time from 1970 to 2554", format!("{number} units of the interface"));
                    return Err(malformed(place, expected, &found).with_salvaged(record));
                };
                record.timestamp = *self.latest.insert(timestamp);
            }
        }
        Ok(record)
    }
}

fn malformed(place: Place, expected: &'static str, found: &str) -> Damage {
    Damage::new(DamageKind::Malformed, place, expected, found.as_bytes())
}

fn unreadable(place: Place, expected: &'static str, found: &str) -> Content {
    malformed(place, expected, found).into()
}

type Parsed<T> = Result<T, BlockContentParseError>;

fn enhanced_packet<'a>(order: Endianness, state: &PcapNgState, body: &'a [u8]) -> Parsed<Packet<'a>> {
    let (block, whole): (EnhancedPacketBlock<'a>, _) =
        block::content(order, state, body, options_of_packet(order, body))?;
    let EnhancedPacketBlock { interface_id: interface, timestamp, original_len: original, data, options } = block;
    let (mut direction, mut drops, mut comment) = (Direction::Unknown, 0, None);
    for option in options {
        match option {
            EnhancedPacketOption::Flags(flags) => direction = block::flags_direction(flags),
            EnhancedPacketOption::DropCount(n) => drops = n,
            EnhancedPacketOption::Common(CommonOption::Comment(text)) => comment = Some(text),
            _ => {}
        }
    }
    Ok(Packet { interface, time: Some(timestamp), original, data, direction, drops, comment, whole })
}

fn packet<'a>(order: Endianness, state: &PcapNgState, body: &'a [u8]) -> Parsed<Packet<'a>> {
    let (block, whole): (PacketBlock<'a>, _) = block::content(order, state, body, options_of_packet(order, body))?;
    let PacketBlock { interface_id, drop_count, timestamp, original_len: original, data, options } = block;
    let flags = options.iter().find_map(|option| match option {
        PacketOption::Flags(flags) => Some(*flags),
        _ => None,
    });
    let direction = block::flags_direction(flags.unwrap_or_default());
    // FFFFh means that the number is unknown.
    let drops = if drop_count == u16::MAX { 0 } else { drop_count.into() };
    Ok(Packet {
        interface: interface_id.into(),
        time: Some(timestamp),
        original,
        data,
        direction,
        drops,
        comment: None,
        whole,
    })
}

fn simple_packet<'a>(order: Endianness, state: &PcapNgState, body: &'a [u8]) -> Parsed<Packet<'a>> {
    let (block, _): (SimplePacketBlock<'a>, _) = block::content(order, state, body, body.len())?;
    let SimplePacketBlock { original_len: original, data } = block;
    Ok(Packet {
        interface: 0,
        time: None,
        original,
        data,
        direction: Direction::Unknown,
        drops: 0,
        comment: None,
        whole: true,
    })
}
