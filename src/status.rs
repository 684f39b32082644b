//! What a user reads: [`MirrorStatus`] tells, for each camera, whether a mirror is drawn and
//! otherwise why not.

use core::{fmt, time::Duration};

use bevy::{ecs::prelude::*, reflect::prelude::*};

use crate::mirror::MirrorShadows;

/// What became of a mirror in this frame, camera by camera. Written by the plugin alone, in
/// `PostUpdate`; it is there on every [`PlanarMirror`](crate::PlanarMirror).
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
pub struct MirrorStatus {
    /// One entry for each active `Camera3d` without [`NoMirrors`](crate::NoMirrors), in no
    /// particular order.
    pub cameras: Vec<CameraStatus>,
}

/// What became of a mirror as seen by one camera.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Clone, Debug, PartialEq)]
pub struct CameraStatus {
    /// The user's camera.
    pub camera: Entity,
    /// Drawn, or why not.
    pub state: MirrorState,
}

/// Whether a camera shows a mirror's reflection.
#[derive(Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Clone, Debug, PartialEq)]
pub enum MirrorState {
    /// Its reflection is drawn. In the first frames after it comes into view, until its pipelines are
    /// compiled, the scene is drawn as if the entity were no mirror.
    Drawn(Projection),
    /// It is not, and the scene is drawn as if the entity were no mirror.
    NotDrawn(NotDrawn),
}

/// The projection with which a reflection is drawn.
#[derive(Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Clone, Debug, PartialEq)]
pub enum Projection {
    /// The camera's own: nothing crosses the plane.
    Plain,
    /// With its near plane on the mirror.
    ///
    /// Other plugins may put items into a reflection of which nobody knows where they are, such as
    /// gizmos. The reflection is then drawn so in the same frame, and the status says so in the next.
    Oblique,
}

/// Why a mirror is not drawn for a camera.
#[derive(Reflect, Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[reflect(Clone, Debug, PartialEq, Hash)]
#[non_exhaustive]
pub enum NotDrawn {
    /// The app has no renderer.
    NoRenderer,
    /// The mirror is hidden by its own or an ancestor's `Visibility`.
    Hidden,
    /// The camera and the mirror share no `RenderLayers`.
    OtherLayers,
    /// The entity has no `Mesh3d`, or its mesh is not loaded yet.
    NoMesh,
    /// The mesh is not kept in the main world: give the plane by
    /// [`MirrorPlane::Local`](crate::MirrorPlane::Local), or keep the mesh.
    MeshNotInMainWorld,
    /// The mesh has no triangle with an area.
    MeshEmpty,
    /// The mesh's vertices do not lie in one plane.
    MeshNotFlat,
    /// The mesh has vertex positions or indices that cannot be read: not triangles, or not finite.
    MeshNotReadable,
    /// The mirror's mesh is skinned or morphed, so that it is not where its vertices say.
    MeshDeforms,
    /// The mirror's transform is not finite, or flattens the plane to a line or a point.
    DegenerateTransform,
    /// The camera's transform or projection is not finite or cannot be inverted.
    DegenerateCamera,
    /// The camera draws no picture: its target is `RenderTarget::None`, has no pixels, or is not
    /// known yet.
    NoTarget,
    /// The camera's `CameraRenderGraph` is not `Core3d`, in which the mirrors are drawn.
    OtherRenderGraph,
    /// The camera draws by deferred rendering, whose phases a mirror cannot use.
    DeferredCamera,
    /// The camera's eye is not in front of the plane, or too close to it to tell.
    EyeBehind,
    /// No part of the mirror is in the camera's view.
    OutOfView,
    /// The camera is nearer to the mirror, or farther from it, than its `VisibilityRange` says.
    OutOfRange,
    /// Opaque things before the mirror hide all of it from the camera.
    ///
    /// Such are meshes of at most 128 triangles, kept in the main world, with an opaque
    /// `StandardMaterial` whose textures are loaded. They must span a sixteenth of the picture's
    /// height. Behind anything else the reflection is drawn, though no pixel of it is shaded.
    Occluded,
    /// What is seen of the mirror is thinner than half a pixel; if the mirror was drawn in the frame
    /// before, than a quarter.
    TooThin,
    /// The plane cannot be told from the rounding of single precision at this distance from the
    /// origin.
    BelowPrecision,
    /// More mirrors are in view than [`PlanarMirrorPlugin`](crate::PlanarMirrorPlugin) may draw: those
    /// that cover more of the screen go first.
    TooManyMirrors,
}

/// What there is to draw for mirrors in this frame: one entry for each reflected view. Written by
/// the plugin alone, in `PostUpdate`.
///
/// How long the GPU takes for all mirrors of a camera is the span `planar_mirror_pass` of Bevy's
/// render diagnostics.
#[derive(Resource, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Resource, Default, Clone, Debug, PartialEq)]
pub struct MirrorFigures {
    /// Grouped by camera; a mirror comes before those that are seen in it.
    pub views: Vec<ViewFigures>,
}

/// One reflected view: a mirror, or several in one plane, as seen by a camera or in another mirror.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Clone, Debug, PartialEq)]
pub struct ViewFigures {
    /// The user's camera.
    pub camera: Entity,
    /// The mirror; of several one.
    pub mirror: Entity,
    /// How many mirrors share the view.
    pub mirrors: usize,
    /// How often a ray is reflected on its way to the camera: 1 if the camera sees the mirror
    /// itself.
    pub bounces: u8,
    /// What is seen of the mirrors on the screen, in physical pixels. What hides a part of them
    /// counts where it is of the kind of [`NotDrawn::Occluded`].
    pub pixels: f32,
    /// Meshes and other objects that are drawn in it.
    pub objects: usize,
    /// The projection with which they are drawn.
    pub projection: Projection,
    /// Where the shadows of directional lights come from. Never [`MirrorShadows::Auto`]; where there
    /// are none, what that would have chosen.
    pub shadows: MirrorShadows,
    /// Cascades of directional lights that are drawn for it: with [`MirrorShadows::Own`] those that
    /// something seen in it reads.
    pub cascades: usize,
    /// What it took to draw, the last time that it was drawn: a frame or two ago. `None` if it
    /// never was.
    pub drawn: Option<DrawnFigures>,
}

/// What it took to draw a reflected view.
#[derive(Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Clone, Debug, PartialEq)]
pub struct DrawnFigures {
    /// Draw calls for what shows in it. Many meshes that are drawn by one call are one, so these
    /// may be fewer than the objects. Those for shadow maps do not count.
    pub draws: usize,
    /// How long the CPU took to record the commands for the view, with those for its shadow maps.
    pub time: Duration,
}

impl MirrorStatus {
    /// The state as seen by `camera`; `None` where that camera is not concerned.
    pub fn of(&self, camera: Entity) -> Option<MirrorState> {
        self.cameras
            .iter()
            .find(|status| status.camera == camera)
            .map(|status| status.state)
    }

    /// Whether any camera shows the reflection.
    pub fn is_drawn(&self) -> bool {
        self.cameras
            .iter()
            .any(|status| matches!(status.state, MirrorState::Drawn(_)))
    }
}

impl fmt::Display for MirrorState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Drawn(Projection::Plain) => f.write_str("drawn, plain projection"),
            Self::Drawn(Projection::Oblique) => f.write_str("drawn, oblique near plane"),
            Self::NotDrawn(reason) => write!(f, "not drawn: {reason}"),
        }
    }
}

impl fmt::Display for NotDrawn {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoRenderer => "the app has no renderer",
            Self::Hidden => "hidden",
            Self::OtherLayers => "on other render layers than the camera",
            Self::NoMesh => "no mesh, or not loaded yet",
            Self::MeshNotInMainWorld => "the mesh is not kept in the main world",
            Self::MeshEmpty => "the mesh has no triangle with an area",
            Self::MeshNotFlat => "the mesh is not flat",
            Self::MeshNotReadable => "the mesh is not made of finite triangles",
            Self::MeshDeforms => "the mesh is skinned or morphed",
            Self::DegenerateTransform => "the mirror's transform is degenerate",
            Self::DegenerateCamera => "the camera's transform or projection is degenerate",
            Self::NoTarget => "the camera draws no picture",
            Self::OtherRenderGraph => "the camera's render graph is not Core3d",
            Self::DeferredCamera => "the camera uses deferred rendering",
            Self::EyeBehind => "the eye is not in front of the plane",
            Self::OutOfView => "out of view",
            Self::OutOfRange => "out of its visibility range",
            Self::Occluded => "hidden by what stands before it",
            Self::TooThin => "thinner than half a pixel",
            Self::BelowPrecision => "below the precision of the coordinates",
            Self::TooManyMirrors => "more mirrors in view than may be drawn",
        })
    }
}
