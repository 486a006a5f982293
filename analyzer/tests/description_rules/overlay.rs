//! The example of a rule laid over a whole description: the sections of the example replace the sections with the same
//! names.
//!
//! A line `...` keeps the other fields of the section. `[1018] removed` removes a section, and the sections of its
//! sub-indexes.

struct Section {
    /// The name in lower case, without brackets; empty for the lines before the first section.
    name: String,
    lines: Vec<String>,
}

fn sections(text: &str) -> Vec<Section> {
    let mut sections = vec![Section { name: String::new(), lines: Vec::new() }];
    for line in text.split('\n') {
        if let Some(rest) = line.strip_prefix('[') {
            let name = rest.split(']').next().unwrap_or(rest).trim().to_ascii_lowercase();
            sections.push(Section { name, lines: Vec::new() });
        }
        sections.last_mut().unwrap().lines.push(line.to_owned());
    }
    sections
}

fn field(line: &str) -> &str {
    line.split_once('=').map_or("", |(name, _)| name)
}

/// The description with the example.
pub fn overlay(base: &str, example: &str) -> String {
    let mut whole = sections(base);
    let example = sections(example);
    let removed = |section: &Section| section.lines[0].ends_with("] removed");
    for gone in example.iter().filter(|section| !section.lines.is_empty() && removed(section)) {
        let subs = format!("{}sub", gone.name);
        whole.retain(|section| section.name != gone.name && !(gone.name.len() == 4 && section.name.starts_with(&subs)));
    }
    let kept = example.iter().filter(|section| !section.name.is_empty() && !removed(section));
    let mut seen: Vec<&str> = Vec::new();
    for section in kept {
        let is_second = seen.contains(&section.name.as_str());
        seen.push(&section.name);
        let mut lines: Vec<String> = section.lines.iter().filter(|line| *line != "...").cloned().collect();
        let place = whole.iter().position(|other| other.name == section.name).filter(|_| !is_second);
        let old = place.map(|at| whole.remove(at));
        if lines.len() < section.lines.len() {
            let named: Vec<String> = lines.iter().map(|line| field(line).to_owned()).collect();
            let other = old.iter().flat_map(|old| old.lines.iter().skip(1));
            lines.extend(other.filter(|line| !line.is_empty() && !named.contains(&field(line).to_owned())).cloned());
        }
        lines.push(String::new());
        let at = place.unwrap_or(whole.len());
        whole.insert(at, Section { name: section.name.clone(), lines });
    }
    whole.into_iter().flat_map(|section| section.lines).collect::<Vec<_>>().join("\n")
}
