//! Objects that act when they are written: their values are never put back, and a zero point is moved only if the user
//! allows it.

use super::Bench;
use crate::touch::Touch;
use crate::verdict::{Lack, Reason, Stop};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object::Acting;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo::{self, Request};
use canvass_traces::Frame;

impl Bench<'_> {
    /// The effect of writing an object; `None` if it is a setting or read-only.
    pub(crate) fn acting(&self, at: Multiplexer) -> Option<Acting> {
        self.target.manual.acting(at, self.target.description.as_ref())
    }

    /// Whether writing an object has an effect that no other write reverses.
    pub(crate) fn acts(&self, at: Multiplexer) -> bool {
        self.acting(at).is_some()
    }

    fn moves_zero_point(&self, at: Multiplexer) -> bool {
        self.acting(at) == Some(Acting::MovesZeroPoint)
    }

    /// Whether writing an object stores its value at once, as the manual of the device says.
    pub(super) fn stores_at_once(&self, at: Multiplexer) -> bool {
        self.manual().is_some_and(|model| model.sheet().storage.persist_at_once.contains(&at))
    }

    /// Whether the user's permissions cover writing an object: a write that moves a zero point needs the permission for
    /// presets, a write that is stored at once needs the permission for non-volatile memory.
    pub(crate) fn may_write(&self, at: Multiplexer) -> bool {
        let allows = |touch: Touch| self.options.allow.contains(&touch);
        (!self.moves_zero_point(at) || allows(Touch::Preset)) && (!self.stores_at_once(at) || allows(Touch::Nvm))
    }

    /// Refuses to send a frame that would move a zero point or write the memory at once, unless the user allows it.
    /// While the tester puts a device back it never moves a zero point, except in [`Bench::put_back_zero_point`].
    ///
    /// This is the last check: a case asks for the user's permission by its `touches`, before it begins.
    pub(super) fn check_leave(&mut self, frame: &Frame) -> Result<(), Stop> {
        let Some(at) = self.written_by(frame) else { return Ok(()) };
        if self.moves_zero_point(at) {
            let is_time_to = !self.traffic.restoring || self.changes.moving_zero_point;
            self.allowed(Touch::Preset, is_time_to, at)?;
        }
        if self.stores_at_once(at) {
            // The bench puts back a value only if a case has written the object with the user's permission.
            self.allowed(Touch::Nvm, true, at)
                .or_else(|stop| if self.traffic.restoring { Ok(()) } else { Err(stop) })?;
            self.changes.note_memory_written()?;
        }
        Ok(())
    }

    /// The object that an own frame starts to write.
    fn written_by(&self, frame: &Frame) -> Option<Multiplexer> {
        if frame.cob_id() != Some(sdo::REQUEST_BASE + u16::from(self.node().raw())) {
            return None;
        }
        match Request::read(frame.data()).ok()? {
            Request::InitiateDownload { multiplexer, .. } | Request::InitiateBlockDownload { multiplexer, .. } => {
                Some(multiplexer)
            }
            _ => None,
        }
    }

    fn allowed(&self, touch: Touch, is_time_to: bool, at: Multiplexer) -> Result<(), Stop> {
        if is_time_to && self.options.allow.contains(&touch) {
            return Ok(());
        }
        let duty = format!("the user allows the action of the case: writing {at} {}", touch.text());
        let reason = Reason::new(duty, touch.name(), format!("not allowed: it {}", touch.text()));
        Err(Stop::NotApplicable(reason.for_lack_of(Lack::Permission)))
    }
}

#[cfg(test)]
mod tests {
    use crate::bench::Options;
    use crate::scripted::{table, with_options};
    use crate::touch::Touch;
    use crate::verdict::Stop;
    use canvass_analyzer::Multiplexer;

    const PRESET: Multiplexer = Multiplexer::new(0x6003, 0);

    /// Every way to write a preset: expedited, in segments, in blocks, as a bare request.
    const REQUESTS: [&str; 3] = ["2303600001000000", "2103600008000000", "C203600008000000"];

    #[test]
    fn a_preset_is_sent_with_leave_only_and_never_to_put_something_back() {
        let sent = |allow: &[Touch], restoring: bool| {
            let options = Options { allow: allow.iter().copied().collect(), ..Options::default() };
            with_options(table(&[]), &options, |bench| {
                bench.traffic.restoring = restoring;
                let download = bench.download_as(PRESET, &[1, 0, 0, 0], canvass_bus::client::sdo::Mode::Shortest);
                let refused = |result: &Result<_, Stop>| matches!(result, Err(Stop::NotApplicable(_)));
                let raw = REQUESTS.map(|request| {
                    let bytes = u64::from_str_radix(request, 16).unwrap().to_be_bytes();
                    bench.send_bytes(0x63F, &bytes).is_ok()
                });
                assert!(raw.iter().all(|sent| *sent != refused(&download.as_ref().map(|_| ()).map_err(Clone::clone))));
                raw[0]
            })
        };
        assert!(!sent(&[], false) && !sent(&[Touch::Nvm, Touch::FactoryDefaults], false));
        assert!(sent(&[Touch::Preset], false));
        assert!(!sent(&[Touch::Preset], true));
    }

    /// A read of the object needs no permission, nor does a write to another node's object.
    #[test]
    fn what_only_looks_like_a_preset_is_sent() {
        with_options(table(&[]), &Options::default(), |bench| {
            assert!(bench.send_bytes(0x63F, &[0x40, 3, 0x60, 0, 0, 0, 0, 0]).is_ok());
            assert!(bench.send_bytes(0x63E, &[0x23, 3, 0x60, 0, 0, 0, 0, 0]).is_ok());
            assert!(bench.send_bytes(0x63F, &[0x23, 4, 0x60, 0, 0, 0, 0, 0]).is_ok());
        });
    }
}
