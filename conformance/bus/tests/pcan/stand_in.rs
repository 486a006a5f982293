//! The stand-in for PEAK's library, built by the C compiler. Tests tell the stand-in the events on the bus.
#![allow(unsafe_code, reason = "functions of a library in C")]

use canvass_bus::pcan::{Channel, Opening, Pcan, PcanError};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;

/// A message in the layout of `TPCANMsg`.
#[repr(C)]
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Message {
    pub id: u32,
    pub kind: u8,
    pub length: u8,
    pub data: [u8; 8],
}

/// The functions whose answer a test can set.
#[derive(Clone, Copy)]
pub enum Function {
    Initialize,
    Read,
    Write,
    GetStatus,
}

/// One channel of the stand-in. Tests that run at the same time use different channels.
pub struct StandIn {
    library: libloading::Library,
    pub channel: Channel,
}

/// The library. Each process builds it once with the C compiler; for tests under Wine it is built beforehand.
static FILE: LazyLock<PathBuf> = LazyLock::new(|| {
    if cfg!(windows) {
        return Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/windows/PCANBasic.dll");
    }
    let source = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/pcan/stand_in.c");
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("libpcanbasic-{}.so", std::process::id()));
    let built = Command::new("cc").args(["-shared", "-fPIC", "-o"]).arg(&file).args([source, "-lpthread"]).status();
    assert!(built.unwrap().success(), "the stand-in is built");
    file
});

impl StandIn {
    /// A channel to which an adapter is plugged in.
    pub fn plugged(number: u16) -> Self {
        let channel = format!("PCAN_USBBUS{number}").parse().unwrap();
        // SAFETY: the library was just built, and has no initialisation that runs when it is loaded.
        let stand_in = Self { library: unsafe { libloading::Library::new(&*FILE) }.unwrap(), channel };
        stand_in.plug(1);
        stand_in
    }

    pub fn open(&self, bit_rate: u32) -> Result<Pcan, PcanError> {
        self.open_as(Opening { channel: self.channel, bit_rate, listen_only: false })
    }

    pub fn open_as(&self, opening: Opening) -> Result<Pcan, PcanError> {
        Pcan::open_with(&FILE, opening)
    }

    /// Sets the adapter: 0: absent, 1: present, 2: in use by another program.
    pub fn plug(&self, to: u32) {
        self.tell(b"stand_in_plug", to);
    }

    /// Sets the state of the bus, as bits of the status.
    pub fn bus(&self, status: u32) {
        self.tell(b"stand_in_bus", status);
    }

    /// Sets whether sent frames stay in the transmit queue.
    pub fn hold(&self, holds: bool) {
        self.tell(b"stand_in_hold", u32::from(holds));
    }

    fn tell(&self, function: &[u8], value: u32) {
        // SAFETY: stand_in.c defines the function with this signature.
        unsafe {
            let function: libloading::Symbol<'_, unsafe extern "C" fn(u16, u32)> = self.library.get(function).unwrap();
            function(self.channel.handle(), value);
        }
    }

    /// Sets the answer of a function from now on; 0 restores its normal answer.
    pub fn answer(&self, function: Function, status: u32) {
        // SAFETY: stand_in.c defines the function with this signature.
        unsafe {
            let answer: libloading::Symbol<'_, unsafe extern "C" fn(u16, u32, u32)> =
                self.library.get(b"stand_in_answer").unwrap();
            answer(self.channel.handle(), function as u32, status);
        }
    }

    /// Makes `times` messages arrive, a millisecond apart, the first at `micros` on the adapter's clock.
    pub fn receive(&self, message: Message, micros: u64, times: u32) {
        // SAFETY: stand_in.c defines the function with this signature.
        unsafe {
            let receive: libloading::Symbol<'_, unsafe extern "C" fn(u16, *const Message, u64, u32)> =
                self.library.get(b"stand_in_receive").unwrap();
            receive(self.channel.handle(), &raw const message, micros, times);
        }
    }

    /// The sent messages, in order.
    pub fn sent(&self) -> Vec<Message> {
        let mut message = Message::default();
        // SAFETY: stand_in.c defines the function with this signature.
        let mut sent = |number| unsafe {
            let sent: libloading::Symbol<'_, unsafe extern "C" fn(u16, u32, *mut Message) -> u32> =
                self.library.get(b"stand_in_sent").unwrap();
            (sent(self.channel.handle(), number, &raw mut message), message)
        };
        let (count, _) = sent(0);
        (0..count).map(|number| sent(number).1).collect()
    }

    /// The registers with which the channel is open, whether it only listens, and how often it was opened; `None` if it
    /// is closed.
    pub fn open_with(&self) -> Option<(u16, bool, u32)> {
        // SAFETY: stand_in.c defines the function with this signature.
        let told = unsafe {
            let open: libloading::Symbol<'_, unsafe extern "C" fn(u16) -> u32> =
                self.library.get(b"stand_in_open").unwrap();
            open(self.channel.handle())
        };
        let [low, high, ..] = told.to_le_bytes();
        (told != u32::MAX).then_some((u16::from_le_bytes([low, high]), told & 1 << 16 != 0, told >> 17))
    }
}
