//! A scene in motion: each frame is right by itself, whatever was shown before it.
//!
//! The law in all of these: one frame after a change the picture is, to the bit, that of an app that
//! never knew the scene otherwise.

use bevy::{
    camera::{Hdr, ScalingMode, Viewport, visibility::NoFrustumCulling},
    core_pipeline::Skybox,
    prelude::*,
    render::render_resource::Extent3d,
};
use bevy_planar_mirror::{MirrorClip, NoMirrors, PlanarMirror};

use crate::support::{
    live::{Change, Live, assert_each_seen_at_once, assert_seen_at_once, find, named, of, unclad},
    props::{BLUE, GREEN, MAGENTA, RED, YELLOW, at, glass, lit, six_colors, sun},
    scene::{Look, Scene, Surface},
    stage::Stage,
};

/// A wall mirror; a box, a ball and a pane before it, a block behind it.
pub fn room(name: &str) -> Scene {
    let mut scene = Scene::new(name)
        .eye(vec3(0.5, 0.8, 3.0), vec3(0.0, 0.1, 0.0))
        .mirror(Surface::wall(3.0, 2.0, at(0.0, 0.2, 0.0)).look(unclad("mirror")))
        .object(
            Cuboid::new(0.5, 0.7, 0.3),
            named("box", RED),
            at(-0.6, 0.0, 0.7),
        )
        .object(
            Sphere::new(0.3).mesh().uv(16, 10),
            named("ball", GREEN),
            at(0.6, 0.5, 0.5),
        )
        .object(
            Cuboid::new(0.6, 0.4, 0.02),
            named("pane", glass(YELLOW, 0.5)),
            at(-0.1, 0.5, 0.9),
        )
        .object(
            Cuboid::from_length(0.8),
            named("block", BLUE),
            at(0.3, 0.3, -0.9),
        )
        .with_camera(Name::new("camera"));
    scene.size = UVec2::new(96, 72);
    scene
}

/// The room with a floor under a shadowed sun.
fn sunny_room(name: &str) -> Scene {
    let mut scene = room(name)
        .object(
            Cuboid::new(4.0, 0.1, 4.0),
            lit(Color::srgb(0.8, 0.8, 0.7)),
            at(0.0, -0.8, 0.0),
        )
        .prop((sun(true), Name::new("sun")));
    scene.objects[0].look = named("box", lit(RED));
    scene
}

fn place(world: &mut World, name: &str, transform: Transform) {
    *of::<Transform>(world, name) = transform;
}

fn insert(world: &mut World, name: &str, bundle: impl Bundle) {
    let entity = find(world, name);
    world.entity_mut(entity).insert(bundle);
}

fn remove<B: Bundle>(world: &mut World, name: &str) {
    let entity = find(world, name);
    world.entity_mut(entity).remove::<B>();
}

fn despawn(world: &mut World, name: &str) {
    let entity = find(world, name);
    world.despawn(entity);
}

fn add<A: Asset>(world: &mut World, asset: A) -> Handle<A> {
    world.resource_mut::<Assets<A>>().add(asset)
}

/// Upright, turned and moved in the mesh itself: another plane for the same transform.
fn leaning_mesh() -> Mesh {
    let mesh: Mesh = Rectangle::new(2.0, 1.6).into();
    mesh.rotated_by(Quat::from_rotation_x(-0.4))
        .translated_by(vec3(0.2, 0.1, -0.3))
}

#[test]
fn a_mirror_and_a_camera_that_move_in_one_frame_are_both_seen_where_they_are() {
    let eye = Transform::from_xyz(-0.7, 0.5, 2.6).looking_at(vec3(0.1, 0.3, 0.0), Vec3::Y);
    let mirror = at(0.1, 0.1, -0.2).with_rotation(Quat::from_euler(EulerRot::YXZ, 0.2, -0.1, 0.05));
    assert_seen_at_once(&room("move-both"), |world| {
        place(world, "camera", eye);
        place(world, "mirror", mirror);
    });
}

#[test]
fn everything_moves_in_every_frame() {
    let moved: Vec<_> = (1..6)
        .map(|step| {
            move |world: &mut World| {
                let t = step as f32 * 0.15;
                let eye = vec3(0.5 - t, 0.8 - 0.3 * t, 3.0 - 0.4 * t);
                let eye = Transform::from_translation(eye).looking_at(Vec3::ZERO, Vec3::Y);
                place(world, "camera", eye);
                let turn = Quat::from_rotation_y(0.3 * t);
                place(world, "mirror", at(0.0, 0.2, -0.3 * t).with_rotation(turn));
                place(world, "box", at(-0.6 + 0.5 * t, 0.0, 0.7 - 0.9 * t));
                place(world, "ball", at(0.6, 0.5 - 0.4 * t, 0.5));
            }
        })
        .collect();
    let changes: Vec<Change> = moved.iter().map(|change| change as Change).collect();
    assert_each_seen_at_once(&room("move-all"), &changes);
}

#[test]
fn what_is_hidden_is_gone_at_once_and_what_is_shown_is_back_at_once() {
    fn see(name: &'static str, visibility: Visibility) -> impl Fn(&mut World) {
        move |world| *of::<Visibility>(world, name) = visibility
    }
    let (hide, show) = (Visibility::Hidden, Visibility::Inherited);
    assert_each_seen_at_once(
        &room("hide-and-show"),
        &[
            &see("ball", hide),
            &see("mirror", hide),
            &see("ball", show),
            &see("mirror", show),
            &see("pane", hide),
            &see("pane", show),
        ],
    );
}

#[test]
fn what_is_despawned_is_gone_at_once() {
    assert_each_seen_at_once(
        &room("despawn"),
        &[
            &|world| despawn(world, "ball"),
            &|world| despawn(world, "pane"),
            &|world| despawn(world, "mirror"),
        ],
    );
}

#[test]
fn a_mirror_that_stops_being_one_is_a_mesh_again() {
    assert_each_seen_at_once(
        &room("no-mirror-any-more"),
        &[
            &|world| remove::<PlanarMirror>(world, "mirror"),
            &|world| insert(world, "mirror", PlanarMirror::default()),
            &|world| insert(world, "camera", NoMirrors),
            &|world| remove::<NoMirrors>(world, "camera"),
        ],
    );
}

#[test]
fn a_camera_in_place_of_another_sees_its_own_reflection() {
    let other = Transform::from_xyz(-0.9, 0.4, 2.4).looking_at(vec3(0.0, 0.2, 0.0), Vec3::Y);
    let exchange = |world: &mut World| {
        let camera = find(world, "camera");
        let new = world.entity_mut(camera).clone_and_spawn();
        world.despawn(camera);
        *world.get_mut::<Transform>(new).expect("cloned") = other;
    };
    assert_seen_at_once(&room("another-camera"), exchange);
}

#[test]
fn a_mirror_with_a_new_parent_goes_where_it_is_taken() {
    let lower = |world: &mut World| {
        let taken = Transform {
            translation: vec3(0.2, -0.2, -0.3),
            rotation: Quat::from_rotation_y(-0.3),
            scale: vec3(0.8, 1.2, 1.0),
        };
        let parent = world.spawn((taken, Visibility::default(), Name::new("parent")));
        let parent = parent.id();
        insert(world, "mirror", ChildOf(parent));
    };
    assert_each_seen_at_once(
        &room("reparent"),
        &[
            &lower,
            &|world| place(world, "parent", at(0.0, 0.3, -0.1)),
            &|world| remove::<ChildOf>(world, "mirror"),
            &|world| {
                let parent = find(world, "parent");
                insert(world, "camera", ChildOf(parent));
            },
            &|world| {
                let parent = find(world, "parent");
                remove::<ChildOf>(world, "camera");
                insert(world, "mirror", ChildOf(parent));
            },
            // The parent takes the mirror with it.
            &|world| despawn(world, "parent"),
        ],
    );
}

#[test]
fn a_mirror_takes_the_plane_of_its_new_mesh_at_once() {
    assert_each_seen_at_once(
        &room("new-mesh"),
        &[
            &|world| {
                let mesh = add(world, leaning_mesh());
                insert(world, "mirror", Mesh3d(mesh));
            },
            &|world| {
                let mesh = add(world, Circle::new(0.9).into());
                insert(world, "mirror", Mesh3d(mesh));
            },
        ],
    );
}

#[test]
fn a_mesh_changed_in_place_changes_the_plane_at_once() {
    fn become_mesh(world: &mut World, name: &str, mesh: Mesh) {
        let id = of::<Mesh3d>(world, name).id();
        let mut meshes = world.resource_mut::<Assets<Mesh>>();
        *meshes.get_mut(id).expect("it is there") = mesh;
    }
    assert_each_seen_at_once(
        &room("changed-mesh"),
        &[
            &|world| become_mesh(world, "mirror", leaning_mesh()),
            &|world| become_mesh(world, "mirror", Rectangle::new(1.5, 2.0).into()),
            // Now it reaches through the plane.
            &|world| become_mesh(world, "ball", Cuboid::new(0.3, 0.4, 2.0).into()),
        ],
    );
}

#[test]
fn a_reflected_object_that_changes_its_material_changes_its_phase_at_once() {
    fn wear(name: &'static str, material: StandardMaterial) -> impl Fn(&mut World) {
        move |world| {
            let material = add(world, material.clone());
            insert(world, name, MeshMaterial3d(material));
        }
    }
    fn become_alpha(world: &mut World, alpha_mode: AlphaMode) {
        let id = of::<MeshMaterial3d<StandardMaterial>>(world, "ball").id();
        let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
        let mut material = materials.get_mut(id).expect("it is there");
        material.alpha_mode = alpha_mode;
        material.base_color = MAGENTA.with_alpha(0.5);
    }
    let opaque = StandardMaterial {
        unlit: true,
        base_color: MAGENTA,
        ..default()
    };
    assert_each_seen_at_once(
        &room("new-material"),
        &[
            &wear("ball", glass(RED, 0.4)),
            &wear("ball", opaque.clone()),
            &wear("pane", opaque),
            &|world| become_alpha(world, AlphaMode::Blend),
            &|world| become_alpha(world, AlphaMode::Mask(0.6)),
            &|world| become_alpha(world, AlphaMode::Opaque),
            &|world| become_alpha(world, AlphaMode::Add),
        ],
    );
}

#[test]
fn a_mirror_is_covered_veiled_and_bare_by_its_material() {
    assert_each_seen_at_once(
        &room("veil"),
        &[
            &|world| {
                let veil = add(world, glass(BLUE, 0.5));
                insert(world, "mirror", MeshMaterial3d(veil));
            },
            &|world| {
                let id = of::<MeshMaterial3d<StandardMaterial>>(world, "mirror").id();
                let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
                materials.get_mut(id).expect("it is there").alpha_mode = AlphaMode::Opaque;
            },
            &|world| {
                let veil = add(world, glass(RED, 0.3));
                insert(world, "mirror", MeshMaterial3d(veil));
            },
            &|world| remove::<MeshMaterial3d<StandardMaterial>>(world, "mirror"),
        ],
    );
}

#[test]
fn samples_and_formats_are_switched_at_run_time() {
    // Bright enough that a format without room for it would show.
    let bright = |world: &mut World| {
        let material = StandardMaterial {
            base_color: LinearRgba::rgb(0.6, 2.5, 4.0).into(),
            unlit: true,
            ..default()
        };
        let material = add(world, material);
        insert(world, "ball", MeshMaterial3d(material));
    };
    assert_each_seen_at_once(
        &room("formats"),
        &[
            &|world| *of::<Msaa>(world, "camera") = Msaa::Sample4,
            &|world| {
                insert(world, "camera", Hdr);
                bright(world);
            },
            &|world| *of::<Msaa>(world, "camera") = Msaa::Off,
            &|world| *of::<Msaa>(world, "camera") = Msaa::Sample4,
            &|world| {
                remove::<Hdr>(world, "camera");
                *of::<Msaa>(world, "camera") = Msaa::Off;
            },
        ],
    );
}

#[test]
fn a_camera_that_is_switched_off_and_on_shows_the_mirror_as_it_is_then() {
    let mut live = Live::new(&room("off-and-on"));
    live.settled();
    let switch = |world: &mut World, on: bool| of::<Camera>(world, "camera").is_active = on;
    switch(live.world(), false);
    for _ in 0..4 {
        live.next();
    }
    let mirror = at(0.0, 0.3, -0.3).with_rotation(Quat::from_rotation_y(0.2));
    place(live.world(), "mirror", mirror);
    live.next();
    switch(live.world(), true);
    let mut fresh = Live::new(&room("off-and-on"));
    place(fresh.world(), "mirror", mirror);
    live.next().assert_same(&fresh.settled(), "off-and-on");
}

#[test]
fn a_viewport_may_change_in_every_frame() {
    fn view(x: u32, y: u32, w: u32, h: u32) -> impl Fn(&mut World) {
        move |world| {
            of::<Camera>(world, "camera").viewport = Some(Viewport {
                physical_position: UVec2::new(x, y),
                physical_size: UVec2::new(w, h),
                ..default()
            });
        }
    }
    assert_each_seen_at_once(
        &room("viewport"),
        &[
            &view(10, 6, 70, 60),
            &view(0, 0, 40, 72),
            &view(48, 24, 48, 48),
            &|world| of::<Camera>(world, "camera").viewport = None,
        ],
    );
}

#[test]
fn a_target_that_changes_its_size_shows_the_reflection_in_it() {
    let scene = room("resized");
    let mut live = Live::new(&scene);
    live.settled();
    for (step, size) in [(48, 36), (133, 71), (7, 90), (96, 72)]
        .into_iter()
        .enumerate()
    {
        live.size = size.into();
        let extent = Extent3d {
            width: size.0,
            height: size.1,
            ..default()
        };
        let target = live.target.clone();
        let mut images = live.world().resource_mut::<Assets<Image>>();
        images.get_mut(&target).expect("it is there").resize(extent);
        // The engine itself tells its cameras of a new size a frame later.
        live.stage.frame();
        let picture = live.next();
        let mut expected = scene.clone();
        expected.size = live.size;
        let expected = Live::new(&expected).settled();
        picture.assert_same(&expected, &format!("resized-{step}"));
    }
}

#[test]
fn a_camera_that_changes_its_target_takes_the_reflection_along() {
    let scene = room("other-target");
    let mut live = Live::new(&scene);
    live.settled();
    live.size = UVec2::new(60, 60);
    live.target = live.stage.target(live.size);
    let target = bevy::camera::RenderTarget::from(live.target.clone());
    insert(live.world(), "camera", target);
    // Bevy itself looks at a camera's target only when something else of it changes too.
    of::<Projection>(live.world(), "camera").set_changed();
    let mut expected = scene.clone();
    expected.size = live.size;
    let picture = live.next();
    picture.assert_same(&Live::new(&expected).settled(), "other-target");
}

#[test]
fn shadows_are_switched_on_and_off_in_the_reflection_too() {
    let shadows = |on| {
        move |world: &mut World| {
            of::<DirectionalLight>(world, "sun").shadow_maps_enabled = on;
        }
    };
    assert_each_seen_at_once(
        &sunny_room("shadows"),
        &[&shadows(false), &shadows(true), &shadows(false)],
    );
}

#[test]
fn a_light_that_moves_moves_its_shadows_in_the_reflection_too() {
    let shine = |from: Vec3| {
        let light = Transform::from_translation(from).looking_at(Vec3::ZERO, Vec3::Y);
        move |world: &mut World| place(world, "sun", light)
    };
    assert_each_seen_at_once(
        &sunny_room("moving-light"),
        &[
            &shine(vec3(-1.0, 3.0, 1.0)),
            &shine(vec3(0.2, 2.0, 2.0)),
            &|world| despawn(world, "sun"),
        ],
    );
}

#[test]
fn a_skybox_comes_and_goes_in_the_reflection_too() {
    let sky = |world: &mut World| {
        let image = add(world, six_colors());
        let skybox = Skybox {
            image: Some(image),
            brightness: 600.0,
            ..default()
        };
        insert(world, "camera", skybox);
    };
    assert_each_seen_at_once(
        &room("skybox"),
        &[
            &sky,
            &|world| of::<Skybox>(world, "camera").rotation = Quat::from_rotation_y(1.0),
            &|world| remove::<Skybox>(world, "camera"),
        ],
    );
}

#[test]
fn the_clear_color_changes_in_the_reflection_too() {
    assert_each_seen_at_once(
        &room("clear-color"),
        &[
            &|world| world.resource_mut::<ClearColor>().0 = MAGENTA,
            &|world| of::<Camera>(world, "camera").clear_color = YELLOW.into(),
        ],
    );
}

#[test]
fn mirrors_come_and_go() {
    const NAMES: [&str; 4] = ["first", "second", "third", "fourth"];
    fn hang(index: usize) -> impl Fn(&mut World) {
        move |world| {
            let mesh = add(world, Rectangle::new(0.6, 0.8).into());
            let x = index as f32 * 0.7 - 1.0;
            let turn = Quat::from_rotation_y(0.3 - 0.2 * index as f32);
            world.spawn((
                Name::new(NAMES[index]),
                Mesh3d(mesh),
                at(x, 0.1, 0.3).with_rotation(turn),
                PlanarMirror::default(),
            ));
        }
    }
    let take = |index: usize| move |world: &mut World| despawn(world, NAMES[index]);
    assert_each_seen_at_once(
        &room("count"),
        &[
            &hang(0),
            &hang(1),
            &|world| (2..4).for_each(|index| hang(index)(world)),
            &take(1),
            &|world| despawn(world, "mirror"),
            &|world| {
                take(0)(world);
                hang(1)(world);
            },
            &|world| (1..4).for_each(|index| take(index)(world)),
            &hang(2),
        ],
    );
}

#[test]
fn an_object_that_passes_through_the_plane_is_cut_right_in_every_frame() {
    let steps: Vec<_> = (0..12)
        .map(|step| {
            // From well before to well behind, and through the touch on both sides.
            let z = 0.36 - 0.06 * step as f32;
            move |world: &mut World| place(world, "ball", at(0.3, 0.4, z))
        })
        .collect();
    let changes: Vec<Change> = steps.iter().map(|change| change as Change).collect();
    assert_each_seen_at_once(&room("through"), &changes);
}

#[test]
fn clips_are_switched_at_run_time() {
    let clip = |clip| move |world: &mut World| of::<PlanarMirror>(world, "mirror").clip = clip;
    assert_each_seen_at_once(
        &room("clips"),
        &[
            &|world| place(world, "ball", at(0.4, 0.4, -0.15)),
            &clip(MirrorClip::Whole),
            &clip(MirrorClip::Oblique),
        ],
    );
}

#[test]
fn a_projection_may_change_its_kind() {
    fn project(projection: impl Into<Projection> + Clone) -> impl Fn(&mut World) {
        move |world| *of::<Projection>(world, "camera") = projection.clone().into()
    }
    let flat = OrthographicProjection {
        scaling_mode: ScalingMode::FixedVertical {
            viewport_height: 2.5,
        },
        ..OrthographicProjection::default_3d()
    };
    let fov = |degrees: f32| PerspectiveProjection {
        fov: degrees.to_radians(),
        ..default()
    };
    assert_each_seen_at_once(
        &room("projections"),
        &[
            &project(flat.clone()),
            &project(fov(80.0)),
            &project(fov(20.0)),
            &project(flat),
        ],
    );
}

#[test]
fn a_camera_that_jumps_a_million_units_and_back_sees_what_is_there() {
    let jump = |world: &mut World| of::<Transform>(world, "camera").translation += Vec3::splat(1e6);
    let back =
        |world: &mut World| of::<Transform>(world, "camera").translation = vec3(0.5, 0.8, 3.0);
    assert_each_seen_at_once(&room("jump"), &[&jump, &back]);
}

#[test]
fn a_mirror_that_jumps_a_million_units_and_back_shows_what_is_there() {
    let jump = |world: &mut World| place(world, "mirror", at(0.0, 1e6, -1e6));
    let back = |world: &mut World| place(world, "mirror", at(0.0, 0.2, 0.0));
    assert_each_seen_at_once(&room("mirror-jump"), &[&jump, &back]);
}

/// At a million units single precision leaves a sixteenth of a unit: coarse, but the same in every frame.
#[test]
fn a_world_that_jumps_a_million_units_and_back_is_whole_in_every_frame() {
    fn shift(by: f32) -> impl Fn(&mut World) {
        move |world| {
            let mut roots = world.query_filtered::<&mut Transform, Without<ChildOf>>();
            for mut transform in roots.iter_mut(world) {
                transform.translation.x += by;
            }
        }
    }
    let scene = room("world-jump");
    let mut live = Live::new(&scene);
    live.settled();
    shift(1e6)(live.world());
    let mut fresh = Live::new(&scene);
    shift(1e6)(fresh.world());
    live.next()
        .assert_same(&fresh.settled(), "world-jump-there");
    shift(-1e6)(live.world());
    let mut fresh = fresh.again(&scene);
    shift(1e6)(fresh.world());
    shift(-1e6)(fresh.world());
    live.next().assert_same(&fresh.settled(), "world-jump-back");
}

/// Until everything is there a pixel may show nothing yet, but never something else.
#[test]
fn the_first_frames_show_the_reflection_or_nothing() {
    let mut scene = room("first-frames");
    scene.objects[3].look = named("block", MAGENTA);
    let mut live = Live::new(&scene);
    let first: Vec<_> = (0..6)
        .filter_map(|_| {
            live.stage.frame();
            live.stage.read(&live.target, live.size).ok()
        })
        .collect();
    let whole = live.settled();
    let plain = Live::plain(Stage::with_mirrors(), &scene).settled();
    let background = scene.clear_color.to_srgba().to_u8_array();
    assert_ne!(whole, plain, "the mirror does not show at all");
    for (frame, picture) in first.iter().enumerate() {
        let wrong = picture.places().find(|place| {
            let of = |picture: &crate::support::picture::Picture| picture.at(place.x, place.y);
            let shown = of(picture);
            // A target that was never drawn into is empty.
            shown != of(&whole) && shown != of(&plain) && shown != background && shown != [0; 4]
        });
        assert_eq!(
            wrong,
            None,
            "frame {frame} shows what is in no picture: {}",
            picture.save("first-frame")
        );
    }
}

/// What culling on the CPU leaves out of account may be on both sides of the plane.
#[test]
fn an_object_without_bounds_is_cut_at_the_plane_when_it_crosses() {
    assert_each_seen_at_once(
        &room("no-bounds"),
        &[
            &|world| {
                insert(world, "ball", NoFrustumCulling);
                place(world, "ball", at(0.2, 0.4, 0.1));
            },
            &|world| place(world, "ball", at(0.2, 0.4, -0.1)),
        ],
    );
}

/// A look that is none, so that the mirror can be found by its name alone.
#[test]
fn a_named_mirror_reflects_as_any_other() {
    let mut bare = room("named");
    let named = Live::new(&bare).settled();
    bare.mirrors[0].look = None::<Look>;
    named.assert_same(&Live::new(&bare).settled(), "named");
}
