//! Meshes that a vertex shader turns to the eye: they show in a mirror, from the front, like any mesh.

use bevy::{
    asset::uuid_handle,
    mesh::MeshVertexBufferLayoutRef,
    pbr::{MaterialPipeline, MaterialPipelineKey},
    prelude::*,
    render::render_resource::{
        AsBindGroup, Face, RenderPipelineDescriptor, SpecializedMeshPipelineError,
    },
    shader::ShaderRef,
};

use crate::support::{
    props::{GREEN, at},
    scene::{Look, Scene, Surface},
    studio::{SHARE, Studio, TOLERANCE},
};

const SHADER: Handle<Shader> = uuid_handle!("a4a3e2c5-6f2e-4c37-8a4f-6a1d1f5a8c55");

/// Made from the view's own axes, red on the left and blue on the right.
const CODE: &str = "
#import bevy_pbr::{mesh_functions, forward_io::Vertex, mesh_view_bindings::view}

struct Billboard {
    @builtin(position) position: vec4<f32>,
    @location(0) side: f32,
}

@vertex
fn vertex(in: Vertex) -> Billboard {
    let center = mesh_functions::get_world_from_local(in.instance_index)[3].xyz;
    let right = view.world_from_view[0].xyz;
    let up = view.world_from_view[1].xyz;
    var out: Billboard;
    out.position = view.clip_from_world
        * vec4(center + right * in.position.x + up * in.position.y, 1.0);
    out.side = in.position.x;
    return out;
}

@fragment
fn fragment(in: Billboard, @builtin(front_facing) is_front: bool) -> @location(0) vec4<f32> {
    if !is_front {
        return vec4(1.0, 1.0, 1.0, 1.0);
    }
    return select(vec4(1.0, 0.0, 0.0, 1.0), vec4(0.0, 0.0, 1.0, 1.0), in.side > 0.0);
}
";

/// What it culls: nothing, or the back as most materials do.
#[derive(Asset, TypePath, AsBindGroup, Clone, Default)]
#[bind_group_data(Culled)]
struct Billboard {
    culled: Option<Face>,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Culled(Option<Face>);

impl From<&Billboard> for Culled {
    fn from(billboard: &Billboard) -> Self {
        Self(billboard.culled)
    }
}

impl Material for Billboard {
    fn vertex_shader() -> ShaderRef {
        SHADER.into()
    }

    fn fragment_shader() -> ShaderRef {
        SHADER.into()
    }

    fn enable_prepass() -> bool {
        false
    }

    fn enable_shadows() -> bool {
        false
    }

    fn specialize(
        _: &MaterialPipeline,
        descriptor: &mut RenderPipelineDescriptor,
        _: &MeshVertexBufferLayoutRef,
        key: MaterialPipelineKey<Self>,
    ) -> Result<(), SpecializedMeshPipelineError> {
        descriptor.primitive.cull_mode = key.bind_group_data.0;
        Ok(())
    }
}

fn add_billboards(app: &mut App) {
    app.add_plugins(MaterialPlugin::<Billboard>::default());
    let mut shaders = app.world_mut().resource_mut::<Assets<Shader>>();
    let shader = Shader::from_wgsl(CODE, "billboard.wgsl");
    shaders.insert(SHADER.id(), shader).expect("the id is free");
}

fn billboard(culled: Option<Face>) -> Look {
    Look::other(move |entity| {
        let handle = entity.world_scope(|world| {
            world
                .resource_mut::<Assets<Billboard>>()
                .add(Billboard { culled })
        });
        entity.insert(MeshMaterial3d(handle));
    })
}

/// By a camera at the eye's mirror image it is drawn the same way, and then flipped.
#[test]
fn a_billboard_is_reflected() {
    for culled in [None, Some(Face::Back)] {
        let scene = Scene::new(&format!("billboard-{culled:?}"))
            .eye(vec3(0.9, 0.7, 3.0), vec3(0.0, 0.2, 0.0))
            .mirror(Surface::wall(3.0, 2.0, at(0.0, 0.2, 0.0)))
            .object(
                Rectangle::new(0.6, 0.4),
                billboard(culled),
                at(-0.5, 0.3, 0.8),
            )
            .object(Cuboid::from_length(0.3), GREEN, at(0.5, 0.1, 0.6))
            .plugin(add_billboards);
        let mut studio = Studio::game(&scene);
        let picture = studio.picture(&scene);
        let reference = studio.reference(&scene, 0);
        let plain = studio.without_mirrors(&scene);
        let mask = studio.mask(&scene, 0);
        const SIDES: [[u8; 4]; 2] = [[255, 0, 0, 255], [0, 0, 255, 255]];
        // To the mask it is a mesh that does not turn.
        let is_itself = |place: UVec2| SIDES.contains(&plain.at(place.x, place.y));
        let inside = |place| mask.inside(place) && !is_itself(place);
        picture.assert_alike(&reference, TOLERANCE, SHARE, inside, &scene.name);
        for color in SIDES {
            let places = picture.places().filter(|place| inside(*place));
            let count = places.filter(|at| picture.at(at.x, at.y) == color).count();
            assert!(count > 30, "{culled:?}: half of it is not in the mirror");
        }
        assert_eq!(
            picture.count(|pixel| pixel == [255; 4]),
            0,
            "its back shows"
        );
    }
}
