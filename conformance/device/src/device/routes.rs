//! The service for each CAN-ID. Most frames of a bus are for other nodes, which a single look-up shows.

/// The service that gets data frames with a CAN-ID. If several services are configured for one CAN-ID, the later of
/// these variants wins.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) enum Route {
    /// No service of this device: the frame is for other nodes.
    Others,
    /// The RPDO with this index.
    Rpdo(u16),
    /// An EMCY of a node of 1028h.
    PeerEmcy,
    Time,
    Sync,
    /// The further SDO channel with this index.
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
    /// Routes without services.
    pub fn new() -> Self {
        Self(vec![Route::Others; CAN_IDS].into_boxed_slice())
    }

    /// The route of a data frame.
    pub fn of(&self, can_id: u16) -> Route {
        self.0.get(usize::from(can_id)).copied().unwrap_or(Route::Others)
    }

    /// Assigns a CAN-ID to a service, unless it belongs to a service of higher rank.
    pub fn set(&mut self, can_id: u16, route: Route) {
        if let Some(slot) = self.0.get_mut(usize::from(can_id)).filter(|slot| **slot <= route) {
            *slot = route;
        }
    }
}
