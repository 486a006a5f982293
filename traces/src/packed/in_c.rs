//! zstd and lz4 by the usual C libraries.

use crate::ChunkCompression;
use std::io::{self, BufRead, Read, Write};

/// Decompresses a zstd stream of one or more frames.
pub(crate) fn zstd<'a>(source: impl BufRead + 'a) -> io::Result<impl Read + 'a> {
    ::zstd::Decoder::with_buffer(source)
}

/// Decompresses an lz4 frame.
pub(crate) fn lz4(source: impl Read) -> io::Result<impl Read> {
    ::lz4::Decoder::new(source)
}

/// Options for the chunks of a written MCAP file.
pub(crate) fn mcap_options(compression: ChunkCompression) -> mcap::WriteOptions {
    let compression = match compression {
        ChunkCompression::Zstd => Some(mcap::Compression::Zstd),
        ChunkCompression::Lz4 => Some(mcap::Compression::Lz4),
        ChunkCompression::None => None,
    };
    mcap::WriteOptions::new().compression(compression).compression_threads(0)
}

/// Writes a zstd stream.
pub(crate) struct ZstdWriter<W: Write>(::zstd::Encoder<'static, W>);

impl<W: Write> ZstdWriter<W> {
    pub(crate) fn new(sink: W) -> io::Result<Self> {
        Ok(Self(::zstd::Encoder::new(sink, 0)?))
    }

    pub(crate) fn finish(&mut self) -> io::Result<()> {
        self.0.do_finish()?;
        self.0.get_mut().flush()
    }
}

impl<W: Write> Write for ZstdWriter<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}
