//! A sheet through the mirror, whose cut edge can be located to a hundredth of a pixel.
//!
//! It is white on black, leans against the mirror, and only cameras behind the mirror see it: so
//! the reflection of its front half shows up to the cut, and nothing real hides what is cut wrong.

use bevy::{
    asset::RenderAssetUsages,
    math::{DVec2, DVec3},
    mesh::{Indices, PrimitiveTopology},
    prelude::*,
};

use crate::{
    coded::Coder,
    lens::Lens,
    quad::Quad,
    support::{
        cut::Plane,
        scene::{Object, Scene},
    },
};

/// How far the sheet reaches to both sides of the cut at most, in pixels of the report.
const REACH_PX: f64 = 24.0;

/// Where the cut must lie, in pixels of the picture that it is measured in.
#[derive(Clone, Copy, Debug)]
pub struct Cut {
    pub from: DVec2,
    pub to: DVec2,
    /// Towards the part that is kept, of unit length, square to the cut.
    pub kept: DVec2,
    /// Along the sides of that part, from the two ends.
    pub sides: [DVec2; 2],
    /// How many of these pixels are one of the report's.
    pub magnification: f64,
    /// To how many pixels of the report beside the cut nothing but the sheet and its reflection
    /// shows.
    pub window: f64,
}

/// The scene with nothing but its mirror and the sheet, magnified; and the cut.
///
/// `None` where the mirror shows too little of a sheet to measure anything.
pub fn sheet(scene: &Scene, exact: &Scene, magnification: u32) -> Option<(Scene, Cut)> {
    let lens = Lens::new(exact);
    let quad = Quad::of(&exact.mirrors[0]);
    let plane = quad.plane();
    let ([start, end], window) = line(&lens, &quad)?;
    let [a, b] = [lens.meets(start, &plane)?, lens.meets(end, &plane)?];
    let lean = lean(&lens, &plane, a, b, window)?;

    let mut drawn = scene.clone();
    drawn.size *= magnification;
    drawn.clear_color = Color::BLACK;
    drawn.props.clear();
    drawn.objects.clear();
    // Its numbers are small, its place is the mirror's: exact wherever that is.
    let here = exact.mirrors[0].transform.translation.as_dvec3();
    let corners = [a - lean, b - lean, b + lean, a + lean].map(|p| (p - here).as_vec3());
    drawn.objects.push(Object {
        mesh: mesh(corners),
        transform: Transform::from_translation(scene.mirrors[0].transform.translation),
        look: Coder::new(scene).only_reflected(),
    });

    // Of the sheet as it is after rounding.
    let [p, q, r, s] = corners.map(|corner| corner.as_dvec3() + here);
    let crossing = |behind: DVec3, before: DVec3| {
        let (low, high) = (plane.height(behind), plane.height(before));
        behind + (before - behind) * (low / (low - high))
    };
    let (start, end) = (crossing(p, s), crossing(q, r));
    let from = lens.project(start)?;
    let to = lens.project(end)?;
    let square = (to - from).perp().normalize_or_zero();
    let sides = [
        lens.project(plane.reflect(start + lean))? - from,
        lens.project(plane.reflect(end + lean))? - to,
    ];
    let magnification = f64::from(magnification);
    let cut = Cut {
        from: from * magnification,
        to: to * magnification,
        kept: square * square.dot(sides[0]).signum(),
        sides,
        magnification,
        window,
    };
    Some((drawn, cut))
}

/// Half widths to look at, in pixels of the report; the first that the mirror has room for.
const WINDOWS_PX: [f64; 4] = [6.0, 4.0, 2.5, 1.5];
/// Of the line, in pixels of the report.
const MIN_LENGTH_PX: f64 = 16.0;

/// A line through the middle of what shows of the mirror, slanted so that a raster of pixels
/// samples it at every phase; and the half width around it that shows nothing but the mirror.
fn line(lens: &Lens, quad: &Quad) -> Option<([DVec2; 2], f64)> {
    let raster = lens.raster(quad);
    let plane = quad.plane();
    let middle = raster.iter().sum::<DVec2>() / raster.len().max(1) as f64;
    let shown = |place: DVec2| {
        let on_screen = place.cmpge(DVec2::ZERO).all() && place.cmple(lens.size).all();
        on_screen && lens.shows(place, quad, &plane)
    };
    let longest = |direction: DVec2, window: f64| {
        let beside = direction.perp() * (window + 1.0);
        let clear = |half: f64| {
            [-half, half].iter().all(|along| {
                let place = middle + direction * *along;
                [-beside, beside]
                    .iter()
                    .all(|beside| shown(place + *beside))
            })
        };
        let step = lens.size.max_element() / 400.0;
        (1..200)
            .map(|i| f64::from(i) * step)
            .take_while(|half| clear(*half))
            .last()
            .unwrap_or(0.0)
    };
    WINDOWS_PX.iter().find_map(|&window| {
        let (half, direction) = (0..24)
            .map(|i| DVec2::from_angle(0.061 + f64::from(i) * std::f64::consts::PI / 24.0))
            .map(|direction| (longest(direction, window), direction))
            .max_by(|a, b| a.0.total_cmp(&b.0))?;
        // A share of it, so that the ends stay clear of the mirror's frame.
        let half = half * 0.9;
        let ends = [middle - direction * half, middle + direction * half];
        (half * 2.0 > MIN_LENGTH_PX).then_some((ends, window))
    })
}

/// From the line `a` to `b` of the plane to the front edge of the sheet.
fn lean(lens: &Lens, plane: &Plane, a: DVec3, b: DVec3, window: f64) -> Option<DVec3> {
    let across = plane.normal.cross(b - a).normalize_or_zero();
    let (middle, along) = ((a + b) / 2.0, lens.project(b)? - lens.project(a)?);
    let square = along.perp().normalize_or_zero();
    let at = lens.project(middle)?;
    // How far the reflections of the front and of the back half reach from the line.
    let shown = |lean: DVec3| -> Option<f64> {
        let front = lens.project(plane.reflect(middle + lean))? - at;
        let back = lens.project(plane.reflect(middle - lean))? - at;
        let (front, back) = (front.dot(square), back.dot(square));
        (front * back < 0.0).then(|| front.abs().min(back.abs()))
    };
    let best = [across, -across]
        .map(|across| (plane.normal + across).normalize())
        .into_iter()
        .filter_map(|direction| {
            // The longest of ever shorter ones that reaches no farther than it needs to.
            let start = (b - a).length().max(1e-3) * 64.0;
            (0..60)
                .map(|i| direction * start * 0.75_f64.powi(i))
                .find(|lean| shown(*lean).is_some_and(|reach| reach < REACH_PX))
        })
        .filter_map(|lean| Some((shown(lean)?, lean)))
        .max_by(|a, b| a.0.total_cmp(&b.0))?;
    (best.0 > window * 1.5).then_some(best.1)
}

fn mesh(corners: [Vec3; 4]) -> Mesh {
    let normal = (corners[1] - corners[0]).cross(corners[3] - corners[0]);
    Mesh::new(
        PrimitiveTopology::TriangleList,
        RenderAssetUsages::default(),
    )
    .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, corners.to_vec())
    .with_inserted_attribute(
        Mesh::ATTRIBUTE_NORMAL,
        vec![normal.normalize_or(Vec3::Z); 4],
    )
    .with_inserted_indices(Indices::U32(vec![0, 1, 2, 0, 2, 3]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes;

    #[test]
    fn every_scene_of_the_report_has_a_sheet_that_shows() {
        for case in scenes::all() {
            let case = case.sized(180);
            let (_, cut) = sheet(&case.scene, case.exact(), 2)
                .unwrap_or_else(|| panic!("{} has none", case.name));
            let length = cut.from.distance(cut.to) / cut.magnification;
            assert!(length > 8.0, "{}: {length} px", case.name);
        }
    }
}
