//! Block transfers, which are optional (CiA 301, 7.2.4.3.9 and 7.2.4.3.13).

use crate::bench::Bench;
use crate::bench::Met;
use crate::bench::sdo::{DEVICE_TYPE, Reply};
use crate::need::Need;
use crate::verdict::{Breach, Stop};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::sdo::{AbortCode, Request, Response};

/// The SDO server supports block uploads.
pub static BLOCK_UPLOAD: Need = Need::new("block-upload", "SDO block uploads", |bench| {
    // Without a long object a short one serves: its CRC can be judged, too.
    let multiplexer = bench.long_object(8)?.unwrap_or(DEVICE_TYPE);
    let request = Request::InitiateBlockUpload { multiplexer, crc: true, block_size: 1, threshold: 0 };
    let reply = begun(bench, multiplexer, &request, "block upload of")?;
    match reply.response {
        Some(Response::InitiateBlockUpload { .. }) => Ok(Ok(())),
        _ => unsupported(&reply),
    }
});

/// The SDO server supports block downloads.
pub(crate) static BLOCK_DOWNLOAD: Need =
    Need::new("block-download", "SDO block downloads", |bench| Ok(block_download(bench)?.map(|_| ())));

/// The SDO server checks the CRC of block downloads.
pub(crate) static BLOCK_CRC: Need = Need::new("block-crc", "a CRC in SDO block downloads", |bench| {
    let crc = block_download(bench)?;
    Ok(crc.and_then(|crc| if crc { Ok(()) } else { Err("the SDO server checks no CRC of block downloads".to_owned()) }))
});

/// Whether the server accepts a block download, and if so whether it supports CRC.
fn block_download(bench: &mut Bench<'_>) -> Result<Result<bool, String>, Stop> {
    let Some(scratch) = bench.scratch_objects()?.into_iter().next() else {
        return Ok(Err("the device has no object that can be written without consequence".to_owned()));
    };
    let (multiplexer, size) = (scratch.multiplexer, u32::try_from(scratch.value.len()).ok());
    let request = Request::InitiateBlockDownload { multiplexer, crc: true, size };
    let reply = begun(bench, multiplexer, &request, "block download to")?;
    match reply.response {
        Some(Response::InitiateBlockDownload { crc, .. }) => Ok(Ok(crc)),
        _ => unsupported(&reply).map(|met| met.map(|()| false)),
    }
}

/// Begins a block transfer and aborts it before any data.
pub(super) fn begun(
    bench: &mut Bench<'_>,
    multiplexer: Multiplexer,
    request: &Request,
    what: &str,
) -> Result<Reply, Stop> {
    let reply = bench.exchange(request, format!("{what} {multiplexer}"))?;
    bench.send_request(&Request::abort(multiplexer, AbortCode::GENERAL))?;
    // A firmware that answers aborts does so now, not in the middle of the case.
    bench.listen(bench.timing().reaction)?;
    Ok(reply)
}

/// Only 0504 0001h says that the server does not support block transfers.
fn unsupported(reply: &Reply) -> Result<Met, Stop> {
    if reply.abort() == Some(AbortCode::COMMAND_SPECIFIER) {
        return Ok(Err(format!("the {} is answered by {}", reply.what, reply.actual())));
    }
    let breach = Breach::new(reply.subject, format!("the {} is answered", reply.what))
        .expected(format!(
            "its confirmation, or abort {} of a server without block transfers",
            AbortCode::COMMAND_SPECIFIER
        ))
        .found(reply.observation())
        .told(reply.actual());
    Err(Box::new(breach).into())
}
