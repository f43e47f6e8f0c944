//! Objects: a shape, where it stands, and which of its sides count.

use std::{
    ops::Deref,
    sync::{Arc, OnceLock},
};

use glam::{DAffine3, DMat3, DVec3};
use umbriel_geometry::{
    AXES, Aabb, Analytic, AnalyticDefect, Convex, Cuboid, Facets, HullDefect, Mesh, NumberDefect, PlacedAnalytic,
    Placement, Rectangle, accept,
};

/// The local shape of an object.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum Shape {
    /// A triangle mesh; instances share it.
    Mesh(Arc<Mesh>),
    /// A flat rectangle.
    Rectangle(Rectangle),
    /// A box.
    Cuboid(Cuboid),
    /// The hull of points.
    Convex(Arc<Convex>),
    /// A body given by formulas: a sphere, a cylinder, … Behind a pointer, as a quadric has twenty-two numbers and a scene many objects that are none.
    Analytic(Arc<Analytic>),
}

impl Shape {
    /// The formulas, of a body that is given by them.
    pub fn analytic(&self) -> Option<&Analytic> {
        if let Self::Analytic(body) = self { Some(body) } else { None }
    }
}

impl From<Analytic> for Shape {
    fn from(body: Analytic) -> Self {
        Self::Analytic(Arc::new(body))
    }
}

/// Which sides of an object's faces can be lit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Sides {
    /// One side for closed components and closed bodies, both for everything else.
    #[default]
    Auto,
    /// One side: where the winding (right-hand rule) says.
    One,
    /// The side that is turned to the light.
    Two,
}

/// A body of the scene. `shape` and `placement` ([`Placed`]) are read as if they were fields; they were checked together, so
/// another shape is another object, and so is another placement ([`Object::moved`]).
#[derive(Clone, Debug)]
pub struct Object {
    /// Unique within the scene.
    pub name: String,
    placed: Placed,
    /// Which sides can be lit.
    pub sides: Sides,
    /// Boxes that hold all of it, local coordinates, if some are given: what collision detection or rough shadows may take it for.
    pub boxes: Vec<PartBox>,
}

/// A shape and where it stands, checked together.
#[derive(Clone, Debug)]
pub struct Placed {
    /// What it is, in local coordinates.
    pub shape: Shape,
    /// Where it stands: local to world.
    pub placement: Placement,
    /// The world box. That of a curved body is found when it is first asked for: a quadric's takes a millisecond.
    bounds: OnceLock<Aabb>,
    /// How many faces the hull of a convex body has, found when first asked for: each point of a query asks.
    hull_faces: OnceLock<usize>,
}

impl Deref for Object {
    type Target = Placed;

    fn deref(&self) -> &Placed {
        &self.placed
    }
}

/// A box round a part of an object, as it likes to stand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartBox {
    /// Local coordinates.
    pub center: DVec3,
    /// Half its edges; usually at right angles, independent in any case.
    pub half: [DVec3; 3],
}

/// Why an object is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ObjectDefect {
    /// A size of a rectangle or box that is not positive or not accepted.
    #[error("number {number} of its size is not positive and between 2^-200 and 2^200")]
    Size {
        /// Which, from 0.
        number: usize,
    },
    /// Numbers that describe no body.
    #[error(transparent)]
    Analytic(#[from] AnalyticDefect),
    /// Points whose hull has no inside, as they are or once they are placed and rounded.
    #[error(transparent)]
    Hull(#[from] HullDefect),
    /// A vertex or corner that the placement moves out of the accepted range.
    #[error("vertex {vertex}, once placed: coordinate {} {defect}", AXES[*.axis])]
    Placed {
        /// Which vertex or corner.
        vertex: usize,
        /// 0, 1 or 2.
        axis: usize,
        /// What is wrong with it.
        defect: NumberDefect,
    },
    /// A box whose half edges span no volume.
    #[error("box {0} has no volume")]
    FlatBox(usize),
    /// A vertex or corner that no box holds.
    #[error("vertex {vertex} is in none of its boxes")]
    OutsideBoxes {
        /// Which vertex or corner.
        vertex: usize,
    },
}

impl PartBox {
    /// The box between two corners, its edges along the axes.
    pub fn between(low: DVec3, high: DVec3) -> Self {
        let half = 0.5 * (high - low);
        Self { center: low + half, half: [DVec3::X * half.x, DVec3::Y * half.y, DVec3::Z * half.z] }
    }

    /// The corners once placed, rounded; bit k of a corner's number picks the upper end of half edge k.
    pub fn placed(&self, map: &DAffine3) -> [DVec3; 8] {
        std::array::from_fn(|corner| {
            let way = |axis: usize| if corner >> axis & 1 == 0 { -self.half[axis] } else { self.half[axis] };
            map.transform_point3(self.center + way(0) + way(1) + way(2))
        })
    }

    /// The map from local coordinates to those in which the box is −1..1; `None` for a box without volume.
    pub fn to_unit(&self) -> Option<DAffine3> {
        let [a, b, c] = self.half;
        let inverse = DAffine3 { matrix3: DMat3::from_cols(a, b, c), translation: self.center }.inverse();
        inverse.is_finite().then_some(inverse)
    }

    /// Whether it holds a point, up to the rounding of its map.
    fn holds(&self, to_unit: &DAffine3, point: DVec3) -> bool {
        let place = to_unit.transform_point3(point);
        let size = to_unit.matrix3.abs() * (point.abs() + self.center.abs());
        // A dozen roundings of terms of this size.
        (place.abs() - DVec3::ONE).cmple(32.0 * f64::EPSILON * (size + 1.0)).all()
    }
}

/// A body by a formula, if its numbers are those of one; the same one, if there is nothing to trim.
fn checked(body: Arc<Analytic>) -> Result<Arc<Analytic>, AnalyticDefect> {
    body.check()?;
    let trimmed = body.trimmed();
    Ok(if trimmed == *body { body } else { Arc::new(trimmed) })
}

impl Object {
    /// Checks and takes a body: sizes are positive, and what the placement makes of it is accepted. A quadric is [trimmed](Analytic::trimmed).
    ///
    /// # Errors
    /// [`ObjectDefect`].
    pub fn new(name: String, shape: Shape, placement: Placement, sides: Sides) -> Result<Self, ObjectDefect> {
        let sizes: Vec<f64> = match &shape {
            Shape::Mesh(_) | Shape::Convex(_) => Vec::new(),
            Shape::Rectangle(rectangle) => rectangle.size.to_vec(),
            Shape::Cuboid(cuboid) => cuboid.size.to_vec(),
            Shape::Analytic(_) => Vec::new(),
        };
        if let Some(number) = sizes.iter().position(|&size| accept(size).is_err() || size <= 0.0) {
            return Err(ObjectDefect::Size { number });
        }
        let shape = match shape {
            Shape::Analytic(body) => Shape::Analytic(checked(body)?),
            shape => shape,
        };
        if let Shape::Convex(body) = &shape {
            body.placed(&placement)?;
        }
        let placed = Placed { shape, placement, bounds: OnceLock::new(), hull_faces: OnceLock::new() };
        let object = Self { name, placed, sides, boxes: Vec::new() };
        for (vertex, local) in object.defining_points().into_iter().enumerate() {
            let place = |(axis, defect)| ObjectDefect::Placed { vertex, axis, defect };
            object.placement.accepts(local).map_err(place)?;
        }
        // Those of a quadric take a millisecond.
        if !matches!(object.shape.analytic(), Some(Analytic::Quadric { .. })) {
            object.bounds();
        }
        Ok(object)
    }

    /// The same body elsewhere.
    ///
    /// # Errors
    /// [`ObjectDefect`], where the placement is too much for it.
    pub fn moved(&self, placement: Placement) -> Result<Self, ObjectDefect> {
        let moved = Self::new(self.name.clone(), self.shape.clone(), placement, self.sides)?;
        Ok(Self { boxes: self.boxes.clone(), ..moved })
    }

    /// With boxes that hold all of its vertices.
    ///
    /// # Errors
    /// [`ObjectDefect::FlatBox`] and [`ObjectDefect::OutsideBoxes`].
    pub fn with_boxes(mut self, boxes: Vec<PartBox>) -> Result<Self, ObjectDefect> {
        let maps = boxes.iter().enumerate().map(|(number, part)| part.to_unit().ok_or(ObjectDefect::FlatBox(number)));
        let maps = maps.collect::<Result<Vec<_>, _>>()?;
        let is_held = |point: DVec3| boxes.iter().zip(&maps).any(|(part, map)| part.holds(map, point));
        if !boxes.is_empty()
            && let Some(vertex) = self.defining_points().into_iter().position(|point| !is_held(point))
        {
            return Err(ObjectDefect::OutsideBoxes { vertex });
        }
        self.boxes = boxes;
        Ok(self)
    }

    /// The local points whose images bound the body.
    pub(crate) fn defining_points(&self) -> Vec<DVec3> {
        match &self.shape {
            Shape::Mesh(mesh) => mesh.positions().to_vec(),
            Shape::Convex(body) => body.points().to_vec(),
            Shape::Rectangle(rectangle) => rectangle.corners().to_vec(),
            Shape::Cuboid(cuboid) => cuboid.corners().to_vec(),
            Shape::Analytic(body) => Cuboid { size: body.half_extent().map(|half| 2.0 * half) }.corners().to_vec(),
        }
    }

    /// The placed planar faces; `None` for a curved body. Costs a sort of the vertices: keep the result.
    pub fn facets(&self) -> Option<Facets> {
        match &self.shape {
            Shape::Mesh(mesh) => Some(Facets::of_mesh(Arc::clone(mesh), &self.placement)),
            Shape::Convex(body) => Facets::of_convex(body, &self.placement).ok(),
            Shape::Rectangle(rectangle) => Some(Facets::of_rectangle(rectangle, &self.placement)),
            Shape::Cuboid(cuboid) => Some(Facets::of_cuboid(cuboid, &self.placement)),
            Shape::Analytic(_) => None,
        }
    }

    /// The placed body, if it is given by formulas.
    pub fn analytic(&self) -> Option<PlacedAnalytic> {
        self.shape.analytic().and_then(|body| PlacedAnalytic::new(*body, self.placement).ok())
    }

    /// The world box, rounded outward; empty for a mesh without triangles. Found once.
    pub fn bounds(&self) -> Aabb {
        *self.placed.bounds.get_or_init(|| self.find_bounds())
    }

    /// Whether the world box was found before.
    pub(crate) fn knows_bounds(&self) -> bool {
        self.placed.bounds.get().is_some()
    }

    fn find_bounds(&self) -> Aabb {
        match &self.shape {
            Shape::Mesh(mesh) if self.placement == Placement::IDENTITY => mesh.bounds(),
            Shape::Mesh(mesh) => {
                let mut is_used = vec![false; mesh.positions().len()];
                mesh.triangles().iter().flatten().for_each(|&corner| is_used[corner as usize] = true);
                let used = mesh.positions().iter().zip(is_used).filter(|&(_, is_used)| is_used);
                self.placement.bounds_of(used.map(|(&position, _)| position))
            }
            Shape::Analytic(body) => body.bounds(&self.placement),
            Shape::Convex(body) => self.placement.bounds_of(body.points().iter().copied()),
            Shape::Rectangle(rectangle) => self.corner_bounds(&rectangle.corners()),
            Shape::Cuboid(cuboid) => self.corner_bounds(&cuboid.corners()),
        }
    }

    /// Of corners that are those of a box along the local axes, flat or not.
    fn corner_bounds(&self, corners: &[DVec3]) -> Aabb {
        self.placement.bounds(&Aabb::of(corners.iter().copied()))
    }

    /// Whether a face has one side only; asks whether its component is closed only where that matters.
    pub fn is_one_sided(&self, component_is_closed: impl FnOnce() -> bool) -> bool {
        match self.sides {
            Sides::Auto => component_is_closed(),
            Sides::One => true,
            Sides::Two => false,
        }
    }

    /// Number of faces that a query can name: triangles (of a convex body: those of its hull), 1 for a rectangle, 6 for a
    /// box, the patches of an analytic body.
    pub fn face_count(&self) -> usize {
        match &self.shape {
            Shape::Mesh(mesh) => mesh.triangles().len(),
            Shape::Convex(_) => *self.placed.hull_faces.get_or_init(|| self.facets().map_or(0, |facets| facets.len())),
            Shape::Rectangle(_) => 1,
            Shape::Cuboid(_) => 6,
            Shape::Analytic(body) => body.face_count(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quadric_is_kept_in_a_box_of_its_own_size() {
        let matrix = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, -1.0]];
        let kept = |within: [[f64; 3]; 2]| {
            let shape = Arc::new(Analytic::Quadric { matrix, within });
            let object =
                Object::new("ball".into(), Shape::Analytic(Arc::clone(&shape)), Placement::IDENTITY, Sides::Auto);
            let Shape::Analytic(kept) = object.expect("an object").shape.clone() else { panic!("another shape") };
            (kept.bounds(&Placement::IDENTITY), Arc::ptr_eq(&kept, &shape), kept.half_extent())
        };
        let (bounds, is_same, extent) = kept([[-1e60, -2.0, -2.0], [2.0, 2.0, 1e9]]);
        assert!(!is_same && extent.iter().all(|&half| half <= 8.0), "{extent:?}");
        assert!(bounds.size().max_element() < 2.0 + 1e-9 && bounds.size().min_element() >= 2.0);
        assert!(kept([[-1.0; 3], [1.0; 3]]).1, "nothing to trim");
    }

    #[test]
    fn a_hull_has_the_faces_of_its_points() {
        let corner = |k: u32| DVec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2));
        let points = (0..8).map(corner).chain([DVec3::splat(0.5)]).collect::<Vec<_>>();
        let shape = Shape::Convex(Arc::new(
            Convex::new(points.iter().map(|point| point.to_array()).collect()).expect("a body"),
        ));
        let object = Object::new("box".into(), shape, Placement::IDENTITY, Sides::Auto).expect("an object");
        assert_eq!([object.face_count(), object.face_count()], [12; 2]);
    }
}
