//! The bus with its device, the journal, and the kept states.

use anyhow::{Context, Result, bail};
use canvass_analyzer::NodeId;
use canvass_bus::Bus;
use canvass_bus::SimulatedBus;
use canvass_device::address::{BusAddress, GivenNode, simulate};
use canvass_device::models::Model;
use canvass_suite::catalogue::cases;
use canvass_suite::selftest::node_of;
use canvass_suite::touch::Touch;
use canvass_traces::{Direction, Duration, Record, parse_frame};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Maximum time that the test listens after a sent frame, on a bus that is never silent.
const PATIENCE: Duration = Duration::from_millis(1_000);

/// The state that a run can change: bus and device, and the journal that the run leaves.
pub struct State {
    pub bus: SimulatedBus,
    pub journal: Option<String>,
}

/// The simulated device under test.
#[derive(Clone)]
pub struct Subject {
    pub address: String,
    pub model: &'static Model,
    pub node: NodeId,
    pub bit_rate: u32,
}

/// The data that outlive a request.
pub struct World {
    current: Option<(Subject, State)>,
    kept: BTreeMap<String, State>,
    folder: tempfile::TempDir,
}

impl State {
    /// A copy of the state.
    fn duplicate(&self) -> Result<Self> {
        let bus = self.bus.duplicate().context("a device on this bus can't be had a second time")?;
        Ok(Self { bus, journal: self.journal.clone() })
    }
}

impl World {
    pub fn new() -> Result<Self> {
        Ok(Self { current: None, kept: BTreeMap::new(), folder: tempfile::tempdir()? })
    }

    /// The path of the runs' journal.
    pub fn journal_path(&self) -> PathBuf {
        self.folder.path().join("journal")
    }

    /// The file with which the tester switches the supply of the device off and on.
    pub fn switch_path(&self) -> PathBuf {
        self.folder.path().join("switch")
    }

    pub fn device(&mut self, address: String) -> Result<Value> {
        let BusAddress::Simulated(mut named) = address.parse()? else { bail!("{address} is no simulated device") };
        for device in &mut named {
            // Like `--node`, this gives a node-ID to a model that is delivered without one.
            let node = node_of(device.model()?);
            device.node.get_or_insert(GivenNode::Id(node));
        }
        let (bus, devices) = simulate(&named, 0)?;
        let first = devices.first().context("expected a device on the bus")?;
        let node = first.node.context("expected a device with a node-ID")?;
        let bit_rate = bus.bit_rate().unwrap_or_default();
        let subject = Subject { address, model: first.model, node, bit_rate };
        self.kept.clear();
        self.current = Some((subject, State { bus, journal: None }));
        Ok(json!({ "node": node.raw(), "model": first.model.id() }))
    }

    pub fn send(&mut self, frame: &str, silence_us: u64) -> Result<Value> {
        let (_, state) = self.current()?;
        state.bus.send(&parse_frame(frame)?.frame)?;
        let (silence, end) = (Duration::from_micros(silence_us), state.bus.now() + PATIENCE);
        let mut heard = Vec::new();
        loop {
            let deadline = (state.bus.now() + silence).min(end);
            let Some(record) = state.bus.receive(deadline)? else { break };
            heard.extend(of_device(&record));
        }
        Ok(json!({ "now": state.bus.now().0, "frames": heard }))
    }

    pub fn wait(&mut self, ms: u64) -> Result<Value> {
        let (_, state) = self.current()?;
        let end = state.bus.now() + Duration::from_millis(ms);
        let mut heard = Vec::new();
        while let Some(record) = state.bus.receive(end)? {
            heard.extend(of_device(&record));
        }
        Ok(json!({ "now": state.bus.now().0, "frames": heard }))
    }

    pub fn power_cycle(&mut self) -> Result<Value> {
        let (_, state) = self.current()?;
        state.bus.power_cycle(0);
        Ok(json!({ "now": state.bus.now().0, "frames": [] }))
    }

    pub fn keep(&mut self, name: String) -> Result<Value> {
        let state = self.current()?.1.duplicate()?;
        self.put_away(name, state);
        Ok(json!({}))
    }

    /// Keeps a state of this run.
    pub fn put_away(&mut self, name: String, state: State) {
        self.kept.insert(name, state);
    }

    pub fn go_back(&mut self, name: &str) -> Result<Value> {
        let state = self.kept.get(name).with_context(|| format!("nothing was kept as \"{name}\""))?.duplicate()?;
        let (subject, current) = self.current()?;
        *current = state;
        // The next user opens the bus at its usual bit rate, whatever bit rate the run had set.
        current.bus.set_bit_rate(subject.bit_rate)?;
        Ok(json!({ "now": current.bus.now().0, "frames": [] }))
    }

    /// The device with its state.
    pub fn current(&mut self) -> Result<(&Subject, &mut State)> {
        let (subject, state) = self.current.as_mut().context("no device was asked for")?;
        Ok((subject, state))
    }
}

/// A frame as candump writes it; `None` if the tester's side sent it.
fn of_device(record: &Record) -> Option<String> {
    (record.direction != Direction::Tx).then(|| record.frame.to_string())
}

pub fn catalogue() -> Value {
    let models: Vec<&str> = Model::all().iter().map(Model::id).collect();
    let words = Touch::ALL.map(Touch::name);
    let cases: Vec<Value> = cases()
        .into_iter()
        .map(|case| json!({ "id": case.id, "touches": case.touches.iter().map(|touch| touch.name()).collect::<Vec<_>>() }))
        .collect();
    json!({ "models": models, "words": &words[..], "cases": cases })
}
