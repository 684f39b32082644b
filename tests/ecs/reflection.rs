//! The components as editors and scenes see them: by reflection.

use std::any::TypeId;

use bevy::{
    ecs::reflect::AppTypeRegistry,
    prelude::*,
    reflect::{
        FromReflect, GetTypeRegistration, TypeRegistry,
        serde::{TypedReflectDeserializer, TypedReflectSerializer},
    },
};
use bevy_planar_mirror::{
    MirrorClip, MirrorPlane, MirrorShadows, MirrorState, MirrorStatus, NoMirrors, NotDrawn,
    PlanarMirror,
    status::{self, CameraStatus},
};
use serde::de::DeserializeSeed;

use super::app::{EYE, MirrorApp, OBLIQUE, PLAIN, mirror_app};

fn registry(app: &MirrorApp) -> AppTypeRegistry {
    app.world().resource::<AppTypeRegistry>().clone()
}

fn reflect_component<T: 'static>(registry: &TypeRegistry) -> &ReflectComponent {
    registry
        .get_type_data::<ReflectComponent>(TypeId::of::<T>())
        .expect("it is registered as a component")
}

#[test]
fn the_components_and_all_that_they_hold_are_registered() {
    let app = mirror_app();
    let registry = registry(&app);
    let registry = registry.read();
    reflect_component::<PlanarMirror>(&registry);
    reflect_component::<NoMirrors>(&registry);
    reflect_component::<MirrorStatus>(&registry);
    for id in [
        TypeId::of::<MirrorPlane>(),
        TypeId::of::<MirrorClip>(),
        TypeId::of::<CameraStatus>(),
        TypeId::of::<MirrorState>(),
        TypeId::of::<status::Projection>(),
        TypeId::of::<NotDrawn>(),
    ] {
        assert!(registry.get(id).is_some());
    }
    for id in [
        TypeId::of::<PlanarMirror>(),
        TypeId::of::<NoMirrors>(),
        TypeId::of::<MirrorStatus>(),
    ] {
        assert!(registry.get_type_data::<ReflectDefault>(id).is_some());
    }
}

/// Through the component's own reflection onto another entity and back.
fn copied<T: Component + Clone>(app: &mut MirrorApp, value: T) -> T {
    let registry = registry(app);
    let registry = registry.read();
    let reflect = reflect_component::<T>(&registry);
    let source = app.spawn(value);
    let dynamic = reflect
        .reflect(app.world().entity(source))
        .expect("it has one")
        .to_dynamic();
    let copy = app.spawn(());
    let world = app.world_mut();
    reflect.insert(
        &mut world.entity_mut(copy),
        dynamic.as_partial_reflect(),
        &registry,
    );
    let result = app.of::<T>(copy).clone();
    app.despawn(source);
    app.despawn(copy);
    result
}

fn mirrors() -> Vec<PlanarMirror> {
    vec![
        PlanarMirror::default(),
        PlanarMirror {
            plane: MirrorPlane::Local {
                point: vec3(1.0, 2.0, 3.0),
                normal: vec3(0.0, 0.6, 0.8),
            },
            clip: MirrorClip::Oblique,
            shadows: MirrorShadows::Off,
        },
        PlanarMirror {
            clip: MirrorClip::Whole,
            ..default()
        },
    ]
}

/// A status with an entry of every kind.
fn full_status() -> MirrorStatus {
    let states = [
        MirrorState::Drawn(status::Projection::Plain),
        MirrorState::Drawn(status::Projection::Oblique),
        MirrorState::NotDrawn(NotDrawn::TooThin),
    ];
    let cameras = states
        .into_iter()
        .zip(1..)
        .map(|(state, index)| CameraStatus {
            camera: Entity::from_raw_u32(index).expect("it is a valid index"),
            state,
        })
        .collect();
    MirrorStatus { cameras }
}

#[test]
fn components_are_inserted_by_reflection() {
    let mut app = mirror_app();
    for mirror in mirrors() {
        assert_eq!(copied(&mut app, mirror.clone()), mirror);
    }
    let status = full_status();
    assert_eq!(copied(&mut app, status.clone()), status);
    copied(&mut app, NoMirrors);
}

#[test]
fn a_mirror_inserted_by_reflection_is_drawn_and_can_be_edited() {
    let mut app = mirror_app();
    let camera = app.spawn_camera(EYE);
    let mesh = app.mesh(Rectangle::new(2.0, 2.0));
    let mirror = app.spawn(Mesh3d(mesh));
    let registry = registry(&app);
    let registry = registry.read();
    let reflect = reflect_component::<PlanarMirror>(&registry);
    let insert = |app: &mut MirrorApp, value: &PlanarMirror| {
        let mut entity = app.world_mut().entity_mut(mirror);
        reflect.insert(&mut entity, value.as_partial_reflect(), &registry);
    };
    insert(&mut app, &PlanarMirror::default());
    app.update();
    app.assert_state(mirror, camera, PLAIN);
    // As an inspector writes a field.
    let mut entity = app.world_mut().entity_mut(mirror);
    let mut value = reflect.reflect_mut(&mut entity).expect("it has one");
    let field = value.reflect_path_mut("clip").expect("it is a field");
    field.apply(&MirrorClip::Oblique);
    app.update();
    app.assert_state(mirror, camera, OBLIQUE);
    let mut entity = app.world_mut().entity_mut(mirror);
    reflect.remove(&mut entity);
    app.update();
    assert!(app.views().is_empty());
}

fn through_json<T>(value: &T) -> T
where
    T: Reflect + FromReflect + GetTypeRegistration,
{
    let app = mirror_app();
    let registry = registry(&app);
    let registry = registry.read();
    let text = serde_json::to_string(&TypedReflectSerializer::new(
        value.as_partial_reflect(),
        &registry,
    ))
    .expect("it can be written");
    let registration = registry.get(TypeId::of::<T>()).expect("it is registered");
    let read = TypedReflectDeserializer::new(registration, &registry)
        .deserialize(&mut serde_json::Deserializer::from_str(&text))
        .expect("it can be read");
    T::from_reflect(&*read).expect("it is complete")
}

#[test]
fn components_go_through_a_file() {
    for mirror in mirrors() {
        assert_eq!(through_json(&mirror), mirror);
    }
    through_json(&NoMirrors);
}
