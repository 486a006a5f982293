//! Sets the bit rate of an interface, like `ip link set can0 type can bitrate 500000`. The interface must be down
//! for this change.

use super::error::SocketCanError;
use super::link::{Link, io_error};
use socketcan::nl::{CanCtrlMode, CanInterface};
use std::io;
use std::sync::atomic::{AtomicBool, Ordering};

/// The range of a controller's bit rates, in bit/s.
const POSSIBLE: std::ops::RangeInclusive<u32> = 1..=1_000_000;

/// Takes the interface down, sets its bit rate and brings it up again. If the kernel refuses the new bit rate, the
/// interface keeps the old one. `goes_down` is true while this program keeps the interface down. `listens` switches
/// listen-only on or off; `None` leaves it as it is.
///
/// # Errors
/// [`SocketCanError`] with a remedy.
pub(super) fn set(
    interface: &str,
    bit_rate: u32,
    listens: Option<bool>,
    goes_down: &AtomicBool,
) -> Result<(), SocketCanError> {
    let failed = |source| SocketCanError::BitRate {
        interface: interface.to_owned(),
        bit_rate,
        command: format!("ip link set {interface} down && ip link set {interface} up type can bitrate {bit_rate}"),
        source,
    };
    let link = SocketCanError::check(interface, Link::find(interface).map_err(failed)?)?;
    if link.state.is_none() {
        return Err(SocketCanError::NoBitRate { interface: interface.to_owned() });
    }
    if !POSSIBLE.contains(&bit_rate) {
        return Err(failed(io::Error::from(io::ErrorKind::InvalidInput)));
    }
    let open = CanInterface::open_iface(link.index);
    goes_down.store(true, Ordering::SeqCst);
    if let Err(error) = open.bring_down() {
        goes_down.store(false, Ordering::SeqCst);
        return Err(failed(io_error(error)));
    }
    let listening = listens.map_or(Ok(()), |on| open.set_ctrlmode(CanCtrlMode::ListenOnly, on));
    let set = listening.and_then(|()| open.set_bitrate(bit_rate, None));
    // The interface comes up with the new bit rate or, after an error, with the old one.
    open.bring_up().map_err(|error| failed(io_error(error)))?;
    set.map_err(|error| failed(io_error(error)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_interfaces_with_a_controller_have_one() {
        let goes_down = AtomicBool::new(false);
        assert!(matches!(set("lo", 500_000, None, &goes_down), Err(SocketCanError::NotCan { .. })));
        assert!(matches!(set("no-such-can", 500_000, Some(true), &goes_down), Err(SocketCanError::NoInterface { .. })));
        assert!(!goes_down.into_inner());
    }
}
