//! The seeds: real files of every kind that the program reads.

use super::chance::Chance;
use super::limited::Program;
use anyhow::{Context, Result, ensure};
use std::fs;
use std::path::Path;

/// The kind of a file.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum SeedKind {
    Capture,
    Description,
    Result,
    Waivers,
    Journal,
}

/// Whether a row of a text is a frame.
pub type IsFrame = fn(&[u8]) -> bool;

/// A real file.
pub struct Seed {
    pub kind: SeedKind,
    pub name: String,
    /// The end of the file name, by which some formats are recognised.
    pub ending: String,
    pub bytes: Vec<u8>,
    /// For a text with rows: whether a row is a frame.
    pub is_frame: Option<IsFrame>,
}

pub struct Seeds(Vec<Seed>);

/// The capture from which files of row formats are made.
const ROWS: &str = "traces/samples/python-can.log";

const WAIVERS: &str = "[[waiver]]\ncase = \"301/sdo/*\"\nsubject = \"1000h\"\ndoes = \"silence\"\nreason = \"known\"\n\
                       until = 2030-01-01\n";

const JOURNAL: &str = "canvass journal 1\nbus can0\nnode 10\ndevice reference-301\noperational yes\n\
                       value 1017:00 E803\nvalue 1800:01 8A010000\nbegun\nvalue 2041:00 41010000\nstores\nsettled\n";

impl SeedKind {
    /// Some of the commands that read files of this kind; `FILE` stands for the file.
    pub fn commands(self, chance: &mut Chance) -> Vec<String> {
        let all: &[&str] = match self {
            Self::Capture => &[
                "decode FILE",
                "decode FILE --format json",
                "decode FILE --format csv --in-order",
                "decode FILE --format table --time utc",
                "decode FILE --events",
                "decode FILE --events --format json --device 5=kuebler-sendix-58x8",
                "decode FILE --from +1 --to +2 --node 5 --filter service=sdo",
                "decode FILE FILE --quality",
                "diagnose FILE",
                "diagnose FILE --format json",
                "diagnose FILE --format html",
                "diagnose FILE --format junit",
                "diagnose FILE --format markdown --verbose",
                "signals FILE --device 63=kuebler-sendix-58x8",
                "signals FILE --format json --every 1000",
                "convert FILE - --to pcapng",
                "convert FILE - --to pcap",
                "convert FILE - --to mcap",
                "convert FILE - --to asc",
                "convert FILE - --to trc",
                "convert FILE - --to csv",
                "fuzz sim:reference-301 --replay FILE",
            ],
            Self::Description => &[
                "decode traces/samples/python-can.log --device 5=FILE",
                "diagnose traces/samples/python-can.log --device 5=FILE",
                "simulate FILE sim:reference-301 --for 2",
                "test sim:reference-301 --device FILE --select 301/identity",
                "scan sim:FILE --no-lss --listen 100ms",
            ],
            Self::Result => &["compare FILE FILE", "compare target/attack/result.json FILE --format json"],
            Self::Waivers => &["test sim:reference-301 --select 301/identity --waivers FILE"],
            // No program listens there; the journal is read first.
            Self::Journal => &["restore slcan:tcp://127.0.0.1:1 --journal FILE"],
        };
        let mut some: Vec<String> = all.iter().map(|command| (*command).to_owned()).collect();
        while some.len() > 3 {
            some.swap_remove(chance.below(some.len()));
        }
        some
    }
}

impl Seeds {
    /// The samples, the descriptions of the models, and files that the program makes from them.
    pub fn gather(program: &Program, folder: &Path) -> Result<Self> {
        let mut seeds = Vec::new();
        for (kind, from) in [
            (SeedKind::Capture, "traces/samples"),
            (SeedKind::Description, "conformance/device/models"),
            (SeedKind::Description, "analyzer/tests/eds"),
        ] {
            for entry in fs::read_dir(from).with_context(|| from.to_owned())? {
                let path = entry?.path();
                let ending = path.extension().unwrap_or_default().to_string_lossy().into_owned();
                if path.is_file() && !["md", "py", "frames", "toml"].contains(&&*ending) {
                    let name = path.display().to_string();
                    let bytes = fs::read(&path)?;
                    seeds.push(Seed { kind, name, ending, bytes, is_frame: None });
                }
            }
        }
        let rows: [(&str, &str, IsFrame); 4] = [
            ("candump", "log", |row| !row.is_empty()),
            ("csv", "csv", |row| row.first().is_some_and(u8::is_ascii_digit)),
            ("trc", "trc", |row| row.first().is_some_and(|&first| first != b';')),
            ("asc", "asc", |row| [&b" Rx "[..], b" Tx "].iter().any(|word| row.windows(4).any(|part| part == *word))),
        ];
        for (format, ending, is_frame) in rows {
            let bytes = program.good(&["convert", ROWS, "-", "--to", format])?;
            let name = format!("{ROWS} as {format}");
            seeds.push(Seed {
                kind: SeedKind::Capture,
                name,
                ending: ending.to_owned(),
                bytes,
                is_frame: Some(is_frame),
            });
        }
        for format in ["pcapng", "pcap", "mcap"] {
            let bytes = program.good(&["convert", ROWS, "-", "--to", format])?;
            let name = format!("{ROWS} as {format}");
            seeds.push(Seed { kind: SeedKind::Capture, name, ending: format.to_owned(), bytes, is_frame: None });
        }
        let result = program.good(&["test", "sim:reference-301", "--select", "301/identity", "--format", "json"])?;
        fs::write(folder.join("result.json"), &result)?;
        for (kind, ending, bytes) in [
            (SeedKind::Result, "json", result),
            (SeedKind::Waivers, "toml", WAIVERS.into()),
            (SeedKind::Journal, "journal", JOURNAL.into()),
        ] {
            seeds.push(Seed { kind, name: format!("{kind:?}"), ending: ending.to_owned(), bytes, is_frame: None });
        }
        ensure!(seeds.len() > 40, "only {} seeds were found", seeds.len());
        Ok(Self(seeds))
    }

    /// A random seed; in half of the cases a seed with countable rows.
    pub fn any(&self, chance: &mut Chance) -> &Seed {
        let counted: Vec<&Seed> = self.0.iter().filter(|seed| seed.is_frame.is_some()).collect();
        let picked = if chance.below(2) == 0 { chance.of(&counted).copied() } else { chance.of(&self.0) };
        picked.unwrap_or(&self.0[0])
    }
}
