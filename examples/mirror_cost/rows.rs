//! The rows of the table: what is compared with what, and the number to reach.

use bevy_planar_mirror::MirrorShadows;

use crate::{
    args::Plan,
    contest::{How, MIRRORS, Outcome, measure, side},
    crowd,
    estimate::Part,
    frames::FrameTimes,
    maths, rooms,
    support::scene::{Scene, Surface},
    systems,
};

#[derive(Clone)]
pub struct Row {
    pub name: &'static str,
    pub compared: &'static str,
    /// What it should be at most; `None` where there is no such number yet.
    pub goal: Option<f64>,
    /// Of the value; a ratio has none.
    pub unit: &'static str,
    pub measure: fn(&Plan) -> Outcome,
}

/// All rows, in the order of the table.
pub fn all() -> Vec<Row> {
    let ratio = |name, compared, goal, measure| Row {
        name,
        compared,
        goal,
        unit: "",
        measure,
    };
    let nanoseconds = |name, compared, goal, measure| Row {
        name,
        compared,
        goal: Some(goal),
        unit: " ns",
        measure,
    };
    vec![
        ratio(
            "control",
            "frame without the plugin / the same once more",
            None,
            control,
        ),
        ratio(
            "off-screen",
            "frame with the mirror out of view / without the plugin",
            Some(1.02),
            |plan| of_frames(plan, with(&few_lamps(plan), rooms::out_of_view(half()))),
        ),
        ratio(
            "back-facing",
            "frame with the mirror's back in view / without the plugin",
            Some(1.02),
            |plan| of_frames(plan, with(&few_lamps(plan), rooms::turned_away(half()))),
        ),
        ratio(
            "area",
            "extra time, mirror over 5 % of the picture / over 100 %",
            Some(0.12),
            area,
        ),
        ratio(
            "rival-25",
            "extra time, 25 % of the picture / second camera into an image",
            Some(0.4),
            |plan| against_second_camera(plan, 0.25),
        ),
        ratio(
            "rival-100",
            "extra time, 100 % of the picture / second camera into an image",
            Some(1.0),
            |plan| against_second_camera(plan, 1.0),
        ),
        ratio(
            "culling",
            "objects drawn in a 2 x 2 m mirror, of 10 000 / seen in it",
            Some(1.15),
            |plan| crowd::measure(plan.height),
        ),
        ratio(
            "shadows",
            "extra time of four cascades in the mirror / in a second camera",
            Some(0.25),
            |plan| shadows(plan, MirrorShadows::Auto),
        ),
        ratio(
            "own-shadows",
            "the same from shadow maps of the mirror's own",
            None,
            |plan| shadows(plan, MirrorShadows::Own),
        ),
        ratio(
            "64-mirrors",
            "frame with 64 mirrors, 4 of them seen / with these 4 alone",
            Some(1.05),
            many,
        ),
        ratio(
            "tiles",
            "frame with 50 mirrors in one plane / one mirror of their size",
            Some(1.1),
            tiles,
        ),
        Row {
            name: "unseen",
            compared: "the plugin's systems in the main world, 1000 mirrors, none seen",
            goal: Some(100.0),
            unit: " us",
            measure: systems::of_unseen_mirrors,
        },
        Row {
            name: "walls",
            compared: "the search for what hides a mirror, 10 000 objects, 100 of them large",
            goal: None,
            unit: " us",
            measure: systems::of_walls,
        },
        nanoseconds(
            "plan",
            "the maths of a mirror that is drawn",
            1000.0,
            maths::of_a_plan,
        ),
        nanoseconds(
            "skip-back",
            "the maths of a mirror whose back is seen",
            100.0,
            maths::of_a_back,
        ),
        nanoseconds(
            "skip-beside",
            "the maths of a mirror beside the view",
            100.0,
            maths::of_one_out_of_view,
        ),
        nanoseconds(
            "straddle",
            "the test of an object against a mirror's plane",
            5.0,
            maths::of_an_object,
        ),
        ratio(
            "bounces",
            "extra time of facing mirrors, 8 bounces / 1 bounce",
            Some(2.2),
            bounces,
        ),
        ratio(
            "hidden",
            "frame with the mirror behind a wall / without the plugin",
            Some(1.02),
            |plan| {
                let scene = rooms::with_screen(few_lamps(plan), 0.25);
                of_frames(plan, with(&scene, rooms::facing(0.25)))
            },
        ),
    ]
}

/// Frames are short, so that what a mirror adds to each shows.
const FEW_LAMPS: u16 = 2;
/// Frames are nothing but shading.
const MANY_LAMPS: u16 = 12;

fn few_lamps(plan: &Plan) -> Scene {
    rooms::room(plan.height, FEW_LAMPS)
}

fn half() -> Surface {
    rooms::facing(0.5)
}

fn with(scene: &Scene, mirror: Surface) -> Scene {
    scene.clone().mirror(mirror)
}

fn whole(times: &FrameTimes) -> f64 {
    times.whole
}

/// The frame with the scene's mirrors, by the frame without the plugin.
fn of_frames(plan: &Plan, scene: Scene) -> Outcome {
    let sides = [
        side("mirror", MIRRORS, &scene),
        side("without", How::Without, &scene),
    ];
    measure(plan, &sides, whole, frame_by_frame)
}

/// Twice the same: how far from 1 a ratio is by chance, or by a fault of the measurement.
fn control(plan: &Plan) -> Outcome {
    let scene = few_lamps(plan);
    let sides = ["first", "second"].map(|name| side(name, How::Without, &scene));
    measure(plan, &sides, whole, frame_by_frame)
}

fn frame_by_frame(times: &[f64]) -> Part {
    Part {
        of: times[0],
        by: times[1],
    }
}

/// What the first two sides take beyond the third.
fn extra_by_extra(times: &[f64]) -> Part {
    Part {
        of: times[0] - times[2],
        by: times[1] - times[2],
    }
}

fn area(plan: &Plan) -> Outcome {
    let room = rooms::room(plan.height, MANY_LAMPS);
    let [small, large] = [0.05, 1.0].map(|share| with(&room, rooms::facing(share)));
    let sides = [
        side("5 %", MIRRORS, &small),
        side("100 %", MIRRORS, &large),
        side("without", How::Without, &large),
    ];
    measure(plan, &sides, whole, extra_by_extra)
}

fn against_second_camera(plan: &Plan, share: f32) -> Outcome {
    let scene = with(&few_lamps(plan), rooms::facing(share));
    let sides = [
        side("mirror", MIRRORS, &scene),
        side("second camera", How::SecondCamera, &scene),
        side("without", How::Without, &scene),
    ];
    measure(plan, &sides, whole, extra_by_extra)
}

fn shadows(plan: &Plan, from: MirrorShadows) -> Outcome {
    let scene = |shadows| {
        let mut scene = rooms::teapot(plan.height, shadows)?;
        for surface in &mut scene.mirrors {
            surface.mirror.shadows = from;
        }
        Ok::<_, String>(scene)
    };
    let (lit, shadowed) = (scene(false)?, scene(true)?);
    let sides = [
        side("mirror", MIRRORS, &lit),
        side("mirror, shadows", MIRRORS, &shadowed),
        side("second camera", How::SecondCamera, &lit),
        side("second camera, shadows", How::SecondCamera, &shadowed),
        side("without", How::Without, &lit),
        side("without, shadows", How::Without, &shadowed),
    ];
    measure(plan, &sides, whole, |times| {
        let shadows = |side: usize| times[side + 1] - times[side];
        Part {
            of: shadows(0) - shadows(4),
            by: shadows(2) - shadows(4),
        }
    })
}

fn many(plan: &Plan) -> Outcome {
    let mut four = few_lamps(plan);
    four.mirrors.extend(rooms::four_mirrors());
    let mut all = four.clone();
    all.mirrors.extend(rooms::sixty_unseen());
    let sides = [
        side("64 mirrors", MIRRORS, &all),
        side("4 mirrors", MIRRORS, &four),
    ];
    measure(plan, &sides, whole, frame_by_frame)
}

fn tiles(plan: &Plan) -> Outcome {
    let room = rooms::furnished_floor(plan.height, FEW_LAMPS);
    let mut tiles = room.clone();
    tiles.mirrors.extend(rooms::tiles());
    let sides = [
        side("50 tiles", MIRRORS, &tiles),
        side("one mirror", MIRRORS, &with(&room, rooms::floor())),
    ];
    measure(plan, &sides, whole, frame_by_frame)
}

fn bounces(plan: &Plan) -> Outcome {
    let scene = rooms::facing_mirrors(plan.height, MANY_LAMPS);
    let sides = [
        side("8 bounces", How::Mirrors { max_bounces: 8 }, &scene),
        side("1 bounce", MIRRORS, &scene),
        side("without", How::Without, &scene),
    ];
    measure(plan, &sides, whole, extra_by_extra)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_has_a_name_of_its_own() {
        let rows = all();
        for (index, row) in rows.iter().enumerate() {
            assert!(rows[..index].iter().all(|other| other.name != row.name));
            assert!(!row.compared.contains('|'), "it is a field of a table");
        }
    }
}
