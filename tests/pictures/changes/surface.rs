//! Meshes, materials and clips that are exchanged, and those that are changed in place.

use bevy::prelude::*;
use bevy_planar_mirror::{MirrorClip, PlanarMirror};

use super::{add, insert, place, remove, room};
use crate::support::{
    live::{assert_each_seen_at_once, of},
    props::{BLUE, MAGENTA, RED, at, glass},
};

/// Upright, turned and moved in the mesh itself: another plane for the same transform.
fn leaning_mesh() -> Mesh {
    let mesh: Mesh = Rectangle::new(2.0, 1.6).into();
    mesh.rotated_by(Quat::from_rotation_x(-0.4))
        .translated_by(vec3(0.2, 0.1, -0.3))
}

#[test]
fn a_mirror_takes_the_plane_of_its_new_mesh_at_once() {
    assert_each_seen_at_once(
        &room("new-mesh"),
        &[
            &|world| {
                let mesh = add(world, leaning_mesh());
                insert(world, "mirror", Mesh3d(mesh));
            },
            &|world| {
                let mesh = add(world, Circle::new(0.9).into());
                insert(world, "mirror", Mesh3d(mesh));
            },
        ],
    );
}

#[test]
fn a_mesh_changed_in_place_changes_the_plane_at_once() {
    fn become_mesh(world: &mut World, name: &str, mesh: Mesh) {
        let id = of::<Mesh3d>(world, name).id();
        let mut meshes = world.resource_mut::<Assets<Mesh>>();
        *meshes.get_mut(id).expect("it is there") = mesh;
    }
    assert_each_seen_at_once(
        &room("changed-mesh"),
        &[
            &|world| become_mesh(world, "mirror", leaning_mesh()),
            &|world| become_mesh(world, "mirror", Rectangle::new(1.5, 2.0).into()),
            // Now it reaches through the plane.
            &|world| become_mesh(world, "ball", Cuboid::new(0.3, 0.4, 2.0).into()),
        ],
    );
}

#[test]
fn a_reflected_object_that_changes_its_material_changes_its_phase_at_once() {
    fn wear(name: &'static str, material: StandardMaterial) -> impl Fn(&mut World) {
        move |world| {
            let material = add(world, material.clone());
            insert(world, name, MeshMaterial3d(material));
        }
    }
    fn become_alpha(world: &mut World, alpha_mode: AlphaMode) {
        let id = of::<MeshMaterial3d<StandardMaterial>>(world, "ball").id();
        let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
        let mut material = materials.get_mut(id).expect("it is there");
        material.alpha_mode = alpha_mode;
        material.base_color = MAGENTA.with_alpha(0.5);
    }
    let opaque = StandardMaterial {
        unlit: true,
        base_color: MAGENTA,
        ..default()
    };
    assert_each_seen_at_once(
        &room("new-material"),
        &[
            &wear("ball", glass(RED, 0.4)),
            &wear("ball", opaque.clone()),
            &wear("pane", opaque),
            &|world| become_alpha(world, AlphaMode::Blend),
            &|world| become_alpha(world, AlphaMode::Mask(0.6)),
            &|world| become_alpha(world, AlphaMode::Opaque),
            &|world| become_alpha(world, AlphaMode::Add),
        ],
    );
}

#[test]
fn a_mirror_is_covered_veiled_and_bare_by_its_material() {
    assert_each_seen_at_once(
        &room("veil"),
        &[
            &|world| {
                let veil = add(world, glass(BLUE, 0.5));
                insert(world, "mirror", MeshMaterial3d(veil));
            },
            &|world| {
                let id = of::<MeshMaterial3d<StandardMaterial>>(world, "mirror").id();
                let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
                materials.get_mut(id).expect("it is there").alpha_mode = AlphaMode::Opaque;
            },
            &|world| {
                let veil = add(world, glass(RED, 0.3));
                insert(world, "mirror", MeshMaterial3d(veil));
            },
            &|world| remove::<MeshMaterial3d<StandardMaterial>>(world, "mirror"),
        ],
    );
}

#[test]
fn clips_are_switched_at_run_time() {
    let clip = |clip| move |world: &mut World| of::<PlanarMirror>(world, "mirror").clip = clip;
    assert_each_seen_at_once(
        &room("clips"),
        &[
            &|world| place(world, "ball", at(0.4, 0.4, -0.15)),
            &clip(MirrorClip::Whole),
            &clip(MirrorClip::Oblique),
        ],
    );
}
