//! What was measured on what: the head of the report.

use std::process::Command;

use bevy::render::renderer::RenderAdapterInfo;

use crate::support::stage::Stage;

/// Lines for the terminal, the CSV and the chart; `what` is one of them.
pub fn about(stage: &mut Stage, what: &str) -> Vec<String> {
    let adapter = stage.world().resource::<RenderAdapterInfo>();
    let driver = format!("{} {}", adapter.driver, adapter.driver_info);
    let profile = if cfg!(debug_assertions) {
        "dev"
    } else {
        "release"
    };
    let cores = std::thread::available_parallelism().map_or(0, |cores| cores.get());
    vec![
        format!(
            "adapter {} ({:?}, {:?}), driver {}, {cores} cores",
            adapter.name,
            adapter.device_type,
            adapter.backend,
            driver.trim(),
        ),
        what.to_owned(),
        format!(
            "bevy_planar_mirror {}, bevy {}, wgpu {}, {}, {profile} profile",
            env!("CARGO_PKG_VERSION"),
            locked("bevy"),
            locked("wgpu"),
            rustc(),
        ),
    ]
}

/// The version of a crate that this was built with.
fn locked(name: &str) -> &'static str {
    version(include_str!("../../Cargo.lock"), name).unwrap_or("of unknown version")
}

fn version<'a>(lock: &'a str, name: &str) -> Option<&'a str> {
    let entry = lock
        .split_once(&format!("name = \"{name}\"\nversion = \""))?
        .1;
    Some(entry.split_once('"')?.0)
}

fn rustc() -> String {
    let asked = Command::new("rustc").arg("--version").output();
    let line = asked
        .ok()
        .and_then(|output| String::from_utf8(output.stdout).ok());
    let words = line.as_deref().map(|line| line.split_whitespace().take(2));
    words.map_or("rustc of unknown version".to_owned(), |words| {
        words.collect::<Vec<_>>().join(" ")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_version_is_that_of_the_very_crate() {
        let lock =
            "name = \"bevy_app\"\nversion = \"1.0.0\"\n\nname = \"bevy\"\nversion = \"0.19.1\"\n";
        assert_eq!(version(lock, "bevy"), Some("0.19.1"));
        assert_eq!(version(lock, "wgpu"), None);
        assert!(locked("wgpu").starts_with(char::is_numeric));
    }
}
