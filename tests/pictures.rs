//! Picture tests: scenes drawn without a window, on whatever Vulkan driver there is, and looked at pixel by pixel.
//!
//! First what can be counted in a picture, then what must equal a reference that knows no mirrors.

mod support;

mod pictures {
    mod harness;
    mod lighting;
    mod random_scenes;
}
