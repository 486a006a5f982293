//! System calls of a `CAN_RAW` socket that the crate socketcan lacks: they fetch many frames at once, each with its
//! times, the mark of own frames and the count of lost ones.
//!
//! This module calls `recvmmsg` directly: the wrapper of nix 0.31 drops the flag `MSG_CONFIRM`, which marks own frames,
//! and does not restore the length of its control buffers for the next use.
#![allow(unsafe_code)]

use canvass_traces::Timestamp;
use nix::poll::{PollFd, PollFlags, PollTimeout, poll};
use nix::sys::socket::{AddressFamily, SockFlag, SockProtocol, SockType, TimestampingFlag, setsockopt, sockopt};
use socketcan::{CanAddr, CanFilter, CanSocket, Socket, SocketOptions};
use std::io::{self, PipeReader};
use std::mem::zeroed;
use std::os::fd::{AsFd, AsRawFd};
use std::time::Duration;

/// The option in `asm-generic/socket.h`; libc and nix do not have it on all targets.
const SO_RXQ_OVFL: libc::c_int = 40;
const SO_MEMINFO: libc::c_int = 55;

/// Maximum number of frames fetched by one system call.
pub(super) const BATCH: usize = 64;
/// Length of a CAN FD frame.
const FRAME: usize = libc::CANFD_MTU;
/// Number of u64 in the space for `SCM_TIMESTAMPING` (64 bytes) and `SO_RXQ_OVFL` (24 bytes), with reserve; u64 gives
/// the alignment.
const CONTROL: usize = 32;

/// A `CAN_RAW` socket, which never blocks.
pub(super) struct RawSocket(CanSocket);

/// Identifier and mask, both with the flags of the identifier: the filter passes frames that are equal in the bits of
/// the mask.
pub(super) type Filter = (u32, u32);

/// The data that the kernel gives with a received frame.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Received {
    /// Whether this socket itself sent the frame.
    pub own: bool,
    /// The kernel's time of the frame, on the system's clock.
    pub software: Option<Timestamp>,
    /// The controller's time of the frame, on the controller's clock.
    pub hardware: Option<Timestamp>,
    /// Number of frames that this socket has lost so far, if it has lost any.
    pub dropped: Option<u32>,
}

impl RawSocket {
    /// A socket that is not bound yet.
    pub fn new() -> io::Result<Self> {
        let flags = SockFlag::SOCK_CLOEXEC | SockFlag::SOCK_NONBLOCK;
        let fd = nix::sys::socket::socket(AddressFamily::Can, SockType::Raw, flags, SockProtocol::CanRaw)?;
        Ok(Self(CanSocket::from(fd)))
    }

    /// Binds the socket to the interface with this index.
    pub fn bind(&self, index: u32) -> io::Result<()> {
        self.0.as_raw_socket().bind(&CanAddr::new(index).into_sock_addr())
    }

    /// Requests all data about frames, and also own frames, CAN FD frames and error frames.
    pub(crate) fn ask_for_all(&self) -> io::Result<()> {
        let stamps = TimestampingFlag::SOF_TIMESTAMPING_RX_SOFTWARE
            | TimestampingFlag::SOF_TIMESTAMPING_SOFTWARE
            | TimestampingFlag::SOF_TIMESTAMPING_RX_HARDWARE
            | TimestampingFlag::SOF_TIMESTAMPING_RAW_HARDWARE;
        setsockopt(&self.0, sockopt::Timestamping, &stamps)?;
        setsockopt(&self.0, sockopt::RxqOvfl, &1)?;
        self.0.set_recv_own_msgs(true)?;
        self.0.set_error_filter_accept_all()?;
        // A kernel without CAN FD does not know the option.
        let _ = self.0.set_socket_option_int(libc::SOL_CAN_RAW, libc::CAN_RAW_FD_FRAMES, 1);
        Ok(())
    }

    /// Number of frames that the kernel could not put into the receive queue since the socket was made. It includes
    /// frames lost after the last queued frame, which `SO_RXQ_OVFL` does not count; `None` on kernels before 4.12.
    pub fn dropped(&self) -> Option<u32> {
        /// The length up to the ninth number, `SK_MEMINFO_DROPS`.
        const FIGURES: usize = size_of::<[u32; 9]>();
        let mut figures = [0; FIGURES];
        let length = self.0.get_socket_option_bytes(libc::SOL_SOCKET, SO_MEMINFO, &mut figures).ok()?;
        let drops = figures.last_chunk().filter(|_| length == figures.len())?;
        Some(u32::from_ne_bytes(*drops))
    }

    /// Makes the kernel's receive queue as long as allowed, up to `bytes` bytes.
    pub(crate) fn enlarge_receive_queue(&self, bytes: i32) {
        // Only root may exceed net.core.rmem_max.
        if self.0.set_socket_option_int(libc::SOL_SOCKET, libc::SO_RCVBUFFORCE, bytes).is_err() {
            let _ = self.0.set_socket_option_int(libc::SOL_SOCKET, libc::SO_RCVBUF, bytes);
        }
    }

    /// Passes only frames that match a filter; without filters, no data frame passes.
    pub(crate) fn set_filters(&self, filters: &[Filter]) -> io::Result<()> {
        let filters: Vec<CanFilter> = filters.iter().map(|&filter| CanFilter::from(filter)).collect();
        self.0.set_filters(&filters)
    }

    /// Sends a frame of 16 or 72 bytes.
    pub fn send(&self, packet: &[u8]) -> io::Result<()> {
        self.0.as_raw_socket().send(packet).map(|_| ())
    }

    /// Waits until the socket has frames or an error, or `timeout` has passed; returns whether it has any.
    pub(crate) fn wait_readable(&self, timeout: Duration) -> io::Result<bool> {
        is_ready(&mut [PollFd::new(self.0.as_fd(), PollFlags::POLLIN)], Some(timeout))
    }

    /// Waits until the socket can take a frame or has an error, or `timeout` has passed; returns false after the
    /// timeout.
    pub(crate) fn wait_writable(&self, timeout: Duration) -> io::Result<bool> {
        is_ready(&mut [PollFd::new(self.0.as_fd(), PollFlags::POLLOUT)], Some(timeout))
    }

    /// Waits until the socket has frames or an error, the other end of the pipe is closed, or `timeout` has passed.
    /// Returns whether the socket has frames or an error.
    pub(crate) fn wait_readable_or_closed(&self, pipe: &PipeReader, timeout: Option<Duration>) -> io::Result<bool> {
        let mut polls = [PollFd::new(self.0.as_fd(), PollFlags::POLLIN), PollFd::new(pipe.as_fd(), PollFlags::POLLIN)];
        is_ready(&mut polls, timeout)?;
        let [ours, _] = polls;
        Ok(ours.any().unwrap_or(true))
    }

    /// Fetches waiting frames, at most one batch; returns their number.
    pub fn receive(&self, batch: &mut Batch) -> io::Result<usize> {
        batch.prepare();
        // SAFETY: prepare() has just pointed every header to buffers of the batch, which is borrowed until the call
        // returns and does not move.
        let received = unsafe {
            let headers = batch.headers.as_mut_ptr();
            libc::recvmmsg(self.0.as_raw_fd(), headers, BATCH as libc::c_uint, 0, std::ptr::null_mut())
        };
        if received < 0 { Err(io::Error::last_os_error()) } else { Ok(received as usize) }
    }
}

/// Waits until one of the descriptors is ready; `None` waits without limit. Returns whether one is ready.
fn is_ready(polls: &mut [PollFd<'_>], timeout: Option<Duration>) -> io::Result<bool> {
    /// Maximum duration of one poll in milliseconds; longer waits are repeated.
    const LONGEST: u16 = 60_000;
    let milliseconds = timeout.map(|timeout| u16::try_from(timeout.as_millis()).unwrap_or(LONGEST).min(LONGEST));
    Ok(poll(polls, milliseconds.map_or(PollTimeout::NONE, PollTimeout::from))? > 0)
}

/// The buffers of many frames.
pub(super) struct Batch {
    headers: Box<[libc::mmsghdr]>,
    vectors: Box<[libc::iovec]>,
    frames: Box<[[u8; FRAME]]>,
    controls: Box<[[u64; CONTROL]]>,
}

impl Batch {
    pub fn new() -> Self {
        // SAFETY: both are plain data, for which zeros are valid.
        let (header, vector) = unsafe { (zeroed::<libc::mmsghdr>(), zeroed::<libc::iovec>()) };
        Self {
            headers: vec![header; BATCH].into_boxed_slice(),
            vectors: vec![vector; BATCH].into_boxed_slice(),
            frames: vec![[0; FRAME]; BATCH].into_boxed_slice(),
            controls: vec![[0; CONTROL]; BATCH].into_boxed_slice(),
        }
    }

    fn prepare(&mut self) {
        let buffers = self.frames.iter_mut().zip(self.controls.iter_mut());
        for ((header, vector), (frame, control)) in self.headers.iter_mut().zip(self.vectors.iter_mut()).zip(buffers) {
            vector.iov_base = frame.as_mut_ptr().cast();
            vector.iov_len = FRAME;
            let header = &mut header.msg_hdr;
            header.msg_iov = &raw mut *vector;
            header.msg_iovlen = 1;
            header.msg_control = control.as_mut_ptr().cast();
            header.msg_controllen = size_of_val(control) as _;
            header.msg_flags = 0;
        }
    }

    /// The frame at this index, with the data that the kernel gives with it.
    pub fn get(&self, at: usize) -> Option<(&[u8], Received)> {
        let (header, frame) = (self.headers.get(at)?, self.frames.get(at)?);
        let len = (header.msg_len as usize).min(FRAME);
        let own = header.msg_hdr.msg_flags & libc::MSG_CONFIRM != 0;
        let mut received = Received { own, ..Received::default() };
        for_each_control(&header.msg_hdr, |level, kind, data| match (level, kind) {
            (libc::SOL_SOCKET, libc::SCM_TIMESTAMPING) => {
                received.software = data.get(..16).and_then(timestamp);
                received.hardware = data.get(32..48).and_then(timestamp);
            }
            (libc::SOL_SOCKET, SO_RXQ_OVFL) => {
                received.dropped = data.first_chunk().map(|bytes| u32::from_ne_bytes(*bytes));
            }
            _ => {}
        });
        Some((frame.get(..len)?, received))
    }
}

fn for_each_control(header: &libc::msghdr, mut visit: impl FnMut(libc::c_int, libc::c_int, &[u8])) {
    // SAFETY: the kernel has filled the header; its control buffer is aligned and lives in the batch. The macros stay
    // within it, and a message's data has the length in its header.
    unsafe {
        let mut message = libc::CMSG_FIRSTHDR(header);
        while let Some(control) = message.as_ref() {
            let data = libc::CMSG_DATA(message);
            let head = data.offset_from(message.cast()) as usize;
            let len = bytes(control.cmsg_len).saturating_sub(head);
            visit(control.cmsg_level, control.cmsg_type, std::slice::from_raw_parts(data, len));
            message = libc::CMSG_NXTHDR(header, message);
        }
    }
}

/// A length, which is `usize` in libc on some targets and `u32` on others.
fn bytes(length: impl TryInto<usize>) -> usize {
    length.try_into().unwrap_or(0)
}

/// Parses a `struct timespec` with 64-bit parts; zero means that there is no time.
fn timestamp(bytes: &[u8]) -> Option<Timestamp> {
    let seconds = i64::from_ne_bytes(*bytes.first_chunk()?);
    let nanos = i64::from_ne_bytes(*bytes.get(8..)?.first_chunk()?);
    let total = u64::try_from(seconds).ok()?.checked_mul(1_000_000_000)?.checked_add(u64::try_from(nanos).ok()?)?;
    (total > 0).then_some(Timestamp(total))
}

/// Asks the kernel to wake this thread at the exact time, not up to 50 µs later to save energy.
pub(crate) fn wake_precisely() {
    // If the kernel refuses, times are only slightly less exact.
    let _ = nix::sys::prctl::set_timerslack(1);
}

// SAFETY: the pointers in the headers are set before each use, to buffers that the batch owns.
unsafe impl Send for Batch {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_whole_or_none() {
        let bytes = |seconds: i64, nanos: i64| [seconds.to_ne_bytes(), nanos.to_ne_bytes()].concat();
        assert_eq!(timestamp(&bytes(1, 5)), Some(Timestamp(1_000_000_005)));
        assert_eq!(timestamp(&bytes(0, 0)), None);
        assert_eq!(timestamp(&bytes(-1, 0)), None);
        assert_eq!(timestamp(&bytes(i64::MAX, 0)), None);
    }
}
