//! Writing a capture file, compressed if its name says so.

use crate::packed::ZstdWriter;
use crate::{Channels, Format, Losses, Record, WriteError, WriteOptions, Writer};
use flate2::write::GzEncoder;
use std::cell::RefCell;
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::rc::Rc;

/// The compression of a whole file.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum Compression {
    /// No compression.
    #[default]
    None,
    /// gzip, `.gz`.
    Gzip,
    /// zstd, `.zst`.
    Zstd,
}

impl Compression {
    /// Compression and format from a file's name: `x.log.gz` is a compressed candump log.
    pub fn and_format_of(path: &Path) -> (Self, Option<Format>) {
        let extension = |path: &Path| path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_owned();
        let compression = match extension(path).to_ascii_lowercase().as_str() {
            "gz" => Self::Gzip,
            "zst" => Self::Zstd,
            _ => return (Self::None, Format::by_extension(&extension(path))),
        };
        (compression, Format::by_extension(&extension(&path.with_extension(""))))
    }
}

/// A capture file that is being written.
///
/// If the recording is dropped without [`Writer::finish`], the file lacks the end that its format requires.
pub struct Recording {
    writer: Box<dyn Writer>,
    sink: Shared,
}

impl Recording {
    /// Begins a capture in the given format.
    ///
    /// # Errors
    /// [`WriteError::NotWritten`] if the format can only be read, or the error of the sink.
    pub fn create(
        sink: Box<dyn Write>,
        format: Format,
        compression: Compression,
        options: &WriteOptions,
    ) -> Result<Self, WriteError> {
        let sink = BufWriter::with_capacity(64 * 1024, sink);
        let sink = Shared(Rc::new(RefCell::new(match compression {
            Compression::None => Sink::Plain(sink),
            Compression::Gzip => Sink::Gzip(GzEncoder::new(sink, flate2::Compression::default())),
            Compression::Zstd => Sink::Zstd(ZstdWriter::new(sink)?),
        })));
        Ok(Self { writer: format.create(Box::new(sink.clone()), options)?, sink })
    }
}

impl Writer for Recording {
    fn write(&mut self, record: &Record, channels: &Channels) -> Result<(), WriteError> {
        self.writer.write(record, channels)
    }

    fn flush(&mut self) -> Result<(), WriteError> {
        self.writer.flush()
    }

    fn finish(&mut self) -> Result<(), WriteError> {
        self.writer.finish()?;
        Ok(self.sink.0.borrow_mut().finish()?)
    }

    fn losses(&self) -> &Losses {
        self.writer.losses()
    }

    fn beginning(&self) -> Option<&[u8]> {
        self.writer.beginning()
    }
}

/// The sink, shared by the writer and the recording. The recording must finish the sink itself: a destructor would lose
/// an error that occurs only then (a full disk).
#[derive(Clone)]
struct Shared(Rc<RefCell<Sink>>);

type Plain = BufWriter<Box<dyn Write>>;

enum Sink {
    Plain(Plain),
    Gzip(GzEncoder<Plain>),
    Zstd(ZstdWriter<Plain>),
}

impl Sink {
    fn writer(&mut self) -> &mut dyn Write {
        match self {
            Self::Plain(sink) => sink,
            Self::Gzip(sink) => sink,
            Self::Zstd(sink) => sink,
        }
    }

    fn finish(&mut self) -> io::Result<()> {
        match self {
            Self::Plain(sink) => sink.flush(),
            Self::Gzip(sink) => {
                sink.try_finish()?;
                sink.get_mut().flush()
            }
            Self::Zstd(sink) => sink.finish(),
        }
    }
}

impl Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.borrow_mut().writer().write(bytes)
    }

    fn write_all(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.0.borrow_mut().writer().write_all(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.borrow_mut().writer().flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{CanId, Capture, Frame, ReadOptions, Source, Timestamp};

    #[test]
    fn the_name_says_format_and_compression() {
        let of = |path: &str| Compression::and_format_of(Path::new(path));
        assert_eq!(of("x/out.pcapng"), (Compression::None, Some(Format::Pcapng)));
        assert_eq!(of("out.LOG.GZ"), (Compression::Gzip, Some(Format::Candump)));
        assert_eq!(of("out.zst"), (Compression::Zstd, None));
        assert_eq!(of(".gz"), (Compression::None, None), "a hidden file without extension");
        assert_eq!(of("-"), (Compression::None, None));
    }

    #[test]
    fn compressed_recordings_are_whole_once_finished() {
        for compression in [Compression::None, Compression::Gzip, Compression::Zstd] {
            let file = Memory::default();
            let sink = Box::new(file.clone());
            let mut recording =
                Recording::create(sink, Format::Candump, compression, &WriteOptions::default()).unwrap();
            let mut channels = Channels::new();
            let channel = channels.intern("can0");
            let frame = Frame::full(CanId::standard_masked(0x123), [7; 8]);
            for n in 0..10_000 {
                recording.write(&Record::new(Timestamp(n), channel, frame), &channels).unwrap();
            }
            recording.finish().unwrap();
            let written = file.0.borrow().clone();
            let capture = Capture::from_source("x", Source::from_bytes(written), &ReadOptions::default()).unwrap();
            assert_eq!(capture.filter(|item| item.is_ok()).count(), 10_000, "{compression:?}");
        }
    }

    #[test]
    fn a_full_disk_shows_at_the_latest_when_finished() {
        struct Full;
        impl Write for Full {
            fn write(&mut self, _: &[u8]) -> io::Result<usize> {
                Err(io::ErrorKind::StorageFull.into())
            }
            fn flush(&mut self) -> io::Result<()> {
                Ok(())
            }
        }
        for compression in [Compression::None, Compression::Gzip, Compression::Zstd] {
            let options = WriteOptions::default();
            let mut recording = Recording::create(Box::new(Full), Format::Asc, compression, &options).unwrap();
            assert!(recording.finish().is_err(), "{compression:?}");
        }
    }

    #[derive(Clone, Default)]
    struct Memory(Rc<RefCell<Vec<u8>>>);

    impl Write for Memory {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0.borrow_mut().write(bytes)
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }
}
