//! Captures and the results of test runs as tables, asked in SQL.
//!
//! - [`table`]: the tables and their columns, the only place that says the schema;
//! - [`capture`]: files found and read, on disk and in object stores;
//! - [`cluster`]: the same over several computers;
//! - [`filter`]: what is asked before a row is made;
//! - [`lake`]: captures and results as Parquet;
//! - [`render`]: answers as tables, JSON, CSV, Parquet and Arrow;
//! - [`report`]: what a lake tells, for a page;
//! - [`scan`]: captures as tables of the query engine;
//! - [`devices`]: which device a node is;
//! - [`stores`]: object stores;
//! - [`session`]: the query engine with all of it;
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
