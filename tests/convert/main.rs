//! End-to-end tests of `canvass convert`, of merging, and of the capture quality.

#[cfg(test)]
mod command;
#[cfg(test)]
mod cuts;
#[cfg(test)]
mod formats_page;
#[cfg(test)]
mod kept_and_lost;
#[cfg(test)]
mod merging;
#[cfg(test)]
mod nothing_overwritten;
#[cfg(test)]
mod outputs;
#[cfg(test)]
mod quality;
#[cfg(test)]
mod recording;
#[cfg(test)]
mod rows;
