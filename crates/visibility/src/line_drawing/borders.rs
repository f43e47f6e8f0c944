//! The outlines of cast shadows: the borders of shadow polygons ([`crate::two_pass`]) that are not borders of the face itself.

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use umbriel_geometry::{Facets, LightSource, Point, Sign};
use umbriel_scene::Scene;

use super::{Ink, Line, Stroke, gaps, hidden::Hiders, projection::Projector};
use crate::two_pass::{FaceShadow, ShadowPolygons, TwoPassDefect, crosses};

/// As far from its face's border as this share of the face's size, an edge lies on it: beyond the grid of shadow polygons, and far below a pixel.
const ON_BORDER: f64 = 1.0 / (1 << 20) as f64;

/// The outlines under one light, on some bodies (ascending).
///
/// # Errors
/// [`TwoPassDefect`] for a scene with texture-cut meshes.
pub(super) fn draw(
    scene: &Scene,
    (hiders, hatched): (&Hiders, &[usize]),
    projector: &Projector,
    light: &LightSource,
) -> Result<Vec<Stroke>, TwoPassDefect> {
    let shadows = ShadowPolygons::cast(scene, light)?;
    let of = |face: &FaceShadow| {
        let facets = hiders.bodies[face.object].1;
        let [seen, lit] = [projector.eye(), light].map(|from| facets.turn(face.face, from));
        // Shadows lie on the side that is turned to the light.
        if seen != lit || seen == Sign::Zero || face.shadow.is_empty() || hatched.binary_search(&face.object).is_err() {
            return Vec::new();
        }
        edges(face, facets).into_iter().flat_map(|ends| visible(hiders, projector, face, ends)).collect()
    };
    Ok(shadows.faces.par_iter().flat_map_iter(of).collect())
}

/// The edges of a face's shadow polygons inside the face, but for seams of two covers, which have shadow on both sides.
fn edges(face: &FaceShadow, facets: &Facets) -> Vec<[DVec3; 2]> {
    let numbers = facets.facet(face.face).corners();
    let corner = |k: usize| facets.positions()[numbers[k % numbers.len()] as usize];
    let outline: Vec<DVec2> = (0..numbers.len()).map(|k| face.coordinates(corner(k)).into()).collect();
    let size = outline.iter().map(|point| (*point - outline[0]).length()).fold(0.0, f64::max);
    let is_on_border = |a: DVec2, b: DVec2| {
        (0..outline.len()).any(|k| {
            let (from, to) = (outline[k], outline[(k + 1) % outline.len()]);
            let along = (to - from).normalize_or_zero();
            [a, b].iter().all(|point| along.perp_dot(*point - from).abs() <= ON_BORDER * size)
        })
    };
    let contours = face.shadow.iter().flatten();
    let all = contours.flat_map(|contour| contour.iter().zip(contour.iter().cycle().skip(1)));
    let all: Vec<[DVec2; 2]> = all.map(|(&a, &b)| [a.into(), b.into()]).collect();
    let rows = Rows::of(&all);
    let is_seam = |a: DVec2, b: DVec2| {
        let beside = (b - a).perp().normalize_or_zero() * (ON_BORDER * size);
        [beside, -beside].iter().all(|&beside| rows.hold((a + b) * 0.5 + beside))
    };
    let inner = all.iter().filter(|[a, b]| !is_on_border(*a, *b) && !is_seam(*a, *b));
    inner.map(|ends| ends.map(|end| face.point(end.to_array()))).collect()
}

/// Edges of a region by rows of its plane: so many that neither long nor short edges take more than n√n looks or places.
struct Rows<'a> {
    edges: &'a [[DVec2; 2]],
    low: f64,
    height: f64,
    /// Which edges each row meets.
    rows: Vec<Vec<u32>>,
}

impl<'a> Rows<'a> {
    fn of(edges: &'a [[DVec2; 2]]) -> Self {
        let ends = || edges.iter().flatten().map(|end| end.y);
        let (low, high) = (ends().fold(f64::INFINITY, f64::min), ends().fold(f64::NEG_INFINITY, f64::max));
        let count = edges.len().isqrt().max(1);
        let height = ((high - low) / count as f64).max(f64::MIN_POSITIVE);
        let mut rows = Self { edges, low, height, rows: vec![Vec::new(); count] };
        for (number, [a, b]) in (0..).zip(edges) {
            let [first, last] = [a.y.min(b.y), a.y.max(b.y)].map(|y| rows.row(y));
            rows.rows[first..=last].iter_mut().for_each(|row| row.push(number));
        }
        rows
    }

    fn row(&self, y: f64) -> usize {
        (((y - self.low) / self.height).max(0.0) as usize).min(self.rows.len() - 1)
    }

    /// Whether a point lies within the region, by crossings of its row.
    fn hold(&self, point: DVec2) -> bool {
        let is_crossed = |&&number: &&u32| crosses(self.edges[number as usize], point);
        self.rows[self.row(point.y)].iter().filter(is_crossed).count() % 2 == 1
    }
}

fn visible(hiders: &Hiders, projector: &Projector, face: &FaceShadow, ends: [DVec3; 2]) -> Vec<Stroke> {
    let Some(range) = projector.visible_range(ends) else { return Vec::new() };
    let line = Line { ends: ends.map(Point::exact), on: [Some((face.object as u32, face.face as u32)), None] };
    let place = |s: f64| projector.place(ends[0].lerp(ends[1], s));
    let seen = gaps(&hiders.hidden(&line), range);
    seen.into_iter().map(|[from, to]| Stroke { ink: Ink::ShadowOutline, ends: [place(from), place(to)] }).collect()
}
