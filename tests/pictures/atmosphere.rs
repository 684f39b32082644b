//! Sunlight under an `Atmosphere`. The software driver stops in the passes that fill the engine's
//! look-up textures, so they are left out here, with or without mirrors: no sunlight comes through
//! the air. A material that does not read them is lit all the same.

use std::sync::Arc;

use bevy::{
    camera::Hdr,
    core_pipeline::tonemapping::Tonemapping,
    light::{Atmosphere, atmosphere::ScatteringMedium},
    pbr::{AtmosphereSettings, resources::AtmosphereTransformsOffset},
    prelude::*,
    render::{Render, RenderApp, RenderSystems},
};

use super::lighting::still_life;
use crate::support::{
    props::{lamp, sun},
    scene::Scene,
    studio::{SHARE, Studio, TOLERANCE},
};

/// Without this neither look-up textures nor the sky are drawn.
fn leave_out_atmosphere_passes(
    mut commands: Commands,
    cameras: Query<Entity, With<AtmosphereTransformsOffset>>,
) {
    for camera in &cameras {
        commands
            .entity(camera)
            .remove::<AtmosphereTransformsOffset>();
    }
}

fn under_an_atmosphere(scene: Scene) -> Scene {
    let mut scene = scene
        .with_camera((AtmosphereSettings::default(), Hdr, Tonemapping::None))
        .plugin(|app| {
            app.sub_app_mut(RenderApp).add_systems(
                Render,
                leave_out_atmosphere_passes
                    .after(RenderSystems::PrepareResources)
                    .before(RenderSystems::Render),
            );
        });
    scene.props.push(Arc::new(|entity| {
        let medium = entity.world_scope(|world| {
            let mut media = world.resource_mut::<Assets<ScatteringMedium>>();
            media.add(ScatteringMedium::earth(32, 32))
        });
        entity.insert(Atmosphere::earth(medium));
    }));
    scene
}

#[test]
fn the_sun_is_as_dim_in_the_reflection_as_in_the_room() {
    let bare = still_life("atmosphere-bare")
        .prop(sun(false))
        .prop(lamp(vec3(1.0, 2.0, 2.0), false))
        .with_camera((Hdr, Tonemapping::None));
    let scene = under_an_atmosphere(bare.clone());
    let mut studio = Studio::game(&scene);
    let picture = studio.picture(&scene);
    let reference = studio.reference(&scene, 0);
    let mask = studio.mask(&scene, 0);
    let inside = |place| mask.inside(place);
    picture.assert_alike(&reference, TOLERANCE, SHARE, inside, "atmosphere");
    studio.assert_untouched_outside(&scene, &picture);
    let bright = Studio::game(&bare).picture(&bare);
    let dimmed = picture.difference(&bright, 8, inside).expect("one size");
    assert!(
        dimmed.beyond > 500,
        "the sun is as bright as ever: {dimmed}"
    );
}
