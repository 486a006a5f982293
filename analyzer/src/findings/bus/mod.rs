//! Rules about the bus as a whole: the use of its CAN-IDs, and its load.

mod before_boot_up;
mod duplicate_node_id;
mod flying_master;
mod frame_kind;
mod interleaving;
mod load;
mod malformed;
mod no_canopen;
mod overlapping_cob_id;
mod repeated;
mod restricted_cob_id;
mod two_producers;
mod unknown_ids;

use crate::object;

/// Whether the object is a COB-ID: of SYNC, TIME, EMCY, an SDO or a PDO.
const fn is_cob_id(index: u16, sub: u8) -> bool {
    matches!(
        (index, sub),
        (object::COB_ID_SYNC | object::COB_ID_TIME | object::COB_ID_EMCY, 0)
            | (0x1200..=0x12FF, 1 | 2)
            | (0x1400..=0x15FF | 0x1800..=0x19FF, 1)
    )
}
