//! `canvass monitor --screen`: the nodes and CAN-IDs of a bus at a glance.

mod ids;

use crate::interrupt::Interrupt;
use crate::output::is_dumb;
use anyhow::{Context, Result, anyhow};
use canvass_analyzer::network::{Decoded, Event, Network};
use canvass_analyzer::wire::error_control::State;
use canvass_analyzer::{Meaning, NodeId, Service};
use canvass_bus::{Bus, Health};
use canvass_reports::escape::Printable;
use canvass_traces::{Duration, Record, Timestamp, bit_length};
use ids::Ids;
use ratatui::Frame;
use ratatui::crossterm::event::{self, Event as Key, KeyCode, KeyEvent};
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::Line;
use ratatui::widgets::{Block, Paragraph, Row, Table};
use std::collections::{BTreeMap, VecDeque};

/// The state of the screen.
#[derive(Default)]
pub struct Screen {
    title: String,
    bit_rate: Option<u32>,
    /// Nodes by their node-ID; `None` collects frames without node, such as SYNC.
    nodes: BTreeMap<Option<NodeId>, NodeRow>,
    ids: Ids,
    recent: VecDeque<String>,
    /// Whether the last frames take the place of the CAN-IDs.
    shows_frames: bool,
    bits: Rate,
    frames: Rate,
    health: Health,
    paused: bool,
}

/// The row of a node.
#[derive(Default)]
struct NodeRow {
    state: Option<State>,
    frames: Rate,
    last_seen: Timestamp,
    /// The latest text of each service with values: PDOs, SDO transfers, errors.
    last: BTreeMap<&'static str, String>,
}

/// A counter, and its increase during the last second.
#[derive(Default)]
struct Rate {
    total: u64,
    before: u64,
    per_second: u64,
}

impl Rate {
    fn add(&mut self, n: u64) {
        self.total += n;
    }

    fn tick(&mut self, span: Duration) {
        let grown = self.total - self.before;
        (self.before, self.per_second) = (self.total, grown * 1_000_000_000 / span.0.max(1));
    }
}

/// Number of latest frames that are kept.
const RECENT: usize = 200;
/// Interval between two drawings of the screen.
const REFRESH: Duration = Duration::from_millis(100);
/// Interval over which rates are computed.
const TICK: Duration = Duration::from_secs(1);

impl Screen {
    fn new(title: &str, bit_rate: Option<u32>) -> Self {
        Self { title: title.to_owned(), bit_rate, ..Self::default() }
    }

    /// Adds a frame.
    fn record(&mut self, record: &Record, decoded: &Decoded, network: &Network) {
        let bits = bit_length(&record.frame).unwrap_or(0);
        self.bits.add(u64::from(bits));
        self.frames.add(1);
        let Some(bus) = network.bus(record.channel) else { return };
        let row = self.nodes.entry(decoded.node).or_default();
        row.frames.add(1);
        row.last_seen = record.timestamp;
        for event in bus.events() {
            if let Event::StateChanged(node, change) = event {
                self.nodes.entry(Some(*node)).or_default().state = Some(change.to);
            }
        }
        let text = Meaning::new(record, decoded, bus).to_string();
        self.ids.record(record, &text);
        if self.recent.len() == RECENT {
            self.recent.pop_front();
        }
        self.recent.push_back(format!("{}  {}  {text}", record.timestamp, record.frame));
        // The column of the state shows heartbeats already.
        if !matches!(decoded.service, Service::Heartbeat | Service::Guarding)
            && let Some(row) = self.nodes.get_mut(&decoded.node)
        {
            row.last.insert(decoded.service.name(), text);
        }
    }

    /// Handles a key; returns whether it ends the program.
    fn is_ended_by(&mut self, key: KeyEvent) -> bool {
        match key.code {
            KeyCode::Char('q') | KeyCode::Esc => return true,
            KeyCode::Char('c') if !key.modifiers.is_empty() => return true,
            KeyCode::Char(' ') => self.paused = !self.paused,
            KeyCode::Char('f') => self.shows_frames = !self.shows_frames,
            KeyCode::Down => self.ids.scroll(1),
            KeyCode::Up => self.ids.scroll(-1),
            KeyCode::PageDown => self.ids.scroll(20),
            KeyCode::PageUp => self.ids.scroll(-20),
            _ => {}
        }
        false
    }

    fn tick(&mut self, span: Duration, health: Health) {
        self.bits.tick(span);
        self.frames.tick(span);
        self.nodes.values_mut().for_each(|row| row.frames.tick(span));
        self.health = health;
    }

    fn draw(&self, frame: &mut Frame<'_>, now: Timestamp) {
        let rows: Vec<Row<'_>> = self.nodes.iter().map(|(node, row)| row.cells(*node, now)).collect();
        // The table of nodes gets at most half of the screen; the rest stays for the frames.
        let height = (rows.len() as u16 + 3).min(frame.area().height / 2);
        let areas = [Constraint::Length(1), Constraint::Max(height), Constraint::Min(3), Constraint::Length(1)];
        let [head, nodes, below, foot] = Layout::vertical(areas).areas(frame.area());
        frame.render_widget(Paragraph::new(self.heading()), head);
        let widths = [
            Constraint::Length(5),
            Constraint::Length(16),
            Constraint::Length(10),
            Constraint::Length(7),
            Constraint::Length(9),
            Constraint::Min(20),
        ];
        let header = Row::new(["node", "state", "frames", "/s", "last", "last values"]).style(Style::new().bold());
        frame.render_widget(Table::new(rows, widths).header(header).block(Block::bordered().title("nodes")), nodes);
        if self.shows_frames {
            self.draw_recent(frame, below);
        } else {
            frame.render_widget(self.ids.table(now), below);
        }
        let keys = "q ends, space holds the screen, f: frames or CAN-IDs, arrows scroll";
        frame.render_widget(Paragraph::new(keys).style(Style::new().dim()), foot);
    }

    fn draw_recent(&self, frame: &mut Frame<'_>, recent: Rect) {
        let room = usize::from(recent.height.saturating_sub(2));
        let lines = self.recent.iter().skip(self.recent.len().saturating_sub(room));
        let lines: Vec<Line<'_>> = lines.map(|line| shown(line)).collect();
        frame.render_widget(Paragraph::new(lines).block(Block::bordered().title("frames")), recent);
    }

    fn heading(&self) -> Line<'_> {
        let mut text = format!("{}  {} frames/s, {} in all", self.title, self.frames.per_second, self.frames.total);
        if let Some(bit_rate) = self.bit_rate {
            text += &format!(", load {} %", self.bits.per_second * 100 / u64::from(bit_rate.max(1)));
        }
        if self.health.lost > 0 {
            text += &format!(", {} lost", self.health.lost);
        }
        if let Some(trouble) = &self.health.trouble {
            text += &format!(", {trouble}");
        }
        if self.paused {
            text += "  [held]";
        }
        let style = if self.health.lost > 0 || self.health.trouble.is_some() { Color::Red } else { Color::Reset };
        shown(&text).style(Style::new().fg(style).add_modifier(Modifier::BOLD))
    }
}

/// A line of the screen, with control characters made visible: names from the bus must not act on the terminal.
fn shown(text: &str) -> Line<'static> {
    Line::raw(Printable::line(text).into_string())
}

impl NodeRow {
    fn cells(&self, node: Option<NodeId>, now: Timestamp) -> Row<'_> {
        let name = node.map_or_else(|| "–".to_owned(), |node| node.to_string());
        let state = self.state.map(|state| state.to_string()).unwrap_or_default();
        let age = format!("{:.1} s", now.since(self.last_seen).as_millis() / 1e3);
        let values: Vec<&str> = self.last.values().map(String::as_str).collect();
        let color = match self.state {
            Some(State::OPERATIONAL) => Color::Green,
            Some(State::STOPPED) => Color::Red,
            Some(_) => Color::Yellow,
            None => Color::Reset,
        };
        let values = Printable::line(&values.join("; ")).into_string();
        let numbers = [self.frames.total.to_string(), self.frames.per_second.to_string()];
        let [total, rate] = numbers;
        Row::new([name, state, total, rate, age, values]).style(Style::new().fg(color))
    }
}

/// Shows a bus until a key, Ctrl-C or the end of the bus.
pub fn show(
    bus: &mut dyn Bus,
    network: &mut Network,
    title: &str,
    end: Timestamp,
    interrupt: &Interrupt,
) -> Result<()> {
    if is_dumb() {
        return Err(anyhow!("--screen needs a terminal with a movable cursor, but TERM is \"dumb\""));
    }
    let mut terminal = ratatui::try_init().context("--screen needs a terminal")?;
    let shown = run(&mut terminal, bus, network, title, end, interrupt);
    // The terminal is restored also after an error.
    ratatui::restore();
    shown
}

fn run(
    terminal: &mut ratatui::DefaultTerminal,
    bus: &mut dyn Bus,
    network: &mut Network,
    title: &str,
    end: Timestamp,
    interrupt: &Interrupt,
) -> Result<()> {
    let mut screen = Screen::new(title, bus.bit_rate());
    let mut ticked = bus.now();
    while !interrupt.came() && bus.now() < end {
        let deadline = end.min(bus.now() + REFRESH);
        while let Some(record) = bus.receive(deadline)? {
            let decoded = network.handle(&record);
            if !screen.paused {
                screen.record(&record, &decoded, network);
            }
            if bus.now() >= deadline {
                break;
            }
        }
        let now = bus.now();
        if now.since(ticked) >= TICK {
            screen.tick(now.since(ticked), bus.health());
            ticked = now;
        }
        terminal.draw(|frame| screen.draw(frame, now))?;
        while event::poll(std::time::Duration::ZERO)? {
            if let Key::Key(key) = event::read()?
                && screen.is_ended_by(key)
            {
                return Ok(());
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_device::models::Model;
    use canvass_traces::{ChannelId, parse_frame};
    use ratatui::Terminal;
    use ratatui::backend::TestBackend;

    fn drawn(screen: &Screen, now: Timestamp) -> String {
        let mut terminal = Terminal::new(TestBackend::new(120, 14)).unwrap();
        terminal.draw(|frame| screen.draw(frame, now)).unwrap();
        terminal.backend().to_string()
    }

    #[test]
    fn nodes_with_state_rate_and_values() {
        let mut network = Network::new();
        let model = Model::by_id("kuebler-sendix-58x8").unwrap();
        network
            .describe(model.default_node().unwrap(), canvass_analyzer::dictionary::KnownDevice::clone(model.device()));
        let mut screen = Screen::new("can0", Some(250_000));
        let at = |ms| Timestamp::ZERO + Duration::from_millis(ms);
        for (ms, text) in [(0, "73F#00"), (100, "000#013F"), (200, "5BF#4300100096010200"), (300, "73F#05")] {
            let record = Record::new(at(ms), ChannelId(0), parse_frame(text).unwrap().frame);
            let decoded = network.handle(&record);
            screen.record(&record, &decoded, &network);
        }
        screen.tick(Duration::from_millis(500), Health::default());
        let text = drawn(&screen, at(1_300));
        let row = text.lines().find(|line| line.contains("operational")).unwrap_or_else(|| panic!("{text}"));
        assert!(row.contains("63") && row.contains("1.0 s"), "{text}");
        assert!(text.contains("can0  8 frames/s, 4 in all, load 0 %"), "{text}");
        let row = text.lines().find(|line| line.contains("5BF")).unwrap_or_else(|| panic!("{text}"));
        assert!(row.contains("43 00 10 00 96 01 02 00") && row.contains("1000h"), "{text}");
        assert!(!screen.is_ended_by(KeyCode::Char('f').into()));
        assert!(drawn(&screen, at(1_300)).contains("5BF#4300100096010200"));
        assert!(screen.is_ended_by(KeyCode::Char('q').into()));
    }

    #[test]
    fn what_devices_send_does_not_control_the_terminal() {
        let mut screen = Screen::new("can0", None);
        screen.recent.push_back("evil \x1b[2J".to_owned());
        screen.health.lost = 7;
        screen.shows_frames = true;
        let text = drawn(&screen, Timestamp::ZERO);
        assert!(!text.contains('\x1b') && text.contains("7 lost"), "{text}");
    }
}
