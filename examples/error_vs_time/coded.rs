//! Scenes drawn in code: each thing in a flat color of its own, what lies behind the mirror in
//! another. A pixel then says which thing it shows, and whether it may.

use bevy::{
    pbr::{ExtendedMaterial, MaterialExtension},
    prelude::*,
    render::render_resource::AsBindGroup,
    shader::ShaderRef,
};

use crate::{
    lens::Lens,
    quad::Quad,
    support::{
        props::add,
        scene::{Look, Scene},
    },
};

/// The colors of things. No mixture of two of them, nor of one and the background, is a third.
const PALETTE: [[u8; 3]; 6] = [
    [255, 0, 0],
    [0, 255, 0],
    [0, 0, 255],
    [255, 255, 0],
    [0, 255, 255],
    [255, 255, 255],
];
/// Also in the shader.
const GHOST: [u8; 3] = [255, 0, 255];
/// Of a channel, in levels.
const TOLERANCE: u8 = 6;
/// What lies behind the mirror by less than this many pixels, may show.
const GHOST_PX: f64 = 0.5;

/// What a pixel of a coded picture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Code {
    /// Of the thing with this number, one of six that share it.
    Thing(u8),
    Background,
    /// What lies behind the mirror.
    Ghost,
    /// A mixture, as at the edges of things.
    Unclear,
}

impl Code {
    /// Of the object with this index in its scene.
    pub fn of_object(index: usize) -> Self {
        Self::Thing((index % PALETTE.len()) as u8)
    }

    pub fn of(pixel: [u8; 4], background: [u8; 4]) -> Self {
        let is = |color: &[u8]| {
            color
                .iter()
                .zip(pixel)
                .all(|(a, b)| a.abs_diff(b) <= TOLERANCE)
        };
        if is(&GHOST) {
            return Self::Ghost;
        }
        if is(&background[..3]) {
            return Self::Background;
        }
        match PALETTE.iter().position(|color| is(color)) {
            Some(number) => Self::Thing(number as u8),
            None => Self::Unclear,
        }
    }
}

/// The material: unlit, so that lights do not matter; an extension, so that what the engine does
/// for its own material (culling for a mirrored camera, above all) is done for this one.
pub type CodedMaterial = ExtendedMaterial<StandardMaterial, Coding>;

#[derive(Asset, AsBindGroup, Reflect, Clone, Debug)]
pub struct Coding {
    #[uniform(100)]
    color: LinearRgba,
    #[uniform(100)]
    normal: Vec4,
    #[uniform(100)]
    origin: Vec4,
    #[uniform(100)]
    tolerance: Vec4,
}

impl MaterialExtension for Coding {
    fn fragment_shader() -> ShaderRef {
        "embedded://error_vs_time/coded.wgsl".into()
    }
}

pub fn plugin(app: &mut App) {
    bevy::asset::embedded_asset!(app, "examples/error_vs_time", "coded.wgsl");
    app.add_plugins(MaterialPlugin::<CodedMaterial>::default());
}

/// What codes the things of one scene.
pub struct Coder {
    normal: Vec4,
    origin: Vec4,
    tolerance: Vec4,
}

impl Coder {
    pub fn new(scene: &Scene) -> Self {
        let quad = Quad::of(&scene.mirrors[0]);
        let pixel = Lens::new(scene).pixel() * GHOST_PX;
        // The rounding of world positions is nobody's ghost.
        let rounding = 4.0 * f64::from(f32::EPSILON) * quad.center.abs().max_element();
        Self {
            normal: quad.plane().normal.extend(0.0).as_vec4(),
            origin: quad.center.extend(0.0).as_vec4(),
            tolerance: Vec4::new(pixel.x as f32, (pixel.y + rounding) as f32, 0.0, 0.0),
        }
    }

    fn look(&self, color: [u8; 3], tolerance: Vec4, both_sides: bool) -> Look {
        let [r, g, b] = color;
        let color = Color::srgb_u8(r, g, b);
        let material = CodedMaterial {
            base: StandardMaterial {
                base_color: color,
                unlit: true,
                double_sided: both_sides,
                cull_mode: (!both_sides).then_some(bevy::render::render_resource::Face::Back),
                ..default()
            },
            extension: Coding {
                color: color.into(),
                normal: self.normal,
                origin: self.origin,
                tolerance,
            },
        };
        Look::other(move |entity| {
            let material = add(entity, material.clone());
            entity.insert(MeshMaterial3d(material));
        })
    }

    /// White, without an inside, and not to be seen but in the mirror.
    pub fn only_reflected(&self) -> Look {
        // Nothing of it is a ghost: where it ends is what is measured.
        let tolerance = Vec4::new(0.0, f32::MAX, 1.0, 0.0);
        self.look([255; 3], tolerance, true)
    }

    /// The scene with its things in code and without lights.
    pub fn scene(&self, scene: &Scene) -> Scene {
        let mut coded = scene.clone();
        coded.props.clear();
        for (object, color) in coded.objects.iter_mut().zip(PALETTE.into_iter().cycle()) {
            let both_sides = matches!(&object.look, Look::Standard(look) if look.double_sided);
            object.look = self.look(color, self.tolerance, both_sides);
        }
        coded
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BACKGROUND: [u8; 4] = [10, 20, 30, 255];

    #[test]
    fn every_color_says_what_it_is() {
        for (number, [r, g, b]) in PALETTE.into_iter().enumerate() {
            let code = Code::of([r, g, b, 255], BACKGROUND);
            assert_eq!(code, Code::Thing(number as u8));
        }
        assert_eq!(Code::of([255, 0, 255, 255], BACKGROUND), Code::Ghost);
        assert_eq!(Code::of([11, 19, 31, 255], BACKGROUND), Code::Background);
    }

    #[test]
    fn half_of_one_and_half_of_another_is_unclear() {
        let all: Vec<[u8; 3]> = PALETTE.into_iter().chain([GHOST, [10, 20, 30]]).collect();
        for (i, a) in all.iter().enumerate() {
            for b in &all[..i] {
                // A mean in linear light of 0 and 255 is 188.
                let mean = |a: u8, b: u8| {
                    if a.abs_diff(b) > 200 {
                        188
                    } else {
                        a.midpoint(b)
                    }
                };
                let [r, g, b] = std::array::from_fn(|k| mean(a[k], b[k]));
                assert_eq!(Code::of([r, g, b, 255], BACKGROUND), Code::Unclear);
            }
        }
    }
}
