//! Fields as text: aligned for the terminal, quoted for a CSV.

use std::fmt::Write;

/// Columns as wide as their widest field; the first is flush left, the others right.
pub fn aligned(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| {
        let widths = rows
            .iter()
            .filter_map(|row| Some(row.get(column)?.chars().count()));
        widths.max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let mut text = String::new();
    for row in rows {
        let mut line = String::new();
        for (column, (field, width)) in row.iter().zip(&widths).enumerate() {
            // Writing to a String cannot fail.
            let _ = if column == 0 {
                write!(line, "{field:width$}")
            } else {
                write!(line, "  {field:>width$}")
            };
        }
        text += line.trim_end();
        text.push('\n');
    }
    text
}

/// A field as RFC 4180 has it: one line, in quotes where it needs them.
pub fn quoted(field: &str) -> String {
    let line = field.split_whitespace().collect::<Vec<_>>().join(" ");
    if line.contains([',', '"']) {
        format!("\"{}\"", line.replace('"', "\"\""))
    } else {
        line
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_aligned_and_lines_end_at_their_last_word() {
        let rows = [vec!["a", "1"], vec!["long name", "22"], vec!["b"]];
        let rows = rows.map(|row| row.into_iter().map(str::to_owned).collect());
        assert_eq!(aligned(&rows), "a           1\nlong name  22\nb\n");
    }

    #[test]
    fn a_field_stays_one_field_on_one_line() {
        assert_eq!(quoted("a, \"b\"\n c"), "\"a, \"\"b\"\" c\"");
        assert_eq!(quoted("plain"), "plain");
    }
}
