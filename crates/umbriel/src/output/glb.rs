//! A bake as a coloured model under one light, coloured by cell, by face or by vertex.

use std::collections::HashMap;

use clap::ValueEnum;
use glam::DVec3;
use umbriel_io::write::ColoredMesh;
use umbriel_scene::{Object, Scene};
use umbriel_shadow::{Cell, HourCell, LightReport, ObjectHours, ObjectReport, Verdict};

use crate::output::{
    hours::{self, Day},
    surface::Surface,
};

/// What has one colour in a baked .glb.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Coloring {
    /// Every stored cell: lit, shadowed or undecided
    Cell,
    /// Every face: the mixture of lit and shadowed by its share
    Face,
    /// Every corner of cells: the mean of the cells around by area, smooth between
    Vertex,
}

/// Linear light, as glTF wants vertex colours.
const LIT: [u8; 4] = [255, 205, 120, 255];
const SHADOWED: [u8; 4] = [10, 16, 48, 255];
const UNDECIDED: [u8; 4] = [255, 70, 0, 255];

/// Faces that meet at a smaller angle than this (60°, by its cosine) share their vertices' colours; at an edge that is
/// sharper the lit side does not shine round the corner.
const SMOOTH_COSINE: f64 = 0.5;

/// The objects that have stored cells, each a mesh.
pub(crate) fn meshes(scene: &Scene, light: &LightReport, coloring: Coloring) -> Vec<ColoredMesh> {
    let with_cells = light.objects.iter().filter(|object| !object.cells.is_empty());
    let mesh_of = |report: &ObjectReport| {
        let cells: Vec<Shaded> = report.cells.iter().map(Shaded::of).collect();
        mesh(&scene.objects[report.object], &cells, coloring)
    };
    with_cells.map(mesh_of).collect()
}

/// The same by the share of all hours in which a cell is lit.
pub(crate) fn hours_meshes(day: &Day, coloring: Coloring) -> Vec<ColoredMesh> {
    let shaded = |cell: HourCell| {
        let share = day.share(&cell);
        Shaded { cell: hours::place(&cell), share, color: mixture(share) }
    };
    let mesh_of = |report: &ObjectHours| {
        let cells: Vec<Shaded> = report.cells.iter().map(shaded).collect();
        mesh(&day.scene.objects[report.object], &cells, coloring)
    };
    day.report.objects.iter().filter(|object| !object.cells.is_empty()).map(mesh_of).collect()
}

/// A cell, how much of it is lit (or for how much of the time), and its own colour.
struct Shaded {
    cell: Cell,
    share: f64,
    color: [u8; 4],
}

impl Shaded {
    fn of(cell: &Cell) -> Self {
        Self { cell: *cell, share: share_of(cell.verdict), color: color(cell.verdict) }
    }
}

fn mesh(object: &Object, cells: &[Shaded], coloring: Coloring) -> ColoredMesh {
    let surface = Surface::of(object);
    let mut mesh = ColoredMesh { name: object.name.clone(), ..Default::default() };
    match coloring {
        Coloring::Cell => cells.iter().for_each(|one| add_polygons(&mut mesh, &surface, &one.cell, one.color)),
        Coloring::Face => {
            for cells in cells.chunk_by(|one, next| one.cell.face == next.cell.face) {
                let face = Cell { level: 0, i: 0, j: 0, ..cells[0].cell };
                add_polygons(&mut mesh, &surface, &face, mixture(lit_share(&surface, cells)));
            }
        }
        Coloring::Vertex => add_smooth(&mut mesh, &surface, cells),
    }
    mesh
}

fn color(verdict: Verdict) -> [u8; 4] {
    match verdict {
        Verdict::Lit => LIT,
        Verdict::Shadowed => SHADOWED,
        Verdict::Undecided => UNDECIDED,
    }
}

/// Between shadowed (0) and lit (1).
fn mixture(share: f64) -> [u8; 4] {
    std::array::from_fn(|i| {
        let (from, to) = (f64::from(SHADOWED[i]), f64::from(LIT[i]));
        (from + share * (to - from)).round() as u8
    })
}

/// What a verdict says of the lit share; the middle where it says nothing.
fn share_of(verdict: Verdict) -> f64 {
    match verdict {
        Verdict::Lit => 1.0,
        Verdict::Shadowed => 0.0,
        Verdict::Undecided => 0.5,
    }
}

/// The lit share of some cells by area, undecided ones counted half. Cells of no area count alike.
fn lit_share(surface: &Surface, cells: &[Shaded]) -> f64 {
    let (mut lit, mut all) = (0.0, 0.0);
    for one in cells {
        let area = surface.area(&one.cell).value;
        lit += area * one.share;
        all += area;
    }
    if all > 0.0 { lit / all } else { cells[0].share }
}

fn add_polygons(mesh: &mut ColoredMesh, surface: &Surface, cell: &Cell, color: [u8; 4]) {
    for part in surface.parts(cell) {
        let polygon = surface.polygon(&part);
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(polygon.iter().map(|&corner| point(surface, cell.face, corner).to_array()));
        mesh.colors.extend(polygon.iter().map(|_| color));
        mesh.triangles.extend((2..polygon.len() as u32).map(|i| [first, first + i - 1, first + i]));
    }
}

fn point(surface: &Surface, face: u32, corner: [f64; 2]) -> DVec3 {
    surface.point(face, corner).unwrap_or_default()
}

fn add_smooth(mesh: &mut ColoredMesh, surface: &Surface, cells: &[Shaded]) {
    let mut vertices = SharedVertices::default();
    let parts = cells.iter().flat_map(|one| surface.parts(&one.cell).into_iter().map(|part| (part, one.share)));
    for (part, share) in parts {
        let corners: Vec<DVec3> =
            surface.polygon(&part).into_iter().map(|corner| point(surface, part.face, corner)).collect();
        // The cross product of the diagonals, in a triangle of two edges: as long as twice the area.
        let normal = (corners[2] - corners[0]).cross(corners[corners.len() - 1] - corners[1]);
        let places: Vec<u32> = corners.iter().map(|&corner| vertices.place(corner, normal, share)).collect();
        mesh.triangles.extend((2..places.len()).map(|i| [places[0], places[i - 1], places[i]]));
    }
    mesh.positions = vertices.list.iter().map(|vertex| vertex.position.to_array()).collect();
    mesh.colors = vertices.list.iter().map(|vertex| mixture(vertex.share())).collect();
}

/// Vertices by place; several at one place where sharp edges meet.
#[derive(Default)]
struct SharedVertices {
    list: Vec<Vertex>,
    at: HashMap<[u32; 3], Vec<u32>>,
}

struct Vertex {
    position: DVec3,
    /// Of the first cell that came; of unit length, or zero.
    normal: DVec3,
    first_share: f64,
    /// The areas of the cells that meet here, and the lit ones among them; a small cell beside a large one must not
    /// shade all of that.
    area: f64,
    lit_area: f64,
}

impl Vertex {
    fn share(&self) -> f64 {
        if self.area > 0.0 { self.lit_area / self.area } else { self.first_share }
    }
}

impl SharedVertices {
    /// The vertex at a position, for a polygon with this share and normal, as long as the area in any unit.
    fn place(&mut self, position: DVec3, normal: DVec3, share: f64) -> u32 {
        // As 32-bit floats from a point of the object, which is how files keep them: neighbouring faces round the
        // points of a common edge differently. Adding zero makes −0 and 0 the same.
        let origin = self.list.first().map_or(position, |first| first.position);
        let key = (position - origin).to_array().map(|coordinate| (coordinate as f32 + 0.0).to_bits());
        let here = self.at.entry(key).or_default();
        let direction = normal.normalize_or_zero();
        let is_smooth = |&vertex: &u32| self.list[vertex as usize].normal.dot(direction) > SMOOTH_COSINE;
        let smooth = here.iter().copied().find(is_smooth);
        let vertex = smooth.unwrap_or_else(|| {
            self.list.push(Vertex { position, normal: direction, first_share: share, area: 0.0, lit_area: 0.0 });
            here.push(self.list.len() as u32 - 1);
            self.list.len() as u32 - 1
        });
        let shared = &mut self.list[vertex as usize];
        shared.area += normal.length();
        shared.lit_area += share * normal.length();
        vertex
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Lit, Shadowed, Undecided};
    use umbriel_geometry::{Analytic, Cuboid, Placement, Rectangle};
    use umbriel_scene::{Shape, Sides};

    fn object(shape: Shape) -> Object {
        Object::new("body".into(), shape, Placement::IDENTITY, Sides::Auto).expect("a body")
    }

    fn rectangle() -> Object {
        object(Shape::Rectangle(Rectangle { size: [4.0, 2.0] }))
    }

    fn cell(level: u8, i: u32, j: u32, verdict: Verdict) -> Cell {
        Cell { face: 0, corner: 0, level, i, j, verdict }
    }

    fn quarters(verdicts: [Verdict; 4]) -> Vec<Cell> {
        (0..4).map(|k| cell(1, k % 2, k / 2, verdicts[k as usize])).collect()
    }

    fn mesh(object: &Object, cells: &[Cell], coloring: Coloring) -> ColoredMesh {
        super::mesh(object, &cells.iter().map(Shaded::of).collect::<Vec<_>>(), coloring)
    }

    /// Twice the area of the triangles.
    fn doubled_area(mesh: &ColoredMesh) -> DVec3 {
        let corner = |index: u32| DVec3::from_array(mesh.positions[index as usize]);
        let cross = |[a, b, c]: [u32; 3]| (corner(b) - corner(a)).cross(corner(c) - corner(a));
        mesh.triangles.iter().map(|&triangle| cross(triangle)).sum()
    }

    #[test]
    fn every_colouring_shows_the_whole_face() {
        for (coloring, vertices) in [(Coloring::Cell, 16), (Coloring::Face, 4), (Coloring::Vertex, 9)] {
            let mesh = mesh(&rectangle(), &quarters([Lit; 4]), coloring);
            assert_eq!(doubled_area(&mesh), DVec3::new(0.0, 16.0, 0.0), "{coloring:?}");
            assert_eq!(mesh.colors, vec![LIT; vertices], "{coloring:?}");
        }
    }

    #[test]
    fn a_face_has_the_mixture_of_its_cells() {
        let mesh = mesh(&rectangle(), &quarters([Lit, Shadowed, Undecided, Shadowed]), Coloring::Face);
        assert_eq!(mesh.colors, vec![mixture(0.375); 4]);
        assert_eq!((mixture(0.0), mixture(1.0)), (SHADOWED, LIT));
    }

    #[test]
    fn a_vertex_has_the_mean_of_the_cells_around() {
        let mesh = mesh(&rectangle(), &quarters([Lit, Shadowed, Lit, Lit]), Coloring::Vertex);
        let color = |x: f64, z: f64| {
            let at = mesh.positions.iter().position(|&position| position == [x, 0.0, z]).expect("a vertex");
            mesh.colors[at]
        };
        assert_eq!(color(0.0, 0.0), mixture(0.75), "all four");
        assert_eq!(color(0.0, 1.0), mixture(0.5), "the lower two");
        assert_eq!(color(2.0, 1.0), SHADOWED);
        assert_eq!(color(-2.0, 1.0), LIT);
    }

    #[test]
    fn a_small_cell_does_not_shade_a_large_one() {
        let cells = [cell(1, 0, 0, Lit), cell(4, 8, 0, Shadowed)];
        let mesh = mesh(&rectangle(), &cells, Coloring::Vertex);
        let at = mesh.positions.iter().position(|&position| position == [0.0, 0.0, 1.0]).expect("a vertex");
        assert_eq!(mesh.colors[at], mixture(64.0 / 65.0));
    }

    #[test]
    fn light_does_not_shine_round_sharp_edges() {
        let top_lit = |face: u32| if face == 3 { Lit } else { Shadowed };
        let cells: Vec<Cell> = (0..6).map(|face| Cell { face, ..cell(0, 0, 0, top_lit(face)) }).collect();
        let cuboid = mesh(&object(Shape::Cuboid(Cuboid { size: [1.0; 3] })), &cells, Coloring::Vertex);
        assert_eq!((cuboid.positions.len(), cuboid.colors.iter().filter(|&&color| color == LIT).count()), (24, 4));
        let ball = mesh(&object(Shape::from(Analytic::Sphere { radius: 1.0 })), &cells, Coloring::Vertex);
        // A patch has 16 × 16 polygons here; the patches of a ball share their borders.
        assert_eq!(ball.positions.len(), 6 * 16 * 16 + 2);
        assert!(ball.colors.iter().any(|&color| color != LIT && color != SHADOWED), "the border is smooth");
    }
}
