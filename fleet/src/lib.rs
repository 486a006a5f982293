//! SQL over captures and results of test runs, as tables.
//!
//! - [`table`]: the tables and their columns, the only definition of the schema;
//! - [`capture`]: files found and read, on disk and in object stores;
//! - [`cluster`]: queries over several computers;
//! - [`filter`]: filters that are applied before a row is made;
//! - [`lake`]: captures and results as Parquet;
//! - [`render`]: answers as tables, JSON, CSV, Parquet and Arrow;
//! - [`report`]: the contents of a lake, for a page;
//! - [`scan`]: captures as tables of the query engine;
//! - [`devices`]: which device a node is;
//! - [`stores`]: object stores;
//! - [`session`]: the query engine with our tables;
//! - [`views`]: the usual questions, as SQL.

#![warn(clippy::disallowed_methods)]

pub mod capture;
pub mod cluster;
pub mod devices;
pub mod filter;
pub mod lake;
pub mod render;
pub mod report;
pub mod scan;
pub mod session;
pub mod stores;
pub mod table;
pub mod views;
