//! The system calls of a `CAN_RAW` socket.
//!
//! They are made directly because neither nix nor socketcan shows what is needed here: the flag `MSG_CONFIRM`, by which
//! own frames are told from others', and the count of `SO_RXQ_OVFL`.
#![allow(unsafe_code)]

use canvass_traces::Timestamp;
use std::io::{self, PipeReader};
use std::mem::{size_of, zeroed};
use std::os::fd::{AsRawFd, FromRawFd, OwnedFd, RawFd};
use std::time::Duration;

/// The options and levels of `linux/can/raw.h`, which libc does not have on all targets.
const SOL_CAN_RAW: libc::c_int = 101;
const CAN_RAW: libc::c_int = 1;
const CAN_RAW_FILTER: libc::c_int = 1;
const CAN_RAW_ERR_FILTER: libc::c_int = 2;
const CAN_RAW_RECV_OWN_MSGS: libc::c_int = 4;
const CAN_RAW_FD_FRAMES: libc::c_int = 5;
const SO_RXQ_OVFL: libc::c_int = 40;
/// All classes of error frames.
const ALL_ERRORS: u32 = 0x1FFF_FFFF;

/// Frames that are fetched by one system call.
pub(super) const BATCH: usize = 64;
/// A CAN FD frame, `CANFD_MTU`.
const FRAME: usize = 72;
/// Room for `SCM_TIMESTAMPING` (64 bytes) and `SO_RXQ_OVFL` (24), in u64 for their alignment.
const CONTROL: usize = 32;

/// A `CAN_RAW` socket, which never blocks.
pub(super) struct RawSocket(OwnedFd);

/// Lets frames pass whose identifier, with its flags, equals `id` where `mask` has ones.
#[repr(C)]
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Filter {
    pub id: u32,
    pub mask: u32,
}

/// What came with a frame.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Received {
    /// Sent by this socket itself.
    pub own: bool,
    /// By the kernel, on the system's clock.
    pub software: Option<Timestamp>,
    /// By the controller, on a clock of its own.
    pub hardware: Option<Timestamp>,
    /// How many frames this socket has lost so far, if any.
    pub dropped: Option<u32>,
}

impl RawSocket {
    /// A socket that is not bound yet.
    pub fn new() -> io::Result<Self> {
        let kind = libc::SOCK_RAW | libc::SOCK_CLOEXEC | libc::SOCK_NONBLOCK;
        // SAFETY: no pointers are passed; the descriptor is new and owned by nobody else.
        unsafe {
            let fd = libc::socket(libc::AF_CAN, kind, CAN_RAW);
            if fd < 0 { Err(io::Error::last_os_error()) } else { Ok(Self(OwnedFd::from_raw_fd(fd))) }
        }
    }

    fn fd(&self) -> RawFd {
        self.0.as_raw_fd()
    }

    /// Binds the socket to the interface of that index.
    pub fn bind(&self, index: u32) -> io::Result<()> {
        // SAFETY: sockaddr_can is plain data, for which zeros are valid; the kernel reads its size at most.
        unsafe {
            let mut address: libc::sockaddr_can = zeroed();
            address.can_family = libc::AF_CAN as libc::sa_family_t;
            address.can_ifindex = index as libc::c_int;
            let size = size_of::<libc::sockaddr_can>() as libc::socklen_t;
            check(libc::bind(self.fd(), (&raw const address).cast(), size))
        }
    }

    /// Asks for everything that is known of a frame, and for own frames, CAN FD frames and error frames.
    pub fn ask_for_all(&self) -> io::Result<()> {
        let stamps = libc::SOF_TIMESTAMPING_RX_SOFTWARE
            | libc::SOF_TIMESTAMPING_SOFTWARE
            | libc::SOF_TIMESTAMPING_RX_HARDWARE
            | libc::SOF_TIMESTAMPING_RAW_HARDWARE;
        self.set(libc::SOL_SOCKET, libc::SO_TIMESTAMPING, &stamps)?;
        self.set(libc::SOL_SOCKET, SO_RXQ_OVFL, &1_i32)?;
        self.set(SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS, &1_i32)?;
        self.set(SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &ALL_ERRORS)?;
        // A kernel without CAN FD does not know it.
        let _ = self.set(SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &1_i32);
        Ok(())
    }

    /// How many frames the kernel could not put into the receive queue since the socket was made, those after the last
    /// one that it could included, of which `SO_RXQ_OVFL` never tells; `None` on kernels before 4.12.
    pub fn dropped(&self) -> Option<u32> {
        const SO_MEMINFO: libc::c_int = 55;
        /// The place of `SK_MEMINFO_DROPS`.
        const DROPS: usize = 8;
        let mut figures = [0_u32; DROPS + 1];
        let mut size = size_of_val(&figures) as libc::socklen_t;
        // SAFETY: the kernel writes at most `size` bytes, which is that of the array.
        let got = check(unsafe {
            libc::getsockopt(self.fd(), libc::SOL_SOCKET, SO_MEMINFO, figures.as_mut_ptr().cast(), &raw mut size)
        });
        figures.last().copied().filter(|_| got.is_ok() && size as usize == size_of::<[u32; DROPS + 1]>())
    }

    /// Makes the kernel's receive queue as long as it lets us, up to `bytes`.
    pub fn enlarge_receive_queue(&self, bytes: i32) {
        // Only root may go beyond net.core.rmem_max.
        if self.set(libc::SOL_SOCKET, libc::SO_RCVBUFFORCE, &bytes).is_err() {
            let _ = self.set(libc::SOL_SOCKET, libc::SO_RCVBUF, &bytes);
        }
    }

    /// Lets only frames pass that one of the filters fits; none: no data frame at all.
    pub fn set_filters(&self, filters: &[Filter]) -> io::Result<()> {
        // SAFETY: Filter has the layout of struct can_filter, and the size given is that of the slice.
        unsafe {
            let size = size_of_val(filters) as libc::socklen_t;
            check(libc::setsockopt(self.fd(), SOL_CAN_RAW, CAN_RAW_FILTER, filters.as_ptr().cast(), size))
        }
    }

    fn set<T: Copy>(&self, level: libc::c_int, name: libc::c_int, value: &T) -> io::Result<()> {
        // SAFETY: the kernel reads as many bytes as the value has.
        unsafe {
            let size = size_of::<T>() as libc::socklen_t;
            check(libc::setsockopt(self.fd(), level, name, (&raw const *value).cast(), size))
        }
    }

    /// Hands over a frame of 16 or 72 bytes.
    pub fn send(&self, packet: &[u8]) -> io::Result<()> {
        // SAFETY: the kernel reads as many bytes as the slice has.
        let sent = unsafe { libc::send(self.fd(), packet.as_ptr().cast(), packet.len(), 0) };
        if sent < 0 { Err(io::Error::last_os_error()) } else { Ok(()) }
    }

    /// Whether there is something to receive, or an error to see, until `timeout` has passed.
    pub fn wait_readable(&self, timeout: Duration) -> io::Result<bool> {
        self.wait(libc::POLLIN, timeout)
    }

    /// Whether the socket takes a frame, or has an error to show, until `timeout` has passed.
    pub fn wait_writable(&self, timeout: Duration) -> io::Result<bool> {
        self.wait(libc::POLLOUT, timeout)
    }

    fn wait(&self, events: libc::c_short, timeout: Duration) -> io::Result<bool> {
        let mut polls = [libc::pollfd { fd: self.fd(), events, revents: 0 }];
        poll(&mut polls, timeout.as_millis().min(60_000) as libc::c_int)
    }

    /// Waits until there is something to receive, or an error to see, or the other end of the pipe is closed, or
    /// `timeout` has passed. Says whether this socket has something.
    pub fn wait_readable_or_closed(&self, pipe: &PipeReader, timeout: Option<Duration>) -> io::Result<bool> {
        let ours = libc::pollfd { fd: self.fd(), events: libc::POLLIN, revents: 0 };
        let mut polls = [ours, libc::pollfd { fd: pipe.as_raw_fd(), events: libc::POLLIN, revents: 0 }];
        poll(&mut polls, timeout.map_or(-1, |timeout| timeout.as_millis().min(60_000) as libc::c_int))?;
        Ok(polls[0].revents != 0)
    }

    /// Fetches what there is, at most a batch; returns how many frames came.
    pub fn receive(&self, batch: &mut Batch) -> io::Result<usize> {
        batch.prepare();
        // SAFETY: prepare() has just let every header point to buffers of the batch, which is borrowed until the call
        // returns and does not move.
        let received = unsafe {
            libc::recvmmsg(self.fd(), batch.headers.as_mut_ptr(), BATCH as libc::c_uint, 0, std::ptr::null_mut())
        };
        if received < 0 { Err(io::Error::last_os_error()) } else { Ok(received as usize) }
    }
}

/// Whether one of them is ready before so many milliseconds have passed; -1: however long it takes.
fn poll(polls: &mut [libc::pollfd], milliseconds: libc::c_int) -> io::Result<bool> {
    // SAFETY: the slice lives until the call returns, and its length is passed.
    let ready = unsafe { libc::poll(polls.as_mut_ptr(), polls.len() as libc::nfds_t, milliseconds) };
    if ready < 0 { Err(io::Error::last_os_error()) } else { Ok(ready > 0) }
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

    /// The frame at that place, with what came with it.
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
    // SAFETY: the header is one that the kernel has filled; its control buffer is aligned and lives in the batch. The
    // macros stay within it, and a message's data is as long as its header says.
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

/// A length, which libc counts in `usize` on some targets and in `u32` on others.
fn bytes(length: impl TryInto<usize>) -> usize {
    length.try_into().unwrap_or(0)
}

/// A `struct timespec` of 64-bit parts; zero means that there is none.
fn timestamp(bytes: &[u8]) -> Option<Timestamp> {
    let seconds = i64::from_ne_bytes(*bytes.first_chunk()?);
    let nanos = i64::from_ne_bytes(*bytes.get(8..)?.first_chunk()?);
    let total = u64::try_from(seconds).ok()?.checked_mul(1_000_000_000)?.checked_add(u64::try_from(nanos).ok()?)?;
    (total > 0).then_some(Timestamp(total))
}

/// Asks the kernel to wake this thread when its time has come, and not up to 50 µs later to save energy.
pub(crate) fn wake_precisely() {
    // SAFETY: no pointers are passed.
    unsafe {
        libc::prctl(libc::PR_SET_TIMERSLACK, 1, 0, 0, 0);
    }
}

/// Sends a message to the kernel's routing socket and returns what it answers, up to 32 KiB.
pub(super) fn ask_routing(request: &[u8]) -> io::Result<Vec<u8>> {
    let mut answer = vec![0; 32 * 1024];
    // SAFETY: the descriptor is new and owned by nobody else; lengths are those of the buffers.
    unsafe {
        let fd = libc::socket(libc::AF_NETLINK, libc::SOCK_RAW | libc::SOCK_CLOEXEC, libc::NETLINK_ROUTE);
        if fd < 0 {
            return Err(io::Error::last_os_error());
        }
        let fd = OwnedFd::from_raw_fd(fd);
        if libc::send(fd.as_raw_fd(), request.as_ptr().cast(), request.len(), 0) < 0 {
            return Err(io::Error::last_os_error());
        }
        let received = libc::recv(fd.as_raw_fd(), answer.as_mut_ptr().cast(), answer.len(), 0);
        answer.truncate(usize::try_from(received).map_err(|_| io::Error::last_os_error())?);
    }
    Ok(answer)
}

fn check(result: libc::c_int) -> io::Result<()> {
    if result < 0 { Err(io::Error::last_os_error()) } else { Ok(()) }
}

// SAFETY: the pointers in the headers are set anew before each use, from buffers that the batch owns.
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
