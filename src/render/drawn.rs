//! What it took to draw the reflected views, handed back to the main world.

use core::time::Duration;
use std::sync::{Mutex, PoisonError};

use bevy::{ecs::prelude::*, platform::time::Instant, render::MainWorld};

use super::extract::ExtractedMirrors;
use crate::{status::DrawnFigures, view::ReflectedViews};

/// The views that the pass has drawn since the last extraction. Entities are those of the main
/// world.
#[derive(Resource, Default)]
pub struct DrawnViews(Mutex<Vec<(Entity, DrawnFigures)>>);

impl DrawnViews {
    pub fn add(&self, views: impl IntoIterator<Item = (Entity, DrawnFigures)>) {
        let mut drawn = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        drawn.extend(views);
    }
}

/// Lets the next [`MirrorFigures`](crate::MirrorFigures) know, and the next choice of projections.
pub fn hand_back(
    mut main_world: ResMut<MainWorld>,
    mut drawn: ResMut<DrawnViews>,
    mirrors: Res<ExtractedMirrors>,
) {
    let mut views = main_world.resource_mut::<ReflectedViews>();
    let drawn = drawn.0.get_mut().unwrap_or_else(PoisonError::into_inner);
    for (view, figures) in drawn.drain(..) {
        if let Some(live) = views.alive.get_mut(&view) {
            live.drawn = Some(figures);
        }
    }
    for mirror in &mirrors.views {
        if let Some(live) = views.alive.get_mut(&mirror.main_view) {
            live.has_foreign_items = mirror.has_foreign_items;
        }
    }
}

/// Measures one stretch of time after the other.
pub struct Laps(Instant);

impl Laps {
    pub fn begin() -> Self {
        Self(Instant::now())
    }

    /// Ends a stretch and begins the next.
    pub fn next(&mut self) -> Duration {
        let now = Instant::now();
        now - core::mem::replace(&mut self.0, now)
    }
}
