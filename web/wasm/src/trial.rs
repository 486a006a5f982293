//! Simulated devices in the page: cases and fuzzer without hardware, all in virtual time.

use crate::host;
use crate::provenance::{Surroundings, flag, given, usual};
use canvass_analyzer::NodeId;
use canvass_analyzer::dictionary::KnownDevice;
use canvass_device::Fault;
use canvass_device::address::{BusAddress, Opened, SimulatedDevice, open_seeded_at};
use canvass_device::models::Model;
use canvass_fuzzer::campaign::{self, Outcome, Plan as FuzzPlan};
use canvass_fuzzer::coverage::{LssReach, SdoReach};
use canvass_fuzzer::stand::{TestStand as _, of_address};
use canvass_fuzzer::time_limit::TimeLimit;
use canvass_fuzzer::{Knowledge, Targets};
use canvass_reports::conformance::{Reporter, RunReport};
use canvass_reports::document::{Form, Report as _};
use canvass_reports::fuzz::{self, Words};
use canvass_reports::provenance::{BusUsed, Choice, Provenance};
use canvass_suite::bench::{Bench, Decoder, Options, Target, Timing};
use canvass_suite::catalogue;
use canvass_suite::identity;
use canvass_suite::runner::{DeviceIdentity, Plan, RunEvent, run};
use canvass_suite::touch::Touch;
use canvass_suite::verdict::Deviation;
use canvass_traces::Duration;
use serde_json::{Value, json};
use std::cell::RefCell;
use std::io::{self, Write};
use std::rc::Rc;
use std::sync::atomic::AtomicBool;

/// The requested trial.
#[derive(Clone, Debug, Default, serde::Deserialize)]
#[serde(default)]
pub struct Wish {
    /// The simulated bus, such as `sim:kuebler-sendix-58x8+boot-up-twice`.
    pub bus: String,
    /// Selectors of cases, separated by commas; empty: all cases.
    pub select: String,
    /// Whether all permissions are given, including changes of non-volatile memory.
    pub allow: bool,
    /// The services to fuzz, separated by commas; empty: all services.
    pub target: String,
    /// Time limit of the fuzzer in seconds.
    pub seconds: f64,
    /// Number of sequences of the fuzzer, if there is no time limit.
    pub sequences: u64,
    /// The seed of random choices.
    pub seed: u64,
}

/// The result of a trial.
#[derive(Debug)]
pub struct Tried {
    /// The HTML page.
    pub html: Vec<u8>,
    /// The JSON result.
    pub json: Vec<u8>,
}

/// The models and faults that can be tried.
pub fn choices() -> Value {
    let models = Model::all().iter().map(|model| json!({ "id": model.id(), "summary": model.summary() }));
    let faults =
        Fault::ALL.iter().map(|fault| json!({ "id": fault.id(), "summary": fault.summary(), "model": fault.model() }));
    let mut families: Vec<&str> = catalogue::cases().iter().map(|case| case.family()).collect();
    families.dedup();
    json!({ "models": models.collect::<Vec<_>>(), "faults": faults.collect::<Vec<_>>(), "families": families })
}

/// The output of a report, shared with its reporter.
#[derive(Clone, Default)]
struct Kept(Rc<RefCell<Vec<u8>>>);

impl Write for Kept {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.borrow_mut().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn words(error: impl std::fmt::Display) -> String {
    error.to_string()
}

fn touches(wish: &Wish) -> std::collections::BTreeSet<Touch> {
    if wish.allow { Touch::ALL.iter().copied().collect() } else { Default::default() }
}

/// The provenance, as far as it is known before the run.
fn provenance(wish: &Wish, surroundings: &Surroundings, bit_rate: Option<u32>, options: Vec<Choice>) -> Provenance {
    let bus = BusUsed { address: wish.bus.clone(), adapter: "simulated".to_owned(), bit_rate };
    Provenance { bus: Some(bus), seed: Some(wish.seed), host: None, options, ..surroundings.provenance() }
}

/// The words of a list separated by commas.
fn words_of(text: &str) -> impl Iterator<Item = String> {
    text.split(',').map(str::trim).filter(|word| !word.is_empty()).map(str::to_owned)
}

/// The options of an equivalent `canvass test`.
fn options_of_test(wish: &Wish, target: &Target) -> Vec<Choice> {
    let timing = Timing::default();
    let spans = [
        ("sdo", timing.sdo_response),
        ("boot-up", timing.boot_up),
        ("reaction", timing.reaction),
        ("silence", timing.silence),
    ];
    let mut timeouts: Vec<_> = spans.iter().map(|(what, span)| format!("{what}={}", span_text(*span))).collect();
    // The defaults of the program for a client and for an interrupted adapter; a simulated bus has neither.
    timeouts.extend(["client=10s".to_owned(), "reconnect=120s".to_owned()]);
    vec![
        usual("node", [target.node.to_string()]),
        usual("device", [target.model.clone()]),
        given("select", words_of(&wish.select)),
        given("exclude", []),
        given("failed-from", []),
        given("shard", []),
        given("shuffle", []),
        allowed(wish),
        given("waivers", []),
        usual("repeat", ["1"]),
        usual("retries", ["0"]),
        flag("fail-fast", false),
        flag("cct-markers", false),
        usual("journal", ["none"]),
        flag("restore", false),
        usual("timeout", timeouts),
        usual("tolerance", [timing.period_tolerance.to_string()]),
        given("power-cycle", []),
        flag("zero-point-stored", false),
        flag("exhaustive", false),
        given("for", []),
        usual("profile", ["full"]),
    ]
}

/// A span in the notation of `--timeout`.
fn span_text(span: Duration) -> String {
    match span.nanos() / 1_000_000 {
        millis if millis % 1_000 == 0 => format!("{}s", millis / 1_000),
        millis => format!("{millis}ms"),
    }
}

fn allowed(wish: &Wish) -> Choice {
    given("allow", wish.allow.then(|| "all".to_owned()))
}

/// The options of an equivalent `canvass fuzz` with this number of sequences.
fn options_of_fuzz(wish: &Wish, plan: &FuzzPlan, knowledge: &Knowledge, model: &Model, sequences: u64) -> Vec<Choice> {
    let all = Targets::default().to_string();
    let target = match &*wish.target {
        "" => usual("target", [all]),
        chosen => Choice { default: vec![all], ..given("target", words_of(chosen)) },
    };
    vec![
        usual("node", [knowledge.node.to_string()]),
        usual("device", [model.id()]),
        target,
        given("for", []),
        given("runs", [sequences.to_string()]),
        flag("stop-at-first", plan.stop_at_first),
        usual("shrink-budget", [plan.shrink_budget.to_string()]),
        allowed(wish),
        given("replay", []),
        given("regressions", []),
        given("corpus-dir", []),
        flag("unconfirmed", false),
        given("reproducers", []),
        usual("reconnect-timeout", ["2min"]),
    ]
}

/// The single simulated device of an address; files and live buses are refused.
fn device(address: &str) -> Result<SimulatedDevice, String> {
    match address.parse::<BusAddress>().map_err(words)? {
        BusAddress::Simulated(devices) => match <[SimulatedDevice; 1]>::try_from(devices) {
            Ok([only]) => Ok(only),
            Err(devices) => Err(format!("expected one simulated device, found {}", devices.len())),
        },
        _ => Err("a page reaches simulated devices only: expected sim:MODEL[+FAULT...]".to_owned()),
    }
}

/// Runs the cases.
///
/// # Errors
/// A text, if the device or a selector is unknown, or nothing could be run.
pub fn test(wish: &Wish, surroundings: &Surroundings) -> Result<Tried, String> {
    device(&wish.bus)?;
    let selectors = words_of(&wish.select).map(|one| one.parse());
    let selectors = selectors.collect::<Result<Vec<_>, _>>().map_err(words)?;
    let cases = catalogue::select(&selectors).map_err(|idle| format!("{idle} selects no case"))?;
    let mut opened = open_seeded_at(&wish.bus, wish.seed, None).map_err(words)?;
    let target = target(&opened)?;
    let mut provenance = provenance(wish, surroundings, opened.bus.bit_rate(), options_of_test(wish, &target));
    let options = Options { allow: touches(wish), ..Options::default() };
    let plan = Plan { cases: &cases, bus: &wish.bus, bit_rate: opened.bus.bit_rate(), seed: wish.seed, shuffle: None };
    let kept: [Kept; 2] = Default::default();
    let forms = [Form::Html, Form::Json];
    // The report advises the command line of the program, not options of the page.
    let report = |(kept, form): (&Kept, Form)| RunReport::new(kept.clone(), form).allowed_by("--allow ");
    let mut reports: Vec<_> = kept.iter().zip(forms).map(report).collect();
    let mut decoder = Decoder::new(&target);
    let cancel = AtomicBool::new(false);
    let mut bench = Bench::new(opened.bus.as_mut(), &target, &options, &mut decoder, &cancel);
    let ran = run(&mut bench, &plan, &mut |event: &RunEvent<'_>| {
        match event {
            RunEvent::CaseStarted { case, number, of } => host::progress(*number, *of, case.id),
            RunEvent::RunStarted(info) => provenance.devices.push((format!("node {}", info.node), info.device.clone())),
            RunEvent::RunFinished(_) => reports.iter_mut().for_each(|report| report.comes_from(&provenance)),
            _ => {}
        }
        // Writing to memory can't fail.
        reports.iter_mut().for_each(|report| drop(report.event(event)));
    });
    ran.map_err(words)?;
    let [html, json] = kept.map(|kept| kept.0.take());
    Ok(Tried { html, json })
}

fn target(opened: &Opened) -> Result<Target, String> {
    let model = opened.model.ok_or("the device is of no built-in model")?;
    let firmware = opened.devices.first().map(|device| device.firmware).unwrap_or_default();
    let (description, manual) = (model.description_with(firmware), model.device().manual.clone());
    let node = opened.node().or_else(|| model.default_node());
    let node =
        node.ok_or_else(|| format!("{} has no node-ID as delivered: write sim:{}@node=5", model.id(), model.id()))?;
    let deviations = Deviation::of_model(model).into_iter().collect();
    let described_alone = model.is_described_alone();
    let device = Some(KnownDevice { description, manual });
    Ok(Target { deviations, described_alone, ..Target::known(node, model.id().to_owned(), device) })
}

/// Fuzzes the device.
///
/// # Errors
/// A text, if the device is unknown, or can't be reached.
pub fn fuzz(wish: &Wish, surroundings: &Surroundings) -> Result<Tried, String> {
    let device = device(&wish.bus)?;
    let (mut stand, knowledge) = of_address(&device, None, wish.seed).map_err(words)?;
    let targets = if wish.target.is_empty() { Targets::default() } else { wish.target.parse().map_err(words)? };
    let plan = FuzzPlan {
        targets,
        seed: wish.seed,
        allow: touches(wish),
        shrink_budget: 2_000,
        // The page has no clock for a time limit; its user cancels by ending the whole worker.
        time: TimeLimit::default(),
        stop_at_first: false,
        regressions: Vec::new(),
        only_regressions: false,
        corpus: Vec::new(),
    };
    let began = host::now();
    let outcome = campaign::run(&mut stand, knowledge.clone(), &plan, &mut |state| {
        let told = format!("{} exchanges, {} violations", state.executions, state.violations);
        let (done, all) = match wish.seconds > 0.0 {
            true => ((host::now() - began) as u64, (wish.seconds * 1e3) as u64),
            false => (state.sequences, wish.sequences),
        };
        host::progress(done as usize, all as usize, &told);
        done < all
    });
    let outcome = outcome.map_err(words)?;
    let model = device.model().map_err(words)?;
    let options = options_of_fuzz(wish, &plan, &knowledge, model, outcome.sequences);
    let mut provenance = provenance(wish, surroundings, Some(stand.bit_rate()), options);
    provenance.devices.push((format!("node {}", knowledge.node), identity_of(wish, knowledge.node)?));
    let run = fuzzed(wish, &plan, &knowledge, model, outcome, stand.has_unconfigured(), provenance);
    let (mut html, mut json) = (Vec::new(), Vec::new());
    run.write(Form::Html, &mut html).and_then(|()| run.write(Form::Json, &mut json)).map_err(words)?;
    Ok(Tried { html, json })
}

/// The identity of the device. It is read from another instance of the device, as the fuzzed instances are in arbitrary
/// states.
fn identity_of(wish: &Wish, node: NodeId) -> Result<DeviceIdentity, String> {
    const BOOT: Duration = Duration::from_secs(5);
    let mut opened = open_seeded_at(&wish.bus, wish.seed, Some(node)).map_err(words)?;
    let boots = opened.bus.now() + BOOT;
    while let Some(record) = opened.bus.receive(boots).map_err(words)? {
        if record.frame.cob_id() == Some(0x700 + u16::from(node.raw())) {
            break;
        }
    }
    identity::ask(opened.bus.as_mut(), node).map_err(words)
}

fn fuzzed(
    wish: &Wish,
    plan: &FuzzPlan,
    knowledge: &Knowledge,
    model: &Model,
    outcome: Outcome,
    has_unconfigured: bool,
    provenance: Provenance,
) -> fuzz::Run {
    let target = Target::known(knowledge.node, model.id().to_owned(), Some(KnownDevice::clone(model.device())));
    let words = outcome.violations.iter().map(|found| Words::of(found, &mut || Box::new(Decoder::new(&target))));
    let allowed = if wish.allow { " --allow all" } else { "" };
    fuzz::Run {
        zero_point: None,
        bit_rate: provenance.bus.as_ref().and_then(|bus| bus.bit_rate),
        provenance,
        bus: wish.bus.clone(),
        node: knowledge.node,
        model: model.id().to_owned(),
        targets: plan.targets,
        allow: plan.allow.clone(),
        seed: plan.seed,
        repeat: format!(
            "canvass fuzz {} --node {} --target {} --seed {} --runs {}{allowed}",
            wish.bus, knowledge.node, plan.targets, plan.seed, outcome.sequences
        ),
        cancelled: false,
        sdo_reach: SdoReach::of(knowledge),
        reach: LssReach::of(&knowledge.services, has_unconfigured, &plan.allow),
        words: words.collect(),
        outcome,
    }
}
