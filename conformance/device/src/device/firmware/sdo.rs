use super::hooks;
use crate::{Fault, Firmware, Liberty};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::sdo::AbortCode;

hooks! {
    is_busy_in_upload with SdoBusyAfterAbandonedTransfer,
    is_busy_in_download with SdoBusyAfterAbandonedDownload,
    is_busy_in_block_transfer with SdoBusyAfterAbandonedBlock or BlockInitiateRefused,
    ignores_client_abort with SdoAbortIgnored,
    ignores_abort_in_block_download with SdoBlockAbortIgnored,
    answers_client_abort with SdoAbortAnswered,
    mixes_up_requests with SdoBackToBackMixed,
    overlooks_first_unknown_command with SdoFirstUnknownCommandSilent,
    loses_responses with SdoResponseLost,
    delays_responses with SdoResponseSlow,
    dies_of_short_request with SdoShortRequestWedges,
    dies_of_timeout with SdoTimeoutWedges,
    answers_stray_block_command unless SdoStrayBlockSilent,
    serves_refused_segment with SdoRefusedSegmentServed,
    writes_segment_in_upload with SdoSegmentWrittenInUpload,
    answers_stray_segment unless SdoStraySegmentSilent,
    answers_unknown_command unless SdoUnknownCommandSilent,
    answers_misplaced_command unless SdoWrongCommandIgnored,
    answers_missing_object unless SdoNoObjectSilent,
    cuts_responses with SdoShortResponse,
    leaves_unused_bytes with SdoUnusedBytesNotZero,
    answers_empty_value unless SdoEmptyValueSilent,
    announces_one_byte_more with SdoAnnouncedSizeWrong,
    answers_segment_after_end with SdoSegmentAfterEndAnswered,
    loses_byte_of_last_segment with SdoSegmentLengthWrong,
    checks_toggle unless SdoToggleUnchecked,
    toggles_upload unless SdoUploadToggleStuck,
    marks_end_of_upload unless SdoUploadEndMissing,
    toggles_confirmations unless SdoConfirmationToggleStuck,
    answers_empty_segment unless SdoEmptySegmentSilent,
    writes_segments_at_once with SdoSegmentsWrittenAtOnce,
    answers_unsized_download unless SdoUnsizedDownloadSilent,
    begins_download_to_read_only with SdoReadOnlySegmentedAccepted,
    takes_short_value_in_segments unless SdoSegmentedShortRefused,
    requires_size with SdoSegmentedSizeRequired,
    confirms_read_only with SdoReadOnlyWritable,
    checks_length unless SdoLengthUnchecked,
    checks_short_length unless SdoShortLengthUnchecked,
    refuses_block_downloads with SdoBlockDownloadRefused,
    counts_full_segment_empty with SdoBlockSevenEndsEmpty,
    sends_crc_unasked with SdoBlockCrcUnasked,
    keeps_requests_of_stopped with SdoRequestKeptOverStop,
    begins_block_to_read_only with SdoBlockReadOnlyAccepted,
    offers_empty_blocks with SdoBlockSizeZeroOffered,
    refuses_sequence_zero unless SdoBlockSequenceZeroIgnored,
    appends_repeated_segment with SdoBlockRepeatedAppended,
    takes_segment_after_gap with SdoBlockGapAccepted,
    miscounts_block with SdoBlockCountOffByOne,
    keeps_padding with SdoBlockPaddingKept,
    checks_crc unless SdoBlockCrcIgnored,
    keeps_block_crc with SdoBlockCrcKept,
    writes_before_crc_check with SdoBlockWrittenBeforeCheck,
    checks_block_length unless SdoBlockSizeMismatchAccepted,
    confirms_end_of_block unless SdoBlockEndSilent,
    checks_block_size unless SdoBlockSizeUnchecked,
    cuts_switched_upload with SdoBlockSwitchTruncates,
    announces_one_byte_more_in_block with SdoBlockAnnouncedSizeWrong,
    checks_confirmation unless SdoBlockConfirmationUnchecked,
    ignores_confirmation with SdoBlockConfirmationIgnored,
    repeats_whole_block with SdoBlockRepeatsAll,
    takes_new_block_size unless SdoBlockNewSizeIgnored,
    miscounts_last_segment with SdoBlockLastLengthWrong,
    begins_crc_with_ones with SdoBlockCrcStartWrong,
    swaps_crc with SdoBlockCrcSwapped,
    marks_end_of_block unless SdoBlockEndUnmarked,
    continues_sequence_numbers with SdoBlockNumbersContinue,
    ends_transfer_at_reset unless SdoTransferSurvivesReset,
    ends_transfer_when_stopped unless SdoTransferSurvivesStop,
    leaks_memory with SdoMemoryLeak,
    bites_under_load with WatchdogResetUnderLoad,
}

impl Firmware {
    /// The object that an abort names; `stale` is that of the transfer before.
    pub(in crate::device) const fn aborted_object(&self, object: Multiplexer, stale: Multiplexer) -> Multiplexer {
        match () {
            () if self.has(Fault::SdoStaleMultiplexer) => stale,
            () if self.has(Fault::SdoAbortMultiplexerZero) => Multiplexer::new(0, 0),
            () => object,
        }
    }

    /// The abort code for what the standard has that one for.
    pub(in crate::device) fn abort_code(&self, code: AbortCode) -> AbortCode {
        let wrong = match code {
            AbortCode::LENGTH | AbortCode::LENGTH_TOO_HIGH | AbortCode::LENGTH_TOO_LOW => {
                (Fault::SdoLengthWrongCode, AbortCode::INVALID_VALUE)
            }
            AbortCode::VALUE_TOO_HIGH | AbortCode::VALUE_TOO_LOW => (Fault::SdoRangeWrongCode, AbortCode::READ_ONLY),
            AbortCode::MAXIMUM_BELOW_MINIMUM => (Fault::LimitsSwappedWrongCode, AbortCode::READ_ONLY),
            AbortCode::TOGGLE => (Fault::SdoToggleWrongCode, AbortCode::COMMAND_SPECIFIER),
            AbortCode::COMMAND_SPECIFIER => (Fault::SdoCommandWrongCode, AbortCode::GENERAL),
            AbortCode::CRC => (Fault::SdoBlockCrcWrongCode, AbortCode::GENERAL),
            AbortCode::BLOCK_SIZE => (Fault::SdoBlockSizeWrongCode, AbortCode::INVALID_VALUE),
            AbortCode::WRITE_ONLY => (Fault::SdoWriteOnlyWrongCode, AbortCode::NO_OBJECT),
            AbortCode::NO_SUB_INDEX => (Fault::SdoUnknownAbortCode, AbortCode(0x0A00_0001)),
            code => return self.free_code(code),
        };
        if self.has(wrong.0) { wrong.1 } else { self.free_code(code) }
    }

    /// The abort code for an object, or a sub-index, that does not exist.
    pub(in crate::device) const fn missing_code(&self, code: AbortCode) -> AbortCode {
        match code {
            AbortCode::NO_OBJECT if self.has(Fault::SdoWrongCodeForNoObject) => AbortCode::NO_SUB_INDEX,
            AbortCode::NO_SUB_INDEX if self.has(Fault::SdoWrongCodeForNoSubIndex) => AbortCode::NO_OBJECT,
            code => code,
        }
    }

    /// The abort code for a write to what can only be read.
    pub(in crate::device) const fn read_only_code(&self) -> AbortCode {
        if self.has(Fault::SdoReadOnlyWrongCode) { AbortCode::DEVICE_STATE } else { AbortCode::READ_ONLY }
    }
}
