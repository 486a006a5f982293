use crate::findings::order::Disorder;
use crate::findings::sink::{Report, Sink};
use canvass_macros::rule;

/// records are slightly out of order
///
/// Frames are older than the previous frame in the file, by at most 20 ms. The diagnosis evaluates them in the order of
/// their times. A larger difference counts as a step of the clock.
///
/// # Why
/// In the order of the file, answers come before their requests. Kernels with several processors and adapters with
/// several channels deliver frames in this way; the bus is not faulty.
///
/// # What to do
/// This diagnosis needs no action. Sort the capture by its times before you read it, or let one processor handle the
/// interrupts of the interface.
#[rule(id = "capture/out-of-order", severity = Info, rank = Detail, of = nothing)]
pub struct OutOfOrder;

/// Reports the number of frames out of order.
pub fn tell(disorder: &Disorder, sink: &mut Sink<'_>) {
    let Some((time, place)) = disorder.first else { return };
    let Disorder { count, largest, .. } = *disorder;
    sink.report(Report::at(time).place(time, place), || match count {
        1 => format!("1 frame is {largest} older than the one before it"),
        _ => format!("{count} frames are older than the one before them, by at most {largest}"),
    });
}
