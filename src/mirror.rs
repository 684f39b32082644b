//! What a user writes: [`PlanarMirror`] on a flat mesh, [`NoMirrors`] on a camera that shall see none.

use bevy::{
    camera::visibility::Visibility, ecs::prelude::*, reflect::prelude::*,
    transform::components::Transform,
};
use glam::Vec3;

use crate::{status::MirrorStatus, view::MirrorPlace};

/// Makes a flat mesh reflect the scene, as seen by every active `Camera3d`.
///
/// Put it beside a `Mesh3d`; nothing else is needed. The reflection is drawn straight into the
/// picture of each camera, so it has that camera's resolution, samples, exposure and tone mapping.
/// A material on the same entity whose alpha mode blends lies over the reflection by its own
/// formula; without a material, or with an opaque one, the mesh is a perfect mirror.
///
/// Only the front of the plane reflects: the side from which the triangles wind counter-clockwise
/// in the mesh's own space, carried along by the transform. What became of each mirror, for each camera, stands in [`MirrorStatus`].
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_planar_mirror::prelude::*;
/// fn setup(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>) {
///     commands.spawn((
///         Mesh3d(meshes.add(Rectangle::new(2.0, 1.0))),
///         Transform::from_xyz(0.0, 1.0, -3.0),
///         PlanarMirror::default(),
///     ));
/// }
/// ```
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[require(Transform, Visibility, MirrorStatus, MirrorPlace)]
pub struct PlanarMirror {
    /// Where the reflecting plane lies in the entity's own space.
    ///
    /// Default [`MirrorPlane::FromMesh`]: fitted to the mesh, which must be flat.
    pub plane: MirrorPlane,
    /// What becomes of objects that cross the plane.
    ///
    /// Default [`MirrorClip::Auto`]: they are cut at it.
    pub clip: MirrorClip,
    /// Where the shadows of directional lights on what is seen in it come from.
    ///
    /// Default [`MirrorShadows::Auto`]: as in the scene itself.
    pub shadows: MirrorShadows,
}

/// Where the reflecting plane of a [`PlanarMirror`] lies.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Default, Clone, Debug, PartialEq)]
pub enum MirrorPlane {
    /// In the mesh: the area-weighted plane through its triangles, front side by their winding.
    ///
    /// The mesh must be flat, a list or strip of triangles, and kept in the main world
    /// (`RenderAssetUsages::MAIN_WORLD`); a mesh that is not gets a status that says so.
    #[default]
    FromMesh,
    /// Given, in the entity's own space. For meshes that only the GPU has.
    Local {
        /// A point on the plane, in local units.
        point: Vec3,
        /// Towards the front. Any length but zero; a vector that is zero or not finite makes the
        /// mirror [`degenerate`](crate::status::NotDrawn::DegenerateTransform).
        normal: Vec3,
    },
}

/// What becomes of reflected objects that cross the plane of a [`PlanarMirror`].
///
/// Objects wholly behind the plane are never drawn, whatever is chosen here.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, Debug, PartialEq, Hash)]
#[non_exhaustive]
pub enum MirrorClip {
    /// They are cut at the plane. While nothing crosses it, the camera's own projection is used:
    /// its depth resolves finer, and the picture is the same.
    #[default]
    Auto,
    /// Always the oblique near plane, also while nothing crosses.
    Oblique,
    /// They are drawn whole, so the part behind the plane shows as well. To see what the oblique
    /// near plane is for.
    Whole,
}

/// Where the shadows of directional lights come from on what is seen in a [`PlanarMirror`].
///
/// Those of point and spot lights are the scene's own and cost nothing more.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, Debug, PartialEq, Hash)]
#[non_exhaustive]
pub enum MirrorShadows {
    /// From the camera's, if these hold all shadows that fall on what is seen in the mirror, and
    /// otherwise from the mirror's own. It is decided anew in every frame, and changes no picture:
    /// both are the same shadows, texel for texel, but for the rounding of depths.
    ///
    /// The camera's serve where what is seen in the mirror lies within the camera's own cascades,
    /// at like distances, as it mostly does in floors; a wall may show what lies behind the camera,
    /// where these end. They are not taken where a light has a `soft_shadow_size`, or while
    /// anything with a `VisibilityRange` throws shadows, since what is in range may differ.
    #[default]
    Auto,
    /// From shadow maps of the mirror's own, in which only what throws shadows on something
    /// seen is drawn, and of the cascades only those that something seen lies in.
    Own,
    /// From the camera's shadow maps alone, so that none are drawn for the mirror. What they do not
    /// reach is lit.
    Shared,
    /// There are none: all is lit.
    Off,
}

/// On a camera: it sees no reflections, and costs nothing for the mirrors of the scene.
#[derive(Component, Reflect, Clone, Copy, Debug, Default)]
#[reflect(Component, Default, Clone, Debug)]
pub struct NoMirrors;
