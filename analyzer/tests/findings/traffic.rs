//! A small machine whose traffic is written frame by frame, and the findings in this traffic.

use canvass_analyzer::findings::{Diagnosis, Finding, InOrder, Results, SourceQuality, Thresholds};
use canvass_traces::{ChannelId, Duration, Frame, INTERMISSION, Quality, Record, Timestamp, bit_length, parse_frame};

/// Frames, each with the time in microseconds from which it waits for the bus.
#[derive(Clone, Default)]
pub struct Traffic {
    frames: Vec<(u64, Frame)>,
}

/// The end of the machine's traffic, in milliseconds. Node 3 is an encoder with a synchronous and a cyclic TPDO, node 4
/// sends on events, node 6 is guarded; a master sends a heartbeat of its own, SYNC with a counter, and TIME.
pub const END: u64 = 30_000;
/// Time at which the machine is started, in milliseconds.
pub const START: u64 = 1_000;

pub fn frame(text: &str) -> Frame {
    let compact: String = text.split_whitespace().collect();
    parse_frame(&compact).unwrap_or_else(|error| panic!("{text}: {error:?}")).frame
}

impl Traffic {
    /// Adds a frame at `ms`, in milliseconds.
    pub fn at(&mut self, ms: u64, text: &str) -> &mut Self {
        self.micros(ms * 1000, text)
    }

    pub fn micros(&mut self, us: u64, text: &str) -> &mut Self {
        self.frames.push((us, frame(text)));
        self
    }

    /// Adds a frame every `period` milliseconds.
    pub fn every(&mut self, from: u64, to: u64, period: u64, text: impl Fn(u64) -> String) -> &mut Self {
        for (n, ms) in (from..to).step_by(period as usize).enumerate() {
            self.at(ms, &text(n as u64));
        }
        self
    }

    /// Adds a request to an SDO server and its answer, 3 ms apart.
    pub fn sdo(&mut self, ms: u64, node: u8, request: &str, response: &str) -> &mut Self {
        let (client, server) = (0x600 + u16::from(node), 0x580 + u16::from(node));
        self.at(ms, &format!("{client:03X}#{request}")).at(ms + 3, &format!("{server:03X}#{response}"))
    }

    /// Removes frames.
    pub fn remove(&mut self, unwanted: impl Fn(u64, &Frame) -> bool) -> &mut Self {
        self.frames.retain(|(us, frame)| !unwanted(us / 1000, frame));
        self
    }

    /// Removes all frames of a CAN-ID within a time.
    pub fn silence(&mut self, id: u16, from: u64, to: u64) -> &mut Self {
        self.remove(|ms, frame| frame.id().as_standard() == Some(id) && (from..to).contains(&ms))
    }

    /// The frames as they follow each other on a bus of 500 kbit/s.
    pub fn records(&self) -> Vec<Record> {
        let mut frames = self.frames.clone();
        frames.sort_by_key(|(us, frame)| (*us, frame.id().raw()));
        let mut free = 0;
        let place = |n: usize| n as u64 + 1;
        let sent = frames.into_iter().enumerate().map(|(n, (us, frame))| {
            let bits = u64::from(bit_length(&frame).unwrap_or(0));
            let end = free.max(us * 1000) + bits * 2000;
            free = end + u64::from(INTERMISSION) * 2000;
            Record::new(Timestamp(1_700_000_000_000_000_000 + end), ChannelId(0), frame).at(place(n), 0)
        });
        sent.collect()
    }

    pub fn results(&self) -> Results {
        diagnose(&self.records(), |_| {})
    }

    /// All findings, which must be of these rules.
    #[track_caller]
    pub fn only(&self, rules: &[&str]) -> Vec<Finding> {
        let findings = self.results().findings;
        let others: Vec<_> = findings.iter().filter(|finding| !rules.contains(&finding.rule.id)).map(shown).collect();
        assert!(others.is_empty(), "besides {rules:?}: {others:#?}");
        findings
    }

    /// The only finding, which must be of this rule and node and first seen within 200 ms of `ms`, with evidence.
    #[track_caller]
    pub fn finds(&self, rule: &str, node: Option<u8>, ms: u64) -> Finding {
        self.finds_among(&[rule], rule, node, ms)
    }

    #[track_caller]
    pub fn finds_among(&self, rules: &[&str], rule: &str, node: Option<u8>, ms: u64) -> Finding {
        let findings = self.only(rules);
        let own: Vec<_> = findings.iter().filter(|finding| finding.rule.id == rule).collect();
        let [finding] = own.as_slice() else {
            panic!("{rule}: expected one finding, there are {:#?}", findings.iter().map(shown).collect::<Vec<_>>())
        };
        assert_eq!(finding.node.map(|node| node.raw()), node, "{}", shown(finding));
        let at = finding.first.nanos().saturating_sub(1_700_000_000_000_000_000) / 1_000_000;
        assert!(at.abs_diff(ms) <= 200, "at {at} ms, expected {ms}: {}", shown(finding));
        (*finding).clone()
    }
}

pub fn shown(finding: &Finding) -> String {
    let node = finding.node.map(|node| format!(" node {node}")).unwrap_or_default();
    let at = finding.first.nanos().saturating_sub(1_700_000_000_000_000_000) / 1_000_000;
    format!("{at} ms {}{node}: {} ({} times)", finding.rule.id, finding.message, finding.count)
}

/// Shows the records to all rules; `prepare` may describe nodes.
pub fn diagnose(records: &[Record], prepare: impl FnOnce(&mut Diagnosis)) -> Results {
    let mut diagnosis = Diagnosis::new(Thresholds::default());
    prepare(&mut diagnosis);
    let mut quality = Quality::default();
    let mut order = InOrder::default();
    for record in records {
        quality.record(record);
        order.push(&mut record.clone());
        while let Some(record) = order.pop() {
            diagnosis.record(record);
        }
    }
    while let Some(record) = order.flush() {
        diagnosis.record(record);
    }
    diagnosis.disordered(order.disorder());
    diagnosis.finish(&[SourceQuality { name: "test.log", quality: &quality }])
}

/// The traffic of a healthy machine in 30 seconds.
pub fn machine() -> Traffic {
    let mut traffic = Traffic::default();
    traffic.every(10, END, 100, |_| "701#05".to_owned());
    for node in [3_u8, 4, 6] {
        traffic.at(100 + u64::from(node), &format!("7{node:02X}#00"));
    }
    configuration(&mut traffic);
    traffic.at(START, "000#0100");
    traffic.every(200, START, 100, |_| "703#7F".to_owned());
    traffic.every(START + 60, END, 100, |_| "703#05".to_owned());
    traffic.every(206, START, 200, |_| "704#7F".to_owned());
    traffic.every(START + 66, END, 200, |_| "704#05".to_owned());
    guarding(&mut traffic);
    for (n, ms) in (START + 20..END).step_by(20).enumerate() {
        let n = n as u64;
        traffic.at(ms, &format!("080#{:02X}", n % 10 + 1));
        // The PDO waits for the end of SYNC.
        traffic.micros(ms * 1000 + 30, &format!("183#{}", hex(4096 + n * 3)));
    }
    traffic.every(START + 7, END, 50, |n| format!("283#{:02X}{:02X}", n & 0xFF, n >> 8 & 0xFF));
    // The event comes at any time.
    traffic.every(START + 333, END, 777, |n| format!("184#{:02X}", n & 1));
    traffic.every(1_500, END, 1_000, |n| format!("100#{} 0010", hex(3_600_000 + n * 1000)));
    traffic.every(2_003, END, 500, |_| "603#4004600000000000".to_owned());
    traffic.every(2_006, END, 500, |n| format!("583#43046000{}", hex(n * 75)));
    later(&mut traffic);
    traffic
}

/// The lowest four bytes of a number in hexadecimal, the lowest byte first.
pub fn hex(value: u64) -> String {
    value.to_le_bytes()[..4].iter().map(|byte| format!("{byte:02X}")).collect()
}

/// The SDO transfers of the master before the start.
fn configuration(traffic: &mut Traffic) {
    let ok = "60";
    traffic.sdo(300, 3, "4000100000000000", "4300100096010200");
    traffic.sdo(310, 3, "4018100100000000", "4318100113000000");
    traffic.sdo(320, 3, "4018100400000000", "4318100439300000");
    traffic.sdo(330, 3, "2B17100064000000", &format!("{ok}17100000000000"));
    traffic.sdo(340, 3, "2300180183010080", &format!("{ok}00180100000000"));
    traffic.sdo(350, 3, "2F00180201000000", &format!("{ok}00180200000000"));
    traffic.sdo(360, 3, "2F001A0000000000", &format!("{ok}001A0000000000"));
    traffic.sdo(370, 3, "23001A0120000460", &format!("{ok}001A0100000000"));
    traffic.sdo(380, 3, "2F001A0001000000", &format!("{ok}001A0000000000"));
    traffic.sdo(390, 3, "2300180183010040", &format!("{ok}00180100000000"));
    traffic.sdo(400, 3, "2F011802FE000000", &format!("{ok}01180200000000"));
    traffic.sdo(410, 3, "2B01180332000000", &format!("{ok}01180300000000"));
    traffic.sdo(420, 3, "2B01180532000000", &format!("{ok}01180500000000"));
    traffic.sdo(430, 3, "2301600000100000", &format!("{ok}01600000000000"));
    traffic.sdo(440, 3, "2302600000000001", &format!("{ok}02600000000000"));
    traffic.sdo(450, 3, "2B00600004000000", &format!("{ok}00600000000000"));
    traffic.sdo(460, 3, "2310100173617665", &format!("{ok}10100100000000"));
    // The device name, in segments.
    traffic.sdo(500, 4, "4008100000000000", "410810000A000000");
    traffic.sdo(510, 4, "6000000000000000", "00454E434F444552");
    traffic.sdo(520, 4, "7000000000000000", "1920313700000000");
    traffic.sdo(530, 4, "2B171000C8000000", &format!("{ok}17100000000000"));
}

/// The master guards node 6 every 300 ms.
fn guarding(traffic: &mut Traffic) {
    for (n, ms) in (700..END).step_by(300).enumerate() {
        let state = if ms < START { 0x7F } else { 0x05 };
        traffic.at(ms, "706#R1").micros(ms * 1000 + 600, &format!("706#{:02X}", state | (n as u8 & 1) << 7));
    }
}

/// An operator stops and starts a node, and resets another one.
fn later(traffic: &mut Traffic) {
    traffic.at(10_031, "000#0204").at(11_045, "000#0104");
    traffic.silence(0x184, 10_031, 11_045);
    for (ms, state) in [(10_066, 4), (10_266, 4), (10_466, 4), (10_666, 4), (10_866, 4)] {
        traffic.silence(0x704, ms, ms + 1).at(ms, &format!("704#{state:02X}"));
    }
    traffic.at(20_000, "000#8204").silence(0x704, 20_000, END).silence(0x184, 20_000, END);
    traffic.at(20_120, "704#00").at(20_500, "000#0104");
    traffic.every(20_320, 20_500, 200, |_| "704#7F".to_owned());
    traffic.every(20_520, END, 200, |_| "704#05".to_owned());
    traffic.every(20_700, END, 900, |n| format!("184#{:02X}", n & 1));
}

/// A number of milliseconds.
pub const fn ms(n: u64) -> Duration {
    Duration::from_millis(n)
}
