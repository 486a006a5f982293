//! What a network knows of its nodes, and what frames bring about.

#[cfg(test)]
mod devices;
#[cfg(test)]
mod events;
#[cfg(test)]
mod scaling;
#[cfg(test)]
#[path = "../trace/mod.rs"]
mod trace;
