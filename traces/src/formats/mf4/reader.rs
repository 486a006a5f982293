//! Reads MF4: first the whole file into memory, then its frames in the order of their times.

use super::block::{Block, Survey, chain, survey};
use super::data::content;
use super::group::{Group, groups};
use super::records::{numbered, sorted};
use crate::damage::Flaw;
use crate::{Channels, Damage, DamageKind, Place, ReadOptions, Reader, Record, Source, TimeBase, Timestamp};
use nom::bytes::complete::{tag, take};
use nom::number::complete::{le_u16, le_u64, u8};
use nom::{IResult, Parser};
use std::collections::BTreeMap;
use std::io::Read;

/// Limit of the size of a file in bytes: 1 GiB.
pub(super) const LARGEST: u64 = 1 << 30;

pub(super) const FINISHED: &[u8] = b"MDF     ";
pub(super) const UNFINISHED: &[u8] = b"UnFinMF ";
/// The offset of the block HD.
pub(super) const HEADER: u64 = 64;
/// Flag of the start of the measurement: local time of an unknown zone.
pub(super) const LOCAL: u8 = 0x01;

pub(crate) fn sniff(head: &[u8]) -> bool {
    // MDF 3 has the same first bytes; its files have no frames of a bus.
    (head.starts_with(FINISHED) || head.starts_with(UNFINISHED)) && head.get(8) == Some(&b'4')
}

pub(crate) fn open(source: Source, _options: &ReadOptions) -> Box<dyn Reader> {
    let (items, channels, base) = (Vec::new().into_iter(), Channels::new(), TimeBase::default());
    Box::new(Mf4Reader { source: Some(source), items, channels, base })
}

struct Mf4Reader {
    /// The file; `None` once it was read.
    source: Option<Source>,
    items: std::vec::IntoIter<Result<Record, Damage>>,
    channels: Channels,
    base: TimeBase,
}

/// What a file holds.
#[derive(Default)]
struct Items {
    rows: Vec<Result<Record, Damage>>,
    channels: Channels,
    base: TimeBase,
    /// Start of the measurement in nanoseconds since 1970.
    start: u64,
    /// Number of channel groups whose records are no frames.
    others: u64,
    /// Whether the recorder did not finish the file, so that its counts say nothing.
    is_unfinished: bool,
    /// Whether the file ends too early.
    is_cut: bool,
    /// Number of data groups and of channel groups to which links lead.
    found: [usize; 2],
    number: u64,
}

impl Mf4Reader {
    fn load(&mut self, mut source: Source) {
        let mut file = Vec::new();
        let read = (&mut source).take(LARGEST + 1).read_to_end(&mut file);
        let place = Place { number: 0, offset: file.len() as u64 };
        let mut items = Items::default();
        if file.len() as u64 > LARGEST {
            let damage = Damage::new(DamageKind::Fatal, place, format!("a file of at most {LARGEST} bytes"), b"more");
            items.rows.push(Err(damage));
        } else {
            items.read(&file);
        }
        if let Err(error) = read {
            items.rows.push(Err(Damage::source(&error.into(), place)));
        }
        (self.items, self.channels, self.base) = (items.rows.into_iter(), items.channels, items.base);
    }
}

/// Parses the start of the measurement: nanoseconds, offsets of time zone and daylight saving time (16 bits each), flags.
fn start(i: &[u8]) -> IResult<&[u8], (u64, u8)> {
    (le_u64, take(4usize), u8).map(|(start, _, flags)| (start, flags)).parse(i)
}

/// Parses the flags of a file that was not finished.
fn unfinished(i: &[u8]) -> IResult<&[u8], u16> {
    (tag(UNFINISHED), take(52usize), le_u16).map(|(_, _, flags)| flags).parse(i)
}

impl Items {
    fn read(&mut self, file: &[u8]) {
        let Survey { is_cut, data_groups, groups } = survey(file, HEADER);
        self.is_unfinished = unfinished(file).is_ok_and(|(_, flags)| flags != 0);
        self.is_cut = is_cut || self.is_unfinished;
        let fatal = self.data_groups(file).err();
        // Records of one group are in their order; others lie between them.
        if !self.rows.is_sorted_by_key(time) {
            self.rows.sort_by_key(time);
        }
        if let Some((flaw, offset)) = fatal {
            let damage = flaw.damage(Place { number: self.number, offset });
            self.rows.push(Err(Damage { kind: DamageKind::Fatal, ..damage }));
            return;
        }
        let end = Place { number: self.number, offset: file.len() as u64 };
        if self.rows.is_empty() && self.others > 0 {
            let found = format!("{} groups of others", self.others);
            let expected = "a group of CAN frames, as ASAM MDF bus logging has it";
            self.rows.push(Err(Damage::new(DamageKind::Unsupported, end, expected, found.as_bytes())));
        }
        let unlinked = [data_groups, groups].into_iter().zip(self.found).find(|(there, found)| there > found);
        if let Some((there, found)) = unlinked {
            let flaw =
                Flaw::malformed(format!("links to {there} groups, as many as their blocks say"), found.to_string());
            self.damage(flaw, HEADER);
        }
        if self.is_cut {
            self.rows.push(Err(Damage::new(DamageKind::Unfinished, end, "a file that its recorder has finished", b"")));
        }
    }

    /// Adds a damage after the frames before it.
    fn damage(&mut self, flaw: Flaw, offset: u64) {
        self.rows.push(Err(flaw.damage(Place { number: self.number, offset })));
    }

    fn data_groups(&mut self, file: &[u8]) -> Result<(), (Flaw, u64)> {
        let at = |offset| move |flaw| (flaw, offset);
        let header = Block::expect(file, HEADER, b"HD").map_err(at(HEADER))?;
        let Ok((_, (start, flags))) = start(header.data) else {
            return Err((Flaw::malformed("the start of the measurement", "a header that ends before it"), HEADER));
        };
        self.base = if flags & LOCAL != 0 { TimeBase::Local } else { TimeBase::Utc };
        self.start = start;
        for group in chain(file, header.link(0), b"DG") {
            let group = group.map_err(at(HEADER))?;
            self.found[0] += 1;
            if let Err(flaw) = self.records(file, &group) {
                self.damage(flaw.costing("the records of this data group"), group.offset);
            }
        }
        Ok(())
    }

    /// Reads the records of a data group.
    fn records(&mut self, file: &[u8], data_group: &Block<'_>) -> Result<(), Flaw> {
        let groups = groups(file, data_group)?;
        self.found[1] += groups.len();
        self.others += groups.iter().filter(|(_, group)| group.frames.is_none() && !group.is_of_values).count() as u64;
        if groups.iter().all(|(_, group)| group.frames.is_none()) {
            return Ok(());
        }
        let content = content(file, data_group.link(2));
        self.is_cut |= content.is_cut;
        let split = match data_group.data.first() {
            Some(0) => sorted(&groups, &content.bytes),
            Some(&width @ (1 | 2 | 4 | 8)) => numbered(&groups, &content.bytes, width.into()),
            other => return Err(Flaw::malformed("numbers of groups of 0, 1, 2, 4 or 8 bytes", format!("{other:?}"))),
        };
        let offset = data_group.link(2).unwrap_or(data_group.offset);
        for (_, group) in &groups {
            let of_group = split.records.iter().filter(|(other, _)| std::ptr::eq(*other, group)).count() as u64;
            if !self.is_cut && of_group != group.count && group.frames.is_some() {
                let flaw = Flaw::malformed(format!("{} records, as the group says", group.count), of_group.to_string());
                self.damage(flaw, offset);
            }
        }
        let mut left: BTreeMap<u64, u64> = groups.iter().map(|(_, group)| (group.id, self.most(group))).collect();
        for (group, record) in split.records {
            // A damaged link may lead to the records of another group.
            if let Some(left) = left.get_mut(&group.id).filter(|left| **left > 0) {
                *left -= 1;
                self.frame(group, record, &split.values, offset);
            }
        }
        if let Some(flaw) = split.flaw.filter(|_| content.flaw.is_none() && !self.is_cut) {
            self.damage(flaw, offset);
        }
        if let Some((flaw, offset)) = content.flaw {
            self.damage(flaw, offset);
        }
        Ok(())
    }

    /// Maximum number of records of a group: the number that the file states, if the recorder has finished the file.
    const fn most(&self, group: &Group<'_>) -> u64 {
        if self.is_unfinished { u64::MAX } else { group.count }
    }

    fn frame(&mut self, group: &Group<'_>, record: &[u8], values: &BTreeMap<u64, Vec<u8>>, offset: u64) {
        let Some(frames) = &group.frames else { return };
        self.number += 1;
        let place = Place { number: self.number, offset };
        let made = frames.record(record, Timestamp(self.start), values).map(|mut made| {
            made.channel = self.channels.intern(&frames.bus(record).to_string());
            made.place = place;
            made
        });
        self.rows.push(made.map_err(|flaw| flaw.damage(place)));
    }
}

/// The time of a frame; a damage belongs after all frames.
fn time(item: &Result<Record, Damage>) -> Timestamp {
    item.as_ref().map_or(Timestamp(u64::MAX), |record| record.timestamp)
}

impl Iterator for Mf4Reader {
    type Item = Result<Record, Damage>;

    fn next(&mut self) -> Option<Self::Item> {
        if let Some(source) = self.source.take() {
            self.load(source);
        }
        self.items.next()
    }
}

impl Reader for Mf4Reader {
    fn channels(&self) -> &Channels {
        &self.channels
    }

    fn time_base(&self) -> TimeBase {
        self.base
    }
}
