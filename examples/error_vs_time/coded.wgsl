// One flat color for each thing, and another for what no mirror may show of it.

#import bevy_pbr::{
    forward_io::VertexOutput,
    mesh_view_bindings::view,
}

struct Code {
    color: vec4<f32>,
    // Of the mirror: its unit normal, a point of it.
    normal: vec4<f32>,
    origin: vec4<f32>,
    // How far behind the mirror still counts as before it: for each unit from the eye, and besides.
    // z: 1 hides the thing from cameras before the mirror.
    tolerance: vec4<f32>,
}

@group(#{MATERIAL_BIND_GROUP}) @binding(100) var<uniform> code: Code;

const GHOST: vec3<f32> = vec3(1.0, 0.0, 1.0);

@fragment
fn fragment(in: VertexOutput) -> @location(0) vec4<f32> {
    let eye = view.world_position;
    if code.tolerance.z == 1.0 && dot(code.normal.xyz, eye - code.origin.xyz) > 0.0 {
        discard;
    }
    let place = in.world_position.xyz;
    // From a point of the plane: far from the origin the sums of the plane equation are too large.
    let before = dot(code.normal.xyz, place - code.origin.xyz);
    if before < -(code.tolerance.x * distance(place, eye) + code.tolerance.y) {
        return vec4(GHOST, 1.0);
    }
    return code.color;
}
