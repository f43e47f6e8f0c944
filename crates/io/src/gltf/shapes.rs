//! Bodies of KHR_implicit_shapes, and of its older form KHR_collision_shapes: what stands for a node without a mesh that
//! KHR_physics_rigid_bodies gives a collider.
//!
//! Spheres, boxes, cylinders, cones, capsules and rectangles become bodies given by formulas. Planes without an end,
//! capsules with two radii and shapes made from meshes have no such body here: they are told and left out, and so are shapes with
//! a size of zero, which have no surface or are flat.

use glam::{DAffine3, DMat3, DVec3};
use umbriel_geometry::{Analytic, Cuboid, MIN_MAGNITUDE, Rectangle};
use umbriel_scene::{Shape, Sides};

use super::json::{Document, ImplicitShape, Node, TurnedShape, element};

/// A body in the coordinates of its node.
pub(super) struct Body {
    pub(super) shape: Shape,
    pub(super) map: DAffine3,
    pub(super) sides: Option<Sides>,
}

impl Body {
    fn of(shape: Shape) -> Self {
        Self { shape, map: DAffine3::IDENTITY, sides: None }
    }

    /// Whether a size of it is zero, and none is wrong.
    pub(super) fn is_flat(&self) -> bool {
        let sizes = self.sizes();
        sizes.contains(&0.0) && sizes.iter().all(|&size| size >= 0.0)
    }

    /// Whether a size of it is negative.
    pub(super) fn is_wrong(&self) -> bool {
        self.sizes().iter().any(|&size| size < 0.0)
    }

    fn sizes(&self) -> Vec<f64> {
        match &self.shape {
            Shape::Cuboid(Cuboid { size }) => size.to_vec(),
            Shape::Rectangle(Rectangle { size }) => size.to_vec(),
            Shape::Analytic(body) => match **body {
                Analytic::Sphere { radius } => vec![radius],
                Analytic::Capsule { radius, height }
                | Analytic::Cylinder { radius, height }
                | Analytic::Cone { radius, height } => vec![radius, height],
                Analytic::Frustum { bottom_radius, top_radius, height } => vec![bottom_radius, top_radius, height],
                _ => Vec::new(),
            },
            _ => Vec::new(),
        }
    }
}

/// A size as it is taken: numbers too small for a scene are zero.
fn size(written: f64) -> f64 {
    if written.abs() < MIN_MAGNITUDE { 0.0 } else { written }
}

/// The shape of a node's collider, if it has one.
pub(super) fn declared<'a>(document: &'a Document, node: &Node) -> Result<Option<&'a ImplicitShape>, String> {
    let collider = node.extensions().rigid_body.as_ref().and_then(|body| body.collider.as_ref());
    let Some(collider) = collider else { return Ok(None) };
    let named = collider.geometry.as_ref().and_then(|geometry| geometry.shape).or(collider.shape);
    let Some(index) = named else { return Ok(None) };
    let extensions = &document.extensions;
    let shapes = extensions.implicit_shapes.as_ref().or(extensions.collision_shapes.as_ref());
    element(shapes.map_or(&[], |shapes| &shapes.shapes), index, "shape").map(Some)
}

/// The body of a shape; `None` for one that is not read.
pub(super) fn body(shape: &ImplicitShape) -> Option<Body> {
    match shape.kind.as_str() {
        "sphere" => {
            let radius = size(shape.sphere.unwrap_or_default().radius);
            Some(Body::of(Shape::from(Analytic::Sphere { radius })))
        }
        "box" => Some(Body::of(Shape::Cuboid(Cuboid { size: shape.cuboid.unwrap_or_default().size.map(size) }))),
        "cylinder" => Some(cylinder(&shape.cylinder.unwrap_or_default())),
        "capsule" => {
            let capsule = shape.capsule.unwrap_or_default();
            let [bottom, top] = radii(&capsule);
            let height = size(capsule.height);
            let is_ball = height == 0.0;
            let body =
                if is_ball { Analytic::Sphere { radius: top } } else { Analytic::Capsule { radius: top, height } };
            (bottom == top).then(|| Body::of(Shape::from(body)))
        }
        "plane" => {
            let plane = shape.plane.unwrap_or_default();
            let size = [plane.size_x?, plane.size_z?].map(size);
            let sides = Some(if plane.double_sided { Sides::Two } else { Sides::One });
            Some(Body { sides, ..Body::of(Shape::Rectangle(Rectangle { size })) })
        }
        _ => None,
    }
}

fn radii(shape: &TurnedShape) -> [f64; 2] {
    [shape.radius_bottom, shape.radius_top].map(|radius| size(radius.unwrap_or(shape.radius)))
}

/// A cylinder, frustum or cone. A cone that stands on its apex is one turned by half a turn about x, which is exact.
fn cylinder(shape: &TurnedShape) -> Body {
    let height = size(shape.height);
    let [bottom_radius, top_radius] = radii(shape);
    let upright = |body| Body::of(Shape::from(body));
    if bottom_radius == top_radius {
        upright(Analytic::Cylinder { radius: top_radius, height })
    } else if top_radius == 0.0 {
        upright(Analytic::Cone { radius: bottom_radius, height })
    } else if bottom_radius == 0.0 {
        let turn = DMat3::from_diagonal(DVec3::new(1.0, -1.0, -1.0));
        Body { map: DAffine3::from_mat3(turn), ..upright(Analytic::Cone { radius: top_radius, height }) }
    } else {
        upright(Analytic::Frustum { bottom_radius, top_radius, height })
    }
}
