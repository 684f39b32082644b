//! Mirrors that are hidden by what stands before them.

use std::f32::consts::PI;

use bevy::{
    asset::RenderAssetUsages,
    camera::visibility::{RenderLayers, VisibilityRange},
    material::OpaqueRendererMethod,
    mesh::{Indices, morph::MeshMorphWeights, skinning::SkinnedMesh},
    pbr::DefaultOpaqueRendererMethod,
    prelude::*,
    render::render_resource::Face,
};
use bevy_planar_mirror::{MirrorFigures, MirrorState, NotDrawn, PlanarMirror, PlanarMirrorPlugin};

use super::app::{EYE, MirrorApp, PLAIN, mirror_app, mirror_app_of, not};

/// Halfway between the camera and a mirror at the origin.
const WALL: Transform = Transform::from_xyz(0.0, 0.0, 2.5);

/// A wall before a mirror, and the camera that sees nothing of the mirror for that.
struct Hidden {
    app: MirrorApp,
    camera: Entity,
    mirror: Entity,
    wall: Entity,
}

fn paint(app: &mut MirrorApp, material: StandardMaterial) -> MeshMaterial3d<StandardMaterial> {
    let mut materials = app.world_mut().resource_mut::<Assets<StandardMaterial>>();
    MeshMaterial3d(materials.add(material))
}

fn painted_app() -> MirrorApp {
    let mut app = mirror_app();
    app.init_asset::<StandardMaterial>();
    app
}

fn spawn_wall(app: &mut MirrorApp, mesh: impl Into<Mesh>, place: Transform) -> Entity {
    let mesh = app.mesh(mesh);
    let material = paint(app, StandardMaterial::default());
    app.spawn((Mesh3d(mesh), material, place))
}

impl Hidden {
    fn new() -> Self {
        Self::behind(Rectangle::new(2.0, 2.0))
    }

    fn behind(mesh: impl Into<Mesh>) -> Self {
        let mut app = painted_app();
        let camera = app.spawn_camera(EYE);
        let mirror = app.spawn_mirror(default());
        let wall = spawn_wall(&mut app, mesh, WALL);
        app.update();
        Self {
            app,
            camera,
            mirror,
            wall,
        }
    }

    /// From this very frame on it is or is not.
    #[track_caller]
    fn assert_hidden(&mut self, is_hidden: bool) {
        self.app.update();
        let state = self.app.state_of(self.mirror, self.camera);
        if is_hidden {
            assert_eq!(state, not(NotDrawn::Occluded));
        } else {
            assert!(matches!(state, Some(MirrorState::Drawn(_))), "{state:?}");
        }
        assert_eq!(self.app.views().is_empty(), is_hidden);
    }

    /// Changed so, the wall hides the mirror or does not.
    #[track_caller]
    fn assert_with(is_hidden: bool, change: impl FnOnce(&mut MirrorApp, Entity)) {
        let mut hidden = Self::new();
        hidden.assert_hidden(true);
        change(&mut hidden.app, hidden.wall);
        hidden.assert_hidden(is_hidden);
    }
}

#[test]
fn a_mirror_behind_a_wall_has_no_view() {
    let mut hidden = Hidden::new();
    hidden.assert_hidden(true);
    assert!(
        hidden
            .app
            .world()
            .resource::<MirrorFigures>()
            .views
            .is_empty()
    );
    hidden.app.updates(100);
    let wall = hidden.wall;
    hidden.app.of_mut::<Transform>(wall).translation.x = 0.7;
    hidden.assert_hidden(false);
    hidden.app.of_mut::<Transform>(wall).translation.x = 0.0;
    hidden.assert_hidden(true);
    // The eye looks past it.
    let camera = hidden.camera;
    hidden.app.of_mut::<Transform>(camera).translation.x = 1.2;
    hidden.assert_hidden(false);
    hidden.app.of_mut::<Transform>(camera).translation.x = 0.0;
    hidden.assert_hidden(true);
    hidden.app.despawn(wall);
    hidden.assert_hidden(false);
}

#[test]
fn what_is_not_surely_drawn_hides_nothing() {
    let with = |change: fn(&mut StandardMaterial)| {
        move |app: &mut MirrorApp, wall: Entity| {
            let mut material = StandardMaterial::default();
            change(&mut material);
            let material = paint(app, material);
            app.insert(wall, material);
        }
    };
    for change in [
        (|material| material.alpha_mode = AlphaMode::Blend) as fn(&mut StandardMaterial),
        |material| material.alpha_mode = AlphaMode::Mask(0.5),
        |material| material.alpha_mode = AlphaMode::AlphaToCoverage,
        |material| material.specular_transmission = 0.5,
        |material| material.depth_bias = -100.0,
        |material| material.opaque_render_method = OpaqueRendererMethod::Deferred,
        |material| material.cull_mode = Some(Face::Front),
    ] {
        Hidden::assert_with(false, with(change));
    }
    Hidden::assert_with(false, |app, wall| app.insert(wall, Visibility::Hidden));
    Hidden::assert_with(false, |app, wall| app.insert(wall, RenderLayers::layer(3)));
    Hidden::assert_with(false, |app, wall| {
        app.insert(wall, VisibilityRange::abrupt(0.0, 100.0));
    });
    Hidden::assert_with(false, |app, wall| app.insert(wall, SkinnedMesh::default()));
    Hidden::assert_with(false, |app, wall| {
        let weights = MeshMorphWeights::Value { weights: vec![0.5] };
        app.insert(wall, weights);
    });
    Hidden::assert_with(false, |app, wall| app.insert(wall, PlanarMirror::default()));
    Hidden::assert_with(false, |app, wall| {
        app.remove::<MeshMaterial3d<StandardMaterial>>(wall);
    });
    // Its back.
    Hidden::assert_with(false, |app, wall| {
        app.of_mut::<Transform>(wall).rotation = Quat::from_rotation_y(PI);
    });
    // Mirrored by its transform, it shows its back as well.
    Hidden::assert_with(false, |app, wall| {
        app.of_mut::<Transform>(wall).scale.x = -1.0
    });
}

#[test]
fn walls_whose_textures_are_not_loaded_hide_nothing() {
    let mut hidden = Hidden::new();
    let images = hidden.app.world().resource::<Assets<Image>>();
    let texture = images.reserve_handle();
    let material = StandardMaterial {
        base_color_texture: Some(texture.clone()),
        ..default()
    };
    let material = paint(&mut hidden.app, material);
    let wall = hidden.wall;
    hidden.app.insert(wall, material);
    hidden.assert_hidden(false);
    let mut images = hidden.app.world_mut().resource_mut::<Assets<Image>>();
    images
        .insert(texture.id(), Image::default())
        .expect("it is reserved");
    hidden.assert_hidden(true);
}

#[test]
fn where_all_is_drawn_deferred_a_camera_that_does_not_sees_no_walls() {
    let mut hidden = Hidden::new();
    hidden
        .app
        .insert_resource(DefaultOpaqueRendererMethod::deferred());
    hidden.assert_hidden(false);
    hidden
        .app
        .insert_resource(DefaultOpaqueRendererMethod::forward());
    hidden.assert_hidden(true);
}

#[test]
fn what_is_drawn_from_behind_hides_too() {
    let turn = |app: &mut MirrorApp, wall: Entity| {
        app.of_mut::<Transform>(wall).rotation = Quat::from_rotation_y(PI);
    };
    for culled in [None, Some(Face::Front)] {
        Hidden::assert_with(true, |app, wall| {
            turn(app, wall);
            let material = paint(
                app,
                StandardMaterial {
                    cull_mode: culled,
                    ..default()
                },
            );
            app.insert(wall, material);
        });
    }
    let mut hidden = Hidden::new();
    let camera = hidden.camera;
    hidden.app.of_mut::<Camera>(camera).invert_culling = true;
    hidden.assert_hidden(false);
    turn(&mut hidden.app, hidden.wall);
    hidden.assert_hidden(true);
}

#[test]
fn meshes_that_cannot_be_read_hide_nothing() {
    let mut unseen = Rectangle::new(2.0, 2.0).mesh().build();
    unseen.asset_usage = RenderAssetUsages::MAIN_WORLD;
    Hidden::behind(unseen).assert_hidden(false);
    let mut unindexed = Rectangle::new(2.0, 2.0).mesh().build();
    unindexed.duplicate_vertices();
    Hidden::behind(unindexed).assert_hidden(false);
    let mut dangling = Rectangle::new(2.0, 2.0).mesh().build();
    dangling.insert_indices(Indices::U32(vec![0, 1, 9, 0, 2, 7]));
    Hidden::behind(dangling).assert_hidden(false);
    Hidden::behind(Sphere::new(2.0).mesh().ico(5).expect("it is small")).assert_hidden(false);
}

#[test]
fn several_hide_it_together() {
    let mut hidden = Hidden::behind(Cuboid::new(0.6, 2.0, 0.2));
    hidden.assert_hidden(false);
    let right = Transform::from_xyz(0.55, 0.0, 2.0);
    spawn_wall(&mut hidden.app, Cuboid::new(1.0, 3.0, 0.2), right);
    hidden.assert_hidden(false);
    let left = Transform::from_xyz(-0.55, 0.0, 3.0);
    let left = spawn_wall(&mut hidden.app, Cuboid::new(1.0, 3.0, 0.2), left);
    hidden.assert_hidden(true);
    // A door in it opens.
    hidden.app.of_mut::<Transform>(left).translation.x = -0.9;
    hidden.assert_hidden(false);
}

/// Whatever was spawned first.
#[test]
fn small_things_between_do_not_matter() {
    let mut app = painted_app();
    let camera = app.spawn_camera(EYE);
    let mirror = app.spawn_mirror(default());
    for i in 0..100_u8 {
        let (column, row) = (f32::from(i % 10), f32::from(i / 10));
        let place = Transform::from_xyz(0.2 * column - 0.9, 0.2 * row - 0.9, 1.0);
        let turn = Quat::from_rotation_z(f32::from(i));
        spawn_wall(
            &mut app,
            Cuboid::from_length(0.15),
            place.with_rotation(turn),
        );
    }
    app.update();
    app.assert_state(mirror, camera, PLAIN);
    spawn_wall(&mut app, Cuboid::new(2.1, 2.1, 0.1), WALL);
    app.update();
    app.assert_state(mirror, camera, not(NotDrawn::Occluded));
}

#[test]
fn a_view_is_narrowed_to_what_a_wall_leaves() {
    let mut hidden = Hidden::new();
    let [left, right] = [-0.7, 0.7].map(|x| hidden.app.spawn_cube(0.1, Vec3::new(x, 0.0, 2.0)));
    let (camera, mirror, wall) = (hidden.camera, hidden.mirror, hidden.wall);
    let mut figures = |place: f32| {
        hidden.app.of_mut::<Transform>(wall).translation.x = place;
        hidden.app.update();
        let figures = hidden.app.world().resource::<MirrorFigures>();
        let pixels = figures.views[0].pixels;
        let view = hidden.app.view(camera, mirror);
        let visible = hidden.app.visible_to(view);
        (pixels, visible.contains(&left), visible.contains(&right))
    };
    let (all, ..) = figures(9.0);
    assert_eq!(figures(9.0), (all, true, true));
    let (half, sees_left, sees_right) = figures(1.0);
    assert!((half / all - 0.5).abs() < 1e-3, "{half} of {all}");
    assert!(sees_left && !sees_right);
    assert_eq!(figures(-1.0), (half, false, true));
}

#[test]
fn of_several_mirrors_only_those_behind_the_wall_are_left_out() {
    let mut hidden = Hidden::new();
    let beside = hidden.app.spawn_mirror(Transform::from_xyz(2.5, 0.0, 0.0));
    hidden.app.update();
    let (camera, mirror) = (hidden.camera, hidden.mirror);
    hidden
        .app
        .assert_state(mirror, camera, not(NotDrawn::Occluded));
    hidden.app.assert_state(beside, camera, PLAIN);
    // For another camera it is the other one.
    let other = hidden.app.spawn_camera(Transform::from_xyz(2.5, 0.0, 5.0));
    let second = Transform::from_xyz(2.5, 0.0, 2.5);
    spawn_wall(&mut hidden.app, Rectangle::new(2.0, 2.0), second);
    hidden.app.update();
    hidden.app.assert_state(mirror, other, PLAIN);
    hidden
        .app
        .assert_state(beside, other, not(NotDrawn::Occluded));
}

/// What hides one mirror in another is not looked for.
#[test]
fn mirrors_in_mirrors_are_drawn() {
    let mut app = mirror_app_of(PlanarMirrorPlugin {
        max_bounces: 2,
        ..default()
    });
    app.init_asset::<StandardMaterial>();
    app.spawn_camera(EYE);
    app.spawn_mirror(default());
    let opposite = Transform::from_xyz(0.0, 0.0, 9.0).with_rotation(Quat::from_rotation_y(PI));
    let opposite = app.spawn_mirror(opposite.with_scale(Vec3::splat(0.1)));
    let wall = Transform::from_xyz(0.0, 0.0, 8.0);
    spawn_wall(&mut app, Cuboid::new(1.0, 1.0, 0.1), wall);
    app.update();
    assert_eq!(app.views().len(), 2);
    app.despawn(opposite);
    app.update();
    assert_eq!(app.views().len(), 1);
}
