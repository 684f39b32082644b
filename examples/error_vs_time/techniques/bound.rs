//! The physical bound: the shading of the mirror's visible pixels and the geometry in the frustum
//! narrowed to them, as a view of the engine's own that does nothing else.
//!
//! An ordinary camera stands at the reflected eye. Its viewport is the rectangle of the screen that
//! the mirror lies in; of the geometry, what is behind the mirror or outside the pyramid from the
//! reflected eye through the mirror's frame is taken away beforehand, and what is partly so is cut
//! in f64. So exactly the pixels of the mirror are shaded, except that things before the mirror
//! hide none of them. What an app costs anyway (schedules, clearing, shadow maps) is measured by
//! the same app with a viewport of one pixel, and taken off: the bound of a frame is the frame
//! without a mirror, plus the difference of these two.

use std::sync::Arc;

use bevy::{
    camera::{ScalingMode, SubCameraView, Viewport, visibility::RenderLayers},
    light::NotShadowCaster,
    math::{DVec3, DVec4},
    mesh::VertexAttributeValues,
    prelude::*,
};

use crate::{
    pyramid::{self, within},
    support::{
        cut::Plane,
        reference::reflected_eye,
        scene::{Look, Object, Scene, exact},
        set::build_plain,
        stage::Stage,
    },
};

/// From so many objects across the mirror on they are cut by the projection: as meshes of their
/// own they would cost more than the cut saves.
const MANY: usize = 100;

/// Returns the camera. The picture has left and right exchanged.
pub fn set_up(
    stage: &mut Stage,
    scene: &Scene,
    (low, high): (UVec2, UVec2),
    target: &Handle<Image>,
) -> Entity {
    let mut bound = scene.clone();
    bound.mirrors.clear();
    let plane = scene.mirrors[0].plane();
    bound.eye = reflected_eye(&scene.eye, plane);
    let sides = pyramid::sides(scene);
    let across = |object: &Object| {
        heights(object, &plane).any(|height| height < 0.0)
            && heights(object, &plane).any(|height| height > 0.0)
    };
    let crowd = scene.objects.iter().filter(|object| across(object)).count() > MANY;
    let cut_by_projection = crowd && matches!(scene.projection, Projection::Perspective(_));
    bound.objects.clear();
    for object in &scene.objects {
        if !heights(object, &plane).any(|height| height > 0.0) {
            continue;
        }
        let planes: Vec<Plane> = if cut_by_projection {
            sides.clone()
        } else {
            sides.iter().copied().chain([plane]).collect()
        };
        bound.objects.extend(within(object, &planes));
    }
    if !crowd {
        keep_shadows(&mut bound, &scene.objects);
    }
    bound.projection = projection(scene, plane, &bound.eye, cut_by_projection);

    let size = high.max(low + 1) - low;
    let offset = UVec2::new(scene.size.x - low.x - size.x, low.y);
    let full_size = scene.size;
    let bound = bound.touch_camera(move |camera| {
        if let Some(mut camera) = camera.get_mut::<Camera>() {
            camera.viewport = Some(Viewport {
                physical_position: offset,
                physical_size: size,
                ..default()
            });
            camera.sub_camera_view = Some(SubCameraView {
                full_size,
                offset: offset.as_vec2(),
                size,
            });
        }
    });
    build_plain(stage, &bound, target.clone())
}

/// The objects as they are go on throwing their shadows, unseen; what is seen throws none.
fn keep_shadows(bound: &mut Scene, objects: &[Object]) {
    const UNSEEN: usize = 1;
    for prop in &mut bound.props {
        let light = prop.clone();
        *prop = Arc::new(move |entity| {
            light(entity);
            entity.insert(RenderLayers::from_layers(&[0, UNSEEN]));
        });
    }
    for object in &mut bound.objects {
        let look = object.look.clone();
        object.look = Look::other(move |entity| {
            look.apply(entity);
            entity.insert(NotShadowCaster);
        });
    }
    bound.objects.extend(objects.iter().cloned().map(|object| {
        let Object { look, .. } = object.clone();
        let look = Look::other(move |entity| {
            look.apply(entity);
            entity.insert(RenderLayers::layer(UNSEEN));
        });
        Object { look, ..object }
    }));
}

/// The heights of an object's vertices over a plane.
fn heights<'a>(object: &'a Object, plane: &'a Plane) -> impl Iterator<Item = f64> + 'a {
    let world_from_local = exact(&object.transform);
    let positions = match object.mesh.attribute(Mesh::ATTRIBUTE_POSITION) {
        Some(VertexAttributeValues::Float32x3(positions)) => &positions[..],
        _ => &[],
    };
    positions.iter().map(move |position| {
        let local = DVec3::from_array(position.map(f64::from));
        plane.height(world_from_local.transform_point3(local))
    })
}

fn projection(scene: &Scene, plane: Plane, eye: &Transform, cut: bool) -> Projection {
    let mut projection = scene.projection.clone();
    match &mut projection {
        Projection::Perspective(perspective) if cut => {
            let view_from_world = exact(eye).inverse();
            let normal = view_from_world.matrix3 * plane.normal;
            let mut near = DVec4::from((normal, plane.height(eye.translation.as_dvec3())));
            // The engine takes an exact (0, 0, -1) for "no clip".
            near.x += 1e-6;
            perspective.near_clip_plane = near.as_vec4();
        }
        // By the ratio of the whole picture, not of the viewport.
        Projection::Orthographic(orthographic) => {
            if let ScalingMode::FixedVertical { viewport_height } = orthographic.scaling_mode {
                let size = scene.size.as_vec2();
                orthographic.scaling_mode = ScalingMode::Fixed {
                    width: viewport_height * size.x / size.y,
                    height: viewport_height,
                };
            }
        }
        _ => {}
    }
    projection
}
