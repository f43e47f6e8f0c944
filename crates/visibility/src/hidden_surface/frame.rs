//! Pixels and the rays through their centres, in the coordinates of the eye, with bounds.
//!
//! View coordinates are left-handed: x to the right, y up, z ahead of the eye. A pixel with its centre at (X, Y), counted in
//! pixels from the picture's middle, Y downward, has the ray along q = (s·X, −s·Y, 1) from the eye (perspective; s is twice the
//! tangent of half the field of view, over the rows), or from (s·X, −s·Y, 0) along (0, 0, 1) (parallel; s metres a pixel).
//!
//! **What is exact.** The rays are those of [`View::ray`], floats as they are. Here they are affine in X and Y, so they
//! differ from these: in each component of a direction by six roundings at most, less than 7u·S in all, where u = 2^-53 and S
//! bounds |forward| + s·|X|·|right| + s·|Y|·|up| over the picture; in each component of a parallel ray's origin by less than 5u
//! times the sum R of the eye's coordinates and the picture's half edges. The length of a direction does not matter to signs.
//!
//! **Axes.** These are orthonormal but for rounding, and by more where the camera looks almost along its `up`. With M the matrix
//! of the axes, M = Q·(I + Ω) for an orthonormal Q and |Ω| ≤ |MᵀM − I| = ω, which is measured. A triple product that is formed
//! from products with the axes is off by less than 4ω times the product of its vectors' lengths.
//!
//! **Points.** A difference and three products and sums: each component is off by at most 4.1u times the vector's length, the
//! vector by 8u times that, and by 2σ more where its ends are known up to σ in each coordinate.

use glam::DVec3;
use umbriel_geometry::{LightDefect, LightSource};
use umbriel_scene::Projection;

use super::ShotDefect;
use crate::view::{Basis, View};

/// Half an ulp at 1.
pub(super) const U: f64 = f64::EPSILON / 2.0;

/// The eye's coordinates and what their bounds are made of; see the header.
#[derive(Debug)]
pub(super) struct Frame {
    origin: DVec3,
    basis: Basis,
    pub(super) is_parallel: bool,
    /// Metres a pixel in the plane at distance 1 (perspective), or everywhere (parallel).
    pub(super) scale: f64,
    /// Half the edges of the picture, pixels.
    pub(super) middle: [f64; 2],
    /// 4ω + 32u: what multiplies a product of lengths; see `footprint.rs`.
    pub(super) unit: f64,
    /// S; 1 for parallel rays, whose directions are one.
    pub(super) stretch: f64,
    /// R; 0 in perspective, where all rays start at the eye.
    pub(super) spread: f64,
}

impl Frame {
    pub(super) fn new(view: &View) -> Self {
        let basis = view.basis();
        let [width, height] = [view.width, view.height].map(f64::from);
        let (is_parallel, scale) = match view.camera.projection {
            Projection::Orthographic { height: metres } => (true, metres / height),
            Projection::Perspective { vertical_degrees } => {
                (false, 2.0 * (0.5 * vertical_degrees).to_radians().tan() / height)
            }
            _ => (true, 0.0),
        };
        let reach = scale * 0.5 * (width + height);
        let origin = view.camera.eye;
        let sum = origin.abs().element_sum() + reach;
        Self {
            unit: 4.0 * skew(&basis) + 32.0 * U,
            stretch: if is_parallel { 1.0 } else { 1.0 + 1.01 * reach },
            spread: if is_parallel { 1.01 * sum } else { 0.0 },
            middle: [0.5 * width, 0.5 * height],
            origin,
            basis,
            is_parallel,
            scale,
        }
    }

    /// A world point in the eye's coordinates.
    pub(super) fn point(&self, point: DVec3) -> DVec3 {
        self.basis.local(point - self.origin)
    }

    /// A difference of world points in the eye's coordinates.
    pub(super) fn vector(&self, vector: DVec3) -> DVec3 {
        self.basis.local(vector)
    }

    /// How far a point may be from the place that [`Frame::point`] gives, as seen from the ray that should meet it.
    pub(super) fn blur(&self, point: DVec3, slack: f64) -> f64 {
        let reach = point.length() + self.spread;
        self.unit * self.stretch * reach + 2.0 * slack
    }

    /// The middle of column `column`, from the picture's middle.
    #[inline]
    pub(super) fn x(&self, column: u32) -> f64 {
        f64::from(column) + 0.5 - self.middle[0]
    }

    /// The middle of row `row`, from the picture's middle, downward.
    #[inline]
    pub(super) fn y(&self, row: u32) -> f64 {
        f64::from(row) + 0.5 - self.middle[1]
    }

    /// The eye as a homogeneous point: what sees a face is what could light it.
    pub(super) fn eye(&self) -> Result<LightSource, ShotDefect> {
        let eye = if self.is_parallel {
            LightSource::sun(self.basis.forward.to_array())
        } else {
            LightSource::point(self.origin.to_array())
        };
        eye.map_err(|defect: LightDefect| ShotDefect::Eye(defect))
    }
}

/// A bound on |MᵀM − I|: three times the greatest entry, and the rounding of measuring it.
fn skew(basis: &Basis) -> f64 {
    let axes = [basis.right, basis.up, basis.forward];
    let entry = |i: usize, j: usize| axes[i].dot(axes[j]) - if i == j { 1.0 } else { 0.0 };
    let greatest = (0..9).map(|k| entry(k / 3, k % 3).abs()).fold(0.0, f64::max);
    let bound = 3.0 * (greatest + 8.0 * U);
    // The square root of MᵀM is bounded by a series that wants it near I; without that nothing is known.
    if bound < 0.25 { bound } else { f64::INFINITY }
}
