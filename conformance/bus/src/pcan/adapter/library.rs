//! PEAK's library, loaded on demand: the functions of `PCANBasic.h` that a bus needs. Only this module calls them.
//!
//! The library is loaded from the usual places of the system: on Windows from the program's folder and the system's
//! folder, never from the working directory, where any user may have put a file.
#![expect(unsafe_code, reason = "functions of a library in C")]

use super::message::{Message, Stamp};
use crate::pcan::Channel;
use crate::pcan::PcanError;
use crate::pcan::Status;
use std::ffi::c_void;
use std::path::Path;

/// A parameter of a channel.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Parameter(u8);

impl Parameter {
    pub(crate) const RECEIVE_EVENT: Self = Self(0x03);
    pub(crate) const API_VERSION: Self = Self(0x05);
    pub(crate) const BUS_OFF_RESET: Self = Self(0x07);
    pub const LISTEN_ONLY: Self = Self(0x08);
    pub(crate) const CONDITION: Self = Self(0x0D);
    pub(crate) const HARDWARE_NAME: Self = Self(0x0E);
    pub(crate) const ALLOW_STATUS_FRAMES: Self = Self(0x1E);
    pub(crate) const ALLOW_ERROR_FRAMES: Self = Self(0x20);
}

/// The value of a parameter that is switched on.
const ON: u32 = 1;

/// PEAK's library, loaded.
pub(super) struct Library {
    initialize: Initialize,
    uninitialize: Handle,
    status: Handle,
    read: Read,
    write: Write,
    get_value: Value,
    set_value: Value,
    /// Keeps the functions loaded, so it is the last field that is dropped.
    _loaded: libloading::Library,
}

type Initialize = unsafe extern "system" fn(u16, u16, u8, u32, u16) -> u32;
type Handle = unsafe extern "system" fn(u16) -> u32;
type Read = unsafe extern "system" fn(u16, *mut Message, *mut Stamp) -> u32;
type Write = unsafe extern "system" fn(u16, *mut Message) -> u32;
type Value = unsafe extern "system" fn(u16, u8, *mut c_void, u32) -> u32;

/// The file names of the library on this system.
#[cfg(windows)]
const NAMES: [&str; 1] = ["PCANBasic.dll"];
#[cfg(not(windows))]
const NAMES: [&str; 2] = ["libpcanbasic.so", "libpcanbasic.so.0"];

impl Library {
    /// Loads the installed library.
    pub fn installed() -> Result<Self, PcanError> {
        let mut failure = None;
        for name in NAMES {
            match load(Path::new(name)) {
                Ok(loaded) => return Self::of(loaded, name),
                Err(error) => failure = failure.or(Some((name, error))),
            }
        }
        let (name, reason) = failure.map_or((NAMES[0], String::new()), |(name, error)| (name, told(&error)));
        Err(PcanError::NoLibrary { name: name.to_owned(), reason })
    }

    /// Loads the library in this file.
    pub fn at(file: &Path) -> Result<Self, PcanError> {
        let name = file.display().to_string();
        match load(file) {
            Ok(loaded) => Self::of(loaded, &name),
            Err(error) => Err(PcanError::NoLibrary { name, reason: told(&error) }),
        }
    }

    fn of(loaded: libloading::Library, name: &str) -> Result<Self, PcanError> {
        let lacks = |function| {
            move |error: libloading::Error| PcanError::OldLibrary {
                name: name.to_owned(),
                function,
                reason: told(&error),
            }
        };
        // SAFETY: PCANBasic.h declares these types for these names, with `__stdcall` where it differs from C's
        // convention. The functions are kept together with the library.
        unsafe {
            Ok(Self {
                initialize: *loaded.get(b"CAN_Initialize").map_err(lacks("CAN_Initialize"))?,
                uninitialize: *loaded.get(b"CAN_Uninitialize").map_err(lacks("CAN_Uninitialize"))?,
                status: *loaded.get(b"CAN_GetStatus").map_err(lacks("CAN_GetStatus"))?,
                read: *loaded.get(b"CAN_Read").map_err(lacks("CAN_Read"))?,
                write: *loaded.get(b"CAN_Write").map_err(lacks("CAN_Write"))?,
                get_value: *loaded.get(b"CAN_GetValue").map_err(lacks("CAN_GetValue"))?,
                set_value: *loaded.get(b"CAN_SetValue").map_err(lacks("CAN_SetValue"))?,
                _loaded: loaded,
            })
        }
    }

    /// Opens a channel with the given registers for the bit rate. The other three arguments of the library's function
    /// are for cards without automatic detection.
    pub fn initialize(&self, channel: Channel, registers: u16) -> Status {
        // SAFETY: the function is called as declared; all arguments are numbers.
        Status(unsafe { (self.initialize)(channel.handle(), registers, 0, 0, 0) })
    }

    /// Closes a channel, whether it is open or not.
    pub(crate) fn uninitialize(&self, channel: Channel) -> Status {
        // SAFETY: the function is called as declared; the argument is a number.
        Status(unsafe { (self.uninitialize)(channel.handle()) })
    }

    /// The library's status of a channel's bus.
    pub fn status(&self, channel: Channel) -> Status {
        // SAFETY: the function is called as declared; the argument is a number.
        Status(unsafe { (self.status)(channel.handle()) })
    }

    /// The next message of the receive queue, if the library has written one.
    pub fn read(&self, channel: Channel) -> (Status, Message, Stamp) {
        let (mut message, mut stamp) = (Message::UNTOUCHED, Stamp::default());
        // SAFETY: both structures have the layout that the library writes, and live until the call returns.
        let status = unsafe { (self.read)(channel.handle(), &raw mut message, &raw mut stamp) };
        (Status(status), message, stamp)
    }

    /// Puts a message into the transmit queue.
    pub fn write(&self, channel: Channel, mut message: Message) -> Status {
        // SAFETY: the message has the layout that the library reads, and lives until the call returns.
        Status(unsafe { (self.write)(channel.handle(), &raw mut message) })
    }

    /// Fills a buffer with a parameter's value.
    fn get(&self, channel: Channel, parameter: Parameter, buffer: &mut [u8]) -> Status {
        let length = u32::try_from(buffer.len()).unwrap_or(u32::MAX);
        // SAFETY: the library writes at most `length` bytes, the length of the buffer.
        Status(unsafe { (self.get_value)(channel.handle(), parameter.0, buffer.as_mut_ptr().cast(), length) })
    }

    pub fn number(&self, channel: Channel, parameter: Parameter) -> Result<u32, Status> {
        let mut bytes = [0; 4];
        match self.get(channel, parameter, &mut bytes) {
            Status::OK => Ok(u32::from_ne_bytes(bytes)),
            status => Err(status),
        }
    }

    /// The value of a text parameter, up to its terminating zero.
    pub fn text(&self, channel: Channel, parameter: Parameter) -> Option<String> {
        let mut bytes = [0; 256];
        let text = (self.get(channel, parameter, &mut bytes) == Status::OK).then_some(&bytes[..])?;
        let text = text.split(|&byte| byte == 0).next().unwrap_or_default();
        (!text.is_empty()).then(|| String::from_utf8_lossy(text).into_owned())
    }

    /// Sets a parameter.
    pub fn set(&self, channel: Channel, parameter: Parameter, value: &[u8]) -> Status {
        let mut value = value.to_vec();
        let length = u32::try_from(value.len()).unwrap_or(u32::MAX);
        // SAFETY: the library reads `length` bytes, the length of the buffer; if it wrote them, no other code would use
        // them.
        Status(unsafe { (self.set_value)(channel.handle(), parameter.0, value.as_mut_ptr().cast(), length) })
    }

    /// Switches a parameter on.
    pub fn switch_on(&self, channel: Channel, parameter: Parameter) -> Status {
        self.set(channel, parameter, &ON.to_ne_bytes())
    }
}

#[cfg(windows)]
fn load(file: &Path) -> Result<libloading::Library, libloading::Error> {
    use libloading::os::windows::{LOAD_LIBRARY_SEARCH_DEFAULT_DIRS, LOAD_WITH_ALTERED_SEARCH_PATH, Library as Loaded};
    let flags = if file.is_absolute() { LOAD_WITH_ALTERED_SEARCH_PATH } else { LOAD_LIBRARY_SEARCH_DEFAULT_DIRS };
    // SAFETY: loading runs the library's initialisation, as in every program that uses PEAK's library.
    unsafe { Loaded::load_with_flags(file, flags) }.map(Into::into)
}

#[cfg(not(windows))]
fn load(file: &Path) -> Result<libloading::Library, libloading::Error> {
    // SAFETY: loading runs the library's initialisation, as in every program that uses PEAK's library.
    unsafe { libloading::Library::new(file) }
}

/// The text of an error and its cause, which contains the system's own text.
fn told(error: &libloading::Error) -> String {
    match std::error::Error::source(error) {
        Some(source) => format!("{error}: {source}"),
        None => error.to_string(),
    }
}
