//! Planar mirrors for Bevy.

pub mod math;
mod mirror;
mod plugin;
mod render;
pub mod status;
mod view;

pub use mirror::{MirrorClip, MirrorPlane, NoMirrors, PlanarMirror};
pub use plugin::{MirrorSystems, PlanarMirrorPlugin};
pub use status::{MirrorState, MirrorStatus, NotDrawn};

/// What a game imports: `use bevy_planar_mirror::prelude::*;`.
pub mod prelude {
    pub use crate::{
        MirrorClip, MirrorPlane, MirrorStatus, NoMirrors, PlanarMirror, PlanarMirrorPlugin,
    };
}
