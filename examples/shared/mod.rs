//! What several examples need.

pub mod cli;
pub mod display;
pub mod headless;
pub mod panel;
pub mod picture;
pub mod pictures;
pub mod table;
