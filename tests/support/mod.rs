//! What the picture tests stand on: an app without a window ([`stage`]), scenes written once and drawn in several
//! ways ([`scene`], [`set`], [`studio`], [`reference`]), and pictures that can be compared ([`picture`]).

pub mod count;
pub mod cut;
#[allow(dead_code, reason = "the tests of the maths need more of it")]
pub mod extremes;
pub mod foreign;
pub mod hall;
pub mod linear;
pub mod live;
pub mod log;
pub mod mask;
pub mod opening;
pub mod picture;
pub mod props;
pub mod random;
pub mod reference;
pub mod scene;
pub mod set;
pub mod setting;
pub mod split_mix;
pub mod stage;
pub mod studio;
pub mod wild;
