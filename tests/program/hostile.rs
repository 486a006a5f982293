//! Captures that attack the program: it reports a clear error, does not crash, and needs little memory.

use crate::running::{Run, finished};
use std::io::{self, Read, Write};
use std::process::{Command, Stdio};

/// Size in KiB of the program itself in memory, built for tests and measured by `size`.
const IMAGE: usize = 38_000;
/// Limit of the program's virtual memory in KiB; the memory in use is less.
const MEMORY: usize = IMAGE + 80_000;

/// Runs the program on the output of `write`, with this limit of memory.
fn run(args: &str, write: impl FnOnce(&mut dyn Write) -> io::Result<()> + Send) -> Run {
    run_within(MEMORY, args, write)
}

fn run_within(memory: usize, args: &str, write: impl FnOnce(&mut dyn Write) -> io::Result<()> + Send) -> Run {
    let shell = format!("ulimit -v {memory} && exec \"$0\" {args}");
    let mut child = Command::new("sh")
        .args(["-c", &shell, env!("CARGO_BIN_EXE_canvass")])
        // Without this variable each thread would reserve 64 MiB of addresses.
        .env("MALLOC_ARENA_MAX", "1")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stdin = child.stdin.take().unwrap();
    std::thread::scope(|scope| {
        // The program may end before it has read everything.
        scope.spawn(move || write(&mut stdin).or_else(closed));
        finished(child.wait_with_output().unwrap())
    })
}

fn closed(error: io::Error) -> io::Result<()> {
    if error.kind() == io::ErrorKind::BrokenPipe { Ok(()) } else { Err(error) }
}

/// `decode` and `convert` both print `report` and end with `status`; `decode` prints `lines` lines before it.
fn says(report: &str, status: i32, lines: usize, write: impl Fn(&mut dyn Write) -> io::Result<()> + Send + Sync) {
    let decoded = run("decode -", &write);
    assert!(decoded.stderr.contains(report), "{}", decoded.stderr);
    assert!(decoded.stderr.lines().count() < 10, "{}", decoded.stderr);
    assert_eq!((decoded.status, decoded.stdout.lines().count()), (status, lines), "{}", decoded.stderr);
    let converted = run("convert --to candump - -", &write);
    assert!(converted.stderr.contains(report), "{}", converted.stderr);
    assert_eq!(converted.status, status, "{}", converted.stderr);
    if status == 0 {
        assert_eq!(converted.stdout.lines().count(), lines);
    }
}

fn sample(name: &str) -> Vec<u8> {
    std::fs::read(format!("{}/traces/samples/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

/// Writes `count` equal bytes.
fn fill(out: &mut dyn Write, byte: u8, count: u64) -> io::Result<()> {
    let block = vec![byte; 1 << 20];
    (0..count >> 20).try_for_each(|_| out.write_all(&block))
}

fn mcap_chunk(record: u64, uncompressed: u64, compression: &str, compressed: u64) -> Vec<u8> {
    let mut file = b"\x89MCAP0\r\n\x06".to_vec();
    file.extend(record.to_le_bytes());
    file.extend([0; 16]);
    file.extend(uncompressed.to_le_bytes());
    file.extend([0; 4]);
    file.extend((compression.len() as u32).to_le_bytes());
    file.extend(compression.as_bytes());
    file.extend(compressed.to_le_bytes());
    file
}

#[test]
fn an_mcap_chunk_of_2_to_the_63_bytes() {
    for compression in ["", "zstd", "lz4"] {
        for (record, compressed, report) in [
            (1 << 63, 1 << 62, "expected a record of 9223372036854775808 bytes, found \"the end of the file\""),
            (50 << 20, 40 << 20, "expected a chunk of at most 33554432 bytes, uncompressed"),
        ] {
            says(report, 0, 0, |out| {
                out.write_all(&mcap_chunk(record, 1 << 63, compression, compressed))?;
                fill(out, 0, 60 << 20)
            });
        }
    }
}

#[test]
fn an_mcap_chunk_that_is_as_large_as_it_may_be() {
    let size = 32 << 20;
    let bomb = zstd::encode_all(io::repeat(0).take(size), 1).unwrap();
    says("malformed", 0, 0, |out| {
        out.write_all(&mcap_chunk(44 + bomb.len() as u64, size, "zstd", bomb.len() as u64))?;
        out.write_all(&bomb)
    });
}

#[test]
fn pcapng_blocks_of_length_0_and_4_gib() {
    for (length, status, report) in [
        (0_u32, 2, "expected a block of at least 12 bytes, found \"length 0\""),
        (u32::MAX, 0, "expected a block of 4294967296 bytes, found \"the end of the file"),
    ] {
        let mut file = sample("two-interfaces.pcapng");
        file.extend(6_u32.to_le_bytes());
        file.extend(length.to_le_bytes());
        says(report, status, 24, |out| {
            out.write_all(&file)?;
            fill(out, 0, 50 << 20)
        });
    }
}

#[test]
fn an_asc_line_of_1_gib() {
    let head = "date Tue Nov 14 12:00:00.000 2023\nbase hex  timestamps absolute\ninternal events logged\n";
    says("expected a line of at most 65536 bytes", 0, 1, |out| {
        out.write_all(head.as_bytes())?;
        fill(out, b'1', 1 << 30)?;
        out.write_all(b"\n   0.100000 1  181             Rx   d 1 05\n")
    });
}

#[test]
fn blf_containers_that_inflate_without_end() {
    let mut zlib = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    io::copy(&mut io::repeat(0).take(300 << 20), &mut zlib).unwrap();
    let bomb = zlib.finish().unwrap();
    for (claimed, report) in [
        (1_000_u32, "expected a container of 1000 bytes, uncompressed, found \"more\""),
        (u32::MAX, "of at most"),
        (32 << 20, "found \"more\""),
    ] {
        let mut file = sample("python-can.blf")[..144].to_vec();
        file.extend(b"LOBJ\x10\0\x01\0");
        file.extend((32 + bomb.len() as u32).to_le_bytes());
        file.extend([10, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0]);
        file.extend(claimed.to_le_bytes());
        file.extend([0; 4]);
        file.extend(&bomb);
        says(report, 0, 0, |out| out.write_all(&file));
    }
}

/// A gzip stream of many members, which the decompressor treats as one stream.
fn gzip_bomb(out: &mut dyn Write, head: &[u8], byte: u8) -> io::Result<()> {
    let member = |content: &mut dyn Read| -> io::Result<Vec<u8>> {
        let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        io::copy(content, &mut gzip)?;
        gzip.finish()
    };
    out.write_all(&member(&mut io::Cursor::new(head))?)?;
    let bomb = member(&mut io::repeat(byte).take(16 << 20))?;
    (0..64).try_for_each(|_| out.write_all(&bomb))
}

#[test]
fn gzip_bombs() {
    says("has no known format", 2, 0, |out| gzip_bomb(out, b"", 0));
    let log = b"(1700000000.000000) can0 701#05\n";
    says("expected a line of at most 65536 bytes", 0, 1, |out| gzip_bomb(out, log, b'('));
    says("expected", 2, 24, |out| gzip_bomb(out, &sample("tcpdump-us.pcap"), 0xFF));
}

/// A command that reads a whole file stops when the file is longer than such files can be.
#[test]
fn a_file_without_end_for_whatever_is_read() {
    let sample = format!("{}/traces/samples/python-can.log", env!("CARGO_MANIFEST_DIR"));
    let zero = "/dev/zero";
    let sim = "sim:reference-301";
    for args in [
        format!("decode {sample} --device 5={zero}"),
        format!("diagnose {sample} --device 5={zero}"),
        format!("signals {sample} --device 5={zero}"),
        format!("decode {zero}"),
        format!("eds check {zero}"),
        format!("eds diff {zero} {zero}"),
        format!("eds convert {zero} - --to xdd"),
        format!("eds show {zero}"),
        format!("eds verify {zero} {sim}"),
        format!("scan sim:{zero}"),
        format!("scan {sim}~csv={zero}"),
        format!("simulate {zero} {sim} --for 1"),
        format!("simulate reference-301 {sim} --for 1 --memory {zero}"),
        format!("test {sim} --device {zero}"),
        format!("test {sim} --waivers {zero}"),
        format!("test {sim} --failed-from {zero}"),
        format!("fuzz {sim} --replay {zero}"),
        format!("fuzz {sim} --runs 1 --regressions {zero}"),
        format!("restore {sim} --journal {zero}"),
        format!("compare {zero} {zero}"),
        format!("history {zero} {zero}"),
        format!("verify {zero}"),
    ] {
        let ended = run_within(400_000, &args, |_| Ok(()));
        assert!((1..=3).contains(&ended.status), "{args}: {}, {}", ended.status, ended.stderr);
        assert!(!ended.stderr.contains("panicked") && ended.stderr.lines().count() < 10, "{args}: {}", ended.stderr);
    }
}

/// All kinds of characters with effects: a control sequence, a line that imitates a message, bidirectional controls,
/// line and paragraph separators, an invisible mark, a tag.
const ACTING: &str = "a\u{1b}[2J\ncanvass: all is well\u{202e}\u{2066}\u{2028}\u{2029}\u{feff}\u{e0041}b";

/// Authors of files choose the names of files, channels and waivers; no output prints them with effect.
#[test]
fn names_do_not_act() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    // The characters are in a file name, and in each place of a capture that holds text.
    let capture = path(&format!("{ACTING}.log"));
    let channel: String = ACTING.chars().filter(|c| !c.is_whitespace() && *c != '\u{2028}').collect();
    std::fs::write(&capture, format!("(1700000000.000000) {channel} 701#05\n{ACTING}\n(1.0) x {ACTING}\n")).unwrap();
    let eds = path(&format!("{ACTING}.eds"));
    std::fs::write(&eds, format!("[DeviceInfo]\nProductName={channel}\n[{channel}]\n{channel}\n[1000]\nX={channel}"))
        .unwrap();
    let waivers = path("waivers.toml");
    let id = "a\\u001b[2J\\ncanvass: all is well\\u202e\\u2066\\u2028\\ufeff\\U000e0041b";
    std::fs::write(
        &waivers,
        format!("[[waiver]]\ncase = \"{id}\"\nsubject = \"{id}\"\ndoes = \"{id}\"\nreason = \"{id}\"\n"),
    )
    .unwrap();
    let (missing, device) = (path(ACTING), format!("1={eds}"));
    let (html, junit, markdown) = (path("h"), path("j"), path("m"));
    let report = |format: &str, file: &str| format!("{format}={file}");
    let (html_report, junit_report) = (report("html", &html), report("junit", &junit));
    let markdown_report = report("markdown", &markdown);
    let test = ["test", "sim:reference-301", "--select", "301/identity", "--device", &eds];
    let commands: Vec<Vec<&str>> = vec![
        vec!["decode", &capture],
        vec!["decode", &capture, "--format", "table", "--quality"],
        vec!["decode", &capture, "--format", "csv", "--device", &device],
        vec!["decode", &capture, "--events"],
        vec!["decode", &capture, "--channel", ACTING],
        vec!["decode", &missing],
        vec!["diagnose", &capture, "--device", &device],
        vec!["diagnose", &capture, "--format", "html"],
        vec!["diagnose", &capture, "--format", "junit"],
        vec!["diagnose", &capture, "--format", "markdown"],
        vec!["diagnose", &capture, "--format", "json"],
        vec!["signals", &capture],
        vec!["convert", &capture, &missing],
        vec!["fuzz", "sim:reference-301", "--replay", &capture],
        vec!["test", "sim:reference-301", "--select", "301/identity", "--waivers", &waivers],
        [&test[..], &["--report", &html_report, "--report", &junit_report, "--report", &markdown_report]].concat(),
        vec!["simulate", &missing, "sim:reference-301", "--for", "1"],
        vec!["scan", &missing],
        vec!["compare", &capture, &missing],
    ];
    let acts = |text: &str| {
        // Lines are checked by their beginning: a name must not produce such a line.
        let acting = text.chars().find(|&c| c != '\n' && canvass_reports::escape::acts(c));
        acting.map(|c| format!("{c:?}")).or_else(|| {
            let forged = text.lines().find(|line| line.starts_with("canvass: all is well"));
            forged.map(str::to_owned)
        })
    };
    for args in commands {
        let run = finished(crate::running::command(&args).stdin(Stdio::null()).output().unwrap());
        for (stream, text) in [("output", &run.stdout), ("error", &run.stderr)] {
            assert_eq!(acts(text), None, "standard {stream} of {args:?}: {text}");
        }
    }
    for file in [&html, &junit, &markdown] {
        let text = std::fs::read_to_string(file).unwrap();
        assert_eq!(acts(&text), None, "{file}: {text}");
    }
}
