//! How many random scenes a test tries.

/// One environment variable for the full counts: `PLANAR_MIRROR_STABILITY=full`.
pub fn count(usual: u64, full: u64) -> u64 {
    match std::env::var("PLANAR_MIRROR_STABILITY").as_deref() {
        Err(_) | Ok("") => usual,
        Ok("full") => full,
        Ok(other) => panic!("PLANAR_MIRROR_STABILITY is full or not set, not {other:?}"),
    }
}
