// Shows the emissive texture at the place on the screen.

#import bevy_pbr::{
    forward_io::{FragmentOutput, VertexOutput},
    mesh_view_bindings::view,
    pbr_bindings::{emissive_sampler, emissive_texture},
    pbr_fragment::pbr_input_from_standard_material,
    pbr_functions::{apply_pbr_lighting, main_pass_post_lighting_processing},
}

@fragment
fn fragment(in: VertexOutput, @builtin(front_facing) is_front: bool) -> FragmentOutput {
    let uv = (in.position.xy - view.viewport.xy) / view.viewport.zw;
    var pbr_input = pbr_input_from_standard_material(in, is_front);
    let seen = textureSampleLevel(emissive_texture, emissive_sampler, uv, 0.0);
    // Weight 0: the exposure has had its say in the image.
    pbr_input.material.emissive = vec4(seen.rgb, 0.0);
    var out: FragmentOutput;
    out.color = apply_pbr_lighting(pbr_input);
    out.color = main_pass_post_lighting_processing(pbr_input, out.color);
    return out;
}
