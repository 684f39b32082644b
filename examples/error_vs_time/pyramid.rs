//! What of an object is seen in a mirror at all, in f64 and with no code of the library: cut at the
//! mirror's plane and at the sides of the pyramid from the reflected eye through the mirror's frame.

use bevy::math::DVec3;

use crate::{
    lens::{Eye, Lens},
    quad::Quad,
    support::{
        cut::{Cut, Plane, cut},
        scene::{Object, Scene, exact},
    },
};

/// The planes through the reflected eye and the edges of the first mirror; the mirror is on their
/// kept side.
pub fn sides(scene: &Scene) -> Vec<Plane> {
    let quad = Quad::of(&scene.mirrors[0]);
    let plane = quad.plane();
    let along: Box<dyn Fn(DVec3) -> DVec3> = match Lens::new(scene).eye {
        Eye::At(eye) => {
            let reflected = plane.reflect(eye);
            Box::new(move |corner| corner - reflected)
        }
        Eye::Along(direction) => {
            let reflected = plane.reflect_direction(direction);
            Box::new(move |_| reflected)
        }
    };
    let corners = quad.corners();
    (0..4)
        .map(|i| {
            let (a, b) = (corners[i], corners[(i + 1) % 4]);
            let side = Plane::through(a, (b - a).cross(along(a)));
            if side.height(quad.center) < 0.0 {
                Plane::through(a, -side.normal)
            } else {
                side
            }
        })
        .collect()
}

/// What of an object is on the kept side of all planes.
pub fn within(object: &Object, planes: &[Plane]) -> Option<Object> {
    planes.iter().try_fold(object.clone(), |object, plane| {
        match cut(&object.mesh, exact(&object.transform), *plane) {
            Cut::Whole => Some(object),
            Cut::Part(mesh) => Some(Object {
                mesh: *mesh,
                ..object
            }),
            Cut::Nothing => None,
        }
    })
}
