//! The tester's side of the protocols, as state machines without I/O and clock: cases use them through the bench,
//! commands through [`Exchange`].

pub mod block_download;
pub mod block_upload;
mod exchange;
mod limit;
pub mod lss;
pub mod sdo;
mod surveyor;

pub use block_download::BlockDownload;
pub use block_upload::BlockUpload;
pub use exchange::Exchange;
pub use limit::{Bound, Excess, UploadLimit};
pub use sdo::{Outcome, Reaction, ServerLine, Transfer, Violation};
pub use surveyor::{SurveyError, Surveyor};

/// The eight bytes of a message. In a block transfer only the state of the transfer distinguishes segments from
/// commands.
pub type Message = [u8; 8];

/// The reaction of a block transfer's client to a message.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum BlockStep {
    /// Wait for further messages of the server.
    Wait,
    /// Send these messages, one after the other, and wait for further messages.
    Send(Vec<Message>),
    /// The transfer has ended.
    Done(Outcome),
    /// Send these messages; then the transfer has ended.
    Finish(Vec<Message>, Outcome),
}

/// A client of a block transfer.
pub trait BlockTransfer {
    /// The request that begins the transfer.
    fn begin(&mut self) -> Message;

    /// Handles a message of the server.
    fn handle(&mut self, message: Message) -> BlockStep;

    /// The object of the transfer.
    fn multiplexer(&self) -> canvass_analyzer::Multiplexer;

    /// Whether the next message of the server is a segment of a block, which has no command specifier.
    fn awaits_segment(&self) -> bool {
        false
    }
}
