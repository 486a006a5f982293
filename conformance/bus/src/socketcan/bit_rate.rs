//! Another bit rate for an interface, as `ip link set can0 type can bitrate 500000` sets it: the interface must be down
//! for that.

use super::error::SocketCanError;
use super::link::{CONTROLLER, IFLA_CAN_BITTIMING, IFLA_INFO_DATA, IFLA_INFO_KIND, IFLA_LINKINFO, Link};
use super::netlink::{IFF_UP, NLM_F_ACK, NLM_F_REQUEST, RTM_NEWLINK, attribute, kind, message};
use super::sys;
use std::io;
use std::sync::atomic::{AtomicBool, Ordering};

/// `struct can_bittiming` has eight numbers. Of those that are zero the kernel finds the best for the first.
const BIT_TIMING: usize = 32;

/// Takes the interface down, sets its bit rate and takes it up again. Where the bit rate can't be set, the interface is
/// up again with the one before. `goes_down` is set while it is this program that takes the interface down.
///
/// # Errors
/// [`SocketCanError`], which says what to do.
pub(super) fn set(interface: &str, bit_rate: u32, goes_down: &AtomicBool) -> Result<(), SocketCanError> {
    let failed = |source| SocketCanError::BitRate {
        interface: interface.to_owned(),
        bit_rate,
        command: format!("ip link set {interface} down && ip link set {interface} up type can bitrate {bit_rate}"),
        source,
    };
    let link = SocketCanError::check(interface, Link::find(interface).map_err(failed)?)?;
    if link.kind != CONTROLLER {
        return Err(SocketCanError::NoBitRate { interface: interface.to_owned(), kind: link.kind });
    }
    goes_down.store(true, Ordering::SeqCst);
    if let Err(error) = change(link.index, (0, IFF_UP), &[]) {
        goes_down.store(false, Ordering::SeqCst);
        return Err(failed(error));
    }
    let set = change(link.index, (IFF_UP, IFF_UP), &timing(bit_rate));
    if set.is_err() {
        change(link.index, (IFF_UP, IFF_UP), &[]).map_err(failed)?;
    }
    set.map_err(failed)
}

fn timing(bit_rate: u32) -> Vec<u8> {
    let mut timing = bit_rate.to_ne_bytes().to_vec();
    timing.resize(BIT_TIMING, 0);
    let controller = attribute(IFLA_CAN_BITTIMING, &timing);
    let info = [attribute(IFLA_INFO_KIND, CONTROLLER.as_bytes()), attribute(IFLA_INFO_DATA, &controller)];
    attribute(IFLA_LINKINFO, &info.concat())
}

fn change(index: u32, flags: (u32, u32), attributes: &[u8]) -> io::Result<()> {
    let request = message(RTM_NEWLINK, NLM_F_REQUEST | NLM_F_ACK, index, flags, attributes);
    kind(&sys::ask_routing(&request)?).map(|_| ())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The attributes of `ip link set can0 type can bitrate 500000`, as strace shows them of iproute2 6.1.
    #[cfg(target_endian = "little")]
    #[test]
    fn as_iproute2_says_it() {
        let mut expected = vec![
            0x34, 0, 18, 0, // IFLA_LINKINFO
            7, 0, 1, 0, b'c', b'a', b'n', 0, // IFLA_INFO_KIND
            0x28, 0, 2, 0, // IFLA_INFO_DATA
            0x24, 0, 1, 0, 0x20, 0xA1, 0x07, 0, // IFLA_CAN_BITTIMING
        ];
        expected.resize(0x34, 0);
        assert_eq!(timing(500_000), expected);
    }

    #[test]
    fn only_interfaces_with_a_controller_have_one() {
        let goes_down = AtomicBool::new(false);
        assert!(matches!(set("lo", 500_000, &goes_down), Err(SocketCanError::NotCan { .. })));
        assert!(matches!(set("no-such-can", 500_000, &goes_down), Err(SocketCanError::NoInterface { .. })));
        assert!(!goes_down.into_inner());
    }
}
