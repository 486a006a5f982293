//! Asks a device for its identity.

use crate::runner::DeviceIdentity;
use canvass_analyzer::object;
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_bus::client::{Exchange, Outcome, Transfer};
use canvass_bus::{Bus, BusError};
use canvass_traces::Duration;

/// Wait for each response: most servers answer within some milliseconds, a slow one within a fifth of a second.
const PATIENCE: Duration = Duration::from_millis(300);
/// Maximum time for all responses: a device that answers nonsense must not keep the program busy.
const LONGEST: Duration = Duration::from_secs(2);

/// The identity that the device reports; parts that it does not answer are empty.
///
/// # Errors
/// [`BusError`] if the bus fails.
pub fn ask(bus: &mut dyn Bus, node: NodeId) -> Result<DeviceIdentity, BusError> {
    let ends = bus.now() + LONGEST;
    let mut exchange = Exchange { bus, observe: &mut |_| (), ends };
    let mut read = |index, sub| -> Result<Option<Vec<u8>>, BusError> {
        let object = Multiplexer::new(index, sub);
        match exchange.transfer(node, Transfer::upload(object), PATIENCE)? {
            Outcome::Uploaded(value) => Ok(Some(value)),
            _ => Ok(None),
        }
    };
    let number = |value: Option<Vec<u8>>| Some(u32::from_le_bytes(*value?.first_chunk()?));
    let text = |value: Option<Vec<u8>>| Some(String::from_utf8_lossy(&value?).into_owned());
    let Some(device_type) = read(object::DEVICE_TYPE, 0)? else { return Ok(DeviceIdentity::default()) };
    let mut identity = DeviceIdentity { device_type: number(Some(device_type)), ..DeviceIdentity::default() };
    for (sub, part) in (1..).zip(&mut identity.identity) {
        *part = number(read(object::IDENTITY, sub)?);
    }
    for (index, name) in (object::MANUFACTURER_DEVICE_NAME..).zip(&mut identity.names) {
        *name = text(read(index, 0)?);
    }
    Ok(identity)
}
