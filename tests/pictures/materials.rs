//! Materials whose look depends on which side is seen, and materials of the user's own.

use std::f32::consts::PI;

use bevy::{
    asset::uuid_handle,
    core_pipeline::prepass::{DepthPrepass, NormalPrepass},
    mesh::MeshVertexBufferLayoutRef,
    pbr::{ExtendedMaterial, MaterialExtension, MaterialPipeline, MaterialPipelineKey},
    prelude::*,
    reflect::TypePath,
    render::render_resource::{
        AsBindGroup, RenderPipelineDescriptor, SpecializedMeshPipelineError,
    },
    shader::ShaderRef,
};

use crate::support::{
    picture::Picture,
    props::{BLUE, GREEN, RED, YELLOW, add, at, is, lamp, lit, sun},
    scene::{Look, Scene, Surface},
    studio::{SHARE, Studio, TOLERANCE, assert_reflects},
};

fn wall(name: &str) -> Scene {
    Scene::new(name)
        .eye(vec3(0.6, 0.3, 4.0), Vec3::ZERO)
        .mirror(Surface::wall(4.0, 2.6, Transform::default()))
}

/// [`Studio::assert_reflects`] for things whose outline only their own shader knows: what stands
/// before the mirror is seen in the picture without mirrors, where nothing else shows.
#[track_caller]
fn assert_own_reflects(scene: &Scene) -> Picture {
    let mut studio = Studio::of(scene);
    let picture = studio.picture(scene);
    let plain = studio.without_mirrors(scene);
    let mut bare = scene.clone();
    bare.objects.clear();
    let mask = studio.mask(&bare, 0);
    let empty = |place: UVec2| is(scene.clear_color)(plain.at(place.x, place.y));
    let around = |place: UVec2| {
        let corner = place.saturating_sub(UVec2::ONE);
        let size = (place + 2).min(plain.size()) - corner;
        (0..size.x * size.y).all(|i| empty(corner + UVec2::new(i % size.x, i / size.x)))
    };
    picture.assert_alike(
        &studio.reference(scene, 0),
        TOLERANCE,
        SHARE,
        |place| mask.inside(place) && around(place),
        &format!("{}-inside", scene.name),
    );
    picture.assert_alike(
        &plain,
        0,
        1.0,
        |place| mask.outside(place),
        &format!("{}-outside", scene.name),
    );
    picture
}

#[test]
fn two_sided_sheets_are_lit_from_the_right_side() {
    let sheet = |color| StandardMaterial {
        double_sided: true,
        cull_mode: None,
        ..lit(color)
    };
    let mut scene = wall("two-sided")
        .eye(vec3(1.6, 0.6, 3.4), Vec3::ZERO)
        // The camera sees the dark side, the mirror the one towards the lamp.
        .object(Rectangle::new(0.6, 0.6), sheet(RED), at(-0.5, 0.1, 0.9))
        .object(
            Rectangle::new(0.6, 0.6),
            sheet(RED),
            at(0.6, -0.2, 0.9).with_rotation(Quat::from_rotation_y(PI)),
        )
        .object(
            Rectangle::new(0.5, 0.5),
            sheet(GREEN),
            at(0.0, 0.7, 0.6).with_rotation(Quat::from_euler(EulerRot::XYZ, 1.1, 0.5, 0.0)),
        )
        .prop(lamp(vec3(0.0, 0.3, 0.3), false));
    scene.ambient.brightness = 20.0;
    let picture = assert_reflects(&scene);
    let bright = picture.count(|[r, g, b, _]| r > 150 && g < 120 && b < 120);
    let dark = picture.count(|[r, g, b, _]| r > 5 && r < 60 && g < 10 && b < 10);
    assert!(
        bright > 300 && dark > 300,
        "both sides are seen: {bright} bright and {dark} dark pixels: {}",
        picture.save("two-sided")
    );
}

#[test]
fn culled_faces_are_those_that_the_mirror_would_not_show() {
    let culling = |color, cull_mode| StandardMaterial {
        cull_mode,
        ..lit(color)
    };
    use bevy::render::render_resource::Face;
    // One sees into the boxes.
    let scene = wall("culling")
        .object(
            Cuboid::from_length(0.7),
            culling(RED, Some(Face::Front)),
            at(-0.9, 0.0, 1.0).with_rotation(Quat::from_rotation_y(0.5)),
        )
        .object(
            Cuboid::from_length(0.7),
            culling(GREEN, Some(Face::Back)),
            at(0.0, 0.3, 1.0).with_rotation(Quat::from_rotation_y(0.5)),
        )
        .object(
            Cuboid::from_length(0.7),
            culling(YELLOW, None),
            at(0.9, 0.0, 1.0).with_rotation(Quat::from_rotation_y(0.5)),
        )
        .prop(sun(false))
        .prop(lamp(vec3(0.0, 0.5, 0.5), false));
    assert_reflects(&scene);
}

/// Green from the front, red from behind, whatever the shader is told of normals.
const SIDES: Handle<Shader> = uuid_handle!("6c2f7a52-2d5b-4f0e-9a26-3f1d3c3b8f01");
const SIDES_WGSL: &str = "
#import bevy_pbr::forward_io::VertexOutput

@fragment
fn fragment(in: VertexOutput, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    return select(vec4(1.0, 0.0, 0.0, 1.0), vec4(0.0, 1.0, 0.0, 1.0), front);
}
";

#[derive(Asset, TypePath, AsBindGroup, Clone, Default)]
struct Sides {}

impl Material for Sides {
    fn fragment_shader() -> ShaderRef {
        SIDES.into()
    }

    fn specialize(
        _: &MaterialPipeline,
        descriptor: &mut RenderPipelineDescriptor,
        _: &MeshVertexBufferLayoutRef,
        _: MaterialPipelineKey<Self>,
    ) -> Result<(), SpecializedMeshPipelineError> {
        descriptor.primitive.cull_mode = None;
        Ok(())
    }
}

/// Tints what the standard material makes of a surface, by the side that is seen.
const TINT: Handle<Shader> = uuid_handle!("6c2f7a52-2d5b-4f0e-9a26-3f1d3c3b8f02");
const TINT_WGSL: &str = "
#import bevy_pbr::{
    pbr_fragment::pbr_input_from_standard_material,
    pbr_functions::{alpha_discard, apply_pbr_lighting, main_pass_post_lighting_processing},
    forward_io::{VertexOutput, FragmentOutput},
}

@group(#{MATERIAL_BIND_GROUP}) @binding(100) var<uniform> back: vec4<f32>;

@fragment
fn fragment(in: VertexOutput, @builtin(front_facing) is_front: bool) -> FragmentOutput {
    var pbr_input = pbr_input_from_standard_material(in, is_front);
    if !is_front {
        pbr_input.material.base_color *= back;
    }
    pbr_input.material.base_color = alpha_discard(pbr_input.material, pbr_input.material.base_color);
    var out: FragmentOutput;
    out.color = main_pass_post_lighting_processing(pbr_input, apply_pbr_lighting(pbr_input));
    return out;
}
";

#[derive(Asset, TypePath, AsBindGroup, Clone)]
struct Tint {
    #[uniform(100)]
    back: LinearRgba,
}

impl MaterialExtension for Tint {
    fn fragment_shader() -> ShaderRef {
        TINT.into()
    }
}

/// Waves: the corners of the mesh are moved in the shader, as are those of its prepass.
const WAVES: Handle<Shader> = uuid_handle!("6c2f7a52-2d5b-4f0e-9a26-3f1d3c3b8f03");
const WAVES_WGSL: &str = "
#import bevy_pbr::{mesh_functions, view_transformations::position_world_to_clip}
#ifdef PREPASS_PIPELINE
#import bevy_pbr::prepass_io::{Vertex, VertexOutput}
#else
#import bevy_pbr::forward_io::{Vertex, VertexOutput}
#endif

@vertex
fn vertex(in: Vertex) -> VertexOutput {
    var out: VertexOutput;
    let world_from_local = mesh_functions::get_world_from_local(in.instance_index);
    let swell = 0.15 * sin(7.0 * in.position.x) * vec3(0.0, 0.0, 1.0);
    out.world_position =
        mesh_functions::mesh_position_local_to_world(world_from_local, vec4(in.position + swell, 1.0));
    out.position = position_world_to_clip(out.world_position.xyz);
#ifndef PREPASS_PIPELINE
    out.world_normal = mesh_functions::mesh_normal_local_to_world(in.normal, in.instance_index);
#ifdef VERTEX_UVS_A
    out.uv = in.uv;
#endif
#endif
    return out;
}

#ifndef PREPASS_PIPELINE
@fragment
fn fragment(in: VertexOutput, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    let height = in.world_position.z - 1.0;
    return vec4(0.3 + 2.0 * height, select(0.0, 0.6, front), 0.3 - 1.5 * height, 1.0);
}
#endif
";

#[derive(Asset, TypePath, AsBindGroup, Clone, Default)]
struct Waves {}

impl Material for Waves {
    fn vertex_shader() -> ShaderRef {
        WAVES.into()
    }

    fn fragment_shader() -> ShaderRef {
        WAVES.into()
    }

    fn prepass_vertex_shader() -> ShaderRef {
        WAVES.into()
    }

    fn specialize(
        _: &MaterialPipeline,
        descriptor: &mut RenderPipelineDescriptor,
        _: &MeshVertexBufferLayoutRef,
        _: MaterialPipelineKey<Self>,
    ) -> Result<(), SpecializedMeshPipelineError> {
        descriptor.primitive.cull_mode = None;
        Ok(())
    }
}

fn own_materials(app: &mut App) {
    let mut shaders = app.world_mut().resource_mut::<Assets<Shader>>();
    for (handle, source, path) in [
        (SIDES, SIDES_WGSL, "sides.wgsl"),
        (TINT, TINT_WGSL, "tint.wgsl"),
        (WAVES, WAVES_WGSL, "waves.wgsl"),
    ] {
        shaders
            .insert(&handle, Shader::from_wgsl(source, path))
            .expect("no other shader has this id");
    }
    app.add_plugins((
        MaterialPlugin::<Sides>::default(),
        MaterialPlugin::<ExtendedMaterial<StandardMaterial, Tint>>::default(),
        MaterialPlugin::<Waves>::default(),
    ));
}

fn own<M: Material>(material: M) -> Look {
    Look::other(move |entity| {
        let material = add(entity, material.clone());
        entity.insert(MeshMaterial3d(material));
    })
}

#[test]
fn a_material_of_the_users_own_knows_its_front_in_the_mirror() {
    let scene = wall("own")
        .plugin(own_materials)
        // Its back is to the camera, its front to the mirror.
        .object(
            Rectangle::new(0.8, 0.8),
            own(Sides {}),
            at(-0.7, 0.0, 1.2).with_rotation(Quat::from_rotation_y(PI)),
        )
        .object(
            Cuboid::from_length(0.4),
            own(Sides {}),
            at(0.8, 0.1, 0.9).with_rotation(Quat::from_euler(EulerRot::XYZ, 0.3, 0.7, 0.0)),
        );
    let picture = assert_own_reflects(&scene);
    let (front, back) = (picture.count(is(GREEN)), picture.count(is(RED)));
    assert!(front > 300 && back > 300, "{front} front, {back} back");
    // To the right of the middle only the box is seen, from outside alone.
    let right = picture.crop(UVec2::new(90, 0), UVec2::new(70, 120));
    assert!(right.count(is(GREEN)) > 100);
    assert_eq!(right.count(is(RED)), 0, "the box is turned inside out");
}

#[test]
fn an_extended_material_knows_its_front_in_the_mirror() {
    let tinted = |color| {
        own(ExtendedMaterial {
            base: StandardMaterial {
                cull_mode: None,
                double_sided: true,
                ..lit(color)
            },
            extension: Tint {
                back: LinearRgba::rgb(0.1, 1.0, 0.1),
            },
        })
    };
    let mut scene = wall("extended")
        .plugin(own_materials)
        .object(
            Rectangle::new(0.8, 0.8),
            tinted(Color::WHITE),
            at(-0.7, 0.0, 1.2).with_rotation(Quat::from_rotation_y(PI)),
        )
        .object(
            Sphere::new(0.4).mesh().uv(24, 14),
            tinted(YELLOW),
            at(0.8, 0.1, 0.2),
        )
        .prop(sun(false))
        .prop(lamp(vec3(0.0, 0.3, 0.5), false));
    scene.ambient.brightness = 100.0;
    let picture = assert_own_reflects(&scene);
    let green = picture.count(|[r, g, _, _]| g > 60 && r < g / 2);
    assert!(green > 300, "its back is seen by the camera: {green}");
}

#[test]
fn corners_moved_by_a_shader_are_moved_in_the_mirror() {
    let sheet = Plane3d::new(Vec3::Z, Vec2::splat(0.6))
        .mesh()
        .subdivisions(12)
        .build();
    let scene = wall("waves")
        .plugin(own_materials)
        .object(
            sheet,
            own(Waves {}),
            at(-0.3, 0.0, 1.0).with_rotation(Quat::from_rotation_y(0.4)),
        )
        .object(Cuboid::from_length(0.4), BLUE, at(0.9, 0.0, 1.0));
    assert_own_reflects(&scene);
}

/// The opaque pass then leaves alone what the prepass has drawn; the reflection has no prepass.
#[test]
fn own_materials_reflect_for_a_camera_with_prepasses() {
    let sheet = Plane3d::new(Vec3::Z, Vec2::splat(0.6))
        .mesh()
        .subdivisions(12)
        .build();
    let scene = wall("own-prepass")
        .plugin(own_materials)
        .object(sheet, own(Waves {}), at(-0.7, 0.0, 1.0))
        .object(
            Rectangle::new(0.8, 0.8),
            own(Sides {}),
            at(0.7, 0.0, 1.2).with_rotation(Quat::from_rotation_y(PI)),
        )
        .with_camera((DepthPrepass, NormalPrepass));
    assert_own_reflects(&scene);
}
