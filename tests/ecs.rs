//! The main world's half of the plugin, without a GPU: which camera gets a reflected view of which mirror, what a
//! mirror's status says, and what a user sees of all that: nothing else.

#[path = "support/log.rs"]
mod log;
#[path = "support/split_mix.rs"]
mod split_mix;

mod ecs {
    mod app;
    mod clusters;
    mod cover;
    mod flicker;
    mod likeness;
    mod log_lines;
    mod meshes;
    mod motion;
    mod own;
    mod pairing;
    mod plugin;
    mod projection;
    mod reasons;
    mod reflection;
    mod removal;
    mod shadows;
    mod sharing;
    mod sight;
    mod status;
    mod steady;
    mod untouched;
    mod windows;
}
