//! Which pixels belong to a mirror, and which surely do not.

use bevy::math::UVec2;

use super::picture::Picture;

/// A picture of the mirror in white and of everything else in black, see-through things in red.
pub struct Mask {
    picture: Picture,
}

impl Mask {
    pub fn new(picture: Picture) -> Self {
        Self { picture }
    }

    /// The mirror less one pixel along its edge.
    pub fn inside(&self, place: UVec2) -> bool {
        self.around(place).all(|[r, g, _, _]| r == 255 && g == 255)
    }

    /// Neither the mirror nor one pixel around it, nor anything see-through that may be before it.
    pub fn outside(&self, place: UVec2) -> bool {
        self.around(place).all(|[r, _, _, _]| r == 0)
    }

    pub fn inside_count(&self) -> usize {
        self.picture
            .places()
            .filter(|place| self.inside(*place))
            .count()
    }

    pub fn picture(&self) -> &Picture {
        &self.picture
    }

    fn around(&self, place: UVec2) -> impl Iterator<Item = [u8; 4]> {
        let last = self.picture.size() - 1;
        let xs = place.x.saturating_sub(1)..=(place.x + 1).min(last.x);
        let ys = place.y.saturating_sub(1)..=(place.y + 1).min(last.y);
        ys.flat_map(move |y| xs.clone().map(move |x| (x, y)))
            .map(|(x, y)| self.picture.at(x, y))
    }
}
