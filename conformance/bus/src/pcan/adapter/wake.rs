//! Waits for received frames by the means of the library: an event on Windows, a file descriptor on Linux.

use super::library::{Library, Parameter};
use crate::pcan::Channel;
use std::io;
use std::time::Duration;

/// Polling interval for a channel without a signal.
const POLL: Duration = Duration::from_millis(1);

/// The signal for received frames.
pub(super) enum Wake {
    /// The system's signal.
    Signal(system::Signal),
    /// No signal: the channel is polled.
    Poll,
}

impl Wake {
    /// The signal of an open channel.
    pub fn of(library: &Library, channel: Channel) -> io::Result<Self> {
        Ok(system::Signal::of(library, channel)?.map_or(Self::Poll, Self::Signal))
    }

    /// Waits for received frames, at most for `patience`.
    pub fn wait(&self, patience: Duration) -> io::Result<()> {
        match self {
            Self::Signal(signal) => signal.wait(patience),
            Self::Poll => {
                std::thread::sleep(POLL.min(patience));
                Ok(())
            }
        }
    }
}

#[cfg(target_os = "linux")]
mod system {
    use super::{Channel, Library, Parameter};
    use nix::poll::{PollFd, PollFlags, PollTimeout, poll};
    use std::io;
    use std::os::fd::{BorrowedFd, RawFd};
    use std::time::Duration;

    /// A file descriptor that is readable while the receive queue holds frames. The library owns it.
    pub struct Signal(RawFd);

    impl Signal {
        pub fn of(library: &Library, channel: Channel) -> io::Result<Option<Self>> {
            let told = library.number(channel, Parameter::RECEIVE_EVENT).ok();
            Ok(told.and_then(|fd| RawFd::try_from(fd).ok()).filter(|fd| *fd > 0).map(Self))
        }

        #[expect(unsafe_code, reason = "the library gives a bare number")]
        pub fn wait(&self, patience: Duration) -> io::Result<()> {
            // SAFETY: the library returned this descriptor for an open channel and closes it with the channel; only
            // the receiving thread, the only caller, closes the channel. The descriptor is used for poll() only.
            let fd = unsafe { BorrowedFd::borrow_raw(self.0) };
            let patience = PollTimeout::try_from(patience).unwrap_or(PollTimeout::MAX);
            match poll(&mut [PollFd::new(fd, PollFlags::POLLIN)], patience) {
                Err(nix::Error::EINTR) | Ok(_) => Ok(()),
                Err(error) => Err(error.into()),
            }
        }
    }
}

#[cfg(windows)]
mod system {
    use super::{Channel, Library, Parameter};
    use crate::pcan::Status;
    use std::io;
    use std::os::windows::io::{AsRawHandle, FromRawHandle, OwnedHandle};
    use std::time::Duration;
    use windows_sys::Win32::Foundation::WAIT_FAILED;
    use windows_sys::Win32::System::Threading::{CreateEventW, WaitForSingleObject};

    /// An event of Windows that the library sets when something was received.
    pub struct Signal(OwnedHandle);

    impl Signal {
        pub fn of(library: &Library, channel: Channel) -> io::Result<Option<Self>> {
            let event = event()?;
            let number = event.as_raw_handle() as usize;
            let told = library.set(channel, Parameter::RECEIVE_EVENT, &number.to_ne_bytes());
            Ok((told == Status::OK).then_some(Self(event)))
        }

        #[expect(unsafe_code, reason = "the standard library has no events")]
        pub fn wait(&self, patience: Duration) -> io::Result<()> {
            let millis = u32::try_from(patience.as_millis()).unwrap_or(u32::MAX - 1);
            // SAFETY: the handle is that of an event, which lives as long as `self`.
            let ended = unsafe { WaitForSingleObject(self.0.as_raw_handle(), millis) };
            if ended == WAIT_FAILED { Err(io::Error::last_os_error()) } else { Ok(()) }
        }
    }

    #[expect(unsafe_code, reason = "the standard library has no events")]
    fn event() -> io::Result<OwnedHandle> {
        // SAFETY: null is allowed for attributes and name; 0, 0 make an event that resets itself and is not set.
        let handle = unsafe { CreateEventW(std::ptr::null(), 0, 0, std::ptr::null()) };
        if handle.is_null() {
            return Err(io::Error::last_os_error());
        }
        // SAFETY: the handle was just created, and this value is its only owner.
        Ok(unsafe { OwnedHandle::from_raw_handle(handle) })
    }
}
