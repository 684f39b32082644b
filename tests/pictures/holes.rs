//! Mirrors of which a part is not there: cut out by their material, or fading by their
//! `VisibilityRange`.

use bevy::{
    asset::{RenderAssetUsages, uuid_handle},
    camera::visibility::VisibilityRange,
    image::ImageSampler,
    prelude::*,
    render::render_resource::{AsBindGroup, Extent3d, TextureDimension, TextureFormat},
    shader::ShaderRef,
};
use bevy_planar_mirror::PlanarMirrorPlugin;

use crate::support::{
    picture::Picture,
    props::{BLUE, GREEN, RED, at, glass},
    scene::{Look, Scene, Surface},
    studio::{Studio, TOLERANCE},
};

const SIDE: u32 = 32;

/// A wall behind an upright mirror that wears `look`, and things before it.
fn room(name: &str, look: impl Into<Look>) -> Scene {
    let mut scene = Scene::new(name)
        .eye(vec3(0.4, 0.5, 3.2), vec3(0.0, 0.2, 0.0))
        .mirror(Surface::wall(2.4, 1.8, at(0.0, 0.2, 0.0)).look(look))
        .object(Cuboid::from_length(0.5), RED, at(-0.5, 0.2, 0.9))
        .object(Cuboid::from_length(0.4), GREEN, at(0.6, 0.0, 0.6))
        .object(Cuboid::new(6.0, 5.0, 0.1), BLUE, at(0.0, 0.2, -0.6));
    scene.size = UVec2::new(120, 90);
    scene
}

/// The same mirror without holes, and the same place without a mirror.
fn whole_and_none(scene: &Scene) -> (Picture, Picture) {
    let mut whole = scene.clone();
    whole.mirrors[0].look = None;
    let mut none = whole.clone();
    none.mirrors.clear();
    let mut studio = Studio::game(&whole);
    (studio.picture(&whole), studio.picture(&none))
}

/// Opaque in a disc.
fn disc() -> Image {
    let half = SIDE as i32 / 2;
    let is_inside = |i: u32| {
        let (x, y) = ((i % SIDE) as i32 - half, (i / SIDE) as i32 - half);
        x * x + y * y < half * half
    };
    let pixels = 0..SIDE * SIDE;
    let data = pixels.flat_map(|i| [255, 255, 255, if is_inside(i) { 255 } else { 0 }]);
    let mut image = Image::new(
        Extent3d {
            width: SIDE,
            height: SIDE,
            depth_or_array_layers: 1,
        },
        TextureDimension::D2,
        data.collect(),
        TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::default(),
    );
    image.sampler = ImageSampler::nearest();
    image
}

/// The engine's own material with the disc.
fn standard_disc(alpha_mode: AlphaMode) -> Look {
    Look::other(move |entity| {
        let material = entity.world_scope(|world| {
            let disc = world.resource_mut::<Assets<Image>>().add(disc());
            let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
            materials.add(StandardMaterial {
                base_color_texture: Some(disc),
                alpha_mode,
                unlit: true,
                ..default()
            })
        });
        entity.insert(MeshMaterial3d(material));
    })
}

/// Each pixel is that of the mirror or that of the wall behind it, and there are enough of both.
#[track_caller]
fn assert_mixed(picture: &Picture, whole: &Picture, none: &Picture, share: f64, what: &str) {
    let differ = |place: &UVec2| whole.at(place.x, place.y) != none.at(place.x, place.y);
    let places: Vec<UVec2> = picture.places().filter(differ).collect();
    let like = |other: &Picture| {
        let same = |at: &&UVec2| {
            let (a, b) = (picture.at(at.x, at.y), other.at(at.x, at.y));
            (0..3).all(|i| a[i].abs_diff(b[i]) <= TOLERANCE)
        };
        places.iter().filter(same).count()
    };
    let (of_mirror, of_wall) = (like(whole), like(none));
    let total = of_mirror + of_wall;
    assert_eq!(total, places.len(), "{what}: {}", picture.save(what));
    let got = of_mirror as f64 / total as f64;
    assert!(
        (got - share).abs() < 0.06,
        "{what}: {got} of the mirror is there, and not {share}: {}",
        picture.save(what)
    );
}

const DISC: f64 = std::f64::consts::FRAC_PI_4;

#[test]
fn through_the_holes_of_a_masked_mirror_one_sees_what_is_behind_it() {
    let scene = room("masked-mirror", standard_disc(AlphaMode::Mask(0.5)));
    let (whole, none) = whole_and_none(&scene);
    let picture = Studio::game(&scene).picture(&scene);
    assert_mixed(&picture, &whole, &none, DISC, "masked-mirror");
}

/// Sample by sample; at its edge a pixel is a bit of both.
#[test]
fn a_masked_mirror_has_its_holes_with_samples_too() {
    for mode in [AlphaMode::Mask(0.5), AlphaMode::AlphaToCoverage] {
        let mut scene = room("masked-samples", standard_disc(mode));
        scene.msaa = Msaa::Sample4;
        let (whole, none) = whole_and_none(&scene);
        let picture = Studio::game(&scene).picture(&scene);
        for (place, expected) in [
            // The middle of the disc, and a corner of the mesh.
            (UVec2::new(52, 44), &whole),
            (UVec2::new(25, 22), &none),
        ] {
            let [got, expected] = [&picture, expected].map(|it| it.at(place.x, place.y));
            assert_eq!(
                got,
                expected,
                "{mode:?}: {}",
                picture.save("masked-samples")
            );
        }
        assert_ne!(whole.at(25, 22), none.at(25, 22), "the corner is seen");
    }
}

const SHADER: Handle<Shader> = uuid_handle!("8d4b3a0e-0c52-4f5e-9d28-3f0f0f7f1a3c");

/// A material of the user's, that leaves out every other stripe.
#[derive(Asset, TypePath, AsBindGroup, Clone, Default)]
struct Stripes {}

impl Material for Stripes {
    fn fragment_shader() -> ShaderRef {
        SHADER.into()
    }

    fn alpha_mode(&self) -> AlphaMode {
        AlphaMode::Mask(0.5)
    }
}

fn add_stripes(app: &mut App) {
    app.add_plugins(MaterialPlugin::<Stripes>::default());
    let mut shaders = app.world_mut().resource_mut::<Assets<Shader>>();
    let code = "
        #import bevy_pbr::forward_io::VertexOutput
        @fragment
        fn fragment(in: VertexOutput) -> @location(0) vec4<f32> {
            if fract(in.uv.x * 4.0) < 0.5 { discard; }
            return vec4(1.0);
        }";
    let shader = Shader::from_wgsl(code, "stripes.wgsl");
    shaders.insert(SHADER.id(), shader).expect("the id is free");
}

#[test]
fn the_holes_of_any_material_are_holes_of_the_mirror() {
    let stripes = Look::other(|entity| {
        let stripes = entity.world_scope(|world| {
            let mut materials = world.resource_mut::<Assets<Stripes>>();
            materials.add(Stripes {})
        });
        entity.insert(MeshMaterial3d(stripes));
    });
    let scene = room("striped-mirror", stripes).plugin(add_stripes);
    let (whole, none) = whole_and_none(&scene);
    let picture = Studio::game(&scene).picture(&scene);
    assert_mixed(&picture, &whole, &none, 0.5, "striped-mirror");
}

/// The second mirror is seen in the first, with its disc.
#[test]
fn a_masked_mirror_has_its_holes_in_another_mirror_too() {
    let twice = |look: Option<Look>| {
        let mut scene = room("masked-inner", RED);
        scene.mirrors[0].look = None;
        let back = at(0.0, 0.2, 1.4).with_rotation(Quat::from_rotation_y(std::f32::consts::PI));
        let mut surface = Surface::wall(1.2, 1.2, back);
        surface.look = look;
        // Only from its back, seen directly.
        scene
            .mirror(surface)
            .eye(vec3(0.9, 0.5, 1.6), vec3(0.0, 0.3, 0.0))
    };
    let draw = |scene: &Scene| {
        let mut studio = Studio::with(PlanarMirrorPlugin {
            max_bounces: 2,
            ..default()
        });
        studio.picture(scene)
    };
    let whole = draw(&twice(None));
    let mut none = twice(None);
    none.mirrors.pop();
    let none = draw(&none);
    let picture = draw(&twice(Some(standard_disc(AlphaMode::Mask(0.5)))));
    assert_mixed(&picture, &whole, &none, DISC, "masked-inner");
}

/// A mirror that fades is there in so many of its pixels, in the pattern in which its own material
/// fades.
#[test]
fn a_mirror_fades_with_its_visibility_range() {
    let eye = 3.2;
    for (gone, share) in [(0.0, 1.0), (0.25, 0.75), (0.5, 0.5), (1.0, 0.0)] {
        let begin = eye - gone * 2.0;
        let range = VisibilityRange {
            start_margin: 0.0..0.0,
            end_margin: begin..begin + 2.0,
            use_aabb: false,
        };
        let name = format!("fading-mirror-{share}");
        let fading = |look: Option<Look>| {
            let range = range.clone();
            let look = Look::other(move |entity| {
                if let Some(look) = &look {
                    look.apply(entity);
                }
                entity.insert(range.clone());
            });
            let mut scene = room(&name, look);
            // Straight before it, so that its distance is known.
            scene.eye = at(0.0, 0.2, eye).looking_to(Vec3::NEG_Z, Vec3::Y);
            scene
        };
        let scene = fading(None);
        let (whole, none) = whole_and_none(&scene);
        let picture = Studio::game(&scene).picture(&scene);
        assert_mixed(&picture, &whole, &none, share, &name);

        // Under a material that blends, which fades by itself.
        let veil = glass(Color::WHITE, 0.5);
        let scene = fading(Some(veil.clone().into()));
        let mut veiled = scene.clone();
        veiled.mirrors[0].look = Some(veil.into());
        let whole = Studio::game(&veiled).picture(&veiled);
        let picture = Studio::game(&scene).picture(&scene);
        assert_mixed(&picture, &whole, &none, share, &format!("veiled-{name}"));
    }
}
