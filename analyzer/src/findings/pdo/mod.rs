//! Rules about PDOs, SYNC and TIME.

mod cycle_too_short;
mod ended;
mod inhibit_time;
mod jitter;
mod length;
mod length_changed;
mod of_unknown_node;
mod out_of_rhythm;
mod period;
mod received_ended;
mod request_unanswered;
mod sync_additional;
mod sync_counter;
mod sync_jitter;
mod sync_missing;
mod sync_pdo_missing;
mod sync_window;
mod time_jump;
mod unrequested;

use super::Context;
use crate::network::sdo::{Direction, Outcome};
use crate::object;

/// Whether an SDO client has written COB-ID SYNC (1005h) or the communication cycle period (1006h), so that SYNC
/// changes its period, begins or ends.
fn changes_sync(context: &Context<'_>) -> bool {
    let ended = context.decoded.ends_transfer();
    let transfer = context.decoded.channel.filter(|_| ended).and_then(|channel| context.scene.bus.transfer(channel));
    transfer.is_some_and(|transfer| {
        let written = transfer.direction == Direction::Download && transfer.outcome == Outcome::Complete;
        written && matches!(transfer.multiplexer.index.0, object::COB_ID_SYNC | object::COMMUNICATION_CYCLE_PERIOD)
    })
}
