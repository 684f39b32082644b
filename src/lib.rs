//! Planar mirrors for Bevy: put one component on a flat mesh, and every 3D camera sees the scene
//! reflected in it.
//!
//! The reflection is drawn straight into the picture of each camera, so it has that camera's
//! resolution, samples, exposure and tone mapping. What crosses the mirror is cut at it, what lies
//! behind it never shows, and a translucent material on the mirror blends over the reflection as
//! over anything else.
//!
//! # A mirror
//!
//! Add the plugin, and [`PlanarMirror`] beside a `Mesh3d`. There is no camera to set up, no image
//! to make and no size to keep.
//!
//! ```no_run
//! use bevy::prelude::*;
//! use bevy_planar_mirror::prelude::*;
//!
//! fn main() {
//!     App::new()
//!         .add_plugins((DefaultPlugins, PlanarMirrorPlugin::default()))
//!         .add_systems(Startup, setup)
//!         .run();
//! }
//!
//! fn setup(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>) {
//!     commands.spawn((
//!         Mesh3d(meshes.add(Rectangle::new(3.0, 2.0))),
//!         Transform::from_xyz(0.0, 1.0, -2.0),
//!         PlanarMirror::default(),
//!     ));
//!     // ... and a camera, lights and something to reflect, as in any scene.
//! }
//! ```
//!
//! Only the front reflects: the side from which the triangles wind counter-clockwise, which is +Z
//! for a `Rectangle` and +Y for a `Plane3d`. Any flat mesh will do, also one modelled away from its
//! pivot; its plane is fitted to its triangles. A mesh that is not kept in the main world needs the
//! plane told, by [`MirrorPlane::Local`].
//!
//! # What lies over the reflection
//!
//! Without a material, or with an opaque one, the mesh is a perfect mirror. A material that blends
//! is drawn over the reflection by its own formula: here, half floor and half reflection. Where a
//! material with `AlphaMode::Mask` has holes, the mirror has them too. A mirror with a
//! `VisibilityRange` fades and goes with it.
//!
//! ```
//! # use bevy::prelude::*;
//! # use bevy_planar_mirror::prelude::*;
//! fn polished_floor(
//!     mut commands: Commands,
//!     mut meshes: ResMut<Assets<Mesh>>,
//!     mut materials: ResMut<Assets<StandardMaterial>>,
//! ) {
//!     commands.spawn((
//!         Mesh3d(meshes.add(Plane3d::default().mesh().size(10.0, 10.0))),
//!         MeshMaterial3d(materials.add(StandardMaterial {
//!             base_color: Color::srgba(0.6, 0.6, 0.6, 0.5),
//!             alpha_mode: AlphaMode::Blend,
//!             ..default()
//!         })),
//!         PlanarMirror::default(),
//!     ));
//! }
//! ```
//!
//! # Why a mirror is dark
//!
//! [`MirrorStatus`] is on every mirror and says, camera by camera, whether the reflection is drawn
//! and otherwise why not. What only you can mend, as a mesh that is not flat, is also in the log,
//! once, as a warning of `bevy_planar_mirror`.
//!
//! ```
//! # use bevy::prelude::*;
//! # use bevy_planar_mirror::prelude::*;
//! fn print_status(mirrors: Query<(Entity, &MirrorStatus), Changed<MirrorStatus>>) {
//!     for (mirror, status) in &mirrors {
//!         for seen in &status.cameras {
//!             println!("{mirror}, seen by {}: {}", seen.camera, seen.state);
//!         }
//!     }
//! }
//! ```
//!
//! | you see | look at |
//! |---|---|
//! | the mesh as if it were no mirror | its [`MirrorStatus`]: [`NotDrawn`] names the reason |
//! | nothing from one side | the front: turn the mesh around, or give [`MirrorPlane::Local`] a normal |
//! | a mirror that hides all behind it | that is what it does; a surface to see through is not done yet |
//! | no reflection in one camera | [`NoMirrors`] on it, its `RenderLayers`, deferred rendering |
//! | no reflection in the first frames | pipelines are compiled in the background; the mesh shows plain until all that its reflection needs is ready |
//! | an object cut off or missing in the mirror | its bounds: see below |
//!
//! # Objects that leave their bounds
//!
//! Bevy finds what a camera sees by each object's bounds, its `Aabb`. A mirror uses them also to
//! leave out what lies behind it, and to find out whether something crosses it and must be cut.
//! Bounds that do not follow the mesh would be wrong there.
//!
//! - Meshes with morph targets, and skinned meshes without `DynamicSkinnedMeshBounds`, may be
//!   anywhere near their bounds. They are drawn and cut wherever they are.
//! - If a vertex shader of yours moves a mesh out of its bounds, put `NoFrustumCulling` on it. It
//!   then may be anywhere, for the camera and for mirrors.
//! - Meshes with `NoCpuCulling` may be anywhere.
//!
//! A mirror that shows such an object is cut at its plane in every frame, and draws shadow maps of
//! its own.
//!
//! A shader may build a billboard from the view's own axes. It turns to the eye in the mirror too:
//! the axes of a reflected view have the same handedness as those of any view.
//!
//! # What it costs
//!
//! [`MirrorFigures`] lists the reflected views of a frame, with the pixels of the mirror, the
//! objects, the draw calls and the shadow cascades drawn for it, and the time that the CPU took to
//! record them. How long the GPU took for all mirrors of a camera is the span
//! `planar_mirror_pass` of Bevy's render diagnostics. With the feature `debug` gizmos show the
//! visible part of each mirror and the frustum behind it, in which objects are looked for.
//!
//! A mirror costs what is seen in it: its pixels and the objects that show. Directional shadows
//! come from the shadow maps that the camera has anyway, if these hold all that fall on what shows,
//! and else from maps of the mirror's own with no others in them; see [`MirrorShadows`]. Where no
//! more than eight lamps reach what shows, or 32 of a small mirror, they need no light clusters;
//! with a light probe or a clustered decal anywhere in the world they do. Mirrors in one plane
//! share a view, so that a floor of tiles costs as one mirror.
//!
//! What walls hide of a mirror costs nothing: opaque meshes of few triangles, see
//! [`NotDrawn::Occluded`]. They may hide it together, and what moves is taken where it is in this
//! very frame. Behind anything else, and in another mirror, a hidden mirror has its view, but none
//! of its pixels are shaded.
//!
//! # Mirrors in mirrors
//!
//! ```
//! # use bevy::prelude::*;
//! # use bevy_planar_mirror::prelude::*;
//! # let mut app = App::new();
//! app.add_plugins(PlanarMirrorPlugin {
//!     max_bounces: 4,
//!     ..default()
//! });
//! ```
//!
//! Each mirror that is seen in a mirror then has a view of its own, narrowed to what is seen of it;
//! where that is thinner than half a pixel it ends by itself.
//!
//! # Which camera sees which mirror
//!
//! Every active `Camera3d` sees every visible mirror on its `RenderLayers`, and what it sees in it
//! is what those layers show. [`NoMirrors`] on a camera leaves it out.
//!
//! ```
//! # use bevy::prelude::*;
//! # use bevy_planar_mirror::prelude::*;
//! fn spawn_minimap(mut commands: Commands) {
//!     commands.spawn((Camera3d::default(), Camera { order: 1, ..default() }, NoMirrors));
//! }
//! ```
//!
//! Your systems never meet the plugin's own views: `Single<&Camera3d>`, picking and the camera of
//! the UI are what they would be without it, and no component of yours is edited. Components that
//! your app requires of every camera, or inserts from an observer, are taken off the views again.
//! There are three ways to meet a view all the same: an observer of new cameras is told of it, a
//! query with `Allow<Disabled>` finds it, and systems in `ExtractSchedule` see it as a camera to
//! draw. And on a device that cannot sort lights into clusters on the GPU, Bevy must see the views
//! while it does so on the CPU: a system in `PostUpdate` that is not ordered against
//! `SimulationLightSystems::AssignLightsToClusters` may meet them then.
//!
//! The plugin works in `PostUpdate`, after transforms are propagated, so a mirror and a camera that
//! move are seen where they are in this very frame. To order systems of yours against it, see
//! [`MirrorSystems`].
//!
//! # How it works
//!
//! 1. The plane is fitted to the mesh, in `f64`: [`math::fit_patch`].
//! 2. For each camera that sees the front of it, past the walls before it, there is a *reflected
//!    view*: the camera, reflected about the plane, with the same projection and without a target
//!    of its own. What is visible from there is found by Bevy's own rules, and Bevy sorts and batches
//!    it as for any view.
//! 3. What lies wholly behind the plane is dropped. If something crosses the plane, the view's near
//!    plane is moved onto it ([`math::with_oblique_near_plane`]), which cuts it there.
//! 4. Between the camera's opaque and transparent passes, the *mirror pass* draws the mesh into a
//!    stencil where nothing stands before it, then the reflected view where that stencil is set. The
//!    stencil counts reflections, so that a mirror in a mirror is drawn the same way.
//!    The pipelines are Bevy's own with a stencil test added and the front face turned around, as a
//!    reflection turns the winding around.
//! 5. The mirror's depth goes into the camera's, and the transparent pass draws the mirror's own
//!    material over the reflection.
//!
//! The geometry is a module of its own, [`math`], which knows nothing of Bevy.
//!
//! | word | meaning |
//! |---|---|
//! | reflected view | the scene as seen by the camera's mirror image |
//! | bounce | one of the reflections of a ray on its way to the camera |
//! | front | the side of the plane that its normal points to, and that reflects |
//! | mask | the pixels in which a mirror shows, as marked in the stencil |
//! | plain projection | the camera's own; enough while nothing crosses the plane |
//! | oblique near plane | a near plane that lies on the mirror instead of square to the view |
//!
//! # Limits
//!
//! - Of a mirror in a mirror one sees its material, if any, beyond
//!   [`max_bounces`](PlanarMirrorPlugin::max_bounces), which is 1 by default.
//! - A camera that renders deferred sees no mirrors, and the status says so.
//! - The reflection is sharp: there is no roughness and no blur.
//! - What screen-space effects and temporal filters read of a mirror's pixels, depth, normals and
//!   motion, is that of its surface and not of what is reflected. Screen-space ambient occlusion
//!   and contact shadows come before that: at a mirror's edge they see what is behind it.
//! - Of what is not a mesh, a skybox or an item in one of Bevy's 3D phases nothing shows in a
//!   reflection: not the sky and the haze of an `Atmosphere`, nor volumetric fog, nor a phase of
//!   another plugin's own. Of Bevy's own additional phases wireframes do show.
//! - With order independent transparency, what blends in a reflection is sorted by distance.
//! - The reflection has no depth prepass: forward decals, contact shadows and ambient occlusion are
//!   left out of it, and so is, with a warning, a material that reads a prepass without asking
//!   whether there is one by `#ifdef DEPTH_PREPASS`.
//! - While something crosses the plane, an orthographic camera's reflection has its highlights in
//!   the wrong place: the engine reads the direction of such a view from the depth row, which then
//!   is the mirror's. Nor does the camera's far plane cut what crosses it, since there is no depth
//!   left for that. [`MirrorClip::Whole`] avoids both, at the price of the cut.
//! - At most [`max_views`](PlanarMirrorPlugin::max_views) reflections show in one camera, by default
//!   255; of more, those that cover most of the screen. Mirrors in one plane share one.

#[cfg(feature = "debug")]
mod debug;
pub mod math;
mod mirror;
mod plugin;
mod render;
pub mod status;
mod view;

#[cfg(feature = "debug")]
pub use debug::MirrorGizmos;
pub use mirror::{MirrorClip, MirrorPlane, MirrorShadows, NoMirrors, PlanarMirror};
pub use plugin::{MirrorSystems, PlanarMirrorPlugin};
pub use status::{MirrorFigures, MirrorState, MirrorStatus, NotDrawn};

/// What a game imports: `use bevy_planar_mirror::prelude::*;`.
pub mod prelude {
    pub use crate::{
        MirrorClip, MirrorFigures, MirrorPlane, MirrorShadows, MirrorStatus, NoMirrors,
        PlanarMirror, PlanarMirrorPlugin,
    };
}
