//! A drawing as SVG.

use std::fmt::Write;

use super::drawing::{Anchor, Drawing, Ink, Shape};

pub fn svg(drawing: &Drawing) -> String {
    let Drawing { width, height, .. } = drawing;
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\" font-family=\"Fira Mono, monospace\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n"
    );
    for shape in &drawing.shapes {
        // Writing to a String cannot fail.
        let _ = match shape {
            Shape::Area { points, ink } => writeln!(
                text,
                "<polygon points=\"{}\" fill=\"{}\"/>",
                places(points),
                color(*ink)
            ),
            Shape::Line { points, width, ink } => writeln!(
                text,
                "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{width}\"/>",
                places(points),
                color(*ink)
            ),
            Shape::Text {
                at: [x, y],
                anchor,
                size,
                ink,
                text: words,
            } => writeln!(
                text,
                "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{size}\" fill=\"{}\" \
                 text-anchor=\"{}\">{}</text>",
                color(*ink),
                match anchor {
                    Anchor::Start => "start",
                    Anchor::Middle => "middle",
                    Anchor::End => "end",
                },
                escaped(words)
            ),
        };
    }
    text + "</svg>\n"
}

fn places(points: &[[f32; 2]]) -> String {
    let place = |[x, y]: &[f32; 2]| format!("{x:.1},{y:.1}");
    points.iter().map(place).collect::<Vec<_>>().join(" ")
}

fn color([r, g, b]: Ink) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shape_is_one_element_and_text_is_escaped() {
        let mut drawing = Drawing {
            width: 10.0,
            height: 20.0,
            shapes: Vec::new(),
        };
        drawing.line([[0.0, 0.0], [1.0, 2.0]], 1.0, [255, 0, 10]);
        drawing.text([1.0, 2.0], Anchor::End, 9.0, [0; 3], "a < b & c");
        let svg = svg(&drawing);
        assert!(svg.contains("points=\"0.0,0.0 1.0,2.0\"") && svg.contains("#ff000a"));
        assert!(svg.contains("text-anchor=\"end\">a &lt; b &amp; c</text>"));
        assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"));
    }
}
