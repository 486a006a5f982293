//! A plot as a picture: SVG.

use super::axis::Axis;
use super::{Curve, Panel, Plot};
use crate::escape::printable;
use maud::{Markup, html};
use std::fmt::Write as _;

/// The width of the picture, and of the room for the marks of the vertical axes.
const WIDTH: f64 = 1000.0;
const LEFT: f64 = 90.0;
const RIGHT: f64 = 20.0;
/// The height of a panel's title line, of a line for each curve's name, of the panel, and of the time axis.
const LINE: f64 = 18.0;
const HEIGHT: f64 = 170.0;
const BELOW: f64 = 46.0;

/// Colours that people with any colour vision tell apart (Okabe and Ito).
const COLORS: [&str; 7] = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000"];

/// The place of a panel.
#[derive(Clone, Copy)]
struct Area {
    top: f64,
}

impl Plot {
    /// The plot as an SVG document with a white background.
    pub fn svg(&self) -> String {
        let mut top = 0.0;
        let mut areas = Vec::new();
        for panel in &self.panels {
            top += LINE * panel.curves.len() as f64 + 10.0;
            areas.push(Area { top });
            top += HEIGHT;
        }
        let height = top + BELOW;
        let picture = html! {
            svg xmlns="http://www.w3.org/2000/svg" viewBox=(format!("0 0 {WIDTH} {height}")) width=(WIDTH) height=(height)
                font-family="system-ui, 'DejaVu Sans', sans-serif" font-size="12" {
                title { (self.panels.iter().flat_map(|panel| &panel.curves).map(|curve| printable(&curve.name).to_string()).collect::<Vec<_>>().join(", ")) }
                rect width="100%" height="100%" fill="white" {}
                @for (panel, area) in self.panels.iter().zip(&areas) { (self.panel(panel, *area)) }
                (self.times(top))
            }
        };
        picture.into_string()
    }

    fn panel(&self, panel: &Panel, area: Area) -> Markup {
        let names = panel.curves.iter().zip(COLORS.iter().cycle()).enumerate();
        let first_line = area.top - LINE * panel.curves.len() as f64;
        html! {
            @for (n, (curve, color)) in names {
                text x=(LEFT) y=(first_line + LINE * n as f64 + 10.0) fill=(color) font-weight="600" { (printable(&curve.name)) }
            }
            rect x=(LEFT) y=(area.top) width=(WIDTH - LEFT - RIGHT) height=(HEIGHT) fill="none" stroke="#999999" {}
            @for (value, text) in panel.axis.marks() {
                line x1=(LEFT) x2=(WIDTH - RIGHT) y1=(px(area.y(panel.axis, value))) y2=(px(area.y(panel.axis, value))) stroke="#e3e3e3" {}
                text x=(LEFT - 6.0) y=(px(area.y(panel.axis, value) + 4.0)) text-anchor="end" fill="#444444" {
                    (text)
                }
            }
            @for (curve, color) in panel.curves.iter().zip(COLORS.iter().cycle()) {
                path d=(self.path(curve, panel.axis, area)) fill="none" stroke=(color) stroke-width="1.5" stroke-linejoin="round" {}
            }
        }
    }

    /// A line through the points; a single point is a short dash.
    fn path(&self, curve: &Curve, axis: Axis, area: Area) -> String {
        let mut path = String::new();
        for (n, &(time, value)) in curve.points.iter().enumerate() {
            // Writing to a string can't fail.
            let _ = write!(path, "{}{} {}", if n == 0 { 'M' } else { 'L' }, px(self.x(time)), px(area.y(axis, value)));
        }
        if curve.points.len() == 1 {
            path.push_str("h3");
        }
        path
    }

    fn x(&self, time: canvass_traces::Timestamp) -> f64 {
        LEFT + self.across(time) * (WIDTH - LEFT - RIGHT)
    }

    /// The axis of the time below the panels.
    fn times(&self, top: f64) -> Markup {
        let axis = self.seconds();
        let x = |value: f64| px(LEFT + axis.along(value) * (WIDTH - LEFT - RIGHT));
        html! {
            @for (value, text) in axis.marks() {
                line x1=(x(value)) x2=(x(value)) y1=(top) y2=(top + 5.0) stroke="#999999" {}
                text x=(x(value)) y=(top + 18.0) text-anchor="middle" fill="#444444" { (text) " s" }
            }
            text x=(LEFT) y=(top + 36.0) fill="#444444" { "0 s is " (printable(&self.begins)) }
        }
    }
}

impl Area {
    fn y(self, axis: Axis, value: f64) -> f64 {
        self.top + HEIGHT * (1.0 - axis.along(value))
    }
}

/// A length with the precision of a tenth of a point.
fn px(length: f64) -> String {
    format!("{length:.1}")
}
