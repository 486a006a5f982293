//! Which CAN-ID belongs to which service of the device: most frames of a bus are for others, and are told by one look.

/// What a data frame on a CAN-ID is to the device. Of services that are configured onto the same CAN-ID the later one
/// of these gets it.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) enum Route {
    /// Nothing.
    Others,
    /// The RPDO at that position.
    Rpdo(u16),
    /// An EMCY of a node of 1028h.
    PeerEmcy,
    Time,
    Sync,
    /// The further SDO channel at that position.
    FurtherSdo(u8),
    /// An error control message of another node.
    PeerErrorControl,
    Lss,
    Lmt,
    Sdo,
    Nmt,
}

/// A route for each CAN-ID of 11 bits.
#[derive(Clone, Debug)]
pub(super) struct Routes(Box<[Route]>);

const CAN_IDS: usize = 0x800;

impl Routes {
    /// Nothing is for the device.
    pub fn new() -> Self {
        Self(vec![Route::Others; CAN_IDS].into_boxed_slice())
    }

    /// What a data frame is.
    pub fn of(&self, can_id: u16) -> Route {
        self.0.get(usize::from(can_id)).copied().unwrap_or(Route::Others)
    }

    /// Gives a CAN-ID to a service, unless it is of one that comes before it.
    pub fn set(&mut self, can_id: u16, route: Route) {
        if let Some(slot) = self.0.get_mut(usize::from(can_id)).filter(|slot| **slot <= route) {
            *slot = route;
        }
    }
}
