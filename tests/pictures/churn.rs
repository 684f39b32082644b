//! Frames in which anything may happen: nothing breaks, and nothing of it stays behind.

use std::collections::BTreeSet;

use bevy::{
    asset::RenderAssetUsages,
    camera::{Hdr, RenderTarget, ScalingMode},
    core_pipeline::tonemapping::Tonemapping,
    light::DirectionalLightShadowMap,
    prelude::*,
    render::render_resource::Extent3d,
};
use bevy_planar_mirror::{MirrorClip, MirrorStatus, NoMirrors, PlanarMirror};

use crate::support::{
    count::count,
    props::{BLUE, GREEN, RED, YELLOW, glass, lamp, lit, sun},
    random::Random,
    set::clear,
    stage::Stage,
};

/// What there was of a round, and what is left when everything of it has been despawned.
#[derive(Debug, PartialEq)]
struct Round {
    states: BTreeSet<String>,
    main_entities: u32,
    render_entities: u32,
    pipelines: usize,
}

fn round(stage: &mut Stage) -> Round {
    let mut states = BTreeSet::new();
    let mut churn = Churn::new(stage);
    // There are two rounds.
    for _ in 0..count(100, 1000) {
        churn.change();
        churn.stage.frame();
        states.extend(churn.states());
    }
    clear(stage);
    for _ in 0..5 {
        stage.frame();
    }
    Round {
        states,
        main_entities: stage.world().entities().count_spawned(),
        render_entities: stage.render_entities(),
        pipelines: stage.pipeline_labels().len(),
    }
}

#[test]
fn random_changes_break_nothing_and_leave_nothing_behind() {
    let mut stage = Stage::game_with_mirrors();
    // Small, for the sake of a processor that draws.
    let shadows = DirectionalLightShadowMap { size: 128 };
    stage.world().insert_resource(shadows);
    let first = round(&mut stage);
    for state in [
        "plain",
        "oblique",
        "hidden",
        "not flat",
        "main world",
        "not in front",
        "out of view",
    ] {
        let met = first.states.iter().any(|met| met.contains(state));
        assert!(met, "no mirror was ever {state}: {first:?}");
    }
    // The same again: what it needs is there, and nothing is needed twice.
    assert_eq!(round(&mut stage), first);
}

/// A scene, and the one generator of all that happens to it.
struct Churn<'a> {
    stage: &'a mut Stage,
    random: Random,
    mirrors: Vec<Entity>,
    cameras: Vec<Entity>,
    lights: Vec<Entity>,
    objects: Vec<Entity>,
}

impl<'a> Churn<'a> {
    fn new(stage: &'a mut Stage) -> Self {
        let mut churn = Self {
            stage,
            random: Random::new(1),
            mirrors: Vec::new(),
            cameras: Vec::new(),
            lights: Vec::new(),
            objects: Vec::new(),
        };
        churn.add_camera();
        for _ in 0..3 {
            churn.add_mirror();
        }
        for _ in 0..4 {
            churn.add_object();
        }
        churn
    }

    /// One to three changes.
    fn change(&mut self) {
        for _ in 0..=self.random.below(3) {
            match self.random.below(10) {
                0 if self.mirrors.len() < 5 => self.add_mirror(),
                1 if self.cameras.len() < 3 => self.add_camera(),
                2 if self.lights.len() < 3 => self.add_light(),
                3 => self.despawn(),
                4 | 5 => self.change_camera(),
                6 => self.change_light(),
                7 => self.change_object(),
                _ => self.change_mirror(),
            }
        }
    }

    /// What the statuses say now.
    fn states(&mut self) -> BTreeSet<String> {
        let world = self.stage.world();
        let mut statuses = world.query::<&MirrorStatus>();
        let seen = statuses.iter(world).flat_map(|status| &status.cameras);
        seen.map(|seen| seen.state.to_string()).collect()
    }

    fn add_mirror(&mut self) {
        let (mesh, place) = (self.surface(), self.place());
        let mirror = (Mesh3d(self.add(mesh)), place, PlanarMirror::default());
        self.mirrors.push(self.stage.world().spawn(mirror).id());
    }

    fn add_camera(&mut self) {
        let size = self.size();
        let target = RenderTarget::from(self.stage.target(size));
        let camera = (Camera3d::default(), target, Msaa::Off, self.eye());
        self.cameras.push(self.stage.world().spawn(camera).id());
    }

    fn add_light(&mut self) {
        let shadows = self.is_heads();
        let light = if self.is_heads() {
            self.stage.world().spawn(sun(shadows)).id()
        } else {
            let place = self
                .random
                .within(vec3(-2.0, 1.0, 0.5), vec3(2.0, 3.0, 3.0));
            self.stage.world().spawn(lamp(place, false)).id()
        };
        self.lights.push(light);
    }

    fn add_object(&mut self) {
        let (mesh, place) = (self.add(Cuboid::from_length(0.6).into()), self.place());
        let material = MeshMaterial3d(self.material());
        let object = (Mesh3d(mesh), material, place);
        self.objects.push(self.stage.world().spawn(object).id());
    }

    fn despawn(&mut self) {
        let kind = match self.random.below(3) {
            0 => &mut self.mirrors,
            1 => &mut self.cameras,
            _ => &mut self.lights,
        };
        if !kind.is_empty() {
            let index = self.random.below(kind.len() as u64) as usize;
            self.stage.world().despawn(kind.swap_remove(index));
        }
    }

    fn change_mirror(&mut self) {
        let Some(mirror) = pick(&mut self.random, &self.mirrors) else {
            return;
        };
        match self.random.below(7) {
            0 => {
                let visibility = self.visibility();
                self.insert(mirror, visibility);
            }
            1 => {
                let place = self.place();
                self.insert(mirror, place);
            }
            2 => {
                let surface = self.surface();
                let mesh = Mesh3d(self.add(surface));
                self.insert(mirror, mesh);
            }
            3 => {
                let material = MeshMaterial3d(self.material());
                self.toggle(mirror, material);
            }
            4 => self.toggle(mirror, PlanarMirror::default()),
            5 => {
                let clips = [MirrorClip::Auto, MirrorClip::Oblique, MirrorClip::Whole];
                let clip = clips[self.random.below(3) as usize];
                self.insert(mirror, PlanarMirror { clip, ..default() });
            }
            // Half of it may be behind an object that goes through it.
            _ => {
                let object = pick(&mut self.random, &self.objects);
                let at = object.and_then(|object| self.stage.world().get::<Transform>(object));
                if let Some(&at) = at {
                    self.insert(mirror, at);
                }
            }
        }
    }

    fn change_camera(&mut self) {
        let Some(camera) = pick(&mut self.random, &self.cameras) else {
            return;
        };
        match self.random.below(7) {
            0 => {
                let eye = self.eye();
                self.insert(camera, eye);
            }
            1 => {
                let samples = [Msaa::Off, Msaa::Sample4];
                let samples = samples[self.random.below(2) as usize];
                self.insert(camera, samples);
            }
            2 => self.toggle(camera, Hdr),
            3 => {
                let maps = [Tonemapping::None, Tonemapping::Reinhard];
                let map = maps[self.random.below(2) as usize];
                self.insert(camera, map);
            }
            4 => self.toggle(camera, NoMirrors),
            5 => {
                let projection = if self.is_heads() {
                    OrthographicProjection {
                        scaling_mode: ScalingMode::FixedVertical {
                            viewport_height: 3.0,
                        },
                        ..OrthographicProjection::default_3d()
                    }
                    .into()
                } else {
                    Projection::default()
                };
                self.insert(camera, projection);
            }
            _ => self.resize(camera),
        }
    }

    fn resize(&mut self, camera: Entity) {
        let size = self.size();
        let world = self.stage.world();
        let target = world.get::<RenderTarget>(camera).and_then(|target| {
            let image = target.as_image()?;
            Some(image.clone())
        });
        let target = target.expect("every camera here draws into an image");
        let mut images = world.resource_mut::<Assets<Image>>();
        images
            .get_mut(&target)
            .expect("it is there")
            .resize(Extent3d {
                width: size.x,
                height: size.y,
                ..default()
            });
    }

    fn change_light(&mut self) {
        let Some(light) = pick(&mut self.random, &self.lights) else {
            return;
        };
        let visibility = self.visibility();
        // A sun is not hidden: of one that casts shadows the engine itself leaves something behind then.
        if let Some(mut sun) = self.stage.world().get_mut::<DirectionalLight>(light) {
            sun.shadow_maps_enabled = !sun.shadow_maps_enabled;
        } else {
            self.insert(light, visibility);
        }
    }

    fn change_object(&mut self) {
        let Some(object) = pick(&mut self.random, &self.objects) else {
            return;
        };
        if self.is_heads() {
            let place = self.place();
            self.insert(object, place);
        } else {
            let material = MeshMaterial3d(self.material());
            self.insert(object, material);
        }
    }

    fn insert(&mut self, entity: Entity, bundle: impl Bundle) {
        self.stage.world().entity_mut(entity).insert(bundle);
    }

    /// Takes the component off, or puts it on.
    fn toggle<C: Component>(&mut self, entity: Entity, component: C) {
        let mut entity = self.stage.world().entity_mut(entity);
        if entity.contains::<C>() {
            entity.remove::<C>();
        } else {
            entity.insert(component);
        }
    }

    fn add<A: Asset>(&mut self, asset: A) -> Handle<A> {
        self.stage.world().resource_mut::<Assets<A>>().add(asset)
    }

    fn is_heads(&mut self) -> bool {
        self.random.below(2) == 0
    }

    fn visibility(&mut self) -> Visibility {
        if self.is_heads() {
            Visibility::Hidden
        } else {
            Visibility::Inherited
        }
    }

    fn size(&mut self) -> UVec2 {
        let sizes = [uvec2(64, 48), uvec2(40, 40), uvec2(17, 50), uvec2(80, 30)];
        sizes[self.random.below(4) as usize]
    }

    /// Near the origin, facing the eyes more or less.
    fn place(&mut self) -> Transform {
        let turn = Quat::from_rotation_y(self.random.between(-1.0, 1.0));
        let place = self
            .random
            .within(vec3(-1.5, -0.5, -1.0), vec3(1.5, 0.8, 1.0));
        Transform::from_translation(place).with_rotation(turn)
    }

    /// Before the mirrors, mostly.
    fn eye(&mut self) -> Transform {
        let place = self
            .random
            .within(vec3(-1.5, 0.0, -1.0), vec3(1.5, 1.5, 4.0));
        Transform::from_translation(place).looking_at(Vec3::ZERO, Vec3::Y)
    }

    /// Mostly flat, and in reach.
    fn surface(&mut self) -> Mesh {
        match self.random.below(6) {
            0 => Circle::new(0.8).into(),
            1 => Cuboid::from_length(0.5).into(),
            2 => {
                let mut mesh = Mesh::from(Rectangle::new(1.0, 1.5));
                mesh.asset_usage = RenderAssetUsages::RENDER_WORLD;
                mesh
            }
            3 => Mesh::from(Rectangle::new(1.0, 1.5))
                .rotated_by(Quat::from_rotation_x(-0.3))
                .translated_by(vec3(0.2, 0.0, -0.3)),
            _ => Rectangle::new(2.0, 1.5).into(),
        }
    }

    fn material(&mut self) -> Handle<StandardMaterial> {
        let color = [RED, GREEN, BLUE, YELLOW][self.random.below(4) as usize];
        let material = match self.random.below(4) {
            0 => glass(color, 0.5),
            1 => StandardMaterial {
                base_color: color.with_alpha(0.6),
                alpha_mode: AlphaMode::Mask(0.5),
                ..default()
            },
            _ => lit(color),
        };
        self.add(material)
    }
}

fn pick(random: &mut Random, from: &[Entity]) -> Option<Entity> {
    let index = random.below(from.len().max(1) as u64) as usize;
    from.get(index).copied()
}
