//! The text formats, read and written through the public interface.

#[cfg(test)]
mod asc;
#[cfg(test)]
mod candump_console;
#[cfg(test)]
mod candump_log;
#[cfg(test)]
mod csv;
#[cfg(test)]
mod frames;
#[cfg(test)]
mod notation;
#[cfg(test)]
mod pasted;
#[cfg(test)]
mod pasted_forms;
#[cfg(test)]
mod pasted_nothing;
#[cfg(test)]
mod pasted_pitfalls;
#[cfg(test)]
mod pasted_times;
#[cfg(test)]
mod pasted_tools;
#[cfg(test)]
mod samples;
#[cfg(test)]
mod trc;
