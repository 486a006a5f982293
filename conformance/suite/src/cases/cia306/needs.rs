//! The needs of the cases of CiA 306, and of all other cases that use the description.

use crate::need::Need;

/// The device's EDS or built-in model.
pub static DESCRIPTION: Need =
    Need::new("description", "a description of the device (an EDS or a built-in model)", |bench| {
        Ok(match bench.target().description {
            Some(_) => Ok(()),
            None => Err("no description of the device was given".to_owned()),
        })
    });
