//! The slack box of a point given by floats: all the points that round to it, half an ulp a coordinate.
//!
//! A point of a surface can hardly be said in floats. So a point with a normal stands for its box, and the question is
//! put to a point of a surface inside it, found exactly.

use glam::DVec3;
use umbriel_geometry::{
    Aabb, Dyadic, ExactPoint, Facets, LightSource, Point, Ring, Sign, Surd, blocking::Probe, predicates::exact_side,
};

use crate::{bodies::Round, query::Precision};

/// A point and half an ulp round it.
pub(crate) struct SlackBox {
    position: DVec3,
    /// Half an ulp of each coordinate; zero for a zero coordinate.
    half: DVec3,
    /// The box, rounded outward.
    pub(crate) bounds: Aabb,
}

impl SlackBox {
    /// The box of `position`, whose coordinates came in as floats of `precision`.
    pub(crate) fn new(position: DVec3, precision: Precision) -> Self {
        let ulp = |coordinate: f64| {
            let size = coordinate.abs();
            match precision {
                _ if size == 0.0 => 0.0,
                Precision::Double => size.next_up() - size,
                Precision::Single => f64::from((size as f32).next_up()) - f64::from(size as f32),
            }
        };
        let half = DVec3::from_array(position.to_array().map(|coordinate| 0.5 * ulp(coordinate)));
        Self { position, half, bounds: Aabb { min: position, max: position }.widened(half) }
    }

    /// Whether the side of a flat face that can be lit makes an acute angle with the normal.
    pub(crate) fn is_meant(
        &self,
        facets: &Facets,
        face: usize,
        normal: DVec3,
        is_one_sided: bool,
        light: &LightSource,
    ) -> bool {
        let turn = facets.turn(face, light);
        let lit_side =
            if is_one_sided { if facets.is_mirrored() { Sign::Negative } else { Sign::Positive } } else { turn };
        // The face's normal against the given one: the face's side of a light far away along it.
        let far = LightSource::sun((-normal).to_array());
        far.is_ok_and(|far| facets.turn(face, &far).times(lit_side) == Sign::Positive)
    }

    /// A point of a flat face inside the box; `None` when they do not meet.
    pub(crate) fn point_on_face(&self, facets: &Facets, face: usize) -> Option<Probe<'static>> {
        let corners: Vec<ExactPoint> =
            facets.facet(face).corners().iter().map(|&corner| facets.point(corner).to_exact()).collect();
        let x = self.straight_to(&corners).or_else(|| self.clip(corners))?;
        Some(Probe::new(self.whole(), || x))
    }

    /// The box as a filter sees any point inside it.
    fn whole(&self) -> Point<'static> {
        Point { position: self.position, slack: self.half, exact: None }
    }

    /// The point of the face's plane straight above or below the middle along some axis, if it lies in the face and in
    /// the box.
    fn straight_to(&self, corners: &[ExactPoint]) -> Option<ExactPoint> {
        let plane = |x: &ExactPoint| exact_side(&corners[0], &corners[1], &corners[corners.len() - 1], x);
        let middle = ExactPoint::from_position(self.position);
        let height = plane(&middle);
        (0..3).find_map(|axis| {
            let mut direction = ExactPoint::from_position(DVec3::AXES[axis]);
            direction.w = Dyadic::zero();
            let slope = plane(&direction);
            let upward = match slope.sign() {
                Sign::Zero => return None,
                sign => sign == Sign::Positive,
            };
            // middle·slope − direction·height, over the weight slope > 0.
            let (slope, height) = if upward { (slope, height.clone()) } else { (-slope, -height.clone()) };
            let mut xyz = middle.xyz.clone().map(|coordinate| coordinate * slope.clone());
            xyz[axis] = xyz[axis].clone() - height;
            let x = ExactPoint { xyz, w: slope };
            (self.holds(&x) && lies_inside(corners, &x)).then_some(x)
        })
    }

    /// The face cut by the box's six planes, one corner of what is left (Sutherland & Hodgman 1974, in exact numbers).
    fn clip(&self, corners: Vec<ExactPoint>) -> Option<ExactPoint> {
        let mut polygon = corners;
        for plane in 0..6 {
            let inside: Vec<Dyadic> = polygon.iter().map(|corner| self.inside_by(corner, plane)).collect();
            let mut kept = Vec::new();
            for (i, corner) in polygon.iter().enumerate() {
                let next = (i + 1) % polygon.len();
                if inside[i].sign() != Sign::Negative {
                    kept.push(corner.clone());
                }
                if inside[i].sign().times(inside[next].sign()) == Sign::Negative {
                    kept.push(crossing(corner, &inside[i], &polygon[next], &inside[next]));
                }
            }
            polygon = kept;
        }
        polygon.into_iter().next()
    }

    /// How far inside one of the box's planes a point lies, times its weight.
    fn inside_by<R: Ring>(&self, x: &ExactPoint<R>, plane: usize) -> R {
        let axis = plane / 2;
        let half = R::from_f64(self.half[axis]);
        let offset = x.xyz[axis].clone() - x.w.clone() * R::from_f64(self.position[axis]);
        let reach = x.w.clone() * half;
        if plane.is_multiple_of(2) { reach - offset } else { reach + offset }
    }

    fn holds<R: Ring>(&self, x: &ExactPoint<R>) -> bool {
        (0..6).all(|plane| self.inside_by(x, plane).sign() != Sign::Negative)
    }

    /// A point of a sphere inside the box, one with its outer normal at an acute angle to the given one where it can be
    /// had; and whether it can. Looks along the rays from the centre through the middle and the corners of the box, and
    /// along the box's edges: where the sphere meets the box otherwise, its points are all beside the box's middle.
    pub(crate) fn point_on_sphere(&self, round: &Round, normal: DVec3) -> Option<(Probe<'static, Surd>, bool)> {
        let (sphere, placement) = (&round.sphere, &round.placement);
        let corner = |i: usize| -> [Dyadic; 3] {
            std::array::from_fn(|axis| {
                let half = if i >> axis & 1 == 0 { -self.half[axis] } else { self.half[axis] };
                Dyadic::new(self.position[axis]) + Dyadic::new(half)
            })
        };
        let middle = self.position.to_array().map(Dyadic::new);
        let targets = std::iter::once(middle).chain((0..8).map(corner));
        let radial = targets.filter_map(|target| sphere.radial_point(placement, &target));
        let edges = (0..3).flat_map(|axis| (0..8).filter(move |i| i >> axis & 1 == 0).map(move |i| (axis, i)));
        let crossings = edges.filter_map(|(axis, i)| {
            let along = DVec3::AXES[axis].to_array().map(Dyadic::new);
            sphere.points_on_line(placement, &corner(i), &along)
        });
        let mut other = None;
        for x in radial.chain(crossings.flatten()).filter(|x| self.holds(x)) {
            let outward = sphere.outward(placement, &x);
            let along = (0..3).map(|k| outward[k].clone() * Surd::from_f64(normal[k]));
            let is_meant = along.reduce(|sum, term| sum + term)?.sign() == Sign::Positive;
            let probe = Probe::new(self.whole(), || x);
            if is_meant {
                return Some((probe, true));
            }
            other = Some((probe, false));
        }
        other
    }
}

/// Whether a point of the plane of a convex polygon lies in the closed polygon.
fn lies_inside(corners: &[ExactPoint], x: &ExactPoint) -> bool {
    // Against the planes through each edge and along the normal's largest axis, all must agree with the polygon's turn.
    let [a, b, c] = [&corners[0], &corners[1], &corners[corners.len() - 1]];
    let turns = |p: &ExactPoint, q: &ExactPoint, r: &ExactPoint, axis: usize| {
        let mut direction = ExactPoint::from_position(DVec3::AXES[axis]);
        direction.w = Dyadic::zero();
        exact_side(p, q, r, &direction).sign()
    };
    let Some((axis, turn)) = (0..3).map(|axis| (axis, turns(a, b, c, axis))).find(|&(_, turn)| turn != Sign::Zero)
    else {
        return false;
    };
    (0..corners.len()).all(|i| {
        let next = &corners[(i + 1) % corners.len()];
        turns(&corners[i], next, x, axis).times(turn) != Sign::Negative
    })
}

/// The point between two corners, on different sides of a plane, where the plane is crossed.
fn crossing(a: &ExactPoint, a_inside: &Dyadic, b: &ExactPoint, b_inside: &Dyadic) -> ExactPoint {
    // a·|b_inside| + b·|a_inside|, weights included.
    let size = |value: &Dyadic| if value.sign() == Sign::Negative { -value.clone() } else { value.clone() };
    let (to_a, to_b) = (size(b_inside), size(a_inside));
    let mix = |x: &Dyadic, y: &Dyadic| x.clone() * to_a.clone() + y.clone() * to_b.clone();
    ExactPoint { xyz: std::array::from_fn(|k| mix(&a.xyz[k], &b.xyz[k])), w: mix(&a.w, &b.w) }
}
