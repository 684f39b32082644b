//! Numbers that look random and are the same on every machine, and scenes made of them.

use bevy::{camera::ScalingMode, prelude::*};

pub use super::extremes::Kind;
use super::{
    props::{lamp, lit, sun},
    scene::{Look, Scene, Surface},
    split_mix::SplitMix,
};

/// Numbers of the kinds that a scene is made of.
pub struct Random(SplitMix);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(SplitMix::new(seed))
    }

    pub fn between(&mut self, low: f32, high: f32) -> f32 {
        let share = (self.0.next() >> 40) as f32 / (1_u64 << 24) as f32;
        low + (high - low) * share
    }

    pub fn below(&mut self, count: u64) -> u64 {
        self.0.next() % count
    }

    pub fn within(&mut self, low: Vec3, high: Vec3) -> Vec3 {
        let [x, y, z] = [0, 1, 2].map(|i| self.between(low[i], high[i]));
        Vec3::new(x, y, z)
    }

    pub fn rotation(&mut self) -> Quat {
        use std::f32::consts::PI;
        let [a, b, c] = [0; 3].map(|_| self.between(-PI, PI));
        Quat::from_euler(EulerRot::XYZ, a, b, c)
    }

    /// Of any color that is not dark.
    pub fn look(&mut self, is_lit: bool) -> Look {
        let [r, g, b] = [0; 3].map(|_| self.between(0.2, 1.0));
        let color = Color::srgb(r, g, b);
        if is_lit {
            lit(color).into()
        } else {
            color.into()
        }
    }
}

/// In flat facets: a round cone's tip has no normal, and what is cut between a corner with one and a corner without is
/// not lit as before.
pub fn cone(radius: f32) -> Mesh {
    Cone {
        radius,
        height: 1.2,
    }
    .mesh()
    .resolution(20)
    .build()
    .with_duplicated_vertices()
    .with_computed_flat_normals()
}

/// A mirror somewhere, a camera before it, and objects of which some cross the plane and some are behind it.
pub fn scene(seed: u64, kind: Kind) -> Scene {
    let random = &mut Random::new(seed);
    let mut scene = Scene::new(&format!("random-{seed}-{kind:?}"));
    scene.size = UVec2::new(128, 96);

    let origin = match kind {
        Kind::FarAway => random.within(Vec3::splat(1200.0), Vec3::splat(2300.0)),
        _ => random.within(Vec3::splat(-5.0), Vec3::splat(5.0)),
    };
    let rotation = random.rotation();
    // Everything stands in the mirror's frame: z is in front of it.
    let world = |local: Vec3| origin + rotation * local;

    let (width, height) = (random.between(2.5, 5.0), random.between(2.0, 4.0));
    let stretch = random.within(Vec3::splat(0.5), Vec3::splat(2.0));
    scene.mirrors.push(Surface::wall(
        width / stretch.x,
        height / stretch.y,
        Transform {
            translation: origin,
            rotation,
            scale: stretch,
        },
    ));

    let (place, target) = match kind {
        Kind::HeadOn => {
            let place = random.within(vec3(-1.0, -0.7, 3.0), vec3(1.0, 0.7, 6.0));
            (place, place.with_z(0.0))
        }
        Kind::Grazing => {
            let beside = -height / 2.0 - 0.4;
            let place = vec3(random.between(-0.5, 0.5), beside, random.between(0.15, 0.4));
            (
                place,
                random.within(vec3(-0.5, 0.0, -0.3), vec3(0.5, 1.0, 0.5)),
            )
        }
        _ => {
            let place = random.within(vec3(-4.0, -3.0, 1.5), vec3(4.0, 3.0, 5.0));
            (
                place,
                random.within(vec3(-0.8, -0.6, -0.4), vec3(0.8, 0.6, 0.4)),
            )
        }
    };
    let up = if kind == Kind::HeadOn {
        rotation * Vec3::Y
    } else {
        random.rotation() * Vec3::Y
    };
    scene.eye = Transform::from_translation(world(place)).looking_at(world(target), up);
    scene.projection = if kind == Kind::Orthographic {
        OrthographicProjection {
            scaling_mode: ScalingMode::FixedVertical {
                viewport_height: random.between(3.0, 6.0),
            },
            ..OrthographicProjection::default_3d()
        }
        .into()
    } else {
        let fov = random.between(30.0_f32, 95.0).to_radians();
        PerspectiveProjection { fov, ..default() }.into()
    };

    // Something crosses the mirror, which a lit orthographic scene cannot show right: see the crate's docs.
    let is_lit = random.below(2) == 0 && kind != Kind::Orthographic;
    for i in 0..7 {
        // In front, across, behind; out of the eye's way.
        let depth = match i {
            0..=3 => (0.3, 2.5),
            4 | 5 => (-0.2, 0.2),
            _ => (-2.5, -1.0),
        };
        let (low, high) = (vec3(-2.5, -2.0, depth.0), vec3(2.5, 2.0, depth.1));
        let mut local = random.within(low, high);
        if local.distance(place) < 1.2 {
            local -= (place - local).normalize_or(Vec3::Z) * 1.2;
        }
        let scale = random.within(Vec3::splat(0.3), Vec3::splat(0.8));
        let transform = Transform {
            translation: world(local),
            rotation: random.rotation(),
            scale,
        };
        let mesh: Mesh = match random.below(4) {
            0 => Cuboid::default().into(),
            1 => Sphere::new(0.6).mesh().uv(24, 16),
            2 => Torus::new(0.25, 0.7)
                .mesh()
                .minor_resolution(12)
                .major_resolution(20)
                .build(),
            _ => cone(0.6),
        };
        let look = random.look(is_lit);
        scene = scene.object(mesh, look, transform);
    }
    if is_lit {
        scene.ambient.brightness = 100.0;
        scene = scene
            .prop(sun(false))
            .prop(lamp(world(vec3(1.0, 2.0, 3.0)), false));
    }
    scene
}
