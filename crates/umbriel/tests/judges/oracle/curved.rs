//! Curved bodies by a way of their own: cut the segment, then ask a quadratic for a zero between two points.
//!
//! A placed body is asked in its local space: points and lights are pulled back with the adjugate of the matrix, as
//! homogeneous vectors of weight ≥ 0. Its surface is a union of closed pieces, each a quadric cut by half spaces, or a
//! plane region cut by half spaces and by at most one quadric. The open segment (for a sun: ray) is the set of
//! α·x + β·L with α, β > 0. Half spaces cut it to an interval between two such combinations, found without division; on
//! e₀ + s·e₁, s > 0, a quadric's form is a + 2b·s + c·s² with a = F(e₀, e₀), b = F(e₀, e₁), c = F(e₁, e₁), and the signs
//! of a, b, c and b² − ac tell whether it vanishes there. No root is ever represented, no case is left to a tolerance.

use super::{
    blocking::{Lamp, Place},
    number::{Binary, Surd, Vector, cross, dot, minus, times, vector},
};

/// A linear form on homogeneous points: n·x + d·w.
#[derive(Clone, Debug)]
pub(crate) struct Linear(pub(crate) [Binary; 4]);

/// A symmetric form on homogeneous points, by rows.
#[derive(Clone, Debug)]
pub(crate) struct Quadratic(pub(crate) [[Binary; 4]; 4]);

/// A closed piece of a surface, in local coordinates.
#[derive(Clone, Debug)]
pub(crate) enum Piece {
    /// Where the form is zero; it grows outward.
    Curved {
        /// The form.
        form: Quadratic,
        /// Not negative on the piece.
        within: Vec<Linear>,
    },
    /// Where the plane's form is zero; it grows outward (of a disk: towards the front).
    Flat {
        /// The plane.
        plane: Linear,
        /// Not positive on the piece.
        inside: Quadratic,
        /// Not negative on the piece.
        within: Vec<Linear>,
    },
}

/// A placed curved body.
#[derive(Clone, Debug)]
pub(crate) struct Curved {
    /// Its surface.
    pub(crate) pieces: Vec<Piece>,
    /// Whether only the outside (of a disk: the front) can be lit.
    pub(crate) one_sided: bool,
    /// The rows of the placement's matrix.
    pub(crate) rows: [Vector; 3],
    /// Where the placement moves the local origin.
    pub(crate) origin: Vector,
    /// The inverse times |determinant|.
    inverse: [Vector; 3],
    size: Binary,
}

/// A pulled-back homogeneous point; the radicand is that of the point it came from.
type Local = [Surd; 4];

/// One end α·x + β·L of an interval.
#[derive(Clone)]
struct End {
    alpha: Surd,
    beta: Surd,
    included: bool,
}

/// The values of a linear form at x and at L.
struct OnLine([Surd; 2]);

/// The values F(x, x), F(x, L), F(L, L) of a quadratic form.
struct OnPairs([Surd; 3]);

impl Linear {
    /// The form with these coefficients.
    pub(crate) fn new(coefficients: [f64; 4]) -> Self {
        Self(coefficients.map(Binary::new))
    }

    /// Its negative.
    pub(crate) fn negated(&self) -> Self {
        Self(self.0.each_ref().map(|coefficient| -coefficient))
    }

    fn at(&self, x: &Local) -> Surd {
        let terms = self.0.iter().zip(x).map(|(coefficient, value)| value.scaled(coefficient));
        terms.fold(Surd::plain(Binary::zero()), |sum, term| sum.plus(&term))
    }
}

impl Quadratic {
    /// F(x, y).
    fn at(&self, x: &Local, y: &Local, radicand: &Binary) -> Surd {
        let row = |i: usize| Linear(self.0[i].clone()).at(y).times(&x[i], radicand);
        (1..4).fold(row(0), |sum, i| sum.plus(&row(i)))
    }
}

impl Quadratic {
    /// The signs at all pairs of points.
    fn at_pairs(&self, points: &[Local], n: &Binary) -> Vec<i8> {
        let pairs = points.iter().enumerate().flat_map(|(i, x)| points[..=i].iter().map(move |y| (x, y)));
        pairs.map(|(x, y)| self.at(x, y, n).sign(n)).collect()
    }
}

impl OnLine {
    fn at(&self, end: &End, n: &Binary) -> Surd {
        self.0[0].times(&end.alpha, n).plus(&self.0[1].times(&end.beta, n))
    }
}

impl OnPairs {
    fn at(&self, e: &End, f: &End, n: &Binary) -> Surd {
        let [xx, xl, ll] = &self.0;
        let of_x = xx.times(&f.alpha, n).plus(&xl.times(&f.beta, n));
        let of_light = xl.times(&f.alpha, n).plus(&ll.times(&f.beta, n));
        of_x.times(&e.alpha, n).plus(&of_light.times(&e.beta, n))
    }
}

/// An interval of the open segment, or of the open ray.
#[derive(Clone)]
struct Interval<'a> {
    ends: [End; 2],
    radicand: &'a Binary,
}

impl<'a> Interval<'a> {
    /// All of the open segment.
    fn whole(radicand: &'a Binary) -> Self {
        let number = |value: f64| Surd::plain(Binary::new(value));
        let end = |alpha, beta| End { alpha: number(alpha), beta: number(beta), included: false };
        Self { ends: [end(1.0, 0.0), end(0.0, 1.0)], radicand }
    }

    /// The one point of the open segment where a form is zero that has values of opposite signs at x and at L.
    fn crossing(values: &OnLine, radicand: &'a Binary) -> Self {
        let [at_x, at_light] = &values.0;
        let positive = |value: &Surd| if value.sign(radicand) < 0 { -value } else { value.clone() };
        let end = End { alpha: positive(at_light), beta: positive(at_x), included: true };
        Self { ends: [end.clone(), end], radicand }
    }

    /// The part where a linear form is not negative.
    fn cut(self, values: &OnLine) -> Option<Self> {
        let at_ends = [values.at(&self.ends[0], self.radicand), values.at(&self.ends[1], self.radicand)];
        let signs = [at_ends[0].sign(self.radicand), at_ends[1].sign(self.radicand)];
        let radicand = self.radicand;
        match signs {
            [-1, -1] => None,
            [-1, 0] => {
                self.ends[1].included.then(|| Self { ends: [self.ends[1].clone(), self.ends[1].clone()], radicand })
            }
            [0, -1] => {
                self.ends[0].included.then(|| Self { ends: [self.ends[0].clone(), self.ends[0].clone()], radicand })
            }
            [-1, 1] => Some(Self { ends: [self.between(&at_ends[1], &-&at_ends[0]), self.ends[1].clone()], radicand }),
            [1, -1] => Some(Self { ends: [self.ends[0].clone(), self.between(&-&at_ends[1], &at_ends[0])], radicand }),
            _ => Some(self),
        }
    }

    /// The combination p·e₀ + q·e₁, p and q positive.
    fn between(&self, p: &Surd, q: &Surd) -> End {
        let [e, f] = &self.ends;
        let combined = |a: &Surd, b: &Surd| a.times(p, self.radicand).plus(&b.times(q, self.radicand));
        End { alpha: combined(&e.alpha, &f.alpha), beta: combined(&e.beta, &f.beta), included: true }
    }

    /// The signs of a, b, c and of b² − ac.
    fn signs(&self, values: &OnPairs) -> ([i8; 3], i8) {
        let (n, [e, f]) = (self.radicand, &self.ends);
        let [a, b, c] = [values.at(e, e, n), values.at(e, f, n), values.at(f, f, n)];
        let discriminant = b.times(&b, n).plus(&-&a.times(&c, n));
        ([a.sign(n), b.sign(n), c.sign(n)], discriminant.sign(n))
    }

    /// Whether a quadratic form is zero somewhere on the interval.
    fn has_zero(&self, values: &OnPairs) -> bool {
        let ([a, b, c], discriminant) = self.signs(values);
        let at_end = (a == 0 && self.ends[0].included) || (c == 0 && self.ends[1].included);
        let between = match (a, c) {
            (0, 0) => b == 0,
            (0, _) => b * c < 0,
            (_, 0) => a * b < 0,
            _ => a != c || (a * b < 0 && discriminant >= 0),
        };
        at_end || between
    }

    /// Whether a quadratic form is zero or negative somewhere on the interval.
    fn has_negative_or_zero(&self, values: &OnPairs) -> bool {
        let ([a, b, c], discriminant) = self.signs(values);
        let at_end = (a <= 0 && self.ends[0].included) || (c <= 0 && self.ends[1].included);
        let between = a < 0 || c < 0 || (b < 0 && discriminant >= 0) || (b == 0 && a == 0 && c == 0);
        at_end || between
    }
}

impl Piece {
    /// Whether the open segment meets the piece.
    fn blocks(&self, x: &Local, light: &Local, n: &Binary) -> bool {
        let on_line = |form: &Linear| OnLine([form.at(x), form.at(light)]);
        let on_pairs = |form: &Quadratic| OnPairs([form.at(x, x, n), form.at(x, light, n), form.at(light, light, n)]);
        let cut = |whole: Interval<'_>, within: &[Linear]| {
            within.iter().try_fold(whole, |rest, form| rest.cut(&on_line(form)).ok_or(())).ok().map(|rest| rest.ends)
        };
        let interval = |ends| Interval { ends, radicand: n };
        match self {
            Self::Curved { form, within } => {
                cut(Interval::whole(n), within).is_some_and(|ends| interval(ends).has_zero(&on_pairs(form)))
            }
            Self::Flat { plane, inside, within } => {
                let values = on_line(plane);
                let whole = match [values.0[0].sign(n), values.0[1].sign(n)] {
                    [0, 0] => Interval::whole(n),
                    [p, q] if p * q < 0 => Interval::crossing(&values, n),
                    _ => return false,
                };
                cut(whole, within).is_some_and(|ends| interval(ends).has_negative_or_zero(&on_pairs(inside)))
            }
        }
    }

    /// Whether signs on corners leave room for a point of the piece in their convex hull. A linear form is between its
    /// values at corners, a quadratic one between its values at pairs of corners.
    fn may_meet(&self, corners: &[Local], n: &Binary) -> bool {
        let at_corners = |form: &Linear| corners.iter().map(|x| form.at(x).sign(n)).collect::<Vec<_>>();
        let vanishes = |signs: &[i8]| signs.iter().any(|&sign| sign >= 0) && signs.iter().any(|&sign| sign <= 0);
        let reaches = |within: &[Linear]| within.iter().all(|form| at_corners(form).iter().any(|&sign| sign >= 0));
        match self {
            Self::Curved { form, within } => vanishes(&form.at_pairs(corners, n)) && reaches(within),
            Self::Flat { plane, inside, within } => {
                vanishes(&at_corners(plane))
                    && inside.at_pairs(corners, n).iter().any(|&sign| sign <= 0)
                    && reaches(within)
            }
        }
    }

    /// Whether signs on corners prove that the piece has a point in their convex hull.
    fn surely_meets(&self, corners: &[Local], n: &Binary) -> bool {
        let vanishes = |signs: &mut dyn Iterator<Item = i8>| {
            let signs: Vec<i8> = signs.collect();
            signs.iter().any(|&sign| sign >= 0) && signs.iter().any(|&sign| sign <= 0)
        };
        let holds = |within: &[Linear]| within.iter().all(|form| corners.iter().all(|x| form.at(x).sign(n) >= 0));
        match self {
            Self::Curved { form, within } => {
                vanishes(&mut corners.iter().map(|x| form.at(x, x, n).sign(n))) && holds(within)
            }
            Self::Flat { plane, inside, within } => {
                vanishes(&mut corners.iter().map(|x| plane.at(x).sign(n)))
                    && inside.at_pairs(corners, n).iter().all(|&sign| sign <= 0)
                    && holds(within)
            }
        }
    }

    /// Whether x lies on the piece.
    fn holds(&self, x: &Local, n: &Binary) -> bool {
        let within = |forms: &[Linear]| forms.iter().all(|form| form.at(x).sign(n) >= 0);
        match self {
            Self::Curved { form, within: forms } => form.at(x, x, n).sign(n) == 0 && within(forms),
            Self::Flat { plane, inside, within: forms } => {
                plane.at(x).sign(n) == 0 && inside.at(x, x, n).sign(n) <= 0 && within(forms)
            }
        }
    }
}

impl Curved {
    /// The pieces under the matrix with these rows, then moved to `origin`.
    pub(crate) fn new(pieces: Vec<Piece>, one_sided: bool, rows: [Vector; 3], origin: Vector) -> Self {
        // The columns of the adjugate are cross products of the rows.
        let columns: [Vector; 3] = std::array::from_fn(|i| cross(&rows[(i + 1) % 3], &rows[(i + 2) % 3]));
        let determinant = dot(&rows[0], &columns[0]);
        let mirrored = determinant.sign() < 0;
        let positive = |value: &Binary| if mirrored { -value } else { value.clone() };
        let inverse = std::array::from_fn(|i| std::array::from_fn(|j| positive(&columns[j][i])));
        Self { pieces, one_sided, rows, origin, inverse, size: positive(&determinant) }
    }

    /// Whether the open segment from x to the light meets the surface.
    pub(crate) fn blocks(&self, x: &Place, light: &Lamp) -> bool {
        let (local, local_light) = (self.pulled_back(x), self.pulled_back_light(light));
        !light.is_at(x) && self.pieces.iter().any(|piece| piece.blocks(&local, &local_light, &x.radicand))
    }

    /// Whether the point x of one piece lies on that piece.
    pub(crate) fn piece_holds(&self, piece: usize, x: &Place) -> bool {
        self.pieces[piece].holds(&self.pulled_back(x), &x.radicand)
    }

    /// A vector along the outward normal at the point x of a piece, rounded, its largest part ±1; zero at a tip.
    pub(crate) fn normal(&self, piece: usize, x: &Place) -> [f64; 3] {
        // The gradient, pulled back: its component along an axis is F(x, axis).
        let along = |axis: usize| {
            let unit: [f64; 3] = std::array::from_fn(|k| if k == axis { 1.0 } else { 0.0 });
            let local = self.pulled_back_light(&Lamp { xyz: vector(unit), weight: Binary::zero() });
            match &self.pieces[piece] {
                Piece::Curved { form, .. } => form.at(&self.pulled_back(x), &local, &x.radicand),
                Piece::Flat { plane, .. } => plane.at(&local),
            }
        };
        let gradient = [0, 1, 2].map(along);
        let root = x.radicand.to_nearest().sqrt();
        let rounded = gradient.map(|part| part.rational.to_nearest() + part.irrational.to_nearest() * root);
        let largest = rounded.iter().fold(0.0, |most: f64, part| most.max(part.abs()));
        rounded.map(|part| if largest > 0.0 { part / largest } else { 0.0 })
    }

    /// For x on a piece: whether the light is before (1), in (0) or behind (−1) the tangent plane, seen from outside.
    pub(crate) fn light_side(&self, piece: usize, x: &Place, light: &Lamp) -> i8 {
        let local_light = self.pulled_back_light(light);
        match &self.pieces[piece] {
            Piece::Curved { form, .. } => form.at(&self.pulled_back(x), &local_light, &x.radicand).sign(&x.radicand),
            Piece::Flat { plane, .. } => plane.at(&local_light).sign(&x.radicand),
        }
    }

    /// Whether the light is strictly on the lit side at the point x of a piece.
    pub(crate) fn faces(&self, piece: usize, x: &Place, light: &Lamp) -> bool {
        let side = self.light_side(piece, x, light);
        side > 0 || (side < 0 && !self.one_sided)
    }

    /// The pieces that may have a point in the convex hull of the places.
    pub(crate) fn near(&self, region: &[Place]) -> Vec<usize> {
        let corners: Vec<Local> = region.iter().map(|x| self.pulled_back(x)).collect();
        let n = &region[0].radicand;
        (0..self.pieces.len()).filter(|&piece| self.pieces[piece].may_meet(&corners, n)).collect()
    }

    /// Whether the piece surely has a point in the convex hull of the places.
    pub(crate) fn surely_meets(&self, piece: usize, region: &[Place]) -> bool {
        let corners: Vec<Local> = region.iter().map(|x| self.pulled_back(x)).collect();
        self.pieces[piece].surely_meets(&corners, &region[0].radicand)
    }

    /// The sign of outward normal·direction at the point x of a piece; affine in x.
    pub(crate) fn outward(&self, piece: usize, x: &Place, direction: &Vector) -> i8 {
        self.light_side(piece, x, &Lamp { xyz: direction.clone(), weight: Binary::zero() })
    }

    /// The world image of a local point position/weight with its root.
    pub(crate) fn image(&self, local: &Place) -> Place {
        let turned = |vector: &Vector| -> Vector { std::array::from_fn(|i| dot(&self.rows[i], vector)) };
        let moved = times(&local.weight, &self.origin);
        Place {
            rational: super::number::plus(&turned(&local.rational), &moved),
            irrational: turned(&local.irrational),
            radicand: local.radicand.clone(),
            weight: local.weight.clone(),
        }
    }

    fn pulled_back(&self, x: &Place) -> Local {
        let rational = minus(&x.rational, &times(&x.weight, &self.origin));
        let turned = |row: &Vector| Surd { rational: dot(row, &rational), irrational: dot(row, &x.irrational) };
        let [a, b, c] = self.inverse.each_ref().map(turned);
        [a, b, c, Surd::plain(&self.size * &x.weight)]
    }

    fn pulled_back_light(&self, light: &Lamp) -> Local {
        let towards = light.seen_from(&self.origin);
        let [a, b, c] = self.inverse.each_ref().map(|row| Surd::plain(dot(row, &towards)));
        [a, b, c, Surd::plain(&self.size * &light.weight)]
    }
}
