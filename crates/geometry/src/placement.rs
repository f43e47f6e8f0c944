//! Placements: regular affine maps from local to world coordinates.
//!
//! A placed mesh vertex is the correctly rounded M·v + t, and that float point *is* the vertex. Corners of rectangles
//! and boxes are the exact image instead. Sums are formed in double-double; where that leaves the rounding in doubt,
//! in exact dyadics.

use glam::{DAffine3, DMat3, DVec3};

use crate::{
    aabb::{Aabb, above, below},
    approx::{Approx, UNDERFLOW_LIMIT},
    decisions::decide,
    dyadic::Dyadic,
    expansion::{two_product, two_sum},
    number::{MAX_MAGNITUDE, MIN_MAGNITUDE, NumberDefect, accept},
    point::ExactPoint,
    ring::{Ring, Sign, determinant},
};

/// Why a placement is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PlacementDefect {
    /// An entry of the matrix outside the accepted range: column 0..=3, row 0..=2.
    #[error("the entry in column {column}, row {row} of the matrix {defect}")]
    Entry {
        /// Column; 3 is the translation.
        column: usize,
        /// Row.
        row: usize,
        /// What is wrong with it.
        defect: NumberDefect,
    },
    /// The determinant is exactly zero.
    #[error("the matrix is singular: it flattens the object")]
    Singular,
}

/// A product that knows whether it was rounded.
fn product(a: f64, b: f64) -> Approx {
    let rounded = Approx::exact(a) * Approx::exact(b);
    // What a normal product is off by is a float.
    let is_exact = rounded.value.abs() > UNDERFLOW_LIMIT && two_product(a, b)[1] == 0.0;
    if is_exact { Approx::exact(rounded.value) } else { rounded }
}

/// A regular affine map, local to world: x ↦ M·x + t.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    map: DAffine3,
    mirrored: bool,
}

impl Placement {
    /// Leaves everything where it is.
    pub const IDENTITY: Self = Self { map: DAffine3::IDENTITY, mirrored: false };

    /// Checks and takes a matrix. Singularity is decided exactly.
    ///
    /// # Errors
    /// [`PlacementDefect`].
    pub fn new(map: DAffine3) -> Result<Self, PlacementDefect> {
        let mut entries = map.to_cols_array();
        for (index, entry) in entries.iter_mut().enumerate() {
            let place = |defect| PlacementDefect::Entry { column: index / 3, row: index % 3, defect };
            *entry = accept(*entry).map_err(place)?;
        }
        let map = DAffine3::from_cols_array(&entries);
        let turn = decide(determinant(&approx_matrix(&map.matrix3)).sign(), || {
            determinant::<Dyadic>(&exact_matrix(&map.matrix3)).sign()
        });
        match turn {
            Sign::Zero => Err(PlacementDefect::Singular),
            sign => Ok(Self { map, mirrored: sign == Sign::Negative }),
        }
    }

    /// The map itself.
    pub fn map(&self) -> &DAffine3 {
        &self.map
    }

    /// Whether the map turns left into right, which reverses windings.
    pub fn is_mirrored(&self) -> bool {
        self.mirrored
    }

    /// The correctly rounded image of a point (ties to even); −0 becomes 0. Not checked against the accepted range.
    pub fn round(&self, local: DVec3) -> DVec3 {
        rounded_image(&self.map, local)
    }

    /// Whether the rounded image of a point is accepted ([`accept`]). Cost: some nanoseconds, a tenth of [`Placement::round`]; coordinates near zero are rounded.
    ///
    /// # Errors
    /// The axis (0, 1, 2) of the first coordinate that is not, and why.
    pub fn accepts(&self, local: DVec3) -> Result<(), (usize, NumberDefect)> {
        let (image, off) = self.roughly(local);
        let size = image.abs();
        let is_large = (size - off).cmpgt(DVec3::splat(MIN_MAGNITUDE));
        let is_accepted = is_large & (size + off).cmplt(DVec3::splat(MAX_MAGNITUDE));
        (0..3).filter(|&axis| !is_accepted.test(axis)).try_for_each(|axis| {
            let rounded = rounded_sum(&self.row(axis), local.to_array());
            accept(rounded).map(|_| ()).map_err(|defect| (axis, defect))
        })
    }

    /// The box of the rounded images of some points. Cost: some nanoseconds each, since most are surely inside the box of those before them; coordinates that are not are
    /// rounded.
    pub fn bounds_of(&self, points: impl IntoIterator<Item = DVec3>) -> Aabb {
        let mut bounds = Aabb::EMPTY;
        for local in points {
            let (image, off) = self.roughly(local);
            let is_inside = (image - off).cmpgt(bounds.min) & (image + off).cmplt(bounds.max);
            for axis in (0..3).filter(|&axis| !is_inside.test(axis)) {
                let rounded = rounded_sum(&self.row(axis), local.to_array());
                bounds.min[axis] = bounds.min[axis].min(rounded);
                bounds.max[axis] = bounds.max[axis].max(rounded);
            }
        }
        bounds
    }

    /// The image of a point by floats, and how far they and the rounded image are apart at most, with the rounding of what is added to them
    /// (NUMERICS.md, "Placement").
    fn roughly(&self, local: DVec3) -> (DVec3, DVec3) {
        let DAffine3 { matrix3: m, translation } = self.map;
        let terms = [m.x_axis * local.x, m.y_axis * local.y, m.z_axis * local.z, translation];
        let sum = |[x, y, z, rest]: [DVec3; 4]| (x + y) + (z + rest);
        let off = sum(terms.map(DVec3::abs)) * (4.0 * f64::EPSILON) + DVec3::splat(f64::MIN_POSITIVE);
        (sum(terms), off)
    }

    /// The image of a vector along an axis: the translation has no part in it. No error where no product is rounded.
    pub(crate) fn side(&self, local: DVec3) -> [Approx; 3] {
        std::array::from_fn(|axis| {
            let row = self.row(axis);
            let products = (0..3).filter(|&k| local[k] != 0.0).map(|k| product(row[k], local[k]));
            products.reduce(|sum, product| sum + product).unwrap_or_default()
        })
    }

    /// The exact image of a point as two floats each: the nearest, and all that it leaves out. `None` where two floats do not hold it.
    pub(crate) fn in_two_floats(&self, local: DVec3) -> Option<[DVec3; 2]> {
        let sums: [DoubleDouble; 3] = std::array::from_fn(|axis| DoubleDouble::of(&self.row(axis), local.to_array()));
        let part = |part: fn(&DoubleDouble) -> f64| DVec3::from_array(sums.each_ref().map(|sum| part(sum) + 0.0));
        sums.iter().all(|sum| sum.is_exact).then(|| [part(|sum| sum.high), part(|sum| sum.low)])
    }

    /// The exact image of a point.
    pub fn exact(&self, local: DVec3) -> ExactPoint {
        let xyz = std::array::from_fn(|axis| exact_coordinate(&self.row(axis), local));
        ExactPoint { xyz, w: Dyadic::new(1.0) }
    }

    /// Bounds on the sizes of the entries of the linear part's inverse, by rows; infinite where nothing is known. The determinant is exact,
    /// so that cancellation in it hides nothing.
    pub fn inverse_bounds(&self) -> [[f64; 3]; 3] {
        let determinant = self.determinant();
        let bound = |cofactor: Approx| {
            let entry = cofactor.divided_by(determinant);
            let size = entry.value.abs() + entry.error;
            if size < f64::INFINITY { size.next_up() } else { f64::INFINITY }
        };
        self.adjugate().map(|row| row.map(bound))
    }

    /// The image of a box, rounded outward, but for what is zero, which is exact. Rounding is monotone, so of the rounded corners one end of the box in each
    /// coordinate is the image of the corner that the signs of the coefficients name.
    pub fn bounds(&self, local: &Aabb) -> Aabb {
        let end = |axis: usize, low: DVec3, high: DVec3| {
            let row = self.row(axis);
            let corner = std::array::from_fn(|k| if row[k] < 0.0 { high[k] } else { low[k] });
            rounded_sum(&row, corner)
        };
        Aabb {
            min: DVec3::from_array(std::array::from_fn(|axis| below(end(axis, local.min, local.max)))),
            max: DVec3::from_array(std::array::from_fn(|axis| above(end(axis, local.max, local.min)))),
        }
    }

    /// The coefficients of one world coordinate: m·x, m·y, m·z, t.
    fn row(&self, axis: usize) -> [f64; 4] {
        row(&self.map, axis)
    }

    /// The adjugate of the linear part (the inverse times the determinant), by rows, with bounds.
    pub(crate) fn adjugate(&self) -> [[Approx; 3]; 3] {
        cofactors_transposed(&approx_matrix(&self.map.matrix3))
    }

    /// The determinant of the linear part, the same whatever the order of the world's axes but for its sign.
    pub(crate) fn determinant(&self) -> Approx {
        determinant::<Dyadic>(&exact_matrix(&self.map.matrix3)).to_approx()
    }

    /// The adjugate of the linear part and its determinant, exact.
    pub(crate) fn exact_adjugate<R: Ring>(&self) -> ([[R; 3]; 3], R) {
        let rows = exact_matrix(&self.map.matrix3);
        (cofactors_transposed(&rows), determinant(&rows))
    }
}

/// The correctly rounded image of a point under an affine map, regular or not (ties to even); −0 becomes 0.
pub(crate) fn rounded_image(map: &DAffine3, local: DVec3) -> DVec3 {
    if map.matrix3 == DMat3::IDENTITY {
        // A single sum is correctly rounded as it is.
        return local + map.translation + DVec3::ZERO;
    }
    DVec3::from_array(std::array::from_fn(|axis| rounded_sum(&row(map, axis), local.to_array())))
}

/// One coordinate of it.
fn rounded_sum(row: &[f64; 4], local: [f64; 3]) -> f64 {
    let sum = DoubleDouble::of(row, local);
    decide(sum.rounded(), || exact_coordinate::<Dyadic>(row, local.into()).to_nearest()) + 0.0
}

fn row(map: &DAffine3, axis: usize) -> [f64; 4] {
    let m = &map.matrix3;
    [m.x_axis[axis], m.y_axis[axis], m.z_axis[axis], map.translation[axis]]
}

fn approx_matrix(m: &DMat3) -> [[Approx; 3]; 3] {
    std::array::from_fn(|row| std::array::from_fn(|column| Approx::exact(m.col(column)[row])))
}

fn exact_matrix<R: Ring>(m: &DMat3) -> [[R; 3]; 3] {
    std::array::from_fn(|row| std::array::from_fn(|column| R::from_f64(m.col(column)[row])))
}

/// The adjugate: entry (i, j) is the cofactor of entry (j, i).
fn cofactors_transposed<T>(m: &[[T; 3]; 3]) -> [[T; 3]; 3]
where
    T: Clone + std::ops::Mul<Output = T> + std::ops::Sub<Output = T>,
{
    let at = |i: usize, j: usize| m[i % 3][j % 3].clone();
    std::array::from_fn(|i| {
        std::array::from_fn(|j| at(j + 1, i + 1) * at(j + 2, i + 2) - at(j + 1, i + 2) * at(j + 2, i + 1))
    })
}

fn exact_coordinate<R: Ring>(row: &[f64; 4], local: DVec3) -> R {
    let product = |i: usize| R::from_f64(row[i]) * R::from_f64(local[i]);
    product(0) + product(1) + product(2) + R::from_f64(row[3])
}

/// 2^-900: products above it keep all their digits in two floats.
const LEAST: f64 = f64::from_bits((1023 - 900) << 52);

/// An unevaluated sum of two floats with a bound on what it misses.
struct DoubleDouble {
    high: f64,
    low: f64,
    error: f64,
    /// Whether nothing was lost: the sum of both is exact.
    is_exact: bool,
}

impl DoubleDouble {
    /// row·(local, 1), by Dekker's two-sums and fused products.
    fn of(row: &[f64; 4], local: [f64; 3]) -> Self {
        let (mut high, mut low, mut magnitude) = (row[3], 0.0_f64, row[3].abs());
        let mut is_exact = true;
        for i in 0..3 {
            let product = row[i] * local[i];
            let product_error = row[i].mul_add(local[i], -product);
            let [sum, sum_error] = two_sum(high, product);
            high = sum;
            let [rests, lost] = two_sum(sum_error, product_error);
            let [next, lost_too] = two_sum(low, rests);
            low = next;
            magnitude += product.abs() + sum.abs();
            // A product that is not zero by a factor may have lost digits at the bottom of the range.
            let is_whole = product.abs() >= LEAST || row[i] == 0.0 || local[i] == 0.0;
            is_exact &= is_whole && lost == 0.0 && lost_too == 0.0;
        }
        // Where nothing was lost, the sum of both is the exact one, and `high` that rounded to the nearest float.
        let [high, low] = two_sum(high, low);
        // `low` sums six terms, each at most u·magnitude, with at most six roundings: 36u² ≤ 2^-100·magnitude.
        Self { high, low, error: magnitude * f64::EPSILON * f64::EPSILON * 16.0, is_exact }
    }

    /// The correctly rounded sum, unless a rounding boundary lies within the error.
    fn rounded(&self) -> Option<f64> {
        if self.is_exact {
            return Some(self.high);
        }
        // The products may underflow where the result is tiny; let the exact path decide there.
        if self.high.abs() < LEAST {
            return None;
        }
        let (down, up) = (self.high + (self.low - self.error), self.high + (self.low + self.error));
        (down == up).then_some(up)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::number::accept_point;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn placed_vertices_are_correctly_rounded(
            entries in proptest::array::uniform12(-2.0..2.0f64), far in -1e9..1e9f64, v in proptest::array::uniform3(-1e3..1e3f64),
        ) {
            let mut entries = entries;
            entries[9] = far;
            let Ok(placement) = Placement::new(DAffine3::from_cols_array(&entries)) else { return Ok(()) };
            let local = DVec3::from_array(v);
            let exact = placement.exact(local);
            for axis in 0..3 {
                prop_assert_eq!(placement.round(local)[axis], exact.xyz[axis].to_nearest());
            }
        }
    }

    proptest! {
        #[test]
        fn a_glance_tells_what_rounding_does(
            entries in proptest::array::uniform12(-2.0..2.0f64), scale in proptest::array::uniform2(-230..230i32), v in proptest::array::uniform9(-1e3..1e3f64),
        ) {
            let [stretch, away] = scale.map(|power| 2f64.powi(power));
            let mut entries = entries.map(|entry| entry * stretch);
            (9..12).for_each(|k| entries[k] *= away);
            let Ok(placement) = Placement::new(DAffine3::from_cols_array(&entries)) else { return Ok(()) };
            // Close to each other, too: a second point an ulp away.
            let points = [0, 3, 6].map(|k| DVec3::new(v[k], v[k + 1], v[k + 2]));
            let points = points.into_iter().flat_map(|point| [point, DVec3::new(point.x.next_up(), point.y, point.z)]);
            let points: Vec<DVec3> = points.collect();
            for point in &points {
                prop_assert_eq!(placement.accepts(*point), accept_point(placement.round(*point).to_array()).map(|_| ()));
            }
            let rounded = Aabb::of(points.iter().map(|&point| placement.round(point)));
            prop_assert_eq!(placement.bounds_of(points), rounded);
        }
    }

    proptest! {
        #[test]
        fn two_floats_are_the_image_where_they_hold_it(
            scale in proptest::array::uniform3(-64..64i32), far in proptest::array::uniform3(-1e12..1e12f64), v in proptest::array::uniform3(-999_999..999_999i32),
        ) {
            let (scale, far) = (DVec3::from_array(scale.map(f64::from)), DVec3::from_array(far));
            let Ok(placement) = Placement::new(DAffine3 { matrix3: DMat3::from_diagonal(scale), translation: far }) else { return Ok(()) };
            let local = DVec3::from_array(v.map(f64::from)) / 1024.0;
            let [near, rest] = placement.in_two_floats(local).expect("a product and a sum");
            let exact = placement.exact(local);
            for axis in 0..3 {
                prop_assert_eq!(near[axis], exact.xyz[axis].to_nearest());
                let left = exact.xyz[axis].clone() - Dyadic::new(near[axis]) - Dyadic::new(rest[axis]);
                prop_assert_eq!(left.sign(), Sign::Zero);
            }
        }
    }

    proptest! {
        #[test]
        fn a_box_holds_its_corners_and_no_more(
            entries in proptest::array::uniform12(-2.0..2.0f64), zeros in 0..512u32, ends in proptest::array::uniform6(-1e3..1e3f64),
        ) {
            let mut entries = entries;
            (0..9).filter(|k| zeros >> k & 1 == 1).for_each(|k| entries[k] = 0.0);
            let Ok(placement) = Placement::new(DAffine3::from_cols_array(&entries)) else { return Ok(()) };
            let [a, b] = [0, 3].map(|k| DVec3::new(ends[k], ends[k + 1], ends[k + 2]));
            let local = Aabb { min: a.min(b), max: a.max(b) };
            let rounded = Aabb::of(local.corners().map(|corner| placement.round(corner)));
            let bounds = placement.bounds(&local);
            for axis in 0..3 {
                let (min, max) = (rounded.min[axis], rounded.max[axis]);
                prop_assert_eq!(bounds.min[axis], if min == 0.0 { min } else { min.next_down() });
                prop_assert_eq!(bounds.max[axis], if max == 0.0 { max } else { max.next_up() });
            }
        }
    }

    #[test]
    fn a_tie_goes_to_even() {
        // 1 + 2^-53 lies exactly between 1 and the next float.
        let map = DAffine3::from_translation(DVec3::new(1.0, 0.0, 0.0));
        let placement = Placement::new(map).expect("regular");
        let half_ulp = f64::EPSILON / 2.0;
        assert_eq!(placement.round(DVec3::new(half_ulp, 0.0, 0.0)).x, 1.0);
        assert_eq!(placement.round(DVec3::new(3.0 * half_ulp, 0.0, 0.0)).x, 1.0 + 2.0 * f64::EPSILON);
    }

    proptest! {
        #[test]
        fn what_is_only_moved_is_correctly_rounded(far in proptest::array::uniform3(-1e9..1e9f64), v in proptest::array::uniform3(-1e3..1e3f64)) {
            let [far, local] = [far, v].map(DVec3::from_array);
            let placement = Placement::new(DAffine3::from_translation(far)).expect("regular");
            let exact = placement.exact(local);
            prop_assert_eq!(placement.round(local).to_array(), std::array::from_fn(|axis| exact.xyz[axis].to_nearest()));
            prop_assert_eq!(placement.round(-far).to_array().map(f64::to_bits), [0; 3], "and no -0");
        }
    }

    #[test]
    fn a_flattening_matrix_is_refused() {
        let flat = DAffine3::from_cols_array(&[1.0, 2.0, 3.0, 2.0, 4.0, 6.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
        assert_eq!(Placement::new(flat), Err(PlacementDefect::Singular));
        let mirror = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        assert!(Placement::new(mirror).expect("regular").is_mirrored());
    }
}
