//! A run of an ingest: finds new files, reads them, and commits their entries meanwhile.

use super::plan::{IngestSpec, IngestTable};
use super::{Entry, LakeError, Location, Snapshot, leftovers, rules};
use crate::capture::{Access, CaptureFile, find, is_url};
use crate::devices::Devices;
use crate::scan::{ScanError, partitions};
use datafusion::arrow::array::{Array as _, AsArray, RecordBatch};
use datafusion::error::{DataFusionError, Result};
use datafusion::prelude::SessionContext;
use futures::{StreamExt as _, TryStreamExt as _};
use object_store::ObjectStoreExt as _;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::{Duration, Instant};
use tokio::runtime::Handle;

/// The parameters of a run.
#[derive(Clone, Debug)]
pub struct Ingest {
    /// Files, folders and patterns, on disk or in an object store.
    pub sources: Vec<String>,
    /// The lake.
    pub lake: String,
    /// The rules of devices.
    pub devices: Devices,
    /// Whether files with unchanged length and time are hashed, too.
    pub rehash: bool,
    /// The place where the files were recorded. Files of two sites with equal paths are different files.
    pub site: Option<String>,
}

/// The progress of a run.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Progress {
    /// Number of finished files.
    pub files: usize,
    /// Number of bytes in the finished files.
    pub bytes: u64,
    /// Number of all files.
    pub all_files: usize,
    /// Number of bytes in all files.
    pub all_bytes: u64,
}

/// The result of a run.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Summary {
    /// Number of new files in the lake.
    pub added: usize,
    /// Number of files whose rows were replaced, as the file or the rules have changed.
    pub replaced: usize,
    /// Number of files that were in the lake already.
    pub known: usize,
    /// Number of files with the same content as another file, whose rows count for both.
    pub copies: usize,
    /// Files that could not be read, or not to their end, with the reason.
    pub broken: Vec<(String, String)>,
    /// Number of written rows.
    pub rows: u64,
    /// Number of written bytes.
    pub bytes: u64,
}

/// Number of waiting entries at which a commit is made. A commit is also made when the first entry has waited
/// [`LONGEST_WAIT`].
const WAITING: usize = 64;
const LONGEST_WAIT: Duration = Duration::from_secs(2);

impl Ingest {
    /// Runs the ingest in the session's process or on its cluster.
    ///
    /// # Errors
    /// If there is nothing to read, or the lake can't be written.
    pub async fn run(&self, session: &SessionContext, tell: &mut (dyn FnMut(Progress) + Send)) -> Result<Summary> {
        let runtime = session.runtime_env();
        let mut files = Vec::new();
        for source in &self.sources {
            files.extend(
                find(source, &runtime).await.map_err(ScanError::from)?.into_iter().map(|file| self.named(file)),
            );
        }
        files.sort();
        files.dedup_by(|one, other| one.name == other.name);
        let location = Location::of(&self.lake, &runtime)?;
        let mut run = Run::begin(location, rules(&self.devices)).await?;
        leftovers::delete(&run.location, run.snapshot.entries.values()).await?;
        let access = Access::new(runtime, Handle::current());
        let todo = run.plan(files, &access, self.rehash).await?;
        run.execute(self, session, todo, tell).await?;
        Ok(run.summary)
    }

    /// The file under its name in the lake: another spelling of a path is the same file, and the same spelling in
    /// another folder is another one.
    fn named(&self, file: CaptureFile) -> CaptureFile {
        if is_url(&file.name) {
            return file;
        }
        // A file that was deleted meanwhile is reported when it is read.
        let path =
            std::fs::canonicalize(&file.name).map_or_else(|_| file.name.clone(), |path| path.display().to_string());
        match &self.site {
            Some(site) => CaptureFile { name: format!("{site}:{path}"), path: Some(path), ..file },
            None => CaptureFile { name: path, ..file },
        }
    }
}

/// A run in progress.
struct Run {
    location: Location,
    snapshot: Snapshot,
    rules: String,
    summary: Summary,
    waiting: Vec<Entry>,
    waiting_since: Instant,
}

impl Run {
    async fn begin(location: Location, rules: String) -> Result<Self> {
        let mut snapshot = Snapshot::read(&location).await?;
        snapshot.begin(&location).await?;
        let (summary, waiting) = (Summary::default(), Vec::new());
        Ok(Self { location, snapshot, rules, summary, waiting, waiting_since: Instant::now() })
    }

    /// The files that have to be read. Known files are counted, copies get their entries.
    async fn plan(&mut self, files: Vec<CaptureFile>, access: &Access, rehash: bool) -> Result<Vec<CaptureFile>> {
        let all = files.len();
        let mut changed = self.changed(files, rehash);
        self.summary.known = all - changed.len();
        let left = self.left_copies(&changed);
        changed.extend(left);
        let hashes = self.hashes(&changed, access).await?;
        let (same, changed): (Vec<_>, Vec<_>) = changed.into_iter().partition(|file| self.is_same(file, &hashes));
        let changing: BTreeSet<&String> = changed.iter().map(|file| &file.name).collect();
        // For each content, the file whose rows are in the lake. Only files of one site are copies of each other: if one
        // of them changes, the other one has to be read, and another site's files can't be read here.
        let content = |file: &CaptureFile, sha256: &str| (file.site().map(str::to_owned), sha256.to_owned());
        let entries = self.snapshot.entries.values();
        let standing = entries.filter(|entry| entry.stands(&self.rules) && !changing.contains(&entry.file.name));
        let mut stands: BTreeMap<(Option<String>, String), String> =
            standing.map(|entry| (content(&entry.file, &entry.sha256), entry.file.name.clone())).collect();
        same.iter().for_each(|file| self.touch(file));
        let mut todo = Vec::new();
        for file in &changed {
            match hashes.get(&file.name).map(|sha256| (sha256, stands.get(&content(file, sha256)))) {
                Some((sha256, Some(of))) => self.copy(file, sha256, &of.clone()),
                Some((sha256, None)) => {
                    stands.insert(content(file, sha256), file.name.clone());
                    todo.push(file.clone());
                }
                None => todo.push(file.clone()),
            }
        }
        Ok(todo)
    }

    /// The files that differ from their entries in the lake, and the copies of these files.
    fn changed(&self, files: Vec<CaptureFile>, rehash: bool) -> Vec<CaptureFile> {
        let known = |file: &CaptureFile| self.snapshot.entries.get(&file.name);
        let is_changed = |file: &CaptureFile| rehash || known(file).is_none_or(|entry| !entry.is_of(file, &self.rules));
        let changing: BTreeSet<String> =
            files.iter().filter(|file| is_changed(file)).map(|file| file.name.clone()).collect();
        let is_copy = |file: &CaptureFile| {
            known(file).and_then(|entry| entry.copy_of.as_ref()).is_some_and(|of| changing.contains(of))
        };
        files.into_iter().filter(|file| changing.contains(&file.name) || is_copy(file)).collect()
    }

    /// The files whose rows were those of a changed file, and which are not among the files of this run. Their rows
    /// would be gone, so they are read.
    fn left_copies(&self, changed: &[CaptureFile]) -> Vec<CaptureFile> {
        let names: BTreeSet<&String> = changed.iter().map(|file| &file.name).collect();
        let is_left = |entry: &&Entry| {
            entry.copy_of.as_ref().is_some_and(|of| names.contains(of)) && !names.contains(&entry.file.name)
        };
        self.snapshot.entries.values().filter(is_left).map(|entry| entry.file.clone()).collect()
    }

    /// Whether only the time of a file has changed.
    fn is_same(&self, file: &CaptureFile, hashes: &BTreeMap<String, String>) -> bool {
        let entry = self.snapshot.entries.get(&file.name).filter(|entry| entry.stands(&self.rules));
        entry.is_some_and(|entry| hashes.get(&file.name) == Some(&entry.sha256))
    }

    /// The SHA-256 of each file that may equal another file, as both have the same length.
    async fn hashes(&self, files: &[CaptureFile], access: &Access) -> Result<BTreeMap<String, String>> {
        let mut lengths: BTreeMap<u64, usize> = BTreeMap::new();
        files.iter().for_each(|file| *lengths.entry(file.size).or_default() += 1);
        self.snapshot.entries.values().for_each(|entry| *lengths.entry(entry.file.size).or_default() += 1);
        let same = files.iter().filter(|file| lengths.get(&file.size).is_some_and(|count| *count > 1)).cloned();
        let hash = |file: CaptureFile| {
            let access = access.clone();
            // An unreadable file is reported when it is ingested.
            async move {
                let hashed = tokio::task::spawn_blocking(move || access.hash(&file).ok().map(|hash| (file.name, hash)));
                hashed.await.map_err(|error| DataFusionError::External(Box::new(error)))
            }
        };
        let hashed: Vec<Option<(String, String)>> =
            futures::stream::iter(same.map(hash)).buffered(8).try_collect().await?;
        Ok(hashed.into_iter().flatten().collect())
    }

    /// Updates the entry of a file with unchanged content: its rows stay.
    fn touch(&mut self, file: &CaptureFile) {
        if let Some(entry) = self.snapshot.entries.get(&file.name) {
            self.summary.known += 1;
            let touched = Entry { file: file.clone(), ..entry.clone() };
            self.wait(touched);
        }
    }

    /// Adds the entry of a file with the content of another file, whose rows count for both.
    fn copy(&mut self, file: &CaptureFile, sha256: &str, of: &str) {
        self.summary.copies += 1;
        let (file, rules, sha256) = (file.clone(), self.rules.clone(), sha256.to_owned());
        self.wait(Entry {
            file,
            rules,
            sha256,
            span: None,
            copy_of: Some(of.to_owned()),
            reason: None,
            parts: Vec::new(),
        });
    }

    fn wait(&mut self, entry: Entry) {
        if self.waiting.is_empty() {
            self.waiting_since = Instant::now();
        }
        self.waiting.push(entry);
    }

    async fn execute(
        &mut self,
        ingest: &Ingest,
        session: &SessionContext,
        todo: Vec<CaptureFile>,
        tell: &mut (dyn FnMut(Progress) + Send),
    ) -> Result<()> {
        let all_bytes = todo.iter().map(|file| file.size).sum();
        let mut progress = Progress { all_files: todo.len(), all_bytes, ..Progress::default() };
        tell(progress);
        let lake = self.location.url.to_string();
        let partitions = partitions(todo, session.state_ref().read().config().target_partitions());
        if !partitions.is_empty() {
            let spec = IngestSpec { lake, devices: ingest.devices.clone() };
            let mut entries =
                session.read_table(Arc::new(IngestTable::new(spec, partitions)))?.execute_stream().await?;
            while let Some(batch) = entries.next().await {
                for entry in read(&batch?)? {
                    progress.files += 1;
                    progress.bytes += entry.file.size;
                    self.take(entry);
                }
                tell(progress);
                if self.waiting.len() >= WAITING || self.waiting_since.elapsed() >= LONGEST_WAIT {
                    self.commit().await?;
                }
            }
        }
        self.commit().await
    }

    fn take(&mut self, entry: Entry) {
        match self.snapshot.entries.contains_key(&entry.file.name) {
            true => self.summary.replaced += 1,
            false => self.summary.added += 1,
        }
        if let Some(reason) = &entry.reason {
            self.summary.broken.push((entry.file.name.clone(), reason.clone()));
        }
        self.summary.rows += entry.parts.iter().map(|part| part.rows).sum::<u64>();
        self.summary.bytes += entry.parts.iter().map(|part| part.bytes).sum::<u64>();
        self.wait(entry);
    }

    /// Commits the waiting entries, and deletes the files of the entries that they replace.
    async fn commit(&mut self) -> Result<()> {
        if self.waiting.is_empty() {
            return Ok(());
        }
        let entries = std::mem::take(&mut self.waiting);
        let kept: BTreeSet<String> = entries.iter().flat_map(|entry| &entry.parts).map(super::Part::path).collect();
        let replaced = self.snapshot.commit(&self.location, entries).await?;
        let parts = replaced.iter().flat_map(|entry| &entry.parts).map(super::Part::path);
        for path in parts.filter(|path| !kept.contains(path)) {
            match self.location.store.delete(&self.location.path(&path)).await {
                Ok(()) | Err(object_store::Error::NotFound { .. }) => {}
                Err(error) => return Err(LakeError::from(error).into()),
            }
        }
        Ok(())
    }
}

/// The entries of a batch.
fn read(batch: &RecordBatch) -> Result<Vec<Entry>> {
    let wrong = |error: serde_json::Error| DataFusionError::External(Box::new(error));
    let column = batch.column(0);
    let texts: Vec<String> = match column.as_string_opt::<i32>() {
        Some(texts) => texts.iter().flatten().map(str::to_owned).collect(),
        None => column.as_string_view().iter().flatten().map(str::to_owned).collect(),
    };
    debug_assert_eq!(texts.len(), column.len());
    texts.iter().map(|text| serde_json::from_str(text).map_err(wrong)).collect()
}
