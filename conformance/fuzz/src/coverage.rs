//! The combinations of state, command and class of answer that a run has seen, of the SDO server and the LSS slave.

use super::{Knowledge, Known, Services};
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::layer_setting::{Dialect, Request};
use canvass_analyzer::wire::sdo::Response;
use canvass_suite::touch::Touch;
use canvass_traces::Frame;
use std::collections::BTreeSet;

/// Defines an enum with a name for each variant and a list of all variants.
macro_rules! classes {
    ($(#[$doc:meta])* $name:ident { $($(#[$variant_doc:meta])* $variant:ident = $text:literal,)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
        pub enum $name {
            $($(#[$variant_doc])* $variant,)*
        }

        impl $name {
            /// All variants.
            pub const ALL: &'static [Self] = &[$(Self::$variant),*];

            /// The name in words.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$variant => $text,)* }
            }
        }
    };
}

classes! {
    /// States of the SDO server.
    SdoState {
        /// No transfer is active.
        Idle = "idle",
        /// A segmented download.
        Download = "segmented download",
        /// A segmented upload.
        Upload = "segmented upload",
        /// The segments of a block download.
        BlockDownload = "block download",
        /// The end of a block download.
        BlockDownloadEnd = "end of block download",
        /// Before the start of a block upload.
        BlockUploadReady = "block upload before its start",
        /// A block upload.
        BlockUpload = "block upload",
        /// The end of a block upload.
        BlockUploadEnd = "end of block upload",
    }
}

classes! {
    /// Classes of frames that an SDO client can send.
    Command {
        /// Expedited download.
        Expedited = "expedited download",
        /// Initiate segmented download.
        BeginDownload = "begin segmented download",
        /// Initiate upload.
        BeginUpload = "initiate upload",
        /// Download segment.
        DownloadSegment = "download segment",
        /// Request for an upload segment.
        UploadSegment = "upload segment",
        /// Abort.
        Abort = "abort",
        /// Initiate block upload.
        BeginBlockUpload = "initiate block upload",
        /// Start of a block upload.
        StartBlockUpload = "start block upload",
        /// Confirmation of a block.
        ConfirmBlockUpload = "confirm block",
        /// End of a block upload.
        EndBlockUpload = "end block upload",
        /// Initiate block download.
        BeginBlockDownload = "initiate block download",
        /// End of a block download.
        EndBlockDownload = "end block download",
        /// A segment of a block.
        BlockSegment = "block segment",
        /// Command specifier 7.
        Unknown = "unknown command",
        /// Fewer than eight bytes.
        Short = "short frame",
        /// A 29-bit identifier.
        Extended = "29-bit identifier",
    }
}

classes! {
    /// Classes of answers.
    Answer {
        /// No answer.
        None = "none",
        /// An abort.
        Abort = "abort",
        /// A value or a segment.
        Data = "data",
        /// A confirmation.
        Confirmation = "confirmation",
        /// Segments of a block.
        Block = "block",
    }
}

classes! {
    /// States of the LSS slave.
    LssState {
        /// Waiting state.
        Waiting = "waiting",
        /// Waiting state, after some parts of the LSS address have come.
        Selecting = "waiting, selecting",
        /// Configuration state.
        Configuration = "configuration",
        /// Without node-ID.
        Unconfigured = "without node-ID",
        /// Without node-ID, in a Fastscan.
        Scanning = "without node-ID, scanning",
    }
}

classes! {
    /// Classes of frames that an LSS master can send.
    LssCommand {
        /// 04h.
        SwitchGlobal = "switch state global",
        /// 11h.
        ConfigureNodeId = "configure node-ID",
        /// 13h.
        ConfigureBitTiming = "configure bit timing",
        /// 15h.
        ActivateBitTiming = "activate bit timing",
        /// 17h.
        Store = "store configuration",
        /// 40h to 43h.
        SwitchSelective = "switch state selective",
        /// 46h to 4Bh.
        IdentifyRemote = "identify remote slave",
        /// 4Ch.
        IdentifyNonConfigured = "identify non-configured",
        /// 51h.
        Fastscan = "Fastscan",
        /// 5Ah to 5Dh.
        Inquire = "inquire",
        /// 5Eh.
        InquireNodeId = "inquire node-ID",
        /// Any other command.
        Unknown = "unknown command",
        /// Fewer than eight bytes.
        Short = "short frame",
    }
}

impl Command {
    /// The class of a frame to the SDO server. In a block download the segments have no command specifier.
    pub fn of(frame: &Frame, in_block_download: bool) -> Self {
        if frame.len() != 8 {
            return Self::Short;
        }
        let byte = frame.bytes()[0];
        if in_block_download && byte != 0x80 {
            return Self::BlockSegment;
        }
        match (byte >> 5, byte & 0b11) {
            (0, _) => Self::DownloadSegment,
            (1, 0b10 | 0b11) => Self::Expedited,
            (1, _) => Self::BeginDownload,
            (2, _) => Self::BeginUpload,
            (3, _) => Self::UploadSegment,
            (4, _) => Self::Abort,
            (5, 0) => Self::BeginBlockUpload,
            (5, 1) => Self::EndBlockUpload,
            (5, 2) => Self::ConfirmBlockUpload,
            (5, _) => Self::StartBlockUpload,
            (6, 0 | 2) => Self::BeginBlockDownload,
            (6, _) => Self::EndBlockDownload,
            _ => Self::Unknown,
        }
    }
}

impl Answer {
    /// The class of a response.
    pub const fn of(response: &Response) -> Self {
        match response {
            Response::Abort(_) => Self::Abort,
            Response::UploadSegment(_)
            | Response::InitiateUpload { .. }
            | Response::InitiateBlockUpload { .. }
            | Response::EndBlockUpload { .. } => Self::Data,
            _ => Self::Confirmation,
        }
    }
}

impl LssCommand {
    /// The class of a frame to the LSS or LMT slave, named after the service of LSS.
    pub fn of<D: Dialect>(frame: &Frame) -> Self {
        let request = Request::<D>::read(frame.data()).ok().filter(|_| frame.len() == 8);
        match request {
            None => Self::Short,
            Some(Request::SwitchGlobal { .. }) => Self::SwitchGlobal,
            Some(Request::ConfigureNodeId { .. }) => Self::ConfigureNodeId,
            Some(Request::ConfigureBitTiming { .. }) => Self::ConfigureBitTiming,
            Some(Request::ActivateBitTiming { .. }) => Self::ActivateBitTiming,
            Some(Request::StoreConfiguration) => Self::Store,
            Some(Request::SwitchSelective { .. }) => Self::SwitchSelective,
            Some(Request::IdentifyRemote { .. }) => Self::IdentifyRemote,
            Some(Request::IdentifyNonConfigured) => Self::IdentifyNonConfigured,
            Some(Request::Fastscan { .. }) => Self::Fastscan,
            Some(Request::Inquire { .. }) => Self::Inquire,
            Some(Request::InquireNodeId) => Self::InquireNodeId,
            Some(Request::Unknown { .. }) => Self::Unknown,
        }
    }
}

const SDO_STATES: usize = SdoState::ALL.len();
const COMMANDS: usize = Command::ALL.len();
const ANSWERS: usize = Answer::ALL.len();
const LSS_STATES: usize = LssState::ALL.len();
const LSS_COMMANDS: usize = LssCommand::ALL.len();

/// Number of occurrences of each combination.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Coverage {
    sdo: [[[u64; ANSWERS]; COMMANDS]; SDO_STATES],
    lss: [[[u64; 2]; LSS_COMMANDS]; LSS_STATES],
}

impl Default for Coverage {
    fn default() -> Self {
        Self { sdo: [[[0; ANSWERS]; COMMANDS]; SDO_STATES], lss: [[[0; 2]; LSS_COMMANDS]; LSS_STATES] }
    }
}

/// The states of the SDO server that a run can reach.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct SdoReach {
    /// Whether the server supports block transfers.
    pub blocks: bool,
    /// Whether an object has a value that does not fit into one frame and is sent in segments.
    pub long_values: bool,
}

impl SdoReach {
    /// The reach on a device. A feature that is not described counts as supported.
    pub fn of(knowledge: &Knowledge) -> Self {
        let is_long = |known: &Known| known.readable && known.size.is_none_or(|size| size > 4);
        Self {
            blocks: knowledge.services.block_transfer != Some(false),
            long_values: !knowledge.is_described() || knowledge.entries().iter().any(is_long),
        }
    }

    const fn has(self, state: SdoState) -> bool {
        match state {
            SdoState::Idle | SdoState::Download => true,
            SdoState::Upload => self.long_values,
            _ => self.blocks,
        }
    }
}

/// The states and commands of LSS or LMT that a run can reach. A master can send every command in every state, so that
/// only the states of the slave and the commands that the user has not allowed limit a run.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct LssReach {
    /// The states that the slave has.
    pub states: Vec<LssState>,
    /// Commands that are never sent, because the user has not allowed them or LMT does not have them.
    pub never: Vec<LssCommand>,
}

impl LssReach {
    /// The reach on a device with these services if only `allow` is allowed. `unconfigured`: the test stand can provide
    /// the device without node-ID.
    pub fn of(services: &Services, unconfigured: bool, allow: &BTreeSet<Touch>) -> Self {
        let states = LssState::ALL.iter().copied().filter(|state| match state {
            LssState::Waiting => true,
            LssState::Selecting | LssState::Configuration => services.lmt || services.lss != Some(false),
            LssState::Unconfigured | LssState::Scanning => unconfigured && !services.lmt,
        });
        // Services of LSS that LMT does not have.
        let lss_only = [LssCommand::IdentifyNonConfigured, LssCommand::Fastscan, LssCommand::InquireNodeId];
        let needs = [
            (LssCommand::ConfigureNodeId, Touch::NodeId),
            (LssCommand::ConfigureBitTiming, Touch::BitRate),
            (LssCommand::ActivateBitTiming, Touch::BitRate),
            (LssCommand::Store, Touch::Nvm),
        ];
        let forbidden = needs.into_iter().filter(|(_, touch)| !allow.contains(touch)).map(|(command, _)| command);
        let never = forbidden.chain(lss_only.into_iter().filter(|_| services.lmt));
        Self { states: states.collect(), never: never.collect() }
    }
}

impl Coverage {
    /// Counts a request to the SDO server and the class of its answer.
    pub const fn sdo(&mut self, state: SdoState, command: Command, answer: Answer) {
        self.sdo[state as usize][command as usize][answer as usize] += 1;
    }

    /// Counts a frame with a 29-bit identifier, which the server must ignore.
    pub(crate) fn sdo_frame(
        &mut self,
        state: Option<SdoState>,
        command: Command,
        frame: &Frame,
        knowledge: &Knowledge,
    ) {
        let twin = canvass_analyzer::wire::sdo::REQUEST_BASE + u16::from(knowledge.node.raw());
        if let Some(state) = state.filter(|_| frame.id().raw() == u32::from(twin)) {
            self.sdo(state, command, Answer::None);
        }
    }

    /// Counts a request to the LSS slave, and whether it was answered.
    pub const fn lss(&mut self, state: LssState, command: LssCommand, answered: bool) {
        self.lss[state as usize][command as usize][answered as usize] += 1;
    }

    /// Number of times that the SDO server got the command in the state.
    pub(crate) fn sdo_count(&self, state: SdoState, command: Command) -> u64 {
        self.sdo[state as usize][command as usize].iter().sum()
    }

    /// Number of times that the LSS slave got the command in the state.
    pub(crate) fn lss_count(&self, state: LssState, command: LssCommand) -> u64 {
        self.lss[state as usize][command as usize].iter().sum()
    }

    /// The combinations of SDO state and command that can be reached. Block segments exist only in a block download,
    /// where the server reads every frame of eight bytes as a segment, except an abort.
    pub(crate) fn sdo_pairs(reach: SdoReach) -> impl Iterator<Item = (SdoState, Command)> {
        let states = SdoState::ALL.iter().copied().filter(move |&state| reach.has(state));
        let pairs = states.flat_map(|state| Command::ALL.iter().map(move |&command| (state, command)));
        pairs.filter(|&(state, command)| match state {
            SdoState::BlockDownload => {
                matches!(command, Command::BlockSegment | Command::Abort | Command::Short | Command::Extended)
            }
            _ => command != Command::BlockSegment,
        })
    }

    /// The combinations of LSS state and command that can be reached.
    pub(crate) fn lss_pairs(reach: &LssReach) -> impl Iterator<Item = (LssState, LssCommand)> + '_ {
        let pairs = reach.states.iter().flat_map(|&state| LssCommand::ALL.iter().map(move |&command| (state, command)));
        pairs.filter(|(_, command)| !reach.never.contains(command))
    }

    /// Number of combinations of state and command that were seen, of SDO and LSS together.
    pub fn exercised(&self) -> usize {
        let sdo = self.sdo.iter().flatten().filter(|answers| answers.iter().any(|&count| count > 0)).count();
        let lss = self.lss.iter().flatten().filter(|answers| answers.iter().any(|&count| count > 0)).count();
        sdo + lss
    }

    /// Number of reachable SDO combinations that were seen, and number of all reachable SDO combinations.
    pub fn sdo_share(&self, reach: SdoReach) -> (usize, usize) {
        let pairs: Vec<_> = Self::sdo_pairs(reach).collect();
        (pairs.iter().filter(|&&(state, command)| self.sdo_count(state, command) > 0).count(), pairs.len())
    }

    /// Number of reachable LSS combinations that were seen, and number of all reachable LSS combinations.
    pub fn lss_share(&self, reach: &LssReach) -> (usize, usize) {
        let pairs: Vec<_> = Self::lss_pairs(reach).collect();
        (pairs.iter().filter(|&&(state, command)| self.lss_count(state, command) > 0).count(), pairs.len())
    }

    /// All LSS combinations that were seen: state, command, whether it was answered, number.
    pub fn lss_rows(&self) -> impl Iterator<Item = (LssState, LssCommand, bool, u64)> {
        LssState::ALL.iter().flat_map(move |&state| {
            LssCommand::ALL.iter().flat_map(move |&command| {
                [false, true].into_iter().filter_map(move |answered| {
                    let count = self.lss[state as usize][command as usize][usize::from(answered)];
                    (count > 0).then_some((state, command, answered, count))
                })
            })
        })
    }

    /// All SDO combinations that were seen: state, command, answer, number.
    pub fn sdo_rows(&self) -> impl Iterator<Item = (SdoState, Command, Answer, u64)> {
        SdoState::ALL.iter().flat_map(move |&state| {
            Command::ALL.iter().flat_map(move |&command| {
                Answer::ALL.iter().filter_map(move |&answer| {
                    let count = self.sdo[state as usize][command as usize][answer as usize];
                    (count > 0).then_some((state, command, answer, count))
                })
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_server_does_not_have_is_not_reachable() {
        let pairs = |blocks, long_values| Coverage::sdo_pairs(SdoReach { blocks, long_values }).count();
        assert_eq!([pairs(true, true), pairs(true, false), pairs(false, true), pairs(false, false)], [109, 94, 45, 30]);
    }
}
