//! Which projection a reflection is drawn with, and what is drawn with it.

use bevy::{
    camera::visibility::{NoAutoAabb, NoCpuCulling, NoFrustumCulling, VisibilityRange},
    prelude::*,
};
use bevy_planar_mirror::{MirrorClip, MirrorState, PlanarMirror};

use super::app::{EYE, MirrorApp, OBLIQUE, PLAIN, above, floor, mirror_app};

/// A mirror on the ground, seen from above.
struct Ground {
    app: MirrorApp,
    mirror: Entity,
    camera: Entity,
}

impl Ground {
    fn new() -> Self {
        let mut app = mirror_app();
        let (mirror, camera) = (app.spawn_mirror(floor(0.0)), app.spawn_camera(above()));
        Self {
            app,
            mirror,
            camera,
        }
    }

    /// With a cube of width 0.4 whose lower face is at `height`.
    fn with_cube(height: f32) -> (Self, Entity) {
        let mut ground = Self::new();
        let cube = ground.app.spawn_cube(0.4, vec3(0.0, height + 0.2, 0.0));
        (ground, cube)
    }

    fn clip(&mut self, clip: MirrorClip) {
        self.app.of_mut::<PlanarMirror>(self.mirror).clip = clip;
    }

    fn state(&mut self) -> Option<MirrorState> {
        self.app.update();
        self.app.state_of(self.mirror, self.camera)
    }

    /// The meshes in the mirror, by this frame's update.
    fn reflected(&mut self) -> Vec<Entity> {
        self.app.update();
        let view = self.app.view(self.camera, self.mirror);
        self.app.visible_to(view)
    }
}

#[test]
fn nothing_to_cut_is_drawn_plain() {
    assert_eq!(Ground::new().state(), PLAIN);
    assert_eq!(Ground::with_cube(0.3).0.state(), PLAIN);
    assert_eq!(Ground::with_cube(-1.0).0.state(), PLAIN);
}

#[test]
fn what_straddles_the_plane_is_cut() {
    for height in [-0.05, -0.2, -0.35] {
        assert_eq!(Ground::with_cube(height).0.state(), OBLIQUE, "at {height}");
    }
}

/// What stands on a floor touches its plane, give or take rounding.
#[test]
fn what_stands_on_the_plane_is_not_cut() {
    for height in [0.0, -1e-7, 1e-7, -1e-4] {
        let (mut ground, cube) = Ground::with_cube(height);
        assert_eq!(ground.state(), PLAIN, "at {height}");
        assert!(ground.reflected().contains(&cube));
    }
    // Turned, its corners are off by rounding; nowhere near the origin, by more.
    let (mut ground, cube) = Ground::with_cube(0.0);
    for step in 0..20 {
        let shift = vec3(step as f32 * 13.7, step as f32 * 3.1, 0.0);
        for (entity, place) in [
            (ground.mirror, Vec3::ZERO),
            (ground.camera, above().translation),
            (cube, vec3(0.0, 0.2, 0.0)),
        ] {
            ground.app.of_mut::<Transform>(entity).translation = place + shift;
        }
        ground.app.of_mut::<Transform>(cube).rotation = Quat::from_rotation_y(step as f32);
        assert_eq!(ground.state(), PLAIN, "step {step}");
        assert!(ground.reflected().contains(&cube));
    }
}

#[test]
fn the_projection_changes_when_something_dips_and_comes_back() {
    let (mut ground, cube) = Ground::with_cube(0.3);
    for (y, expected) in [
        (0.5, PLAIN),
        (0.1, OBLIQUE),
        (-0.1, OBLIQUE),
        (-0.5, PLAIN),
        (0.0, OBLIQUE),
        (0.2, PLAIN),
    ] {
        ground.app.of_mut::<Transform>(cube).translation.y = y;
        assert_eq!(ground.state(), expected, "at {y}");
    }
    ground.app.of_mut::<Transform>(cube).translation.y = 0.0;
    assert_eq!(ground.state(), OBLIQUE);
    ground.app.insert(cube, Visibility::Hidden);
    assert_eq!(ground.state(), PLAIN, "what is hidden needs no cut");
    ground.app.insert(cube, Visibility::Visible);
    assert_eq!(ground.state(), OBLIQUE);
    ground.app.despawn(cube);
    assert_eq!(ground.state(), PLAIN);
}

#[test]
fn what_the_mirror_does_not_show_needs_no_cut() {
    // It straddles the plane, outside what can be seen in the mirror's frame: far from it, and on each side of it
    // where the camera's own view goes on.
    for (place, seen) in [
        (vec3(30.0, 0.0, -3.0), false),
        (vec3(0.0, 0.0, 60.0), false),
        (vec3(2.0, 0.0, 0.0), true),
        (vec3(-2.0, 0.0, 0.0), true),
        (vec3(0.0, 0.0, 2.0), true),
        (vec3(0.0, 0.0, -3.0), true),
    ] {
        let mut ground = Ground::new();
        let cube = ground.app.spawn_cube(0.4, place);
        assert_eq!(ground.state(), PLAIN, "at {place}");
        assert!(!ground.reflected().contains(&cube), "at {place}");
        assert_eq!(ground.app.visible_to(ground.camera).contains(&cube), seen);
    }
}

#[test]
fn what_lies_behind_is_not_in_the_mirror() {
    let mut ground = Ground::new();
    let app = &mut ground.app;
    let front = [0.3, 0.6].map(|y| app.spawn_cube(0.2, vec3(0.1, y, 0.0)));
    let straddling = app.spawn_cube(0.2, vec3(-0.4, 0.0, 0.2));
    let behind = [-0.3, -5.0].map(|y| app.spawn_cube(0.2, vec3(0.1, y, 0.0)));
    // Under the floor by a hair, and in its plane: nothing of them shows.
    let under = app.spawn_cube(0.2, vec3(0.4, -0.1, 0.0));
    let carpet = app.mesh(Plane3d::default().mesh().size(0.5, 0.5));
    let carpet = app.spawn((Mesh3d(carpet), Transform::default()));
    let mut reflected = ground.reflected();
    reflected.sort();
    let mut expected = vec![front[0], front[1], straddling];
    expected.sort();
    assert_eq!(reflected, expected);
    for hidden in [behind[0], behind[1], under, carpet, ground.mirror] {
        assert!(!expected.contains(&hidden));
    }
    // The camera itself sees them as ever.
    let seen = ground.app.visible_to(ground.camera);
    for entity in [behind[0], under, carpet, ground.mirror] {
        assert!(seen.contains(&entity));
    }
}

#[test]
fn a_mirror_is_not_in_itself_but_in_others() {
    let mut ground = Ground::new();
    let wall = ground.app.spawn_mirror(Transform::from_xyz(0.0, 1.0, -1.0));
    ground.app.update();
    let in_floor = ground.app.view(ground.camera, ground.mirror);
    let in_wall = ground.app.view(ground.camera, wall);
    assert_eq!(ground.app.visible_to(in_floor), [wall]);
    assert_eq!(ground.app.visible_to(in_wall), [ground.mirror]);
    // Without bounds it would be in every list.
    ground.app.insert(ground.mirror, NoFrustumCulling);
    ground.app.update();
    assert_eq!(ground.app.visible_to(in_floor), [wall]);
}

#[test]
fn a_mirror_that_nothing_else_crosses_does_not_cross_itself() {
    let mut ground = Ground::new();
    ground.app.insert(ground.mirror, NoFrustumCulling);
    assert_eq!(ground.state(), PLAIN);
}

#[test]
fn what_has_no_known_bounds_is_cut() {
    // In front of the plane by far, but nobody can know.
    let (mut ground, cube) = Ground::with_cube(3.0);
    assert_eq!(ground.state(), PLAIN);
    ground.app.insert(cube, NoFrustumCulling);
    assert_eq!(ground.state(), OBLIQUE, "bounds that do not count");
    assert!(ground.reflected().contains(&cube));
    ground.app.remove::<NoFrustumCulling>(cube);
    assert_eq!(ground.state(), PLAIN);

    ground.app.insert(cube, NoCpuCulling);
    assert_eq!(ground.state(), OBLIQUE, "in no list of the CPU's");
    ground.app.remove::<NoCpuCulling>(cube);
    assert_eq!(ground.state(), PLAIN);

    ground.app.insert(cube, NoAutoAabb);
    ground.app.remove::<bevy::camera::primitives::Aabb>(cube);
    assert_eq!(ground.state(), OBLIQUE, "no bounds at all");
    assert!(ground.reflected().contains(&cube));
    ground.app.remove::<NoAutoAabb>(cube);
    assert_eq!(ground.state(), PLAIN);
}

#[test]
fn the_user_may_choose() {
    let (mut ground, cube) = Ground::with_cube(0.3);
    ground.clip(MirrorClip::Oblique);
    assert_eq!(ground.state(), OBLIQUE, "also where nothing crosses");
    ground.clip(MirrorClip::Whole);
    assert_eq!(ground.state(), PLAIN);
    ground.app.of_mut::<Transform>(cube).translation.y = 0.0;
    assert_eq!(ground.state(), PLAIN, "also where something crosses");
    assert!(ground.reflected().contains(&cube));
    ground.clip(MirrorClip::Auto);
    assert_eq!(ground.state(), OBLIQUE);
    // What is wholly behind is never in the mirror.
    ground.app.of_mut::<Transform>(cube).translation.y = -0.5;
    for clip in [MirrorClip::Auto, MirrorClip::Oblique, MirrorClip::Whole] {
        ground.clip(clip);
        assert!(!ground.reflected().contains(&cube), "{clip:?}");
    }
}

#[test]
fn each_camera_and_each_mirror_has_its_own_projection() {
    let mut app = mirror_app();
    let cameras = [EYE, Transform::from_xyz(0.5, 0.0, 4.0)].map(|eye| app.spawn_camera(eye));
    let crossed = app.spawn_mirror(Transform::from_xyz(-1.1, 0.0, 0.0));
    let free = app.spawn_mirror(Transform::from_xyz(1.1, 0.0, -3.0));
    app.spawn_cube(0.4, vec3(-1.1, 0.0, 0.0));
    app.update();
    for camera in cameras {
        app.assert_state(crossed, camera, OBLIQUE);
        app.assert_state(free, camera, PLAIN);
    }
}

#[test]
fn an_orthographic_camera_cuts_alike() {
    let (mut ground, cube) = Ground::with_cube(0.0);
    let projection = OrthographicProjection {
        scale: 0.02,
        ..OrthographicProjection::default_3d()
    };
    ground
        .app
        .insert(ground.camera, Projection::from(projection));
    assert_eq!(ground.state(), PLAIN);
    assert!(ground.reflected().contains(&cube));
    ground.app.of_mut::<Transform>(cube).translation.y = 0.0;
    assert_eq!(ground.state(), OBLIQUE);
    ground.app.of_mut::<Transform>(cube).translation.y = -0.5;
    assert_eq!(ground.state(), PLAIN);
    assert!(!ground.reflected().contains(&cube));
}

/// The range counts from the eye of the view: as far as the light goes by way of the mirror.
#[test]
fn levels_of_detail_hold_in_the_mirror() {
    let (mut ground, cube) = Ground::with_cube(0.3);
    // 4.3 from the eye, and 4.7 by way of the floor.
    for (range, seen, reflected) in [(10.0, true, true), (4.5, true, false), (2.0, false, false)] {
        ground.app.insert(cube, VisibilityRange::abrupt(0.0, range));
        assert_eq!(
            ground.reflected().contains(&cube),
            reflected,
            "range {range}"
        );
        assert_eq!(ground.app.visible_to(ground.camera).contains(&cube), seen);
    }
}

/// Of many objects several threads look for those that show.
#[test]
fn what_shows_is_the_same_among_many_objects() {
    let seen = |more: bool| {
        let mut ground = Ground::new();
        let spawn = |ground: &mut Ground, y: f32| -> Vec<Entity> {
            let places = (0..600).map(|i| ((i % 30) as f32, (i / 30) as f32));
            let places = places.map(|(x, z)| vec3(0.2 * x - 3.0, y, 0.2 * z - 2.0));
            places
                .map(|place| ground.app.spawn_cube(0.1, place))
                .collect()
        };
        let cubes = spawn(&mut ground, 0.3);
        if more {
            spawn(&mut ground, -0.3);
        }
        let reflected = ground.reflected();
        assert!(reflected.is_sorted());
        let index = |seen: &Entity| cubes.iter().position(|cube| cube == seen);
        reflected.iter().map(index).collect::<Vec<_>>()
    };
    let few = seen(false);
    assert!(few.len() > 100 && few.len() < 600, "{}", few.len());
    assert_eq!(seen(true), few);
}
