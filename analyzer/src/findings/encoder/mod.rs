//! Rules about encoders (CiA 406). They look only at nodes whose device profile is known to be that: from 1000h in the
//! capture, or from a description.

mod alarm;
mod kind;
mod parameter_changed;
mod position_frozen;
mod position_jump;
mod position_outside_range;
mod redundant_channels;
mod warning;
