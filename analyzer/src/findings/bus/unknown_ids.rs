use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen};
use crate::message::Message;
use canvass_macros::rule;

/// frames have CAN-IDs of unknown use
///
/// The capture contains 11-bit frames on CAN-IDs that neither the predefined connection set, nor a description, nor the
/// SDO traffic of the capture assigns.
///
/// # Why
/// The frames may be PDOs whose CAN-IDs were set before the capture began, or another protocol on the same wires. They
/// add to the bus load, and their content can't be decoded.
///
/// # What to do
/// Name the models or descriptions of the nodes, so that their COB-IDs are known, or record from the start of the
/// machine.
#[rule(id = "bus/unknown-ids", severity = Info, rank = Detail, services = [Unknown])]
struct UnknownIds {
    /// a lower number of frames is not reported
    #[threshold(count = 1)]
    frames: u64,
    /// A bit for each CAN-ID with frames.
    ids: CanIds,
    seen: u64,
    first: Option<Seen>,
}

/// A bit for each CAN-ID of 11 bits.
struct CanIds([u16; 128]);

impl Default for CanIds {
    fn default() -> Self {
        Self([0; 128])
    }
}

impl Rule for UnknownIds {
    fn frame(&mut self, context: &Context<'_>, _: &mut Sink<'_>) {
        let Some(id) = context.record.frame.id().as_standard() else { return };
        if *context.message() != Message::Unknown || context.record.frame.cob_id().is_none() {
            return;
        }
        self.ids.0[usize::from(id >> 4)] |= 1 << (id & 0xF);
        self.seen += 1;
        if self.first.is_none() {
            self.first = Some(context.seen());
        }
    }

    fn finish(&mut self, _: &Scene<'_>, sink: &mut Sink<'_>) {
        let Some(first) = self.first.as_ref().filter(|_| self.seen >= self.frames) else { return };
        const SHOWN: usize = 12;
        let ids: Vec<u16> = (0..0x800).filter(|id| self.ids.0[usize::from(id >> 4)] >> (id & 0xF) & 1 != 0).collect();
        let listed: Vec<String> = ids.iter().take(SHOWN).map(|id| format!("{id:03X}h")).collect();
        let more = if ids.len() > SHOWN { ", …" } else { "" };
        sink.report(Report::at(first.time()).evidence(first.evidence()), || {
            format!("{} frames on {} CAN-IDs: {}{more}", self.seen, ids.len(), listed.join(", "))
        });
    }
}
