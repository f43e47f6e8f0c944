//! Cut-outs: triangles with holes where a texture is transparent, as glTF's MASK materials have them.
//!
//! A point of such a triangle is opaque, and blocks light, where factor · vertex alpha · texture alpha ≥ cutoff (glTF 2.0 §3.9.4),
//! the texture as its sampler reads it at the finest level ([`AlphaMap`]). Texture coordinates and vertex alphas are affine on the
//! triangle, by the f64 values of its corners.
//!
//! Where a way from x to the light L meets the triangle (a, b, c), the three determinants |b − x, c − x, L − w·x| and so on are to each
//! other as the barycentric coordinates of the meeting point. So coordinates there are ratios of polynomials in the input, and
//! whether alpha reaches the cutoff is a sign: a filter tells it nearly always, exact arithmetic the rest (NUMERICS.md, "Cut-outs"). Seen
//! edge-on, a triangle has no single point that is met; there, and without area, it counts as opaque.
//!
//! Bounds of alpha over boxes of texture coordinates tell triangles, and parts of them, that are wholly opaque or wholly clear.
//! Cost: some 200 ns a point, microseconds where the filter is in doubt.

mod alpha_map;
mod bilinear;
mod likely;
mod placed;

use std::{ops::Range, sync::Arc};

pub use alpha_map::{AlphaMap, Filter, Wrap};

use crate::{
    approx::Approx,
    blocking::Probe,
    decide::Decide,
    decisions,
    dyadic::Dyadic,
    light::LightSource,
    mesh::Mesh,
    point::{ExactPoint, Point},
    ring::{Ring, Sign, determinant},
};

/// Texture coordinates up to this size are accepted, 2^31: texels are then numbered below 2^48, which floats and integers hold.
pub const MOST_PLACE: f64 = 2_147_483_648.0;

/// How a surface is cut out.
#[derive(Clone, Debug, PartialEq)]
pub struct CutOut {
    /// The texture's alpha; `None` counts as one everywhere.
    pub map: Option<Arc<AlphaMap>>,
    /// How the map is read between its texels.
    pub filter: Filter,
    /// How the map goes on along each coordinate.
    pub wrap: [Wrap; 2],
    /// What alpha is multiplied by, 0 to 1.
    pub factor: f64,
    /// The least alpha that is opaque, 0 or more.
    pub cutoff: f64,
}

/// What a vertex says about the texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TexturePoint {
    /// Texture coordinates: (0, 0) is the picture's upper left corner, (1, 1) its lower right.
    pub place: [f64; 2],
    /// The alpha of the vertex' colour, 0 to 1; one where it has no colour.
    pub alpha: f64,
}

/// Triangles of a mesh that one cut-out applies to.
#[derive(Clone, Debug, PartialEq)]
pub struct CutOutPart {
    /// Which triangles.
    pub faces: Range<u32>,
    /// How they are cut out.
    pub cut_out: CutOut,
    /// The first vertex that they may use.
    pub first_vertex: u32,
    /// What each vertex from there on says.
    pub vertices: Vec<TexturePoint>,
}

/// Whether a triangle, or a part of one, has holes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Opacity {
    /// It has none.
    Opaque,
    /// It is all hole.
    Clear,
    /// It has holes, or bounds cannot tell.
    Mixed,
}

/// Why cut-outs are refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CutOutDefect {
    /// A map without texels, with too many, or with another number than its size says.
    #[error("a map of alpha has 1 to 65536 texels along each side, and a value for each")]
    Texels,
    /// A factor, cutoff, texture coordinate or vertex alpha that is no number or out of range.
    #[error("alphas are 0 to 1, cutoffs 0 or more, texture coordinates between -2^31 and 2^31")]
    Number,
    /// Parts that overlap, are out of order, or name triangles or vertices that are not there.
    #[error("the parts of a cut-out mesh follow each other and name triangles and vertices that are there")]
    Part,
}

/// The cut-outs of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CutOuts {
    parts: Vec<CutOutPart>,
    /// Of every triangle.
    opacities: Vec<Opacity>,
}

impl CutOuts {
    /// Checks the parts and looks at every triangle; `None` where all of them are opaque.
    pub(crate) fn new(parts: Vec<CutOutPart>, triangles: &[[u32; 3]]) -> Result<Option<Self>, CutOutDefect> {
        let mut end = 0;
        for part in &parts {
            part.check(end, triangles)?;
            end = part.faces.end;
        }
        let mut cut_outs = Self { parts, opacities: vec![Opacity::Opaque; triangles.len()] };
        for number in 0..cut_outs.parts.len() {
            for face in cut_outs.parts[number].faces.clone() {
                cut_outs.opacities[face as usize] = cut_outs.parts[number].face(face, triangles).opacity();
            }
        }
        let has_holes = cut_outs.opacities.iter().any(|&opacity| opacity != Opacity::Opaque);
        Ok(has_holes.then_some(cut_outs))
    }

    pub(crate) fn opacity(&self, face: usize) -> Opacity {
        self.opacities[face]
    }

    /// How a triangle that belongs to a part is cut out.
    pub(crate) fn face(&self, face: usize, mesh: &Mesh) -> Option<FaceCutOut<'_>> {
        let face = face as u32;
        let part = self.parts.partition_point(|part| part.faces.end <= face);
        let part = self.parts.get(part).filter(|part| part.faces.contains(&face))?;
        Some(part.face(face, mesh.triangles()))
    }
}

impl CutOutPart {
    fn check(&self, end: u32, triangles: &[[u32; 3]]) -> Result<(), CutOutDefect> {
        let of_one = |value: f64| (0.0..=1.0).contains(&value);
        let is_vertex = |vertex: &TexturePoint| {
            of_one(vertex.alpha) && vertex.place.iter().all(|coordinate| coordinate.abs() <= MOST_PLACE)
        };
        let CutOut { factor, cutoff, .. } = self.cut_out;
        let is_cutoff = cutoff >= 0.0 && cutoff.is_finite();
        if !of_one(factor) || !is_cutoff || !self.vertices.iter().all(is_vertex) {
            return Err(CutOutDefect::Number);
        }
        let faces = triangles.get(self.faces.start as usize..self.faces.end as usize);
        let faces = faces.filter(|_| self.faces.start >= end).ok_or(CutOutDefect::Part)?;
        let is_here = |&vertex: &u32| {
            vertex.checked_sub(self.first_vertex).is_some_and(|index| (index as usize) < self.vertices.len())
        };
        if faces.as_flattened().iter().all(is_here) { Ok(()) } else { Err(CutOutDefect::Part) }
    }

    fn face(&self, face: u32, triangles: &[[u32; 3]]) -> FaceCutOut<'_> {
        let vertex = |vertex: u32| self.vertices[(vertex - self.first_vertex) as usize];
        FaceCutOut { cut_out: &self.cut_out, corners: triangles[face as usize].map(vertex) }
    }
}

/// How one triangle is cut out.
#[derive(Clone, Copy, Debug)]
pub struct FaceCutOut<'a> {
    cut_out: &'a CutOut,
    corners: [TexturePoint; 3],
}

/// A point of a triangle by homogeneous numbers: texture coordinates and alpha are what is here over `weight` > 0.
struct Met<T> {
    place: [T; 2],
    alpha: T,
    weight: T,
}

impl FaceCutOut<'_> {
    /// The same for a triangle whose corners are counted from another one on: 0, 1 or 2.
    #[must_use]
    pub fn counted_from(mut self, corner: u8) -> Self {
        self.corners.rotate_left(usize::from(corner));
        self
    }

    /// Whether the point where the way from `x` to the light meets the triangle with these corners is opaque. The way meets it:
    /// [`polygon_blocks`](crate::blocking::polygon_blocks). Exact.
    pub fn is_opaque_at<R: Ring>(&self, corners: [&Point; 3], x: &Probe<R>, light: &LightSource) -> bool {
        let filtered = || {
            let towards = light.xyz().to_array().map(Approx::exact);
            let weights = weights(
                &corners.map(|corner| corner.coordinates()),
                (&x.bounds.coordinates(), &Approx::exact(1.0)),
                (&towards, &Approx::exact(light.w())),
            );
            self.is_opaque_on(weights)
        };
        decisions::decide(filtered(), || {
            let light = ExactPoint::<R>::from_light(light);
            let corners = corners.map(|corner| corner.to_exact::<R>().xyz);
            let x = x.exact();
            let weights = weights(&corners, (&x.xyz, &x.w), (&light.xyz, &light.w));
            let sum = R::sum_of_three(weights.clone());
            let upright = |value: R| if sum.sign() == Sign::Negative { -value } else { value };
            // Edge-on, or without area.
            sum.sign() == Sign::Zero
                || self.is_opaque(&self.met(weights.map(upright), upright(sum.clone()))).unwrap_or(true)
        })
    }

    /// Whether the point that a way meets is opaque: by the way's weights at the corners (as determinants, each of the side opposite its
    /// corner, all of one sign). `None` where their bounds cannot tell.
    pub fn is_opaque_on(&self, way: [Approx; 3]) -> Option<bool> {
        let sum = Approx::sum_of_three(way);
        sum.sign().filter(|&sign| sign != Sign::Zero)?;
        self.is_opaque(&self.met(way.map(|weight| weight.divided_by(sum)), Approx::exact(1.0)))
    }

    /// Whether the triangle has holes.
    pub fn opacity(&self) -> Opacity {
        self.opacity_within([f64::NEG_INFINITY; 2], [f64::INFINITY; 2])
    }

    /// Whether the triangle has holes in what the ways meet whose weights, as in [`FaceCutOut::is_opaque_on`], lie in the hull of these.
    /// Weights must be positive where a way meets the triangle.
    pub fn opacity_over(&self, ways: impl IntoIterator<Item = [Approx; 3]>) -> Opacity {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for weights in ways {
            let sum = Approx::sum_of_three(weights);
            // The map from ways to points is projective: it maps hulls to hulls where its denominator keeps its sign.
            if sum.lower().is_nan() || sum.lower() <= 0.0 {
                return Opacity::Mixed;
            }
            let place = self.place(&weights.map(|weight| weight.divided_by(sum)));
            for axis in 0..2 {
                low[axis] = low[axis].min(place[axis].lower());
                high[axis] = high[axis].max(place[axis].upper());
                if place[axis].error.is_nan() || place[axis].value.is_nan() {
                    return Opacity::Mixed;
                }
            }
        }
        self.opacity_within(low, high)
    }

    /// Whether the triangle has holes where its texture coordinates lie in a box. The vertices' alphas count as a whole.
    fn opacity_within(&self, low: [f64; 2], high: [f64; 2]) -> Opacity {
        let own = |axis: usize| self.corners.map(|corner| corner.place[axis]);
        let [columns, rows] = [0, 1].map(|axis| {
            let (least, greatest) = (least(own(axis)), greatest(own(axis)));
            [low[axis].clamp(least, greatest), high[axis].clamp(least, greatest)]
        });
        let texels = match &self.cut_out.map {
            None => [AlphaMap::ONE; 2],
            Some(map) => {
                let texels = |place: [f64; 2], axis: usize| self.cut_out.texels(place, map.size()[axis]);
                map.range(self.cut_out.wrap, texels(columns, 0), texels(rows, 1))
            }
        };
        let alphas = self.corners.map(|corner| corner.alpha);
        if self.cut_out.reaches(least(alphas), texels[0]) {
            Opacity::Opaque
        } else if self.cut_out.reaches(greatest(alphas), texels[1]) {
            self.opacity_between_texels([columns, rows])
        } else {
            Opacity::Clear
        }
    }

    /// The same by what is between the texels, where the box meets few of them.
    fn opacity_between_texels(&self, ranges: [[f64; 2]; 2]) -> Opacity {
        let &CutOut { ref map, filter, factor, cutoff, .. } = self.cut_out;
        let map = map.as_ref().filter(|_| filter == Filter::Linear);
        let Some([low, high]) = map.and_then(|map| self.cut_out.bilinear_range(map, ranges)) else {
            return Opacity::Mixed;
        };
        let needed = Approx::exact(cutoff) * Approx::exact(f64::from(AlphaMap::ONE));
        let excess =
            |alpha: f64, texture: f64| Approx::exact(factor) * Approx::exact(alpha) * Approx::exact(texture) - needed;
        let alphas = self.corners.map(|corner| corner.alpha);
        if excess(least(alphas), low).lower() >= 0.0 {
            Opacity::Opaque
        } else if excess(greatest(alphas), high).upper() < 0.0 {
            Opacity::Clear
        } else {
            Opacity::Mixed
        }
    }

    fn met<T: Decide>(&self, weights: [T; 3], sum: T) -> Met<T> {
        let alpha = mean(&weights, self.corners.map(|corner| corner.alpha));
        Met { place: self.place(&weights), alpha, weight: sum }
    }

    /// The texture coordinates, times the sum of the weights.
    fn place<T: Decide>(&self, weights: &[T; 3]) -> [T; 2] {
        [0, 1].map(|axis| mean(weights, self.corners.map(|corner| corner.place[axis])))
    }

    /// Whether alpha reaches the cutoff at a point of the triangle; `None` where bounds cannot tell.
    fn is_opaque<T: Decide>(&self, met: &Met<T>) -> Option<bool> {
        let cut_out = self.cut_out;
        // Alpha times a power of the weight, 0 to ONE.
        let (texture, weight) = match &cut_out.map {
            None => (T::number(f64::from(AlphaMap::ONE)), met.weight.clone()),
            Some(map) => {
                let [column, row] = [0, 1].map(|axis| self.texel(met, axis, map.size()[axis]));
                self.sampled(map, [column?, row?], &met.weight)
            }
        };
        let alpha = T::number(cut_out.factor) * met.alpha.clone() * texture;
        let needed = T::number(cut_out.cutoff) * T::number(f64::from(AlphaMap::ONE)) * weight;
        Some((alpha - needed).decide()? != Sign::Negative)
    }

    /// The texture's alpha times the weight (once: nearest, thrice: linear, less one for the vertex' alpha), and that power of the weight.
    fn sampled<T: Decide>(&self, map: &AlphaMap, [column, row]: [(i64, T); 2], weight: &T) -> (T, T) {
        let first = [column.0, row.0];
        if self.cut_out.filter == Filter::Nearest {
            return (T::number(self.cut_out.texel(map, first)), weight.clone());
        }
        let (x, y) = (column.1, row.1);
        let (from_x, from_y) = (weight.clone() - x.clone(), weight.clone() - y.clone());
        let line = |[left, right]: [f64; 2]| T::number(left) * from_x.clone() + T::number(right) * x.clone();
        let [above, below] = self.cut_out.square(map, first).map(line);
        let square = weight.clone() * weight.clone();
        (above * from_y + below * y, square * weight.clone())
    }

    /// The texel (with linear filtering: the one before) along an axis of `count` texels, and how far past its beginning (its
    /// middle) the point is, times the weight. `None` where bounds cannot tell.
    fn texel<T: Decide>(&self, met: &Met<T>, axis: usize, count: u32) -> Option<(i64, T)> {
        let shift = if self.cut_out.filter == Filter::Linear { 0.5 } else { 0.0 };
        let place = met.place[axis].clone() * T::number(f64::from(count));
        let past = |texel: i64| place.clone() - met.weight.clone() * T::number(texel as f64 + shift);
        let own = self.corners.map(|corner| corner.place[axis]);
        let [mut low, mut high] = self.cut_out.texels([least(own), greatest(own)], count);
        high += i64::from(self.cut_out.filter == Filter::Nearest);
        // The texel is at least `low` and below `high`, and mostly the first that is asked.
        let guess = place.about_ratio(&met.weight).map(|ratio| (ratio - shift).floor() as i64);
        let mut guesses = guess.into_iter().flat_map(|texel| [texel, texel.saturating_add(1)]);
        while high - low > 1 {
            let guess = guesses.next().filter(|&guess| low < guess && guess < high);
            let middle = guess.unwrap_or(low + (high - low) / 2);
            match past(middle).decide()? {
                Sign::Negative => high = middle,
                Sign::Zero | Sign::Positive => low = middle,
            }
        }
        Some((low, past(low)))
    }
}

impl CutOut {
    /// The texels, first and last, that points between two coordinates depend on, of `count` along the axis.
    fn texels(&self, [low, high]: [f64; 2], count: u32) -> [i64; 2] {
        let count = f64::from(count);
        match self.filter {
            Filter::Nearest => [floor_of_product(low, count), floor_of_product(high, count)],
            Filter::Linear => {
                // ⌊x − ½⌋ = ⌊(⌊2x⌋ − 1)/2⌋, and the texel after it.
                let before = |place: f64| (floor_of_product(place, 2.0 * count) - 1).div_euclid(2);
                [before(low), before(high) + 1]
            }
        }
    }

    /// The value of a texel by its numbers along the axes, of any size.
    fn texel(&self, map: &AlphaMap, index: [i64; 2]) -> f64 {
        let wrapped = |axis: usize| self.wrap[axis].texel(index[axis], map.size()[axis]);
        f64::from(map.texel([0, 1].map(wrapped)))
    }

    /// The values of a texel and of those after it: two rows of two.
    fn square(&self, map: &AlphaMap, [column, row]: [i64; 2]) -> [[f64; 2]; 2] {
        let wrapped =
            |axis: usize, first: i64| [first, first + 1].map(|index| self.wrap[axis].texel(index, map.size()[axis]));
        let columns = wrapped(0, column);
        wrapped(1, row).map(|row| columns.map(|column| f64::from(map.texel([column, row]))))
    }

    /// Whether factor · alpha · texel is at least the cutoff. Exact.
    fn reaches(&self, alpha: f64, texel: u16) -> bool {
        fn excess<T: Decide>(cut_out: &CutOut, alpha: f64, texel: u16) -> T {
            let number = |value: f64| T::number(value);
            number(cut_out.factor) * number(alpha) * number(f64::from(texel))
                - number(cut_out.cutoff) * number(f64::from(AlphaMap::ONE))
        }
        let sign = excess::<Approx>(self, alpha, texel).sign();
        sign.unwrap_or_else(|| excess::<Dyadic>(self, alpha, texel).sign()) != Sign::Negative
    }
}

/// ⌊x · n⌋ of the exact product, below 2^53 in size.
fn floor_of_product(x: f64, n: f64) -> i64 {
    let product = x * n;
    let floor = product.floor();
    // What rounding took away; a product too small for floats keeps the sign of x.
    let rest = if product == 0.0 { x } else { x.mul_add(n, -product) };
    floor as i64 - i64::from(floor == product && rest < 0.0)
}

/// The determinants |b − x, c − x, L − w·x|, and so on round the triangle (a, b, c): each of the side opposite its corner.
fn weights<T: Decide>(corners: &[[T; 3]; 3], (x, w): (&[T; 3], &T), (light, light_w): (&[T; 3], &T)) -> [T; 3] {
    let from_x = |p: &[T; 3], weight: &T| -> [T; 3] {
        std::array::from_fn(|k| p[k].clone() * w.clone() - x[k].clone() * weight.clone())
    };
    let one = T::number(1.0);
    let away = [0, 1, 2].map(|k| from_x(&corners[k], &one));
    let towards = from_x(light, light_w);
    [0, 1, 2].map(|k| determinant(&[away[(k + 1) % 3].clone(), away[(k + 2) % 3].clone(), towards.clone()]))
}

/// The mean of values, times the sum of the weights.
fn mean<T: Decide>(weights: &[T; 3], values: [f64; 3]) -> T {
    let [a, b, c] = weights.clone();
    let [p, q, r] = values.map(T::number);
    T::sum_of_three([a * p, b * q, c * r])
}

fn least(values: [f64; 3]) -> f64 {
    values.into_iter().fold(f64::INFINITY, f64::min)
}

fn greatest(values: [f64; 3]) -> f64 {
    values.into_iter().fold(f64::NEG_INFINITY, f64::max)
}

#[cfg(test)]
mod tests;
