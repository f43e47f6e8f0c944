//! What an open segment meets: closed triangles, also those without area, and ellipsoids.
//!
//! A point x = (p + q·√n)/w and a light L are homogeneous, and every test on a flat piece is a function *linear in x*,
//! formed from the piece and the light first. The open segment, or for a sun the open ray, is {α·x + β·L : α, β > 0}.

use super::number::{Binary, Surd, Vector, cross, dot, is_zero, minus, plus, times, vector};
use umbriel_geometry::LightSource;

/// The point (rational + irrational·√radicand) / weight; the weight is positive.
#[derive(Clone, Debug)]
pub(crate) struct Place {
    /// Coordinates without the root, times the weight.
    pub(crate) rational: Vector,
    /// What multiplies the root.
    pub(crate) irrational: Vector,
    /// The number under the root, not negative.
    pub(crate) radicand: Binary,
    /// The common denominator.
    pub(crate) weight: Binary,
}

impl Place {
    /// A point with coordinates that are binary fractions.
    pub(crate) fn new(position: Vector) -> Self {
        Self::weighted(position, Binary::new(1.0))
    }

    /// The point position / weight.
    pub(crate) fn weighted(position: Vector, weight: Binary) -> Self {
        Self { rational: position, irrational: vector([0.0; 3]), radicand: Binary::zero(), weight }
    }

    /// The nearest floats, or nearly.
    pub(crate) fn approximate(&self) -> [f64; 3] {
        let root = self.radicand.to_nearest().sqrt();
        let weight = self.weight.to_nearest();
        std::array::from_fn(|i| (self.rational[i].to_nearest() + self.irrational[i].to_nearest() * root) / weight)
    }

    /// The sign of normal·(x − origin).
    pub(crate) fn side(&self, normal: &Vector, origin: &Vector) -> i8 {
        let offset = &dot(normal, origin) * &self.weight;
        let value =
            Surd { rational: &dot(normal, &self.rational) - &offset, irrational: dot(normal, &self.irrational) };
        value.sign(&self.radicand)
    }
}

/// A light as a homogeneous point, weight 0 for a sun.
#[derive(Clone, Debug)]
pub(crate) struct Lamp {
    /// The position, or the vector towards the sun.
    pub(crate) xyz: Vector,
    /// 1 or 0.
    pub(crate) weight: Binary,
}

impl Lamp {
    /// The light of a scene.
    pub(crate) fn new(light: &LightSource) -> Self {
        let weight = if light.is_sun() { 0.0 } else { 1.0 };
        Self { xyz: vector(light.xyz().to_array()), weight: Binary::new(weight) }
    }

    /// The vector from a point to the light, up to a positive factor.
    pub(crate) fn seen_from(&self, point: &Vector) -> Vector {
        minus(&self.xyz, &times(&self.weight, point))
    }

    /// The sign of normal·(L − origin).
    pub(crate) fn side(&self, normal: &Vector, origin: &Vector) -> i8 {
        dot(normal, &self.seen_from(origin)).sign()
    }

    /// Whether the light is at x: the open segment is then empty.
    pub(crate) fn is_at(&self, x: &Place) -> bool {
        self.weight.sign() != 0
            && (0..3).all(|axis| {
                let unit: [f64; 3] = std::array::from_fn(|i| if i == axis { 1.0 } else { 0.0 });
                x.side(&vector(unit), &self.xyz) == 0
            })
    }
}

/// A closed triangle, or the segment or point that is left of it when it has no area.
#[derive(Clone, Debug)]
pub(crate) struct Triangle {
    corners: [Vector; 3],
    normal: Vector,
}

impl Triangle {
    /// The triangle with these corners.
    pub(crate) fn new(corners: [Vector; 3]) -> Self {
        let normal = cross(&minus(&corners[1], &corners[0]), &minus(&corners[2], &corners[0]));
        Self { corners, normal }
    }

    /// Whether the open segment from x to the light meets the closed triangle.
    pub(crate) fn blocks(&self, x: &Place, light: &Lamp) -> bool {
        if is_zero(&self.normal) {
            return self.hull_of_line().is_some_and(|[p, q]| segment_blocks(&p, &q, x, light));
        }
        let of_light = light.side(&self.normal, &self.corners[0]);
        let of_x = x.side(&self.normal, &self.corners[0]);
        match (of_light, of_x) {
            (0, 0) => !light.is_at(x) && !self.is_separated_in_plane(x, light),
            // Else the line meets the plane in one point, which lies between x and L when they are on either side.
            _ if of_light * of_x < 0 => (0..3).all(|edge| self.beam_side(edge, x, light) * of_light <= 0),
            _ => false,
        }
    }

    /// Whether linear inequalities show that no segment from the convex hull of `points` to the light is blocked.
    pub(crate) fn surely_misses(&self, points: &[Place], light: &Lamp) -> bool {
        if is_zero(&self.normal) {
            return false;
        }
        let of_light = light.side(&self.normal, &self.corners[0]);
        let sides: Vec<i8> = points.iter().map(|x| x.side(&self.normal, &self.corners[0])).collect();
        if of_light == 0 {
            return sides.iter().all(|&side| side > 0) || sides.iter().all(|&side| side < 0);
        }
        // A mean of points beside a beam is beside it, unless it takes only points in the beam's plane; a mean of points
        // that are not beyond the triangle's plane is not beyond it.
        let is_beside = |edge: usize| {
            let mut beams = points.iter().map(|x| self.beam_side(edge, x, light) * of_light);
            let mut not_beyond = sides.iter().map(|&side| side * of_light >= 0);
            beams.all(|beam| {
                let not_beyond = not_beyond.next().unwrap_or(false);
                beam > 0 || (beam == 0 && not_beyond)
            })
        };
        sides.iter().all(|&side| side * of_light >= 0) || (0..3).any(is_beside)
    }

    /// The side of x with respect to the plane through an edge and the light.
    fn beam_side(&self, edge: usize, x: &Place, light: &Lamp) -> i8 {
        let [a, b] = [&self.corners[edge], &self.corners[(edge + 1) % 3]];
        x.side(&cross(&minus(b, a), &light.seen_from(a)), a)
    }

    /// With x and L in the plane: two convex sets are disjoint when an edge of one of them separates them.
    fn is_separated_in_plane(&self, x: &Place, light: &Lamp) -> bool {
        let by_edge = (0..3).any(|edge| {
            let [a, b] = [&self.corners[edge], &self.corners[(edge + 1) % 3]];
            let inward = cross(&self.normal, &minus(b, a));
            let (of_x, of_light) = (x.side(&inward, a), light.side(&inward, a));
            of_x <= 0 && of_light <= 0 && of_x + of_light < 0
        });
        let turns = self.corners.each_ref().map(|corner| {
            let across = cross(&self.normal, &light.seen_from(corner));
            x.side(&across, corner)
        });
        by_edge || turns.iter().all(|&turn| turn > 0) || turns.iter().all(|&turn| turn < 0)
    }

    /// The two corners farthest apart; all corners lie on one line. `None` only if that cannot be told.
    fn hull_of_line(&self) -> Option<[Vector; 2]> {
        let longest = [(0, 1), (1, 2), (2, 0)].into_iter().max_by(|&(a, b), &(c, d)| {
            let squared = |i: usize, j: usize| {
                let side = minus(&self.corners[i], &self.corners[j]);
                dot(&side, &side)
            };
            (&squared(a, b) - &squared(c, d)).sign().cmp(&0)
        })?;
        Some([self.corners[longest.0].clone(), self.corners[longest.1].clone()])
    }
}

/// Whether the open segment from x to the light meets the closed segment p, q (one point when they are equal).
fn segment_blocks(p: &Vector, q: &Vector, x: &Place, light: &Lamp) -> bool {
    let along = minus(q, p);
    if is_zero(&along) {
        let to_light = light.seen_from(p);
        return is_on_line(x, p, &to_light) && x.side(&to_light, p) < 0;
    }
    let plane = cross(&along, &light.seen_from(p));
    if is_zero(&plane) {
        return collinear_blocks(p, q, x, light);
    }
    // x in the plane of p, q and L, beyond the line p q, and between the beams through p and q.
    let across = cross(&plane, &along);
    let beams = [p, q].map(|end| x.side(&cross(&plane, &light.seen_from(end)), end));
    x.side(&plane, p) == 0 && x.side(&across, p) * light.side(&across, p) < 0 && beams[0] * beams[1] <= 0
}

/// The case of a light on the line of p and q (or a sun along it).
fn collinear_blocks(p: &Vector, q: &Vector, x: &Place, light: &Lamp) -> bool {
    let along = minus(q, p);
    if !is_on_line(x, p, &along) || light.is_at(x) {
        return false;
    }
    // Along the line, p comes before q. A sun is beyond both, or before both.
    let (x_p, x_q) = (x.side(&along, p), x.side(&along, q));
    let (l_p, l_q) = (light.side(&along, p), light.side(&along, q));
    let all_before = x_p <= 0 && l_p <= 0;
    let all_after = x_q >= 0 && l_q >= 0;
    !all_before && !all_after
}

fn is_on_line(x: &Place, origin: &Vector, along: &Vector) -> bool {
    let units = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    units.iter().all(|&unit| x.side(&cross(along, &vector(unit)), origin) == 0)
}

/// The image of a sphere: |adj·(y − centre)|² = bound, where adj is the adjugate of the placement's matrix.
#[derive(Clone, Debug)]
pub(crate) struct Ellipsoid {
    adjugate: [Vector; 3],
    centre: Vector,
    bound: Binary,
}

/// The quadratic form of an ellipsoid on the span of x and L, up to positive factors.
struct Pencil {
    of_x: Surd,
    mixed: Surd,
    of_light: Binary,
}

impl Ellipsoid {
    /// The image of the sphere of this radius about the origin under the matrix with these rows, then moved to `centre`.
    pub(crate) fn new(rows: &[Vector; 3], centre: Vector, radius: &Binary) -> Self {
        // The columns of the adjugate are cross products of the rows.
        let columns: [Vector; 3] = std::array::from_fn(|i| cross(&rows[(i + 1) % 3], &rows[(i + 2) % 3]));
        let determinant = dot(&rows[0], &columns[0]);
        let adjugate = std::array::from_fn(|i| std::array::from_fn(|j| columns[j][i].clone()));
        let scaled = radius * &determinant;
        Self { adjugate, centre, bound: &scaled * &scaled }
    }

    fn pulled_back(&self, vector: &Vector) -> Vector {
        std::array::from_fn(|i| dot(&self.adjugate[i], vector))
    }

    fn pencil(&self, x: &Place, light: &Lamp) -> Pencil {
        let p = self.pulled_back(&minus(&x.rational, &times(&x.weight, &self.centre)));
        let q = self.pulled_back(&x.irrational);
        let l = self.pulled_back(&light.seen_from(&self.centre));
        let bound = |a: &Binary, b: &Binary| &self.bound * &(a * b);
        let squares = &dot(&p, &p) + &(&x.radicand * &dot(&q, &q));
        let cross_term = dot(&p, &q);
        Pencil {
            of_x: Surd { rational: &squares - &bound(&x.weight, &x.weight), irrational: &cross_term + &cross_term },
            mixed: Surd { rational: &dot(&p, &l) - &bound(&x.weight, &light.weight), irrational: dot(&q, &l) },
            of_light: &dot(&l, &l) - &bound(&light.weight, &light.weight),
        }
    }

    /// −1 inside, 0 on the surface, 1 outside.
    pub(crate) fn side(&self, x: &Place) -> i8 {
        let anywhere = Lamp { xyz: self.centre.clone(), weight: Binary::new(1.0) };
        self.pencil(x, &anywhere).of_x.sign(&x.radicand)
    }

    /// For x on the surface: whether the light is before (1), in (0) or behind (−1) the tangent plane, seen from outside.
    pub(crate) fn light_side(&self, x: &Place, light: &Lamp) -> i8 {
        self.pencil(x, light).mixed.sign(&x.radicand)
    }

    /// The sign of outward normal·direction where the ellipsoid through x, of the same shape, passes x.
    pub(crate) fn outward(&self, x: &Place, direction: &Vector) -> i8 {
        self.pencil(x, &Lamp { xyz: direction.clone(), weight: Binary::zero() }).mixed.sign(&x.radicand)
    }

    /// Whether a plane separates the ellipsoid from the convex hull of the points, which have weight 1: the plane is the
    /// tangent plane under the first point, in the space where the ellipsoid is a sphere.
    pub(crate) fn is_apart_from(&self, points: &[Place]) -> bool {
        let pulled = |x: &Place| self.pulled_back(&minus(&x.rational, &self.centre));
        let first = pulled(&points[0]);
        let limit = &self.bound * &dot(&first, &first);
        points.iter().all(|x| {
            let along = dot(&pulled(x), &first);
            along.sign() > 0 && (&(&along * &along) - &limit).sign() > 0
        })
    }

    /// Whether no segment from any of the points, all outside, to the light comes near the surface.
    pub(crate) fn surely_misses(&self, points: &[Place], light: &Lamp) -> bool {
        points.iter().all(|x| {
            let pencil = self.pencil(x, light);
            let outside = pencil.of_x.sign(&x.radicand) > 0 && pencil.of_light.sign() > 0;
            let away = pencil.mixed.sign(&x.radicand) >= 0;
            let square = pencil.mixed.squared(&x.radicand);
            let shrunk = &pencil.of_light * &Binary::new(1.0 - 2f64.powi(-12));
            outside && (away || square.minus_scaled(&pencil.of_x, &shrunk).sign(&x.radicand) < 0)
        })
    }

    /// Whether all segments from the convex hull of the points to the light meet the surface.
    pub(crate) fn surely_blocks(&self, points: &[Place], light: &Lamp) -> bool {
        let outside = |x: &Place| self.pencil(x, light).of_light.sign() > 0;
        points.iter().all(|x| outside(x) && self.blocks(x, light))
    }

    /// Whether the open segment from x to the light meets the surface: whether a + 2b·t + c·t² has a root t > 0.
    pub(crate) fn blocks(&self, x: &Place, light: &Lamp) -> bool {
        let pencil = self.pencil(x, light);
        let (a, b, c) = (pencil.of_x.sign(&x.radicand), pencil.mixed.sign(&x.radicand), pencil.of_light.sign());
        match (a, c) {
            (0, _) => b * c < 0,
            (_, 0) => a * b < 0,
            _ if a != c => true,
            _ => {
                a * b < 0 && {
                    let discriminant = pencil.mixed.squared(&x.radicand).minus_scaled(&pencil.of_x, &pencil.of_light);
                    discriminant.sign(&x.radicand) >= 0
                }
            }
        }
    }
}

/// The point A + u·(B − A) + v·(D − A).
pub(crate) fn combination(a: &Vector, b: &Vector, d: &Vector, u: f64, v: f64) -> Vector {
    let along_u = times(&Binary::new(u), &minus(b, a));
    let along_v = times(&Binary::new(v), &minus(d, a));
    plus(a, &plus(&along_u, &along_v))
}
