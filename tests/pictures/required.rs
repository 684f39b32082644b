//! Apps that give components to every camera: by requirement, or by an observer. None of them reaches
//! a view of the plugin's, so the picture is that of an app that gives them to its own camera.

use bevy::{
    anti_alias::{
        contrast_adaptive_sharpening::ContrastAdaptiveSharpening, fxaa::Fxaa, smaa::Smaa,
        taa::TemporalAntiAliasing,
    },
    camera::{
        Hdr,
        visibility::{NoCpuCulling, NoFrustumCulling},
    },
    core_pipeline::{
        oit::OrderIndependentTransparencySettings,
        prepass::{DeferredPrepass, DepthPrepass, MotionVectorPrepass, NormalPrepass},
    },
    light::VolumetricFog,
    pbr::{
        AtmosphereSettings, ContactShadows, DistanceFog, ScreenSpaceAmbientOcclusion,
        ScreenSpaceReflections, wireframe::Wireframe,
    },
    post_process::{
        auto_exposure::AutoExposure, bloom::Bloom, dof::DepthOfField,
        effect_stack::ChromaticAberration, motion_blur::MotionBlur,
    },
    prelude::*,
    render::{occlusion_culling::OcclusionCulling, view::NoIndirectDrawing},
};
use bevy_planar_mirror::{MirrorStatus, PlanarMirrorPlugin};

use super::changes::sunny_room;
use crate::support::{live::Live, picture::Picture, scene::Scene, stage::Stage};

/// A component of the user's.
#[derive(Component, Clone, Default)]
struct Mine;

fn scene() -> Scene {
    sunny_room("required")
}

/// The picture after so many frames that effects of several have come to an end, and what the mirror
/// says.
fn drawn(live: &mut Live) -> (Picture, Vec<String>) {
    for _ in 0..12 {
        live.stage.frame();
    }
    let picture = live.stage.read(&live.target, live.size);
    let picture = picture.unwrap_or_else(|reason| panic!("{reason}"));
    let world = live.world();
    let mut statuses = world.query::<&MirrorStatus>();
    let states = statuses.iter(world).flat_map(|status| &status.cameras);
    (picture, states.map(|seen| seen.state.to_string()).collect())
}

/// The same picture from an app that requires a component of every 3D camera, from one whose
/// observer inserts it, and from one whose camera has it.
fn check<C: Component + Default>(of_camera: Option<Live>) -> Live {
    let what = std::any::type_name::<C>();
    let scene = scene().touch_camera(|camera| {
        camera.insert(C::default());
    });
    let mut of_camera = match of_camera {
        Some(live) => live.again(&scene),
        None => Live::on(Stage::with_mirrors(), &scene),
    };
    let expected = drawn(&mut of_camera);
    let bare = self::scene();
    let adders: [fn(&mut App); 2] = [
        |app| {
            app.register_required_components::<Camera3d, C>();
        },
        |app| {
            app.add_observer(|add: On<Add, Camera3d>, mut commands: Commands| {
                commands.entity(add.entity).insert(C::default());
            });
        },
    ];
    for add in adders {
        let stage = Stage::new(|app| {
            app.add_plugins(PlanarMirrorPlugin::default());
            add(app);
        });
        let got = drawn(&mut Live::on(stage, &bare));
        assert_eq!(got.1, expected.1, "{what}");
        got.0.assert_same(&expected.0, what);
    }
    of_camera
}

macro_rules! check_each {
    ($($component:ty),* $(,)?) => {
        let mut live = None;
        $(live = Some(check::<$component>(live));)*
        drop(live);
    };
}

#[test]
fn what_every_camera_has_of_a_prepass_reaches_no_reflected_view() {
    check_each!(
        DepthPrepass,
        NormalPrepass,
        MotionVectorPrepass,
        DeferredPrepass,
        OcclusionCulling,
        ScreenSpaceReflections,
        ScreenSpaceAmbientOcclusion,
        ContactShadows,
    );
}

#[test]
fn what_every_camera_has_of_effects_reaches_no_reflected_view() {
    check_each!(
        AutoExposure,
        Bloom,
        ChromaticAberration,
        ContrastAdaptiveSharpening,
        DepthOfField,
        Fxaa,
        Hdr,
        MotionBlur,
        Smaa,
    );
    // It moves the camera from frame to frame: the count has to be the same.
    drop(check::<TemporalAntiAliasing>(None));
}

#[test]
fn what_every_camera_has_of_anything_else_reaches_no_reflected_view() {
    check_each!(
        AtmosphereSettings,
        DistanceFog,
        Mine,
        NoCpuCulling,
        NoFrustumCulling,
        NoIndirectDrawing,
        OrderIndependentTransparencySettings,
        VolumetricFog,
        Wireframe,
    );
}

/// What stopped the renderer: a reflected view with a prepass but no textures for it.
#[test]
fn a_game_may_require_a_prepass_of_every_camera() {
    let stage = Stage::as_games_run(|app| {
        app.add_plugins(PlanarMirrorPlugin::default());
        app.register_required_components::<Camera3d, DepthPrepass>();
    });
    let picture = Live::on(stage, &scene()).settled();
    let expected = Live::new(&scene().with_camera(DepthPrepass)).settled();
    picture.assert_same(&expected, "required-prepass");
}
