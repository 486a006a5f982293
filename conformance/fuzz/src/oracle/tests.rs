use super::*;
use canvass_analyzer::NodeId;
use canvass_device::models::Model;
use canvass_traces::parse_frame;

/// The models of one device, and a clock.
struct Watched {
    oracle: Oracle,
    coverage: Coverage,
    now: Timestamp,
}

impl Watched {
    /// A device with node-ID 4 that has just started. `by_manual`: the manual is known, too.
    fn new(model: &str, by_manual: bool) -> Self {
        let model = Model::by_id(model).unwrap();
        let sheet = Some(model.sheet()).filter(|_| by_manual);
        let knowledge = Knowledge::new(NodeId::new(4).unwrap(), Some(model.description()), sheet);
        let mut oracle = Oracle::new(Arc::new(knowledge));
        oracle.start(Timestamp::ZERO, Start::Configured);
        Self { oracle, coverage: Coverage::default(), now: Timestamp(1_000_000_000) }
    }

    /// The fuzzer sends a frame after this number of microseconds.
    fn sends(&mut self, after: u64, line: &str) {
        self.now += Duration::from_micros(after);
        let frame = parse_frame(line).unwrap().frame;
        self.oracle.sent(self.now, &frame, &mut self.coverage).unwrap();
    }

    /// The device sends a frame after this number of microseconds.
    fn receives(&mut self, after: u64, line: &str) -> Result<(), Violation> {
        self.now += Duration::from_micros(after);
        let frame = parse_frame(line).unwrap().frame;
        self.oracle.received(self.now, &frame, &mut self.coverage)
    }
}

/// A device with a lasting error is reset twice: the report of its first start is under way when the second reset
/// comes.
#[test]
fn each_start_may_report_the_same_error() {
    let (reset, boot_up, emcy) = ("000#8204", "704#00", "084#0050012F04000000");
    let mut device = Watched::new("reference-301", true);
    device.sends(0, reset);
    device.receives(5_000, boot_up).unwrap();
    device.sends(10, reset);
    device.receives(40, emcy).unwrap();
    device.receives(4_950, boot_up).unwrap();
    device.receives(10, emcy).unwrap();
    assert_eq!(device.receives(490, emcy).unwrap_err().rule, "EMCY repeated");
}

/// CiA 301 (7.5.2.32) does not say how long a device with an error stays out of operational. When the error is gone, a
/// start has to be obeyed.
#[test]
fn a_start_proves_nothing_while_an_error_lasts() {
    let (start, heartbeat) = ("000#0104", 100_000);
    let mut device = Watched::new("reference-301", true);
    device.sends(0, "604#2B17100064000000");
    device.receives(1_000, "584#6017100000000000").unwrap();
    device.sends(1_000, start);
    device.receives(heartbeat, "704#05").unwrap();
    device.receives(heartbeat - 1_000, "084#3081110000000000").unwrap();
    device.receives(1_000, "704#7F").unwrap();
    device.sends(50_000, start);
    device.receives(heartbeat - 50_000, "704#7F").unwrap();
    device.receives(heartbeat, "704#05").unwrap();
    device.receives(heartbeat, "704#7F").unwrap();
    device.receives(10_000, "084#0000000000000000").unwrap();
    device.sends(10_000, start);
    let wrong = device.receives(heartbeat - 20_000, "704#7F").unwrap_err();
    assert_eq!((wrong.property, wrong.rule), (Property::NmtState, "state in error control"));
    assert_eq!((&*wrong.expected, &*wrong.actual), ("operational", "pre-operational"));
    assert_eq!(wrong.state.to_string(), "operational; SDO server: idle");
}

/// 100Ch is mandatory for a device that guards (CiA 301, 7.5.2.11). Of any other device the frames are heartbeats, whose
/// bit 7 never changes.
#[test]
fn heartbeats_of_a_device_without_100ch_are_no_answers_to_guarding() {
    let guarded = |model: &str| {
        let mut device = Watched::new(model, false);
        (0..3).try_for_each(|_| {
            device.sends(100_000, "704#R1");
            device.receives(1_000, "704#7F")
        })
    };
    guarded("kuebler-sendix-m58").unwrap();
    assert_eq!(guarded("reference-301").unwrap_err().rule, "toggle bit of guarding");
}

/// Messages that their configuration switches off are no PDOs.
#[test]
fn messages_that_are_off_have_a_property_of_their_own() {
    let wrong = |line: &str| Watched::new("reference-301", true).receives(0, line).unwrap_err();
    let sync = wrong("080#");
    assert_eq!((sync.property, sync.rule), (Property::Produced, "SYNC although off"));
    assert_eq!(sync.symptom, Symptom::Frame(parse_frame("080#").unwrap().frame));
    assert_eq!(wrong("100#").rule, "TIME although off");
    assert_eq!(wrong("1B4#").property, Property::Pdo);
}
