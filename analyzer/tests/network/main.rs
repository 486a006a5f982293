//! What a network knows of its nodes, and what frames bring about.

#[cfg(test)]
mod blocks;
#[cfg(test)]
mod channels;
#[cfg(test)]
mod devices;
#[cfg(test)]
mod dialogues;
#[cfg(test)]
mod events;
#[cfg(test)]
mod kept;
#[cfg(test)]
mod learned;
#[cfg(test)]
mod mapped;
#[cfg(test)]
mod rest;
#[cfg(test)]
mod scaling;
#[cfg(test)]
mod services;
#[cfg(test)]
#[path = "../trace/mod.rs"]
mod trace;
#[cfg(test)]
mod transfers;
