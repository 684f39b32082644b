//! Draws scenes: with the plugin, without it, as masks and as references, and compares them.

use bevy::prelude::*;
use bevy_planar_mirror::PlanarMirrorPlugin;

use super::{
    mask::Mask,
    picture::{Difference, Picture, Unlike},
    scene::Scene,
    set::{How, build, clear},
    stage::Stage,
};

/// Levels of 255 that a pixel of the reflection may be off.
pub const TOLERANCE: u8 = 2;
/// The share of the mirror's pixels that must be within [`TOLERANCE`].
pub const SHARE: f64 = 0.9999;
/// That share beyond a thousand units from the origin, where single precision shows.
pub const SHARE_FAR_AWAY: f64 = 0.9995;

/// Pixels that a mirror must have for a picture of it to say anything.
const LEAST: usize = 100;

/// How a studio's apps are made.
fn stage(as_game: bool) -> fn(&mut dyn FnMut(&mut App)) -> Stage {
    if as_game {
        |add| Stage::as_games_run(add)
    } else {
        |add| Stage::new(add)
    }
}

/// Two apps, one with the plugin and one without, that draw one scene after the other.
#[derive(Default)]
pub struct Studio {
    plugin: PlanarMirrorPlugin,
    plugins: Vec<fn(&mut App)>,
    /// Whether both are as games run.
    as_game: bool,
    mirrors: Option<Stage>,
    stock: Option<Stage>,
}

impl Studio {
    /// For scenes that need plugins of their own.
    pub fn of(scene: &Scene) -> Self {
        Self {
            plugins: scene.plugins.clone(),
            ..default()
        }
    }

    /// With apps as games run them.
    pub fn games() -> Self {
        Self {
            as_game: true,
            ..default()
        }
    }

    /// [`Self::of`] with apps as games run them.
    pub fn game(scene: &Scene) -> Self {
        Self {
            as_game: true,
            ..Self::of(scene)
        }
    }

    /// With other settings of the plugin than the default.
    pub fn with(plugin: PlanarMirrorPlugin) -> Self {
        Self {
            plugin,
            ..default()
        }
    }

    /// The app that has the plugin, as the last [`Self::picture`] left it.
    pub fn stage(&mut self) -> &mut Stage {
        let (plugin, plugins) = (&self.plugin, &self.plugins);
        let new = stage(self.as_game);
        self.mirrors.get_or_insert_with(|| {
            new(&mut |app| {
                app.add_plugins(plugin.clone());
                plugins.iter().for_each(|add| add(app));
            })
        })
    }

    fn stock(&mut self) -> &mut Stage {
        let plugins = &self.plugins;
        let new = stage(self.as_game);
        self.stock
            .get_or_insert_with(|| new(&mut |app| plugins.iter().for_each(|add| add(app))))
    }

    /// The scene with its mirrors.
    #[track_caller]
    pub fn picture(&mut self, scene: &Scene) -> Picture {
        draw(self.stage(), scene, How::Mirrors)
    }

    /// The scene in an app that knows no mirrors.
    #[track_caller]
    pub fn without_mirrors(&mut self, scene: &Scene) -> Picture {
        draw(self.stock(), scene, How::Plain)
    }

    /// What the mirror of this index must show, where it shows at all.
    #[track_caller]
    pub fn reference(&mut self, scene: &Scene, mirror: usize) -> Picture {
        draw(self.stock(), scene, How::Reference(mirror)).flipped()
    }

    /// The same picture drawn without a flip, for what a flip would put elsewhere: samples, dither,
    /// viewports, projections that lean. No material but `StandardMaterial` can be in it.
    #[track_caller]
    pub fn reference_in_place(&mut self, scene: &Scene, mirror: usize) -> Picture {
        draw(self.stock(), scene, How::InPlace(mirror))
    }

    /// Where the mirror of this index shows.
    #[track_caller]
    pub fn mask(&mut self, scene: &Scene, mirror: usize) -> Mask {
        Mask::new(draw(self.stock(), scene, How::Mask(mirror)))
    }

    /// The acceptance of a mirror: what it shows is the reference, and the rest of the picture is
    /// that of an app without mirrors, to the bit. Returns the picture.
    #[track_caller]
    pub fn assert_reflects(&mut self, scene: &Scene) -> Picture {
        self.assert_shows(scene, LEAST, Self::reference)
    }

    /// [`Self::assert_reflects`] against [`Self::reference_in_place`].
    #[track_caller]
    pub fn assert_reflects_in_place(&mut self, scene: &Scene) -> Picture {
        self.assert_shows(scene, LEAST, Self::reference_in_place)
    }

    /// [`Self::assert_reflects_in_place`] for mirrors of a few pixels: at least `least` of them, less
    /// the edge.
    #[track_caller]
    pub fn assert_small_reflects(&mut self, scene: &Scene, least: usize) -> Picture {
        self.assert_shows(scene, least, Self::reference_in_place)
    }

    /// How far the one mirror of a scene is from its reference. Around it at most `odd` pixels may be touched.
    ///
    /// Where an edge goes through the very center of a pixel, a picture that is flipped shows its other side. So
    /// each pixel may be that of [`Self::reference`] or of [`Self::reference_in_place`].
    #[track_caller]
    pub fn reflection_error(&mut self, scene: &Scene, odd: usize) -> Difference {
        let picture = self.picture(scene);
        let mask = self.mask(scene, 0);
        let plain = self.without_mirrors(scene);
        let is_kept = match picture.difference(&plain, 0, |place| mask.outside(place)) {
            Ok(around) => around.beyond <= odd,
            Err(unlike) => unlike == Unlike::NothingCompared,
        };
        if !is_kept {
            self.assert_untouched_outside(scene, &picture);
        }
        let compared = |reference: &Picture| {
            picture
                .difference(reference, TOLERANCE, |place| mask.inside(place))
                .unwrap_or_else(|unlike| panic!("{}: {unlike}", scene.name))
        };
        let reference = self.reference(scene, 0);
        let difference = compared(&reference);
        if difference.beyond == 0 {
            return difference;
        }
        compared(&picture.nearer(&reference, &self.reference_in_place(scene, 0)))
    }

    #[track_caller]
    fn assert_shows(
        &mut self,
        scene: &Scene,
        least: usize,
        reference: fn(&mut Self, &Scene, usize) -> Picture,
    ) -> Picture {
        let picture = self.picture(scene);
        for mirror in 0..scene.mirrors.len() {
            let mask = self.mask(scene, mirror);
            let count = mask.inside_count();
            assert!(
                count >= least,
                "{}: of mirror {mirror} only {count} pixels are seen, too few to be tested",
                scene.name
            );
            let reference = reference(self, scene, mirror);
            let far = scene.eye.translation.length() > 1e3;
            let share = if far { SHARE_FAR_AWAY } else { SHARE };
            let what = format!("{}-inside-{mirror}", scene.name);
            picture.assert_alike(
                &reference,
                TOLERANCE,
                share,
                |place| mask.inside(place),
                &what,
            );
        }
        self.assert_untouched_outside(scene, &picture);
        picture
    }

    /// Not one pixel outside the mirrors differs from the picture without the plugin.
    #[track_caller]
    pub fn assert_untouched_outside(&mut self, scene: &Scene, picture: &Picture) {
        let plain = self.without_mirrors(scene);
        let masks: Vec<_> = (0..scene.mirrors.len())
            .map(|mirror| self.mask(scene, mirror))
            .collect();
        let outside = |place| masks.iter().all(|mask| mask.outside(place));
        if plain.places().any(outside) {
            picture.assert_alike(&plain, 0, 1.0, outside, &format!("{}-outside", scene.name));
        }
    }

    /// The scene looks as if there were no plugin: every pixel.
    #[track_caller]
    pub fn assert_no_mirror(&mut self, scene: &Scene) {
        let picture = self.picture(scene);
        picture.assert_same(&self.without_mirrors(scene), &scene.name);
    }
}

/// One scene, one studio: [`Studio::assert_reflects`].
#[track_caller]
pub fn assert_reflects(scene: &Scene) -> Picture {
    Studio::of(scene).assert_reflects(scene)
}

/// Takes the last scene off the stage, sets this one up and reads its picture.
#[track_caller]
fn draw(stage: &mut Stage, scene: &Scene, how: How) -> Picture {
    clear(stage);
    let target = stage.target(scene.size);
    build(stage.world(), scene, how, target.clone());
    match stage.settle(&target, scene.size) {
        // A mask or a plain picture of one color can be right; the mirrors' own must show something.
        Ok(picture) => {
            if how == How::Mirrors {
                picture.assert_shows_something();
            }
            picture
        }
        Err(reason) => panic!("{}, drawn as {how:?}: {reason}", scene.name),
    }
}
