//! The needs of the cases of CiA 305.

use super::dialogue::{configure, tell, wait};
use super::fastscan::{RESET, scan_begin};
use super::unconfigured::unconfigured;
use crate::bench::Found;
use crate::need::Need;
use canvass_analyzer::wire::lss::{Request, Response};

/// Layer setting services, if the description says that they are supported.
pub static LSS: Need = Need::new("lss", "layer setting services (LSS)", |bench| {
    Ok(match &bench.target().description {
        Some(description) if description.device.lss_supported => Ok(()),
        Some(_) => Err("the description says that LSS is not supported".to_owned()),
        None => Err("without a description it is not known whether the device supports LSS".to_owned()),
    })
})
.rescued_by(super::node_id::restore);

/// The inquiry of the node-ID, which not every LSS slave supports.
pub(crate) static LSS_INQUIRY: Need = Need::new("lss-inquiry", "the inquiry of the node-ID (LSS 5Eh)", |bench| {
    // Bringing the slave into configuration finds out whether it supports the inquiry.
    configure(bench)?;
    wait(bench)?;
    Ok(match bench.knowledge.known(LSS_INQUIRY.id) {
        Some(Found::Known(met)) => met.clone(),
        _ => Ok(()),
    })
});

/// Fastscan, which is optional. A slave that supports it shows this only without node-ID: it then answers the message
/// with which a scan begins.
pub(crate) static FASTSCAN: Need = Need::new("fastscan", "Fastscan (LSS 51h)", |bench| {
    let (mut searched, mut answered) = (None, None);
    unconfigured(bench, |bench, _| {
        searched = tell(bench, Request::IdentifyNonConfigured)?;
        answered = scan_begin(bench)?;
        Ok(())
    })?;
    Ok(match (answered, searched) {
        (Some(_), _) => Ok(()),
        (None, Some(Response::NonConfigured)) => Err(format!(
            "without node-ID the device answers the search for such slaves (4Ch), and not the begin of a Fastscan (51h, bit check {RESET:02X}h)"
        )),
        (None, _) => Err(format!(
            "without node-ID the device answers neither the begin of a Fastscan (51h, bit check {RESET:02X}h) nor the search for such slaves (4Ch)"
        )),
    })
});
