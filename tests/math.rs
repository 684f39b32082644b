//! The maths of the mirror: against reference vectors of 50 digits, and as laws on random input.

#[path = "support/count.rs"]
mod count;
#[path = "math/cover.rs"]
mod cover;
#[path = "support/extremes.rs"]
mod extremes;
#[path = "math/fitting.rs"]
mod fitting;
#[path = "math/joins.rs"]
mod joins;
#[path = "math/laws.rs"]
mod laws;
#[path = "math/plans.rs"]
mod plans;
#[path = "math/polygons.rs"]
mod polygons;
#[path = "math/random.rs"]
mod random;
#[path = "math/reference.rs"]
mod reference;
#[path = "math/single_precision.rs"]
mod single_precision;
#[path = "support/split_mix.rs"]
mod split_mix;
#[path = "math/stability/mod.rs"]
mod stability;
#[path = "math/support.rs"]
mod support;
#[path = "math/vector_scenes.rs"]
mod vector_scenes;
#[path = "math/vectors.rs"]
mod vectors;
