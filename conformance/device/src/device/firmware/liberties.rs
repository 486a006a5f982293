use super::hooks;
use crate::{Firmware, Liberty};
use canvass_analyzer::wire::sdo::AbortCode;

hooks! {
    answers_wrong_toggle but ToggleIgnored,
    aborts_at_timeout but TimeoutWithoutAbort,
    announces_sizes but SizesUnannounced,
    knows_block_crc but BlocksWithoutCrc,
    switches_protocol but ProtocolNotSwitched,
    refuses_reserved_bits by ReservedBitsRefused,
    switches_before_block_size by ProtocolBeforeBlockSize,
    checks_length_before_crc by LengthBeforeCrc,
    refuses_cob_id_rewrite by CobIdRewriteRefused,
    locks_pdo_parameters by PdoParametersLocked,
    keeps_manufacturer_variables by VariablesKept,
    starts_by_itself by SelfStart,
    signals_errors but NoEmcy,
    inhibits_from_write by InhibitFromWrite,
    has_generic_codes_only by GenericErrorCodes,
    reports_sync_length but SyncLengthUnreported,
    reports_long_rpdo but LongRpdoUnreported,
    signals_newest_after_stopped by StoppedEmcyNewest,
    drops_emcy_of_stopped by StoppedEmcyDropped,
    reports_lost_heartbeat but LostHeartbeatUnreported,
    takes_writes_for_events but OwnEvents,
    takes_one_length by StringsOfOneLength,
    knows_segments but NoSegmentedTransfer,
    refuses_at_end by RefusedAtEnd,
    delays_synchronous_pdo_rightly by SyncTpdoIn40Ms,
    checks_mapped_length_at_entry by MappingLengthAtEntry,
    counts_from_middle by SyncCountFromMiddle,
    maps_whole_bytes_only by MappingInBytes,
    knows_fastscan but NoFastscan,
    knows_lss_inquiry but NoLssInquiry,
    stores_lss_slowly by LssStoreIn2S,
    has_sdo_client by OwnSdoClient,
    sends_bursts by OwnTraffic,
}

/// The segments of a block where the firmware has little memory.
const SMALL_BLOCK: u8 = 4;

/// Abort codes of which the standard has several for the same reason.
impl Firmware {
    /// A code that is as right as that one.
    pub(super) const fn free_code(&self, code: AbortCode) -> AbortCode {
        match code {
            AbortCode::LENGTH_TOO_HIGH | AbortCode::LENGTH_TOO_LOW if self.takes(Liberty::LengthCodeGeneral) => {
                AbortCode::LENGTH
            }
            AbortCode::VALUE_TOO_HIGH | AbortCode::VALUE_TOO_LOW if self.takes(Liberty::RangeCodeGeneral) => {
                AbortCode::INVALID_VALUE
            }
            code => code,
        }
    }

    /// For a value above what a service knows.
    pub(in crate::device) const fn limit_code(&self) -> AbortCode {
        if self.takes(Liberty::LimitCodePrecise) { AbortCode::VALUE_TOO_HIGH } else { AbortCode::INVALID_VALUE }
    }

    /// For an empty entry of 1003h.
    pub(in crate::device) const fn empty_history_code(&self) -> AbortCode {
        if self.takes(Liberty::HistoryCodeGeneral) { AbortCode::GENERAL } else { AbortCode::NO_DATA }
    }

    /// For 1019h while 1006h is not 0.
    pub(in crate::device) const fn overflow_code(&self) -> AbortCode {
        if self.takes(Liberty::OverflowCodeGeneral) { AbortCode::GENERAL } else { AbortCode::DEVICE_STATE }
    }

    /// For an object that can't be mapped.
    pub(in crate::device) const fn entry_code(&self, code: AbortCode) -> AbortCode {
        match code {
            AbortCode::NOT_MAPPABLE if self.takes(Liberty::EntryCodeMissing) => AbortCode::NO_OBJECT,
            AbortCode::NO_OBJECT if self.takes(Liberty::EntryCodeUnmappable) => AbortCode::NOT_MAPPABLE,
            code => code,
        }
    }

    /// For a number of mapped objects that is not possible.
    pub(in crate::device) const fn count_code(&self, code: AbortCode) -> AbortCode {
        match code {
            AbortCode::PDO_LENGTH if self.takes(Liberty::CountCodeMissing) => AbortCode::NO_OBJECT,
            code => code,
        }
    }

    /// For another CAN-ID of a COB-ID that is valid.
    pub(in crate::device) const fn cob_id_code(&self, code: AbortCode) -> AbortCode {
        match () {
            () if self.takes(Liberty::CobIdCodeGeneral) => AbortCode::GENERAL,
            () if self.takes(Liberty::CobIdCodeState) => AbortCode::DEVICE_STATE,
            () => code,
        }
    }

    /// Whether parameters are stored as soon as they are written.
    pub(in crate::device) const fn stores_by_itself(&self) -> bool {
        let has_1010h = !self.takes(Liberty::NoStore);
        has_1010h && (self.takes(Liberty::StoresByItself) || self.takes(Liberty::StoresBothWays))
    }

    /// Whether restoring the defaults takes the node-ID away. A device without LSS could never get one again.
    pub(in crate::device) const fn restores_node_id(&self) -> bool {
        self.takes(Liberty::NodeIdRestored) && !self.takes(Liberty::NoLss)
    }

    /// The size of the blocks that the server asks for; `usual` is the largest one.
    pub(in crate::device) const fn block_size(&self, usual: u8) -> u8 {
        if self.takes(Liberty::SmallBlocks) { SMALL_BLOCK } else { usual }
    }
}
