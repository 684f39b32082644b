//! What other plugins put into a view: drawn in the reflection where that is possible, left out with one warning
//! where it is not, and never an error.

use bevy::{
    camera::visibility::NoFrustumCulling,
    pbr::wireframe::{WireframeConfig, WireframePlugin},
    prelude::*,
};
use bevy_planar_mirror::{
    MirrorFigures, MirrorState, MirrorStatus, PlanarMirrorPlugin, status::Projection,
};

use crate::support::{
    foreign::{Misfit, OwnPipeline, Phase, Triangle, When, add_own_pipeline},
    live::Live,
    picture::Picture,
    props::{BLUE, GREEN, MAGENTA, at, is},
    scene::{Look, Scene, Surface},
    stage::Stage,
    studio::{SHARE, Studio, TOLERANCE},
};

/// A wall mirror, and a ball before it.
pub fn booth(name: &str) -> Scene {
    let mut scene = Scene::new(name)
        .eye(vec3(0.9, 0.7, 3.0), vec3(0.0, 0.2, 0.0))
        .mirror(Surface::wall(3.0, 2.0, at(0.0, 0.2, 0.0)))
        .object(
            Sphere::new(0.3).mesh().uv(16, 10),
            GREEN,
            at(-0.7, 0.3, 0.6),
        );
    scene.size = UVec2::new(120, 90);
    scene
}

/// The reflection is right, and without what is added it would be another one.
#[track_caller]
fn assert_reflects_what_is_added(bare: &Scene, with: &Scene) {
    assert_reflects_but_for(bare, with, SHARE);
}

/// [`assert_reflects_what_is_added`], where a share of the pixels may be on either side of an edge.
#[track_caller]
fn assert_reflects_but_for(bare: &Scene, with: &Scene, share: f64) {
    let mut studio = Studio::of(with);
    let picture = studio.picture(with);
    let reference = studio.reference(with, 0);
    let mask = studio.mask(with, 0);
    let inside = |place| mask.inside(place);
    picture.assert_alike(&reference, TOLERANCE, share, inside, &with.name);
    studio.assert_untouched_outside(with, &picture);
    let without = Studio::of(bare).picture(bare);
    let seen = picture.difference(&without, 8, inside);
    assert!(
        seen.as_ref().is_ok_and(|seen| seen.beyond > 30),
        "{}: nothing of it is in the mirror: {seen:?}",
        with.name
    );
}

/// With samples, whose pattern has no mirror image: edges of the reference are other ones.
#[track_caller]
fn assert_reflects_with_samples(bare: &Scene, with: &Scene) {
    let [bare, with] = [bare, with].map(|scene| Scene {
        msaa: Msaa::Sample4,
        ..scene.clone()
    });
    assert_reflects_but_for(&bare, &with, 0.985);
}

mod gizmos {
    use super::*;

    /// Lines have their width on the screen, and no two computations of it round alike.
    const LINES: f64 = 0.999;

    /// A thick cross before the mirror, a strip with corners, a circle.
    fn draw(mut gizmos: Gizmos) {
        gizmos.line(vec3(0.1, 0.1, 0.5), vec3(0.8, 0.8, 0.9), MAGENTA);
        gizmos.line(vec3(0.1, 0.8, 0.5), vec3(0.8, 0.1, 0.9), BLUE);
        let strip = [
            vec3(-0.3, 0.9, 0.3),
            vec3(0.0, 0.5, 0.3),
            vec3(0.3, 0.9, 0.4),
        ];
        gizmos.linestrip(strip, MAGENTA);
        // Through the ball: what is inside it is hidden, if nothing is said to the contrary.
        gizmos.line(vec3(-1.2, 0.3, 0.6), vec3(-0.2, 0.3, 0.6), MAGENTA);
    }

    fn with_bias(app: &mut App, depth_bias: f32) {
        let mut config = GizmoConfig {
            depth_bias,
            ..default()
        };
        config.line.width = 4.0;
        config.line.joints = GizmoLineJoint::Miter;
        app.insert_gizmo_config(DefaultGizmoConfigGroup, config)
            .add_systems(Update, draw);
    }

    #[test]
    fn lines_are_reflected() {
        let scene = booth("gizmos").plugin(|app| with_bias(app, 0.0));
        assert_reflects_but_for(&booth("gizmos-bare"), &scene, LINES);
    }

    #[test]
    fn lines_that_are_always_on_top_are_so_in_the_reflection_too() {
        let scene = booth("gizmos-on-top").plugin(|app| with_bias(app, -1.0));
        assert_reflects_but_for(&booth("gizmos-bare"), &scene, LINES);
        let inside = booth("gizmos-inside").plugin(|app| with_bias(app, 0.0));
        let mask = Studio::default().mask(&booth("gizmos-bare"), 0);
        let on_top = Studio::of(&scene).picture(&scene);
        let inside = Studio::of(&inside).picture(&inside);
        let seen = on_top.difference(&inside, 8, |place| mask.inside(place));
        assert!(
            seen.as_ref().is_ok_and(|seen| seen.beyond > 20),
            "the line through the ball is hidden: {seen:?}"
        );
    }

    #[test]
    fn lines_are_reflected_with_samples_and_in_hdr() {
        let scene = booth("gizmos-hdr").plugin(|app| with_bias(app, 0.0)).hdr();
        let bare = booth("gizmos-hdr-bare").hdr();
        assert_reflects_but_for(&bare, &scene, LINES);
        assert_reflects_with_samples(&bare, &scene);
    }

    /// Nothing else crosses the plane, so nothing else asks for it to be cut at.
    #[test]
    fn a_line_behind_the_mirror_does_not_show_in_it() {
        let scene = booth("gizmo-behind").plugin(|app| {
            app.add_systems(Update, |mut gizmos: Gizmos| {
                gizmos.line(vec3(-0.5, 0.3, -0.5), vec3(0.8, 0.6, -0.9), MAGENTA);
            });
        });
        let bare = booth("gizmo-behind-bare");
        let without = Studio::default().picture(&bare);
        let mask = Studio::default().mask(&bare, 0);
        let picture = Studio::of(&scene).picture(&scene);
        picture.assert_alike(&without, 0, 1.0, |at| mask.inside(at), &scene.name);
    }

    /// Of a line nobody knows where it is, so the view is cut at the mirror. The status says so from
    /// the frame on that comes after the first line.
    #[test]
    fn the_status_of_a_mirror_with_lines_says_that_it_is_cut() {
        let states = |scene: &Scene| {
            let mut live = Live::on(
                Stage::as_games_run(|app| {
                    app.add_plugins(PlanarMirrorPlugin::default());
                    scene.plugins.iter().for_each(|add| add(app));
                }),
                scene,
            );
            live.settled();
            let world = live.world();
            let mut statuses = world.query::<&MirrorStatus>();
            let states = statuses.iter(world).flat_map(|status| &status.cameras);
            let states: Vec<_> = states.map(|seen| seen.state).collect();
            let figures = &world.resource::<MirrorFigures>().views;
            (states, figures[0].projection)
        };
        let plain = states(&booth("gizmo-none"));
        assert_eq!(plain.1, Projection::Plain);
        assert_eq!(plain.0, [MirrorState::Drawn(Projection::Plain)]);
        let with = states(&booth("gizmo-status").plugin(|app| with_bias(app, 0.0)));
        assert_eq!(with.1, Projection::Oblique);
        assert_eq!(with.0, [MirrorState::Drawn(Projection::Oblique)]);
    }

    /// What is behind would show beside the line, not on it.
    #[test]
    fn a_line_through_the_mirror_ends_at_it() {
        fn line(app: &mut App, behind: f32) {
            app.add_systems(Update, move |mut gizmos: Gizmos| {
                let (start, at_mirror) = (vec3(-0.4, 0.8, 0.6), vec3(0.0, 0.5, 0.0));
                gizmos.line(start, at_mirror + behind * (at_mirror - start), MAGENTA);
            });
        }
        let through = booth("gizmo-through").plugin(|app| line(app, 1.5));
        let ending = booth("gizmo-ending").plugin(|app| line(app, 0.0));
        let mask = Studio::default().mask(&booth("gizmo-bare"), 0);
        let through = Studio::of(&through).picture(&through);
        let ending = Studio::of(&ending).picture(&ending);
        let inside = |place| mask.inside(place);
        // The engine shortens lines at the near plane by a two-thousandth.
        through.assert_alike(&ending, 2, 0.999, inside, "gizmo-through");
        assert!(ending.count(is(MAGENTA)) > 30);
    }
}

/// Lines along the edges of every triangle, in a phase of their own.
#[test]
fn wireframes_are_reflected() {
    fn add(app: &mut App) {
        app.add_plugins(WireframePlugin::default());
        app.insert_resource(WireframeConfig {
            global: true,
            default_color: MAGENTA,
            ..default()
        });
    }
    for msaa in [Msaa::Off, Msaa::Sample4] {
        let mut bare = booth(&format!("wireframes-bare-{msaa:?}"));
        bare.msaa = msaa;
        let mut with = bare.clone().plugin(add);
        with.name = format!("wireframes-{msaa:?}");
        // Lines are as thin as they can be, and round to one side or the other.
        let share = if msaa == Msaa::Off { 0.99 } else { 0.97 };
        assert_reflects_but_for(&bare, &with, share);
    }
}

/// Before the mirror and facing it: the camera sees its face in the mirror alone.
const FACING: [Vec3; 3] = [
    vec3(-0.1, 0.0, 0.5),
    vec3(0.3, 0.9, 0.5),
    vec3(0.9, 0.1, 0.7),
];
/// Behind it, and turned to where the eye is in the mirror's world.
const BEHIND: [Vec3; 3] = [
    vec3(0.5, 0.0, -0.6),
    vec3(-0.5, 0.0, -0.6),
    vec3(0.1, 0.8, -0.6),
];

const FITTING: Triangle = Triangle {
    label: "foreign_triangle",
    corners: FACING,
    phase: Phase::Transparent,
    when: When::Queue,
    misfit: Misfit::None,
};

#[test]
fn a_custom_sorted_item_is_reflected_the_right_way_round() {
    let scene = booth("sorted").plugin(|app| FITTING.add(app));
    assert_reflects_what_is_added(&booth("bare"), &scene);
}

#[test]
fn a_custom_binned_item_is_reflected_the_right_way_round() {
    fn add(app: &mut App) {
        Triangle {
            phase: Phase::Opaque,
            ..FITTING
        }
        .add(app);
    }
    assert_reflects_what_is_added(&booth("bare"), &booth("binned").plugin(add));
}

#[test]
fn a_custom_item_that_the_phase_keeps_is_reflected_in_every_frame() {
    fn add(app: &mut App) {
        Triangle {
            phase: Phase::OpaqueRetained,
            ..FITTING
        }
        .add(app);
    }
    let scene = booth("retained").plugin(add);
    assert_reflects_what_is_added(&booth("bare"), &scene);
    // It outlives a change of format, for which its plugin queues it once more.
    let mut live = Live::on(stage_of(&scene), &scene);
    live.settled();
    *live
        .stage
        .world()
        .query::<&mut Msaa>()
        .iter_mut(live.stage.world())
        .next()
        .expect("a camera") = Msaa::Sample4;
    let mut expected = scene.clone();
    expected.msaa = Msaa::Sample4;
    live.settled()
        .assert_same(&Studio::of(&expected).picture(&expected), "retained-msaa");
}

#[test]
fn custom_items_are_reflected_with_samples_and_in_hdr() {
    let scene = booth("items-hdr").plugin(|app| FITTING.add(app)).hdr();
    let bare = booth("items-hdr-bare").hdr();
    assert_reflects_what_is_added(&bare, &scene);
    assert_reflects_with_samples(&bare, &scene);
}

#[test]
fn a_custom_item_behind_the_mirror_does_not_show_in_it() {
    for phase in [Phase::Transparent, Phase::Opaque] {
        let add: fn(&mut App) = match phase {
            Phase::Transparent => |app| {
                Triangle {
                    corners: BEHIND,
                    ..FITTING
                }
                .add(app);
            },
            _ => |app| {
                Triangle {
                    corners: BEHIND,
                    phase: Phase::Opaque,
                    ..FITTING
                }
                .add(app);
            },
        };
        let scene = booth(&format!("behind-{phase:?}")).plugin(add);
        let without = Studio::default().picture(&booth("bare"));
        let mask = Studio::default().mask(&booth("bare"), 0);
        let picture = Studio::of(&scene).picture(&scene);
        picture.assert_alike(&without, 0, 1.0, |at| mask.inside(at), &scene.name);
    }
}

fn stage_of(scene: &Scene) -> Stage {
    Stage::new(|app| {
        app.add_plugins(bevy_planar_mirror::PlanarMirrorPlugin::default());
        scene.plugins.iter().for_each(|add| add(app));
    })
}

/// An item that fits the camera's own view and no reflected one.
#[track_caller]
fn assert_left_out(name: &str, add: fn(&mut App)) {
    let scene = booth(name).plugin(add);
    let mut live = Live::on(stage_of(&scene), &scene);
    let picture = live.settled();
    for _ in 0..3 {
        live.next();
    }
    let warnings: Vec<_> = live
        .stage
        .warnings()
        .filter(|line| line.target.starts_with("bevy_planar_mirror"))
        .map(|line| &line.text)
        .collect();
    assert!(
        matches!(warnings[..], [one] if one.contains("misfit_triangle")),
        "{name}: not one warning that names it: {warnings:?}"
    );
    drop(live);
    let mut bare = Studio::default();
    let mask = Studio::of(&scene).mask(&scene, 0);
    picture.assert_alike(
        &bare.picture(&booth("bare")),
        0,
        1.0,
        |place| mask.inside(place),
        &format!("{name}-inside"),
    );
    let plain = Studio::of(&scene).without_mirrors(&scene);
    let empty = bare.without_mirrors(&booth("bare"));
    // Where the item itself is, before the mirror and beside it.
    let item = |place: UVec2| plain.at(place.x, place.y) != empty.at(place.x, place.y);
    assert!(plain.places().filter(|place| item(*place)).count() > 100);
    picture.assert_alike(&plain, 0, 1.0, item, &format!("{name}-item"));
}

/// Before the mirror, and turned to the camera.
const MISFIT: Triangle = Triangle {
    label: "misfit_triangle",
    corners: [
        vec3(-0.2, -1.2, 0.8),
        vec3(0.8, -1.2, 0.8),
        vec3(0.3, 0.6, 0.6),
    ],
    ..FITTING
};

#[test]
fn an_item_with_other_samples_is_left_out() {
    assert_left_out("other-samples", |app| {
        Triangle {
            misfit: Misfit::OtherSamples,
            ..MISFIT
        }
        .add(app);
    });
}

#[test]
fn an_item_with_another_format_is_left_out() {
    assert_left_out("other-format", |app| {
        Triangle {
            misfit: Misfit::OtherFormat,
            phase: Phase::Opaque,
            ..MISFIT
        }
        .add(app);
    });
}

#[test]
fn an_item_without_a_depth_test_is_left_out() {
    assert_left_out("no-depth", |app| {
        Triangle {
            misfit: Misfit::NoDepth,
            phase: Phase::Opaque,
            ..MISFIT
        }
        .add(app);
    });
    assert_left_out("no-depth-sorted", |app| {
        Triangle {
            misfit: Misfit::NoDepth,
            ..MISFIT
        }
        .add(app);
    });
}

/// Queued when everybody else is done: it may come too late to be reflected, but it breaks nothing.
#[test]
fn an_item_that_comes_late_is_reflected_or_left_out() {
    for phase in [Phase::Transparent, Phase::Opaque] {
        let add: fn(&mut App) = match phase {
            Phase::Transparent => |app| {
                Triangle {
                    when: When::Prepare,
                    ..FITTING
                }
                .add(app);
            },
            _ => |app| {
                Triangle {
                    when: When::Prepare,
                    phase: Phase::Opaque,
                    ..FITTING
                }
                .add(app);
            },
        };
        let scene = booth(&format!("late-{phase:?}")).plugin(add);
        let picture: Picture = Studio::of(&scene).picture(&scene);
        let reference = Studio::of(&scene).reference(&scene, 0);
        let without = Studio::default().picture(&booth("bare"));
        let mask = Studio::default().mask(&booth("bare"), 0);
        let inside = |place| mask.inside(place);
        if picture.alike(&reference, 2, 0.9999, inside).is_err() {
            picture.assert_alike(&without, 0, 1.0, inside, &scene.name);
        }
    }
}

/// A mesh that a plugin draws by its own pipeline, as the engine's example for it does.
fn own(name: &str) -> Scene {
    let look = || {
        Look::other(|entity| {
            entity.insert(OwnPipeline);
        })
    };
    booth(name)
        .plugin(add_own_pipeline)
        .object(Cuboid::from_length(0.5), look(), at(0.4, 0.3, 0.6))
        .object(Cuboid::from_length(0.5), look(), at(0.3, 0.8, 0.5))
}

#[test]
fn a_mesh_with_a_pipeline_of_its_own_is_reflected() {
    assert_reflects_what_is_added(&booth("bare"), &own("own"));
}

#[test]
fn a_mesh_with_a_pipeline_of_its_own_is_cut_at_the_plane() {
    let look = Look::other(|entity| {
        entity.insert(OwnPipeline);
    });
    let scene = own("own-through").object(
        Cuboid::from_length(0.6),
        look,
        at(-0.9, 0.8, 0.2).with_rotation(Quat::from_rotation_x(0.4)),
    );
    assert_reflects_what_is_added(&own("own"), &scene);
}

#[test]
fn a_mesh_with_a_pipeline_of_its_own_does_not_show_from_behind_the_mirror() {
    let look = Look::other(|entity| {
        entity.insert(OwnPipeline);
    });
    let scene = own("own-behind").object(Cuboid::from_length(0.6), look, at(0.1, 0.3, -0.7));
    let picture = Studio::of(&scene).assert_reflects(&scene);
    let bare = own("own");
    let mask = Studio::of(&bare).mask(&bare, 0);
    let without = Studio::of(&bare).picture(&bare);
    picture.assert_alike(&without, 0, 1.0, |at| mask.inside(at), &scene.name);
}

/// Such meshes may be left without bounds, too.
#[test]
fn a_mesh_with_a_pipeline_of_its_own_and_no_bounds_is_reflected() {
    let look = Look::other(|entity| {
        entity.insert((OwnPipeline, NoFrustumCulling));
    });
    let scene = own("own-no-bounds").object(Cuboid::from_length(0.4), look, at(-0.6, 0.8, 0.8));
    assert_reflects_what_is_added(&own("own"), &scene);
}
