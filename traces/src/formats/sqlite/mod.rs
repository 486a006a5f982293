//! python-can's SQLite databases (`.db`, `.sqlite`): one row of a table for each message.
//!
//! ```text
//! file     pages of equal size; the first begins with a header of 100 bytes: "SQLite format 3\0", page size (16 bits)
//! table    a tree of pages: interior pages (type 5) lead to leaf pages (type 13), which hold the rows
//! row      length, row number, sizes and types of the columns, values; what does not fit into the page follows in a
//!          chain of overflow pages
//! page 1   the table of all tables: type, name, name, first page, and the SQL that made it
//! ```
//!
//! Numbers are big-endian. The table is the first one with the columns `ts`, `arbitration_id` and `data`: python-can's
//! user may have given it another name. **A journal or write-ahead log beside the file is not read**: a file that its
//! recorder has not closed may lack the last messages.
//!
//! Times are doubles in seconds, which hold microseconds of present dates.

mod message;
mod pages;
mod reader;
mod row;

pub(crate) use reader::{open, sniff};
