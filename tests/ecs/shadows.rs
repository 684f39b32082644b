//! Where the shadows of directional lights in a mirror come from.

use bevy::{
    camera::visibility::{CascadesVisibleEntities, RenderLayers, VisibilityRange},
    light::{
        CascadeShadowConfig, CascadeShadowConfigBuilder, Cascades, DirectionalLightShadowMap,
        NotShadowCaster, ShadowFilteringMethod, cascade::Cascade,
    },
    prelude::*,
};
use bevy_planar_mirror::{MirrorFigures, MirrorShadows, PlanarMirror};

use super::app::{EYE, MirrorApp, above, floor, mirror_app, target};
use crate::split_mix::SplitMix;

/// A mirror, one that looks into it, and the sun.
struct Lit {
    app: MirrorApp,
    mirror: Entity,
    camera: Entity,
    sun: Entity,
}

fn sun(cascades: usize, first_far: f32, far: f32) -> impl Bundle {
    (
        DirectionalLight {
            shadow_maps_enabled: true,
            ..default()
        },
        CascadeShadowConfigBuilder {
            num_cascades: cascades,
            first_cascade_far_bound: first_far,
            maximum_distance: far,
            ..default()
        }
        .build(),
    )
}

impl Lit {
    fn new(mirror: Transform, eye: Transform) -> Self {
        let mut app = mirror_app();
        let mirror = app.spawn_mirror(mirror);
        let camera = app.spawn_camera(eye);
        let down = Transform::default().looking_to(vec3(1.0, -2.0, -1.0), Vec3::Y);
        let sun = app.spawn((sun(4, 8.0, 100.0), down));
        Self {
            app,
            mirror,
            camera,
            sun,
        }
    }

    /// A cube over a mirror on the floor, in the middle of the picture.
    fn floor() -> Self {
        let mut lit = Self::new(floor(0.0), above());
        lit.app.spawn_cube(0.3, vec3(0.3, 0.3, 0.0));
        lit
    }

    fn choose(&mut self, shadows: MirrorShadows) {
        self.app.of_mut::<PlanarMirror>(self.mirror).shadows = shadows;
        self.app.update();
    }

    /// From where they come, and how many cascades are drawn for it.
    fn figures(&self) -> (MirrorShadows, usize) {
        let view = self.app.world().resource::<MirrorFigures>().views[0];
        (view.shadows, view.cascades)
    }

    fn view(&mut self) -> Entity {
        let (camera, mirror) = (self.camera, self.mirror);
        self.app.view(camera, mirror)
    }

    fn cascades_of(&self, viewer: Entity) -> &[Cascade] {
        &self.app.of::<Cascades>(self.sun).cascades[&viewer]
    }

    /// How many casters there are in the cascades of the mirror.
    fn casters(&mut self) -> usize {
        let view = self.view();
        self.app.of::<CascadesVisibleEntities>(self.sun).entities[&view]
            .iter()
            .map(|cascade| cascade.entities.len())
            .sum()
    }
}

#[test]
fn figures_count_the_shadow_cascades_that_something_seen_reads() {
    let mut lit = Lit::new(default(), EYE);
    lit.app.of_mut::<PlanarMirror>(lit.mirror).shadows = MirrorShadows::Own;
    lit.app.spawn_cube(0.3, vec3(0.3, 0.0, 1.0));
    lit.app.update();
    let (view, camera) = (lit.view(), lit.camera);
    let existing = |lit: &Lit| [camera, view].map(|viewer| lit.cascades_of(viewer).len());
    // All that shows is within eight units. The cascades behind do not exist; the camera has all of
    // its own.
    assert_eq!(lit.figures(), (MirrorShadows::Own, 1));
    assert_eq!(existing(&lit), [4, 1]);
    lit.app.spawn_cube(4.0, vec3(0.0, 0.0, 50.0));
    lit.app.update();
    // The last holds this.
    assert_eq!(lit.figures(), (MirrorShadows::Own, 4));
    assert_eq!(existing(&lit), [4, 4]);
    assert!(lit.casters() > 0);
    lit.choose(MirrorShadows::Off);
    assert_eq!(lit.figures(), (MirrorShadows::Off, 0));
    assert_eq!(existing(&lit), [4, 0]);
    lit.choose(MirrorShadows::Own);
    assert_eq!(existing(&lit), [4, 4]);
    lit.app
        .of_mut::<DirectionalLight>(lit.sun)
        .shadow_maps_enabled = false;
    lit.app.update();
    assert_eq!(lit.figures(), (MirrorShadows::Own, 0));
    lit.app.despawn(lit.sun);
    lit.app.update();
    assert_eq!(lit.figures(), (MirrorShadows::Own, 0));
}

#[test]
fn the_cameras_maps_are_taken_where_they_serve() {
    let mut lit = Lit::floor();
    lit.app.update();
    assert_eq!(lit.figures(), (MirrorShadows::Shared, 0));
    let (view, camera) = (lit.view(), lit.camera);
    assert_eq!(lit.cascades_of(view).len(), 1);
    let matrix = |lit: &Lit, viewer| lit.cascades_of(viewer)[0].clip_from_world;
    assert_eq!(matrix(&lit, view), matrix(&lit, camera));
    // Nothing is drawn into them again.
    assert_eq!(lit.casters(), 0);
    lit.choose(MirrorShadows::Own);
    assert_eq!(lit.figures(), (MirrorShadows::Own, 1));
    assert_ne!(matrix(&lit, view), matrix(&lit, camera));
    assert!(lit.casters() > 0);
}

/// Of each thing only as much as the mirror shows, and of each cascade only the things that are
/// deep enough in the view to read it, have to be in the camera's map.
#[test]
fn the_cameras_maps_serve_for_things_on_a_floor() {
    for (eye, size) in [
        (vec3(0.0, 1.6, 4.0), uvec2(320, 180)),
        (vec3(0.0, 1.6, 4.0), uvec2(160, 180)),
        (vec3(1.5, 1.8, 4.0), uvec2(160, 180)),
    ] {
        let mut app = mirror_app();
        app.spawn_mirror(floor(0.0) * Transform::from_scale(Vec3::splat(1.5)));
        let place = Transform::from_translation(eye).looking_at(vec3(0.0, 0.2, 0.0), Vec3::Y);
        let target = target(&mut app, size);
        app.spawn((Camera3d::default(), target, place));
        app.spawn_cube(1.0, vec3(-0.9, 0.8, 0.2));
        app.spawn_cube(0.6, vec3(0.9, 0.6, 0.3));
        app.spawn_cube(0.5, vec3(0.2, 0.9, 1.0));
        app.spawn((
            sun(2, 6.0, 20.0),
            Transform::from_xyz(1.0, 3.0, 1.5).looking_at(Vec3::ZERO, Vec3::Y),
        ));
        app.update();
        let view = app.world().resource::<MirrorFigures>().views[0];
        assert_eq!(view.shadows, MirrorShadows::Shared, "from {eye}, {size}");
    }
}

/// What a wall shows may lie behind the camera, where no cascade of the camera's is.
#[test]
fn the_cameras_maps_are_not_taken_where_they_end() {
    let mut lit = Lit::new(default(), EYE);
    lit.app.spawn_cube(4.0, vec3(0.0, 0.0, 50.0));
    lit.app.update();
    assert_eq!(lit.figures(), (MirrorShadows::Own, 1));
    // Unless somebody asks for them.
    lit.choose(MirrorShadows::Shared);
    assert_eq!(lit.figures(), (MirrorShadows::Shared, 0));
    let (view, camera) = (lit.view(), lit.camera);
    let last = |viewer| lit.cascades_of(viewer).last().map(|it| it.clip_from_world);
    assert_eq!(last(view), last(camera));
}

#[test]
fn maps_are_not_shared_where_what_throws_shadows_may_differ() {
    let mut lit = Lit::floor();
    let caster = lit.app.spawn_cube(0.2, vec3(0.0, 1.0, 0.0));
    lit.app.insert(caster, VisibilityRange::abrupt(0.0, 100.0));
    lit.app.update();
    assert_eq!(lit.figures().0, MirrorShadows::Own);
    lit.app.insert(caster, NotShadowCaster);
    lit.app.update();
    assert_eq!(lit.figures().0, MirrorShadows::Shared);
}

/// A filter that reaches farther needs more of the camera's map.
#[test]
fn maps_are_shared_as_far_as_the_filter_reaches() {
    let mut lit = Lit::floor();
    lit.app.update();
    assert_eq!(lit.figures().0, MirrorShadows::Shared);
    let camera = lit.camera;
    lit.app.insert(camera, ShadowFilteringMethod::Temporal);
    lit.app.update();
    assert_eq!(lit.figures().0, MirrorShadows::Shared);
    lit.app
        .of_mut::<DirectionalLight>(lit.sun)
        .shadow_normal_bias = 2000.0;
    lit.app.update();
    assert_eq!(lit.figures().0, MirrorShadows::Own);
}

/// A point that shows in a mirror finds in the camera's map what it would find in the mirror's own:
/// each has the point in it, and on the same place in a texel of the same size.
#[test]
fn shared_maps_show_the_same_shadows_texel_for_texel() {
    let (mut shared, mut points) = (0, 0);
    for seed in 0..60 {
        let seen = texels(seed);
        shared += u32::from(seen > 0);
        points += seen;
    }
    // Else nothing is tested.
    assert!(
        shared >= 40 && points > 4000,
        "{shared} scenes, {points} points"
    );
}

/// How many points of a random scene were compared; none if its maps are not shared.
fn texels(seed: u64) -> u32 {
    let mut random = SplitMix::new(seed);
    let mut between = |low: f32, high: f32| low + (high - low) * random.share() as f32;
    let place = floor(0.0) * Transform::from_scale(Vec3::splat(between(0.5, 4.0)));
    let eye = vec3(between(-3.0, 3.0), between(0.5, 4.0), between(3.0, 6.0));
    let eye = Transform::from_translation(eye).looking_at(Vec3::ZERO, Vec3::Y);
    let mut lit = Lit::new(place, eye);
    let (mirror, camera) = (lit.mirror, lit.camera);
    let size = 1 << (6 + seed % 6);
    lit.app.insert_resource(DirectionalLightShadowMap { size });
    let down = vec3(between(-2.0, 2.0), between(-3.0, -0.1), between(-2.0, 2.0));
    let sun = lit.sun;
    lit.app.insert(
        sun,
        (
            Transform::default().looking_to(down, Vec3::Y),
            CascadeShadowConfigBuilder {
                num_cascades: 1 + seed as usize % 4,
                first_cascade_far_bound: between(3.0, 12.0),
                maximum_distance: between(15.0, 60.0),
                ..default()
            }
            .build(),
        ),
    );
    let mut cubes = Vec::new();
    for _ in 0..3 {
        let center = vec3(between(-1.5, 1.5), between(0.1, 1.5), between(-1.5, 1.5));
        let width = between(0.1, 0.8);
        lit.app.spawn_cube(width, center);
        cubes.push((center, width / 2.0));
    }
    lit.choose(MirrorShadows::Own);
    let view = lit.view();
    let own = lit.cascades_of(view).to_vec();
    lit.choose(MirrorShadows::Auto);
    if lit.figures().0 != MirrorShadows::Shared {
        return 0;
    }
    let shared = lit.cascades_of(view);
    assert_eq!(shared.len(), own.len());
    let config = lit.app.of::<CascadeShadowConfig>(sun);
    let world_from_view = lit.app.of::<GlobalTransform>(view).to_matrix();
    let clip_from_view = lit.app.of::<Camera>(camera).clip_from_view();
    let eye = world_from_view.w_axis.truncate();
    let local_from_world = lit.app.of::<GlobalTransform>(mirror).affine().inverse();
    let mut points = 0;
    for (center, half) in cubes {
        for _ in 0..40 {
            let mut along = || between(-half, half);
            let point = center + vec3(along(), along(), along());
            // Where on the mirror's plane it shows, and where in the picture.
            let [from, to] = [eye, point].map(|p| local_from_world.transform_point3(p));
            let on_mirror = from.lerp(to, from.z / (from.z - to.z));
            let in_view = world_from_view.inverse() * point.extend(1.0);
            let clip = clip_from_view * in_view;
            if to.z < 0.0
                || on_mirror.truncate().abs().max_element() > 1.0
                || clip.truncate().truncate().abs().max_element() > clip.w
            {
                continue;
            }
            for index in cascades_read(config, -in_view.z) {
                let [mine, theirs] =
                    [&own[index], &shared[index]].map(|cascade| place_in(cascade, point));
                let is_inside = theirs.abs().max_element() <= 1.0 && theirs.z >= 0.0;
                assert!(is_inside, "seed {seed}: {theirs} of cascade {index}");
                let texels = (mine - theirs).truncate() * (size as f32 / 2.0);
                let off = (texels - texels.round()).abs().max_element();
                assert!(off < 0.01, "seed {seed}: {texels} texels, cascade {index}");
                points += 1;
            }
        }
    }
    points
}

/// Which cascades the engine's shader samples at a depth.
fn cascades_read(config: &CascadeShadowConfig, depth: f32) -> impl Iterator<Item = usize> {
    let bounds = &config.bounds;
    let first = bounds.iter().position(|&far| depth < far);
    let next = first.filter(|&first| {
        first + 1 < bounds.len() && depth >= (1.0 - config.overlap_proportion) * bounds[first]
    });
    first.into_iter().chain(next.map(|first| first + 1))
}

fn place_in(cascade: &Cascade, point: Vec3) -> Vec3 {
    (cascade.clip_from_world * point.extend(1.0)).truncate()
}

/// A light that lights nothing here throws no shadows here.
#[test]
fn a_sun_that_is_hidden_or_on_other_layers_has_no_maps_of_the_mirrors_own() {
    // Behind the camera, where its own maps end.
    let lit = || {
        let mut lit = Lit::new(default(), EYE);
        lit.app.spawn_cube(4.0, vec3(0.0, 0.0, 50.0));
        lit.app.update();
        lit
    };
    assert_eq!(lit().figures(), (MirrorShadows::Own, 1));
    let changes: [fn(&mut MirrorApp, Entity); 2] = [
        |app, sun| app.insert(sun, Visibility::Hidden),
        |app, sun| app.insert(sun, RenderLayers::layer(3)),
    ];
    for change in changes {
        let mut lit = lit();
        change(&mut lit.app, lit.sun);
        lit.app.update();
        assert_eq!(lit.figures(), (MirrorShadows::Shared, 0));
    }
}

/// Of a view that Bevy does not see it cannot tell what is in range.
#[test]
fn what_is_in_range_throws_its_shadow_in_any_mirror() {
    let mut lit = Lit::floor();
    let caster = lit.app.spawn_cube(0.3, vec3(-0.2, 0.6, 0.0));
    lit.choose(MirrorShadows::Own);
    let all = lit.casters();
    for (range, is_there) in [(100.0, true), (1.0, false)] {
        lit.app.insert(caster, VisibilityRange::abrupt(0.0, range));
        lit.app.update();
        let expected = if is_there { all } else { all - 1 };
        assert_eq!(lit.casters(), expected, "range {range}");
    }
}
