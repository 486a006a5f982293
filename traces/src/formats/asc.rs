//! Reader.

use crate::{ReadOptions, Reader, Source};

pub(crate) fn sniff(_head: &[u8]) -> bool {
    false
}

pub(crate) fn open(_source: Source, _options: &ReadOptions) -> Box<dyn Reader> {
    todo!()
}
