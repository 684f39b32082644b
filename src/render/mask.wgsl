// The mirror's own surface: into the stencil as a mask before its reflection is drawn, and into the
// depth of what sees it after that.

#import bevy_render::view::View

struct MirrorUniform {
    world_from_local: mat4x4<f32>,
    // What the depths of an oblique view that sees the surface may differ by.
    depth_noise: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> mirror: MirrorUniform;

#ifdef MASK
#ifdef MULTISAMPLED
@group(1) @binding(0) var main_depth: texture_depth_multisampled_2d;
#else
@group(1) @binding(0) var main_depth: texture_depth_2d;
#endif
#endif

// The engine computes the same depth of the same surface by another program, so the two may differ
// by some units of rounding. 2^-18 of the depth is 64 of them, and 40 micrometres at 10 m.
const DEPTH_SLACK: f32 = 3.8146973e-6;
// Without perspective depth is the sum of a constant and three products, and is near the constant
// all the way. Of it, four units of rounding; of what begins with the place of the surface, 16.
// Where something enters the mirror slack is a gap: 2^-18 would be 4 millimetres of 1000 m.
const CONSTANT_SLACK: f32 = 2.3841858e-7;
const PRODUCT_SLACK: f32 = 9.536743e-7;

fn depth_slack(world_position: vec3<f32>, clip: vec4<f32>) -> f32 {
    if view.clip_from_view[3][3] != 1.0 {
        return clip.z * DEPTH_SLACK;
    }
    let m = view.clip_from_world;
    let products = abs(vec3(m[0].z, m[1].z, m[2].z) * world_position);
    return dot(products, vec3(PRODUCT_SLACK)) + abs(m[3].z) * CONSTANT_SLACK;
}

// The place of the surface, moved towards the eye by `side` times the slack.
fn moved(position: vec3<f32>, side: f32) -> vec4<f32> {
    let world_position = (mirror.world_from_local * vec4(position, 1.0)).xyz;
    let clip = view.clip_from_world * vec4(world_position, 1.0);
    let slack = depth_slack(world_position, clip) + mirror.depth_noise * clip.w;
    return vec4(clip.xy, clip.z + side * slack, clip.w);
}

// Towards the eye, so that a mirror is not hidden by its own material.
@vertex
fn mask_vertex(@location(0) position: vec3<f32>) -> @builtin(position) vec4<f32> {
    return moved(position, 1.0);
}

#ifdef MASK
// Keeps the mask off what the camera sees in front of the mirror, sample by sample.
@fragment
fn mask_fragment(
    @builtin(position) position: vec4<f32>,
#ifdef MULTISAMPLED
    @builtin(sample_index) sample: u32,
#endif
) {
#ifdef MULTISAMPLED
    let seen = textureLoad(main_depth, vec2<i32>(position.xy), i32(sample));
#else
    let seen = textureLoad(main_depth, vec2<i32>(position.xy), 0);
#endif
    if position.z < seen {
        discard;
    }
}
#endif

// For draws of which the depth and the stencil are all that matters.
@fragment
fn empty_fragment() {}

// Away from the eye, so that the mirror's own material still passes the depth test.
@vertex
fn depth_vertex(@location(0) position: vec3<f32>) -> @builtin(position) vec4<f32> {
    return moved(position, -1.0);
}

// One triangle over the whole viewport, at the far end of the depth range.
@vertex
fn clear_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    let corner = vec2(f32(index & 1u), f32(index >> 1u)) * 4.0 - 1.0;
    return vec4(corner, 0.0, 1.0);
}

// The color itself comes from the blend constant.
@fragment
fn clear_fragment() -> @location(0) vec4<f32> {
    return vec4(1.0);
}
