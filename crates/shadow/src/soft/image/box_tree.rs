//! The boxes of a body, and their parts: made once, placed in every frame.
//!
//! A body's boxes are those that its object was given ([`PartBox`]), else the one round its vertices along its own axes. Below each stands its hierarchy of
//! cubes: the cube round the box is halved along all three of the box's directions, down to [`DEEPEST`] times, and each part is cut to
//! the triangles whose middles it holds (of several boxes, the one in which a middle lies deepest holds it). A frame places eight corners a box that it uses, and touches no vertex. O(triangles × levels) once;
//! O(boxes used) a frame.

use std::{collections::BTreeMap, ops::Range};

use glam::{DAffine3, DMat3, DVec3};
use umbriel_geometry::Analytic;
use umbriel_scene::{Object, PartBox, Shape};
use umbriel_visibility::depth_map::LightSpace;

use super::boxes::{OrientedBox, Outline};

/// How often a box's cube is halved at most.
const DEEPEST: u32 = 5;

/// Boxes and their parts, in an object's local coordinates.
#[derive(Clone, Debug, Default)]
pub struct BoxTree {
    nodes: Vec<Node>,
    roots: usize,
}

#[derive(Clone, Debug)]
struct Node {
    part: PartBox,
    children: Range<usize>,
}

/// Which boxes a frame uses.
#[derive(Clone, Debug, Default)]
pub struct Cut {
    /// Their outlines as the light sees them, none removed yet.
    pub outlines: Vec<Outline>,
    /// Boxes that have no outline: they reach the light's plane and have no parts, or are flattened to a line.
    pub left_out: usize,
}

impl BoxTree {
    /// The boxes of an object; empty for one without vertices.
    pub fn of(object: &Object) -> Self {
        let mut tree = Self::default();
        let given = if object.boxes.is_empty() { own_box(object).into_iter().collect() } else { object.boxes.clone() };
        tree.roots = given.len();
        tree.nodes.extend(given.into_iter().map(|part| Node { part, children: 0..0 }));
        let maps: Vec<Option<DAffine3>> = tree.nodes.iter().map(|node| node.part.to_unit()).collect();
        let mut held = vec![Vec::new(); tree.roots];
        for triangle in triangles_of(object) {
            // How far the middle is from a box's, in its own measure: in the nearest it lies.
            let off = |root: usize| {
                maps[root].map_or(f64::INFINITY, |map| map.transform_point3(middle(&triangle)).abs().max_element())
            };
            let nearest = (0..tree.roots).min_by(|&a, &b| off(a).total_cmp(&off(b)));
            nearest.into_iter().for_each(|root| held[root].push(triangle));
        }
        held.into_iter().enumerate().for_each(|(root, triangles)| tree.divide(root, triangles));
        tree
    }

    /// Halves a root's cube, level by level.
    fn divide(&mut self, root: usize, triangles: Vec<[DVec3; 3]>) {
        let frame = Frame::of(&self.nodes[root].part);
        let half = self.nodes[root].part.half.map(DVec3::length).into_iter().fold(0.0, f64::max);
        let turned = triangles.into_iter().map(|triangle| triangle.map(|corner| frame.to_frame(corner))).collect();
        let mut level = vec![(root, DVec3::ZERO, turned)];
        for depth in 0..DEEPEST {
            let half = half / f64::from(1u32 << depth);
            let mut next = Vec::new();
            for (node, center, triangles) in level {
                next.extend(self.divide_node(node, center, half, triangles, &frame));
            }
            level = next;
        }
    }

    /// Gives a node its children; these with the middles of their cubes and what they hold.
    fn divide_node(
        &mut self,
        node: usize,
        center: DVec3,
        half: f64,
        triangles: Vec<[DVec3; 3]>,
        frame: &Frame,
    ) -> Vec<(usize, DVec3, Vec<[DVec3; 3]>)> {
        if triangles.len() < 2 {
            return Vec::new();
        }
        let mut parts: BTreeMap<[bool; 3], Vec<[DVec3; 3]>> = BTreeMap::new();
        for triangle in triangles {
            parts.entry(middle(&triangle).cmpge(center).into()).or_default().push(triangle);
        }
        let first = self.nodes.len();
        let children = parts.into_iter().enumerate().map(|(child, (side, triangles))| {
            let way = side.map(|is_upper| if is_upper { 0.5 * half } else { -0.5 * half });
            (first + child, center + DVec3::from_array(way), triangles)
        });
        let children: Vec<_> = children.collect();
        for (_, _, triangles) in &children {
            let corners = triangles.iter().flatten();
            let (low, high) = corners.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &corner| {
                (low.min(corner), high.max(corner))
            });
            self.nodes.push(Node { part: frame.to_local(PartBox::between(low, high)), children: 0..0 });
        }
        self.nodes[node].children = first..self.nodes.len();
        children
    }

    /// The boxes themselves, placed.
    pub fn roots(&self, map: &DAffine3) -> Vec<OrientedBox> {
        self.nodes[..self.roots].iter().map(|node| OrientedBox { corners: node.part.placed(map) }).collect()
    }

    /// The boxes that a frame uses: the body's, each replaced by its parts, and these by theirs, where it reaches the light's plane or `is_fine` does not
    /// take its depths (nearest and farthest).
    pub fn cut(&self, map: &DAffine3, space: &LightSpace, is_fine: impl Fn([f64; 2]) -> bool) -> Cut {
        let mut cut = Cut::default();
        let mut open: Vec<usize> = (0..self.roots).rev().collect();
        while let Some(number) = open.pop() {
            let node = &self.nodes[number];
            let outline = Outline::of(space, &OrientedBox { corners: node.part.placed(map) });
            match outline {
                Some(outline) if node.children.is_empty() || is_fine(outline.depths()) => cut.outlines.push(outline),
                None if node.children.is_empty() => cut.left_out += 1,
                _ => open.extend(node.children.clone().rev()),
            }
        }
        cut
    }
}

/// A box's own directions, at right angles, from its middle.
struct Frame {
    turn: DMat3,
    center: DVec3,
}

impl Frame {
    /// Along the first half edge and in the plane of the first two; those of the axes for a box without volume.
    fn of(part: &PartBox) -> Self {
        let [a, b, _] = part.half;
        let z = a.cross(b).try_normalize();
        let turn = z.zip(a.try_normalize()).map(|(z, x)| DMat3::from_cols(x, z.cross(x), z));
        Self { turn: turn.unwrap_or(DMat3::IDENTITY), center: part.center }
    }

    fn to_frame(&self, local: DVec3) -> DVec3 {
        self.turn.transpose() * (local - self.center)
    }

    fn to_local(&self, part: PartBox) -> PartBox {
        PartBox { center: self.center + self.turn * part.center, half: part.half.map(|half| self.turn * half) }
    }
}

fn middle(triangle: &[DVec3; 3]) -> DVec3 {
    triangle.iter().sum::<DVec3>() / 3.0
}

fn triangles_of(object: &Object) -> Vec<[DVec3; 3]> {
    let Shape::Mesh(mesh) = &object.shape else { return Vec::new() };
    mesh.triangles().iter().map(|triangle| triangle.map(|corner| mesh.positions()[corner as usize])).collect()
}

/// The box round an object along its own axes.
fn own_box(object: &Object) -> Option<PartBox> {
    let round = |points: &mut dyn Iterator<Item = DVec3>| {
        let (low, high) =
            points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
        (low.x <= high.x).then(|| PartBox::between(low, high))
    };
    match &object.shape {
        Shape::Mesh(mesh) => {
            round(&mut mesh.triangles().iter().flatten().map(|&corner| mesh.positions()[corner as usize]))
        }
        Shape::Convex(body) => round(&mut body.points().iter().copied()),
        Shape::Cuboid(cuboid) => round(&mut cuboid.corners().into_iter()),
        Shape::Rectangle(rectangle) => round(&mut rectangle.corners().into_iter()),
        Shape::Analytic(body) => round(&mut half_extents(body).into_iter()),
        _ => None,
    }
}

fn half_extents(body: &Analytic) -> [DVec3; 2] {
    let half = DVec3::from_array(body.half_extent());
    [-half, half]
}

/// Whether some surface of an object may be behind another of its own: not if it is convex or no more than its own box.
pub fn may_hide_itself(object: &Object) -> bool {
    match &object.shape {
        Shape::Mesh(_) => {
            let triangles = triangles_of(object);
            let corners = || triangles.iter().flatten().copied();
            let (low, high) =
                (corners().fold(DVec3::INFINITY, DVec3::min), corners().fold(DVec3::NEG_INFINITY, DVec3::max));
            let is_in_face = |triangle: &[DVec3; 3]| {
                (0..3).any(|axis| {
                    let place = triangle[0][axis];
                    (place == low[axis] || place == high[axis]) && triangle.iter().all(|corner| corner[axis] == place)
                })
            };
            !triangles.iter().all(is_in_face)
        }
        Shape::Analytic(body) => !body.is_convex(),
        _ => false,
    }
}

/// Which objects block: those that may have some surface of another object behind them as the light sees it. Boxes first, then vertices:
/// O(objects²) and for pairs whose boxes leave it open O(vertices).
pub fn hide_others(space: &LightSpace, objects: &[Object], trees: &[BoxTree]) -> Vec<bool> {
    let placed: Vec<Vec<OrientedBox>> =
        objects.iter().zip(trees).map(|(object, tree)| tree.roots(object.placement.map())).collect();
    let hides = |object: usize| {
        (0..objects.len()).any(|other| {
            let corners: Vec<DVec3> = placed[other].iter().flat_map(|oriented| oriented.corners).collect();
            other != object
                && placed[object].iter().any(|oriented| {
                    oriented.may_hide(space, &corners)
                        && oriented.may_hide(space, &vertices_of(&objects[other], &corners))
                })
        })
    };
    (0..objects.len()).map(hides).collect()
}

/// The placed vertices of a body; where it has none, the corners of its boxes.
fn vertices_of(object: &Object, corners: &[DVec3]) -> Vec<DVec3> {
    let map = object.placement.map();
    match &object.shape {
        Shape::Mesh(mesh) => mesh.positions().iter().map(|&point| map.transform_point3(point)).collect(),
        Shape::Convex(body) => body.points().iter().map(|&point| map.transform_point3(point)).collect(),
        _ => corners.to_vec(),
    }
}
