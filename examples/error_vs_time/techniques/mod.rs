//! The ways to draw a mirror that the report compares.

mod bound;
mod rival;
mod screen_space;

use std::fmt;

use bevy::{prelude::*, render::diagnostic::RenderDiagnosticsPlugin};
use bevy_planar_mirror::{MirrorClip, PlanarMirrorPlugin};

use crate::{
    coded, frames,
    support::{
        scene::Scene,
        set::{build_plain, build_with_mirrors, clear},
        stage::Stage,
    },
};

/// A way to draw a mirror.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// None: the floor of time.
    NoMirror,
    Ours(MirrorClip),
    /// A second camera into an image, see [`rival`].
    SecondCamera {
        /// The image is smaller by this.
        divisor: u32,
        clip: bool,
    },
    ScreenSpace,
    /// What any technique has to do at least, see [`bound`].
    Bound,
    /// What the bound's app does besides: not a technique, but what [`Kind::Bound`] is counted
    /// from.
    BoundIdle,
}

/// A way to draw a mirror, and with how many samples a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Technique {
    pub kind: Kind,
    pub samples: u32,
}

/// What is to be drawn.
pub struct Setting<'a> {
    pub scene: &'a Scene,
    pub camera_scale: f32,
    /// The pixels that show the mirror: from, to (exclusive).
    pub bounds: (UVec2, UVec2),
}

/// All techniques, in the order of the table.
pub fn all() -> Vec<Technique> {
    let second = |divisor, clip| Kind::SecondCamera { divisor, clip };
    let kinds = [
        Kind::NoMirror,
        Kind::Ours(MirrorClip::Auto),
        Kind::Ours(MirrorClip::Oblique),
        Kind::Ours(MirrorClip::Whole),
        second(1, true),
        second(2, true),
        second(4, true),
        second(1, false),
        Kind::ScreenSpace,
        Kind::Bound,
        Kind::BoundIdle,
    ];
    let both = |kind| [1, 4].map(|samples| Technique { kind, samples });
    kinds.into_iter().flat_map(both).collect()
}

impl Technique {
    pub fn is(self, kind: Kind, samples: u32) -> bool {
        self == Self { kind, samples }
    }

    /// Whether it is a row of the table, and not only what another is counted from.
    pub fn is_row(self) -> bool {
        self.kind != Kind::BoundIdle
    }

    pub fn msaa(self) -> Msaa {
        match self.samples {
            1 => Msaa::Off,
            2 => Msaa::Sample2,
            8 => Msaa::Sample8,
            _ => Msaa::Sample4,
        }
    }

    /// The name of the pass that draws the mirror, where there is one.
    pub fn pass(self) -> Option<&'static str> {
        match self.kind {
            Kind::Ours(_) => Some("planar_mirror_pass"),
            Kind::ScreenSpace => Some("ssr"),
            _ => None,
        }
    }

    /// Starts its app. `Err` says why it cannot be had.
    pub fn start(self) -> Result<Stage, String> {
        if self.kind == Kind::ScreenSpace && self.samples > 1 {
            return Err("needs deferred rendering, which has no MSAA".into());
        }
        Ok(Stage::new(|app| {
            app.add_plugins((RenderDiagnosticsPlugin, coded::plugin));
            match self.kind {
                Kind::Ours(_) => {
                    app.add_plugins((PlanarMirrorPlugin::default(), frames::clock_plugin));
                }
                Kind::SecondCamera { .. } => {
                    app.add_plugins(rival::plugin);
                }
                Kind::ScreenSpace => {
                    app.add_plugins(screen_space::plugin);
                }
                Kind::NoMirror | Kind::Bound | Kind::BoundIdle => {}
            }
        }))
    }

    /// Takes the last scene off the stage and sets this one up; returns what it is drawn into.
    pub fn set_up(self, stage: &mut Stage, setting: &Setting) -> Result<Handle<Image>, String> {
        clear(stage);
        let mut scene = setting.scene.clone();
        scene.msaa = self.msaa();
        let target = stage.target(scene.size);
        let camera = match self.kind {
            Kind::NoMirror => build_plain(stage, &scene, target.clone()),
            Kind::Ours(clip) => {
                scene.mirrors[0].mirror.clip = clip;
                build_with_mirrors(stage, &scene, target.clone())
            }
            Kind::SecondCamera { divisor, clip } => {
                rival::set_up(stage, &scene, setting.camera_scale, divisor, clip, &target)
            }
            Kind::ScreenSpace => screen_space::set_up(stage, &scene, &target),
            Kind::Bound => bound::set_up(stage, &scene, setting.bounds, &target),
            Kind::BoundIdle => {
                let one_pixel = (setting.bounds.0, setting.bounds.0 + 1);
                bound::set_up(stage, &scene, one_pixel, &target)
            }
        };
        if setting.camera_scale != 1.0 && !matches!(self.kind, Kind::Bound | Kind::BoundIdle) {
            scale_camera(stage.world(), camera, setting.camera_scale);
        }
        Ok(target)
    }

    /// Whether its picture has left and right exchanged.
    pub fn is_flipped(self) -> bool {
        matches!(self.kind, Kind::Bound | Kind::BoundIdle)
    }
}

/// Makes a camera the child of an entity that is scaled, where it was.
fn scale_camera(world: &mut World, camera: Entity, scale: f32) {
    let parent = world.spawn(Transform::from_scale(Vec3::splat(scale))).id();
    let mut camera = world.entity_mut(camera);
    if let Some(mut transform) = camera.get_mut::<Transform>() {
        transform.translation /= scale;
    }
    camera.insert(ChildOf(parent));
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoMirror => "no mirror",
            Self::Ours(MirrorClip::Auto) => "ours, automatic",
            Self::Ours(MirrorClip::Oblique) => "ours, oblique",
            Self::Ours(_) => "ours, whole",
            Self::SecondCamera {
                divisor,
                clip: true,
                ..
            } => {
                return write!(f, "second camera 1/{divisor}");
            }
            Self::SecondCamera { clip: false, .. } => "second camera, no clip",
            Self::ScreenSpace => "screen space",
            Self::Bound => "physical bound",
            Self::BoundIdle => "physical bound, idle",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_technique_comes_without_and_with_samples_and_has_a_name_of_its_own() {
        let all = all();
        for technique in &all {
            assert!(
                [1, 4]
                    .map(|n| technique.is(technique.kind, n))
                    .contains(&true)
            );
            let same = |other: &&Technique| other.kind.to_string() == technique.kind.to_string();
            assert_eq!(all.iter().filter(same).count(), 2, "{}", technique.kind);
        }
        assert!(
            all[0].is(Kind::NoMirror, 1),
            "the floor of time comes first"
        );
    }
}
