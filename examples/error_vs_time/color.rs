//! Light and levels: sRGB as pictures store it, linear as light adds up.

use std::sync::LazyLock;

/// The light of a level of 0 to 255, from 0 to 1.
pub fn linear(level: u8) -> f64 {
    static LIGHT: LazyLock<[f64; 256]> =
        LazyLock::new(|| std::array::from_fn(|level| from_srgb(level as f64 / 255.0)));
    LIGHT[usize::from(level)]
}

/// The level, not rounded, of a light from 0 to 1.
pub fn srgb(light: f64) -> f64 {
    255.0
        * if light <= 0.003_130_8 {
            light * 12.92
        } else {
            1.055 * light.powf(1.0 / 2.4) - 0.055
        }
}

/// Light of an sRGB value from 0 to 1.
pub fn from_srgb(value: f64) -> f64 {
    if value <= 0.040_45 {
        value / 12.92
    } else {
        ((value + 0.055) / 1.055).powf(2.4)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_become_light_and_come_back() {
        for level in 0..=255 {
            let back = srgb(linear(level));
            assert!((back - f64::from(level)).abs() < 0.01, "{level}: {back}");
        }
        assert!((linear(188) - 0.5).abs() < 0.005);
    }
}
