//! The chart: a panel for each scene, run time to the right, error upwards, both by logarithm.

mod drawing;
mod raster;
mod svg;

use std::{fs, path::Path};

use bevy_planar_mirror::MirrorClip;

use self::drawing::{Anchor, Drawing, Ink, Mark};
use crate::{
    frontier::frontier,
    png,
    row::Row,
    techniques::{Kind, Technique},
};

const PANEL: [f32; 2] = [360.0, 270.0];
/// Left, top, right, bottom of a panel, outside its axes.
const MARGIN: [f32; 4] = [52.0, 30.0, 14.0, 34.0];
const COLUMNS: usize = 3;
const HEAD: f32 = 86.0;
const FOOT: f32 = 84.0;
/// Errors below this are drawn here: a logarithm has no zero.
const LEAST_ERROR: f64 = 0.01;
/// Pixels of the PNG for each unit of the drawing.
const SCALE: f32 = 1.5;

const BLACK: Ink = [30, 30, 30];
const GRAY: Ink = [120, 120, 120];
const PALE: Ink = [225, 225, 225];
const FRONTIER: Ink = [150, 190, 150];

/// Writes `error_vs_time.svg` and `error_vs_time.png`.
pub fn write(rows: &[Row], about: &[String], folder: &Path) -> Result<(), String> {
    let chart = chart(rows, about);
    let path = folder.join("error_vs_time.svg");
    fs::write(&path, svg::svg(&chart)).map_err(|error| format!("{}: {error}", path.display()))?;
    let pixels = raster::raster(&chart, SCALE);
    let path = folder.join("error_vs_time.png");
    png::write_bytes(&pixels.bytes, pixels.width, pixels.height, &path)
}

fn chart(rows: &[Row], about: &[String]) -> Drawing {
    let scenes: Vec<&[Row]> = rows.chunk_by(|a, b| a.scene == b.scene).collect();
    let columns = scenes.len().clamp(1, COLUMNS);
    let lines = scenes.len().div_ceil(columns);
    let mut drawing = Drawing {
        // The legend and the head need their width, however few the scenes.
        width: (PANEL[0] * columns as f32).max(PANEL[0] * 3.0),
        height: HEAD + PANEL[1] * lines as f32 + FOOT,
        shapes: Vec::new(),
    };
    head(&mut drawing, about);
    for (i, rows) in scenes.iter().enumerate() {
        let (column, line) = ((i % columns) as f32, (i / columns) as f32);
        panel(
            &mut drawing,
            [column * PANEL[0], HEAD + line * PANEL[1]],
            rows,
        );
    }
    let foot = drawing.height - FOOT;
    legend(&mut drawing, foot, rows);
    drawing
}

fn head(drawing: &mut Drawing, about: &[String]) {
    let title = "Mirrors: error (RMSE, levels of 255) against run time of a frame (ms)";
    drawing.text([16.0, 26.0], Anchor::Start, 15.0, BLACK, title);
    for (line, text) in about.iter().enumerate() {
        let y = 44.0 + 14.0 * line as f32;
        drawing.text([16.0, y], Anchor::Start, 10.0, GRAY, text.clone());
    }
}

/// A logarithmic axis.
#[derive(Clone, Copy)]
struct Axis {
    low: f64,
    high: f64,
    from: f32,
    to: f32,
}

impl Axis {
    /// From below the least value to above the greatest.
    fn over(values: impl Iterator<Item = f64>, from: f32, to: f32) -> Self {
        let (low, high) = values.fold((f64::INFINITY, 0.0_f64), |(low, high), value| {
            (low.min(value), high.max(value))
        });
        Self {
            low: low / 1.25,
            high: high * 1.25,
            from,
            to,
        }
    }

    fn at(&self, value: f64) -> f32 {
        let share = (value / self.low).ln() / (self.high / self.low).ln();
        self.from + (self.to - self.from) * share as f32
    }

    /// Round numbers on it, few enough to be read.
    fn ticks(&self) -> Vec<f64> {
        let decades = (self.high / self.low).log10();
        let steps: &[f64] = if decades > 2.2 {
            &[1.0]
        } else if decades > 1.0 {
            &[1.0, 3.0]
        } else if decades > 0.5 {
            &[1.0, 2.0, 5.0]
        } else {
            &[1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0]
        };
        (-9..=9)
            .flat_map(|power| steps.iter().map(move |step| step * 10.0_f64.powi(power)))
            .filter(|tick| (self.low..=self.high).contains(tick))
            .collect()
    }
}

fn panel(drawing: &mut Drawing, corner: [f32; 2], rows: &[Row]) {
    let [left, top, right, bottom] = MARGIN;
    let (x0, x1) = (corner[0] + left, corner[0] + PANEL[0] - right);
    let (y0, y1) = (corner[1] + PANEL[1] - bottom, corner[1] + top);
    let title = format!("{} ({:.0} % mirror)", rows[0].scene, rows[0].share * 100.0);
    drawing.text(
        [(x0 + x1) / 2.0, y1 - 8.0],
        Anchor::Middle,
        12.0,
        BLACK,
        title,
    );

    let marks: Vec<(Technique, f64, f64)> = rows
        .iter()
        .filter_map(|row| {
            let (time, error) = row.place()?;
            Some((row.technique, time, error.max(LEAST_ERROR)))
        })
        .collect();
    if marks.is_empty() {
        drawing.text(
            [(x0 + x1) / 2.0, (y0 + y1) / 2.0],
            Anchor::Middle,
            11.0,
            GRAY,
            "nothing measured",
        );
        return;
    }
    let x = Axis::over(marks.iter().map(|mark| mark.1), x0, x1);
    let y = Axis::over(marks.iter().map(|mark| mark.2), y0, y1);
    for tick in x.ticks() {
        let at = x.at(tick);
        drawing.line([[at, y0], [at, y1]], 0.7, PALE);
        drawing.text(
            [at, y0 + 13.0],
            Anchor::Middle,
            9.5,
            GRAY,
            format!("{}", round(tick)),
        );
    }
    for tick in y.ticks() {
        let at = y.at(tick);
        drawing.line([[x0, at], [x1, at]], 0.7, PALE);
        drawing.text(
            [x0 - 5.0, at + 3.5],
            Anchor::End,
            9.5,
            GRAY,
            format!("{}", round(tick)),
        );
    }
    drawing.line([[x0, y1], [x0, y0], [x1, y0]], 1.0, GRAY);
    drawing.text([x1, y0 + 26.0], Anchor::End, 9.5, GRAY, "ms a frame");

    // The bound is no technique that could be used, so it is on no frontier.
    let usable: Vec<&(Technique, f64, f64)> = marks
        .iter()
        .filter(|mark| mark.0.kind != Kind::Bound)
        .collect();
    let places: Vec<(f64, f64)> = usable.iter().map(|mark| (mark.1, mark.2)).collect();
    let mut steps: Vec<[f32; 2]> = Vec::new();
    for i in frontier(&places) {
        let at = [x.at(places[i].0), y.at(places[i].1)];
        // Down only where the next one is: between two, nothing better is known.
        if let Some(last) = steps.last() {
            steps.push([at[0], last[1]]);
        }
        steps.push(at);
    }
    drawing.line(steps, 3.0, FRONTIER);
    for (technique, time, error) in marks {
        let (mark, ink) = look(technique.kind);
        drawing.mark(
            mark,
            [x.at(time), y.at(error)],
            4.5,
            ink,
            technique.samples > 1,
        );
    }
}

/// Without the noise of binary fractions.
fn round(value: f64) -> f64 {
    let digits = 10.0_f64.powi(2 - value.log10().floor() as i32);
    (value * digits).round() / digits
}

fn look(kind: Kind) -> (Mark, Ink) {
    match kind {
        Kind::NoMirror => (Mark::Plus, GRAY),
        Kind::Ours(MirrorClip::Auto) => (Mark::Circle, [20, 110, 40]),
        Kind::Ours(MirrorClip::Oblique) => (Mark::Diamond, [70, 160, 70]),
        Kind::Ours(_) => (Mark::Down, [150, 180, 60]),
        Kind::SecondCamera { clip: false, .. } => (Mark::Cross, [190, 70, 60]),
        Kind::SecondCamera { divisor: 1, .. } => (Mark::Square, [190, 40, 30]),
        Kind::SecondCamera { divisor: 2, .. } => (Mark::Square, [225, 120, 40]),
        Kind::SecondCamera { .. } => (Mark::Square, [225, 180, 50]),
        Kind::ScreenSpace => (Mark::Triangle, [120, 60, 170]),
        Kind::Bound | Kind::BoundIdle => (Mark::Triangle, [40, 90, 200]),
    }
}

fn legend(drawing: &mut Drawing, top: f32, rows: &[Row]) {
    let mut kinds: Vec<Kind> = Vec::new();
    for row in rows {
        if !kinds.contains(&row.technique.kind) {
            kinds.push(row.technique.kind);
        }
    }
    let width = (drawing.width - 32.0) / 4.0;
    for (i, kind) in kinds.iter().enumerate() {
        let at = [
            24.0 + (i % 4) as f32 * width,
            top + 16.0 + (i / 4) as f32 * 17.0,
        ];
        let (mark, ink) = look(*kind);
        drawing.mark(mark, at, 4.5, ink, true);
        drawing.text(
            [at[0] + 12.0, at[1] + 4.0],
            Anchor::Start,
            11.0,
            BLACK,
            kind.to_string(),
        );
    }
    let text = "Filled: MSAA 4x; hollow: off. Green line: the frontier, what no other technique \
                beats in both.";
    drawing.text([16.0, top + 72.0], Anchor::Start, 10.0, GRAY, text);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{errors::Errors, row::Measured, stats::Summary, techniques};

    fn rows(scenes: &[&'static str]) -> Vec<Row> {
        let mut rows = Vec::new();
        for scene in scenes {
            for (i, technique) in techniques::all().into_iter().enumerate() {
                let time = 5.0 + i as f64;
                rows.push(Row {
                    scene: (*scene).to_owned(),
                    technique,
                    share: 0.3,
                    outcome: Ok(Measured {
                        frame: Summary::of(&[time]),
                        errors: Some(Errors {
                            pixels: 9,
                            beyond: 0.1,
                            largest: 9.0,
                            rmse: 40.0 / time - 1.9,
                            flip: 0.1,
                        }),
                        ..Measured::default()
                    }),
                });
            }
        }
        rows
    }

    #[test]
    fn every_place_is_on_the_paper() {
        let chart = chart(&rows(&["a", "b", "c", "d"]), &["about".into()]);
        for shape in &chart.shapes {
            let points = match shape {
                drawing::Shape::Area { points, .. } | drawing::Shape::Line { points, .. } => {
                    points.clone()
                }
                drawing::Shape::Text { at, .. } => vec![*at],
            };
            for [x, y] in points {
                let inside = (0.0..=chart.width).contains(&x) && (0.0..=chart.height).contains(&y);
                assert!(inside, "{shape:?}");
            }
        }
    }

    #[test]
    fn ticks_are_few_and_round_on_narrow_and_wide_axes() {
        for (low, high) in [(4.0, 5.0), (3.0, 9.0), (0.5, 20.0), (0.01, 200.0)] {
            let axis = Axis {
                low,
                high,
                from: 0.0,
                to: 1.0,
            };
            let ticks = axis.ticks();
            assert!((2..=8).contains(&ticks.len()), "{low} to {high}: {ticks:?}");
            assert!(
                ticks
                    .iter()
                    .all(|tick| (0.0..=1.0).contains(&axis.at(*tick)))
            );
        }
    }

    #[test]
    fn a_scene_without_marks_says_so() {
        let mut rows = rows(&["a"]);
        for row in &mut rows {
            row.outcome = Err("no".into());
        }
        let svg = svg::svg(&chart(&rows, &[]));
        assert!(svg.contains("nothing measured"));
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
    }
}
