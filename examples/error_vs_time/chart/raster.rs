//! A drawing as pixels.
//!
//! By the rasterizer and the font that the engine draws its own text with: nothing to install, and
//! the same pixels on every machine.

use bevy::text::DEFAULT_FONT_DATA;
use swash::{
    FontRef,
    scale::{Render, ScaleContext, Source},
    zeno::{Command, Format, Mask, Placement, Stroke, Style, Vector},
};

use super::drawing::{Anchor, Drawing, Ink, Shape};

/// Rows of RGBA.
pub struct Pixels {
    pub width: u32,
    pub height: u32,
    pub bytes: Vec<u8>,
}

/// Draws on white; `scale` pixels for each unit of the drawing.
pub fn raster(drawing: &Drawing, scale: f32) -> Pixels {
    let (width, height) = (drawing.width * scale, drawing.height * scale);
    let (width, height) = (width.ceil() as u32, height.ceil() as u32);
    let mut pixels = Pixels {
        width,
        height,
        bytes: vec![255; (width * height * 4) as usize],
    };
    let mut context = ScaleContext::new();
    for shape in &drawing.shapes {
        match shape {
            Shape::Area { points, ink } => {
                let path = path(points, scale, true);
                let (mask, place) = Mask::new(&path[..]).format(Format::Alpha).render();
                pixels.cover(&mask, place, *ink);
            }
            Shape::Line { points, width, ink } => {
                let path = path(points, scale, false);
                let (mask, place) = Mask::new(&path[..])
                    .style(Style::Stroke(Stroke::new(width * scale)))
                    .format(Format::Alpha)
                    .render();
                pixels.cover(&mask, place, *ink);
            }
            Shape::Text {
                at,
                anchor,
                size,
                ink,
                text,
            } => {
                let at = [at[0] * scale, at[1] * scale];
                pixels.write(&mut context, text, at, *anchor, size * scale, *ink);
            }
        }
    }
    pixels
}

fn path(points: &[[f32; 2]], scale: f32, closed: bool) -> Vec<Command> {
    let mut path: Vec<Command> = points
        .iter()
        .enumerate()
        .map(|(i, [x, y])| {
            let place = Vector::new(x * scale, y * scale);
            if i == 0 {
                Command::MoveTo(place)
            } else {
                Command::LineTo(place)
            }
        })
        .collect();
    if closed {
        path.push(Command::Close);
    }
    path
}

impl Pixels {
    fn cover(&mut self, mask: &[u8], place: Placement, ink: Ink) {
        for row in 0..place.height {
            for column in 0..place.width {
                let alpha = mask[(row * place.width + column) as usize];
                let x = i64::from(place.left) + i64::from(column);
                let y = i64::from(place.top) + i64::from(row);
                if alpha == 0 || x < 0 || y < 0 {
                    continue;
                }
                if x >= i64::from(self.width) || y >= i64::from(self.height) {
                    continue;
                }
                let at = (y as usize * self.width as usize + x as usize) * 4;
                for (channel, ink) in self.bytes[at..at + 3].iter_mut().zip(ink) {
                    let (old, new, alpha) = (u32::from(*channel), u32::from(ink), u32::from(alpha));
                    *channel = ((old * (255 - alpha) + new * alpha + 127) / 255) as u8;
                }
            }
        }
    }

    fn write(
        &mut self,
        context: &mut ScaleContext,
        text: &str,
        at: [f32; 2],
        anchor: Anchor,
        size: f32,
        ink: Ink,
    ) {
        let Some(font) = FontRef::from_index(DEFAULT_FONT_DATA, 0) else {
            return;
        };
        let (charmap, metrics) = (font.charmap(), font.glyph_metrics(&[]).scale(size));
        let glyphs: Vec<_> = text.chars().map(|c| charmap.map(c)).collect();
        let widths: Vec<f32> = glyphs.iter().map(|id| metrics.advance_width(*id)).collect();
        let total: f32 = widths.iter().sum();
        let mut x = at[0]
            - match anchor {
                Anchor::Start => 0.0,
                Anchor::Middle => total / 2.0,
                Anchor::End => total,
            };
        let mut scaler = context.builder(font).size(size).build();
        for (glyph, width) in glyphs.into_iter().zip(widths) {
            let offset = Vector::new(x, 0.0);
            let drawn = Render::new(&[Source::Outline])
                .format(Format::Alpha)
                .offset(offset)
                .render(&mut scaler, glyph);
            if let Some(image) = drawn {
                // A glyph's top is above its baseline.
                let place = Placement {
                    top: at[1].round() as i32 - image.placement.top,
                    ..image.placement
                };
                self.cover(&image.data, place, ink);
            }
            x += width;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawing() -> Drawing {
        Drawing {
            width: 40.0,
            height: 30.0,
            shapes: Vec::new(),
        }
    }

    fn at(pixels: &Pixels, x: u32, y: u32) -> [u8; 3] {
        let at = ((y * pixels.width + x) * 4) as usize;
        [pixels.bytes[at], pixels.bytes[at + 1], pixels.bytes[at + 2]]
    }

    #[test]
    fn areas_and_lines_are_where_they_are_said_to_be() {
        let mut drawing = drawing();
        drawing.shapes.push(Shape::Area {
            points: vec![[5.0, 5.0], [15.0, 5.0], [15.0, 10.0], [5.0, 10.0]],
            ink: [200, 0, 0],
        });
        drawing.line([[20.0, 20.0], [40.0, 20.0]], 2.0, [0, 0, 200]);
        let pixels = raster(&drawing, 2.0);
        assert_eq!((pixels.width, pixels.height), (80, 60));
        assert_eq!(at(&pixels, 20, 15), [200, 0, 0]);
        assert_eq!(at(&pixels, 8, 15), [255; 3]);
        assert_eq!(at(&pixels, 60, 40), [0, 0, 200]);
        assert_eq!(at(&pixels, 60, 45), [255; 3]);
    }

    /// The columns of a text's ink: first and last.
    fn extent(anchor: Anchor) -> (u32, u32) {
        let mut drawing = drawing();
        drawing.text([20.0, 20.0], anchor, 10.0, [0; 3], "HH");
        let pixels = raster(&drawing, 1.0);
        let dark = |x: &u32| (0..30).any(|y| at(&pixels, *x, y)[0] < 128);
        let columns: Vec<u32> = (0..40).filter(dark).collect();
        let above = (0..40).any(|x| (21..30).any(|y| at(&pixels, x, y)[0] < 128));
        assert!(!above, "nothing is below the baseline");
        (columns[0], columns[columns.len() - 1])
    }

    #[test]
    fn text_is_anchored_at_its_start_its_middle_or_its_end() {
        assert!(extent(Anchor::Start).0 >= 20);
        assert!(extent(Anchor::End).1 <= 20);
        let (first, last) = extent(Anchor::Middle);
        assert!((first + last).abs_diff(39) <= 2, "{first} to {last}");
    }

    #[test]
    fn what_hangs_over_the_edge_is_cut_off() {
        let mut drawing = drawing();
        drawing.line([[-10.0, -5.0], [60.0, 50.0]], 3.0, [0; 3]);
        drawing.text([-3.0, 2.0], Anchor::Start, 10.0, [0; 3], "out");
        raster(&drawing, 1.0);
    }
}
