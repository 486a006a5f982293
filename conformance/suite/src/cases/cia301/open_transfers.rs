//! Resets in the middle of SDO transfers.

use super::sdo::by_hand::{begin_download, begin_upload, long_object};
use crate::bench::Bench;
use crate::bench::sdo::DEVICE_TYPE;
use crate::case;
use crate::verdict::Judged;
use canvass_analyzer::wire::nmt::Command;

/// A reset ends every SDO transfer: after reset node and after reset communication in the middle of a segmented upload
/// or download, the server serves a new request as after power-on.
#[case(id = "301/boot-up/open-transfers", clause = "CiA 301 7.3.2.2.1", confidence = Cited, level = Must,
       needs = [ScratchObject, SegmentedDownload], catches = [SdoOpenDownloadSurvivesReset])]
fn open_transfers(bench: &mut Bench<'_>) -> Judged {
    let scratch = bench.scratch(&[4, 2, 1])?;
    let has_upload = bench.long_object(8)?.is_some();
    let directions: &[&str] = if has_upload { &["download", "upload"] } else { &["download"] };
    for command in [Command::RESET_NODE, Command::RESET_COMMUNICATION] {
        bench.each(directions, |bench, direction| {
            match *direction {
                "upload" => {
                    let multiplexer = long_object(bench)?;
                    begin_upload(bench, multiplexer)?;
                }
                _ => begin_download(bench, &scratch)?,
            }
            bench.reset(command)?;
            let circumstance = format!("after {command} in the middle of a segmented {direction}");
            let served = bench.upload(DEVICE_TYPE)?.under(&circumstance).value().map(|_| ());
            // The next transfer must not begin with the remains of this transfer.
            bench.make_server_idle();
            bench.check(served)
        })?;
    }
    Ok(())
}
