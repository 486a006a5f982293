//! Rules about drives. They look only at nodes whose device profile is known to be CiA 402: from 1000h in the capture, or
//! from a description.

mod axes;
mod fault;
mod left_operation;
mod not_enabled;
