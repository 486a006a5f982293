//! The adapter's end of SLCAN over TCP: programs connect to it, and form one bus with this program and each other.

use super::codec::{Decoder, Message, write_frame};
use super::{SlCanError, frame_line};
use crate::clock::SteadyClock;
use crate::connection::arrival::Arrivals;
use crate::connection::link::{self, LOOK, Link};
use crate::connection::way::Way;
use crate::inbox::{Inbox, receives_by_inbox};
use crate::{Bus, BusError};
use canvass_traces::{ChannelId, Direction, Frame};
use std::io::Read;
use std::net::TcpListener;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{Builder, JoinHandle};

/// Maximum number of programs at a time.
const MOST: usize = 64;

/// A bus that other programs connect to.
pub struct SlCanHub {
    shared: Arc<Shared>,
    acceptor: Option<JoinHandle<()>>,
    bit_rate: Option<u32>,
}

/// State shared by the bus, the thread that accepts programs, and one thread for each program.
struct Shared {
    name: String,
    clock: SteadyClock,
    inbox: Inbox,
    /// The connected programs. Whoever puts a frame on the bus holds the lock until all others have it, so that all see
    /// the frames in the same order.
    programs: Mutex<Vec<Arc<Way>>>,
}

impl SlCanHub {
    /// Waits for programs at `host:port`, or at `port` for programs on this machine only. The protocol has no
    /// passwords: every program that connects can use the bus. `name` is the name of the bus in messages.
    ///
    /// # Errors
    /// [`SlCanError::Open`] with a remedy.
    pub fn listen(name: &str, address: &str, bit_rate: Option<u32>) -> Result<Self, SlCanError> {
        let failed = |source| SlCanError::Open { name: name.to_owned(), source };
        let listener = link::listen(address).map_err(failed)?;
        let shared = Arc::new(Shared {
            name: name.to_owned(),
            clock: SteadyClock::start(),
            inbox: Inbox::new(),
            programs: Mutex::default(),
        });
        let accepts = Arc::clone(&shared);
        let acceptor = Builder::new().name(format!("accept {name}")).spawn(move || accept(&accepts, &listener));
        Ok(Self { shared, acceptor: Some(acceptor.map_err(failed)?), bit_rate })
    }
}

/// Accepts programs until the bus is closed.
fn accept(shared: &Arc<Shared>, listener: &TcpListener) {
    let mut threads: Vec<JoinHandle<()>> = Vec::new();
    while !shared.inbox.is_closed() {
        threads.retain(|thread| !thread.is_finished());
        match link::accept(listener) {
            Ok(Some(link)) if threads.len() < MOST => threads.extend(serve(shared, link)),
            // The program finds its connection closed.
            Ok(Some(_)) => shared.note(&format!("a program was refused: {MOST} programs are connected")),
            Ok(None) | Err(_) => std::thread::sleep(LOOK),
        }
    }
    for thread in threads {
        // A panic of the thread does not matter any more.
        let _ = thread.join();
    }
}

/// Connects a program to the bus; its thread begins to read. `None` if the system has no thread for it.
fn serve(shared: &Arc<Shared>, link: Link) -> Option<JoinHandle<()>> {
    let way = Arc::new(Way::default());
    way.connect(link.writer);
    way.open();
    // A program that leaves at once is taken off the bus after it was put on it: its thread waits for the lock.
    let mut programs = shared.programs();
    let program = Program { shared: Arc::clone(shared), way: Arc::clone(&way), reader: link.reader };
    match Builder::new().name(format!("receive {}", shared.name)).spawn(move || program.run()) {
        Ok(thread) => {
            programs.push(way);
            let now = shared.clock.now();
            shared.inbox.note(|health| health.came_back(now));
            Some(thread)
        }
        Err(error) => {
            shared.note(&format!("a program was refused: {error}"));
            None
        }
    }
}

impl Shared {
    fn programs(&self) -> MutexGuard<'_, Vec<Arc<Way>>> {
        self.programs.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Notes trouble that does not interrupt the bus.
    fn note(&self, trouble: &str) {
        self.inbox.note(|health| health.trouble = Some(format!("{}: {trouble}", self.name)));
    }

    /// Takes a program off the bus. The bus is interrupted if it was the only one.
    fn remove(&self, way: &Arc<Way>, trouble: String) {
        let mut programs = self.programs();
        programs.retain(|known| !Arc::ptr_eq(known, way));
        if programs.is_empty() {
            let now = self.clock.now();
            self.inbox.note(|health| health.went_away(now, trouble));
        }
    }
}

/// Writes a frame to all programs but its sender; returns the number of programs that have taken it. A program that
/// takes nothing more is noticed by its thread.
fn spread(programs: &[Arc<Way>], sender: Option<&Arc<Way>>, line: &[u8]) -> usize {
    let others = programs.iter().filter(|way| sender.is_none_or(|sender| !Arc::ptr_eq(way, sender)));
    others.filter(|way| way.send(line).is_ok()).count()
}

/// A connected program.
struct Program {
    shared: Arc<Shared>,
    way: Arc<Way>,
    reader: Box<dyn Read + Send>,
}

impl Program {
    /// Reads from the program until it leaves, or the bus is closed.
    fn run(mut self) {
        let shared = Arc::clone(&self.shared);
        let (mut decoder, mut arrivals) = (Decoder::default(), Arrivals::of_this_thread());
        let mut bytes = [0; 4096];
        while !shared.inbox.is_closed() {
            let mut messages = Vec::new();
            arrivals.begin();
            let trouble = match self.reader.read(&mut bytes) {
                Ok(0) => Some("a program was disconnected".to_owned()),
                Ok(n) => {
                    decoder.push(bytes.get(..n).unwrap_or_default(), |message| messages.push(message));
                    None
                }
                Err(error) if link::is_silence(&error) => None,
                Err(error) => Some(format!("a program was disconnected: {error}")),
            };
            self.take(messages, &mut arrivals);
            let unread = || self.way.take_failure().map(|_| "a program did not read its frames".to_owned());
            if let Some(trouble) = trouble.or_else(unread) {
                shared.remove(&self.way, format!("{}: {trouble}", shared.name));
                return;
            }
        }
        self.way.close();
    }

    /// Puts the frames of one read on the bus, and answers commands.
    fn take(&self, messages: Vec<Message>, arrivals: &mut Arrivals) {
        let shared = &*self.shared;
        let arrival = arrivals.end(&shared.clock);
        if messages.is_empty() {
            return;
        }
        let programs = shared.programs();
        shared.inbox.set_delivering(true);
        shared.inbox.note(|health| arrival.note(messages.len(), health));
        let mut records = Vec::new();
        for (at, message) in messages.into_iter().enumerate() {
            match message {
                Message::Frame { mut record, .. } => {
                    record.timestamp = arrival.of(at);
                    (record.channel, record.direction) = (ChannelId(0), Direction::Rx);
                    let mut line = Vec::new();
                    if write_frame(&record, &mut line).is_some() {
                        spread(&programs, Some(&self.way), &line);
                    }
                    records.push(record);
                }
                // The next round reports a failure.
                Message::Command(command) => _ = self.way.tell(command.answer()),
                Message::Unknown(line) if !line.is_empty() => shared.inbox.note(|health| health.lost += 1),
                _ => {}
            }
        }
        shared.inbox.deliver(&mut records);
        shared.inbox.set_delivering(false);
    }
}

impl Bus for SlCanHub {
    receives_by_inbox!();

    fn send(&mut self, frame: &Frame) -> Result<(), BusError> {
        let shared = &*self.shared;
        let (record, line) = frame_line(self.now(), frame)?;
        let programs = shared.programs();
        shared.inbox.send(&record, &shared.clock, || match spread(&programs, None, &line) {
            0 => Err(SlCanError::Nobody { name: shared.name.clone() }.into()),
            _ => Ok(()),
        })
    }

    fn bit_rate(&self) -> Option<u32> {
        self.bit_rate
    }

    fn wait_for_client(&mut self, patience: canvass_traces::Duration) -> Result<(), BusError> {
        let deadline = self.now() + patience;
        while self.shared.programs().is_empty() {
            if self.now() >= deadline {
                return Err(SlCanError::NoClient { name: self.shared.name.clone(), waited: patience }.into());
            }
            std::thread::sleep(LOOK);
        }
        Ok(())
    }

    /// The programs set the bit rate, which has no effect on the connection.
    fn set_bit_rate(&mut self, bit_rate: u32) -> Result<(), BusError> {
        Err(BusError::FixedBitRate { bit_rate })
    }
}

impl Drop for SlCanHub {
    fn drop(&mut self) {
        self.shared.inbox.close();
        if let Some(acceptor) = self.acceptor.take() {
            // A panic of the thread does not matter any more.
            let _ = acceptor.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::SlCan;
    use super::*;
    use canvass_traces::{CanId, Duration, Record};
    use std::io::Write;
    use std::net::TcpStream;

    fn frame(n: u32) -> Frame {
        Frame::new(CanId::standard(n).unwrap(), &n.to_le_bytes()).unwrap()
    }

    /// A hub at a free port of this machine, and its address.
    fn hub() -> (SlCanHub, String) {
        // The port is free again once this listener is gone.
        let address = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string();
        (SlCanHub::listen(&format!("listen://{address}"), &address, None).unwrap(), address)
    }

    fn program(address: &str) -> SlCan {
        SlCan::open(&format!("tcp://{address}"), Some(250_000)).unwrap()
    }

    fn received(bus: &mut dyn Bus, count: usize) -> Vec<(u32, Direction)> {
        let deadline = bus.now() + Duration::from_secs(10);
        let mut all = Vec::new();
        while all.len() < count {
            let Some(record) = bus.receive(deadline).unwrap() else { break };
            all.push((record.frame.id().raw(), record.direction));
        }
        all
    }

    fn until(hub: &SlCanHub, is_so: impl Fn(&SlCanHub) -> bool) {
        let end = hub.now() + Duration::from_secs(10);
        while !is_so(hub) {
            assert!(hub.now() < end, "{:?}", hub.health());
            std::thread::yield_now();
        }
    }

    #[test]
    fn a_program_and_the_hub_are_one_bus_and_survive_a_break() {
        let (mut hub, address) = hub();
        let nobody = hub.send(&frame(1)).unwrap_err();
        assert!(nobody.to_string().contains("no program is connected") && nobody.is_interruption(), "{nobody}");
        for round in 0..2 {
            let mut program = program(&address);
            program.send(&frame(0x100)).unwrap();
            assert_eq!(received(&mut hub, 1), [(0x100, Direction::Rx)], "round {round}");
            hub.send(&frame(0x200)).unwrap();
            assert_eq!(received(&mut hub, 1), [(0x200, Direction::Tx)]);
            assert_eq!(received(&mut program, 2), [(0x100, Direction::Tx), (0x200, Direction::Rx)]);
            drop(program);
            until(&hub, |hub| hub.health().interruptions == round + 1);
            assert!(hub.is_interrupted());
        }
    }

    #[test]
    fn several_programs_see_each_other_in_one_order() {
        let (mut hub, address) = hub();
        let mut programs = [program(&address), program(&address), program(&address)];
        until(&hub, |hub| hub.shared.programs().len() == 3);
        for (n, program) in (1..).zip(&mut programs) {
            program.send(&frame(n)).unwrap();
            assert_eq!(received(&mut hub, 1), [(n, Direction::Rx)]);
        }
        hub.send(&frame(4)).unwrap();
        for (own, program) in (1..).zip(&mut programs) {
            let expected: Vec<(u32, Direction)> =
                (1..=4).map(|n| (n, if n == own { Direction::Tx } else { Direction::Rx })).collect();
            let mut seen = received(program, 4);
            // The own frame stands where it was sent, which may be before frames on their way.
            seen.sort_unstable_by_key(|(n, _)| *n);
            assert_eq!(seen, expected);
        }
        let [first, ..] = programs;
        drop(first);
        until(&hub, |hub| hub.shared.programs().len() == 2);
        assert_eq!((hub.health().interruptions, hub.is_interrupted()), (0, false), "two programs are left");
    }

    #[test]
    fn who_waits_for_a_client_is_told_when_none_comes() {
        let (mut hub, address) = hub();
        let error = hub.wait_for_client(Duration::from_millis(50)).unwrap_err().to_string();
        assert!(error.contains("no program has connected to listen://127.0.0.1"), "{error}");
        let client = std::thread::spawn(move || {
            std::thread::sleep(std::time::Duration::from_millis(100));
            TcpStream::connect(address).unwrap()
        });
        hub.wait_for_client(Duration::from_secs(10)).unwrap();
        hub.send(&frame(1)).unwrap();
        drop(client.join().unwrap());
    }

    /// A program that connects and neither sends nor reads does not keep others from the bus.
    #[test]
    fn a_program_that_does_not_read_is_taken_off_the_bus() {
        let (mut hub, address) = hub();
        let deaf = TcpStream::connect(&address).unwrap();
        let mut talks = TcpStream::connect(&address).unwrap();
        until(&hub, |hub| hub.shared.programs().len() == 2);
        let mut reads = talks.try_clone().unwrap();
        let reader = std::thread::spawn(move || while reads.read(&mut [0; 1 << 16]).is_ok_and(|n| n > 0) {});
        let end = hub.now() + Duration::from_secs(60);
        while hub.shared.programs().len() == 2 {
            assert!(hub.now() < end);
            hub.send(&frame(1)).unwrap();
        }
        talks.write_all(b"t12310F\r").unwrap();
        let from_the_other = |record: Record| record.frame.id().raw() == 0x123 && record.direction == Direction::Rx;
        let deadline = hub.now() + Duration::from_secs(30);
        while !from_the_other(hub.receive(deadline).unwrap().expect("the frame of the program that reads")) {}
        drop((deaf, talks));
        drop(hub);
        reader.join().unwrap();
    }

    /// Whoever comes and goes at once leaves nothing behind.
    #[test]
    fn programs_that_leave_at_once_are_off_the_bus() {
        let (mut hub, address) = hub();
        for _ in 0..50 {
            drop(TcpStream::connect(&address).unwrap());
        }
        let mut last = program(&address);
        last.send(&frame(7)).unwrap();
        assert_eq!(received(&mut hub, 1), [(7, Direction::Rx)]);
        until(&hub, |hub| hub.shared.programs().len() == 1);
        drop(last);
        until(&hub, |hub| hub.shared.programs().is_empty() && hub.is_interrupted());
    }

    #[test]
    fn the_hub_does_not_set_a_bit_rate() {
        let (mut hub, _) = hub();
        assert!(matches!(hub.set_bit_rate(500_000), Err(BusError::FixedBitRate { bit_rate: 500_000 })));
    }
}
