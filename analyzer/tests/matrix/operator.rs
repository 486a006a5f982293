//! Operators: what goes wrong with the frames of one sort and node.

use super::draw::Draw;
use super::plan::{MS, Plan, Planned, SECOND};
use super::play::{Fate, SDO_TIMEOUT};
use super::sort::Sort;
use canvass_analyzer::wire::Field;
use canvass_traces::{CanId, Frame};
use std::collections::HashMap;

/// What goes wrong.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Operator {
    /// The frame is not sent.
    Drop,
    /// The frame comes late: by one and a half intervals, or by more than a client waits.
    Delay,
    /// The frame comes at a random time within seven tenths of its interval.
    Jitter,
    /// The frame is sent twice.
    Duplicate,
    /// The frame and the next one with its identifier change their places.
    Reorder,
    /// A field has another value.
    Change(Field),
    /// Another sender uses the identifier, too, with its own data and rhythm.
    OtherSender,
    /// The frame has a byte less.
    Shorter,
    /// The frame has a byte more.
    Longer,
    /// The frame has no data.
    Empty,
    /// The identifier is one higher.
    OtherId,
    /// A remote frame comes instead.
    Remote,
    /// The identifier has 29 bits.
    Extended,
    /// The frame is repeated at every millisecond.
    Repeat,
    /// The frames begin late.
    BeginLate,
}

/// How often it goes wrong.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum When {
    /// With one frame.
    Once,
    /// For six seconds, or with three frames that are not regular.
    While,
    /// To the end of the capture.
    ToTheEnd,
}

/// An incident: the fates of frames, and since when.
pub struct Incident {
    /// The fates, by the places of the frames.
    pub fates: HashMap<usize, Fate>,
    /// The node; 0 for the bus.
    pub node: u8,
    /// The time of the first frame with a fate, since the beginning of the capture.
    pub since: u64,
}

const NAMES: [(Operator, &str); 14] = [
    (Operator::Drop, "drop"),
    (Operator::Delay, "delay"),
    (Operator::Jitter, "jitter"),
    (Operator::Duplicate, "duplicate"),
    (Operator::Reorder, "reorder"),
    (Operator::OtherSender, "other-sender"),
    (Operator::Shorter, "shorter"),
    (Operator::Longer, "longer"),
    (Operator::Empty, "empty"),
    (Operator::OtherId, "other-id"),
    (Operator::Remote, "remote"),
    (Operator::Extended, "extended"),
    (Operator::Repeat, "repeat"),
    (Operator::BeginLate, "begin-late"),
];

impl When {
    /// All, with their names in ids.
    pub const ALL: [(Self, &'static str); 3] =
        [(Self::Once, "once"), (Self::While, "while"), (Self::ToTheEnd, "to-the-end")];
}

impl Operator {
    /// All operators for a sort.
    pub fn all(sort: &Sort) -> Vec<Self> {
        let simple = NAMES.into_iter().map(|(operator, _)| operator);
        if *sort == Sort::ALL_OF_A_NODE {
            return vec![Self::Drop];
        }
        simple.chain(sort.fields.iter().map(|field| Self::Change(*field))).collect()
    }

    /// The name of the row in the table: fields together.
    pub fn row(self) -> &'static str {
        NAMES.iter().find(|(operator, _)| *operator == self).map_or("change a field", |(_, name)| name)
    }

    /// The name in ids: `change-toggle-bit`.
    pub fn id(self) -> String {
        match self {
            Self::Change(field) if field.is_reserved() => format!("change-reserved-{}", field.first),
            Self::Change(field) => format!("change-{}", field.name.to_lowercase().replace(' ', "-")),
            _ => self.row().to_owned(),
        }
    }

    /// Decides whether the frame at `place` stays, is replaced, moves or is repeated. `next` is the place of the next frame
    /// with the same sender and identifier.
    fn fate(self, plan: &Plan, place: usize, next: Option<usize>, draw: &mut Draw) -> Fate {
        let planned = &plan.frames[place];
        let instead = |frame: Option<Frame>| Fate { instead: frame, ..Fate::default() };
        match self {
            Self::Drop | Self::BeginLate => Fate { lost: true, ..Fate::default() },
            Self::Delay => Fate { shift: late(planned), ..Fate::default() },
            Self::Jitter => Fate { shift: deviation(planned, draw), ..Fate::default() },
            // What comes within a millisecond may be the copy of an interface that hears itself.
            Self::Duplicate => Fate { also: vec![(1_300_000, planned.frame)], ..Fate::default() },
            Self::Reorder => Fate {
                instead: next.map(|next| plan.frames[next].frame).filter(|frame| *frame != planned.frame),
                is_swapped: true,
                ..Fate::default()
            },
            Self::Change(field) => instead(changed(&planned.frame, field, draw)),
            Self::OtherSender => Fate { also: vec![other_sender(planned, draw)], ..Fate::default() },
            Self::Shorter => {
                instead(planned.frame.len().checked_sub(1).and_then(|length| resized(&planned.frame, length)))
            }
            Self::Longer => instead(resized(&planned.frame, planned.frame.len() + 1)),
            Self::Empty => {
                instead(Some(planned.frame).filter(|frame| !frame.is_empty()).and_then(|frame| resized(&frame, 0)))
            }
            Self::OtherId => instead(with_id(&planned.frame, CanId::standard(planned.frame.id().raw() + 1))),
            Self::Remote => instead(remote(&planned.frame)),
            Self::Extended => instead(with_id(&planned.frame, CanId::extended(planned.frame.id().raw()))),
            Self::Repeat => Fate { also: (1..50).map(|n| (n * MS as i64, planned.frame)).collect(), ..Fate::default() },
        }
    }

    /// Lets this go wrong at a drawn node and moment; `None` if no frame of the sort is in the plan.
    pub fn act(self, plan: &Plan, sort: &Sort, when: When, draw: &mut Draw) -> Option<Incident> {
        let node = draw_node(plan, sort, draw)?;
        let places = places(plan, sort, node);
        let chosen = self.choose(plan, &places, sort, when, draw)?;
        let nexts = nexts(plan, &places);
        let mut fates = HashMap::new();
        for place in &chosen {
            let next = nexts.get(place).copied();
            let fate = self.fate(plan, *place, next, draw);
            if fate.is_nothing() || fates.contains_key(place) {
                continue;
            }
            if let (true, Some(next)) = (fate.is_swapped, next) {
                fates.insert(next, Fate { instead: Some(plan.frames[*place].frame), ..fate.clone() });
            }
            fates.insert(*place, fate);
        }
        if self == Self::Repeat && when != When::Once {
            self.go_on(plan, &chosen, when, &mut fates);
        }
        let since = fates.keys().map(|place| plan.frames[*place].at).min()?;
        Some(Incident { fates, node, since })
    }

    /// Repeats the first chosen frame to the end of its span.
    fn go_on(self, plan: &Plan, chosen: &[usize], when: When, fates: &mut HashMap<usize, Fate>) {
        let Some(first) = chosen.first() else { return };
        let frame = plan.frames[*first].frame;
        let times = if when == When::While { 2_000 } else { 8_000 };
        let also = (1..times).map(|n| (n * MS as i64, frame)).collect();
        fates.clear();
        fates.insert(*first, Fate { also, ..Fate::default() });
    }

    /// The frames with which it goes wrong.
    fn choose(self, plan: &Plan, places: &[usize], sort: &Sort, when: When, draw: &mut Draw) -> Option<Vec<usize>> {
        let at = |place: &usize| plan.frames[*place].at;
        if self == Self::BeginLate {
            let late = 12 * SECOND + draw.below(4 * SECOND);
            return Some(places.iter().copied().filter(|place| at(place) < late).collect());
        }
        // After the network has been in operation for a while, if the sort comes then.
        let settled = 12 * SECOND + draw.below(10 * SECOND);
        let last = places.iter().map(at).max()?;
        let begin = if last > settled { settled } else { 0 };
        let later: Vec<usize> = places.iter().copied().filter(|place| at(place) >= begin).collect();
        let first = match begin {
            0 => draw.below(later.len() as u64) as usize,
            _ => 0,
        };
        let later = &later[first..];
        let from = at(later.first()?);
        let is_regular = *sort == Sort::ALL_OF_A_NODE || plan.frames[*later.first()?].period != 0;
        let chosen = match when {
            When::Once if *sort == Sort::ALL_OF_A_NODE => {
                later.iter().filter(|place| at(place) < from + 300 * MS).copied().collect()
            }
            When::Once => later[..1].to_vec(),
            When::While if is_regular => later.iter().filter(|place| at(place) < from + 6 * SECOND).copied().collect(),
            When::While => later.iter().take(3).copied().collect(),
            When::ToTheEnd => later.to_vec(),
        };
        Some(chosen)
    }
}

fn belongs(planned: &Planned, sort: &Sort) -> bool {
    match *sort == Sort::ALL_OF_A_NODE {
        true => planned.sender.is_some(),
        false => planned.sort == *sort,
    }
}

fn draw_node(plan: &Plan, sort: &Sort, draw: &mut Draw) -> Option<u8> {
    let of = |planned: &Planned| if *sort == Sort::ALL_OF_A_NODE { planned.sender.unwrap_or(0) } else { planned.node };
    let mut nodes: Vec<u8> = plan.frames.iter().filter(|planned| belongs(planned, sort)).map(of).collect();
    nodes.sort_unstable();
    nodes.dedup();
    if nodes.is_empty() { None } else { Some(draw.of(&nodes)) }
}

/// The frames of a sort and node, in the order of their times.
fn places(plan: &Plan, sort: &Sort, node: u8) -> Vec<usize> {
    let is_of = |planned: &Planned| match *sort == Sort::ALL_OF_A_NODE {
        true => planned.sender == Some(node),
        false => planned.node == node,
    };
    let mut places: Vec<usize> = (0..plan.frames.len())
        .filter(|place| belongs(&plan.frames[*place], sort) && is_of(&plan.frames[*place]))
        .collect();
    places.sort_by_key(|place| plan.frames[*place].at);
    places
}

/// For each place the next frame of the same sender with the same identifier.
fn nexts(plan: &Plan, places: &[usize]) -> HashMap<usize, usize> {
    let Some(first) = places.first().map(|place| &plan.frames[*place]) else { return HashMap::new() };
    let is_of_same = |place: &usize| {
        let planned = &plan.frames[*place];
        planned.sender == first.sender && planned.frame.id() == first.frame.id()
    };
    let mut same: Vec<usize> = (0..plan.frames.len()).filter(is_of_same).collect();
    same.sort_by_key(|place| plan.frames[*place].at);
    same.windows(2).map(|pair| (pair[0], pair[1])).collect()
}

/// How late a delayed frame is.
fn late(planned: &Planned) -> i64 {
    let of_period = planned.period * 3 / 2;
    let least = if planned.sort.group.starts_with("sdo") { 3 * SDO_TIMEOUT } else { 300 * MS };
    of_period.max(least) as i64
}

fn deviation(planned: &Planned, draw: &mut Draw) -> i64 {
    let period = if planned.period == 0 { 200 * MS } else { planned.period };
    let deviation = draw.below(period * 14 / 10) as i64 - (period * 7 / 10) as i64;
    // Nothing comes before its cause.
    if planned.cause.is_some() { deviation.abs() } else { deviation }
}

/// A frame of another sender, and when it comes.
fn other_sender(planned: &Planned, draw: &mut Draw) -> (i64, Frame) {
    let frame = &planned.frame;
    let wait = if planned.period == 0 { 2 * MS } else { planned.period * draw.between(3, 7) / 10 };
    let mut data = frame.data().to_vec();
    match planned.sort.group {
        // The other one has another state, or another master stops the nodes.
        "error-control" => data.iter_mut().for_each(|byte| *byte = if *byte == 0x7F { 0x05 } else { 0x7F }),
        "nmt" => data[0] = if data[0] == 0x80 { 0x02 } else { 0x80 },
        // The other one speaks of another object, or has another value.
        _ => data.iter_mut().skip(1).for_each(|byte| *byte ^= 0x15),
    }
    (wait as i64, Frame::new(frame.id(), &data).filter(|_| !frame.is_remote()).unwrap_or(*frame))
}

/// The frame with another value of a field; `None` if it has no such field.
fn changed(frame: &Frame, field: Field, draw: &mut Draw) -> Option<Frame> {
    let mut data = frame.data().to_vec();
    let field = field.within(data.len())?;
    let all = if field.bits == 64 { u64::MAX } else { (1 << field.bits) - 1 };
    let old = field.get(&data)?;
    let others = [0, all, old ^ 1 << (field.bits - 1), old.wrapping_add(1) & all, old.wrapping_sub(1) & all];
    let others: Vec<u64> = others.into_iter().filter(|value| *value != old).collect();
    field.set(&mut data, draw.of(&others));
    Frame::new(frame.id(), &data)
}

fn resized(frame: &Frame, length: usize) -> Option<Frame> {
    if frame.is_remote() || frame.is_error() {
        return None;
    }
    let mut data = frame.data().to_vec();
    data.resize(length, 0);
    Frame::new(frame.id(), &data)
}

fn with_id(frame: &Frame, id: Option<CanId>) -> Option<Frame> {
    let id = id.filter(|_| !frame.is_error())?;
    if frame.is_remote() { Frame::remote(id, frame.len() as u8) } else { Frame::new(id, frame.data()) }
}

fn remote(frame: &Frame) -> Option<Frame> {
    if frame.is_error() || frame.is_remote() { None } else { Frame::remote(frame.id(), frame.len() as u8) }
}
