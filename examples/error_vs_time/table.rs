//! Rows as text on the terminal.

use crate::{edge::Found, row::Row, shared::table::aligned, stats::Summary};

/// The table of one scene.
pub fn scene(rows: &[Row]) -> String {
    let head = [
        "technique",
        "MSAA",
        "frame ms",
        "+-",
        "/none",
        "/bound",
        "GPU ms",
        "CPU ms",
        "MiB",
        ">2 lv %",
        "max lv",
        "RMSE lv",
        "FLIP",
        "cut px",
        "ghosts",
        "losses",
        "order",
    ];
    let mut lines = vec![head.map(str::to_owned).to_vec()];
    let mut reasons = String::new();
    for row in rows {
        let name = row.technique.kind.to_string();
        let msaa = match row.technique.samples {
            1 => "off".to_owned(),
            samples => format!("{samples}x"),
        };
        match &row.outcome {
            Ok(_) => lines.push([vec![name, msaa], fields(row)].concat()),
            Err(reason) => {
                let reason = reason.split_whitespace().collect::<Vec<_>>().join(" ");
                reasons += &format!("{name}, {msaa}: not measured: {reason}\n");
            }
        }
    }
    aligned(&lines) + &reasons
}

fn fields(row: &Row) -> Vec<String> {
    let Some(measured) = row.measured() else {
        return Vec::new();
    };
    let none = || "-".to_owned();
    let of = |value: Option<f64>, digits: usize| {
        value.map_or_else(none, |value| format!("{value:.digits$}"))
    };
    let median = |summary: Option<Summary>| summary.map(|summary| summary.median);
    let cpu = [measured.cpu_main, measured.cpu_extract, measured.cpu_render].map(median);
    let cpu = cpu.iter().copied().sum::<Option<f64>>();
    let errors = measured.errors;
    let things = measured.things;
    let count = |count: Option<usize>| count.map_or_else(none, |count| count.to_string());
    vec![
        of(median(measured.frame), 2),
        of(measured.frame.map(|frame| frame.spread), 2),
        of(measured.to_none, 2),
        of(measured.to_bound, 2),
        of(measured.gpu_mirror, 2),
        of(cpu, 2),
        of(
            measured
                .memory
                .map(|bytes| bytes as f64 / f64::from(1 << 20)),
            1,
        ),
        of(errors.map(|errors| errors.beyond * 100.0), 2),
        of(errors.map(|errors| errors.largest), 0),
        of(errors.map(|errors| errors.rmse), 2),
        of(errors.map(|errors| errors.flip), 4),
        match measured.cut {
            Some(Found::Beside { shift, .. }) => format!("{shift:+.3}"),
            Some(Found::NotCut) => "none".to_owned(),
            Some(Found::NoSheet) => "lost".to_owned(),
            None => none(),
        },
        count(things.map(|things| things.ghosts)),
        count(things.map(|things| things.losses)),
        count(things.map(|things| things.inversions)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{row::Measured, techniques};

    #[test]
    fn a_technique_that_cannot_run_is_in_the_table_with_its_reason() {
        let technique = techniques::all()[0];
        let row = |outcome| Row {
            scene: "x".to_owned(),
            technique,
            share: 0.5,
            outcome,
        };
        let text = scene(&[row(Err("no\nway".into())), row(Ok(Measured::default()))]);
        assert!(
            text.contains("no mirror, off: not measured: no way"),
            "{text}"
        );
        let lines: Vec<&str> = text.lines().collect();
        let words = |line: &str| {
            line.split("  ")
                .filter(|word| !word.trim().is_empty())
                .count()
        };
        assert_eq!(words(lines[0]), words(lines[1]), "{text}");
    }
}
