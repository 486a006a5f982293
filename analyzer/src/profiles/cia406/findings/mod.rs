//! Rules about encoders. They look only at nodes whose device profile is known to be CiA 406: from 1000h in the capture, or
//! from a description.

mod alarm;
mod node;
mod parameter_changed;
mod position_frozen;
mod position_jump;
mod position_outside_range;
mod raw_position;
mod redundant_channels;
mod warning;
