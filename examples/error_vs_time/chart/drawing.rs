//! A drawing as a list of shapes, to be written as SVG or as pixels.

/// Red, green, blue.
pub type Ink = [u8; 3];

pub struct Drawing {
    pub width: f32,
    pub height: f32,
    pub shapes: Vec<Shape>,
}

/// Coordinates run to the right and down.
#[derive(Clone, Debug)]
pub enum Shape {
    /// A filled polygon.
    Area { points: Vec<[f32; 2]>, ink: Ink },
    /// A line through points.
    Line {
        points: Vec<[f32; 2]>,
        width: f32,
        ink: Ink,
    },
    Text {
        at: [f32; 2],
        anchor: Anchor,
        size: f32,
        ink: Ink,
        text: String,
    },
}

/// Which part of a text is at its place; the height is that of its baseline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Anchor {
    Start,
    Middle,
    End,
}

/// The marks of a chart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mark {
    Circle,
    Square,
    Diamond,
    Triangle,
    Down,
    Cross,
    Plus,
}

impl Drawing {
    pub fn line(&mut self, points: impl Into<Vec<[f32; 2]>>, width: f32, ink: Ink) {
        self.shapes.push(Shape::Line {
            points: points.into(),
            width,
            ink,
        });
    }

    pub fn text(
        &mut self,
        at: [f32; 2],
        anchor: Anchor,
        size: f32,
        ink: Ink,
        text: impl Into<String>,
    ) {
        self.shapes.push(Shape::Text {
            at,
            anchor,
            size,
            ink,
            text: text.into(),
        });
    }

    /// A mark around a place; hollow or filled.
    pub fn mark(&mut self, mark: Mark, at: [f32; 2], radius: f32, ink: Ink, filled: bool) {
        let around = |points: &[[f32; 2]]| -> Vec<[f32; 2]> {
            points
                .iter()
                .map(|[x, y]| [at[0] + x * radius, at[1] + y * radius])
                .collect()
        };
        let outline = match mark {
            Mark::Circle => {
                let turn = |i: u8| {
                    let (sin, cos) = (f32::from(i) * std::f32::consts::TAU / 24.0).sin_cos();
                    [cos, sin]
                };
                around(&(0..24).map(turn).collect::<Vec<_>>())
            }
            Mark::Square => around(&[[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]]),
            Mark::Diamond => around(&[[0.0, -1.25], [1.25, 0.0], [0.0, 1.25], [-1.25, 0.0]]),
            Mark::Triangle => around(&[[0.0, -1.2], [1.15, 0.8], [-1.15, 0.8]]),
            Mark::Down => around(&[[0.0, 1.2], [1.15, -0.8], [-1.15, -0.8]]),
            Mark::Cross | Mark::Plus => {
                let strokes = if mark == Mark::Cross {
                    [[[-0.9, -0.9], [0.9, 0.9]], [[-0.9, 0.9], [0.9, -0.9]]]
                } else {
                    [[[-1.2, 0.0], [1.2, 0.0]], [[0.0, -1.2], [0.0, 1.2]]]
                };
                let width = if filled { 2.4 } else { 1.2 };
                for stroke in strokes {
                    self.line(around(&stroke), width, ink);
                }
                return;
            }
        };
        if filled {
            self.shapes.push(Shape::Area {
                points: outline.clone(),
                ink,
            });
        }
        let closed: Vec<_> = outline.iter().chain(outline.first()).copied().collect();
        self.line(closed, 1.4, ink);
    }
}
