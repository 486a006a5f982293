use crate::findings::order::Disorder;
use crate::findings::sink::{Report, Sink};
use canvass_macros::rule;

/// records are out of order by a little
///
/// Frames are older than the one before them in the file, by at most 20 ms. They are looked at in the order of their
/// times. What is older by more is a step of the clock.
///
/// # Why
/// In the order of the file, answers come before their requests. Kernels with several processors and adapters
/// with several channels hand frames over like this; nothing is wrong with the bus.
///
/// # What to do
/// Nothing for this diagnosis. Sort the capture by its times before it is read by eye, or let one processor handle the
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
