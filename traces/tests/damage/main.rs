//! Captures of every format, cut at every byte and changed at random.

#[cfg(test)]
mod accounting;
#[cfg(test)]
mod corpus;
#[cfg(test)]
mod cuts;
#[cfg(test)]
mod mutations;
