//! Where a point of the world is on the screen, in f64 and with no code of the library.

use bevy::{
    math::{DMat4, DVec2, DVec3, DVec4},
    prelude::*,
};

use crate::{
    quad::Quad,
    support::{
        cut::Plane,
        scene::{Scene, exact},
    },
};

/// A camera as seen from outside: world to pixels and back.
#[derive(Clone, Copy)]
pub struct Lens {
    clip_from_world: DMat4,
    world_from_clip: DMat4,
    pub size: DVec2,
    pub eye: Eye,
}

#[derive(Clone, Copy)]
pub enum Eye {
    At(DVec3),
    /// Of an orthographic camera: the direction it looks along.
    Along(DVec3),
}

impl Lens {
    pub fn new(scene: &Scene) -> Self {
        let mut projection = scene.projection.clone();
        projection.update(scene.size.x as f32, scene.size.y as f32);
        let clip_from_view = projection.get_clip_from_view().as_dmat4();
        let world_from_view = exact(&scene.eye);
        Self {
            clip_from_world: clip_from_view * DMat4::from(world_from_view.inverse()),
            world_from_clip: DMat4::from(world_from_view) * clip_from_view.inverse(),
            size: scene.size.as_dvec2(),
            eye: match projection {
                Projection::Orthographic(_) => Eye::Along(-world_from_view.matrix3.z_axis),
                _ => Eye::At(world_from_view.translation),
            },
        }
    }

    /// The place on the screen, in pixels from the top left; `None` before the near plane.
    pub fn project(&self, point: DVec3) -> Option<DVec2> {
        let clip = self.clip_from_world * point.extend(1.0);
        (clip.w > 0.0 && clip.z <= clip.w).then(|| {
            let ndc = clip.truncate().truncate() / clip.w;
            (ndc * DVec2::new(1.0, -1.0) + 1.0) / 2.0 * self.size
        })
    }

    /// Where the line of sight through a place on the screen meets a plane, before the eye.
    pub fn meets(&self, place: DVec2, plane: &Plane) -> Option<DVec3> {
        let ndc = (place / self.size * 2.0 - 1.0) * DVec2::new(1.0, -1.0);
        // The far end of the line, which an infinite perspective has at infinity.
        let far = self.world_from_clip * DVec4::new(ndc.x, ndc.y, 0.0, 1.0);
        let (start, direction) = match self.eye {
            Eye::At(eye) => (eye, far.truncate() - eye * far.w),
            Eye::Along(direction) => (far.truncate() / far.w, direction),
        };
        let distance = -plane.height(start) / plane.normal.dot(direction);
        let ahead = matches!(self.eye, Eye::Along(_)) || distance > 0.0;
        (ahead && distance.is_finite()).then(|| start + direction * distance)
    }

    /// The size of a pixel in world units: for each unit of distance from the eye, and besides.
    pub fn pixel(&self) -> DVec2 {
        let height = self.clip_from_world.row(1).truncate().length();
        let pixel = 2.0 / (height * self.size.y);
        match self.eye {
            Eye::At(_) => DVec2::new(pixel, 0.0),
            Eye::Along(_) => DVec2::new(0.0, pixel),
        }
    }

    /// Places of a raster over the screen at which a quad shows.
    pub fn raster(&self, quad: &Quad) -> Vec<DVec2> {
        const STEPS: u32 = 96;
        let plane = quad.plane();
        (0..STEPS * STEPS)
            .map(|i| DVec2::new(f64::from(i % STEPS), f64::from(i / STEPS)) + 0.5)
            .map(|step| step / f64::from(STEPS) * self.size)
            .filter(|place| self.shows(*place, quad, &plane))
            .collect()
    }

    /// Whether a quad covers a place on the screen.
    pub fn shows(&self, place: DVec2, quad: &Quad, plane: &Plane) -> bool {
        self.meets(place, plane)
            .is_some_and(|point| quad.contains(point) && self.project(point).is_some())
    }
}

#[cfg(test)]
mod tests {
    use bevy::math::DVec3;

    use super::*;
    use crate::support::scene::Surface;

    fn scenes() -> Vec<Scene> {
        let perspective = Scene::new("perspective").eye(Vec3::new(1.0, 2.0, 5.0), Vec3::ZERO);
        let mut orthographic = perspective.clone();
        orthographic.projection = OrthographicProjection {
            scaling_mode: bevy::camera::ScalingMode::FixedVertical {
                viewport_height: 4.0,
            },
            ..OrthographicProjection::default_3d()
        }
        .into();
        vec![perspective, orthographic]
    }

    #[test]
    fn a_place_on_the_screen_meets_the_point_that_projects_there() {
        for scene in scenes() {
            let lens = Lens::new(&scene);
            let plane = Plane::through(DVec3::ZERO, DVec3::new(0.1, 0.9, 0.3));
            for place in [DVec2::new(80.0, 70.0), DVec2::new(3.5, 110.0)] {
                let point = lens.meets(place, &plane).expect("the plane is in view");
                assert!(plane.height(point).abs() < 1e-9, "{}", scene.name);
                let back = lens.project(point).expect("the point is in view");
                assert!(
                    back.distance(place) < 1e-6,
                    "{}: {place} came back as {back}",
                    scene.name
                );
            }
        }
    }

    #[test]
    fn the_point_looked_at_is_in_the_middle() {
        for scene in scenes() {
            let middle = Lens::new(&scene).project(DVec3::ZERO).expect("in view");
            // The f32 rotation of the camera is good to a thousandth of a pixel.
            assert!(middle.distance(DVec2::new(80.0, 60.0)) < 1e-3, "{middle}");
        }
    }

    #[test]
    fn a_pixel_is_as_large_as_two_neighbors_are_apart() {
        for mut scene in scenes() {
            scene = scene.eye(Vec3::new(0.0, 0.0, 7.0), Vec3::ZERO);
            let lens = Lens::new(&scene);
            let plane = Plane::through(DVec3::ZERO, DVec3::Z);
            let at = |y| lens.meets(DVec2::new(80.0, y), &plane).expect("in view");
            let apart = at(60.0).distance(at(61.0));
            let pixel = lens.pixel();
            let expected = pixel.x * 7.0 + pixel.y;
            assert!((apart / expected - 1.0).abs() < 1e-6, "{apart} {expected}");
        }
    }

    #[test]
    fn what_is_before_the_near_plane_does_not_show() {
        for scene in scenes() {
            let lens = Lens::new(&scene.eye(Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO));
            assert!(lens.project(DVec3::new(0.0, 0.0, 4.8)).is_some());
            assert!(lens.project(DVec3::new(0.0, 0.0, 5.01)).is_none());
        }
        let scene = scenes().remove(0);
        let lens = Lens::new(&scene.eye(Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO));
        assert!(lens.project(DVec3::new(0.0, 0.0, 4.95)).is_none());
    }

    #[test]
    fn the_raster_of_a_quad_covers_its_share_of_the_screen() {
        // 4 x 3 units of a view 4 units high and 16/3 wide.
        let mut scene = scenes().remove(1).eye(Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO);
        scene.size = UVec2::new(160, 120);
        let quad = Quad::of(&Surface::wall(4.0, 3.0, Transform::default()));
        let raster = Lens::new(&scene).raster(&quad);
        let share = raster.len() as f64 / f64::from(96 * 96);
        assert!((share - 12.0 / (4.0 * 16.0 / 3.0)).abs() < 0.02, "{share}");
    }
}
