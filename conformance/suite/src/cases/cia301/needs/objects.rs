//! Objects of the dictionary, and objects that serve a case.

use super::block::begun;
use crate::bench::Bench;
use crate::bench::sdo::{DEVICE_TYPE, number};
use crate::need::Need;
use crate::verdict::Stop;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::sdo::{AbortCode, Payload, Request};
use canvass_bus::client::Outcome;

/// An object that can be written and read back without side effects.
pub(crate) static SCRATCH_OBJECT: Need =
    Need::new("scratch-object", "an object that can be written and read back without consequence", |bench| {
        Ok(match bench.scratch_objects()?.is_empty() {
            true => Err("the device has no object that can be written without consequence".to_owned()),
            false => Ok(()),
        })
    });

/// A readable value of more than four bytes, which is uploaded in segments.
pub(crate) static SEGMENTED_UPLOAD: Need =
    Need::new("segmented-upload", "a readable value of more than four bytes", |bench| {
        let found = bench.long_object(8)?.map(|_| ());
        Ok(found.ok_or_else(|| "no object that was found gives more than 7 bytes".to_owned()))
    });

/// The SDO server supports segmented downloads. It must do so if an object has more than four bytes (CiA 301,
/// 7.2.4.2.1).
pub(crate) static SEGMENTED_DOWNLOAD: Need = Need::new("segmented-download", "SDO downloads in segments", |bench| {
    if bench.long_writable().is_some() || bench.long_object(5)?.is_some() {
        return Ok(Ok(()));
    }
    let scratch = bench.scratch_objects()?.into_iter().next();
    let multiplexer = scratch.map_or(DEVICE_TYPE, |scratch| scratch.multiplexer);
    let request = Request::InitiateDownload { multiplexer, payload: Payload::Segmented(4) };
    let reply = begun(bench, multiplexer, &request, "segmented download to")?;
    let is_unknown = reply.abort() == Some(AbortCode::COMMAND_SPECIFIER);
    Ok(match is_unknown {
        true => {
            Err(format!("no object has more than four bytes, and the {} is answered by {}", reply.what, reply.actual()))
        }
        false => Ok(()),
    })
});

/// A device name, hardware version or software version (1008h, 1009h, 100Ah).
pub static NAME: Need = Need::new("name", "a device name or version (1008h, 1009h or 100Ah)", |bench| {
    Ok(match bench.names()?.is_empty() {
        true => Err("the device has no 1008h, 1009h or 100Ah".to_owned()),
        false => Ok(()),
    })
});

/// The predefined error field, 1003h.
pub static ERROR_HISTORY: Need = Need::new("error-history", "the predefined error field (1003h)", |bench| {
    bench.has_all(&[Multiplexer::new(object::PREDEFINED_ERROR_FIELD, 0)])
});

/// TIME, 1012h.
pub static TIME: Need =
    Need::new("time", "TIME (1012h)", |bench| bench.can_write_all(&[Multiplexer::new(object::COB_ID_TIME, 0)]));

/// The COB-ID of EMCY, 1014h.
pub(crate) static EMCY_OBJECT: Need = Need::new("emcy-object", "the COB-ID of EMCY (1014h)", |bench| {
    bench.has_all(&[Multiplexer::new(object::COB_ID_EMCY, 0)])
});

/// A COB-ID of EMCY that can be written, 1014h.
pub(crate) static EMCY_ID: Need = Need::new("emcy-id", "a COB-ID of EMCY that can be written (1014h)", |bench| {
    bench.can_write_all(&[Multiplexer::new(object::COB_ID_EMCY, 0)])
});

/// The inhibit time of EMCY, 1015h.
pub(crate) static EMCY_INHIBIT: Need = Need::new("emcy-inhibit", "the inhibit time of EMCY (1015h)", |bench| {
    bench.can_write_all(&[Multiplexer::new(object::INHIBIT_TIME_EMCY, 0)])
});

/// The description contains an application object that can be written without side effects.
pub(crate) static APPLICATION_PARAMETER: Need =
    Need::new("application-parameter", "an application object that can be written without consequence", |bench| {
        Ok(match bench.application_scratch()? {
            Some(_) => Ok(()),
            None => Err("no application object that the tester knows can be written without consequence".to_owned()),
        })
    });

/// The SDO server parameter, 1200h.
pub(crate) static SERVER_PARAMETER: Need = Need::new("server-parameter", "the SDO server parameter (1200h)", |bench| {
    bench.has_all(&[Multiplexer::new(object::SDO_SERVER_PARAMETER, 1)])
});

/// A second SDO server, 1201h.
pub(crate) static SECOND_SERVER: Need = Need::new("second-server", "a second SDO server (1201h)", |bench| {
    bench.can_write_all(&[
        Multiplexer::new(object::FURTHER_SDO_SERVER_PARAMETER, 1),
        Multiplexer::new(object::FURTHER_SDO_SERVER_PARAMETER, 2),
    ])
});

/// Store parameters, 1010h:01.
pub(crate) static STORE_OBJECT: Need =
    Need::new("store-object", "store parameters (1010h:01)", |bench| bench.has_all(&[STORE_ALL]));

/// Parameters are stored on command, by 1010h:01.
pub(crate) static STORE: Need = Need::new("store", "parameters that are stored on command (1010h:01)", |bench| {
    let found = bench.has_all(&[STORE_ALL])?;
    Ok(match found {
        Ok(()) if stores_only_by_itself(bench)? => {
            Err("1010h:01 says that the device stores by itself and not on command".to_owned())
        }
        found => found,
    })
});

const STORE_ALL: Multiplexer = Multiplexer::new(object::STORE_PARAMETERS, 1);

/// Whether only bit 1 of 1010h:01 is set: then 1010h can't be written (CiA 301, 7.5.2.13).
fn stores_only_by_itself(bench: &mut Bench<'_>) -> Result<bool, Stop> {
    Ok(match bench.upload(STORE_ALL)?.outcome {
        Outcome::Uploaded(value) => number(&value) == 0b10,
        _ => false,
    })
}

/// Verify configuration, 1020h.
pub static VERIFY_CONFIGURATION: Need = Need::new("verify-configuration", "verify configuration (1020h)", |bench| {
    bench.can_write_all(&[
        Multiplexer::new(object::VERIFY_CONFIGURATION, 1),
        Multiplexer::new(object::VERIFY_CONFIGURATION, 2),
    ])
});

/// A string that can be written without side effects, according to the description.
pub(crate) static LONG_SCRATCH: Need =
    Need::new("long-scratch", "a string that can be written without consequence", |bench| {
        Ok(match bench.long_writable() {
            Some(_) => Ok(()),
            None => Err("the description names no string that can be written and read".to_owned()),
        })
    });

/// A string that is empty.
pub(crate) static EMPTY_VALUE: Need = Need::new("empty-value", "a string that is empty", |bench| {
    Ok(match bench.empty_object()? {
        Some(_) => Ok(()),
        None => Err("no object that was found is an empty string".to_owned()),
    })
});
