//! A planar convex occluder seen from one receiver: its shadow there, without projecting anything.
//!
//! For a polygon (a_0 … a_n) with the light strictly on one side of its plane, a point p is blocked exactly when p lies
//! on the inner side of every shadow plane (a_i, a_{i+1}, light), borders included, and strictly beyond the polygon's
//! own plane. All of these are affine in p. Turning every polygon counter-clockwise *in the projection* is the sign of
//! its plane at the light (NUMERICS.md, "Blocking as signs").

use umbriel_geometry::{Approx, Point, Sign};

use super::{
    borders::Border,
    field::{Field, Weights},
    outline::{Outline, ParamBox},
    pattern::POINTS,
    receiver::Receiver,
};

/// A facet of the scene: which object, which face.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct FacetId {
    pub(crate) object: u32,
    pub(crate) facet: u32,
}

/// The functions `sides` use numbers 0..4; this one is "strictly beyond the polygon's plane".
pub(crate) const NEARER: usize = 4;

/// A polygon as an occluder of one receiver with N corners.
#[derive(Clone, Debug)]
pub(crate) struct PolygonBlocker<const N: usize> {
    pub(crate) id: FacetId,
    /// Inner side of each shadow plane ≥ 0; number 4 is > 0 where the polygon is strictly nearer to the light.
    functions: [Field<N>; 5],
    side_count: usize,
    /// The light lies in the polygon's plane: it blocks no area, but no cell that it touches is proved lit.
    pub(crate) edge_on: bool,
    /// What each edge is to the sum of all polygons.
    pub(crate) border: [Border; 4],
    /// The same number for all polygons that hang together by edges.
    pub(crate) sheet: u32,
    /// Where its holes are listed, if it has any: it blocks where it is opaque only.
    pub(crate) holes: Option<u32>,
    outline: Outline,
}

impl<const N: usize> PolygonBlocker<N> {
    /// Of corners with a number for each position; `None` when the polygon cannot block any point of the receiver.
    /// `light_side` is the side of the polygon's plane on which the light lies, `is_clear` what is known of [`Receiver::is_clear_of`]. Inlined, as its 600 bytes are made in place then.
    #[inline(always)]
    pub(crate) fn new(
        id: FacetId,
        numbered: &[(Point, u32)],
        light_side: Sign,
        receiver: &Receiver<N>,
        is_clear: Option<bool>,
    ) -> Option<Self> {
        let mut points = [numbered[0].0; 4];
        points.iter_mut().zip(numbered).for_each(|(point, corner)| *point = corner.0);
        let corners = &points[..numbered.len()];
        let sign = if light_side == Sign::Negative { -1.0 } else { 1.0 };
        let edge_on = light_side == Sign::Zero;
        let nearer = Field::new(receiver.sides_of_plane(corners, -sign));
        let beyond_reach = if edge_on { has_one_sign(&nearer) } else { everywhere(&nearer, |v| v <= 0.0) };
        if beyond_reach || is_clear.unwrap_or_else(|| receiver.is_clear_of(corners)) {
            return None;
        }
        let mut functions = [nearer; 5];
        for (i, (from, low)) in numbered.iter().enumerate() {
            let (to, high) = &numbered[(i + 1) % numbered.len()];
            // From the lower number to the higher: all polygons at an edge have one function of it, to the last bit.
            let (ends, sign) = if low < high { ([from, to], sign) } else { ([to, from], -sign) };
            let side = Field::new(receiver.sides_of_shadow_plane(ends, sign));
            let misses = if edge_on { has_one_sign(&side) } else { is_outside(&side, &nearer) };
            if misses {
                return None;
            }
            functions[i] = side;
        }
        let side_count = corners.len();
        let outline = match (receiver.facing, edge_on) {
            (None, _) => Outline::UNBOUNDED,
            (_, true) => Outline::of_images(corners, receiver),
            (_, false) => {
                Outline::new(&functions[..side_count]).unwrap_or_else(|| Outline::of_images(corners, receiver))
            }
        };
        Some(Self {
            id,
            functions,
            side_count,
            edge_on,
            holes: None,
            border: [Border::default(); 4],
            sheet: 0,
            outline,
        })
    }

    /// Function `index`: a side's, or [`NEARER`].
    pub(crate) fn function(&self, index: usize) -> &Field<N> {
        &self.functions[index]
    }

    /// The numbers of all functions.
    #[inline]
    pub(crate) fn function_indices(&self) -> impl Iterator<Item = usize> + use<N> {
        let indices: &[usize] = if self.side_count == 3 { &[0, 1, 2, NEARER] } else { &[0, 1, 2, 3, NEARER] };
        indices.iter().copied()
    }

    /// The numbers of the functions of which nothing is known: bit f of `known` is that of function f.
    #[inline]
    pub(crate) fn open_functions(&self, known: u8) -> impl Iterator<Item = usize> + use<N> {
        self.function_indices().filter(move |index| known & (1 << index) == 0)
    }

    /// Whether the functions but those `known` are surely positive at a point.
    #[inline]
    pub(crate) fn holds(&self, known: u8, probe: &Weights<N>) -> bool {
        self.open_functions(known).all(|index| {
            let value = self.functions[index].at(probe);
            value.value > value.error
        })
    }

    /// A bound on the shadow in the face's parameters.
    pub(crate) fn reach(&self) -> &ParamBox {
        &self.outline.reach
    }

    /// The borders and the cut that may meet the inside of a cell, with the numbers of their functions; those that are known to be on the blocking
    /// side do not. `cell` bounds its parameters, on a flat face.
    #[inline]
    pub(crate) fn crossing(&self, known: u8, cell: Option<&ParamBox>) -> impl Iterator<Item = (usize, Border)> {
        self.open_functions(known).filter_map(move |index| {
            if index == NEARER {
                return Some((index, Border::CUT));
            }
            let border = self.border[index];
            let is_beside = || cell.is_some_and(|cell| cell.misses_inside(&self.outline.edge(index, self.side_count)));
            (border.net > 0 && !is_beside()).then_some((index, border))
        })
    }

    /// How the way from a point meets a triangle, as a [`FaceCutOut`](umbriel_geometry::cut_out::FaceCutOut) takes it: what the
    /// side opposite each corner says.
    pub(crate) fn way(&self, weights: &Weights<N>) -> [Approx; 3] {
        [1, 2, 0].map(|opposite| self.functions[opposite].near(weights))
    }

    /// The same as far as floats tell, for estimates.
    pub(crate) fn likely_way(&self, weights: &Weights<N>) -> [f64; 3] {
        [1, 2, 0].map(|opposite| self.functions[opposite].at(weights).value)
    }

    /// Whether the polygon, without holes, blocks the point with these weights; `None` where the bounds cannot tell.
    pub(crate) fn blocks(&self, weights: &Weights<N>) -> Option<bool> {
        self.blocks_by(|function| function.near(weights))
    }

    /// The same of a point whose weights are exact.
    pub(crate) fn blocks_at(&self, weights: &Weights<N>) -> Option<bool> {
        self.blocks_by(|function| function.at(weights))
    }

    #[inline(always)]
    fn blocks_by(&self, value: impl Fn(&Field<N>) -> Approx) -> Option<bool> {
        if self.edge_on {
            return None;
        }
        let mut certain = true;
        for index in self.function_indices() {
            match value(&self.functions[index]).sign() {
                Some(Sign::Negative) => return Some(false),
                Some(Sign::Zero) if index == NEARER => return Some(false),
                Some(_) => {}
                None => certain = false,
            }
        }
        certain.then_some(true)
    }

    /// The likely answers at points of a flat face, a bit each, for estimates; without holes. Bit f of `known`: function f is on the blocking side at
    /// all of them.
    pub(crate) fn probably_blocked(&self, known: u8, [u, v]: &[[f64; POINTS]; 2]) -> u16 {
        let mut blocked = if self.edge_on { 0 } else { u16::MAX };
        for index in self.open_functions(known) {
            let [constant, along_u, along_v] = self.functions[index].along_parameters();
            let mut inner = 0;
            for k in 0..POINTS {
                let value = constant + along_u * u[k] + along_v * v[k];
                inner |= u16::from(value > 0.0 || (value == 0.0 && index != NEARER)) << k;
            }
            blocked &= inner;
        }
        blocked
    }

    /// The likely answer, for estimates; without holes.
    pub(crate) fn probably_blocks(&self, weights: &Weights<N>) -> bool {
        !self.edge_on
            && self.function_indices().all(|index| {
                let value = self.functions[index].at(weights).value;
                value > 0.0 || (value == 0.0 && index != NEARER)
            })
    }
}

fn corners<const N: usize>(field: &Field<N>) -> impl Iterator<Item = Approx> + '_ {
    (0..N).map(|k| field.corner(k))
}

/// Whether an upper bound of the function fulfils `test` at all corners, and so everywhere.
fn everywhere<const N: usize>(field: &Field<N>, test: impl Fn(f64) -> bool) -> bool {
    corners(field).all(|corner| test(corner.value + corner.error))
}

/// Whether no point is on the inner side of an edge and beyond the polygon's plane: where the side's function vanishes, if anywhere, the receiver is in that plane
/// or before it, as along an edge or at a corner that both share.
fn is_outside<const N: usize>(side: &Field<N>, nearer: &Field<N>) -> bool {
    corners(side).zip(corners(nearer)).all(|(side, nearer)| {
        let side = side.value + side.error;
        side < 0.0 || (side == 0.0 && nearer.value + nearer.error <= 0.0)
    })
}

/// Whether the function is strictly positive everywhere, or strictly negative everywhere.
fn has_one_sign<const N: usize>(field: &Field<N>) -> bool {
    corners(field).all(|c| c.value > c.error) || corners(field).all(|c| -c.value > c.error)
}
