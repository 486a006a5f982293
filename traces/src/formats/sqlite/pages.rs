//! Pages, and the trees that they make.

use super::row::varint;
use crate::damage::Flaw;

/// Length of the header of the file, on the first page.
const FILE_HEADER: usize = 100;
const INTERIOR: u8 = 5;
const LEAF: u8 = 13;
/// Limit of the depth of a tree; SQLite's own limit is 20.
const DEEPEST: usize = 32;
/// Limit of the length of a row; a message has less than 200 bytes.
const LONGEST: u64 = 64 * 1024;

/// The pages of a file.
pub(super) struct Pages {
    file: Vec<u8>,
    size: usize,
    /// Length of a page without the bytes that extensions reserve at its end.
    usable: usize,
}

/// A page, as its header describes it.
struct Page<'a> {
    bytes: &'a [u8],
    kind: u8,
    /// The offsets of the cells.
    cells: &'a [u8],
    /// The page behind the last cell of an interior page.
    last: u32,
}

/// A row of a table.
pub(super) struct Row {
    /// Its number, which SQLite counts from 1.
    pub number: u64,
    pub bytes: Vec<u8>,
}

impl Page<'_> {
    /// Checks the number of cells: without free blocks the first cell is where the header says that the cells begin, which
    /// is the end of a page without cells.
    fn check(&self, number_of_page: u32, usable: usize) -> Result<(), Flaw> {
        let at = if number_of_page == 1 { FILE_HEADER } else { 0 };
        let has_free_blocks = number(self.bytes, at + 1, 2) != Some(0);
        let begin = number(self.bytes, at + 5, 2).map(|begin| if begin == 0 { 65_536 } else { begin });
        let first = self.cells.chunks_exact(2).filter_map(|cell| number(cell, 0, 2)).min();
        if has_free_blocks || Some(first.unwrap_or(usable)) == begin {
            return Ok(());
        }
        let expected = format!("cells from byte {} of page {number_of_page} on", begin.unwrap_or_default());
        let found = first.map_or_else(|| "none".to_owned(), |first| format!("byte {first}"));
        Err(Flaw::malformed(expected, found).costing("some rows of the page"))
    }
}

/// A walk through a tree, row by row.
pub(super) struct Walk {
    /// The pages from the root to the current leaf, each with the number of its next cell.
    path: Vec<(u32, usize)>,
    /// Whether a page was visited: a damaged link may lead back.
    visited: Vec<bool>,
    /// Whether the page of the next row was checked.
    is_checked: bool,
}

fn number(bytes: &[u8], at: usize, length: usize) -> Option<usize> {
    let bytes = bytes.get(at..at.checked_add(length)?)?;
    Some(bytes.iter().fold(0, |number, &byte| number << 8 | usize::from(byte)))
}

impl Pages {
    /// Takes a file whose header states a page size.
    pub fn new(file: Vec<u8>) -> Result<Self, Flaw> {
        let size = match number(&file, 16, 2) {
            Some(1) => 65_536,
            Some(size) if size >= 512 && size.is_power_of_two() => size,
            found => {
                let found = found.map_or_else(|| "the end of the file".to_owned(), |size| size.to_string());
                return Err(Flaw::malformed("a page size: a power of two from 512 to 65536", found));
            }
        };
        let reserved = file.get(20).map_or(0, |byte| usize::from(*byte));
        // SQLite needs 480 bytes of a page.
        match size.checked_sub(reserved).filter(|usable| *usable >= 480) {
            Some(usable) => Ok(Self { file, size, usable }),
            None => Err(Flaw::malformed(
                "a page of at least 480 usable bytes",
                format!("{reserved} of {size} bytes reserved"),
            )),
        }
    }

    /// Number of pages that the header of the file states, if the file has fewer.
    pub fn missing(&self) -> Option<usize> {
        number(&self.file, 28, 4).filter(|stated| *stated > self.file.len() / self.size)
    }

    /// Size of the file in bytes.
    pub fn length(&self) -> u64 {
        self.file.len() as u64
    }

    /// The offset of a page; pages count from 1.
    pub fn offset(&self, page: u32) -> u64 {
        u64::from(page.saturating_sub(1)) * self.size as u64
    }

    fn bytes(&self, page: u32) -> Result<&[u8], Flaw> {
        let start = usize::try_from(page).ok().and_then(|page| page.checked_sub(1)?.checked_mul(self.size));
        let bytes = start.and_then(|start| self.file.get(start..start.checked_add(self.size)?));
        bytes.ok_or_else(|| Flaw::malformed(format!("page {page} within the file"), "its end"))
    }

    fn page(&self, page: u32) -> Result<Page<'_>, Flaw> {
        let bytes = self.bytes(page)?;
        let at = if page == 1 { FILE_HEADER } else { 0 };
        let unreadable = || Flaw::malformed(format!("page {page} of a table"), format!("type {}", bytes[at]));
        let kind = bytes[at];
        let header = match kind {
            INTERIOR => 12,
            LEAF => 8,
            _ => return Err(unreadable()),
        };
        let count = number(bytes, at + 3, 2).unwrap_or_default();
        let cells = bytes.get(at + header..at + header + 2 * count).ok_or_else(unreadable)?;
        let last = number(bytes, at + 8, 4).unwrap_or_default() as u32;
        Ok(Page { bytes, kind, cells, last })
    }

    /// Collects a row with its number: the part in the leaf, and its overflow pages.
    fn row(&self, page: &Page<'_>, cell: usize) -> Result<Row, Flaw> {
        let cut = || Flaw::malformed("a whole row", "the end of its page");
        let at = number(page.cells, 2 * cell, 2).ok_or_else(cut)?;
        let bytes = page.bytes.get(at..self.usable).ok_or_else(cut)?;
        let (length, rest) = varint(bytes).ok_or_else(cut)?;
        let (number_of_row, payload) = varint(rest).ok_or_else(cut)?;
        if length > LONGEST {
            return Err(Flaw::malformed(format!("a row of at most {LONGEST} bytes"), length.to_string()));
        }
        let length = length as usize;
        let local = self.local(length);
        let mut row = payload.get(..local).ok_or_else(cut)?.to_vec();
        let mut next = if local < length { number(payload, local, 4).ok_or_else(cut)? as u32 } else { 0 };
        while row.len() < length {
            let bytes = self.bytes(next)?;
            next = number(bytes, 0, 4).unwrap_or_default() as u32;
            let more = (length - row.len()).min(self.usable - 4);
            row.extend_from_slice(&bytes[4..4 + more]);
        }
        Ok(Row { number: number_of_row, bytes: row })
    }

    /// Number of bytes of a row of this length that are in the leaf itself.
    const fn local(&self, length: usize) -> usize {
        let most = self.usable - 35;
        if length <= most {
            return length;
        }
        let least = (self.usable - 12) * 32 / 255 - 23;
        let rest = least + (length - least) % (self.usable - 4);
        if rest <= most { rest } else { least }
    }
}

impl Walk {
    /// Begins at the root of a table.
    pub fn new(pages: &Pages, root: u32) -> Self {
        let mut walk =
            Self { path: Vec::new(), visited: vec![false; pages.file.len() / pages.size + 1], is_checked: false };
        // The root of a new walk was not visited.
        let _ = walk.enter(root);
        walk
    }

    /// Number of the page of the next row.
    pub fn page(&self) -> u32 {
        self.path.last().map_or(0, |(page, _)| *page)
    }

    fn enter(&mut self, page: u32) -> Result<(), Flaw> {
        let visited = usize::try_from(page).ok().and_then(|page| self.visited.get_mut(page));
        // A page outside the file is reported when it is read.
        let is_new = visited.is_none_or(|visited| !std::mem::replace(visited, true));
        if !is_new || self.path.len() >= DEEPEST {
            return Err(Flaw::malformed("a page that no other page leads to", format!("page {page} again")));
        }
        self.path.push((page, 0));
        self.is_checked = false;
        Ok(())
    }

    /// The next row; `None` at the end. After an error the walk goes on behind the damaged page or row.
    pub fn next(&mut self, pages: &Pages) -> Option<Result<Row, Flaw>> {
        loop {
            let (number_of_page, cell) = self.path.last_mut()?;
            let at = *cell;
            *cell += 1;
            let page = match pages.page(*number_of_page) {
                Ok(page) => page,
                Err(flaw) => {
                    self.path.pop();
                    return Some(Err(flaw.costing("its rows")));
                }
            };
            if at == 0
                && !std::mem::replace(&mut self.is_checked, true)
                && let Err(flaw) = page.check(*number_of_page, pages.usable)
            {
                *cell = 0;
                return Some(Err(flaw));
            }
            let count = page.cells.len() / 2;
            if page.kind == LEAF {
                if at < count {
                    return Some(pages.row(&page, at));
                }
                self.path.pop();
                continue;
            }
            let child = match at {
                at if at < count => number(page.cells, 2 * at, 2).and_then(|at| number(page.bytes, at, 4)),
                at if at == count => Some(page.last as usize),
                _ => {
                    self.path.pop();
                    continue;
                }
            };
            let child = child.and_then(|child| u32::try_from(child).ok());
            let entered = match child {
                Some(child) => self.enter(child),
                None => Err(Flaw::malformed("the number of a page", "the end of the page before it")),
            };
            if let Err(flaw) = entered {
                return Some(Err(flaw.costing("its rows")));
            }
        }
    }
}
