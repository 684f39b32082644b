//! A second camera into an image, as the engine's own example of a mirror does it: the main
//! camera reflected, a near clip plane at the mirror, inverted culling, and on the mirror a
//! material that samples the image in screen space.
//!
//! The example's mirror is fixed to one plane; here the same steps take any. Its formulas are kept,
//! in f32 as there, only that points are reflected relative to the mirror, so that the distance
//! from the origin does not cost it more than it must. What it does not have is not given to it:
//! no clip for orthographic cameras, and none where the camera looks exactly square at the mirror.

use bevy::{
    asset::{AssetPath, embedded_path},
    camera::RenderTarget,
    math::Affine3A,
    pbr::{ExtendedMaterial, MaterialExtension},
    prelude::*,
    render::render_resource::{AsBindGroup, Face},
    shader::ShaderRef,
};

use crate::support::{
    props::add,
    scene::{Look, Scene, Surface},
    set::build_plain,
    stage::Stage,
};

/// Shows its emissive texture at the place on the screen instead of by coordinates of the mesh.
#[derive(Asset, AsBindGroup, Reflect, Clone, Debug)]
struct ScreenSpaceTexture {
    /// An extension has to have a field.
    #[uniform(100)]
    unused: Vec4,
}

impl MaterialExtension for ScreenSpaceTexture {
    fn fragment_shader() -> ShaderRef {
        let path = AssetPath::from_path_buf(embedded_path!("error_vs_time", "rival.wgsl"));
        path.with_source("embedded").into()
    }
}

type ScreenSpaceMaterial = ExtendedMaterial<StandardMaterial, ScreenSpaceTexture>;

pub fn plugin(app: &mut App) {
    bevy::asset::embedded_asset!(app, "error_vs_time", "rival.wgsl");
    app.add_plugins(MaterialPlugin::<ScreenSpaceMaterial>::default());
}

/// Returns the main camera.
pub fn set_up(
    stage: &mut Stage,
    scene: &Scene,
    camera_scale: f32,
    divisor: u32,
    clip: bool,
    target: &Handle<Image>,
) -> Entity {
    let image = stage.target((scene.size / divisor).max(UVec2::ONE));
    let mut scene = scene.clone();
    let surface = &mut scene.mirrors[0];
    let flips = surface.transform.scale.signum().element_product() < 0.0;
    surface.look = Some(screen_space(image.clone(), flips));
    let camera = build_plain(stage, &scene, target.clone());
    let main = Affine3A::from_scale_rotation_translation(
        Vec3::splat(camera_scale),
        scene.eye.rotation,
        scene.eye.translation,
    );
    let (transform, projection) = reflected(main, &scene.projection, &scene.mirrors[0], clip);
    let mut second = stage
        .world()
        .spawn((scene.camera_bundle(), RenderTarget::from(image)));
    for touch in &scene.camera {
        touch(&mut second);
    }
    second.insert((
        Camera {
            order: -1,
            // Mirroring turns the winding of every triangle around.
            invert_culling: true,
            ..default()
        },
        transform,
        projection,
    ));
    camera
}

/// The example's `calculate_mirror_camera_transform_and_projection`, for any plane.
fn reflected(
    main: Affine3A,
    projection: &Projection,
    mirror: &Surface,
    clip: bool,
) -> (Transform, Projection) {
    let plane = mirror.plane();
    let (normal, origin) = (plane.normal.as_vec3(), mirror.transform.translation);
    let reflect = |v: Vec3| v - 2.0 * normal.dot(v) * normal;
    let axes = main.matrix3;
    let eye = Vec3::from(main.translation);
    let transform = Transform::from_matrix(Mat4::from_cols(
        reflect(axes.x_axis.into()).extend(0.0),
        reflect(axes.y_axis.into()).extend(0.0),
        reflect(axes.z_axis.into()).extend(0.0),
        (origin + reflect(eye - origin)).extend(1.0),
    ));
    let mut projection = projection.clone();
    if let (Projection::Perspective(perspective), true) = (&mut projection, clip) {
        let from_camera = normal.dot(origin - eye);
        let in_view = (axes.inverse() * -Vec3A::from(normal)).normalize();
        perspective.near_clip_plane = Vec3::from(in_view).extend(from_camera);
    }
    (transform, projection)
}

fn screen_space(image: Handle<Image>, flips: bool) -> Look {
    Look::other(move |entity| {
        let material = add(
            entity,
            ScreenSpaceMaterial {
                base: StandardMaterial {
                    base_color: Color::BLACK,
                    emissive: Color::WHITE.into(),
                    emissive_texture: Some(image.clone()),
                    perceptual_roughness: 0.0,
                    metallic: 1.0,
                    cull_mode: Some(if flips { Face::Front } else { Face::Back }),
                    ..default()
                },
                extension: ScreenSpaceTexture { unused: Vec4::ZERO },
            },
        );
        entity.insert(MeshMaterial3d(material));
    })
}
