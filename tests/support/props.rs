//! Colors, materials, lights and textures that the scenes share.

use bevy::{
    asset::RenderAssetUsages,
    diagnostic::FrameCount,
    image::{ImageSampler, TextureFormatPixelInfo},
    light::CascadeShadowConfigBuilder,
    prelude::*,
    render::render_resource::{
        Extent3d, TextureDimension, TextureFormat, TextureViewDescriptor, TextureViewDimension,
    },
};

pub const RED: Color = Color::srgb(1.0, 0.0, 0.0);
pub const GREEN: Color = Color::srgb(0.0, 1.0, 0.0);
pub const BLUE: Color = Color::srgb(0.0, 0.0, 1.0);
pub const YELLOW: Color = Color::srgb(1.0, 1.0, 0.0);
pub const MAGENTA: Color = Color::srgb(1.0, 0.0, 1.0);

/// Whether a pixel is this color on the screen, give or take two levels.
pub fn is(color: Color) -> impl Fn([u8; 4]) -> bool + Copy {
    let wanted = bytes(color);
    move |pixel| (0..3).all(|i| pixel[i].abs_diff(wanted[i]) <= 2)
}

pub fn bytes(color: Color) -> [u8; 4] {
    color.to_srgba().to_u8_array()
}

/// Lit, rough, of one color.
pub fn lit(color: Color) -> StandardMaterial {
    StandardMaterial {
        base_color: color,
        perceptual_roughness: 0.8,
        ..default()
    }
}

/// Unlit, blended over what is behind.
pub fn glass(color: Color, alpha: f32) -> StandardMaterial {
    StandardMaterial {
        base_color: color.with_alpha(alpha),
        unlit: true,
        alpha_mode: AlphaMode::Blend,
        ..default()
    }
}

pub fn at(x: f32, y: f32, z: f32) -> Transform {
    Transform::from_xyz(x, y, z)
}

/// Daylight from above, a little from the right and the front.
pub fn sun(shadows: bool) -> impl Bundle + Clone {
    let light = DirectionalLight {
        illuminance: 6000.0,
        shadow_maps_enabled: shadows,
        ..default()
    };
    // Two cascades over what the scenes show: the default four would draw each scene twice as often.
    let cascades = CascadeShadowConfigBuilder {
        num_cascades: 2,
        first_cascade_far_bound: 6.0,
        maximum_distance: 20.0,
        ..default()
    };
    (
        light,
        cascades.build(),
        at(1.0, 3.0, 1.5).looking_at(Vec3::ZERO, Vec3::Y),
    )
}

pub fn lamp(place: Vec3, shadows: bool) -> impl Bundle + Clone {
    let light = PointLight {
        intensity: 400_000.0,
        shadow_maps_enabled: shadows,
        ..default()
    };
    (light, Transform::from_translation(place))
}

pub fn spot(place: Vec3, target: Vec3, shadows: bool) -> impl Bundle + Clone {
    let light = SpotLight {
        intensity: 2_000_000.0,
        outer_angle: 0.7,
        inner_angle: 0.5,
        shadow_maps_enabled: shadows,
        ..default()
    };
    (
        light,
        Transform::from_translation(place).looking_at(target, Vec3::Y),
    )
}

/// A texture of four by four texels, no two rows or columns of which are mirror images: upper left
/// red, upper right green, lower left blue, lower right yellow.
pub fn four_quarters(alpha: [u8; 4]) -> Image {
    let quarters = [RED, GREEN, BLUE, YELLOW].map(bytes);
    let texel = |x: usize, y: usize| {
        let quarter = x / 2 + 2 * (y / 2);
        let [r, g, b, _] = quarters[quarter];
        [r, g, b, alpha[quarter]]
    };
    let data = (0..16).flat_map(|i| texel(i % 4, i / 4)).collect();
    let mut image = Image::new(
        Extent3d {
            width: 4,
            height: 4,
            depth_or_array_layers: 1,
        },
        TextureDimension::D2,
        data,
        TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::default(),
    );
    image.sampler = ImageSampler::nearest();
    image
}

/// A cube map whose six faces have six colors (+x, -x, +y, -y, +z, -z), each brighter towards its
/// first corner, so that a turned one would show too.
pub fn six_colors() -> Image {
    const FACES: [[u8; 3]; 6] = [
        [200, 40, 40],
        [40, 200, 40],
        [60, 80, 220],
        [200, 200, 40],
        [200, 40, 200],
        [40, 200, 200],
    ];
    const EDGE: u32 = 8;
    let format = TextureFormat::Rgba8UnormSrgb;
    let texel = |face: [u8; 3], x: u32, y: u32| {
        let gain = 1.0 - 0.05 * x as f32 - 0.02 * y as f32;
        let [r, g, b] = face.map(|channel| (f32::from(channel) * gain) as u8);
        [r, g, b, 255]
    };
    let data: Vec<u8> = FACES
        .into_iter()
        .flat_map(|face| (0..EDGE * EDGE).flat_map(move |i| texel(face, i % EDGE, i / EDGE)))
        .collect();
    assert_eq!(
        data.len(),
        (EDGE * EDGE * 6) as usize * format.pixel_size().expect("plain bytes")
    );
    let size = Extent3d {
        width: EDGE,
        height: EDGE,
        depth_or_array_layers: 6,
    };
    let mut image = Image::new(
        size,
        TextureDimension::D2,
        data,
        format,
        RenderAssetUsages::default(),
    );
    image.texture_view_descriptor = Some(TextureViewDescriptor {
        dimension: Some(TextureViewDimension::Cube),
        ..default()
    });
    image
}

/// Noise that changes from frame to frame stands still, and so does the picture.
pub fn still_noise(app: &mut App) {
    app.add_systems(First, |mut frames: ResMut<FrameCount>| frames.0 = 7);
}

/// Adds an asset to the world of an entity.
pub fn add<A: Asset>(entity: &mut EntityWorldMut, asset: A) -> Handle<A> {
    entity.world_scope(|world| world.resource_mut::<Assets<A>>().add(asset))
}

/// A material with [`four_quarters`] on it.
pub fn quarters(material: StandardMaterial, alpha: [u8; 4]) -> super::scene::Look {
    super::scene::Look::other(move |entity| {
        let texture = add(entity, four_quarters(alpha));
        let material = StandardMaterial {
            base_color_texture: Some(texture),
            ..material.clone()
        };
        let material = add(entity, material);
        entity.insert(MeshMaterial3d(material));
    })
}
