// The mirror's own surface: into the stencil as a mask, and into the camera's depth at the end.

#import bevy_render::view::View

struct MirrorUniform {
    world_from_local: mat4x4<f32>,
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

// The main pass computes the same depth of the same surface by another program, so the two may
// differ by some units of rounding. 2^-18 of the depth is 64 of them, and 40 micrometres at 10 m.
const DEPTH_SLACK: f32 = 3.8146973e-6;

fn clip_from_local(position: vec3<f32>) -> vec4<f32> {
    let world_position = mirror.world_from_local * vec4(position, 1.0);
    return view.clip_from_world * vec4(world_position.xyz, 1.0);
}

#ifdef MASK
@vertex
fn mask_vertex(@location(0) position: vec3<f32>) -> @builtin(position) vec4<f32> {
    return clip_from_local(position);
}

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
    if position.z * (1.0 + DEPTH_SLACK) < seen {
        discard;
    }
}
#endif

// A hair away from the eye, so that the mirror's own material still passes the depth test.
@vertex
fn depth_vertex(@location(0) position: vec3<f32>) -> @builtin(position) vec4<f32> {
    let clip = clip_from_local(position);
    return vec4(clip.xy, clip.z * (1.0 - DEPTH_SLACK), clip.w);
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
