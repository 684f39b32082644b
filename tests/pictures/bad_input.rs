//! Bad input: the mirror says why it is not drawn, the log says it once, and everything else is drawn as if it were no
//! mirror. When the input is mended the mirror is back.

use bevy::{
    asset::RenderAssetUsages,
    camera::{CameraProjection, RenderTarget, Viewport},
    mesh::{Indices, PrimitiveTopology, VertexAttributeValues},
    prelude::*,
    render::{
        render_resource::{PipelineCache, PipelineDescriptor, TextureFormat},
        settings::{WgpuFeatures, WgpuSettings},
    },
};
use bevy_planar_mirror::{
    MirrorPlane, MirrorState, MirrorStatus, NotDrawn, PlanarMirror, PlanarMirrorPlugin,
};

use super::changes::room;
use crate::support::{
    live::{Live, find, of},
    mask::Mask,
    picture::Picture,
    props::{BLUE, GREEN, RED, at, glass},
    scene::{Scene, Surface},
    stage::Stage,
    studio::Studio,
};

/// The room, whose mirror has a material too: spoiled as a mirror it is still a pane.
fn glazed(name: &str) -> Scene {
    let mut scene = room(name);
    scene.mirrors[0].look = Some(crate::support::live::named("mirror", glass(BLUE, 0.4)));
    scene
}

fn state(live: &mut Live) -> Option<MirrorState> {
    let camera = live.camera;
    of::<MirrorStatus>(live.world(), "mirror").of(camera)
}

fn lines(live: &Live) -> Vec<String> {
    live.stage
        .warnings()
        .filter(|line| line.target.starts_with("bevy_planar_mirror"))
        .map(|line| line.text.clone())
        .collect()
}

/// Spoiled from the first frame on, mended, and spoiled again while it runs.
#[track_caller]
fn assert_refused(
    scene: &Scene,
    reason: NotDrawn,
    spoil: impl Fn(&mut World),
    mend: impl Fn(&mut World),
) {
    let name = &scene.name;
    let mut plain = Live::plain(Stage::stock(), scene);
    spoil(plain.world());
    let plain = plain.settled();
    let good = Studio::default().picture(scene);

    let mut live = Live::new(scene);
    spoil(live.world());
    live.settled()
        .assert_same(&plain, &format!("{name}-spoiled"));
    let not_drawn = Some(MirrorState::NotDrawn(reason));
    assert_eq!(state(&mut live), not_drawn, "{name}");

    mend(live.world());
    live.next().assert_same(&good, &format!("{name}-mended"));
    assert!(matches!(state(&mut live), Some(MirrorState::Drawn(_))));

    spoil(live.world());
    live.next()
        .assert_same(&plain, &format!("{name}-spoiled-again"));
    assert_eq!(state(&mut live), not_drawn, "{name}, the second time");
    for _ in 0..3 {
        live.next();
    }
    let lines = lines(&live);
    assert!(lines.len() <= 1, "{name}: {lines:#?}");
    mend(live.world());
    live.next()
        .assert_same(&good, &format!("{name}-mended-again"));
}

mod mirrors {
    use super::*;

    const GOOD: Transform = Transform::from_xyz(0.0, 0.2, 0.0);

    #[track_caller]
    fn assert_transform_refused(name: &str, bad: Transform) {
        let place = |transform| {
            move |world: &mut World| {
                *of::<Transform>(world, "mirror") = transform;
            }
        };
        assert_refused(
            &glazed(name),
            NotDrawn::DegenerateTransform,
            place(bad),
            place(GOOD),
        );
    }

    #[test]
    fn a_mirror_at_no_place_is_refused() {
        assert_transform_refused("nan", Transform::from_translation(Vec3::NAN));
    }

    #[test]
    fn a_mirror_at_infinity_is_refused() {
        assert_transform_refused("infinite", Transform::from_xyz(f32::INFINITY, 0.0, 0.0));
    }

    #[test]
    fn a_mirror_of_no_size_is_refused() {
        assert_transform_refused("zero", GOOD.with_scale(Vec3::ZERO));
        assert_transform_refused("flattened", GOOD.with_scale(vec3(1.0, 0.0, 1.0)));
    }

    #[test]
    fn a_mirror_that_turns_no_way_is_refused() {
        assert_transform_refused(
            "nan-rotation",
            GOOD.with_rotation(Quat::from_xyzw(f32::NAN, 0.0, 0.0, 1.0)),
        );
    }

    /// Flattened along its own normal it is as flat as before.
    #[test]
    fn a_mirror_flattened_across_its_plane_is_a_mirror() {
        let good = Studio::default().picture(&glazed("flat"));
        let mut flat = glazed("flat");
        flat.mirrors[0].transform.scale.z = 0.0;
        let picture = Studio::default().picture(&flat);
        let mask = Studio::default().mask(&glazed("flat"), 0);
        picture.assert_alike(&good, 2, 0.9999, |place| mask.inside(place), "flat");
    }

    #[test]
    fn a_plane_without_a_direction_is_refused() {
        for (name, normal) in [("no-normal", Vec3::ZERO), ("nan-normal", Vec3::NAN)] {
            let plane = MirrorPlane::Local {
                point: Vec3::ZERO,
                normal,
            };
            let set = |plane| {
                move |world: &mut World| {
                    of::<PlanarMirror>(world, "mirror").plane = plane;
                }
            };
            assert_refused(
                &glazed(name),
                NotDrawn::DegenerateTransform,
                set(plane),
                set(MirrorPlane::FromMesh),
            );
        }
    }

    #[test]
    fn a_mirror_without_a_mesh_is_refused() {
        let take = |world: &mut World| {
            let mirror = find(world, "mirror");
            world.entity_mut(mirror).remove::<Mesh3d>();
        };
        let give = |world: &mut World| {
            let mesh = Mesh::from(Rectangle::new(3.0, 2.0));
            let mesh = world.resource_mut::<Assets<Mesh>>().add(mesh);
            let mirror = find(world, "mirror");
            world.entity_mut(mirror).insert(Mesh3d(mesh));
        };
        assert_refused(&room("no-mesh"), NotDrawn::NoMesh, take, give);
    }
}

mod meshes {
    use super::*;

    #[track_caller]
    fn assert_mesh_refused(scene: &Scene, reason: NotDrawn, mesh: impl Fn() -> Mesh) {
        fn wear(world: &mut World, mesh: Mesh) {
            let mesh = world.resource_mut::<Assets<Mesh>>().add(mesh);
            let mirror = find(world, "mirror");
            world.entity_mut(mirror).insert(Mesh3d(mesh));
        }
        assert_refused(
            scene,
            reason,
            |world| wear(world, mesh()),
            |world| wear(world, Rectangle::new(3.0, 2.0).into()),
        );
    }

    fn mesh(topology: PrimitiveTopology) -> Mesh {
        Mesh::new(topology, RenderAssetUsages::default())
    }

    fn rectangle() -> Mesh {
        Rectangle::new(3.0, 2.0).into()
    }

    #[test]
    fn a_mesh_without_vertices_is_refused() {
        assert_mesh_refused(&room("no-vertices"), NotDrawn::MeshEmpty, || {
            mesh(PrimitiveTopology::TriangleList)
                .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, Vec::<[f32; 3]>::new())
        });
    }

    #[test]
    fn a_mesh_without_positions_is_refused() {
        assert_mesh_refused(&room("no-positions"), NotDrawn::MeshEmpty, || {
            mesh(PrimitiveTopology::TriangleList)
                .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0, 0.0, 1.0]; 3])
        });
    }

    #[test]
    fn a_mesh_of_one_point_is_refused() {
        assert_mesh_refused(&glazed("one-point"), NotDrawn::MeshEmpty, || {
            rectangle().scaled_by(Vec3::ZERO)
        });
    }

    #[test]
    fn a_mesh_that_is_not_flat_is_refused() {
        assert_mesh_refused(&glazed("not-flat"), NotDrawn::MeshNotFlat, || {
            Cuboid::new(2.0, 1.0, 0.5).into()
        });
    }

    #[test]
    fn a_mesh_of_lines_is_refused() {
        assert_mesh_refused(&room("lines"), NotDrawn::MeshNotReadable, || {
            let corners = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
            mesh(PrimitiveTopology::LineStrip)
                .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, corners)
        });
    }

    #[test]
    fn a_mesh_with_a_corner_nowhere_is_refused() {
        for bad in [f32::NAN, f32::INFINITY] {
            assert_mesh_refused(&room("nowhere"), NotDrawn::MeshNotReadable, || {
                let mut mesh = rectangle();
                let positions = mesh.attribute_mut(Mesh::ATTRIBUTE_POSITION);
                if let Some(VertexAttributeValues::Float32x3(positions)) = positions {
                    positions[0][1] = bad;
                }
                mesh
            });
        }
    }

    #[test]
    fn a_mesh_whose_triangles_have_no_corners_is_refused() {
        assert_mesh_refused(&room("indices"), NotDrawn::MeshNotReadable, || {
            let mut mesh = rectangle();
            mesh.insert_indices(Indices::U32(vec![0, 1, 2, 0, 2, 99]));
            mesh
        });
    }

    /// Whether it was seen in the main world for one frame or not.
    #[test]
    fn a_mesh_that_only_the_gpu_has_is_refused() {
        assert_mesh_refused(&glazed("gpu-only"), NotDrawn::MeshNotInMainWorld, || {
            let mut mesh = rectangle();
            mesh.asset_usage = RenderAssetUsages::RENDER_WORLD;
            mesh
        });
    }

    /// The same mesh with its plane given.
    #[test]
    fn a_mesh_that_only_the_gpu_has_reflects_where_its_plane_is_given() {
        let good = Studio::default().picture(&glazed("gpu-only-plane"));
        let mut scene = glazed("gpu-only-plane");
        scene.mirrors[0].mesh.asset_usage = RenderAssetUsages::RENDER_WORLD;
        scene.mirrors[0].mirror.plane = MirrorPlane::Local {
            point: Vec3::ZERO,
            normal: Vec3::Z,
        };
        let picture = Studio::default().picture(&scene);
        picture.assert_same(&good, "gpu-only-plane");
    }

    /// What is reflected may be bad as well.
    #[test]
    fn objects_that_are_nowhere_do_not_harm_the_reflection() {
        let mut scene = room("nowhere-objects");
        let good = {
            let mut without = scene.clone();
            without.objects.truncate(3);
            Studio::default().picture(&without)
        };
        scene.objects[3].transform = Transform::from_translation(Vec3::NAN);
        scene = scene
            .object(
                Cuboid::default(),
                RED,
                Transform::from_xyz(f32::INFINITY, 0.0, 0.0),
            )
            .object(
                Cuboid::default(),
                GREEN,
                at(0.2, 0.3, 0.5).with_scale(Vec3::ZERO),
            );
        let picture = Studio::default().picture(&scene);
        picture.assert_same(&good, "nowhere-objects");
    }
}

mod cameras {
    use super::*;

    fn eye() -> Transform {
        room("eye").eye
    }

    #[test]
    fn a_camera_that_stands_nowhere_sees_no_mirror() {
        for (name, bad) in [
            ("nan-eye", eye().with_translation(Vec3::NAN)),
            ("flat-eye", eye().with_scale(vec3(1.0, 1.0, 0.0))),
        ] {
            let place = |transform| {
                move |world: &mut World| {
                    *of::<Transform>(world, "camera") = transform;
                }
            };
            assert_refused(
                &glazed(name),
                NotDrawn::DegenerateCamera,
                place(bad),
                place(eye()),
            );
        }
    }

    #[test]
    fn a_camera_with_a_projection_that_is_none_sees_no_mirror() {
        let good = PerspectiveProjection::default();
        let bad = [
            (
                "no-fov",
                PerspectiveProjection {
                    fov: 0.0,
                    ..good.clone()
                },
            ),
            (
                "nan-fov",
                PerspectiveProjection {
                    fov: f32::NAN,
                    ..good.clone()
                },
            ),
            (
                "no-near",
                PerspectiveProjection {
                    near: 0.0,
                    ..good.clone()
                },
            ),
        ];
        for (name, bad) in bad {
            let look = |projection: &PerspectiveProjection| {
                let projection = projection.clone();
                move |world: &mut World| {
                    *of::<Projection>(world, "camera") = projection.clone().into();
                }
            };
            assert_refused(
                &glazed(name),
                NotDrawn::DegenerateCamera,
                look(&bad),
                look(&good),
            );
        }
    }

    /// A projection of the user's own, for which nothing is sure.
    #[derive(Clone, Debug)]
    struct Nothing;

    impl CameraProjection for Nothing {
        fn get_clip_from_view(&self) -> Mat4 {
            Mat4::ZERO
        }
        fn get_clip_from_view_for_sub(&self, _: &bevy::camera::SubCameraView) -> Mat4 {
            Mat4::ZERO
        }
        fn update(&mut self, _: f32, _: f32) {}
        fn far(&self) -> f32 {
            1000.0
        }
        fn get_frustum_corners(&self, _: f32, _: f32) -> [Vec3A; 8] {
            [Vec3A::ZERO; 8]
        }
    }

    #[test]
    fn a_camera_with_a_projection_of_zeros_sees_no_mirror() {
        assert_refused(
            &glazed("zeros"),
            NotDrawn::DegenerateCamera,
            |world| *of::<Projection>(world, "camera") = Projection::custom(Nothing),
            |world| *of::<Projection>(world, "camera") = PerspectiveProjection::default().into(),
        );
    }

    /// Nothing is nearer than such a camera looks: it sees nothing, and no mirror.
    #[test]
    fn a_camera_that_looks_less_far_than_near_sees_nothing() {
        let scene = glazed("far-before-near");
        let look = |world: &mut World| {
            let projection = PerspectiveProjection {
                near: 0.1,
                far: 0.01,
                ..default()
            };
            *of::<Projection>(world, "camera") = projection.into();
        };
        let mut plain = Live::plain(Stage::stock(), &scene);
        look(plain.world());
        let mut live = Live::new(&scene);
        look(live.world());
        live.settled().assert_same(&plain.settled(), &scene.name);
        assert!(matches!(state(&mut live), Some(MirrorState::NotDrawn(_))));
    }

    /// A second camera without a target is no matter of the first one's.
    fn assert_target_refused(name: &str, target: impl Fn(&mut Live) -> RenderTarget) {
        let scene = glazed(name);
        let good = Studio::default().picture(&scene);
        let mut live = Live::new(&scene);
        let target = target(&mut live);
        let eye = scene.eye;
        let blind = live.world().spawn((scene.camera_bundle(), target, eye));
        let blind = blind.id();
        live.settled().assert_same(&good, name);
        let status = of::<MirrorStatus>(live.world(), "mirror").of(blind);
        assert_eq!(status, Some(MirrorState::NotDrawn(NotDrawn::NoTarget)));
        assert_eq!(lines(&live), [""; 0]);
    }

    #[test]
    fn a_camera_of_a_window_that_is_not_there_sees_no_mirror() {
        assert_target_refused("no-window", |_| RenderTarget::default());
    }

    #[test]
    fn a_camera_of_a_window_without_pixels_sees_no_mirror() {
        assert_target_refused("no-pixels", |live| {
            let window = Window {
                resolution: UVec2::ZERO.into(),
                ..default()
            };
            let window = live.world().spawn(window).id();
            RenderTarget::Window(bevy::window::WindowRef::Entity(window))
        });
    }

    #[test]
    fn a_camera_of_no_pixels_sees_no_mirror() {
        assert_target_refused("no-size", |_| RenderTarget::None { size: UVec2::ZERO });
    }

    #[test]
    fn a_viewport_without_pixels_sees_no_mirror() {
        let scene = glazed("no-viewport");
        let mut live = Live::new(&scene);
        let good = live.settled();
        let narrow = |world: &mut World, size: UVec2| {
            of::<Camera>(world, "camera").viewport = Some(Viewport {
                physical_size: size,
                ..default()
            });
        };
        narrow(live.world(), UVec2::new(40, 0));
        for _ in 0..3 {
            // Whether the engine draws with it is its own business.
            live.stage.try_frame(App::update).ok();
        }
        let not_drawn = MirrorState::NotDrawn(NotDrawn::NoTarget);
        assert_eq!(state(&mut live), Some(not_drawn));
        drop(good);
    }

    /// The image is taken from under a camera that draws into it.
    #[test]
    fn a_target_that_goes_harms_no_other_camera() {
        let scene = glazed("gone-target");
        let mut live = Live::new(&scene);
        let other = live.stage.target(scene.size);
        let eye = scene.eye;
        let target = RenderTarget::from(other.clone());
        live.world().spawn((scene.camera_bundle(), target, eye));
        let good = live.settled();
        live.world().resource_mut::<Assets<Image>>().remove(&other);
        drop(other);
        for _ in 0..4 {
            live.next().assert_same(&good, "gone-target");
        }
    }
}

/// Of all pipelines asked for so far.
fn depth_formats(live: &mut Live) -> Vec<TextureFormat> {
    let cache = live.stage.render_world().resource::<PipelineCache>();
    cache
        .pipelines()
        .filter_map(|pipeline| match &pipeline.descriptor {
            PipelineDescriptor::RenderPipelineDescriptor(it) => it.depth_stencil.as_ref(),
            PipelineDescriptor::ComputePipelineDescriptor(_) => None,
        })
        .map(|depth_stencil| depth_stencil.format)
        .collect()
}

/// The picture of a scene on a device without the depth-stencil format that is liked best.
#[test]
fn without_the_preferred_format_the_other_one_serves() {
    let scene = room("other-format").object(
        Cuboid::from_length(0.5),
        RED,
        at(0.7, 0.0, 0.05).with_rotation(Quat::from_rotation_y(0.4)),
    );
    let mut settings = WgpuSettings::default();
    settings.disabled_features = Some(WgpuFeatures::DEPTH32FLOAT_STENCIL8);
    let stage = Stage::with_wgpu(settings, |app| {
        app.add_plugins(PlanarMirrorPlugin::default());
    });
    let mut live = Live::on(stage, &scene);
    let picture = live.settled();
    let formats = depth_formats(&mut live);
    assert!(formats.contains(&TextureFormat::Depth24PlusStencil8));
    assert!(!formats.contains(&TextureFormat::Depth32FloatStencil8));
    drop(live);
    let mut studio = Studio::default();
    let mask: Mask = studio.mask(&scene, 0);
    let reference: Picture = studio.reference(&scene, 0);
    picture.assert_alike(
        &reference,
        2,
        0.9999,
        |place| mask.inside(place),
        "other-format",
    );
    studio.assert_untouched_outside(&scene, &picture);
}

/// Small mirrors in rows, each a little farther from the eye than the one before.
fn wall_of_mirrors(count: usize, of_which_mirrors: usize) -> Scene {
    const ROW: usize = 20;
    let mut scene = Scene::new(&format!("wall-{count}-{of_which_mirrors}"))
        .eye(vec3(0.0, 0.0, 6.0), Vec3::ZERO)
        .fov(60.0)
        .object(Sphere::new(1.2).mesh().uv(24, 16), RED, at(0.6, 0.4, 7.5))
        .object(Cuboid::from_length(1.5), GREEN, at(-1.8, -0.8, 8.0));
    for index in 0..count {
        let (column, row) = ((index % ROW) as f32, (index / ROW) as f32);
        let place = vec3(column * 0.4 - 3.8, row * 0.4 - 2.8, -0.01 * index as f32);
        let pane = Surface::wall(0.35, 0.35, Transform::from_translation(place));
        let pane = pane.look(glass(BLUE, 0.3));
        if index < of_which_mirrors {
            scene = scene.mirror(pane);
        } else {
            scene = scene.object(pane.mesh.clone(), glass(BLUE, 0.3), pane.transform);
        }
    }
    scene
}

#[test]
fn of_more_mirrors_than_ids_the_nearest_are_drawn() {
    let mut live = Live::new(&wall_of_mirrors(300, 300));
    let picture = live.settled();
    let camera = live.camera;
    let world = live.world();
    let mut mirrors = world.query::<(&GlobalTransform, &MirrorStatus)>();
    let eye = vec3(0.0, 0.0, 6.0);
    let (mut nearest_left_out, mut farthest_drawn) = (f32::MAX, 0.0_f32);
    let mut left_out = 0;
    for (transform, status) in mirrors.iter(world) {
        let distance = transform.translation().distance(eye);
        match status.of(camera) {
            Some(MirrorState::Drawn(_)) => farthest_drawn = farthest_drawn.max(distance),
            Some(MirrorState::NotDrawn(NotDrawn::TooManyMirrors)) => {
                left_out += 1;
                nearest_left_out = nearest_left_out.min(distance);
            }
            other => panic!("{other:?}"),
        }
    }
    assert_eq!(left_out, 45);
    assert!(farthest_drawn <= nearest_left_out);
    let lines = lines(&live);
    assert_eq!(lines.len(), 1, "{lines:#?}");
    // Those left out look as if they were none.
    let drawn: Vec<Vec3> = {
        let world = live.world();
        let mut mirrors = world.query::<(&GlobalTransform, &MirrorStatus)>();
        let drawn = mirrors.iter(world).filter(|(_, status)| status.is_drawn());
        drawn
            .map(|(transform, _)| transform.translation())
            .collect()
    };
    let mut fewer = wall_of_mirrors(300, 300);
    let (mirrors, panes): (Vec<_>, Vec<_>) = std::mem::take(&mut fewer.mirrors)
        .into_iter()
        .partition(|mirror| drawn.contains(&mirror.transform.translation));
    assert_eq!(mirrors.len(), 255);
    fewer.mirrors = mirrors;
    for pane in panes {
        fewer = fewer.object(pane.mesh, glass(BLUE, 0.3), pane.transform);
    }
    let fewer = live.again(&fewer).settled();
    picture.assert_same(&fewer, "of-300");
    picture.assert_shows_something();
}
