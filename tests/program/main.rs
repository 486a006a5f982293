//! The program, end to end.

#[cfg(test)]
mod ci_page;
#[cfg(test)]
mod conformance;
#[cfg(test)]
mod contract;
#[cfg(test)]
mod decode;
#[cfg(test)]
mod diagnose;
#[cfg(test)]
mod events;
#[cfg(test)]
mod fuzz;
#[cfg(test)]
mod hostile;
#[cfg(test)]
mod killed;
#[cfg(test)]
mod live;
#[cfg(test)]
mod memory;
#[cfg(test)]
mod rows;
#[cfg(test)]
mod running;
