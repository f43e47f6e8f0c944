//! Bodies of the oracle: what a scene's objects are in the world, exactly, and which of their sides can be lit.

use std::collections::BTreeMap;

use umbriel_geometry::{Analytic, Cuboid, Mesh, Placement, Rectangle};
use umbriel_scene::{Object, Shape, Sides};

use super::{
    blocking::{Ellipsoid, Lamp, Place, Triangle, combination},
    curved::Curved,
    hull::hull,
    number::{Binary, Vector, cross, dot, minus, plus, times, vector},
    solids::Solid,
};

/// A placed flat face: a triangle or a parallelogram.
#[derive(Clone, Debug)]
pub(crate) struct Flat {
    /// Three or four corners.
    pub(crate) corners: Vec<Vector>,
    /// Towards the front; zero for a face without area.
    pub(crate) normal: Vector,
    /// Whether only the front can be lit.
    pub(crate) one_sided: bool,
}

impl Flat {
    fn new(corners: Vec<Vector>, mirrored: bool, one_sided: bool) -> Self {
        let (a, b, d) = (&corners[0], &corners[1], &corners[corners.len() - 1]);
        let wound = cross(&minus(b, a), &minus(d, a));
        let normal = if mirrored { wound.each_ref().map(|coordinate| -coordinate) } else { wound };
        Self { corners, normal, one_sided }
    }

    /// The point (u, v).
    pub(crate) fn point(&self, u: f64, v: f64) -> Place {
        let last = self.corners.len() - 1;
        Place::new(combination(&self.corners[0], &self.corners[1], &self.corners[last], u, v))
    }

    /// The point (u, v) counted from another corner.
    pub(crate) fn point_from(&self, corner: usize, u: f64, v: f64) -> Place {
        let at = |step: usize| &self.corners[(corner + step) % self.corners.len()];
        Place::new(combination(at(0), at(1), at(self.corners.len() - 1), u, v))
    }

    /// Whether the light is strictly on the lit side.
    pub(crate) fn faces(&self, light: &Lamp) -> bool {
        let side = light.side(&self.normal, &self.corners[0]);
        side > 0 || (side < 0 && !self.one_sided)
    }

    /// The closed triangles that the face is made of.
    pub(crate) fn triangles(&self) -> impl Iterator<Item = Triangle> + '_ {
        let fan = self.corners.windows(2).skip(1);
        fan.map(|pair| Triangle::new([self.corners[0].clone(), pair[0].clone(), pair[1].clone()]))
    }
}

/// A placed sphere.
#[derive(Clone, Debug)]
pub(crate) struct Round {
    /// Its surface.
    pub(crate) surface: Ellipsoid,
    /// Whether only the outside can be lit.
    pub(crate) one_sided: bool,
    rows: [Vector; 3],
    centre: Vector,
    radius: Binary,
}

impl Round {
    /// The point (u, v) of a patch: centre + radius·M·d/|d| with d on the cube −1..1, as the scene's sphere says.
    pub(crate) fn point(&self, patch: usize, u: f64, v: f64) -> Place {
        let one = Binary::new(1.0);
        let centred = |t: f64| &(&Binary::new(2.0) * &Binary::new(t)) - &one;
        let axis = patch / 2;
        let mut direction = vector([0.0; 3]);
        let [next, after] = [(axis + 1) % 3, (axis + 2) % 3];
        if patch % 2 == 1 {
            direction[axis] = one.clone();
            (direction[next], direction[after]) = (centred(u), centred(v));
        } else {
            direction[axis] = -&one;
            (direction[next], direction[after]) = (centred(v), centred(u));
        }
        let squared = dot(&direction, &direction);
        let image: Vector = std::array::from_fn(|i| dot(&self.rows[i], &direction));
        Place {
            rational: times(&squared, &self.centre),
            irrational: times(&self.radius, &image),
            radicand: squared.clone(),
            weight: squared,
        }
    }

    /// The outward normal at a surface point, rounded: the inverse transpose of the matrix on the local direction.
    pub(crate) fn outward(&self, x: &Place) -> [f64; 3] {
        let coordinate = |row: &Vector| row.each_ref().map(|entry| entry.to_nearest());
        let columns = glam::DMat3::from_cols_array_2d(&self.rows.each_ref().map(coordinate));
        let centre = self.centre.each_ref().map(|entry| entry.to_nearest());
        let offset = glam::DVec3::from_array(x.approximate()) - glam::DVec3::from_array(centre);
        // `columns` holds the rows as columns: the transpose.
        let local = columns.transpose().inverse() * offset;
        (columns.inverse() * local).to_array()
    }

    /// Whether the light is strictly on the lit side of the surface point x.
    pub(crate) fn faces(&self, x: &Place, light: &Lamp) -> bool {
        let side = self.surface.light_side(x, light);
        side > 0 || (side < 0 && !self.one_sided)
    }
}

/// A placed curved body.
#[derive(Clone, Debug)]
pub(crate) struct Bent {
    /// What it is.
    pub(crate) solid: Solid,
    /// Its surface.
    pub(crate) surface: Curved,
    /// The image of a ball that holds it.
    pub(crate) hull: Ellipsoid,
}

impl Bent {
    fn new(solid: Solid, frame: &Frame, one_sided: bool) -> Self {
        let (middle, radius) = solid.ball();
        let hull = Ellipsoid::new(&frame.rows, frame.image(middle), &Binary::new(radius));
        let surface = Curved::new(solid.pieces(), one_sided, frame.rows.clone(), frame.origin.clone());
        Self { solid, surface, hull }
    }

    /// Whether all segments from the convex hull of the points to the light meet the surface. With a convex body, and all
    /// ends outside of it, the points behind it are a convex set.
    pub(crate) fn surely_blocks(&self, points: &[Place], light: &Lamp) -> bool {
        let is_outside = |x: &Place| self.hull.side(x) > 0;
        let light_is_outside = light.weight.sign() == 0 || is_outside(&Place::new(light.xyz.clone()));
        self.solid.is_convex()
            && light_is_outside
            && self.surface.near(points).is_empty()
            && points.iter().all(|x| is_outside(x) && self.surface.blocks(x, light))
    }

    /// The piece of a face, and the point (u, v); `None` where that is no point of the surface.
    pub(crate) fn point(&self, face: usize, parameters: [f64; 2]) -> Option<(usize, Place)> {
        let (piece, local) = self.solid.point(face, parameters)?;
        Some((piece, self.surface.image(&local)))
    }
}

/// A placed object.
#[derive(Clone, Debug)]
pub(crate) enum Body {
    /// Faces in the order of the object.
    Flats(Vec<Flat>),
    /// A sphere.
    Round(Box<Round>),
    /// Another curved body.
    Bent(Box<Bent>),
}

impl Body {
    /// What an object is in the world.
    pub(crate) fn new(object: &Object) -> Self {
        let frame = Frame::new(&object.placement);
        let one_sided = |closed: bool| match object.sides {
            Sides::Auto => closed,
            Sides::One => true,
            Sides::Two => false,
        };
        match &object.shape {
            Shape::Mesh(mesh) => Self::Flats(frame.mesh(mesh, &one_sided)),
            Shape::Rectangle(rectangle) => Self::Flats(vec![frame.rectangle(rectangle, one_sided(false))]),
            Shape::Cuboid(cuboid) => Self::Flats(frame.cuboid(cuboid, one_sided(true))),
            Shape::Analytic(body) => frame.curved(body, one_sided),
            Shape::Convex(convex) => Self::Flats(frame.convex(convex.points(), one_sided(true))),
            other => panic!("the oracle does not know {other:?}"),
        }
    }
}

/// A placement as exact rows and an exact origin.
struct Frame {
    rows: [Vector; 3],
    origin: Vector,
    mirrored: bool,
}

impl Frame {
    fn new(placement: &Placement) -> Self {
        let map = placement.map();
        let columns = [map.matrix3.x_axis, map.matrix3.y_axis, map.matrix3.z_axis].map(|column| column.to_array());
        let rows: [Vector; 3] = std::array::from_fn(|i| vector([columns[0][i], columns[1][i], columns[2][i]]));
        let mirrored = dot(&rows[0], &cross(&rows[1], &rows[2])).sign() < 0;
        Self { rows, origin: vector(map.translation.to_array()), mirrored }
    }

    fn curved(self, body: &Analytic, one_sided: impl Fn(bool) -> bool) -> Body {
        if let Analytic::Sphere { radius } = body {
            let radius = Binary::new(*radius);
            let surface = Ellipsoid::new(&self.rows, self.origin.clone(), &radius);
            let one_sided = one_sided(true);
            return Body::Round(Box::new(Round { surface, one_sided, rows: self.rows, centre: self.origin, radius }));
        }
        let solid = Solid::new(body);
        Body::Bent(Box::new(Bent::new(solid, &self, one_sided(solid.is_closed()))))
    }

    fn image(&self, local: [f64; 3]) -> Vector {
        let local = vector(local);
        plus(&self.origin, &std::array::from_fn(|i| dot(&self.rows[i], &local)))
    }

    fn rectangle(&self, rectangle: &Rectangle, one_sided: bool) -> Flat {
        let [x, z] = rectangle.size.map(|size| size / 2.0);
        let corners = [[-x, 0.0, z], [x, 0.0, z], [x, 0.0, -z], [-x, 0.0, -z]];
        Flat::new(corners.map(|corner| self.image(corner)).to_vec(), self.mirrored, one_sided)
    }

    fn cuboid(&self, cuboid: &Cuboid, one_sided: bool) -> Vec<Flat> {
        let corner = |number: u32| {
            let end = |axis: usize| if number >> axis & 1 == 1 { cuboid.size[axis] } else { -cuboid.size[axis] };
            self.image([end(0) / 2.0, end(1) / 2.0, end(2) / 2.0])
        };
        Cuboid::FACES.iter().map(|face| Flat::new(face.map(corner).to_vec(), self.mirrored, one_sided)).collect()
    }

    /// The hull of the placed and rounded points.
    fn convex(&self, points: &[glam::DVec3], one_sided: bool) -> Vec<Flat> {
        let place = |position: &glam::DVec3| self.image(position.to_array()).map(|c| c.to_nearest() + 0.0);
        let placed: Vec<[f64; 3]> = points.iter().map(place).collect();
        let flat = |corners: [[f64; 3]; 3]| Flat::new(corners.map(vector).to_vec(), self.mirrored, one_sided);
        hull(&placed, self.mirrored).into_iter().map(flat).collect()
    }

    fn mesh(&self, mesh: &Mesh, one_sided: &dyn Fn(bool) -> bool) -> Vec<Flat> {
        let place = |position: &glam::DVec3| self.image(position.to_array()).map(|c| c.to_nearest() + 0.0);
        let placed: Vec<[f64; 3]> = mesh.positions().iter().map(place).collect();
        let triangles: Vec<[[f64; 3]; 3]> =
            mesh.triangles().iter().map(|corners| corners.map(|corner| placed[corner as usize])).collect();
        let closed = closed_faces(&triangles);
        let flat = |(corners, closed): (&[[f64; 3]; 3], bool)| {
            Flat::new(corners.map(vector).to_vec(), self.mirrored, one_sided(closed))
        };
        triangles.iter().zip(closed).map(flat).collect()
    }
}

/// A solid under a placement; `one_sided` says whether only its outside can be lit.
pub(crate) fn placed(solid: &Solid, placement: &Placement, one_sided: bool) -> Curved {
    Bent::new(*solid, &Frame::new(placement), one_sided).surface
}

/// Whether each triangle belongs to a component (triangles joined by edges of equal positions) in which every edge is
/// used as often one way as the other.
pub(crate) fn closed_faces(triangles: &[[[f64; 3]; 3]]) -> Vec<bool> {
    let key = |position: [f64; 3]| position.map(f64::to_bits);
    let mut edges: BTreeMap<_, (i64, Vec<usize>)> = BTreeMap::new();
    for (number, corners) in triangles.iter().enumerate() {
        for i in 0..3 {
            let (from, to) = (key(corners[i]), key(corners[(i + 1) % 3]));
            if from != to {
                let edge = edges.entry((from.min(to), from.max(to))).or_default();
                edge.0 += if from < to { 1 } else { -1 };
                edge.1.push(number);
            }
        }
    }
    // The least number spreads through every component until nothing changes.
    let mut component: Vec<usize> = (0..triangles.len()).collect();
    loop {
        let before = component.clone();
        for (_, users) in edges.values() {
            let least = users.iter().map(|&user| component[user]).min().unwrap_or(0);
            users.iter().for_each(|&user| component[user] = least);
        }
        if component == before {
            break;
        }
    }
    let is_open = |number: usize| {
        edges.values().any(|(balance, users)| *balance != 0 && users.iter().any(|&user| component[user] == number))
    };
    component.iter().map(|&number| !is_open(number)).collect()
}
