//! Writing captures of text formats.

use crate::lines::NOTE;
use crate::{Channels, Loss, Losses, Record, WriteError, Writer};
use std::io::{BufWriter, Write};

/// How one text format writes its lines. A `String` takes all that is written, so nothing can fail.
pub(crate) trait LineWriter {
    /// The lines before the first record, written with it, or at the end of an empty capture.
    fn header(&mut self, _first: Option<&Record>, _out: &mut String) {}

    /// The line of one record, with its line end, or nothing if the format can't hold it.
    fn record(&mut self, record: &Record, channel: &str, out: &mut String, losses: &mut Losses);

    /// The begin and the end of a line that is a comment; `None` in a format without comments.
    const COMMENT: Option<(&'static str, &'static str)>;

    /// The lines after the last record.
    fn footer(&mut self, _out: &mut String) {}
}

/// Writes a capture of a text format.
pub(crate) struct TextWriter<F> {
    sink: BufWriter<Box<dyn Write>>,
    /// Used again for every line.
    text: String,
    losses: Losses,
    begun: bool,
    format: F,
}

impl<F: LineWriter> TextWriter<F> {
    pub(crate) fn new(sink: Box<dyn Write>, format: F) -> Self {
        Self { sink: BufWriter::new(sink), text: String::new(), losses: Losses::default(), begun: false, format }
    }

    fn begin(&mut self, first: Option<&Record>) {
        if !self.begun {
            self.begun = true;
            self.format.header(first, &mut self.text);
        }
    }

    fn comment(&mut self, comment: &str) {
        let Some((begin, end)) = F::COMMENT else { return self.losses.count(Loss::Comment) };
        for line in comment.lines() {
            self.text.extend([begin, NOTE, line, end]);
        }
    }

    fn put(&mut self) -> Result<(), WriteError> {
        self.sink.write_all(self.text.as_bytes())?;
        self.text.clear();
        Ok(())
    }
}

impl<F: LineWriter> Writer for TextWriter<F> {
    fn write(&mut self, record: &Record, channels: &Channels) -> Result<(), WriteError> {
        self.begin(Some(record));
        if let Some(comment) = record.comment() {
            self.comment(comment);
        }
        self.format.record(record, channels.name(record.channel), &mut self.text, &mut self.losses);
        self.put()
    }

    fn flush(&mut self) -> Result<(), WriteError> {
        Ok(self.sink.flush()?)
    }

    fn finish(&mut self) -> Result<(), WriteError> {
        self.begin(None);
        self.format.footer(&mut self.text);
        self.put()?;
        self.flush()
    }

    fn losses(&self) -> &Losses {
        &self.losses
    }
}
