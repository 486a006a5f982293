use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen};
use crate::message::Message;
use canvass_macros::rule;

/// nothing on the bus is CANopen
///
/// Not one frame belongs to a service of CANopen: all are error frames, CAN FD or CAN XL frames, have 29-bit
/// identifiers, or CAN-IDs of no known use. One frame of CANopen is enough for this rule to be silent.
///
/// # Why
/// Nothing was diagnosed: that there are no other findings says nothing about the machine.
///
/// # What to do
/// Error frames alone come from a wrong bit rate, or of a recorder that nobody else is connected to. If there are other
/// frames, check that this is the right bus, and the right channel of the recorder.
#[rule(id = "bus/no-canopen", severity = Warning, rank = Detail, services = [Unknown, ErrorFrame])]
struct NoCanopen {
    error_frames: u64,
    /// Number of CAN FD frames, CAN XL frames and frames with 29-bit identifiers.
    foreign: u64,
    unknown: u64,
    first: Option<Seen>,
}

impl Rule for NoCanopen {
    fn frame(&mut self, context: &Context<'_>, _: &mut Sink<'_>) {
        match context.message() {
            Message::ErrorFrame(_) => self.error_frames += 1,
            Message::Foreign => self.foreign += 1,
            Message::Unknown | Message::UnexpectedRemote => self.unknown += 1,
            _ => return,
        }
        if self.first.is_none() {
            self.first = Some(context.seen());
        }
    }

    fn finish(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        let Some(first) = &self.first else { return };
        if self.error_frames + self.foreign + self.unknown < scene.quality.frames.total() {
            return;
        }
        let kinds = [
            (self.error_frames, "error frames"),
            (self.foreign, "CAN FD, CAN XL or with 29-bit identifiers"),
            (self.unknown, "with CAN-IDs of no known use"),
        ];
        let kinds = kinds.iter().filter(|kind| kind.0 > 0).map(|(count, what)| format!("{count} {what}"));
        let kinds: Vec<String> = kinds.collect();
        sink.report(Report::at(first.time()).evidence(first.evidence()), || {
            format!("no frame of any service of CANopen: {}", kinds.join(", "))
        });
    }
}
