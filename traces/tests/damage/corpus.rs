//! Captures of every format and variant: the samples of other tools, further forms that other tools write, and
//! compressed captures.

use canvass_traces::{Capture, Damage, Format, ReadOptions, Record, Source};
use std::io::Write;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A capture before it is damaged.
pub struct Sample {
    pub name: String,
    pub bytes: Vec<u8>,
    pub format: Format,
    pub frames: Vec<Record>,
    /// Whether the file is compressed as a whole.
    pub compressed: bool,
}

/// Rows in forms that no sample file has.
const ROWS: &[(&str, &str)] = &[
    (
        "minimon.csv",
        "ASCII Trace IXXAT MiniMon V3  Version: 1.1.4.4533\r\nDate: 28.01.2025\r\nStart time: 10:47:15\r\n\
         Baudrate: 250 kbit/s\r\n\"Time\";\"Identifier (hex)\";\"Format\";\"Flags\";\"Data (hex)\"\r\n\
         \"10:47:15.23\";\"83\";\"Std\";\"\";\"00 00 00 00 08 \"\r\n\"10:47:15.24\";\"701\";\"Std\";\"\";\"05 \"\r\n\
         \"10:47:15.24\";\"18FF1234\";\"Ext\";\"\";\"01 02 03 04 05 06 07 08 \"\r\n\"10:47:16.00\";\"80\";\"Std\";\"\";\"\"\r\n",
    ),
    (
        "1.0.trc",
        ";####\r\n;\r\n     1)     17535  00000100  8  00 11 22 33 44 55 66 77 \r\n     2)     17540  FFFFFFFF  4  00 00 00 08 \r\n\
         \u{20}    3)     17545  0701  1  05 \r\n",
    ),
    (
        "1.1.trc",
        ";$FILEVERSION=1.1\r\n;$STARTTIME=44548.6028595139\r\n;---+--\r\n\
         \u{20}    1)     17535.4  Tx     00000100  8  00 00 00 00 00 00 00 01 \r\n\
         \u{20}    2)     17540.3  Warng  FFFFFFFF  4  00 00 00 08  BUSHEAVY \r\n\
         \u{20}    3)     19295.4  Rx         0000  1  02 \r\n     4)     19468.9  Tx         0000  8  RTR\r\n",
    ),
    (
        "2.0.trc",
        ";$FILEVERSION=2.0\n;$STARTTIME=44548.6028595139\n;$COLUMNS=N,O,T,I,d,l,D\n\
         \u{20}     1     17535.400 DT 00000100 Tx 8  00 00 00 00 00 00 00 00\n\
         \u{20}     2     17540.300 ST          Rx    00 00 00 08\n\
         \u{20}     3     17541.300 FB     0100 Rx 12 00 01 02 03 04 05 06 07 08 09 0A 0B\n",
    ),
    (
        "everything.log",
        "(1700000000.000000001)     can0 701#05 R\n(1700000000.000100000) vcan-long 18FF1234#0102030405060708_C T\n\
         DROPCOUNT: dropped 3 CAN frames on 'can0' socket (total drops 3)\n(1700000000.000200000)     can0 123#R4\n\
         (1700000000.000300000)     can0 123##5000102030405060708090A0B\n(1700000000.000400000)     can0 20000080#0000000000000000\n\
         (1700000000.000500000)     can0 00123#81:00:12345678#112233\n",
    ),
    (
        "pasted.txt",
        "my trace:\n   0.100100 1  605             Tx   8 40 00 10 00 00 00 00 00\n\
         \u{20}  0.101000 1  585             Rx   8 43 00 10 00 92 01 02 00\n   0.500000 1  705             Rx   1 05\n\
         \u{20}  0.600000 2  18FF1234        Rx   3 01 02 03\n   0.700000 1  080             Rx   0\n",
    ),
    (
        "savvycan.csv",
        "Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8,\n\
         100100,00000605,false,Tx,0,8,40,00,10,00,00,00,00,00,\n101000,00000585,false,Rx,0,8,43,00,10,00,92,01,02,00,\n\
         500000,18FF1234,true,Rx,1,1,05,,,,,,,,\n",
    ),
    ("slcan.txt", "t60584000100000000000\nt58584300100092010200\nt705105\nr7051\n"),
    (
        "relative.asc",
        "date Tue Nov 14 12:00:00.000 2023\r\nbase dec  timestamps relative\r\nBegin TriggerBlock\r\n\
         \u{20}  0.100000 1  1793             Rx   d 1 05\r\n   0.100000 1  419361332x       Tx   d 2 01 255 Length = 0 BitCount = 0\r\n\
         \u{20}  0.000100 1  ErrorFrame\r\n   0.000200 2  256             Rx   r 3\r\nEnd TriggerBlock\r\n",
    ),
];

/// Samples that also get a variant compressed as a whole.
const COMPRESSED: [&str; 3] = ["python-can.log", "tcpdump-ns.pcap", "ros2-plain.mcap"];

/// All samples that `chosen` accepts.
pub fn samples(chosen: impl Fn(&Sample) -> bool) -> Vec<Sample> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("samples");
    let mut files: Vec<(String, Vec<u8>)> = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if !name.ends_with(".frames") && !name.ends_with(".md") && !name.ends_with(".py") {
            files.push((name, std::fs::read(&path).unwrap()));
        }
    }
    files.sort();
    let compressed = COMPRESSED.iter().flat_map(|wanted| {
        let plain = &files.iter().find(|file| file.0 == *wanted).unwrap().1;
        [(format!("{wanted}.gz"), gzip(plain)), (format!("{wanted}.zst"), zstd::encode_all(&plain[..], 3).unwrap())]
    });
    let compressed: Vec<_> = compressed.collect();
    let rows = ROWS.iter().map(|(name, rows)| ((*name).to_owned(), rows.as_bytes().to_vec()));
    files.into_iter().chain(rows).chain(compressed).map(|(name, bytes)| sample(name, bytes)).filter(chosen).collect()
}

fn sample(name: String, bytes: Vec<u8>) -> Sample {
    let capture = open(&bytes).unwrap_or_else(|| panic!("{name}"));
    let format = capture.format();
    let frames: Vec<_> = capture.filter_map(Result::ok).collect();
    assert!(!frames.is_empty(), "{name}");
    let compressed = name.ends_with(".gz") || name.ends_with(".zst");
    Sample { name, bytes, format, frames, compressed }
}

fn gzip(plain: &[u8]) -> Vec<u8> {
    let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    gzip.write_all(plain).unwrap();
    gzip.finish().unwrap()
}

/// The random generator Xorshift, which makes the same changes everywhere.
pub struct Xorshift(pub u64);

impl Xorshift {
    pub fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    pub fn below(&mut self, end: usize) -> usize {
        (self.next() % end.max(1) as u64) as usize
    }
}

/// A capture of these bytes; `None` if their format is unknown.
pub fn open(bytes: &[u8]) -> Option<Capture> {
    Capture::from_source("test", Source::from_bytes(bytes), &ReadOptions::default()).ok()
}

/// Whether `some` are the first frames of the sample. In MF4 each kind of frames has records of its own, which follow each
/// other: a part of the file has all frames of the first kinds.
pub fn are_first(sample: &Sample, some: &[Record]) -> bool {
    let mut all = sample.frames.iter();
    match sample.format {
        Format::Mf4 => some.iter().all(|frame| all.any(|other| other == frame)),
        _ => sample.frames.starts_with(some),
    }
}

/// All records and damages; `None` if the format of the bytes is unknown.
pub fn read(bytes: &[u8]) -> Option<(Vec<Record>, Vec<Damage>)> {
    let mut capture = open(bytes)?;
    let (mut frames, mut damages) = (Vec::new(), Vec::new());
    for item in capture.by_ref() {
        match item {
            Ok(record) => frames.push(record),
            Err(damage) => damages.push(damage),
        }
    }
    assert!(capture.next().is_none(), "the end is the end");
    Some((frames, damages))
}

/// Does the work for each sample on all processors, and joins the results.
pub fn each<T: Send>(samples: &[Sample], work: impl Fn(&Sample) -> Vec<T> + Sync) -> Vec<T> {
    let next = AtomicUsize::new(0);
    let worker = || {
        let taken = std::iter::from_fn(|| samples.get(next.fetch_add(1, Ordering::Relaxed)));
        taken.flat_map(&work).collect::<Vec<T>>()
    };
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..processors).map(|_| scope.spawn(worker)).collect();
        workers.into_iter().flat_map(|worker| worker.join().unwrap()).collect()
    })
}

/// Checks that no format lacks a sample.
#[test]
fn every_format_has_a_sample() {
    let samples = samples(|_| true);
    for format in Format::all() {
        assert!(samples.iter().any(|sample| sample.format == format), "{format}");
    }
}
