//! Rows for other programs: `decode --format csv` and `table`, `signals`.

use crate::running::{run, run_with_input};

const COMMISSIONING: &str = "docs/examples/commissioning.log";
const DEVICE: &str = "63=kuebler-sendix-58x8";

#[test]
fn frames_as_csv() {
    let frames = "\
(1738061235.000001) can0 63F#4018100100000000
(1738061235.500000) can0 00012345#R4
";
    let decoded = run_with_input(&["decode", "-", "--format", "csv", "--time", "utc"], frames);
    let expected = "\
t,channel,direction,id,extended,remote,dlc,data,node,service,index,sub,text,comment
2025-01-28T10:47:15.000001000Z,can0,,0x63F,false,false,8,40 18 10 01 00 00 00 00,63,sdo,0x1018,0x01,\"read 1018h:01 Identity object, Vendor-ID\",
2025-01-28T10:47:15.500000000Z,can0,,0x00012345,true,true,4,,,unknown,,,remote frame,
";
    assert_eq!(decoded.stdout, expected);
}

#[test]
fn cells_are_no_formulas() {
    let decoded = run_with_input(&["decode", "-", "--format", "csv"], "(1.000000) =cmd|'x'!A0 73F#00\n");
    assert!(decoded.stdout.contains(",'=cmd|'x'!A0,"), "{}", decoded.stdout);
}

#[test]
fn a_table_has_a_header_and_rules() {
    let decoded = run(&["decode", COMMISSIONING, "--format", "table", "--time", "delta"]);
    let lines: Vec<&str> = decoded.stdout.lines().collect();
    assert!(lines[0].starts_with("time         │ channel │ id  │ data"), "{}", lines[0]);
    assert!(lines[1].chars().all(|c| matches!(c, '─' | '┼')), "{}", lines[1]);
    assert!(lines[2].ends_with("│   63 │ boot-up     │ boot-up"), "{}", lines[2]);
    // Without a terminal no cell is cut.
    assert!(decoded.stdout.contains("Number of mapped application objects") && !decoded.stdout.contains('…'));
}

#[test]
fn signals_as_columns() {
    let printed = run(&["signals", COMMISSIONING, "--device", DEVICE]);
    let expected = "\
t [ns],channel,node,pdo,\"node 5 Speed value, Speed value channel 1 [rpm]\",node 5 Position value [steps],node 5 Position value [°]
1738061235550000000,can0,5,TPDO 2,1200,19642,863.173828
1738061235560000000,can0,5,TPDO 2,1199,19643,863.217773
";
    assert_eq!(printed.stdout, expected);
}

/// Two nodes whose mapping the trace shows; without a description their objects have no names.
const LEARNED: &str = "\
(1.000000) can0 601#40001A0000000000
(1.001000) can0 581#4F001A0001000000
(1.002000) can0 601#40001A0100000000
(1.003000) can0 581#43001A0110000020
(1.004000) can0 602#40001A0000000000
(1.005000) can0 582#4F001A0001000000
(1.006000) can0 602#40001A0100000000
(1.007000) can0 582#43001A0108000020
(2.000000) can0 181#0001
(2.010000) can0 182#07
(2.025000) can0 181#0002
(2.030000) can0 181#0003
";

#[test]
fn what_is_not_known_yet_is_empty() {
    let printed = run_with_input(&["signals", "-"], LEARNED);
    let expected = "\
t [ns],channel,node,pdo,node 1 2000h:00,node 2 2000h:00
2000000000,can0,1,TPDO 1,256,
2010000000,can0,2,TPDO 1,256,7
2025000000,can0,1,TPDO 1,512,7
2030000000,can0,1,TPDO 1,768,7
";
    assert_eq!(printed.stdout, expected, "{}", printed.stderr);
}

#[test]
fn rows_at_fixed_times_have_the_latest_values() {
    let printed = run_with_input(&["signals", "-", "--every", "10ms"], LEARNED);
    let expected = "\
t [ns],node 1 2000h:00,node 2 2000h:00
2000000000,256,
2010000000,256,7
2020000000,256,7
2030000000,768,7
";
    assert_eq!(printed.stdout, expected, "{}", printed.stderr);
    let wrong = run(&["signals", "-", "--every", "0"]);
    assert_eq!(wrong.status, 2);
}

#[test]
fn a_clock_that_jumps_makes_no_rows_without_end() {
    let jumping =
        format!("{LEARNED}(4000000000.000000) can0 181#0004\n(3.000000) can0 181#0005\n(3.010000) can0 182#08\n");
    let printed = run_with_input(&["signals", "-", "--every", "0.001ms"], &jumping);
    assert!(printed.stdout.lines().count() < 50_000, "{}", printed.stdout.lines().count());
    assert!(printed.stderr.contains("long silences left out"), "{}", printed.stderr);
    assert!(
        printed.stdout.lines().last().unwrap().starts_with("3010000000,1280,8"),
        "{:?}",
        printed.stdout.lines().last()
    );
}

#[test]
fn no_mapping_is_said() {
    let printed = run_with_input(&["signals", "-"], "(1.000000) can0 181#0001\n");
    assert_eq!((printed.status, printed.stdout.as_str()), (0, "t [ns],channel,node,pdo\n"));
    assert!(printed.stderr.contains("--device"), "{}", printed.stderr);
}

/// A position that rises by one step each 10 ms: drawn in the terminal, and as a picture.
#[test]
fn values_are_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("rising.log");
    let line = |n: u32| format!("({}.{:06}) can0 285#{}0000\n", n / 100, n % 100 * 10_000, hex(n));
    std::fs::write(&log, (0..200).map(line).collect::<String>()).unwrap();
    let log = log.to_str().unwrap();
    let drawn = run(&["plot", log, "--device", "5=kuebler-sendix-58x8", "--signal", "node 5 position steps"]);
    let lines: Vec<&str> = drawn.stdout.lines().collect();
    assert!(lines[0].contains("node 5 Position value [steps]"), "{} {}", drawn.stdout, drawn.stderr);
    assert!(lines[1].trim_start().starts_with("200 steps │"), "{}", drawn.stdout);
    assert!(lines[11].ends_with("2.0 s") && lines[12].ends_with("0 s is 0.000000 of the capture"), "{}", drawn.stdout);
    let picture = folder.path().join("rising.svg");
    let to = picture.to_str().unwrap();
    let written = run(&["plot", log, "--device", "5=kuebler-sendix-58x8", "--signal", "steps", "-o", to]);
    assert!(written.status == 0 && written.stdout.is_empty(), "{}", written.stderr);
    assert!(std::fs::read_to_string(&picture).unwrap().starts_with("<svg"));
    let other = run(&["plot", log, "--device", "5=kuebler-sendix-58x8", "--signal", "temperature"]);
    assert!(
        other.status == 2 && other.stderr.contains("expected one of node 5 Position value [steps]"),
        "{}",
        other.stderr
    );
    let unknown = run(&["plot", log]);
    assert!(unknown.stderr.contains("node 5 TPDO 2: the mapping is not known (200 PDOs)"), "{}", unknown.stderr);
    assert!(unknown.status == 2 && unknown.stderr.contains("--device 5=MODEL|FILE"), "{}", unknown.stderr);
}

/// The four bytes of a position, in the order of the bus.
fn hex(value: u32) -> String {
    value.to_le_bytes().iter().map(|byte| format!("{byte:02X}")).collect()
}
