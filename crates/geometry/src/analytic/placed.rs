//! A placed analytic body: which side a point lies on, what its surface blocks, which way it faces. All exact.
//!
//! Each question is put to a filter in floats first and to exact numbers where that cannot tell.

use std::{cell::LazyCell, sync::OnceLock};

use super::{
    Analytic, AnalyticDefect,
    chart::{Chart, charts},
    forms::{Forms, LocalPoint, linear_value},
    layout::{Layout, Part, Piece, Surface, Trim},
    polynomial::{Polynomial, Way, all_known, any_known, is_met},
};
use crate::{
    aabb::Aabb,
    approx::Approx,
    blocking::Probe,
    decide::Decide,
    decisions::{decide, decide_by_pairs},
    dyadic::Dyadic,
    light::LightSource,
    number::power_of_two_below,
    pair::Pair,
    placement::Placement,
    point::{ExactPoint, Point},
    ring::{Ring, Sign},
    surd::Surd,
};

/// An analytic body under a placement, ready for questions.
#[derive(Debug)]
pub struct PlacedAnalytic {
    body: Analytic,
    placement: Placement,
    layout: Layout,
    forms: Forms<Approx>,
    /// What pulled-back points are multiplied by in `forms`: a power of two.
    scale: f64,
    exact: OnceLock<Forms<Dyadic>>,
    /// Times `scale`, as `forms`.
    in_pairs: OnceLock<Forms<Surd<Pair>>>,
    /// In local coordinates, rounded.
    float: OnceLock<Forms<f64>>,
    charts: Vec<Chart>,
}

impl PlacedAnalytic {
    /// Places a body.
    ///
    /// # Errors
    /// [`AnalyticDefect`] when the numbers describe no body.
    pub fn new(body: Analytic, placement: Placement) -> Result<Self, AnalyticDefect> {
        body.check()?;
        let layout = Layout::of(&body);
        let (forms, scale) = approx_forms(&layout, &placement);
        Ok(Self {
            charts: charts(&body),
            body,
            placement,
            layout,
            forms,
            scale,
            exact: OnceLock::new(),
            in_pairs: OnceLock::new(),
            float: OnceLock::new(),
        })
    }

    /// The body in local coordinates.
    pub fn body(&self) -> &Analytic {
        &self.body
    }

    /// Where it stands.
    pub fn placement(&self) -> &Placement {
        &self.placement
    }

    /// The closed parts that make up its surface.
    pub fn parts(&self) -> &[Part] {
        &self.layout.parts
    }

    /// The closed sets whose union it is.
    pub fn pieces(&self) -> &[Piece] {
        &self.layout.pieces
    }

    /// The patches of its surface, as faces are numbered; see [`Analytic`].
    pub fn charts(&self) -> &[Chart] {
        &self.charts
    }

    /// The forms with error bounds, times a positive power of two.
    pub fn forms(&self) -> &Forms<Approx> {
        &self.forms
    }

    /// The exact forms; made when first asked for.
    pub fn exact_forms(&self) -> &Forms<Dyadic> {
        self.exact.get_or_init(|| exact_forms(&self.layout, &self.placement))
    }

    /// The forms in pairs of floats, in the scale of [`PlacedAnalytic::forms`]; made when first asked for.
    pub(super) fn forms_in_pairs(&self) -> &Forms<Surd<Pair>> {
        self.in_pairs.get_or_init(|| {
            let exact = self.exact_forms();
            let number = |number: &Dyadic| Surd::plain(Pair::from(number));
            let scaled = |value: &Dyadic| number(&(value.clone() * Dyadic::new(self.scale)));
            Forms {
                adjugate: exact.adjugate.each_ref().map(|row| row.each_ref().map(scaled)),
                weight: scaled(&exact.weight),
                ..exact.map(number)
            }
        })
    }

    /// The forms in floats; made when first asked for.
    pub(crate) fn float_forms(&self) -> &Forms<f64> {
        self.float.get_or_init(|| self.forms.map(|number| number.value))
    }

    /// The unit of length that local coordinates are counted in, metres.
    pub(crate) fn unit(&self) -> f64 {
        self.layout.unit
    }

    /// The tight world box, rounded outward; empty for a quadric without points in its box.
    pub fn bounds(&self) -> Aabb {
        self.body.bounds(&self.placement)
    }

    /// Where a homogeneous world point lies: negative strictly inside, zero on the surface, positive outside. Exact. A disk
    /// has no inside; a sun is outside of everything.
    pub fn side(&self, x: &Point, is_sun: bool) -> Sign {
        if is_sun {
            return Sign::Positive;
        }
        let local = self.forms.pull_back_point(x);
        let by_pairs = || {
            let (forms, x) = (self.forms_in_pairs(), ExactPoint::of_pairs(Pair::of_point(x)));
            self.side_of(forms, &forms.pull_back(&x.xyz, &x.w))
        };
        decide_by_pairs(self.side_of(&self.forms, &local), by_pairs, || {
            let (forms, exact) = (self.exact_forms(), x.to_exact::<Dyadic>());
            self.side_of(forms, &forms.pull_back(&exact.xyz, &exact.w)).unwrap_or(Sign::Zero)
        })
    }

    /// Where a light lies; see [`PlacedAnalytic::side`].
    pub fn light_side(&self, light: &LightSource) -> Sign {
        self.side(&Point::exact(light.xyz()), light.is_sun())
    }

    /// The values of all quadrics and of all planes at a light, in the scale of [`PlacedAnalytic::forms`]: the filter's where these are sharp,
    /// else those of pairs of floats, else the floats nearest to the exact ones. So their signs are always known.
    pub fn light_values(&self, light: &LightSource) -> [Vec<Approx>; 2] {
        let at = self.forms.pull_back_light(light);
        let at_in_pairs = LazyCell::new(|| {
            let light = ExactPoint::from_light(light);
            self.forms_in_pairs().pull_back(&light.xyz, &light.w)
        });
        let exact_at = LazyCell::new(|| {
            let light = ExactPoint::<Dyadic>::from_light(light);
            self.exact_forms().pull_back(&light.xyz, &light.w).map(|coordinate| coordinate * Dyadic::new(self.scale))
        });
        let is_sharp = |value: &Approx| value.error <= value.value.abs() * SHARP;
        let told = |surface: Surface| {
            let by_pairs = || Some(self.forms_in_pairs().surface(surface, &at_in_pairs).rational().to_approx());
            decide_by_pairs(
                Some(self.forms.surface(surface, &at)).filter(is_sharp),
                || by_pairs().filter(is_sharp),
                || self.exact_forms().surface(surface, &exact_at).to_approx(),
            )
        };
        let quadrics = (0..self.forms.quadrics.len()).map(|index| told(Surface::Quadric(index)));
        let planes = (0..self.forms.planes.len()).map(|index| told(Surface::Plane(index)));
        [quadrics.collect(), planes.collect()]
    }

    /// Whether all of some points lie in a plane of the body. Exact.
    pub fn plane_holds(&self, plane: usize, points: &[Point]) -> bool {
        let vanishes = |value: Option<Sign>| value.map(|sign| sign == Sign::Zero);
        let filtered = |x: &Point| vanishes(self.forms.plane(plane, &self.forms.pull_back_point(x)).sign());
        let in_pairs = |x: &Point| {
            let (forms, x) = (self.forms_in_pairs(), ExactPoint::of_pairs(Pair::of_point(x)));
            vanishes(forms.plane(plane, &forms.pull_back(&x.xyz, &x.w)).decide())
        };
        let exactly = |x: &Point| {
            let (forms, x) = (self.exact_forms(), x.to_exact::<Dyadic>());
            forms.plane(plane, &forms.pull_back(&x.xyz, &x.w)).sign() == Sign::Zero
        };
        decide_by_pairs(
            all_known(points.iter().map(filtered)),
            || all_known(points.iter().map(in_pairs)),
            || points.iter().all(exactly),
        )
    }

    /// Whether a light is a tip of a quadric: a point of it without a tangent plane, as that of a cone. Exact.
    pub fn is_tip(&self, quadric: usize, light: &LightSource) -> bool {
        let at = self.forms.pull_back_light(light);
        let filtered = self.vanishes_beside(&self.forms, quadric, &at);
        decide(filtered, || {
            let (forms, light) = (self.exact_forms(), ExactPoint::from_light(light));
            self.vanishes_beside(forms, quadric, &forms.pull_back(&light.xyz, &light.w)).unwrap_or(false)
        })
    }

    /// The other factor, up to a positive number, of a quadric that is the product of two planes' forms, one of which is the polar form of a light: the
    /// light lies in that plane, so that all of it is seen edge-on where it is no point of the other one. In the coordinates of [`PlacedAnalytic::forms`]. Exact.
    pub fn beside_edge_on(&self, quadric: usize, light: &LightSource) -> Option<[Approx; 4]> {
        let (forms, light) = (self.exact_forms(), ExactPoint::<Dyadic>::from_light(light));
        let at = forms.pull_back(&light.xyz, &light.w);
        let polar = std::array::from_fn(|k| linear_value(&forms.quadrics[quadric].row(k), &at));
        Some(forms.quadrics[quadric].cofactor(&polar)?.map(|factor| factor.to_approx()))
    }

    /// Whether a quadric is zero at all pairs of this point with another one.
    fn vanishes_beside<T: Decide + Default>(
        &self,
        forms: &Forms<T>,
        quadric: usize,
        x: &LocalPoint<T>,
    ) -> Option<bool> {
        let row = |k: usize| linear_value(&forms.quadrics[quadric].row(k), x);
        all_known((0..4).map(|k| row(k).decide().map(|sign| sign == Sign::Zero)))
    }

    fn side_of<T: Decide>(&self, forms: &Forms<T>, x: &LocalPoint<T>) -> Option<Sign> {
        let mut nearest = Some(Sign::Positive);
        for piece in &self.layout.pieces {
            let signs = piece.planes.iter().map(|&plane| forms.plane(plane, x).decide().map(Sign::flipped));
            let flat = piece.flat.map(|plane| forms.plane(plane, x).decide());
            // On a flat piece there is no inside: off its plane is outside.
            let flat = flat.map(|sign| sign.map(|sign| if sign == Sign::Zero { Sign::Zero } else { Sign::Positive }));
            let signs: Vec<Option<Sign>> =
                std::iter::once(forms.quadric(piece.quadric, x, x).decide()).chain(signs).chain(flat).collect();
            let side = if signs.contains(&Some(Sign::Positive)) {
                Some(Sign::Positive)
            } else {
                signs.into_iter().try_fold(Sign::Negative, |side, sign| Some(side.max(sign?)))
            };
            nearest = match (nearest, side) {
                (Some(Sign::Negative), _) | (_, Some(Sign::Negative)) => return Some(Sign::Negative),
                (Some(a), Some(b)) => Some(a.min(b)),
                _ => None,
            };
        }
        nearest
    }

    /// Whether the surface meets the open segment from `x` to the light. A point on the surface does not block itself; `own`
    /// names the surface that it is known to lie on.
    pub fn blocks<R: Ring>(&self, x: &Probe<R>, own: Option<Surface>, light: &LightSource) -> bool {
        let way = if light.is_sun() { Way::ToSun } else { Way::ToPoint };
        let segment = Segment::bounded(&self.forms, &x.bounds, light);
        let by_pairs = || {
            let (forms, x) = (self.forms_in_pairs(), x.in_pairs()?);
            self.is_met(forms, &Segment::exact(forms, &x, &ExactPoint::from_light(light)), own, way)
        };
        decide_by_pairs(self.is_met(&self.forms, &segment, own, way), by_pairs, || {
            let forms = self.exact_forms().lifted::<R>();
            let segment = Segment::exact(&forms, x.exact(), &ExactPoint::from_light(light));
            self.is_met(&forms, &segment, own, way).unwrap_or(false)
        })
    }

    fn is_met<T: Decide>(
        &self,
        forms: &Forms<T>,
        segment: &Segment<T>,
        own: Option<Surface>,
        way: Way,
    ) -> Option<bool> {
        // A light at the point itself: nothing lies between.
        let moves = any_known(segment.along.iter().map(|coordinate| Some(coordinate.decide()? != Sign::Zero)));
        if !moves? {
            return Some(false);
        }
        any_known(self.layout.parts.iter().map(|part| {
            let mut surface = segment.along_surface(forms, part.surface);
            if own == Some(part.surface) {
                surface.constant = T::number(0.0);
            }
            let trims: Vec<Polynomial<T>> = part.trims.iter().map(|&trim| segment.along_trim(forms, trim)).collect();
            is_met(&surface, &trims, way)
        }))
    }

    /// On which side of the tangent plane at `x`, a point of `surface`, the light lies: positive outside.
    pub fn facing<R: Ring>(&self, surface: Surface, x: &Probe<R>, light: &LightSource) -> Sign {
        let (local_light, local_x) = (self.forms.pull_back_light(light), self.forms.pull_back_point(&x.bounds));
        let by_pairs = || {
            let (forms, light) = (self.forms_in_pairs(), ExactPoint::from_light(light));
            let local_x = match x.local_in_pairs(&self.placement) {
                Some(([x, y, z], weight)) => [x, y, z, Surd::plain(weight * Pair::exact(self.layout.unit))],
                None => x.in_pairs().map(|x| forms.pull_back(&x.xyz, &x.w))?,
            };
            facing_value(forms, surface, &local_x, &forms.pull_back(&light.xyz, &light.w)).decide()
        };
        decide_by_pairs(facing_value(&self.forms, surface, &local_x, &local_light).sign(), by_pairs, || {
            let (forms, x, light) = (self.exact_forms().lifted::<R>(), x.exact(), ExactPoint::<R>::from_light(light));
            let (local_x, local_light) = (forms.pull_back(&x.xyz, &x.w), forms.pull_back(&light.xyz, &light.w));
            facing_value(&forms, surface, &local_x, &local_light).sign()
        })
    }

    /// A vector along the outer normal at a point of `surface`, world coordinates; zero at a tip.
    pub fn outward<R: Ring>(&self, surface: Surface, x: &ExactPoint<R>) -> [R; 3] {
        let forms = self.exact_forms().lifted::<R>();
        outward_value(&forms, surface, &forms.pull_back(&x.xyz, &x.w))
    }

    /// Whether a point of a part's surface lies in the part. Exact.
    pub fn part_holds<R: Ring>(&self, part: &Part, x: &ExactPoint<R>) -> bool {
        let forms = self.exact_forms().lifted::<R>();
        trims_hold(&forms, part, &forms.pull_back(&x.xyz, &x.w)) == Some(true)
    }
}

/// See [`PlacedAnalytic::outward`]; of a quadric half the gradient of its form, of a plane minus it.
pub(super) fn outward_value<T: Decide>(forms: &Forms<T>, surface: Surface, x: &LocalPoint<T>) -> [T; 3] {
    let gradient: [T; 3] = match surface {
        Surface::Quadric(index) => forms.quadrics[index].half_gradient(x),
        Surface::Plane(index) => std::array::from_fn(|k| -forms.planes[index][k].clone()),
    };
    std::array::from_fn(|k| {
        let term = |i: usize| forms.adjugate[i][k].clone() * gradient[i].clone();
        term(0) + term(1) + term(2)
    })
}

/// Whether a point of a part's surface lies in the part.
pub(super) fn trims_hold<T: Decide>(forms: &Forms<T>, part: &Part, x: &LocalPoint<T>) -> Option<bool> {
    all_known(part.trims.iter().map(|&trim| trim_value(forms, trim, x, x).decide().map(|sign| sign != Sign::Negative)))
}

/// Positive where the light lies strictly outside the tangent plane; affine in x.
pub(crate) fn facing_value<T: Decide>(
    forms: &Forms<T>,
    surface: Surface,
    x: &LocalPoint<T>,
    light: &LocalPoint<T>,
) -> T {
    match surface {
        Surface::Quadric(index) => forms.quadric(index, x, light),
        Surface::Plane(index) => -forms.plane(index, light),
    }
}

/// A trim at a point (a quadric: at a pair of points): ≥ 0 where it holds.
fn trim_value<T: Decide>(forms: &Forms<T>, trim: Trim, x: &LocalPoint<T>, y: &LocalPoint<T>) -> T {
    match trim {
        Trim::Inside(index) => -forms.quadric(index, x, y),
        Trim::Above(index) => forms.plane(index, x),
        Trim::Below(index) => -forms.plane(index, x),
    }
}

/// A segment x + s·(light − w·x), pulled back.
pub(super) struct Segment<T> {
    pub(super) start: LocalPoint<T>,
    pub(super) along: LocalPoint<T>,
}

impl Segment<Approx> {
    fn bounded(forms: &Forms<Approx>, x: &Point, light: &LightSource) -> Self {
        let way =
            if light.is_sun() { light.xyz().to_array().map(Approx::exact) } else { Point::exact(light.xyz()).minus(x) };
        Self { start: forms.pull_back_point(x), along: forms.pull_back_direction(&way) }
    }
}

impl<T: Decide> Segment<T> {
    fn exact(forms: &Forms<T>, x: &ExactPoint<T>, light: &ExactPoint<T>) -> Self {
        let way: [T; 3] =
            std::array::from_fn(|i| light.xyz[i].clone() * x.w.clone() - x.xyz[i].clone() * light.w.clone());
        Self { start: forms.pull_back(&x.xyz, &x.w), along: forms.pull_back_direction(&way) }
    }

    pub(super) fn along_surface(&self, forms: &Forms<T>, surface: Surface) -> Polynomial<T> {
        match surface {
            Surface::Quadric(index) => self.along_quadric(forms, index),
            Surface::Plane(index) => self.along_plane(forms, index),
        }
    }

    pub(super) fn along_trim(&self, forms: &Forms<T>, trim: Trim) -> Polynomial<T> {
        match trim {
            Trim::Inside(index) => self.along_quadric(forms, index).negated(),
            Trim::Above(index) => self.along_plane(forms, index),
            Trim::Below(index) => self.along_plane(forms, index).negated(),
        }
    }

    fn along_quadric(&self, forms: &Forms<T>, index: usize) -> Polynomial<T> {
        let mixed = forms.quadric(index, &self.start, &self.along);
        Polynomial {
            constant: forms.quadric(index, &self.start, &self.start),
            linear: mixed.clone() + mixed,
            quadratic: forms.quadric(index, &self.along, &self.along),
        }
    }

    fn along_plane(&self, forms: &Forms<T>, index: usize) -> Polynomial<T> {
        Polynomial {
            constant: forms.plane(index, &self.start),
            linear: forms.plane(index, &self.along),
            quadratic: T::number(0.0),
        }
    }
}

/// A value at a light is sharp where its bound is below this share of it. Any number serves: what is not sharp is told exactly.
const SHARP: f64 = 1.0 / (1u64 << 30) as f64;

/// A number times a power of two, whatever that leaves of it.
fn scaled(number: Approx, factor: f64) -> Approx {
    let [value, error] = [number.value * factor, number.error * factor.abs()];
    // Below the normal floats bounds leave out up to 2^-1074.
    let keeps_digits =
        |before: f64, after: f64| before == 0.0 || after.is_normal() && before.abs() > 2.0 * f64::MIN_POSITIVE;
    match value.is_finite() && error.is_finite() {
        true if keeps_digits(number.value, value) && keeps_digits(number.error, error) => Approx { value, error },
        true => Approx { value, error: error + f64::MIN_POSITIVE * factor.abs().max(1.0) },
        false => Approx::UNKNOWN,
    }
}

/// The forms with bounds, and their scale. The matrix is scaled by a power of two that brings the weight near one, so that products of
/// values stay far from underflow whatever the scale.
fn approx_forms(layout: &Layout, placement: &Placement) -> (Forms<Approx>, f64) {
    let (adjugate, determinant) = (placement.adjugate(), placement.determinant());
    let sign = if placement.is_mirrored() { -1.0 } else { 1.0 };
    let weight = determinant * Approx::exact(sign * layout.unit);
    let factor = sign / power_of_two_below(weight.value.abs());
    let forms = Forms {
        adjugate: adjugate.map(|row| row.map(|number| scaled(number, factor))),
        translation: placement.map().translation.to_array().map(Approx::exact),
        weight: scaled(weight, factor.abs()),
        quadrics: layout.quadrics.iter().map(|form| form.map(Dyadic::to_approx)).collect(),
        planes: layout.planes.iter().map(|plane| std::array::from_fn(|k| plane[k].to_approx())).collect(),
    };
    (forms, factor.abs())
}

fn exact_forms(layout: &Layout, placement: &Placement) -> Forms<Dyadic> {
    let (adjugate, determinant) = placement.exact_adjugate::<Dyadic>();
    let turned = |number: Dyadic| if placement.is_mirrored() { -number } else { number };
    Forms {
        adjugate: adjugate.map(|row| row.map(turned)),
        translation: placement.map().translation.to_array().map(Dyadic::new),
        weight: turned(determinant) * Dyadic::new(layout.unit),
        quadrics: layout.quadrics.clone(),
        planes: layout.planes.clone(),
    }
}
