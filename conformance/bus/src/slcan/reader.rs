//! The thread that reads from the adapter, and reopens it after it was unplugged.

use super::codec::{Command, Decoder, Message, MinuteClock, Status};
use super::stamps::{StampCheck, StampWatch};
use super::{Change, Shared, SlCanError};
use crate::connection::RETRY;
use crate::connection::arrival::Arrivals;
use crate::connection::link::{Link, Place, is_silence};
use crate::hardware_clock::HardwareClock;
use canvass_traces::{ChannelId, Direction, Record, Timestamp};
use std::io::{self, Read};
use std::sync::{Arc, PoisonError};
use std::time::{Duration, Instant};

/// Timeout of an answer while no command was answered yet: some programs never answer.
const PATIENCE: Duration = Duration::from_millis(300);

/// Timeout of an answer once a command was answered. It is long because a late answer would be taken for the answer to
/// the next command.
const ANSWER: Duration = Duration::from_secs(2);

/// Interval between two queries of the status flags.
const STATUS: Duration = Duration::from_secs(1);

/// Time after which a silent adapter that answers this query is regarded as lost. A TCP connection to a machine without
/// power shows no other sign for a quarter of an hour.
const GONE: Duration = Duration::from_secs(4);

pub(super) struct Reader {
    shared: Arc<Shared>,
    place: Place,
    bit_rate: Option<u8>,
    /// Whether the adapter only listens.
    listens: bool,
    port: Option<Box<dyn Read + Send>>,
    /// Time of the last received byte, or of the opening.
    heard: Instant,
    decoder: Decoder,
    minute: MinuteClock,
    hardware: HardwareClock,
    stamps: StampWatch,
    records: Vec<Record>,
    /// Whether the adapter may answer the query of its status flags.
    has_status: bool,
    /// Whether the adapter has answered the query of its status flags on this connection.
    has_told_status: bool,
    /// Whether an answer to the query of the status flags is outstanding.
    asks_status: bool,
    /// Whether the adapter has answered a command on this connection.
    has_answered: bool,
    /// Whether the adapter has answered a command on any connection.
    is_answering: bool,
}

impl Reader {
    pub fn new(shared: Arc<Shared>, place: Place, bit_rate: Option<u8>) -> Self {
        Self {
            shared,
            place,
            bit_rate,
            listens: false,
            port: None,
            heard: Instant::now(),
            decoder: Decoder::default(),
            minute: MinuteClock::default(),
            hardware: HardwareClock::default(),
            stamps: StampWatch::default(),
            records: Vec::new(),
            has_status: true,
            has_told_status: false,
            asks_status: false,
            has_answered: false,
            is_answering: false,
        }
    }

    /// Opens the connection and the adapter's channel.
    pub fn connect(&mut self) -> Result<(), SlCanError> {
        let failed = |source| SlCanError::Open { name: self.shared.name.clone(), source };
        let Link { reader, writer } = self.place.open().map_err(failed)?;
        self.port = Some(reader);
        self.heard = Instant::now();
        self.shared.way.connect(writer);
        (self.decoder, self.has_status, self.has_told_status) = (Decoder::default(), true, false);
        (self.asks_status, self.has_answered) = (false, false);
        (self.minute, self.hardware) = (MinuteClock::default(), HardwareClock::default());
        self.stamps = StampWatch::default();
        self.open_channel().inspect_err(|_| self.disconnect())?;
        self.shared.way.open();
        let now = self.shared.clock.now();
        self.shared.inbox.note(|health| health.came_back(now));
        Ok(())
    }

    fn disconnect(&mut self) {
        self.port = None;
        self.shared.way.close();
    }

    fn open_channel(&mut self) -> Result<(), SlCanError> {
        // Ends an unfinished line of another program.
        self.shared.tell(b"\r\r")?;
        self.reopen_channel()?;
        // Some adapters never answer. An adapter that answered before is not ready yet, or is lost again.
        if self.is_answering && !self.has_answered {
            return Err(self.shared.not_connected());
        }
        self.is_answering |= self.has_answered;
        Ok(())
    }

    fn reopen_channel(&mut self) -> Result<(), SlCanError> {
        // The adapter refuses this command if the channel is closed already.
        self.tell(Command::Close)?;
        let refused = |action| SlCanError::Refused { name: self.shared.name.clone(), action };
        let (rate, open) = (refused("set the bit rate"), refused("open its channel"));
        if let Some(index) = self.bit_rate
            && self.tell(Command::BitRate(index))? == Some(false)
        {
            return Err(rate);
        }
        // If the adapter refuses timestamps, frames get their time of arrival.
        self.tell(Command::Timestamps(true))?;
        let command = if self.listens { Command::Listen } else { Command::Open };
        if self.tell(command)? == Some(false) {
            return Err(open);
        }
        Ok(())
    }

    /// Opens the channel at another bit rate, or as it was if the adapter refuses.
    fn change_bit_rate(&mut self, index: u8, listens: bool) -> Result<(), SlCanError> {
        let before = (self.bit_rate.replace(index), std::mem::replace(&mut self.listens, listens));
        let changed = self.reopen_channel();
        if changed.is_err() {
            (self.bit_rate, self.listens) = before;
            self.reopen_channel()?;
        }
        changed
    }

    /// Sends a command; returns whether the adapter carried it out, or `None` without an answer.
    fn tell(&mut self, command: Command) -> Result<Option<bool>, SlCanError> {
        self.settle();
        let mut line = Vec::new();
        command.write(&mut line);
        self.shared.tell(&line)?;
        let patience = if self.has_answered { ANSWER } else { PATIENCE };
        let begun = Instant::now();
        // The answer to an outstanding query comes first.
        let mut missing = 1 + usize::from(std::mem::take(&mut self.asks_status));
        let mut answer = None;
        while missing > 0 && begun.elapsed() < patience {
            // The next read reports the loss, too.
            let Ok(messages) = self.read() else { break };
            for message in messages {
                match message {
                    Message::Done if missing > 0 => answer = Some(true),
                    Message::Refused if missing > 0 => answer = Some(false),
                    Message::Status(_) if missing > 1 => self.take(message, self.shared.clock.now()),
                    other => {
                        self.take(other, self.shared.clock.now());
                        continue;
                    }
                }
                missing -= 1;
                self.has_answered = true;
            }
        }
        Ok(answer)
    }

    /// Reads the bytes that arrived before a command, so that they are not taken for its answer.
    fn settle(&mut self) {
        for message in self.read().unwrap_or_default() {
            self.take(message, self.shared.clock.now());
        }
        self.shared.inbox.deliver(&mut self.records);
    }

    /// Reads until the bus is closed.
    pub fn run(mut self) {
        let shared = Arc::clone(&self.shared);
        let mut asked = Instant::now();
        let mut arrivals = Arrivals::of_this_thread();
        while !shared.inbox.is_closed() {
            if self.port.is_none() {
                // The adapter is not back; the next round tries again.
                if self.connect().is_err() {
                    std::thread::sleep(RETRY);
                }
                continue;
            }
            arrivals.begin();
            match self.read() {
                Ok(messages) => {
                    let arrival = arrivals.end(&shared.clock);
                    shared.inbox.set_delivering(true);
                    shared.inbox.note(|health| arrival.note(messages.len(), health));
                    for (at, message) in messages.into_iter().enumerate() {
                        self.take(message, arrival.of(at));
                    }
                    shared.inbox.deliver(&mut self.records);
                    shared.inbox.set_delivering(false);
                }
                Err(error) => self.lose(&error),
            }
            let change = shared.change.lock().unwrap_or_else(PoisonError::into_inner).take();
            if let Some(Change { index, listens, done }) = change {
                // The caller may have stopped waiting.
                let _ = done.send(self.change_bit_rate(index, listens));
            }
            if self.has_status && asked.elapsed() >= STATUS {
                asked = Instant::now();
                self.ask_status();
            }
            self.notice_loss();
        }
    }

    fn ask_status(&mut self) {
        let mut line = Vec::new();
        Command::Status.write(&mut line);
        // `notice_loss` handles a failed write.
        self.asks_status = self.shared.tell(&line).is_ok();
    }

    /// Detects losses that a read does not show: a failed write, or a silent adapter.
    fn notice_loss(&mut self) {
        if let Some(error) = self.shared.way.take_failure() {
            self.lose(&error);
        } else if self.has_told_status && self.asks_status && self.heard.elapsed() >= GONE {
            self.lose(&io::Error::new(io::ErrorKind::TimedOut, "the adapter no longer answers"));
        }
    }

    /// Reads once, for a limited time; returns the messages that are complete.
    fn read(&mut self) -> io::Result<Vec<Message>> {
        let mut bytes = [0; 4096];
        let Some(port) = &mut self.port else { return Ok(Vec::new()) };
        let mut messages = Vec::new();
        match port.read(&mut bytes) {
            Ok(0) => Err(io::ErrorKind::UnexpectedEof.into()),
            Ok(n) => {
                self.heard = Instant::now();
                self.decoder.push(bytes.get(..n).unwrap_or_default(), |message| messages.push(message));
                Ok(messages)
            }
            Err(error) if is_silence(&error) => Ok(messages),
            Err(error) => Err(error),
        }
    }

    fn take(&mut self, message: Message, arrived: Timestamp) {
        match message {
            Message::Frame { mut record, milliseconds } => {
                record.timestamp = milliseconds.map_or(arrived, |stamp| self.stamped(stamp, arrived));
                (record.channel, record.direction) = (ChannelId(0), Direction::Rx);
                self.records.push(record);
            }
            Message::Command(command) => {
                // The next read reports a failure.
                let _ = self.shared.tell(command.answer());
            }
            Message::Status(status) => {
                (self.asks_status, self.has_told_status) = (false, true);
                self.note(status);
            }
            // A refusal is most likely the answer to the query of the status flags.
            Message::Refused => (self.asks_status, self.has_status) = (false, false),
            Message::Unknown(line) if !line.is_empty() => self.shared.inbox.note(|health| health.lost += 1),
            _ => {}
        }
    }

    /// The time of a frame on the bus, by the adapter's clock while its stamps can be trusted.
    fn stamped(&mut self, milliseconds: u16, arrived: Timestamp) -> Timestamp {
        let adapter = self.minute.unwrap(milliseconds, arrived);
        match self.stamps.check(milliseconds, arrived) {
            StampCheck::Wrong(trouble) => {
                self.shared.inbox.note(|health| _ = health.stamps.get_or_insert(trouble));
                return arrived;
            }
            StampCheck::Doubtful(late) => self.shared.inbox.note(|health| health.stamping.add(late)),
            StampCheck::Right => {}
        }
        self.hardware.system_time(adapter, arrived)
    }

    /// Counts the errors in the adapter's status flags.
    fn note(&self, status: Status) {
        if status.0 == 0 {
            return;
        }
        self.shared.inbox.note(|health| {
            // The adapter does not report the number of lost frames, so a loss counts as one.
            health.lost += u64::from(status.has_lost());
            health.error_frames += 1;
            health.trouble = Some(format!("{}: {status}", self.shared.name));
        });
    }

    fn lose(&mut self, error: &io::Error) {
        self.disconnect();
        let name = &self.shared.name;
        let trouble = match error.kind() {
            io::ErrorKind::UnexpectedEof => format!("{name} was disconnected"),
            _ => format!("{name} was disconnected: {error}"),
        };
        let now = self.shared.clock.now();
        self.shared.inbox.note(|health| health.went_away(now, trouble));
    }
}
