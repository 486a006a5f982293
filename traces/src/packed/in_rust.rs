//! zstd and lz4 by libraries in Rust. They read the same data as the C libraries; written data stays uncompressed or is
//! refused.

use crate::ChunkCompression;
use ruzstd::decoding::FrameDecoder;
use ruzstd::decoding::errors::{FrameDecoderError, ReadFrameHeaderError};
use std::convert::Infallible;
use std::io::{self, BufRead, Read, Write};
use std::marker::PhantomData;

/// Maximum window of a zstd frame, as in the C library.
const WINDOW: u64 = 128 << 20;

/// Decompresses a zstd stream of one or more frames.
#[expect(clippy::unnecessary_wraps, reason = "the C library may fail here")]
pub(crate) fn zstd<'a>(source: impl BufRead + 'a) -> io::Result<impl Read + 'a> {
    let mut decoder = FrameDecoder::new();
    decoder.set_max_window_size(WINDOW);
    Ok(Frames { source, decoder, within: false })
}

/// Decompresses an lz4 frame.
#[expect(clippy::unnecessary_wraps, reason = "the C library may fail here")]
pub(crate) fn lz4(source: impl Read) -> io::Result<impl Read> {
    Ok(lz4_flex::frame::FrameDecoder::new(source))
}

/// Options for the chunks of a written MCAP file: always uncompressed.
pub(crate) fn mcap_options(_: ChunkCompression) -> mcap::WriteOptions {
    mcap::WriteOptions::new().compression(None)
}

/// Decodes one zstd frame after the other.
struct Frames<S> {
    source: S,
    decoder: FrameDecoder,
    /// Whether a frame has begun.
    within: bool,
}

impl<S: BufRead> Read for Frames<S> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        while self.decoder.can_collect() == 0 {
            if self.within && !self.decoder.is_finished() {
                self.decode_block()?;
            } else if !self.begin()? {
                return Ok(0);
            }
        }
        self.decoder.read(buffer)
    }
}

impl<S: BufRead> Frames<S> {
    /// Goes on to the next frame, if there is one.
    fn begin(&mut self) -> io::Result<bool> {
        self.within = false;
        while !self.source.fill_buf()?.is_empty() {
            match self.decoder.init(&mut self.source) {
                Ok(()) => {
                    self.within = true;
                    return Ok(true);
                }
                // A skippable frame holds data of another program.
                Err(FrameDecoderError::ReadFrameHeaderError(ReadFrameHeaderError::SkipFrame { length, .. })) => {
                    io::copy(&mut (&mut self.source).take(u64::from(length)), &mut io::sink())?;
                }
                Err(error) => return Err(self.failed(&error)),
            }
        }
        Ok(false)
    }

    fn decode_block(&mut self) -> io::Result<()> {
        use ruzstd::decoding::BlockDecodingStrategy::UptoBlocks;
        match self.decoder.decode_blocks(&mut self.source, UptoBlocks(1)) {
            Ok(_) if self.decoder.is_finished() && self.is_changed() => Err(io::Error::other("wrong checksum")),
            Ok(_) => Ok(()),
            Err(error) => Err(self.failed(&error)),
        }
    }

    /// Whether the frame has a checksum that differs from the checksum of the decoded bytes.
    fn is_changed(&self) -> bool {
        let stated = self.decoder.get_checksum_from_data();
        stated.is_some() && self.decoder.can_collect() == 0 && stated != self.decoder.get_calculated_checksum()
    }

    /// The error of the library, which does not distinguish a stream that ends early from a damaged one.
    fn failed(&mut self, error: &FrameDecoderError) -> io::Error {
        match self.source.fill_buf() {
            Ok([]) => io::ErrorKind::UnexpectedEof.into(),
            Ok(_) => io::Error::other(error.to_string()),
            Err(error) => error,
        }
    }
}

/// A placeholder without values: this build does not write zstd.
pub(crate) struct ZstdWriter<W>(Infallible, PhantomData<W>);

impl<W: Write> ZstdWriter<W> {
    pub(crate) fn new(_: W) -> io::Result<Self> {
        Err(io::Error::other("zstd is only read in a browser: choose gzip"))
    }

    pub(crate) fn finish(&mut self) -> io::Result<()> {
        match self.0 {}
    }
}

impl<W: Write> Write for ZstdWriter<W> {
    fn write(&mut self, _: &[u8]) -> io::Result<usize> {
        match self.0 {}
    }

    fn flush(&mut self) -> io::Result<()> {
        match self.0 {}
    }
}

#[cfg(test)]
mod tests;
