//! The tester's side of the protocols, as state machines without I/O and clock: a bench drives them in
//! cases, [`Exchange`] in commands.

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

/// A message of eight bytes as it goes over the bus. In a block transfer only the state of the transfer tells segments
/// from commands.
pub type Message = [u8; 8];

/// What a client of a block transfer does after a message.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum BlockStep {
    /// Nothing: more messages of the server follow.
    Wait,
    /// Send these, one after the other, and wait.
    Send(Vec<Message>),
    /// The transfer is over.
    Done(Outcome),
    /// Send these, and then the transfer is over.
    Finish(Vec<Message>, Outcome),
}

/// A client of a block transfer.
pub trait BlockTransfer {
    /// The request that begins it.
    fn begin(&mut self) -> Message;

    /// Takes a message of the server.
    fn handle(&mut self, message: Message) -> BlockStep;

    /// The object of the transfer.
    fn multiplexer(&self) -> canvass_analyzer::Multiplexer;

    /// Whether the next message of the server is a segment of a block, which has no command specifier.
    fn awaits_segment(&self) -> bool {
        false
    }
}
