//! The README says what is true of the repository it stands in.

use std::{fs, path::Path};

const README: &str = include_str!("../README.md");

#[test]
fn the_smallest_use_is_the_example() {
    let example = include_str!("../examples/mirror.rs");
    assert!(README.contains(&format!("```rust\n{example}```\n")));
}

#[test]
fn every_file_it_links_to_is_there() {
    let links: Vec<&str> = README
        .split("](")
        .skip(1)
        .filter_map(|rest| rest.split(')').next())
        .filter(|link| !link.contains("://") && !link.starts_with('#'))
        .collect();
    assert!(links.len() > 5, "{links:?}");
    for link in links {
        assert!(repository().join(link).is_file(), "{link}");
    }
}

#[test]
fn every_script_and_example_it_runs_is_there() {
    let named = |before: &'static str| {
        README
            .split(before)
            .skip(1)
            .filter_map(|rest| rest.split_whitespace().next())
            .map(|name| name.trim_end_matches('`'))
    };
    for script in named("\nsh ") {
        assert!(repository().join(script).is_file(), "{script}");
    }
    for example in named("--example ") {
        let folder = repository().join("examples");
        assert!(
            folder.join(example).join("main.rs").is_file()
                || folder.join(format!("{example}.rs")).is_file(),
            "{example}"
        );
    }
    assert!(named("\nsh ").count() == 2 && named("--example ").count() > 3);
}

#[test]
fn its_versions_are_those_of_the_manifest() {
    let manifest = fs::read_to_string(repository().join("Cargo.toml")).expect("the manifest");
    let (crate_version, _) = env!("CARGO_PKG_VERSION")
        .rsplit_once('.')
        .expect("three numbers");
    let bevy_version = manifest
        .split("\nbevy = { version = \"")
        .nth(1)
        .and_then(|rest| rest.split('"').next())
        .and_then(|version| version.rsplit_once('.'))
        .expect("Bevy's version")
        .0;
    assert!(README.contains(&format!("\n| {crate_version} | {bevy_version} |\n")));
    let rust = format!(
        "[Rust](https://rustup.rs) {}",
        env!("CARGO_PKG_RUST_VERSION")
    );
    assert!(README.contains(&rust));
}

fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}
