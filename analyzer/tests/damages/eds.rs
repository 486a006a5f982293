//! An EDS as its lines, to be changed in places.

/// The lines, without their ends.
#[derive(Clone)]
pub struct Eds {
    pub lines: Vec<String>,
}

/// A section that describes an entry, by its `DataType`.
#[derive(Clone, Debug)]
pub struct Entry {
    pub header: usize,
    pub index: u16,
    /// `None` for the section of an object without sub-indexes, or in the short form.
    pub sub: Option<u8>,
    pub data_type: u16,
}

/// The entries of a list: number, line, value.
pub type Listed = Vec<(u32, usize, u16)>;

pub const LISTS: [&str; 3] = ["MandatoryObjects", "OptionalObjects", "ManufacturerObjects"];

impl Eds {
    pub fn new(text: &str) -> Self {
        Self { lines: text.lines().map(str::to_owned).collect() }
    }

    pub fn text(&self) -> String {
        self.lines.join("\n") + "\n"
    }

    /// The lines of the section headers.
    pub fn headers(&self) -> Vec<usize> {
        (0..self.lines.len()).filter(|&line| self.lines[line].starts_with('[')).collect()
    }

    pub fn name(&self, header: usize) -> &str {
        self.lines[header].trim_start_matches('[').trim_end_matches(']')
    }

    pub fn header(&self, name: &str) -> Option<usize> {
        self.headers().into_iter().find(|&header| self.name(header).eq_ignore_ascii_case(name))
    }

    /// The line after a section.
    pub fn end(&self, header: usize) -> usize {
        self.headers().into_iter().find(|&other| other > header).unwrap_or(self.lines.len())
    }

    /// The line after the last field of a section.
    pub fn last(&self, header: usize) -> usize {
        self.fields(header).last().map_or(header, |&line| line) + 1
    }

    /// The lines with an equals sign.
    pub fn fields(&self, header: usize) -> Vec<usize> {
        let is_field = |line: &usize| self.lines[*line].contains('=') && !self.lines[*line].starts_with(';');
        (header + 1..self.end(header)).filter(is_field).collect()
    }

    pub fn field(&self, header: usize, name: &str) -> Option<usize> {
        self.fields(header).into_iter().find(|&line| self.key(line).eq_ignore_ascii_case(name))
    }

    pub fn key(&self, line: usize) -> &str {
        self.lines[line].split_once('=').map_or("", |(key, _)| key)
    }

    pub fn value(&self, line: usize) -> &str {
        self.lines[line].split_once('=').map_or("", |(_, value)| value)
    }

    pub fn set(&mut self, line: usize, value: impl std::fmt::Display) {
        self.lines[line] = format!("{}={value}", self.key(line));
    }

    /// Gives a field a value, or adds it as the last field of the section. Returns its line.
    pub fn put(&mut self, header: usize, name: &str, value: impl std::fmt::Display) -> usize {
        let line = self.field(header, name).unwrap_or_else(|| {
            let line = self.last(header);
            self.lines.insert(line, format!("{name}="));
            line
        });
        self.set(line, value);
        line
    }

    pub fn text_of(&self, header: usize, name: &str) -> Option<&str> {
        self.field(header, name).map(|line| self.value(line)).filter(|value| !value.is_empty())
    }

    pub fn number_of(&self, header: usize, name: &str) -> Option<u64> {
        number(self.text_of(header, name)?)
    }

    pub fn remove_section(&mut self, header: usize) {
        let end = self.end(header);
        self.lines.drain(header..end);
    }

    /// Removes all sections whose name begins with `prefix`.
    pub fn remove_all(&mut self, prefix: &str) {
        while let Some(header) = self.headers().into_iter().find(|&header| self.name(header).starts_with(prefix)) {
            self.remove_section(header);
        }
    }

    /// Adds a section as the last one; returns the line of its header.
    pub fn add(&mut self, text: &str) -> usize {
        let header = self.lines.len();
        self.lines.extend(text.lines().map(str::to_owned));
        header
    }

    /// The indexes of the objects that have a section of their own, with its header.
    pub fn objects(&self) -> Vec<(u16, usize)> {
        let index = |header: usize| Some((address(self.name(header))?, header));
        let objects = self.headers().into_iter().filter_map(index);
        objects.filter_map(|((index, sub), header)| sub.is_none().then_some((index, header))).collect()
    }

    /// The sub-indexes of an object that have sections, with their headers.
    pub fn subs(&self, index: u16) -> Vec<(u8, usize)> {
        let sub = |header: usize| {
            let (of, sub) = address(self.name(header))?;
            Some((sub.filter(|_| of == index)?, header))
        };
        self.headers().into_iter().filter_map(sub).collect()
    }

    pub fn sub(&self, index: u16, sub: u8) -> Option<usize> {
        self.header(&format!("{index:04X}sub{sub:X}"))
    }

    /// The sections that describe entries.
    pub fn entries(&self) -> Vec<Entry> {
        let entry = |header: usize| {
            let (index, sub) = address(self.name(header))?;
            let data_type = self.number_of(header, "DataType")? as u16;
            Some(Entry { header, index, sub, data_type })
        };
        self.headers().into_iter().filter_map(entry).collect()
    }

    pub fn listed(&self, list: usize) -> Listed {
        let line = |line: usize| Some((self.key(line).parse().ok()?, line, number(self.value(line))? as u16));
        self.fields(list).into_iter().filter_map(line).collect()
    }

    /// The objects that PDOs carry: the line of the mapping entry's default, whether a TPDO carries the object, and the
    /// mapping entry.
    pub fn mapped(&self) -> Vec<(usize, bool, u32)> {
        let mut mapped = Vec::new();
        for (index, _) in self.objects() {
            if !matches!(index, 0x1600..=0x17FF | 0x1A00..=0x1BFF) {
                continue;
            }
            let count = self.sub(index, 0).and_then(|header| self.number_of(header, "DefaultValue")).unwrap_or(0);
            for sub in 1..=count as u8 {
                let line = self.sub(index, sub).and_then(|header| self.field(header, "DefaultValue"));
                let Some(line) = line else { continue };
                mapped.extend(number(self.value(line)).map(|value| (line, index >= 0x1A00, value as u32)));
            }
        }
        mapped
    }

    /// The section of a mapped object.
    pub fn target(&self, mapped: u32) -> Option<usize> {
        let (index, sub) = ((mapped >> 16) as u16, (mapped >> 8) as u8);
        self.sub(index, sub).or_else(|| self.header(&format!("{index:04X}")))
    }
}

/// Index and sub-index in a section's name `1018` or `1018sub1`.
fn address(name: &str) -> Option<(u16, Option<u8>)> {
    let (index, rest) = name.split_at_checked(4)?;
    let index = u16::from_str_radix(index, 16).ok()?;
    match rest.strip_prefix("sub") {
        Some(sub) => Some((index, Some(u8::from_str_radix(sub, 16).ok()?))),
        None => rest.is_empty().then_some((index, None)),
    }
}

/// A number in the forms of CiA 306, without formulas.
pub fn number(text: &str) -> Option<u64> {
    match text.strip_prefix("0x") {
        Some(digits) => u64::from_str_radix(digits, 16).ok(),
        None => text.parse().ok(),
    }
}
