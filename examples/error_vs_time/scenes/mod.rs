//! The scenes of the report. Each is written once, as data, and drawn by every technique.

mod crowds;
mod lenses;
mod rooms;
mod still_life;
mod surfaces;

use crate::support::{extremes::KINDS, scene::Scene, wild};

/// One scene of the report.
#[derive(Clone)]
pub struct Case {
    pub name: String,
    /// What it is for.
    pub about: String,
    /// It has one mirror.
    pub scene: Scene,
    /// The same picture by easier numbers, where single precision does not show: for the
    /// reference. `None` where the scene itself is easy.
    pub exact: Option<Scene>,
    /// The camera's parent is scaled by this.
    pub camera_scale: f32,
    /// By how many pixels things may be displaced before they count as lost or out of order.
    pub slack: u32,
    /// Which objects lie just before the next one: their order is what depth has to resolve.
    pub layers: Vec<usize>,
    /// One of those of `--quick`.
    pub quick: bool,
}

impl Case {
    fn new(name: &str, about: &str, scene: Scene) -> Self {
        Self {
            name: name.to_owned(),
            about: about.to_owned(),
            scene,
            exact: None,
            camera_scale: 1.0,
            slack: 1,
            layers: Vec::new(),
            quick: false,
        }
    }

    fn quick(mut self) -> Self {
        self.quick = true;
        self
    }

    /// The scene to take the reference from.
    pub fn exact(&self) -> &Scene {
        self.exact.as_ref().unwrap_or(&self.scene)
    }

    /// In pictures of this height; the width is by the scene's own ratio.
    pub fn sized(mut self, height: u32) -> Self {
        for scene in std::iter::once(&mut self.scene).chain(&mut self.exact) {
            let size = scene.size;
            // Very wide and very high pictures keep about the number of pixels of a usual one.
            let ratio = f64::from(size.x) / f64::from(size.y);
            let area = f64::from(height).powi(2) * 16.0 / 9.0;
            let y = if (0.2..=5.0).contains(&ratio) {
                f64::from(height)
            } else {
                (area / ratio).sqrt() / 2.0
            };
            scene.size.y = y.round().max(1.0) as u32;
            scene.size.x = (y.round() * ratio).round().max(1.0) as u32;
        }
        self
    }
}

/// A random scene at the extremes, one of those that the picture tests draw.
///
/// Every fifth of them is far away from the origin, and has no easier numbers for its reference:
/// rounding shows in that as well.
pub fn random(seed: u64) -> Case {
    let kind = KINDS[(seed % KINDS.len() as u64) as usize];
    let scene = wild::scene(kind, seed);
    Case::new(&format!("{RANDOM}{seed}"), &format!("{kind:?}"), scene)
}

/// What the names of random scenes begin with.
const RANDOM: &str = "random-";

/// The scene of that name.
pub fn named(name: &str) -> Option<Case> {
    match name.strip_prefix(RANDOM) {
        Some(seed) => Some(random(seed.parse().ok()?)),
        None => all().into_iter().find(|case| case.name == name),
    }
}

/// All scenes with a name of their own, in the order of the report.
pub fn all() -> Vec<Case> {
    let mut cases = rooms::cases();
    cases.extend(lenses::cases());
    cases.extend(surfaces::cases());
    cases.extend(crowds::cases());
    cases
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{lens::Lens, quad::Quad};

    #[test]
    fn every_scene_has_a_name_of_its_own_and_one_mirror() {
        let mut cases = all();
        cases.extend((0..10).map(random));
        for (index, case) in cases.iter().enumerate() {
            assert_eq!(case.scene.mirrors.len(), 1, "{}", case.name);
            assert!(!case.about.is_empty());
            assert!(cases[..index].iter().all(|other| other.name != case.name));
        }
        assert!(cases.iter().any(|case| case.quick));
    }

    #[test]
    fn every_mirror_is_seen_from_its_front_and_covers_some_of_the_screen() {
        for case in all() {
            let case = case.sized(180);
            let scene = case.exact();
            let quad = Quad::of(&scene.mirrors[0]);
            let height = quad.plane().height(scene.eye.translation.as_dvec3());
            assert!(height > 0.0, "{}: the eye is {height} before it", case.name);
            let share = Lens::new(scene).raster(&quad).len() as f64 / f64::from(96 * 96);
            assert!(share > 0.005, "{}: it covers only {share}", case.name);
        }
    }

    #[test]
    fn a_sized_scene_keeps_its_ratio() {
        for case in all() {
            let before = case.scene.size.as_dvec2();
            let after = case.sized(270).scene.size.as_dvec2();
            let change = (after.x / after.y) / (before.x / before.y);
            assert!((change - 1.0).abs() < 0.1, "{after}");
            assert!(after.max_element() <= 4096.0);
        }
    }
}
