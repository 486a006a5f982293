//! The table of CAN-IDs: rate, cycle, data and meaning of the last frame of each.

use canvass_reports::escape::Printable;
use canvass_traces::{CanId, ChannelId, Duration, Record, Timestamp};
use ratatui::layout::Constraint;
use ratatui::style::{Color, Style, Stylize};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Row, Table};
use std::collections::BTreeMap;

/// Maximum number of rows: a device that uses every identifier must not exhaust the memory.
const MOST: usize = 4_096;
/// Time during which a changed byte stays marked.
const MARKED: Duration = Duration::from_secs(1);

/// The rows, by CAN-ID.
#[derive(Default)]
pub struct Ids {
    rows: BTreeMap<(ChannelId, CanId), IdRow>,
    /// Number of frames with identifiers that got no row.
    omitted: u64,
    /// Index of the first row on the screen.
    top: usize,
}

#[derive(Default)]
struct IdRow {
    count: u64,
    last: Timestamp,
    /// Time between the last two frames.
    cycle: Option<Duration>,
    /// Each data byte, with the time of its last change.
    data: Vec<(u8, Option<Timestamp>)>,
    meaning: String,
}

impl IdRow {
    fn take(&mut self, record: &Record, meaning: &str) {
        let now = record.timestamp;
        self.cycle = (self.count > 0).then(|| now.since(self.last));
        let changed = |at: usize, byte: u8| match self.data.get(at) {
            Some(&(before, changed)) if before == byte => changed,
            Some(_) => Some(now),
            None => (self.count > 0).then_some(now),
        };
        self.data = record.data().iter().enumerate().map(|(at, &byte)| (byte, changed(at, byte))).collect();
        (self.last, self.count) = (now, self.count + 1);
        meaning.clone_into(&mut self.meaning);
    }

    fn cells(&self, id: CanId, now: Timestamp) -> Row<'static> {
        let cycle = self.cycle.map(|cycle| format!("{:.1}", cycle.as_millis())).unwrap_or_default();
        let byte = |&(byte, changed): &(u8, Option<Timestamp>)| {
            let marked = changed.is_some_and(|changed| now.since(changed) < MARKED);
            let style = if marked { Style::new().fg(Color::Yellow).bold().reversed() } else { Style::new() };
            [Span::styled(format!("{byte:02X}"), style), Span::raw(" ")]
        };
        let data = Line::from_iter(self.data.iter().take(8).flat_map(byte));
        let meaning = Printable::line(&self.meaning).into_string();
        let number = |text: String| Line::raw(text).right_aligned();
        Row::new([Line::raw(id.to_string()), number(self.count.to_string()), number(cycle), data, Line::raw(meaning)])
    }
}

impl Ids {
    /// Adds a frame.
    pub fn record(&mut self, record: &Record, meaning: &str) {
        let key = (record.channel, record.frame.id());
        if self.rows.len() < MOST || self.rows.contains_key(&key) {
            self.rows.entry(key).or_default().take(record, meaning);
        } else {
            self.omitted += 1;
        }
    }

    /// Scrolls the rows.
    pub fn scroll(&mut self, by: isize) {
        self.top = self.top.saturating_add_signed(by).min(self.rows.len().saturating_sub(1));
    }

    /// The table, for drawing.
    pub fn table(&self, now: Timestamp) -> Table<'static> {
        let widths = [
            Constraint::Length(8),
            Constraint::Length(9),
            Constraint::Length(10),
            Constraint::Length(24),
            Constraint::Min(10),
        ];
        let rows = self.rows.iter().skip(self.top).map(|((_, id), seen)| seen.cells(*id, now));
        let right = |text: &'static str| Line::raw(text).right_aligned();
        let header = [Line::raw("CAN-ID"), right("frames"), right("cycle ms"), Line::raw("data"), Line::raw("meaning")];
        let more = if self.omitted > 0 { format!(", {} frames of others", self.omitted) } else { String::new() };
        let title = format!("{} CAN-IDs{more}", self.rows.len());
        Table::new(rows, widths).header(Row::new(header).bold()).block(Block::bordered().title(title))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_traces::parse_frame;
    use ratatui::Terminal;
    use ratatui::backend::TestBackend;
    use ratatui::style::Modifier;

    fn at(ms: u64) -> Timestamp {
        Timestamp::ZERO + Duration::from_millis(ms)
    }

    fn seen(frames: &[(u64, &str)]) -> Ids {
        let mut ids = Ids::default();
        for (ms, text) in frames {
            let record = Record::new(at(*ms), ChannelId(0), parse_frame(text).unwrap().frame);
            ids.record(&record, &format!("at {ms}"));
        }
        ids
    }

    fn terminal(ids: &Ids, now: Timestamp) -> Terminal<TestBackend> {
        let mut terminal = Terminal::new(TestBackend::new(70, 6)).unwrap();
        terminal.draw(|frame| frame.render_widget(ids.table(now), frame.area())).unwrap();
        terminal
    }

    #[test]
    fn a_row_for_each_id_with_count_cycle_data_and_meaning() {
        let ids = seen(&[(0, "1BF#0011"), (10, "73F#05"), (20, "1BF#0012"), (45, "1BF#0013")]);
        let text = terminal(&ids, at(50)).backend().to_string();
        assert!(text.contains("2 CAN-IDs"), "{text}");
        let row = text.lines().find(|line| line.contains("1BF")).unwrap();
        let words: Vec<&str> = row.trim_matches(['"', '│']).split_whitespace().collect();
        assert_eq!(words, ["1BF", "3", "25.0", "00", "13", "at", "45"]);
    }

    #[test]
    fn bytes_that_have_changed_are_marked_for_a_second() {
        let ids = seen(&[(0, "1BF#0011"), (20, "1BF#0012")]);
        let marked = |now| {
            let terminal = terminal(&ids, now);
            let cells = terminal.backend().buffer().content().to_vec();
            cells
                .iter()
                .filter(|cell| cell.modifier.contains(Modifier::REVERSED))
                .map(|cell| cell.symbol().to_owned())
                .collect::<String>()
        };
        assert_eq!(marked(at(30)), "12");
        assert_eq!(marked(at(2_000)), "");
    }

    #[test]
    fn a_flood_of_ids_is_bounded() {
        let mut ids = Ids::default();
        for id in 0..MOST as u32 + 10 {
            let record = Record::new(at(0), ChannelId(0), parse_frame(&format!("{id:08X}#")).unwrap().frame);
            ids.record(&record, "");
        }
        assert_eq!((ids.rows.len(), ids.omitted), (MOST, 10));
        ids.scroll(-5);
        ids.scroll(isize::MAX);
        assert_eq!(ids.top, MOST - 1);
    }
}
