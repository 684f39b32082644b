//! All rows with all their columns, written as they come: what an interrupted run has measured,
//! it keeps.

use std::{
    fs::File,
    io::{self, Write},
    path::Path,
};

use crate::{
    edge::Found,
    row::{Measured, Row},
    shared::table::quoted,
    stats::Summary,
};

pub struct Csv(File);

/// The names of the columns; units are at their ends.
const HEADER: &[&str] = &[
    "scene",
    "technique",
    "samples",
    "mirror_share",
    "frame_ms",
    "frame_spread_ms",
    "frame_count",
    "to_no_mirror",
    "to_bound",
    "gpu_ms",
    "gpu_spread_ms",
    "gpu_count",
    "gpu_mirror_ms",
    "cpu_main_ms",
    "cpu_main_spread_ms",
    "cpu_extract_ms",
    "cpu_extract_spread_ms",
    "cpu_render_ms",
    "cpu_render_spread_ms",
    "cpu_plugin_main_ms",
    "cpu_plugin_main_spread_ms",
    "cpu_mirror_pass_ms",
    "cpu_mirror_pass_spread_ms",
    "memory_bytes",
    "pixels",
    "beyond_2_levels",
    "largest_levels",
    "rmse_levels",
    "flip",
    "cut_px",
    "cut_tilt_px",
    "cut",
    "ghosts_px",
    "losses_px",
    "inversions_px",
    "reason",
];

impl Csv {
    /// A file with its header; comment lines before it say what was measured on what.
    pub fn create(path: &Path, about: &[String]) -> io::Result<Self> {
        let mut file = File::create(path)?;
        for line in about {
            writeln!(file, "# {line}")?;
        }
        writeln!(file, "{}", HEADER.join(","))?;
        Ok(Self(file))
    }

    pub fn write(&mut self, rows: &[Row]) -> io::Result<()> {
        for row in rows {
            let line: Vec<String> = fields(row).iter().map(|field| quoted(field)).collect();
            writeln!(self.0, "{}", line.join(","))?;
        }
        self.0.flush()
    }
}

/// One value for every name of the header; empty where there is none.
fn fields(row: &Row) -> Vec<String> {
    let nothing = Measured::default();
    let measured = row.measured().unwrap_or(&nothing);
    let mut fields = vec![
        row.scene.to_owned(),
        row.technique.kind.to_string(),
        row.technique.samples.to_string(),
        number(Some(row.share)),
    ];
    fields.extend(summary(measured.frame, true));
    fields.extend([number(measured.to_none), number(measured.to_bound)]);
    fields.extend(summary(measured.gpu, true));
    fields.push(number(measured.gpu_mirror));
    for clock in [
        measured.cpu_main,
        measured.cpu_extract,
        measured.cpu_render,
        measured.cpu_plugin,
        measured.cpu_pass,
    ] {
        fields.extend(summary(clock, false));
    }
    fields.push(
        measured
            .memory
            .map_or(String::new(), |bytes| bytes.to_string()),
    );
    let errors = measured.errors;
    fields.push(errors.map_or(String::new(), |errors| errors.pixels.to_string()));
    fields.extend([
        number(errors.map(|errors| errors.beyond)),
        number(errors.map(|errors| errors.largest)),
        number(errors.map(|errors| errors.rmse)),
        number(errors.map(|errors| errors.flip)),
    ]);
    fields.extend(match measured.cut {
        Some(Found::Beside { shift, tilt }) => {
            [number(Some(shift)), number(Some(tilt)), "cut".to_owned()]
        }
        Some(Found::NotCut) => [String::new(), String::new(), "not cut".to_owned()],
        Some(Found::NoSheet) => [String::new(), String::new(), "no reflection".to_owned()],
        None => Default::default(),
    });
    let count = |count: Option<usize>| count.map_or(String::new(), |count| count.to_string());
    fields.extend([
        count(measured.things.map(|things| things.ghosts)),
        count(measured.things.map(|things| things.losses)),
        count(measured.things.map(|things| things.inversions)),
    ]);
    fields.push(row.outcome.as_ref().err().cloned().unwrap_or_default());
    fields
}

fn summary(summary: Option<Summary>, with_count: bool) -> Vec<String> {
    let mut fields = vec![
        number(summary.map(|summary| summary.median)),
        number(summary.map(|summary| summary.spread)),
    ];
    if with_count {
        fields.push(summary.map_or(String::new(), |summary| summary.count.to_string()));
    }
    fields
}

fn number(value: Option<f64>) -> String {
    value.map_or(String::new(), |value| {
        if value == 0.0 || (1e-3..1e6).contains(&value.abs()) {
            let text = format!("{value:.5}");
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            format!("{value:.4e}")
        }
    })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::techniques::{Kind, Technique};

    fn row(outcome: Result<Measured, String>) -> Row {
        Row {
            scene: "teapot".to_owned(),
            technique: Technique {
                kind: Kind::NoMirror,
                samples: 4,
            },
            share: 0.25,
            outcome,
        }
    }

    #[test]
    fn every_row_has_a_field_for_every_column() {
        let full = Measured {
            cut: Some(Found::Beside {
                shift: 0.01,
                tilt: -0.002,
            }),
            frame: Summary::of(&[4.0, 5.0, 6.0]),
            ..Measured::default()
        };
        for outcome in [
            Ok(Measured::default()),
            Ok(full),
            Err("needs, \"this\"\nand that".to_owned()),
        ] {
            assert_eq!(fields(&row(outcome)).len(), HEADER.len());
        }
    }

    #[test]
    fn values_stand_under_their_names() {
        let fields = fields(&row(Ok(Measured {
            frame: Summary::of(&[4.0, 5.0, 6.0]),
            memory: Some(-7),
            cut: Some(Found::NotCut),
            ..Measured::default()
        })));
        let of = |name: &str| {
            let column = HEADER.iter().position(|it| *it == name);
            &*fields[column.unwrap_or_else(|| panic!("no column {name}"))]
        };
        assert_eq!(
            (of("frame_ms"), of("frame_spread_ms"), of("frame_count")),
            ("5", "1", "3")
        );
        assert_eq!(
            (of("memory_bytes"), of("cut"), of("cut_px")),
            ("-7", "not cut", "")
        );
        assert_eq!(
            (of("samples"), of("mirror_share"), of("reason")),
            ("4", "0.25", "")
        );
    }

    #[test]
    fn rows_are_in_the_file_as_soon_as_they_are_written() {
        let path = std::env::temp_dir().join(format!("error_vs_time-{}.csv", std::process::id()));
        let mut csv = Csv::create(&path, &["about".to_owned()]).expect("a file can be made");
        csv.write(&[row(Err("why".into()))])
            .expect("a row can be written");
        let text = fs::read_to_string(&path).expect("it can be read");
        fs::remove_file(&path).ok();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 3);
        assert!(lines[0].starts_with("# about") && lines[1].starts_with("scene,"));
        assert!(lines[2].starts_with("teapot,no mirror,4,0.25,") && lines[2].ends_with(",why"));
    }
}
