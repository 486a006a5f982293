//! Load: no frame that the kernel delivered is lost, and frames that it dropped are counted.

use crate::interface::{Interface, transmitted};
use crate::running::{Running, canvass, run, text};
use std::io::Write as _;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

fn number_before(text: &str, words: &str) -> u64 {
    let at = text.find(words).unwrap_or_else(|| panic!("expected \"{words}\" in {text}"));
    text[..at].split_whitespace().last().unwrap().parse().unwrap()
}

/// Records cangen at full speed in three formats at once.
fn load(interface: &'static str, span: Duration) {
    let bus = Interface::new(interface);
    let folder = std::env::temp_dir();
    let outputs = ["pcapng", "mcap", "log"].map(|ending| folder.join(format!("{interface}.{ending}")));
    let outputs = outputs.map(|path| path.display().to_string());
    let [pcapng, mcap, log] = &outputs;
    let mut record = Running::start(canvass(&["record", bus.name(), pcapng, mcap, log, "--force"]));
    record.says("recording");
    let begun = Instant::now();
    let mut cangen = Command::new("cangen");
    cangen.args(["-g", "0", "-I", "123", "-L", "0", "-i", bus.name()]).stdin(Stdio::null());
    let cangen = Running::start(cangen);
    std::thread::sleep(span);
    cangen.kill();
    let took = begun.elapsed();
    let sent = transmitted(bus.name());
    std::thread::sleep(Duration::from_secs(2));
    let ended = record.interrupt();
    // Earlier lines may report single losses; the last line reports the total.
    let total = ended.stderr.lines().last().unwrap_or_default();
    let (recorded, lost) = (number_before(total, " frames recorded"), number_before(total, " lost"));
    writeln!(
        std::io::stderr(),
        "figure: load: {sent} frames in {took:?}, {:.0} frames/s; {}",
        sent as f64 / took.as_secs_f64(),
        total
    )
    .unwrap();
    assert_eq!(recorded + lost, sent, "every frame is recorded or counted as lost: {}", ended.stderr);
    for output in &outputs {
        let quality = run(&["decode", output, "--node", "127", "--quality", "json", "--quality-out", "-"]);
        let quality: serde_json::Value = serde_json::from_slice(&quality.stdout)
            .unwrap_or_else(|error| panic!("{output}: {error}: {}", text(&quality.stderr)));
        assert_eq!(quality["total"]["frames"], recorded, "{output}");
    }
}

/// The load takes a few seconds, or the time that `cargo xtask vcan-load` sets.
#[test]
fn nothing_is_lost() {
    let seconds = std::env::var("CANVASS_LOAD_SECONDS").map_or(2, |seconds| seconds.parse().unwrap());
    load("vload", Duration::from_secs(seconds));
}
