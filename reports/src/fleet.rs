//! The results of a lake of captures and test results as one self-contained page, with plots over days and months and a
//! table for each question.

use crate::escape::printable;
use crate::page::{self, Page};
use maud::{Markup, html};
use serde::Serialize;
use std::io::{self, Write};

const STYLES: [&str; 2] = [include_str!("../assets/uplot/uPlot.min.css"), include_str!("../assets/fleet.css")];
const SCRIPTS: [&str; 2] = [include_str!("../assets/uplot/uPlot.iife.min.js"), include_str!("../assets/fleet.js")];

/// The content of the page.
#[derive(Clone, Debug, Default)]
pub struct Fleet {
    /// The address of the lake, as the user gave it.
    pub lake: String,
    /// The contents of the lake: each a name and a figure.
    pub totals: Vec<(&'static str, String)>,
    /// Plots of values over time or releases.
    pub plots: Vec<Plot>,
    /// The questions with their answers.
    pub questions: Vec<Question>,
    /// The program that made the page.
    pub made_by: String,
}

/// Values over days, months or releases.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Plot {
    /// The title, with the unit of the values.
    pub title: String,
    /// The labels of the horizontal axis, in this order.
    pub labels: Vec<String>,
    /// The lines of the plot.
    pub lines: Vec<Line>,
}

/// A line of a plot.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Line {
    /// The name of the line. Empty if it is the only line.
    pub name: String,
    /// A value for each label. `None` if a value is missing.
    pub values: Vec<Option<f64>>,
}

/// A question and its answer.
#[derive(Clone, Debug, Default)]
pub struct Question {
    /// The name of its view.
    pub name: &'static str,
    /// The text of the question.
    pub title: &'static str,
    /// The meaning of the answer, and its limits.
    pub doc: String,
    /// The names of the columns.
    pub columns: Vec<String>,
    /// The rows, with a cell for each column. `None` if a value is missing.
    pub rows: Vec<Vec<Option<String>>>,
    /// Whether rows were left out.
    pub is_cut: bool,
}

/// Writes the page.
///
/// # Errors
/// The errors of `out`.
pub fn render(fleet: &Fleet, out: &mut dyn Write) -> io::Result<()> {
    let questions = fleet.questions.iter().map(|question| (question.name, question.title));
    let sections: Vec<(&str, &str)> = std::iter::once(("course", "Over time")).chain(questions).collect();
    let page = Page {
        title: "Fleet",
        styles: &STYLES,
        scripts: &SCRIPTS,
        header: html! {
            p.kicker { "CANopen captures and test runs" }
            h1 { (printable(&fleet.lake)) }
        },
        sections: &sections,
        footer: html! {
            p { "Made by " (printable(&fleet.made_by)) "." }
            (page::plot_licence())
        },
    };
    page::write(&page, out, |out| {
        page::put(out, course(fleet))?;
        for question in &fleet.questions {
            page::put(out, answer(question))?;
        }
        page::put_data(out, "data", &fleet.plots)
    })
}

fn course(fleet: &Fleet) -> Markup {
    html! {
        section {
            h2 #course { "Over time" }
            dl.facts { @for (name, figure) in &fleet.totals { (page::fact(name, figure)) } }
            div #plots {}
            noscript { p { "The plots need JavaScript, which runs in this page only." } }
        }
    }
}

fn answer(question: &Question) -> Markup {
    html! {
        section {
            h2 id=(question.name) { (question.title) }
            p.hint { (printable(&question.doc)) }
            @if question.rows.is_empty() { p { "Nothing." } } @else {
                div.card.scroll { table.answer {
                    thead { tr { @for column in &question.columns { th scope="col" { (printable(column)) } } } }
                    tbody { @for row in &question.rows {
                        tr { @for cell in row { td { @if let Some(text) = cell { (printable(text)) } } } }
                    } }
                } }
            }
            @if question.is_cut {
                p.hint { "These are the first rows. All: " code { "SELECT * FROM " (question.name) } }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HOSTILE: &str = "</script><img src=x onerror=alert(1)>\u{202e}\u{1b}[2J";

    fn rendered(fleet: &Fleet) -> String {
        let mut page = Vec::new();
        render(fleet, &mut page).unwrap();
        String::from_utf8(page).unwrap()
    }

    #[test]
    fn names_out_of_captures_are_no_markup() {
        let (text, cell) = (HOSTILE.to_owned(), Some(HOSTILE.to_owned()));
        let question = Question {
            name: "bus_load",
            title: "Bus load",
            doc: text.clone(),
            columns: vec![text.clone()],
            rows: vec![vec![cell]],
            is_cut: true,
        };
        let line = Line { name: text.clone(), values: vec![Some(1.0), None] };
        let plot = Plot { title: text.clone(), labels: vec![text.clone(), "2025-01-28".to_owned()], lines: vec![line] };
        let page = rendered(&Fleet {
            lake: text.clone(),
            totals: vec![("captures", text.clone())],
            plots: vec![plot],
            questions: vec![question],
            made_by: text,
        });
        assert!(!page.contains("<img") && !page.contains(['\u{202e}', '\u{1b}']));
        assert_eq!(page.matches("&lt;img").count(), 6, "lake, figure, doc, column, cell and program");
        let data = page.split_once("id=\"data\">").unwrap().1.split_once("</script>").unwrap().0;
        let plots: serde_json::Value = serde_json::from_str(data).unwrap();
        assert_eq!((&plots[0]["labels"][0], &plots[0]["lines"][0]["name"]), (&HOSTILE.into(), &HOSTILE.into()));
    }

    #[test]
    fn an_answer_without_rows_says_so() {
        let question = Question { name: "bus_load", title: "Bus load", ..Question::default() };
        let page = rendered(&Fleet { questions: vec![question], ..Fleet::default() });
        assert!(page.contains("<p>Nothing.</p>") && !page.contains("first rows"));
    }
}
