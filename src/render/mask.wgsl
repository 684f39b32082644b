// The mirror's own surface: into the stencil as a mask before its reflection is drawn, and into the
// depth, and what else a prepass writes, of what sees it after that.

#import bevy_render::view::View

struct MirrorUniform {
    world_from_local: mat4x4<f32>,
    // For the camera in the last frame.
    previous_clip_from_local: mat4x4<f32>,
    // Distances from the eye at which the surface begins to fade in, is there, begins to fade out
    // and is gone.
    fade: vec4<f32>,
    // Of the plane, in the world.
    normal: vec3<f32>,
    // What the depths of an oblique view that sees the surface may differ by.
    depth_noise: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> mirror: MirrorUniform;

#ifdef READS_DEPTH
#ifdef MULTISAMPLED
@group(1) @binding(0) var main_depth: texture_depth_multisampled_2d;
#else
@group(1) @binding(0) var main_depth: texture_depth_2d;
#endif
#endif

struct Surface {
    @builtin(position) position: vec4<f32>,
#ifdef HAS_OTHER_SIDE
    // Clip z of the other side of the slack.
#ifdef MULTISAMPLED
    @location(0) @interpolate(perspective, sample) other_z: f32,
#else
    @location(0) other_z: f32,
#endif
#endif
#ifdef FADES
    @location(1) @interpolate(flat) fade: i32,
#endif
#ifdef MOTION_VECTORS
    @location(2) clip: vec4<f32>,
    @location(3) previous_clip: vec4<f32>,
#endif
}

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
fn surface(position: vec3<f32>, side: f32) -> Surface {
    let world_position = (mirror.world_from_local * vec4(position, 1.0)).xyz;
    let clip = view.clip_from_world * vec4(world_position, 1.0);
    let slack = depth_slack(world_position, clip) + mirror.depth_noise * clip.w;
    var out: Surface;
    out.position = vec4(clip.xy, clip.z + side * slack, clip.w);
#ifdef HAS_OTHER_SIDE
    out.other_z = clip.z - side * slack;
#endif
#ifdef FADES
    out.fade = fade_level();
#endif
#ifdef MOTION_VECTORS
    out.clip = view.unjittered_clip_from_world * vec4(world_position, 1.0);
    out.previous_clip = mirror.previous_clip_from_local * vec4(position, 1.0);
#endif
    return out;
}

// Towards the eye, so that a mirror is not hidden by its own material.
@vertex
fn near_vertex(@location(0) position: vec3<f32>) -> Surface {
    return surface(position, 1.0);
}

// Away from the eye, so that the mirror's own material still passes the depth test.
@vertex
fn far_vertex(@location(0) position: vec3<f32>) -> Surface {
    return surface(position, -1.0);
}

#ifdef FADES
// How far the surface has faded, as the engine counts it: from -16, where it begins to appear, over
// 0 to 16, where it is gone. `get_visibility_range_dither_level` of Bevy's `mesh_functions.wgsl`.
fn fade_level() -> i32 {
    let distance = distance(view.lod_view_world_position, mirror.world_from_local[3].xyz);
    let vanishes = distance >= mirror.fade.z;
    let margin = select(mirror.fade.xy, mirror.fade.zw, vanishes);
    let level = i32(round((distance - margin.x) / (margin.y - margin.x) * 16.0));
    return select(-16, 0, vanishes) + clamp(level, 0, 16);
}

// Leaves out the pixels that the engine leaves out of a mesh that has faded so far: ordered
// dithering by a Bayer matrix of 4 by 4, made by interleaving bits of the place.
fn is_faded(place: vec2<f32>, level: i32) -> bool {
    let x = u32(place.x);
    let y = u32(place.y);
    let threshold = i32((((x ^ y) & 1u) << 3u) | ((y & 1u) << 2u) | (((x ^ y) & 2u)) | ((y & 2u) >> 1u));
    return level <= -16 || level >= 16
        || (level > 0 && level + threshold >= 16)
        || (level < 0 && level + threshold < 0);
}
#endif

#ifdef READS_DEPTH
// Keeps off what the camera sees in front of the mirror, sample by sample: the mask, and the depth
// of the prepass, which may lack it. And keeps the mask off the holes of a material that cuts some
// out: there the camera sees something behind the surface.
@fragment
fn seen_fragment(
    in: Surface,
#ifdef MULTISAMPLED
    @builtin(sample_index) sample: u32,
#endif
) {
#ifdef MULTISAMPLED
    let seen = textureLoad(main_depth, vec2<i32>(in.position.xy), i32(sample));
#else
    let seen = textureLoad(main_depth, vec2<i32>(in.position.xy), 0);
#endif
#ifdef IS_FAR_SIDE
    let near_side = in.other_z * in.position.w;
#else
    let near_side = in.position.z;
#endif
    if near_side < seen {
        discard;
    }
#ifdef CUT_OUT
    let far_side = in.other_z * in.position.w;
    if seen < far_side {
        discard;
    }
#endif
#ifdef FADES
    if is_faded(in.position.xy, in.fade) {
        discard;
    }
#endif
}
#endif

// For draws of which the depth and the stencil are all that matters.
@fragment
fn empty_fragment(in: Surface) {
#ifdef FADES
    if is_faded(in.position.xy, in.fade) {
        discard;
    }
#endif
}

#ifdef PREPASS_COLORS
struct Prepass {
#ifdef NORMALS
    @location(0) normal: vec4<f32>,
#endif
#ifdef MOTION_VECTORS
    @location(1) motion_vector: vec2<f32>,
#endif
}

// What the engine's `prepass.wgsl` writes for a flat mesh.
@fragment
fn prepass_fragment(in: Surface) -> Prepass {
#ifdef FADES
    if is_faded(in.position.xy, in.fade) {
        discard;
    }
#endif
    var out: Prepass;
#ifdef NORMALS
    out.normal = vec4(mirror.normal * 0.5 + 0.5, 1.0);
#endif
#ifdef MOTION_VECTORS
    let now = in.clip.xy / in.clip.w;
    let before = in.previous_clip.xy / in.previous_clip.w;
    out.motion_vector = (now - before) * vec2(0.5, -0.5);
#endif
    return out;
}
#endif

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
