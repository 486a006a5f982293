use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen};
use crate::message::Message;
use canvass_macros::rule;

/// no frame on the bus belongs to CANopen
///
/// All frames of the capture are error frames, CAN FD or CAN XL frames, have 29-bit identifiers, or have CAN-IDs that
/// no CANopen service is known to use. The rule reports nothing if a single frame belongs to a CANopen service.
///
/// # Why
/// The diagnosis checked no message, so the absence of other findings tells nothing about the machine.
///
/// # What to do
/// If the capture holds error frames only, the bit rate is wrong, or no other device is connected to the recorder. If
/// it holds other frames, check that the recorder uses the right bus and the right channel.
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
            (self.unknown, "with CAN-IDs of unknown use"),
        ];
        let kinds = kinds.iter().filter(|kind| kind.0 > 0).map(|(count, what)| format!("{count} {what}"));
        let kinds: Vec<String> = kinds.collect();
        sink.report(Report::at(first.time()).evidence(first.evidence()), || {
            format!("no frame of any service of CANopen: {}", kinds.join(", "))
        });
    }
}
