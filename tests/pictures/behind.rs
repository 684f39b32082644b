//! What a camera's prepass has of the things behind a mirror: nothing is left of them where the mirror
//! shows, so no effect takes them for what is seen there.

use bevy::{
    asset::uuid_handle,
    core_pipeline::{
        oit::OrderIndependentTransparencySettings,
        prepass::{DepthPrepass, MotionVectorPrepass, NormalPrepass},
    },
    post_process::motion_blur::MotionBlur,
    prelude::*,
    render::render_resource::AsBindGroup,
    shader::ShaderRef,
};
use bevy_planar_mirror::PlanarMirrorPlugin;

use super::changes::room;
use crate::support::{
    live::{Live, named, of},
    picture::Picture,
    props::{BLUE, GREEN, MAGENTA, RED, YELLOW, at, glass},
    scene::{Look, Scene, Surface},
    stage::Stage,
    studio::Studio,
};

/// A picture after so many frames in which `step` moved things.
fn after(frames: u32, scene: &Scene, step: impl Fn(&mut World, u32)) -> Picture {
    let mut live = Live::new(scene);
    live.settled();
    for frame in 0..frames {
        step(live.world(), frame);
        live.stage.frame();
    }
    let picture = live.stage.read(&live.target, live.size);
    picture.unwrap_or_else(|reason| panic!("{reason}"))
}

fn blurred(name: &str) -> Scene {
    let mut scene = room(name).with_camera(MotionBlur {
        shutter_angle: 2.0,
        samples: 8,
    });
    scene.objects.pop();
    scene
}

fn swing(world: &mut World, name: &str, frame: u32) {
    of::<Transform>(world, name).translation.x = 0.9 * (0.9 * frame as f32).sin();
}

#[test]
fn what_moves_behind_a_mirror_does_not_blur_the_reflection() {
    for msaa in [Msaa::Off, Msaa::Sample4] {
        let mut still = blurred("motion-behind");
        still.msaa = msaa;
        let expected = after(8, &still, |_, _| {});
        let runner = named("runner", MAGENTA);
        let moving = still.object(Rectangle::new(1.5, 1.5), runner, at(0.0, 0.2, -1.0));
        let picture = after(8, &moving, |world, frame| swing(world, "runner", frame));
        let mask = Studio::default().mask(&room("motion-mask"), 0);
        picture.assert_alike(
            &expected,
            0,
            1.0,
            |place| mask.inside(place),
            &format!("motion-behind-{msaa:?}"),
        );
    }
}

/// It is blurred as a mesh in its place would be.
#[test]
fn a_mirror_that_moves_is_blurred_as_any_mesh() {
    let moved = |mirror: bool| {
        let mut scene = blurred("moving-mirror");
        // Flat colors in the mirror and on the mesh: what is blurred is the edge.
        scene.objects.clear();
        if !mirror {
            scene.mirrors[0].look = Some(named("mirror", scene.clear_color));
        }
        let scene = scene.object(Cuboid::new(8.0, 6.0, 0.1), BLUE, at(0.0, 0.0, -1.0));
        let slide = |world: &mut World, frame: u32| {
            of::<Transform>(world, "mirror").translation.x = 0.12 * frame as f32;
        };
        if mirror {
            after(6, &scene, slide)
        } else {
            let mut live = Live::plain(Stage::stock(), &scene);
            live.settled();
            for frame in 0..6 {
                slide(live.world(), frame);
                live.stage.frame();
            }
            live.stage
                .read(&live.target, live.size)
                .unwrap_or_else(|reason| panic!("{reason}"))
        }
    };
    // The blur has noise in it, which changes from frame to frame.
    let [mirror, mesh] = [moved(true), moved(false)];
    mirror.assert_alike(&mesh, 32, 0.999, |_| true, "moving-mirror");
    // Between blue and the clear color there is nothing but blur.
    let between = |pixel: [u8; 4]| (60..230).contains(&pixel[2]);
    assert!(mirror.count(between) > 100, "{}", mirror.count(between));
}

const SHADER: Handle<Shader> = uuid_handle!("0f7c1a55-5c3e-4d0f-8a6e-2a9f6f1f4b11");

/// Shows what the camera's prepass has left, over the whole picture.
#[derive(Asset, TypePath, AsBindGroup, Clone, Default)]
struct ShowPrepass {}

impl Material for ShowPrepass {
    fn fragment_shader() -> ShaderRef {
        SHADER.into()
    }

    fn alpha_mode(&self) -> AlphaMode {
        AlphaMode::Blend
    }
}

fn add_show_prepass(app: &mut App) {
    app.add_plugins(MaterialPlugin::<ShowPrepass>::default());
    let mut shaders = app.world_mut().resource_mut::<Assets<Shader>>();
    let code = "
        #import bevy_pbr::{forward_io::VertexOutput, prepass_utils}
        @fragment
        fn fragment(in: VertexOutput) -> @location(0) vec4<f32> {
        #ifdef DEPTH_PREPASS
            let depth = prepass_utils::prepass_depth(in.position, 0u);
            let normal = prepass_utils::prepass_normal(in.position, 0u);
            let motion = prepass_utils::prepass_motion_vector(in.position, 0u);
            return vec4(depth * 15.0, normal.x * 0.4 + normal.z * 0.1 + 0.5, motion.x * 8.0 + 0.5, 1.0);
        #else
            return vec4(0.0);
        #endif
        }";
    let shader = Shader::from_wgsl(code, "show_prepass.wgsl");
    shaders.insert(SHADER.id(), shader).expect("the id is free");
}

/// What the prepass leaves, where the mirror shows, is what it would leave of an opaque mesh.
#[test]
fn depth_normals_and_motion_are_those_of_the_mirrors_surface() {
    let pane = Look::other(|entity| {
        let pane = entity.world_scope(|world| {
            let mut materials = world.resource_mut::<Assets<ShowPrepass>>();
            materials.add(ShowPrepass {})
        });
        entity.insert(MeshMaterial3d(pane));
    });
    for msaa in [Msaa::Off, Msaa::Sample4] {
        let mut scene = room("prepass")
            .with_camera((DepthPrepass, NormalPrepass, MotionVectorPrepass))
            .object(Rectangle::new(9.0, 9.0), pane.clone(), at(0.45, 0.72, 2.7))
            .plugin(add_show_prepass);
        scene.msaa = msaa;
        let mut opaque = scene.clone();
        opaque.mirrors[0].look = Some(named("mirror", RED));
        // Both move in the last frame.
        let draw = |stage: fn(&Scene) -> Live, scene: &Scene| {
            let mut live = stage(scene);
            live.settled();
            of::<Transform>(live.world(), "mirror").translation.x += 0.05;
            of::<Transform>(live.world(), "camera").translation.x += 0.02;
            live.stage.frame();
            let picture = live.stage.read(&live.target, live.size);
            picture.unwrap_or_else(|reason| panic!("{reason}"))
        };
        let stock = |scene: &Scene| Live::plain(Stage::as_games_run(add_show_prepass), scene);
        let expected = draw(stock, &opaque);
        let hidden = draw(stock, &scene);
        let got = draw(
            |scene| {
                let stage = Stage::as_games_run(|app| {
                    add_show_prepass(app);
                    app.add_plugins(PlanarMirrorPlugin::default());
                });
                Live::on(stage, scene)
            },
            &scene,
        );
        let mut bare = room("prepass-mask");
        bare.objects
            .retain(|object| object.transform.translation.z < 0.0);
        let mask = Studio::default().mask(&bare, 0);
        let inside = |place| mask.inside(place);
        let what = format!("prepass-{msaa:?}");
        got.assert_alike(&expected, 1, 0.99, inside, &what);
        let seen = hidden.difference(&expected, 8, inside).expect("one size");
        assert!(seen.beyond > 100, "nothing is behind the mirror: {seen}");
    }
}

/// With order independent transparency what blends is sorted by a buffer of its own, which knows the
/// depth of the prepass alone.
#[test]
fn glass_before_and_behind_a_mirror_is_as_ever_with_order_independent_transparency() {
    let scene = |name: &str| {
        let mut scene = Scene::new(name)
            .eye(vec3(0.5, 0.8, 3.0), vec3(0.0, 0.1, 0.0))
            .mirror(Surface::wall(2.0, 1.4, at(0.0, 0.2, 0.0)))
            .object(Cuboid::from_length(0.4), RED, at(-0.5, 0.1, 0.8))
            .object(Cuboid::new(8.0, 6.0, 0.1), BLUE, at(0.0, 0.0, 5.0))
            .object(
                Rectangle::new(0.6, 0.5),
                glass(YELLOW, 0.5),
                at(0.4, 0.3, 0.9),
            )
            .object(
                Rectangle::new(1.5, 1.0),
                glass(GREEN, 0.5),
                at(0.2, 0.1, -0.6),
            );
        scene.size = UVec2::new(96, 72);
        scene
    };
    let sorted = Studio::game(&scene("glass")).picture(&scene("glass"));
    let oit = OrderIndependentTransparencySettings::default();
    for with in [
        scene("oit").with_camera(oit),
        scene("oit-prepass").with_camera((oit, DepthPrepass)),
    ] {
        let picture = Studio::game(&with).picture(&with);
        // It keeps colors with fewer bits.
        picture.assert_alike(&sorted, 3, 0.995, |_| true, &with.name);
    }
}
