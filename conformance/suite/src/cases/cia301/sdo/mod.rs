//! The SDO server.

mod access;
mod block_download;
mod block_upload;
mod command;
mod described;
mod expedited;
mod frames;
mod refusals;
mod segmented_download;
mod segmented_upload;
mod sequence;
mod server_parameter;

use crate::bench::sdo::Attempt;
use crate::verdict::{Judged, Reason, demand};
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo::Response;
use canvass_bus::client::sdo::Bytes;

/// Demands that every response of a transfer has eight bytes, and zeros in those that carry nothing.
fn expect_form(attempt: &Attempt) -> Judged {
    for frame in &attempt.responses {
        demand(frame.len() == 8, || {
            let duty = format!("each response to the {} has eight bytes", attempt.what);
            Reason::new(duty, "8 bytes", format!("{} ({} bytes)", Bytes(frame.data()), frame.len()))
        })?;
        // What was understood, written out again, differs exactly in the bytes that mean nothing.
        let clean = Response::read(frame.data()).map(|response| response.to_frame(frame.cob_id().unwrap_or_default()));
        demand(clean.is_ok_and(|clean| clean == *frame), || {
            let expected = clean.map_or_else(|error| error.to_string(), |clean| Bytes(clean.data()).to_string());
            let duty = format!("reserved bits and unused bytes of the responses to the {} are 0", attempt.what);
            Reason::new(duty, expected, Bytes(frame.data()).to_string())
        })?;
    }
    Ok(())
}
