//! Random scenes at the extremes: one mirror, one camera, and every number that a user could get
//! wrong spread evenly in its logarithm.
//!
//! A scene is made of [`Shares`], numbers from 0 to 1, and of nothing else. 0 stands for what is
//! usual, so that [`shrink`] can tell which of a failing scene's extremes matter.

use core::f64::consts::{PI, TAU};

use bevy_planar_mirror::math::{PlanarPatch, ViewInput, transform_patch};
use glam::{DAffine3, DMat3, DMat4, DQuat, DVec2, DVec3, DVec4, EulerRot};

use super::split_mix::SplitMix;

/// More than a scene draws.
const COUNT: usize = 64;

/// What a scene is made of.
pub type Shares = [f64; COUNT];

/// The shares of one seed.
pub fn shares(seed: u64) -> Shares {
    let mut random = SplitMix::new(seed);
    [0.0; COUNT].map(|_| random.share())
}

/// The tamest shares, one after the other, for which `fails` still holds.
pub fn shrink(mut shares: Shares, mut fails: impl FnMut(&Shares) -> bool) -> Shares {
    for index in 0..COUNT {
        for factor in [0.0, 0.5, 0.9] {
            let mut tamer = shares;
            tamer[index] *= factor;
            if fails(&tamer) {
                shares = tamer;
                break;
            }
        }
    }
    shares
}

/// What a random scene is about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    Any,
    /// The camera looks straight at the mirror, or by 1e-12 radian beside.
    HeadOn,
    /// The eye is hardly above the mirror's plane.
    Grazing,
    Orthographic,
    /// Thousands of units from the origin, at the extremes ten million.
    FarAway,
}

pub const KINDS: [Kind; 5] = [
    Kind::Any,
    Kind::HeadOn,
    Kind::Grazing,
    Kind::Orthographic,
    Kind::FarAway,
];

/// A camera's projection, in the numbers a user gives. `shift` is how far off center, in clip space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    Perspective {
        fov: f64,
        aspect: f64,
        near: f64,
        far: Option<f64>,
        shift: DVec2,
    },
    Orthographic {
        height: f64,
        aspect: f64,
        near: f64,
        far: f64,
        shift: DVec2,
    },
}

impl Projection {
    /// View to clip space with reversed depth, each entry exactly an `f32`.
    pub fn clip_from_view(&self) -> DMat4 {
        let columns = match *self {
            Self::Perspective {
                fov,
                aspect,
                near,
                far,
                shift,
            } => {
                let y = 1.0 / (0.5 * fov).tan();
                let (depth, offset) = match far {
                    None => (0.0, near),
                    Some(far) => (near / (far - near), near * far / (far - near)),
                };
                [
                    DVec4::new(y / aspect, 0.0, 0.0, 0.0),
                    DVec4::new(0.0, y, 0.0, 0.0),
                    DVec4::new(shift.x, shift.y, depth, -1.0),
                    DVec4::new(0.0, 0.0, offset, 0.0),
                ]
            }
            Self::Orthographic {
                height,
                aspect,
                near,
                far,
                shift,
            } => {
                let span = far - near;
                [
                    DVec4::new(2.0 / (height * aspect), 0.0, 0.0, 0.0),
                    DVec4::new(0.0, 2.0 / height, 0.0, 0.0),
                    DVec4::new(0.0, 0.0, 1.0 / span, 0.0),
                    DVec4::new(shift.x, shift.y, far / span, 1.0),
                ]
            }
        };
        let [x, y, z, w] = columns;
        DMat4::from_cols(x, y, z, w).as_mat4().as_dmat4()
    }
}

/// One mirror and one camera, everything exactly an `f32`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extreme {
    pub camera: DAffine3,
    pub projection: Projection,
    pub viewport_size: DVec2,
    pub jitter_px: f64,
    pub mirror: DAffine3,
    /// Half the size of the mirror in its own plane z = 0, which faces +Z. `None` if not known.
    pub half_size: Option<DVec2>,
    pub was_drawn: bool,
}

impl Extreme {
    /// The scene of a seed. `Extreme::of(Kind::Any, 7)` is the same on every machine.
    pub fn of(kind: Kind, seed: u64) -> Self {
        Self::from_shares(kind, &shares(seed))
    }

    pub fn from_shares(kind: Kind, shares: &Shares) -> Self {
        let draw = &mut Draw(shares.iter());
        let projection = any_projection(draw, kind);
        let viewport_size = any_viewport(draw, &projection);
        let jitter_px = draw.rarely(0.2).map_or(0.0, |_| 0.5);
        let half_size = DVec2::new(draw.spread(1.0, 1e-2, 1e2), draw.spread(1.0, 1e-2, 1e2));
        let is_bounded = draw.rarely(0.03).is_none();
        let mirror = any_mirror(draw, kind);
        let camera = any_camera(draw, kind, &mirror, half_size);
        Self {
            camera,
            projection,
            viewport_size,
            jitter_px,
            mirror,
            half_size: is_bounded.then_some(half_size),
            was_drawn: draw.rarely(0.5).is_some(),
        }
    }

    /// `None` if the mirror's transform leaves no plane.
    pub fn input(&self) -> Option<ViewInput> {
        let half_size = self.half_size.unwrap_or(DVec2::INFINITY);
        let (plane, corners) = transform_patch(&patch(half_size), &self.mirror)?;
        Some(ViewInput {
            world_from_view: self.camera,
            clip_from_view: self.projection.clip_from_view(),
            viewport_size: self.viewport_size,
            plane,
            corners,
            jitter_px: self.jitter_px,
            was_drawn: self.was_drawn,
        })
    }
}

pub fn patch(half_size: DVec2) -> PlanarPatch {
    PlanarPatch {
        center: DVec3::ZERO,
        tangent_x: DVec3::X,
        tangent_y: DVec3::Y,
        half_size,
    }
}

/// Takes the shares one by one; every function below takes always as many.
struct Draw<'a>(core::slice::Iter<'a, f64>);

impl Draw<'_> {
    fn share(&mut self) -> f64 {
        *self.0.next().expect("a scene takes fewer shares")
    }

    /// In `odds` of all scenes, a share anew.
    fn rarely(&mut self, odds: f64) -> Option<f64> {
        let above = self.share() - (1.0 - odds);
        (above >= 0.0).then_some(above / odds)
    }

    fn log(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.share())
    }

    /// What is usual in every third scene, else anything between the extremes.
    fn spread(&mut self, usual: f64, low: f64, high: f64) -> f64 {
        match self.rarely(2.0 / 3.0) {
            None => usual,
            Some(share) => low * (high / low).powf(share),
        }
    }

    fn signed(&mut self) -> f64 {
        match self.rarely(0.8) {
            None => 0.0,
            Some(share) => 2.0 * share - 1.0,
        }
    }

    fn vector(&mut self) -> DVec3 {
        DVec3::new(self.signed(), self.signed(), self.signed())
    }

    /// A scale of each axis, negative ones too, and a shear.
    fn stretch(&mut self, odds: f64, low: f64, high: f64) -> DMat3 {
        let is_uniform = self.rarely(0.3).is_none();
        let scale = [0; 3].map(|_| self.spread(1.0, low, high));
        let scale = if is_uniform { [scale[0]; 3] } else { scale };
        let sign = [0; 3].map(|_| self.rarely(0.2).map_or(1.0, |_| -1.0));
        let shear = self.vector();
        let is_sheared = self.rarely(0.2).is_some();
        if self.rarely(odds).is_none() {
            return DMat3::IDENTITY;
        }
        let axes = DMat3::from_diagonal(DVec3::from(scale) * DVec3::from(sign));
        if is_sheared {
            let slant = DMat3::from_cols(
                DVec3::X,
                DVec3::new(shear.x, 1.0, 0.0),
                DVec3::new(shear.y, shear.z, 1.0),
            );
            slant * axes
        } else {
            axes
        }
    }
}

fn any_projection(draw: &mut Draw, kind: Kind) -> Projection {
    let half = draw.spread(PI / 6.0, PI / 360.0, 0.5 * PI);
    // The same figures at the wide end: 1 degree short of a straight angle.
    let half = if half > PI / 4.0 {
        0.5 * PI - PI / 360.0 * (PI / 4.0 / (PI / 360.0)).powf(2.0 - half / (PI / 4.0))
    } else {
        half
    };
    let aspect = draw.spread(16.0 / 9.0, 1e-2, 1e2);
    let near = draw.spread(0.1, 1e-6, 1e2);
    let far_ratio = draw
        .rarely(0.3)
        .map(|share| 10.0_f64.powf(1.0 + 6.0 * share));
    let is_shifted = draw.rarely(0.2).is_some();
    let shift = DVec2::new(2.0 * draw.signed(), 2.0 * draw.signed());
    let shift = if is_shifted { shift } else { DVec2::ZERO };
    let height = draw.spread(10.0, 1e-2, 1e3);
    let far = draw.spread(1e3, 1.0, 1e6);
    let begins_behind = draw.rarely(0.3).is_some();
    let is_orthographic = draw.rarely(0.15).is_some();
    if kind == Kind::Orthographic || (kind != Kind::HeadOn && is_orthographic) {
        Projection::Orthographic {
            height,
            aspect,
            near: if begins_behind { -far } else { 0.0 },
            far,
            shift,
        }
    } else {
        Projection::Perspective {
            fov: 2.0 * half,
            aspect,
            near,
            far: far_ratio.map(|ratio| near * ratio),
            shift,
        }
    }
}

fn any_viewport(draw: &mut Draw, projection: &Projection) -> DVec2 {
    let (Projection::Perspective { aspect, .. } | Projection::Orthographic { aspect, .. }) =
        *projection;
    let longer = draw.spread(1920.0, 16.0, 8192.0);
    let size = DVec2::new(longer * aspect.min(1.0), longer / aspect.max(1.0));
    size.round().max(DVec2::ONE)
}

fn any_mirror(draw: &mut Draw, kind: Kind) -> DAffine3 {
    let turn = DQuat::from_euler(
        EulerRot::XYZ,
        draw.signed() * PI,
        draw.signed() * PI,
        draw.signed() * PI,
    );
    let mut stretch = draw.stretch(0.6, 1e-3, 1e3);
    if draw.rarely(0.1).is_some() {
        stretch.z_axis = DVec3::ZERO;
    }
    let direction = draw.vector();
    let distance = draw.share();
    let near_by = draw.rarely(0.6).is_none();
    let offset = match kind {
        Kind::FarAway => 10.0_f64.powf(3.0 + 4.0 * distance),
        _ if near_by => 0.0,
        _ => 10.0_f64.powf(-2.0 + 7.0 * distance),
    };
    rounded(DAffine3 {
        matrix3: DMat3::from_quat(turn) * stretch,
        translation: direction * offset,
    })
}

fn any_camera(draw: &mut Draw, kind: Kind, mirror: &DAffine3, half_size: DVec2) -> DAffine3 {
    let (x, y) = (mirror.x_axis * half_size.x, mirror.y_axis * half_size.y);
    let (normal, front) = match transform_patch(&patch(half_size), mirror) {
        Some((plane, _)) => (plane.normal, mirror.translation),
        None => (DVec3::Z, mirror.translation),
    };
    let target = front + x * draw.signed() + y * draw.signed();

    // As far as the mirror is large, or any distance.
    let size = x.length().min(y.length());
    let by_size = draw.spread(3.0, 0.1, 100.0) * size;
    let anyhow = draw.log(1e-3, 1e3);
    let distance = draw.rarely(0.4).map_or(by_size, |_| anyhow);
    let elevation = (1.0 - draw.share()) * 0.5 * PI;
    let any_height = draw.log(1e-6, 1e3);
    let is_any_height = draw.rarely(0.4).is_some();
    let azimuth = draw.signed() * PI;
    let (tangent_x, tangent_y) = normal.any_orthonormal_pair();
    let beside = tangent_x * azimuth.cos() + tangent_y * azimuth.sin();
    let (lateral, height) = match kind {
        Kind::HeadOn => (0.0, distance),
        Kind::Grazing => (distance, any_height.min(distance)),
        _ if is_any_height => (distance, any_height),
        _ => (distance * elevation.cos(), distance * elevation.sin()),
    };
    let side = draw.rarely(0.05).map_or(1.0, |_| -1.0);
    let eye = target + beside * lateral + normal * height * side;

    let toward = match kind {
        Kind::HeadOn => -normal,
        _ => (target - eye).try_normalize().unwrap_or(-normal),
    };
    let (across, up) = toward.any_orthonormal_pair();
    let roll = draw.signed() * TAU;
    let across = across * roll.cos() + up * roll.sin();
    let tilt = match (kind, draw.rarely(0.6)) {
        (_, None) => 0.0,
        (Kind::HeadOn, Some(share)) => 10.0_f64.powf(-12.0 + 10.0 * share),
        (_, Some(share)) => PI * 10.0_f64.powf(-7.0 + 7.0 * share),
    };
    let toward = DQuat::from_axis_angle(across, tilt) * toward;
    let z = -toward;
    let turned = DMat3::from_cols(across, z.cross(across), z);
    let spin = DMat3::from_quat(DQuat::from_axis_angle(DVec3::Z, draw.signed() * PI));
    rounded(DAffine3 {
        matrix3: turned * spin * draw.stretch(0.3, 1e-2, 1e2),
        translation: eye,
    })
}

fn rounded(affine: DAffine3) -> DAffine3 {
    affine.as_affine3a().as_daffine3()
}
