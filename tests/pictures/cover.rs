//! Walls that hide a mirror leave its view out, and change no pixel by that.
//!
//! The reference are the same walls with meshes that the plugin cannot read.

use bevy::prelude::*;
use bevy_planar_mirror::{MirrorState, MirrorStatus, NotDrawn};

use super::changes::sunny_room;
use crate::support::{
    live::{Live, named, of},
    props::{BLUE, at, lit},
    random::Random,
    scene::Scene,
};

const WALLS: usize = 3;
const FRAMES: u16 = 12;

/// Slabs before the mirror, each askew.
struct Slabs {
    sizes: [Vec3; WALLS],
    places: [Transform; WALLS],
    drift: Vec3,
}

impl Slabs {
    fn new(seed: u64) -> Self {
        let random = &mut Random::new(seed);
        let mut within = |low, high| random.between(low, high);
        let sizes = [(); WALLS].map(|()| vec3(within(0.7, 2.2), within(1.0, 2.2), 0.1));
        let mut depth = 0.9;
        let places = [(); WALLS].map(|()| {
            depth += 0.4;
            let turn = [0.4, 0.3, 0.2].map(|most| within(-most, most));
            at(within(-0.3, 0.9), within(0.2, 0.8), depth).with_rotation(Quat::from_euler(
                EulerRot::YXZ,
                turn[0],
                turn[1],
                turn[2],
            ))
        });
        let drift = vec3(within(-0.04, 0.04), within(-0.02, 0.02), 0.0);
        Self {
            sizes,
            places,
            drift,
        }
    }

    fn scene(&self, name: &str, is_readable: bool) -> Scene {
        let mut scene = sunny_room(name);
        for (index, size) in self.sizes.iter().enumerate() {
            let mut mesh = Cuboid::from_size(*size).mesh().build();
            if !is_readable {
                mesh.duplicate_vertices();
            }
            let look = named(NAMES[index], lit(BLUE));
            scene = scene.object(mesh, look, self.places[index]);
        }
        scene
    }

    fn drift(&self, world: &mut World) {
        for (index, name) in NAMES.iter().enumerate() {
            // Not all the same way.
            let step = self.drift * if index == 1 { -1.0 } else { 1.0 };
            of::<Transform>(world, name).translation += step;
        }
    }
}

const NAMES: [&str; WALLS] = ["wall-0", "wall-1", "wall-2"];

fn state(live: &mut Live) -> MirrorState {
    let camera = live.camera;
    let status = of::<MirrorStatus>(live.world(), "mirror");
    status.of(camera).expect("the camera may see it")
}

#[test]
fn walls_that_hide_a_mirror_change_no_pixel() {
    let (mut hidden, mut seen, mut changes) = (0, 0, 0);
    for seed in 0..10 {
        let slabs = Slabs::new(seed);
        let [mut read, mut unread] = [true, false].map(|is_readable| {
            let mut scene = slabs.scene(&format!("walls-{seed}"), is_readable);
            if seed % 2 == 1 {
                scene.msaa = Msaa::Sample4;
            }
            let mut live = Live::new(&scene);
            live.settled();
            live
        });
        let mut was_hidden = None;
        for frame in 0..FRAMES {
            let pictures = [&mut read, &mut unread].map(|live| {
                slabs.drift(live.world());
                live.next()
            });
            assert!(matches!(state(&mut unread), MirrorState::Drawn(_)));
            let is_hidden = match state(&mut read) {
                MirrorState::NotDrawn(NotDrawn::Occluded) => true,
                MirrorState::Drawn(_) => false,
                other => panic!("{other}"),
            };
            hidden += usize::from(is_hidden);
            seen += usize::from(!is_hidden);
            changes += usize::from(was_hidden.is_some_and(|was| was != is_hidden));
            was_hidden = Some(is_hidden);
            pictures[0].assert_same(&pictures[1], &format!("walls-{seed}-{frame}"));
        }
    }
    assert!(
        hidden > 30 && seen > 30 && changes > 1,
        "{hidden} frames hidden, {seen} seen, {changes} changes"
    );
}
