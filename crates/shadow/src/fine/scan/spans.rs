//! Eight occluders against a patch: in each row, the columns that each one hides.
//!
//! An edge function of an occluder, and the difference of its plane's depth and the receiver's, are linear in row and column
//! once multiplied by the sample's third coordinate, which is positive: f(i, j) = first + i·row + j·column. A sample is
//! blocked where all of them exceed their tolerances, not blocked where one is below its negative; between, the pair
//! is in doubt. In a row each function bounds the columns from one side, at −(first + i·row)/column. NUMERICS.md, "Samples by scan
//! conversion", derives the tolerances.

use umbriel_geometry::simd::{F8, Float, I8, Int, Lanes, M8, Mask, Simd};

use super::{
    pack::{Corners, ROUNDOFF, Triangles},
    patch::Patch,
    tree::WIDTH,
};

/// Rows that are scanned at once.
const ROWS: u32 = 8;

/// A step of a column is made at least this part of the tolerance, so that spans have an end.
const LEAST_STEP: f32 = 1.0 / 1024.0;

/// Beyond all columns.
const FAR: f32 = 1e12;

/// More than any range of depths that is known.
const UNBOUNDED: f32 = 1e15;

/// A linear function of row and column, a lane an occluder.
#[derive(Clone, Copy, Debug)]
pub(super) struct Linear<V> {
    pub(super) first: V,
    pub(super) row: V,
    pub(super) column: V,
    pub(super) tolerance: V,
}

impl<V: Float<WIDTH>> Linear<V> {
    #[inline(always)]
    fn at(&self, row: V, column: V) -> V {
        self.first + row * self.row + column * self.column
    }

    /// The least and the greatest value in some rows and columns beyond the first ones.
    #[inline(always)]
    pub(super) fn range<S: Lanes<WIDTH, Float = V>>(&self, simd: S, row: V, rows: V, columns: V) -> [V; 2] {
        let none = simd.splat(0.0);
        let start = self.first + row * self.row;
        let (along, across) = (rows * self.row, columns * self.column);
        [start + along.min(none) + across.min(none), start + along.max(none) + across.max(none)]
    }
}

/// How far samples are to the left of lines through points, relative to the patch's middle, times the lengths along them.
#[inline(always)]
pub(super) fn beside_lines<S: Simd>(
    simd: S,
    along: [F8<S>; 2],
    from: [F8<S>; 2],
    patch: &Patch,
    tolerance: F8<S>,
) -> Linear<F8<S>> {
    Linear {
        first: turn(simd, along, from, patch, 0),
        row: turn(simd, along, from, patch, 1),
        column: turn(simd, along, from, patch, 2),
        tolerance,
    }
}

/// Eight occluders as functions over a patch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Functions<S: Simd> {
    edges: [Linear<F8<S>>; 3],
    /// Twice the area times how much nearer than the patch's plane.
    plane: Linear<F8<S>>,
    /// Occluders all of which is nearer than all of the patch.
    nearer: M8<S>,
    /// Occluders of which nothing is certain inside.
    thin: M8<S>,
    /// Occluders that block nothing for certain: those and what has holes.
    vague: M8<S>,
    /// Whether some lane is neither.
    is_plane_used: bool,
}

/// How exact images and depths are.
#[derive(Clone, Copy, Debug)]
pub(super) struct Errors {
    pub(super) image: f32,
    pub(super) depth: f32,
}

impl Errors {
    /// How much deeper than `depth` something must be to be deeper for certain.
    #[inline(always)]
    pub(super) fn depth_slack(&self, depth: f32) -> f32 {
        2.0 * self.depth + 32.0 * f32::EPSILON * depth.abs()
    }
}

/// The sides of eight triangles, counted from a point of the image, and how exact functions of them are.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outlines<S: Simd> {
    /// The sides across from the corners.
    pub(super) along: [[F8<S>; 2]; 3],
    pub(super) x: [F8<S>; 3],
    pub(super) y: [F8<S>; 3],
    /// Twice.
    pub(super) area: F8<S>,
    /// Triangles of which nothing is certain inside.
    pub(super) is_thin: M8<S>,
    /// What a side's function may be off by where nothing is farther from the point than `reach`.
    pub(super) tolerance: F8<S>,
}

impl<S: Simd> Outlines<S> {
    /// Counted from a point from which no receiver is farther than `reach`. Roundings are `of_reach` unit roundoffs of the reach and one of `others`, quanta
    /// (NUMERICS.md, "Edges" and "Bunches").
    #[inline(always)]
    pub(super) fn new(
        simd: S,
        triangles: &Triangles<S>,
        (center, reach): ([i32; 2], f32),
        [of_reach, others]: [f32; 2],
        errors: &Errors,
    ) -> Self {
        let Corners { x, y, reach: away } = triangles.corners_from(simd, center);
        let reach = away.max(simd.splat8(reach));
        let (mut along, mut length) = ([[simd.splat8(0.0); 2]; 3], simd.splat8(0.0));
        for (k, along) in along.iter_mut().enumerate() {
            // Differences of integers are exact.
            let (from, to) = ((k + 1) % 3, (k + 2) % 3);
            *along =
                [(triangles.x[to] - triangles.x[from]).to_float(), (triangles.y[to] - triangles.y[from]).to_float()];
            length = length.max(along[0].abs()).max(along[1].abs());
        }
        let error = simd.splat8(errors.image);
        let area = along[0][0] * along[1][1] - along[0][1] * along[1][0];
        let area_off = simd.splat8(9.0) * (error * (length + error) + simd.splat8(ROUNDOFF) * length * length);
        let is_thin = area.le(area_off);
        let thin = (area_off + area_off).select(is_thin, simd.splat8(0.0));
        let roundings = length * (simd.splat8(of_reach * ROUNDOFF) * reach + simd.splat8(others * ROUNDOFF));
        let tolerance = simd.splat8(10.0 * errors.image) * (reach + length) + roundings + thin;
        Self { along, x, y, area, is_thin, tolerance }
    }

    /// What the difference of depths, weighted by the sides' functions, may be off by: `depths` are those of the corners, counted from `middle`, as is the `range`
    /// of those of the receivers.
    #[inline(always)]
    pub(super) fn plane_off(
        &self,
        simd: S,
        depths: &[F8<S>; 3],
        (middle, range): (f32, f32),
        errors: &Errors,
    ) -> F8<S> {
        let size = depths[0].abs().max(depths[1].abs()).max(depths[2].abs()).max(simd.splat8(range));
        let off = simd.splat8(errors.depth) + simd.splat8(16.0 * ROUNDOFF) * (size + simd.splat8(middle.abs()));
        let reach = self.area + simd.splat8(4.0) * self.tolerance;
        simd.splat8(5.0) * size * self.tolerance + simd.splat8(3.0) * reach * off
    }
}

impl<S: Simd> Functions<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, triangles: &Triangles<S>, lanes: u32, patch: &Patch, errors: &Errors) -> Self {
        let outlines = Outlines::new(simd, triangles, (patch.center, patch.reach), [256.0, 0.0], errors);
        let Outlines { along, x, y, is_thin, tolerance, .. } = outlines;
        let edges = [
            beside_lines(simd, along[0], [x[1], y[1]], patch, tolerance),
            beside_lines(simd, along[1], [x[2], y[2]], patch, tolerance),
            beside_lines(simd, along[2], [x[0], y[0]], patch, tolerance),
        ];
        let limit = patch.nearest - errors.depth_slack(patch.nearest);
        let nearer = triangles.farthest().lt(simd.splat8(limit));
        // Mostly the depths alone tell.
        let is_plane_used = (!(nearer | is_thin)).bits() & lanes != 0;
        let plane = if is_plane_used { plane(simd, triangles, &outlines, patch, &edges, errors) } else { edges[0] };
        Self { edges, plane, nearer, thin: is_thin, vague: is_thin | triangles.holed, is_plane_used }
    }

    /// One sample against all eight: those that block it for certain, and those in doubt.
    #[inline(always)]
    pub(super) fn at(&self, simd: S, row: u32, column: u32) -> [u32; 2] {
        let (row, column) = (simd.splat8(row as f32), simd.splat8(column as f32));
        let [a, b, c] = &self.edges;
        let least = a.at(row, column).min(b.at(row, column)).min(c.at(row, column));
        let tolerance = self.edges[0].tolerance;
        // Not "at least": what is no number is in doubt.
        let beside = least.lt(-tolerance);
        if beside.bits() == 0xff {
            return [0, 0];
        }
        let (nearer, off) = (self.plane.at(row, column), self.plane.tolerance);
        let certain = least.gt(tolerance) & (self.nearer | nearer.gt(off)) & !self.vague;
        let beyond = nearer.lt(-off) & !(self.nearer | self.thin);
        [certain.bits(), (!(beside | beyond | certain)).bits()]
    }

    /// The lanes that block no sample in eight rows from `row` on, and those that block all: functions over a box are
    /// between their values at its corners.
    #[inline(always)]
    pub(super) fn over_rows(&self, simd: S, patch: &Patch, row: u32) -> [u32; 2] {
        let first = simd.splat8(row as f32);
        let rows = simd.splat8((patch.rows - row).min(ROWS) as f32 - 1.0);
        let columns = simd.splat8((patch.columns - 1) as f32);
        let mut missed = simd.mask8(0);
        let mut covered = !self.vague;
        for edge in &self.edges {
            let [low, high] = edge.range(simd, first, rows, columns);
            missed = missed | high.lt(-edge.tolerance);
            covered = covered & low.gt(edge.tolerance);
        }
        if self.is_plane_used {
            let [low, high] = self.plane.range(simd, first, rows, columns);
            missed = missed | (high.lt(-self.plane.tolerance) & !(self.nearer | self.thin));
            covered = covered & (self.nearer | low.gt(self.plane.tolerance));
        }
        [missed.bits(), covered.bits()]
    }

    /// The functions as bounds of columns.
    #[inline(always)]
    pub(super) fn bounds(&self, simd: S) -> Bounds {
        let [(a, a_holds), (b, b_holds), (c, c_holds)] =
            [side(simd, &self.edges[0]), side(simd, &self.edges[1]), side(simd, &self.edges[2])];
        let (plane, plane_holds) =
            if self.is_plane_used { side(simd, &self.plane) } else { (Side::EMPTY, simd.mask8(0xff)) };
        let uses_plane = !(self.nearer | self.thin);
        let holds = a_holds & b_holds & c_holds & (plane_holds | !uses_plane) & !self.vague;
        Bounds { sides: [a, b, c, plane], uses_plane: uses_plane.bits(), uncertain: (!holds).bits() }
    }
}

/// How far the n-th vector of a patch is to the left of an edge, times the edge's length.
#[inline(always)]
fn turn<S: Simd>(simd: S, along: [F8<S>; 2], from: [F8<S>; 2], patch: &Patch, n: usize) -> F8<S> {
    let (x, y) = (simd.splat8(patch.x[n]), simd.splat8(patch.y[n]));
    if patch.z[n] == 0.0 {
        return along[0] * y - along[1] * x;
    }
    let z = simd.splat8(patch.z[n]);
    along[0] * (y - from[1] * z) - along[1] * (x - from[0] * z)
}

/// The receiver's depth less the occluder's, times twice the occluder's area: the mean of the corners' differences,
/// weighted by the edge functions.
#[inline(always)]
fn plane<S: Simd>(
    simd: S,
    triangles: &Triangles<S>,
    outlines: &Outlines<S>,
    patch: &Patch,
    edges: &[Linear<F8<S>>; 3],
    errors: &Errors,
) -> Linear<F8<S>> {
    let middle = simd.splat8(patch.middle);
    let depth = [triangles.depth[0] - middle, triangles.depth[1] - middle, triangles.depth[2] - middle];
    // A patch whose depths nothing bounds has a plane that tells nothing.
    let range = (patch.farthest - patch.middle).max(patch.middle - patch.nearest);
    let range = (range + errors.depth_slack(patch.middle)).min(UNBOUNDED);
    let area = outlines.area;
    Linear {
        first: area * simd.splat8(patch.depth[0])
            - (edges[0].first * depth[0] + edges[1].first * depth[1] + edges[2].first * depth[2]),
        row: area * simd.splat8(patch.depth[1])
            - (edges[0].row * depth[0] + edges[1].row * depth[1] + edges[2].row * depth[2]),
        column: area * simd.splat8(patch.depth[2])
            - (edges[0].column * depth[0] + edges[1].column * depth[1] + edges[2].column * depth[2]),
        tolerance: outlines.plane_off(simd, &depth, (patch.middle, range), errors),
    }
}

/// One function of each of eight occluders as a bound of columns.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    /// Where the function is 0 in row 0, and how that moves with the row.
    base: [f32; WIDTH],
    slope: [f32; WIDTH],
    /// What is added to it for the first column for certain, the first in doubt, the last for certain, the last in
    /// doubt.
    offsets: [[f32; WIDTH]; 4],
}

impl Side {
    const EMPTY: Self = Self { base: [0.0; WIDTH], slope: [0.0; WIDTH], offsets: [[0.0; WIDTH]; 4] };
}

/// The bound, and where its numbers are such.
#[inline(always)]
pub(super) fn side<S: Simd>(simd: S, f: &Linear<F8<S>>) -> (Side, M8<S>) {
    let least = f.tolerance * simd.splat8(LEAST_STEP);
    let column = least.select(f.column.abs().lt(least), f.column);
    let inverse = simd.splat8(-1.0) / column;
    let wide = f.tolerance * inverse.abs() * simd.splat8(1.2);
    let far = simd.splat8(FAR);
    let is_low = column.gt(simd.splat8(0.0));
    let (base, slope) = (f.first * inverse, f.row * inverse);
    let holds = (base.abs() + slope.abs() + wide).lt(simd.splat8(1e-2 * FAR));
    let side = Side {
        base: base.to_array(),
        slope: slope.to_array(),
        offsets: [
            wide.select(is_low, -far).to_array(),
            (-wide).select(is_low, -far).to_array(),
            far.select(is_low, -wide).to_array(),
            far.select(is_low, wide).to_array(),
        ],
    };
    (side, holds)
}

/// Eight occluders as bounds of columns.
#[derive(Clone, Debug)]
pub(super) struct Bounds {
    /// Of the edges and the plane.
    sides: [Side; 4],
    /// Lanes in which the plane matters.
    uses_plane: u32,
    /// Lanes that hide nothing for certain.
    uncertain: u32,
}

impl Bounds {
    /// Of nothing yet.
    pub(super) const EMPTY: Self = Self { sides: [Side::EMPTY; 4], uses_plane: 0, uncertain: 0 };

    /// The columns that one occluder hides in eight rows from `row` on: those for certain, and those and the doubtful.
    #[inline(always)]
    pub(super) fn spans<S: Simd>(&self, simd: S, lane: usize, row: u32) -> [I8<S>; 2] {
        let mut limits = Limits::new(simd, row);
        let count = if self.uses_plane >> lane & 1 == 1 { 4 } else { 3 };
        for side in &self.sides[..count] {
            limits.add(simd, side, lane);
        }
        let [certain, maybe] = limits.columns(simd);
        [if self.uncertain >> lane & 1 == 1 { simd.splat_int8(0) } else { certain }, maybe]
    }
}

/// Columns of eight rows between sides.
pub(super) struct Limits<S: Simd> {
    rows: F8<S>,
    /// See [`Side`].
    limits: [F8<S>; 4],
}

impl<S: Simd> Limits<S> {
    /// All columns of eight rows from `row` on.
    #[inline(always)]
    pub(super) fn new(simd: S, row: u32) -> Self {
        const STEPS: [f32; WIDTH] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
        let (before, beyond) = (simd.splat8(-1.0), simd.splat8(33.0));
        Self { rows: simd.load(&STEPS) + simd.splat8(row as f32), limits: [before, before, beyond, beyond] }
    }

    /// Only those on the inner side of one function.
    #[inline(always)]
    pub(super) fn add(&mut self, simd: S, side: &Side, lane: usize) {
        let zero = simd.splat8(side.base[lane]) + self.rows * simd.splat8(side.slope[lane]);
        let [[a, b], [c, d]] = [
            [simd.splat8(side.offsets[0][lane]), simd.splat8(side.offsets[1][lane])],
            [simd.splat8(side.offsets[2][lane]), simd.splat8(side.offsets[3][lane])],
        ];
        // In this order what is no number bounds nothing.
        self.limits[0] = (zero + a).max(self.limits[0]);
        self.limits[1] = (zero + b).max(self.limits[1]);
        self.limits[2] = (zero + c).min(self.limits[2]);
        self.limits[3] = (zero + d).min(self.limits[3]);
    }

    /// A bit a column, a lane a row: those between all sides for certain, and those that may be.
    #[inline(always)]
    pub(super) fn columns(&self, simd: S) -> [I8<S>; 2] {
        // No closures: they would be compiled for narrow vectors.
        [between(simd, self.limits[0], self.limits[2]), between(simd, self.limits[1], self.limits[3])]
    }
}

/// Whether no bit is set.
#[inline(always)]
pub(super) fn is_none<S: Simd>(simd: S, rows: I8<S>) -> bool {
    rows.eq(simd.splat_int8(0)).bits() == 0xff
}

/// The bits of the columns beyond a limit up to another one.
#[inline(always)]
fn between<S: Simd>(simd: S, start: F8<S>, end: F8<S>) -> I8<S> {
    columns_after(simd, start).without(columns_after(simd, end.max(simd.splat8(-1.0))))
}

/// The bits of the columns beyond a limit.
#[inline(always)]
fn columns_after<S: Simd>(simd: S, limit: F8<S>) -> I8<S> {
    (limit.floor().to_int() + simd.splat_int8(1)).bits_from()
}
