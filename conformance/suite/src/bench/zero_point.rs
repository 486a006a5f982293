//! The position of the zero point, and how the tester puts it back: while the device is at rest, exactly to the step.

use super::profile;
use super::sdo::number;
use super::{Bench, Options, Target};
use crate::verdict::{Precondition, Stop};
use crate::zero_point::{Moved, Objects, ZeroPoint, shorter_way};
use canvass_analyzer::Multiplexer;
use canvass_bus::Bus;
use canvass_traces::{Duration, Record};
use std::sync::atomic::AtomicBool;

/// A position is at rest if it stays the same in [`READINGS`] readings, [`BETWEEN`] apart.
const READINGS: usize = 4;
const BETWEEN: Duration = Duration::from_millis(30);

/// Reads a number of any length, so that a zero point is known even if the description is wrong.
fn number_of(bench: &mut Bench<'_>, at: Multiplexer) -> Result<u32, Stop> {
    Ok(number(&bench.upload(at)?.value().or_inconclusive()?))
}

/// Reads the position. An angle may be signed or unsigned.
fn shown(bench: &mut Bench<'_>, objects: &Objects) -> Result<i64, Stop> {
    let number = number_of(bench, objects.position)?;
    let is_negative = !objects.takes_position && u64::from(number) >= objects.range;
    Ok(if is_negative { i64::from(number as u16 as i16) } else { i64::from(number) })
}

/// The zero point of a device; `None` if nothing moves it, or the device does not answer.
pub fn zero_point_of(bus: &mut dyn Bus, target: &Target) -> Option<ZeroPoint> {
    /// Reading takes a moment; a device that sends without end must not prolong it.
    const LONGEST: Duration = Duration::from_secs(3);
    let (options, cancel) = (Options { limit: Some(LONGEST), ..Options::default() }, AtomicBool::new(false));
    let mut annotate = |_: &Record| String::new();
    Bench::new(bus, target, &options, &mut annotate, &cancel).look_at_zero_point().ok()?
}

impl Bench<'_> {
    /// Reads the zero point; `None` if the device has none that can be moved.
    ///
    /// # Errors
    /// The errors of reading the position.
    pub(crate) fn look_at_zero_point(&mut self) -> Result<Option<ZeroPoint>, Stop> {
        let Some(objects) = profile::zero_point(self)? else { return Ok(None) };
        let first = shown(self, &objects)?;
        let mut around = [0, 0];
        for _ in 1..READINGS {
            self.listen(BETWEEN)?;
            let away = shorter_way(first, shown(self, &objects)?, objects.range);
            around = [around[0].min(away), around[1].max(away)];
        }
        let mut told = |at: Option<Multiplexer>| at.map(|at| number_of(self, at)).transpose();
        let (offset, raw) = (told(objects.offset)?, told(objects.raw)?);
        let offset = offset.map(|offset| i64::from(offset as i32));
        Ok(Some(ZeroPoint::new(objects, first, around, offset, raw.map(i64::from))))
    }

    /// Puts the zero point back by a preset at rest, and checks it. Returns the remaining distance.
    ///
    /// # Errors
    /// The errors of the bus; and [`Stop::NotApplicable`] if the user has not allowed presets.
    pub(crate) fn put_back_zero_point(&mut self, before: &ZeroPoint) -> Result<Option<Moved>, Stop> {
        /// A trembling position needs several tries: its step changes between reading and writing.
        const TRIES: usize = 6;
        let mut left = None;
        for _ in 0..TRIES {
            let Some(now) = self.look_at_zero_point()? else { return Ok(None) };
            left = before.moved(&now);
            let may_be_put_back = |moved: &Moved| now.is_at_rest() && moved.takes_position && !moved.is_denied;
            let Some(moved) = left.filter(may_be_put_back) else { break };
            let value = before.preset_back(&now, &moved);
            self.with_leave_to_move(|bench| bench.download_now(moved.preset, &value.to_le_bytes()))?;
        }
        Ok(left)
    }
}
