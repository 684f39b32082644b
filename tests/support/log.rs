//! Collects what the app under test logs at WARN and above, so that a test can ask for it and an error fails it.

use std::{
    fmt::Write,
    sync::{Mutex, MutexGuard, Once},
};

use bevy::log::{
    Level,
    tracing::{
        self, Event, Subscriber,
        field::{Field, Visit},
    },
    tracing_subscriber::{
        Layer,
        layer::{Context, SubscriberExt},
        registry,
    },
};

/// One line of the log.
#[derive(Clone, Debug)]
pub struct Line {
    pub level: Level,
    /// The module that logged it.
    pub target: String,
    pub text: String,
}

static LINES: Mutex<Vec<Line>> = Mutex::new(Vec::new());

fn lines() -> MutexGuard<'static, Vec<Line>> {
    LINES
        .lock()
        .unwrap_or_else(|poisoned| poisoned.into_inner())
}

/// Starts collecting. The subscriber belongs to the process: systems run on threads of their own.
pub fn install() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        tracing::subscriber::set_global_default(registry().with(Collector))
            .expect("nothing else in this test binary sets a log subscriber");
    });
}

/// Hands over the lines since the last call.
pub fn take() -> Vec<Line> {
    std::mem::take(&mut lines())
}

struct Collector;

impl<S: Subscriber> Layer<S> for Collector {
    fn enabled(&self, metadata: &tracing::Metadata<'_>, _: Context<'_, S>) -> bool {
        *metadata.level() <= Level::WARN
    }

    fn on_event(&self, event: &Event<'_>, _: Context<'_, S>) {
        let mut text = Text(String::new());
        event.record(&mut text);
        lines().push(Line {
            level: *event.metadata().level(),
            target: event.metadata().target().to_owned(),
            text: text.0,
        });
    }
}

struct Text(String);

impl Visit for Text {
    fn record_debug(&mut self, field: &Field, value: &dyn std::fmt::Debug) {
        // Writing to a String cannot fail.
        let _ = if field.name() == "message" {
            write!(self.0, "{value:?}")
        } else {
            write!(self.0, " {}={value:?}", field.name())
        };
    }
}
