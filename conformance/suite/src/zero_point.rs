//! The zero point of a position, which a preset moves. The tester compares it before and after a run, at rest, exactly
//! to the step.
//!
//! Writing back the earlier value of a preset would move the zero point again. So it is never "restored": a case that
//! was allowed to move it puts it back at rest by `Bench::put_back_zero_point`; in all other cases the tester reports
//! the distance.

use canvass_analyzer::Multiplexer;
use std::fmt;
use std::str::FromStr;

/// Maximum difference of a position at rest, in steps: the last bit of the sensor.
const TREMBLE: i64 = 2;

/// The objects by which a device profile shows and moves a zero point.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Objects {
    /// The object that moves the zero point when it is written. If `takes_position`, its value is the new position;
    /// otherwise 1 makes the current position 0, and 0 reverses that.
    pub preset: Multiplexer,
    /// Whether `preset` takes the new position.
    pub takes_position: bool,
    /// The position.
    pub position: Multiplexer,
    /// The distance by which presets have moved the zero point, if the device shows it.
    pub offset: Option<Multiplexer>,
    /// The position without preset and scaling, if the device shows it.
    pub raw: Option<Multiplexer>,
    /// Number of positions that the device shows.
    pub range: u64,
}

/// The position of a zero point, as far as the device shows it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct ZeroPoint {
    preset: Multiplexer,
    takes_position: bool,
    position: Multiplexer,
    range: u64,
    /// The position, and the maximum difference between its readings.
    shown: i64,
    spread: i64,
    offset: Option<i64>,
    raw: Option<i64>,
}

/// A zero point that is not where it was.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Moved {
    /// The distance in steps of the position.
    pub steps: i64,
    /// The object that moves the zero point.
    pub preset: Multiplexer,
    /// Whether `preset` takes the new position; otherwise 1 makes the current position 0.
    pub takes_position: bool,
    /// The object that shows the position.
    pub position: Multiplexer,
    /// Number of positions.
    pub range: u64,
    /// Whether the shaft may have been turned instead: the device shows no offset, or the same offset as before.
    pub is_uncertain: bool,
    /// Whether the device shows the same offset as before: then most likely the shaft was turned.
    pub is_denied: bool,
    /// Whether the zero point is moved in the device's memory, so that the next start loads it.
    pub is_stored: bool,
}

impl ZeroPoint {
    /// The zero point from readings of the position: the first reading, and the maximum distance of later readings in
    /// both directions.
    pub(crate) fn new(objects: Objects, first: i64, around: [i64; 2], offset: Option<i64>, raw: Option<i64>) -> Self {
        let Objects { preset, takes_position, position, range, .. } = objects;
        let spread = around[1] - around[0];
        debug_assert!(spread >= 0, "what is furthest up is not below what is furthest down");
        Self { preset, takes_position, position, range, shown: first, spread, offset, raw }
    }

    /// Whether the shaft was at rest.
    pub(crate) const fn is_at_rest(&self) -> bool {
        self.spread <= TREMBLE
    }

    /// Whether the device shows that no preset has moved the zero point, or shows no offset.
    pub(crate) fn is_as_delivered(&self) -> bool {
        self.offset.is_none_or(|offset| offset == 0)
    }

    /// Whether a preset can put the zero point back from every position.
    pub(crate) const fn takes_position(&self) -> bool {
        self.takes_position
    }

    /// The object that moves the zero point.
    pub(crate) const fn preset(&self) -> Multiplexer {
        self.preset
    }

    /// The distance by which the zero point has moved until `now`; `None` if it has not, or if the shaft turns and no
    /// offset shows it.
    pub fn moved(&self, now: &Self) -> Option<Moved> {
        let Self { preset, takes_position, position, range, .. } = *self;
        let by_offset = self.offset.zip(now.offset).map(|(before, after)| shorter_way(before, after, range));
        let by_position = shorter_way(self.shown, now.shown, range);
        let both_at_rest = self.is_at_rest() && now.is_at_rest();
        let has_turned = self.raw.zip(now.raw).is_some_and(|(before, after)| (before - after).abs() > TREMBLE);
        let excused = match by_offset {
            Some(_) => TREMBLE.max(self.spread).max(now.spread),
            None => self.spread + now.spread,
        };
        let is_denied = by_offset == Some(0);
        let (steps, is_uncertain) = match by_offset {
            Some(steps) if steps != 0 && takes_position => (steps, false),
            // If the zero is set at the current position, the offset shows that it was set, but not the distance.
            Some(changed) if changed != 0 => (by_position, false),
            _ if both_at_rest && !has_turned && by_position.abs() > excused => (by_position, true),
            _ => return None,
        };
        Some(Moved { steps, preset, takes_position, position, range, is_uncertain, is_denied, is_stored: false })
    }

    /// The preset that moves the zero point from `now` back to here, at rest.
    pub(crate) fn preset_back(&self, now: &Self, moved: &Moved) -> u32 {
        let range = i64::try_from(self.range).unwrap_or(i64::MAX).max(1);
        u32::try_from((now.shown - moved.steps).rem_euclid(range)).unwrap_or(u32::MAX)
    }
}

/// The zero point as in a journal: `6003:00 6004:00 33554432 19642 0 307 -`; with `=` before the first object if that
/// takes no position.
impl fmt::Display for ZeroPoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let object = |at: Multiplexer| format!("{:04X}:{:02X}", at.index.0, at.sub.0);
        let known = |number: Option<i64>| number.map_or_else(|| "-".to_owned(), |number| number.to_string());
        let Self { preset, position, range, shown, spread, offset, raw, .. } = *self;
        let kind = if self.takes_position { "" } else { "=" };
        write!(f, "{kind}{} {} {range} {shown} {spread} ", object(preset), object(position))?;
        write!(f, "{} {}", known(offset), known(raw))
    }
}

impl FromStr for ZeroPoint {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        const EXPECTED: &str = "the objects and numbers of a zero point, such as 6003:00 6004:00 8192 100 0 7 -";
        let object = |text: &str| {
            let (index, sub) = text.split_once(':')?;
            Some(Multiplexer::new(u16::from_str_radix(index, 16).ok()?, u8::from_str_radix(sub, 16).ok()?))
        };
        let known = |text: &str| if text == "-" { Some(None) } else { text.parse().ok().map(Some) };
        let read = |words: &[&str]| {
            let &[preset, position, range, shown, spread, offset, raw] = words else { return None };
            let takes_position = !preset.starts_with('=');
            Some(Self {
                preset: object(preset.trim_start_matches('='))?,
                takes_position,
                position: object(position)?,
                range: range.parse().ok().filter(|range| (1..=1 << 32).contains(range))?,
                shown: shown.parse().ok()?,
                spread: spread.parse().ok()?,
                offset: known(offset)?,
                raw: known(raw)?,
            })
        };
        read(&text.split(' ').collect::<Vec<_>>()).ok_or(EXPECTED)
    }
}

impl fmt::Display for Moved {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { steps, preset, position, .. } = self;
        let plural = if steps.abs() == 1 { "" } else { "s" };
        let stored = if self.is_stored { "stored " } else { "" };
        match self.is_uncertain {
            false => write!(f, "the {stored}zero point was moved by {steps:+} step{plural}")?,
            true => write!(
                f,
                "the position at rest is {steps:+} step{plural} from that before the run: the {stored}zero point was moved, or \
                 the shaft was turned"
            )?,
        }
        f.write_str(". To set it right by hand, at rest: ")?;
        if self.takes_position {
            let more = if *steps < 0 { "plus" } else { "minus" };
            let (amount, range) = (steps.abs(), self.range);
            write!(f, "read {position}, and give {preset} that value {more} {amount}, modulo {range}")?;
        } else {
            write!(f, "bring it to where {position} was 0, and write 1 to {preset}")?;
        }
        if self.is_stored { f.write_str("; then store it") } else { Ok(()) }
    }
}

/// The shorter way from one position to another.
pub(crate) fn shorter_way(from: i64, to: i64, range: u64) -> i64 {
    let range = i64::try_from(range).unwrap_or(i64::MAX).max(1);
    let way = (to - from).rem_euclid(range);
    if way > range / 2 { way - range } else { way }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn at(shown: i64, spread: i64, offset: Option<i64>, raw: Option<i64>) -> ZeroPoint {
        let (preset, position) = (Multiplexer::new(0x6003, 0), Multiplexer::new(0x6004, 0));
        ZeroPoint { preset, takes_position: true, position, range: 10_000, shown, spread, offset, raw }
    }

    fn steps(before: ZeroPoint, now: ZeroPoint) -> Option<(i64, bool)> {
        before.moved(&now).map(|moved| (moved.steps, moved.is_uncertain))
    }

    /// The offset 6509h counts first, also across the end of the range; otherwise the position at rest.
    #[test]
    fn a_zero_point_that_moved_is_told_to_the_step() {
        let before = at(100, 0, Some(0), None);
        assert_eq!(steps(before, before), None);
        assert_eq!(steps(before, at(407, 0, Some(307), None)), Some((307, false)));
        assert_eq!(steps(before, at(101, 0, Some(1), None)), Some((1, false)));
        assert_eq!(steps(at(5, 0, Some(-20), None), at(9_985, 0, Some(9_960), None)), Some((-20, false)));
        assert_eq!(steps(before, at(100, 0, Some(10_000), None)), None, "once round is nowhere");
        assert_eq!(steps(before, at(407, 0, Some(0), None)), Some((307, true)), "6509h may be wrong");
        assert_eq!(steps(at(100, 0, None, None), at(101, 0, None, None)), Some((1, true)));
    }

    /// A shaft that trembles or turns does not move the zero point.
    #[test]
    fn a_shaft_that_moves_is_no_zero_point_that_moved() {
        let before = at(100, 0, Some(7), Some(50));
        assert_eq!(steps(before, at(102, 2, Some(7), Some(52))), None, "it trembles");
        assert_eq!(steps(before, at(400, 0, Some(7), Some(350))), None, "it was turned meanwhile");
        assert_eq!(steps(before, at(400, 90, Some(7), None)), None, "it turns");
        assert_eq!(steps(at(100, 1, None, None), at(101, 0, None, None)), None, "nothing tells a step from trembling");
        assert_eq!(steps(before, at(400, 90, Some(8), None)), Some((1, false)), "it turns, and was moved");
    }

    #[test]
    fn it_is_told_how_to_set_it_right_by_hand() {
        let moved = at(100, 0, Some(0), None).moved(&at(407, 0, Some(307), None)).unwrap();
        let told = "the zero point was moved by +307 steps. To set it right by hand, at rest: read 6004h:00, and give 6003h:00 \
                    that value minus 307, modulo 10000";
        assert_eq!(moved.to_string(), told);
        let stored = Moved { steps: -1, is_stored: true, is_uncertain: true, ..moved };
        let told = "the position at rest is -1 step from that before the run: the stored zero point was moved, or the shaft was \
                    turned. To set it right by hand, at rest: read 6004h:00, and give 6003h:00 that value plus 1, modulo 10000; \
                    then store it";
        assert_eq!(stored.to_string(), told);
    }

    /// An angle whose zero is set at the current position can only be set again at that position.
    #[test]
    fn a_zero_that_is_set_on_the_spot_is_set_again_there() {
        let angle = |shown| ZeroPoint { takes_position: false, ..at(shown, 0, Some(1), None) };
        let gone = ZeroPoint { offset: Some(0), ..angle(9_000) };
        assert_eq!(steps(angle(0), gone), Some((-1_000, false)));
        let told = angle(0).moved(&gone).unwrap().to_string();
        assert!(told.ends_with("at rest: bring it to where 6004h:00 was 0, and write 1 to 6003h:00"), "{told}");
        assert_eq!(angle(7).to_string().parse(), Ok(angle(7)));
    }

    proptest! {
        #[test]
        fn a_journal_gives_back_what_it_was_told(
            shown in 0_i64..10_000,
            spread in 0_i64..5,
            offset in proptest::option::of(-5_000_i64..5_000),
            raw in proptest::option::of(0_i64..1 << 32),
        ) {
            let zero_point = at(shown, spread, offset, raw);
            prop_assert_eq!(zero_point.to_string().parse(), Ok(zero_point));
        }

        #[test]
        fn any_other_text_is_none(text in "[0-9A-F: -]{0,60}") {
            // Reading must not panic, and a text that is read is written identically.
            if let Ok(read) = text.parse::<ZeroPoint>() {
                prop_assert_eq!(read.to_string().parse(), Ok(read));
            }
        }

        /// Wherever the shaft rests and wherever its zero point was moved to, the preset brings back its earlier
        /// position.
        #[test]
        fn the_preset_back_brings_the_position_back(shaft in 0_i64..10_000, old in 0_i64..10_000, new in 0_i64..10_000) {
            let shown = |offset: i64| at((shaft + offset).rem_euclid(10_000), 0, Some(offset), None);
            let (before, now) = (shown(old), shown(new));
            match before.moved(&now) {
                Some(moved) => prop_assert_eq!(i64::from(before.preset_back(&now, &moved)), before.shown),
                None => prop_assert_eq!(before.shown, now.shown),
            }
        }
    }
}
