//! What flat faces do before an area light as a cell sees it: their images, and the bands along their borders.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};
use umbriel_geometry::Facets;

use super::{
    cell::CellBounds,
    occluders::HullShaft,
    polygon::{Pieces, Polygon},
    views::Views,
};

#[derive(Clone, Default)]
pub(super) struct Cover {
    faces: Vec<Polygon>,
    /// What is within reach of a border edge: hidden or not, it may change.
    borders: Vec<Polygon>,
    /// What is within reach of any edge of an image: not hidden now, it may be elsewhere.
    fringes: Vec<Polygon>,
    /// Whether a face reaches where the views bound nothing: it may hide anything.
    has_unbounded: bool,
}

/// What the faces of one object do: their images, and which of their edges are borders.
#[derive(Default)]
pub(super) struct Outline {
    faces: Vec<Polygon>,
    /// By the first points at the ends: how often it is used one way more than the other, the ends' points, and whether it is a border in any case.
    edges: BTreeMap<(u32, u32), (i32, [u32; 2], bool)>,
    reach: f64,
    has_unbounded: bool,
}

impl Outline {
    /// Adds a face with the part of it in the shaft.
    pub(super) fn add(&mut self, facets: &Facets, face: usize, part: &[DVec3], views: &Views) {
        let images: Option<Vec<(DVec2, f64)>> = part.iter().map(|&corner| views.project(corner)).collect();
        let Some(images) = images else {
            self.has_unbounded = true;
            return;
        };
        self.reach = images.iter().map(|&(_, shift)| shift).fold(self.reach, f64::max);
        let mut image = Polygon(images.into_iter().map(|(point, _)| point).collect());
        let area = image.area();
        let (numbers, firsts) = (facets.facet(face).corners(), facets.welded(face).corners());
        for k in 0..numbers.len() {
            let next = (k + 1) % numbers.len();
            let forward = firsts[k] < firsts[next];
            let (key, ends) = if forward {
                ((firsts[k], firsts[next]), [numbers[k], numbers[next]])
            } else {
                ((firsts[next], firsts[k]), [numbers[next], numbers[k]])
            };
            let edge = self.edges.entry(key).or_insert((0, ends, false));
            // Seen edge-on, a face has no turn: its edges are borders.
            edge.2 |= area == 0.0;
            edge.0 += if forward == (area > 0.0) { 1 } else { -1 };
        }
        if area < 0.0 {
            image.0.reverse();
        }
        if area != 0.0 {
            self.faces.push(image);
        }
    }

    /// Adds all to the cover.
    pub(super) fn finish(self, facets: &Facets, shaft: &HullShaft, views: &Views, cover: &mut Cover) {
        cover.has_unbounded |= self.has_unbounded;
        let reach = self.reach + views.rim.growth;
        let fringes = self.faces.iter().flat_map(Polygon::edges).map(|edge| Polygon::round_segment(edge, reach));
        cover.fringes.extend(fringes.filter(|fringe| views.centre.may_meet(fringe)));
        for (net, ends, is_border) in self.edges.into_values() {
            if net == 0 && !is_border {
                continue;
            }
            let Some(segment) = shaft.cut_segment(ends.map(|end| facets.positions()[end as usize])) else { continue };
            match (views.project(segment[0]), views.project(segment[1])) {
                (Some((a, at_a)), Some((b, at_b))) => {
                    let reach = self.reach.max(at_a).max(at_b) + views.rim.growth;
                    let band = Polygon::round_segment([a, b], reach);
                    cover.borders.extend(views.centre.may_meet(&band).then_some(band));
                }
                _ => cover.has_unbounded = true,
            }
        }
        cover.faces.extend(self.faces.into_iter().filter(|face| views.centre.may_meet(face)));
    }
}

/// The bounds that faces leave.
pub(super) fn bounds_of(views: &Views, base: &Pieces, cover: &Cover) -> CellBounds {
    let mut seen = base.clone();
    let mut is_touched = false;
    cover.faces.iter().for_each(|face| is_touched |= seen.subtract(face));
    let (estimate, error) = views.centre.share_of(&seen);
    let (of_base, base_error) = views.centre.share_of(base);
    let mut off_borders = base.clone();
    let mut has_bands = false;
    cover.borders.iter().for_each(|band| has_bands |= off_borders.subtract(band));
    if !has_bands && estimate <= error && of_base > 4.0 * (error + base_error) {
        // No border moves over the light, and the middle sees none of it.
        return CellBounds::UMBRA;
    }
    let (outside, _) = views.centre.share_of(&off_borders);
    cover.faces.iter().for_each(|face| _ = off_borders.subtract(face));
    let (not_hidden, open_error) = views.centre.share_of(&off_borders);
    cover.fringes.iter().for_each(|fringe| is_touched |= off_borders.subtract(fringe));
    let (open, fringe_error) = views.centre.share_of(&off_borders);
    let rounding = if base.cuts == 0 && !is_touched && !has_bands {
        0.0
    } else {
        error + 2.0 * (base_error + open_error + fringe_error)
    };
    let (lower, upper) =
        if rounding == 0.0 { (1.0, 1.0) } else { (open - rounding, not_hidden + (of_base - outside) + rounding) };
    let lower = if cover.has_unbounded { 0.0 } else { lower.clamp(0.0, 1.0) };
    views.rim.widened(CellBounds { lower, upper: upper.clamp(0.0, 1.0), estimate })
}
