//! Captures compressed by gzip or zstd, recognised by their content.
//!
//! A stream may consist of several members (gzip) or frames (zstd), one after the other. If the stream ends early,
//! the part before the end is read, and the source then reports an unexpected end. Memory is bounded: a zstd window
//! of more than 128 MiB is refused.

use crate::{Source, SourceError, packed};
use flate2::bufread::MultiGzDecoder;
use std::io::{self, Read};

const GZIP: &[u8] = &[0x1F, 0x8B, 0x08];
const ZSTD: &[u8] = &[0x28, 0xB5, 0x2F, 0xFD];

/// The source itself, or the decompressed content of a compressed one.
///
/// # Errors
/// [`SourceError`] if the first bytes can't be read.
pub(crate) fn decompressed(mut source: Source) -> Result<Source, SourceError> {
    // A pipe may be slow, so only the bytes that distinguish compressed from plain data are awaited.
    while begins(source.window()) && source.window().len() < ZSTD.len() {
        if !source.fill()? {
            break;
        }
    }
    if source.window().starts_with(GZIP) {
        Ok(Source::new(Named { name: "gzip", inner: MultiGzDecoder::new(source) }))
    } else if source.window().starts_with(ZSTD) {
        Ok(Source::new(Named { name: "zstd", inner: packed::zstd(source)? }))
    } else {
        Ok(source)
    }
}

/// Whether a compressed stream may begin with these bytes.
fn begins(head: &[u8]) -> bool {
    [GZIP, ZSTD].iter().any(|magic| head.starts_with(magic) || magic.starts_with(head))
}

/// A decompressor that adds the name of the compression to its errors.
struct Named<R> {
    name: &'static str,
    inner: R,
}

impl<R: Read> Read for Named<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.inner.read(buffer).map_err(|error| match error.kind() {
            io::ErrorKind::Interrupted => error,
            io::ErrorKind::UnexpectedEof => {
                io::Error::new(error.kind(), format!("the {} stream ends early", self.name))
            }
            kind => io::Error::new(kind, format!("the {} stream is damaged: {error}", self.name)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    fn gzip(content: &[u8]) -> Vec<u8> {
        let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
        encoder.write_all(content).unwrap();
        encoder.finish().unwrap()
    }

    fn content(compressed: &[u8]) -> (Vec<u8>, Option<SourceError>) {
        let mut source = decompressed(Source::from_bytes(compressed)).unwrap();
        let mut all = Vec::new();
        loop {
            let more = source.fill();
            all.extend_from_slice(source.window());
            source.consume(usize::MAX);
            match more {
                Ok(true) => {}
                Ok(false) => return (all, None),
                Err(error) => return (all, Some(error)),
            }
        }
    }

    #[test]
    fn plain_content_is_left_alone() {
        for plain in [&b""[..], b"\x1f", b"(1.0) can0 1#", b"\x28\xb5\x00\x00"] {
            assert_eq!(content(plain).0, plain);
        }
    }

    #[test]
    fn all_members_are_read() {
        let two = [gzip(b"first "), gzip(b"second")].concat();
        assert!(matches!(content(&two), (all, None) if all == b"first second"));
        let frame = |content: &[u8]| zstd::encode_all(content, 0).unwrap();
        let two = [frame(b"first "), frame(b"second")].concat();
        assert!(matches!(content(&two), (all, None) if all == b"first second"));
    }

    #[test]
    fn a_stream_cut_anywhere_gives_a_prefix_and_says_so() {
        let plain: Vec<u8> = (0..20_000u32).flat_map(|n| (n.wrapping_mul(2_654_435_761) >> 7).to_le_bytes()).collect();
        for whole in [gzip(&plain), zstd::encode_all(&plain[..], 0).unwrap()] {
            for end in (4..whole.len()).step_by(997) {
                let (all, error) = content(&whole[..end]);
                assert!(plain.starts_with(&all));
                assert!(
                    matches!(error, Some(SourceError::Io(e)) if e.kind() == io::ErrorKind::UnexpectedEof),
                    "cut at {end}"
                );
            }
        }
    }

    #[test]
    fn damage_inside_is_an_error() {
        let mut damaged = gzip(&[7; 5000]);
        let middle = damaged.len() / 2;
        damaged[middle] ^= 0xFF;
        let (_, error) = content(&damaged);
        assert!(error.unwrap().to_string().contains("gzip"));
    }
}
