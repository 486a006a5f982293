//! The program, end to end.

#[cfg(test)]
mod archive;
#[cfg(test)]
mod bounded;
#[cfg(test)]
mod bundle;
#[cfg(test)]
mod ci_page;
#[cfg(test)]
mod closed_output;
#[cfg(test)]
mod completion;
#[cfg(test)]
mod conformance;
#[cfg(test)]
mod contract;
#[cfg(test)]
mod decode;
#[cfg(test)]
mod diagnose;
#[cfg(test)]
mod eds_check;
#[cfg(test)]
mod eds_convert;
#[cfg(test)]
mod eds_diff;
#[cfg(test)]
mod eds_from_device;
#[cfg(test)]
mod eds_show;
#[cfg(test)]
mod eds_verify;
#[cfg(test)]
mod events;
#[cfg(test)]
mod everyday;
#[cfg(test)]
mod flooded;
#[cfg(test)]
mod fuzz;
#[cfg(test)]
mod history;
#[cfg(test)]
mod hostile;
#[cfg(test)]
mod killed;
#[cfg(test)]
mod live;
#[cfg(test)]
mod lsp;
#[cfg(test)]
mod marks;
#[cfg(test)]
mod memory;
#[cfg(test)]
mod one_language;
#[cfg(test)]
mod pages;
#[cfg(test)]
mod progress;
#[cfg(test)]
mod provenance;
#[cfg(test)]
mod quarantine;
#[cfg(test)]
mod rogues;
#[cfg(test)]
mod rows;
#[cfg(test)]
mod running;
#[cfg(test)]
mod settings;
#[cfg(test)]
mod terminals;
#[cfg(test)]
mod waiting;
