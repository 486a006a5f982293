//! Random sequences of changes and ingests: a lake holds what the files held when they were read, once.

use crate::lake::{ingest_at, open, rows};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// A generator of numbers (Knuth's constants), so that a failure can be repeated by its seed.
struct Dice(u64);

impl Dice {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % end
    }
}

/// The text of a content: `content + 1` frames at times that no other content has.
fn text(content: usize) -> String {
    let begin = 1_700_000_000 + content * 1_000;
    (0..=content).map(|n| format!("({}.000000) can0 705#05\n", begin + n)).collect()
}

/// Number of frames of each content in the lake.
async fn contents(lake: &Path) -> BTreeMap<usize, usize> {
    let session = open(lake).await;
    let found = rows(&session, "SELECT CAST(t AS BIGINT) AS t FROM frames").await;
    let mut counts = BTreeMap::new();
    for row in found {
        let seconds = row["t"].as_i64().unwrap() / 1_000_000_000;
        *counts.entry(((seconds - 1_700_000_000) / 1_000) as usize).or_default() += 1;
    }
    counts
}

/// The files of a sequence.
struct Files {
    folder: tempfile::TempDir,
    /// What each file holds now.
    now: BTreeMap<PathBuf, usize>,
    /// What each file held when it was last read into the lake.
    read: BTreeMap<PathBuf, usize>,
    next: usize,
}

impl Files {
    /// Gives a file a new content, or that of another file.
    fn write(&mut self, dice: &mut Dice) {
        let path = self.folder.path().join(["one", "two"][dice.below(2)]).join(["a.log", "b.log"][dice.below(2)]);
        let others: Vec<usize> = self.now.values().copied().collect();
        let content = match others.is_empty() || dice.below(3) > 0 {
            true => {
                self.next += 1;
                self.next
            }
            false => others[dice.below(others.len())],
        };
        std::fs::write(&path, text(content)).unwrap();
        self.now.insert(path, content);
    }

    /// Reads a folder, a file or all into the lake, under one of several spellings.
    async fn ingest(&mut self, dice: &mut Dice, lake: &Path) {
        let root = self.folder.path().display().to_string();
        let below = ["", "/one", "/two", "/one/a.log", "/two/b.log"][dice.below(5)];
        let spelled = [format!("{root}{below}"), format!("{root}/two/..{below}"), format!("{root}/.{below}")];
        let chosen = self.folder.path().join(below.trim_start_matches('/'));
        if !self.now.keys().any(|path| path.starts_with(&chosen)) {
            return;
        }
        ingest_at(&spelled[dice.below(3)], lake, None).await;
        let read = self.now.iter().filter(|(path, _)| path.starts_with(&chosen));
        self.read.extend(read.map(|(path, content)| (path.clone(), *content)));
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_lake_holds_what_was_read_and_once() {
    for seed in 0..24 {
        let (mut dice, lake) = (Dice(seed), tempfile::tempdir().unwrap());
        let folder = tempfile::tempdir().unwrap();
        for name in ["one", "two"] {
            std::fs::create_dir(folder.path().join(name)).unwrap();
        }
        let mut files = Files { folder, now: BTreeMap::new(), read: BTreeMap::new(), next: 0 };
        for step in 0..12 {
            match dice.below(2) {
                0 => files.write(&mut dice),
                _ => files.ingest(&mut dice, lake.path()).await,
            }
            if files.read.is_empty() {
                continue;
            }
            let found = contents(lake.path()).await;
            // A file that has not changed since it was read has its rows.
            for (path, content) in files.read.iter().filter(|(path, content)| files.now[*path] == **content) {
                assert_eq!(found.get(content), Some(&(content + 1)), "seed {seed}, step {step}: {}", path.display());
            }
            assert!(found.iter().all(|(content, count)| *count == content + 1), "seed {seed}, step {step}: {found:?}");
        }
        // When everything has been read, the lake is that of the files as they are.
        if !files.now.is_empty() {
            ingest_at(&files.folder.path().display().to_string(), lake.path(), None).await;
            let live: BTreeSet<usize> = files.now.values().copied().collect();
            assert_eq!(contents(lake.path()).await.into_keys().collect::<BTreeSet<_>>(), live, "seed {seed}");
        }
    }
}
