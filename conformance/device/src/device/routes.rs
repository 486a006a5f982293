//! Which CAN-ID belongs to which service of the device: most frames of a bus are for others, and are told by one look.

use super::Device;
use canvass_analyzer::CobId;
use canvass_analyzer::wire::{error_control, lss, nmt, sdo};

/// What a data frame on a CAN-ID is to the device.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Route {
    /// Nothing.
    Others,
    Nmt,
    Sync,
    Time,
    /// An EMCY of a node of 1028h.
    PeerEmcy,
    /// An error control message of another node.
    PeerErrorControl,
    Sdo,
    /// The further channel at that position.
    SecondSdo(u8),
    /// The RPDO at that position.
    Rpdo(u16),
    Lss,
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

    fn set(&mut self, can_id: u16, route: Route) {
        if let Some(slot) = self.0.get_mut(usize::from(can_id)) {
            *slot = route;
        }
    }
}

impl Device {
    /// Finds all routes anew: COB-IDs or the node-ID have changed. What is set last wins a CAN-ID that is used twice.
    pub(super) fn find_routes(&mut self) {
        let mut routes = Routes::new();
        for (position, rpdo) in (0..).zip(&self.rpdos) {
            rpdo.can_id().into_iter().for_each(|can_id| routes.set(can_id, Route::Rpdo(position)));
        }
        let parameters = &self.objects.parameters;
        for cob_id in (1..=127).map_while(|sub| parameters.number(0x1028, sub)).map(|raw| CobId(raw as u32)) {
            if cob_id.is_valid() && cob_id.can_id() != 0 {
                routes.set(cob_id.can_id() as u16, Route::PeerEmcy);
            }
        }
        self.objects.clock.can_id().into_iter().for_each(|can_id| routes.set(can_id, Route::Time));
        self.sync.can_id().into_iter().for_each(|can_id| routes.set(can_id, Route::Sync));
        for (position, channel) in (0..).zip(&self.second_sdos) {
            channel.can_id().into_iter().for_each(|can_id| routes.set(can_id, Route::SecondSdo(position)));
        }
        for node in 1..=0x7F {
            routes.set(error_control::CAN_ID_BASE + node, Route::PeerErrorControl);
        }
        routes.set(lss::MASTER_CAN_ID, Route::Lss);
        if let Some(node) = self.node {
            routes.set(sdo::REQUEST_BASE + u16::from(node.raw()), Route::Sdo);
            routes.set(nmt::CAN_ID, Route::Nmt);
        }
        self.routes = routes;
    }

    /// Whether a frame in the 29-bit format is taken for one with 11 bits.
    pub(super) fn confuses_formats(&self) -> bool {
        self.firmware.takes_extended_for_base_format()
    }
}
