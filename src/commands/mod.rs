//! One file per subcommand: what was typed becomes objects, the objects do the work.

pub mod compare;
pub mod completions;
pub mod convert;
pub mod decode;
mod decode_events;
pub mod diagnose;
pub mod doctor;
pub mod eds;
pub mod explain;
pub mod fuzz;
pub mod help;
pub mod history;
pub mod list;
pub mod lss;
pub mod man;
pub mod monitor;
pub mod nmt;
pub mod record;
pub mod restore;
pub mod scan;
pub mod sdo;
pub mod selftest;
pub mod send;
pub mod signals;
pub mod simulate;
pub mod test;
pub mod verify;
