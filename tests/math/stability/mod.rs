//! The maths at the extremes: many random scenes, sweeps in the smallest steps, jumps.

mod flicker;
mod ghosts;
mod motion;
mod plans;
mod precision;
mod tally;
mod witness;
