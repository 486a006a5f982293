//! Writing captures of text formats.

use crate::lines::NOTE;
use crate::{Channels, Loss, Losses, Record, WriteError, Writer};
use std::io::{BufWriter, Write};

/// The formatter of one text format's lines. Writing to a `String` can't fail.
pub(crate) trait LineWriter {
    /// Writes the lines before the first record. An empty capture has no first record; its lines are written at its
    /// end.
    fn header(&mut self, _first: Option<&Record>, _out: &mut String) {}

    /// Writes the line of one record with its line end, or nothing if the format can't hold the record.
    fn record(&mut self, record: &Record, channel: &str, out: &mut String, losses: &mut Losses);

    /// Begin and end of a comment line; `None` if the format has no comments.
    const COMMENT: Option<(&'static str, &'static str)>;

    /// Writes the lines after the last record.
    fn footer(&mut self, _out: &mut String) {}
}

/// Writes a capture of a text format.
pub(crate) struct TextWriter<F> {
    sink: BufWriter<Box<dyn Write>>,
    /// A buffer that is reused for every line.
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
