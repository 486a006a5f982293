//! What the cases of CiA 305 need.

use crate::need::Need;

/// Layer setting services: the description says that they are supported.
pub static LSS: Need = Need::new("lss", "layer setting services (LSS)", |bench| {
    Ok(match &bench.target().description {
        Some(description) if description.device.lss_supported => Ok(()),
        Some(_) => Err("the description says that LSS is not supported".to_owned()),
        None => Err("without a description it is not known whether the device supports LSS".to_owned()),
    })
})
.rescued_by(super::configuration::restore);
