//! The needs of the cases of CiA DS-205.

use super::configuration::{configure_own, configure_own_rate};
use super::dialogue::{in_configuration, tell};
use crate::need::Need;
use canvass_analyzer::wire::layer_setting::SLAVE_CAN_ID;
use canvass_analyzer::wire::lmt::{Part, Request};

/// Layer management: the slave answers one of the inquiries in configuration. The slave is switched back to operation.
pub static LMT: Need = Need::new("lmt", "layer management (LMT)", |bench| {
    let described = bench.target().description.as_ref();
    if described.is_some_and(|description| description.device.lss_supported) {
        return Ok(Err("the description says that the device has LSS".to_owned()));
    }
    let begun = bench.now();
    tell(bench, Request::SwitchGlobal { mode: 1 })?;
    let mut answers = false;
    for part in Part::ALL {
        answers |= tell(bench, Request::Inquire { part })?.is_some();
    }
    tell(bench, Request::SwitchGlobal { mode: 0 })?;
    // A wrong response counts, too: the cases judge it.
    answers |= bench.heard_since(begun).iter().any(|record| record.frame.cob_id() == Some(SLAVE_CAN_ID));
    Ok(match answers {
        true => Ok(()),
        false => Err("no LMT slave answers an inquiry".to_owned()),
    })
})
.rescued_by(|bench, _| {
    in_configuration(bench, |bench| {
        configure_own(bench)?;
        configure_own_rate(bench)
    })
});
