//! What there must be for a window, and one line where it is missing.

use super::cli::say;

/// The examples' build of Bevy opens X11 windows on Linux; Wayland desktops offer that as well.
pub fn has_display() -> bool {
    !cfg!(target_os = "linux") || std::env::var_os("DISPLAY").is_some_and(|name| !name.is_empty())
}

/// Bevy panics where it finds no graphics device or no window system. One line instead.
pub fn explain_missing_driver() {
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        let text = info.payload_as_str().unwrap_or_default();
        if text.contains("Unable to find a GPU") {
            say(
                "no graphics driver found. On Linux install a Vulkan driver: \
                 `sh examples/run` does it, or `apt-get install mesa-vulkan-drivers`.",
            );
            std::process::exit(1);
        }
        if text.contains("event loop") {
            say(&format!(
                "no window could be opened ({text}); try --headless."
            ));
            std::process::exit(1);
        }
        usual(info);
    }));
}
