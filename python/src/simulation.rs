//! A simulated bus, in virtual time or at the pace of this computer's clock.

use crate::frame::Frame;
use canvass_analyzer::NodeId;
use canvass_analyzer::wire::emcy::EmcyCode;
use canvass_bus::{Bus as _, Machine, SimulatedBus};
use canvass_device::address::{self, Attached, BusAddress};
use canvass_device::models::Model;
use canvass_device::{Device, MotionSpec};
use canvass_traces::small_file::{self, OF_HAND};
use canvass_traces::{CanId, Channels, Direction, Duration, Frame as CanFrame, Record, Timestamp};
use pyo3::exceptions::{PyKeyError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration as StdDuration, Instant};

/// The built-in models: pairs of id and summary.
#[pyfunction]
pub fn models() -> Vec<(String, String)> {
    Model::all().iter().map(|model| (model.id().to_owned(), model.summary().to_owned())).collect()
}

/// A bus with simulated devices.
///
/// In real time the bus runs as long as it exists, and `receive` waits as on a real bus. In virtual time nothing waits:
/// time advances only in `receive`, from one frame to the next, at most by its timeout.
#[pyclass(frozen, module = "canvass")]
pub struct Simulation {
    state: Mutex<State>,
    sent: Condvar,
}

struct State {
    bus: SimulatedBus,
    devices: Vec<Handle>,
    channels: Channels,
    /// The start on this computer's clock; `None` in virtual time.
    started: Option<Instant>,
    /// Frames that were on the bus and that nobody has received yet.
    ready: VecDeque<Record>,
    /// Number of frames that were dropped because nobody received them in time.
    lost: u64,
    /// Number of calls of `receive` in virtual time since the last frame was sent.
    unasked: u32,
    /// When [`Simulation::answer`] was last called.
    answered: Option<Instant>,
}

/// A device that the bus and the program share.
#[derive(Clone)]
struct Shared(Arc<Mutex<Device>>);

struct Handle {
    device: Shared,
    attached: Attached,
}

/// Maximum number of frames that wait for the program. The oldest are dropped, as in the queue of an adapter.
const WAITING: usize = 1 << 16;
/// The longest boot of a device: a faulty one may never end it.
const LONGEST_BOOT: Timestamp = Timestamp(30_000_000_000);
/// Number of calls of `receive` in virtual time after which a program that sends nothing has to wait for [`MOMENT`].
/// Without it a thread that receives all the time would use a whole processor, and a day would pass in a second.
const UNASKED: u32 = 256;
const MOMENT: StdDuration = StdDuration::from_millis(1);
/// The longest wait after which Python may handle signals, such as Ctrl-C.
const LOOK: StdDuration = StdDuration::from_millis(50);
/// How long `receive` of other threads waits in virtual time after a call of [`Simulation::answer`]. Without it such a
/// thread would let hours pass between two requests.
const OWN: StdDuration = StdDuration::from_millis(20);

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Device> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Machine for Shared {
    fn handle(&mut self, now: Timestamp, frame: &CanFrame) {
        self.lock().handle(now, frame);
    }

    fn ignores(&self, frame: &CanFrame) -> bool {
        self.lock().ignores(frame)
    }

    fn poll_transmit(&mut self, now: Timestamp) -> Option<CanFrame> {
        self.lock().poll_transmit(now)
    }

    fn poll_timeout(&self) -> Option<Timestamp> {
        self.lock().poll_timeout()
    }

    fn handle_timeout(&mut self, now: Timestamp) {
        self.lock().handle_timeout(now);
    }

    fn bit_rate(&self) -> Option<u32> {
        Machine::bit_rate(&*self.lock())
    }

    fn power_cycle(&mut self, now: Timestamp) {
        Machine::power_cycle(&mut *self.lock(), now);
    }

    fn withdraws(&self, pending: &CanFrame) -> bool {
        self.lock().withdraws(pending)
    }
}

impl State {
    /// Lets the devices boot: whoever opens a bus expects devices that were switched on before. Their boot-up messages
    /// wait for the program.
    fn boot(&mut self) {
        let is_booting = |handle: &Handle| {
            let device = handle.device.lock();
            device.node().is_some() && device.state() == canvass_analyzer::wire::error_control::State::BOOT_UP
        };
        while self.bus.now() < LONGEST_BOOT && self.devices.iter().any(is_booting) {
            let Some(next) = self.bus.next_time() else { return };
            let record = self.step(next);
            self.ready.extend(record);
        }
    }

    /// The present time of a bus in real time.
    fn present(&self) -> Option<Timestamp> {
        self.started.map(|started| Timestamp(u64::try_from(started.elapsed().as_nanos()).unwrap_or(u64::MAX)))
    }

    /// Lets the bus run until now, if it is in real time.
    fn catch_up(&mut self) {
        let Some(present) = self.present() else { return };
        while let Ok(Some(record)) = self.bus.receive(present) {
            self.keep(record);
        }
    }

    fn keep(&mut self, record: Record) {
        if self.ready.len() >= WAITING {
            self.ready.pop_front();
            self.lost += 1;
        }
        self.ready.push_back(record);
    }

    /// The next frame of a bus in virtual time, at most `until`.
    fn step(&mut self, until: Timestamp) -> Option<Record> {
        // The simulated bus does not fail.
        self.bus.receive(until).ok().flatten()
    }

    fn device(&self, node: Option<u8>) -> PyResult<usize> {
        let Some(node) = node else { return Ok(0) };
        let has = |handle: &Handle| handle.device.lock().node().or(handle.attached.node).map(NodeId::raw) == Some(node);
        self.devices
            .iter()
            .position(has)
            .ok_or_else(|| PyKeyError::new_err(format!("no simulated device has the node-ID {node}")))
    }
}

impl Simulation {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for the next frame, at most for `timeout`, or without end; `own` frames of the program count, too. Returns
    /// to Python now and then, so that Ctrl-C ends the waiting.
    fn wait(&self, py: Python<'_>, timeout: Option<StdDuration>, own: bool) -> PyResult<Option<Record>> {
        let begun = Instant::now();
        let state = self.state();
        let nanos = |timeout: StdDuration| u64::try_from(timeout.as_nanos()).unwrap_or(u64::MAX);
        let virtual_end = timeout.map(|timeout| state.bus.now() + Duration(nanos(timeout)));
        drop(state);
        loop {
            let end = Until { timeout, virtual_end, begun, own };
            match py.detach(|| self.wait_a_while(&end)) {
                Waited::Frame(record) => return Ok(Some(record)),
                Waited::TimeIsOver => return Ok(None),
                Waited::Interrupted => py.check_signals()?,
            }
        }
    }

    /// Waits for the next frame, at most for [`LOOK`].
    fn wait_a_while(&self, until: &Until) -> Waited {
        let looks = Instant::now();
        let mut state = self.state();
        loop {
            state.catch_up();
            if let Some(record) = state.next_ready(until.own) {
                return Waited::Frame(record);
            }
            let pause = match state.present() {
                Some(present) => until.pause(state.bus.next_time(), present),
                None => state.advance(until),
            };
            let Some(pause) = pause else { return Waited::TimeIsOver };
            if looks.elapsed() >= LOOK {
                return Waited::Interrupted;
            }
            if !pause.is_zero() {
                // A frame that is sent meanwhile ends the pause.
                state = self.sent.wait_timeout(state, pause.min(LOOK)).unwrap_or_else(PoisonError::into_inner).0;
            }
        }
    }
}

/// What `receive` waits for.
struct Until {
    timeout: Option<StdDuration>,
    /// The end of the timeout in virtual time.
    virtual_end: Option<Timestamp>,
    begun: Instant,
    own: bool,
}

/// The result of waiting.
enum Waited {
    Frame(Record),
    TimeIsOver,
    /// Nothing yet: Python may have something else to do.
    Interrupted,
}

impl Until {
    /// In real time: how long to wait for the bus's next event. `None` if the timeout is over.
    fn pause(&self, next: Option<Timestamp>, present: Timestamp) -> Option<StdDuration> {
        let until_event = next.map(|next| StdDuration::from(next.since(present)));
        let left = self.timeout.map(|timeout| timeout.saturating_sub(self.begun.elapsed()));
        if left.is_some_and(|left| left.is_zero()) {
            return None;
        }
        // Without an event the bus is silent until the program sends.
        Some(until_event.into_iter().chain(left).min().unwrap_or(LOOK))
    }
}

impl State {
    /// The next frame that waits; own frames of the program only if they are wanted.
    fn next_ready(&mut self, own: bool) -> Option<Record> {
        while let Some(record) = self.ready.pop_front() {
            if own || record.direction != Direction::Tx {
                return Some(record);
            }
        }
        None
    }

    /// In virtual time: lets the bus run to its next frame, and returns how long to wait before it is looked for.
    /// `None` if the timeout is over.
    fn advance(&mut self, until: &Until) -> Option<StdDuration> {
        if self.answered.is_some_and(|answered| answered.elapsed() < OWN) {
            let is_over = until.timeout.is_some_and(|timeout| until.begun.elapsed() >= timeout);
            return (!is_over).then_some(OWN);
        }
        self.unasked = self.unasked.saturating_add(1);
        if self.unasked > UNASKED && self.unasked % 2 == 1 {
            // The next call goes on.
            return Some(MOMENT);
        }
        match (until.virtual_end, self.bus.next_time()) {
            (Some(end), _) => {
                let record = self.step(end)?;
                self.ready.push_back(record);
                Some(StdDuration::ZERO)
            }
            (None, Some(next)) => {
                let record = self.step(next);
                self.ready.extend(record);
                Some(StdDuration::ZERO)
            }
            (None, None) => Some(LOOK),
        }
    }
}

/// A frame without an object: see `receive_raw`.
type Raw<'py> = (f64, u32, bool, bool, usize, Bound<'py, PyBytes>, bool);

fn raw<'py>(py: Python<'py>, record: &Record) -> Raw<'py> {
    let (frame, id) = (&record.frame, record.frame.id());
    let (seconds, data) = (record.timestamp.nanos() as f64 / 1e9, PyBytes::new(py, frame.data()));
    let is_rx = record.direction != Direction::Tx;
    (seconds, id.raw(), id.is_extended(), frame.is_remote(), frame.len(), data, is_rx)
}

/// A timeout in seconds as a duration. `None`, which waits without end, stands for a timeout of decades, too.
fn span(timeout: Option<f64>) -> Option<StdDuration> {
    const LONGEST: f64 = 1e9;
    let timeout = timeout.filter(|timeout| *timeout < LONGEST);
    timeout.map(|timeout| StdDuration::from_secs_f64(timeout.max(0.0)))
}

#[pymethods]
impl Simulation {
    /// `address`: `sim:MODEL[:NODE][@BITRATE][~MOTION][+FAULT...]`, as on canvass's command line. `seed` determines the
    /// random choices of the devices.
    #[new]
    #[pyo3(signature = (address, seed=0, real_time=true))]
    fn new(address: &str, seed: u64, real_time: bool) -> PyResult<Self> {
        let wrong = |error: &dyn std::fmt::Display| PyValueError::new_err(error.to_string());
        let named = match address.parse::<BusAddress>().map_err(|error| wrong(&error))? {
            BusAddress::Simulated(named) => named,
            _ => return Err(PyValueError::new_err(format!("expected sim:MODEL, found \"{address}\""))),
        };
        let (bit_rate, made) = address::devices(&named, seed).map_err(|error| wrong(&error))?;
        let mut bus = SimulatedBus::new(bit_rate);
        let mut devices = Vec::new();
        for (device, attached) in made {
            let device = Shared(Arc::new(Mutex::new(device)));
            bus.attach(Box::new(device.clone()));
            devices.push(Handle { device, attached });
        }
        let mut channels = Channels::new();
        channels.intern(address);
        let mut state = State {
            bus,
            devices,
            channels,
            started: None,
            ready: VecDeque::new(),
            lost: 0,
            unasked: 0,
            answered: None,
        };
        state.boot();
        state.started =
            if real_time { Instant::now().checked_sub(StdDuration::from_nanos(state.bus.now().nanos())) } else { None };
        Ok(Self { state: Mutex::new(state), sent: Condvar::new() })
    }

    /// Queues a frame for sending.
    #[pyo3(signature = (can_id, data, extended=false, remote=false, length=0))]
    fn send(&self, can_id: u32, data: &[u8], extended: bool, remote: bool, length: u8) -> PyResult<()> {
        let id = if extended { CanId::extended(can_id) } else { CanId::standard(can_id) };
        let id = id.ok_or_else(|| PyValueError::new_err(format!("{can_id:X}h is no CAN-ID")))?;
        let frame = if remote { CanFrame::remote(id, length) } else { CanFrame::new(id, data) };
        let frame = frame.ok_or_else(|| PyValueError::new_err("expected up to 8 bytes"))?;
        let mut state = self.state();
        state.catch_up();
        state.unasked = 0;
        state.bus.send(&frame).map_err(|error| PyValueError::new_err(error.to_string()))?;
        drop(state);
        self.sent.notify_all();
        Ok(())
    }

    /// The next frame that was on the bus, or `None` after `timeout` seconds; without a timeout it waits without end.
    /// Own frames are left out unless `own` is true.
    #[pyo3(signature = (timeout=None, own=false))]
    fn receive(&self, py: Python<'_>, timeout: Option<f64>, own: bool) -> PyResult<Option<Frame>> {
        let record = self.wait(py, span(timeout), own)?;
        Ok(record.map(|record| Frame::of(&record, &self.state().channels)))
    }

    /// As `receive`, without an object: time in seconds, CAN-ID, whether it has 29 bits, whether the frame is remote,
    /// its length, its payload, and whether another participant has sent it.
    #[pyo3(signature = (timeout=None, own=false))]
    fn receive_raw<'py>(&self, py: Python<'py>, timeout: Option<f64>, own: bool) -> PyResult<Option<Raw<'py>>> {
        Ok(self.wait(py, span(timeout), own)?.map(|record| raw(py, &record)))
    }

    /// In virtual time: the next frame of another participant within `timeout` seconds. It is for a sender that wants
    /// the answer at once; other threads that receive wait meanwhile.
    fn answer<'py>(&self, py: Python<'py>, timeout: f64) -> Option<Raw<'py>> {
        let mut state = self.state();
        state.answered = Some(Instant::now());
        let end = state.bus.now() + Duration((timeout.clamp(0.0, 1e6) * 1e9) as u64);
        loop {
            let record = match state.ready.pop_front() {
                Some(record) => record,
                None => state.step(end)?,
            };
            if record.direction != Direction::Tx {
                return Some(raw(py, &record));
            }
        }
    }

    /// The time of the bus in seconds.
    #[getter]
    fn now(&self) -> f64 {
        let mut state = self.state();
        state.catch_up();
        state.bus.now().nanos() as f64 / 1e9
    }

    /// Number of frames that were dropped because more than 65 536 waited to be received.
    #[getter]
    fn lost(&self) -> u64 {
        self.state().lost
    }

    /// The bit rate in bit/s.
    #[getter]
    fn bit_rate(&self) -> Option<u32> {
        self.state().bus.bit_rate()
    }

    /// The devices: pairs of the present node-ID and the id of the model.
    #[getter]
    fn devices(&self) -> Vec<(Option<u8>, String)> {
        let of =
            |handle: &Handle| (handle.device.lock().node().map(NodeId::raw), handle.attached.model.id().to_owned());
        self.state().devices.iter().map(of).collect()
    }

    /// Raises or clears a hardware error with this EMCY code in the device of a node (default: the first device).
    #[pyo3(signature = (code, present, node=None))]
    fn set_error(&self, code: u16, present: bool, node: Option<u8>) -> PyResult<()> {
        self.change(node, |device, now| {
            device.set_error(now, EmcyCode(code), present);
            Ok(())
        })
    }

    /// Sets what the device measures, as after `~` in an address: `60rpm`, `1000`, `sine(...)`.
    #[pyo3(signature = (motion, node=None))]
    fn set_motion(&self, motion: &str, node: Option<u8>) -> PyResult<()> {
        let wrong = |error: String| PyValueError::new_err(format!("{motion}: {error}"));
        let spec: MotionSpec = motion.parse().map_err(|error: canvass_device::MotionError| wrong(error.to_string()))?;
        let motion = match spec {
            MotionSpec::Known(motion) => motion,
            MotionSpec::File(path) => {
                let text = small_file::read_text(path.as_ref(), OF_HAND).map_err(|error| wrong(error.to_string()))?;
                MotionSpec::from_csv(&text).map_err(|error| wrong(error.to_string()))?
            }
        };
        self.change(node, |device, now| {
            device.set_motion(now, motion);
            Ok(())
        })
    }

    /// Switches the supply of a device off and on (default: the first device).
    #[pyo3(signature = (node=None))]
    fn power_cycle(&self, node: Option<u8>) -> PyResult<()> {
        let mut state = self.state();
        state.catch_up();
        let at = state.device(node)?;
        state.bus.power_cycle(at);
        drop(state);
        self.sent.notify_all();
        Ok(())
    }
}

impl Simulation {
    /// Changes a device; the bus then asks it for frames and timers, which the change may have made.
    fn change(&self, node: Option<u8>, change: impl FnOnce(&mut Device, Timestamp) -> PyResult<()>) -> PyResult<()> {
        let mut state = self.state();
        state.catch_up();
        let (at, now) = (state.device(node)?, state.bus.now());
        let device = state.devices.get(at).map(|handle| handle.device.clone());
        let device = device.ok_or_else(|| PyKeyError::new_err("the bus has no simulated device"))?;
        change(&mut device.lock(), now)?;
        state.bus.take_up(at);
        drop(state);
        self.sent.notify_all();
        Ok(())
    }
}
