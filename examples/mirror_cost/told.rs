//! Rows as text: a table on the terminal that README can take over, and a CSV.

use std::{fs, io, path::Path};

use crate::{
    contest::{Failure, Outcome},
    rows::Row,
    shared::table::{aligned, quoted},
};

/// What is told, row by row.
pub struct Told {
    table: Vec<Vec<String>>,
    csv: String,
    reasons: String,
}

impl Told {
    /// Comment lines before the CSV say what was measured on what.
    pub fn new(about: &[String]) -> Self {
        let head = ["row", "measured", "16-84 %", "of", "at most", "reached"];
        let comments: String = about.iter().map(|line| format!("# {line}\n")).collect();
        Self {
            table: vec![head.map(str::to_owned).to_vec()],
            csv: comments + "row,compared,measured,low,high,count,unit,at_most,details\n",
            reasons: String::new(),
        }
    }

    pub fn add(&mut self, row: &Row, outcome: &Outcome) {
        let measured = match outcome {
            Ok(measured) => measured,
            Err(failure) => {
                let reason = match failure {
                    Failure::Interrupted => "interrupted",
                    Failure::Reason(reason) => reason,
                };
                let reason = reason.split_whitespace().collect::<Vec<_>>().join(" ");
                self.reasons += &format!("{}: not measured: {reason}\n", row.name);
                return;
            }
        };
        let (estimate, unit) = (measured.estimate, row.unit);
        let number = |value: f64| {
            if unit.is_empty() {
                format!("{value:.3}")
            } else if value < 10.0 {
                format!("{value:.1}{unit}")
            } else {
                format!("{value:.0}{unit}")
            }
        };
        let [low, high] = estimate.range;
        self.table.push(vec![
            format!("{}: {}", row.name, row.compared),
            number(estimate.value),
            format!("{} - {}", number(low), number(high)),
            estimate.count.to_string(),
            row.goal.map_or("-".into(), |goal| format!("{goal}{unit}")),
            match row.goal {
                None => "-",
                Some(goal) if estimate.value <= goal => "yes",
                Some(_) => "no",
            }
            .to_owned(),
        ]);
        let fields = [
            row.name.to_owned(),
            row.compared.to_owned(),
            estimate.value.to_string(),
            low.to_string(),
            high.to_string(),
            estimate.count.to_string(),
            unit.trim().to_owned(),
            row.goal.map_or(String::new(), |goal| goal.to_string()),
            measured.details.clone(),
        ];
        let line: Vec<String> = fields.iter().map(|field| quoted(field)).collect();
        self.csv += &(line.join(",") + "\n");
    }

    pub fn table(&self) -> String {
        aligned(&self.table) + &self.reasons
    }

    pub fn write_csv(&self, path: &Path) -> io::Result<()> {
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder)?;
        }
        fs::write(path, &self.csv)
    }
}
