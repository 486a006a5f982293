//! The files that a pattern matches: a file, all files of a folder, or the matches of `*`, `?`, `[…]`, `{a,b}` and
//! `**`.

use super::access::locate;
use super::{AccessError, CaptureFile, is_url};
use datafusion::execution::runtime_env::RuntimeEnv;
use futures::TryStreamExt;
use globset::{GlobBuilder, GlobMatcher};
use std::io;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

/// Why a pattern gives no files.
#[derive(Debug, thiserror::Error)]
pub enum PatternError {
    /// The syntax of the pattern is wrong.
    #[error("\"{pattern}\" is no pattern for files: {source}")]
    Syntax {
        /// The pattern as the user gave it.
        pattern: String,
        /// The error in the pattern.
        source: globset::Error,
    },
    /// No file matches.
    #[error("no file matches \"{0}\"")]
    Nothing(String),
    /// A folder can't be read.
    #[error("can't read the folder {folder}: {source}", folder = folder.display())]
    Folder {
        /// The folder.
        folder: PathBuf,
        /// The reason.
        source: io::Error,
    },
    /// The object store can't be accessed.
    #[error(transparent)]
    Access(#[from] AccessError),
    /// The object store gave an error.
    #[error("can't list {name}: {reason}")]
    Store {
        /// The URL.
        name: String,
        /// The reason.
        reason: String,
    },
}

/// The files that a pattern matches, by name.
///
/// # Errors
/// [`PatternError`] if no file matches, or a folder or store can't be read.
pub async fn find(pattern: &str, runtime: &RuntimeEnv) -> Result<Vec<CaptureFile>, PatternError> {
    let mut found = if is_url(pattern) { in_store(pattern, runtime).await? } else { on_disk(pattern)? };
    found.sort();
    found.dedup();
    if found.is_empty() {
        return Err(PatternError::Nothing(pattern.to_owned()));
    }
    Ok(found)
}

/// The part of a pattern before the first path component with a wildcard, and whether there is a wildcard.
fn fixed_part(pattern: &str) -> (&str, bool) {
    match pattern.find(['*', '?', '[', '{']) {
        None => (pattern, false),
        Some(wildcard) => {
            (pattern.get(..wildcard).and_then(|head| head.rfind('/')).map_or("", |at| &pattern[..=at]), true)
        }
    }
}

fn matcher(pattern: &str) -> Result<GlobMatcher, PatternError> {
    let glob = GlobBuilder::new(pattern).literal_separator(true).build();
    Ok(glob.map_err(|source| PatternError::Syntax { pattern: pattern.to_owned(), source })?.compile_matcher())
}

fn on_disk(pattern: &str) -> Result<Vec<CaptureFile>, PatternError> {
    let (base, has_wildcard) = fixed_part(pattern);
    let mut found = Vec::new();
    let path = Path::new(pattern);
    // An existing file takes precedence: its name may contain wildcard characters.
    if let Ok(metadata) = path.metadata()
        && metadata.is_file()
    {
        return Ok(vec![on_disk_file(pattern.to_owned(), &metadata)]);
    }
    if path.is_dir() {
        walk(path, &|_| true, &mut found)?;
    } else if has_wildcard {
        let glob = matcher(pattern)?;
        let start = if base.is_empty() { Path::new(".") } else { Path::new(base) };
        let matches = |path: &Path| glob.is_match(path.strip_prefix("./").unwrap_or(path)) || glob.is_match(path);
        if start.is_dir() {
            walk(start, &matches, &mut found)?;
        }
        if base.is_empty() {
            found.iter_mut().for_each(|file| file.name = file.name.trim_start_matches("./").to_owned());
        }
    }
    Ok(found)
}

fn walk(folder: &Path, matches: &dyn Fn(&Path) -> bool, found: &mut Vec<CaptureFile>) -> Result<(), PatternError> {
    let unreadable = |source| PatternError::Folder { folder: folder.to_owned(), source };
    for entry in folder.read_dir().map_err(unreadable)? {
        let entry = entry.map_err(unreadable)?;
        let (path, metadata) = (entry.path(), entry.metadata());
        // The file was deleted after the folder was listed.
        let Ok(metadata) = metadata.and_then(|own| if own.is_symlink() { path.metadata() } else { Ok(own) }) else {
            continue;
        };
        if metadata.is_dir() && !entry.path().is_symlink() {
            walk(&path, matches, found)?;
        } else if metadata.is_file() && matches(&path) {
            found.push(on_disk_file(path.display().to_string(), &metadata));
        }
    }
    Ok(())
}

fn on_disk_file(name: String, metadata: &std::fs::Metadata) -> CaptureFile {
    let since_1970 = metadata.modified().ok().and_then(|time| time.duration_since(UNIX_EPOCH).ok());
    let modified = since_1970.and_then(|since| i64::try_from(since.as_nanos()).ok()).unwrap_or(0);
    CaptureFile { name, path: None, size: metadata.len(), modified }
}

fn in_store_file(name: String, object: &object_store::ObjectMeta) -> CaptureFile {
    let modified = object.last_modified.timestamp_nanos_opt().unwrap_or(0);
    CaptureFile { name, path: None, size: object.size, modified }
}

async fn in_store(pattern: &str, runtime: &RuntimeEnv) -> Result<Vec<CaptureFile>, PatternError> {
    let (base, has_wildcard) = fixed_part(pattern);
    let (store, prefix) = locate(runtime, base)?;
    let root = base.strip_suffix(prefix.as_ref()).or_else(|| base.strip_suffix('/')?.strip_suffix(prefix.as_ref()));
    let root = root.unwrap_or(base).trim_end_matches('/');
    let failed =
        |error: object_store::Error| PatternError::Store { name: pattern.to_owned(), reason: error.to_string() };
    let objects: Vec<_> = store.list(Some(&prefix)).try_collect().await.map_err(failed)?;
    let mut files: Vec<CaptureFile> =
        objects.into_iter().map(|object| in_store_file(format!("{root}/{}", object.location), &object)).collect();
    if has_wildcard {
        let glob = matcher(pattern)?;
        files.retain(|file| glob.is_match(&file.name));
    } else if files.is_empty() {
        // The pattern names no folder; it may name an object.
        use object_store::ObjectStoreExt as _;
        if let Ok(object) = store.head(&prefix).await {
            files.push(in_store_file(pattern.to_owned(), &object));
        }
    }
    Ok(files)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path, pattern: &str) -> Vec<String> {
        let found = on_disk(&format!("{}/{pattern}", folder.display())).unwrap();
        let base = format!("{}/", folder.display());
        let mut names: Vec<String> = found.into_iter().map(|file| file.name.replace(&base, "")).collect();
        names.sort();
        names
    }

    #[test]
    fn files_folders_and_patterns() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a.log", "b.mcap", "c.txt", "d[1].log", "deep/er/a.log", "deep/e.blf"] {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, "x").unwrap();
        }
        let found = |pattern| names(folder.path(), pattern);
        assert_eq!(found("a.log"), ["a.log"]);
        assert_eq!(found("d[1].log"), ["d[1].log"], "a file that is there is meant before a pattern");
        assert_eq!(found("*.log"), ["a.log", "d[1].log"]);
        assert_eq!(found("**/*.{log,blf}"), ["a.log", "d[1].log", "deep/e.blf", "deep/er/a.log"]);
        assert_eq!(found("deep"), ["deep/e.blf", "deep/er/a.log"]);
        assert!(found("*.pcap").is_empty() && found("none").is_empty() && found("none/*.log").is_empty());
    }
}
