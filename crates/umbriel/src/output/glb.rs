//! A bake as a coloured model: every stored cell a polygon in the colour of its verdict.

use glam::DVec3;
use umbriel_geometry::{Facet, Facets, Sphere};
use umbriel_io::write::ColoredMesh;
use umbriel_scene::{Object, Scene, Shape};
use umbriel_shadow::{Cell, LightReport, Verdict};

/// On a sphere no polygon is coarser than a patch halved this often, so that it looks round.
const ROUND_LEVEL: u8 = 4;

/// The objects that have stored cells, each a mesh.
pub(crate) fn meshes(scene: &Scene, light: &LightReport) -> Vec<ColoredMesh> {
    let with_cells = light.objects.iter().filter(|object| !object.cells.is_empty());
    with_cells.map(|report| mesh(&scene.objects[report.object], &report.cells)).collect()
}

/// Linear light, as glTF wants vertex colours.
fn color(verdict: Verdict) -> [u8; 4] {
    match verdict {
        Verdict::Lit => [255, 205, 120, 255],
        Verdict::Shadowed => [10, 16, 48, 255],
        Verdict::Undecided => [255, 70, 0, 255],
    }
}

fn mesh(object: &Object, cells: &[Cell]) -> ColoredMesh {
    let surface = Surface::of(object);
    let mut mesh = ColoredMesh { name: object.name.clone(), ..Default::default() };
    for cell in cells {
        for polygon in surface.polygons(cell) {
            let first = mesh.positions.len() as u32;
            mesh.positions.extend(polygon.iter().map(|point| point.to_array()));
            mesh.colors.extend(polygon.iter().map(|_| color(cell.verdict)));
            mesh.triangles.extend((2..polygon.len() as u32).map(|i| [first, first + i - 1, first + i]));
        }
    }
    mesh
}

/// Where (u, v) of a face lies in the world.
enum Surface<'a> {
    Facets(Facets),
    Sphere(&'a Object, Sphere),
    /// A curved shape that this file format knows no polygons for.
    Unknown,
}

impl<'a> Surface<'a> {
    fn of(object: &'a Object) -> Self {
        match (&object.shape, object.facets()) {
            (Shape::Sphere(sphere), _) => Self::Sphere(object, *sphere),
            (_, Some(facets)) => Self::Facets(facets),
            _ => Self::Unknown,
        }
    }

    /// The convex polygons of a cell, counter-clockwise seen from the face's front.
    fn polygons(&self, cell: &Cell) -> Vec<Vec<DVec3>> {
        match self {
            Self::Unknown => Vec::new(),
            Self::Facets(facets) => {
                let facet = facets.facet(cell.face as usize);
                let half = matches!(facet, Facet::Triangle(_)) && is_cut(cell);
                let mut polygon: Vec<DVec3> =
                    corners(cell, half).iter().map(|&(u, v)| facet_point(facets, facet, u, v)).collect();
                if facets.is_mirrored() {
                    polygon.reverse();
                }
                vec![polygon]
            }
            Self::Sphere(object, sphere) => {
                let point = |(u, v): (f64, f64)| {
                    let direction = Sphere::direction(cell.face as usize, u, v).normalize();
                    object.placement.map().transform_point3(sphere.radius * direction)
                };
                let parts = split(cell, ROUND_LEVEL).into_iter();
                let mirrored = object.placement.is_mirrored();
                parts
                    .map(|part| {
                        let mut polygon = corners(&part, false).into_iter().map(point).collect::<Vec<_>>();
                        if mirrored {
                            polygon.reverse();
                        }
                        polygon
                    })
                    .collect()
            }
        }
    }
}

/// Whether the line u + v = 1 cuts the cell in half.
fn is_cut(cell: &Cell) -> bool {
    u64::from(cell.i) + u64::from(cell.j) + 1 == 1 << cell.level
}

/// The corners of a cell in its face's parameters, counter-clockwise; of its lower half only if `half`.
fn corners(cell: &Cell, half: bool) -> Vec<(f64, f64)> {
    let steps: &[(f64, f64)] =
        if half { &[(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)] } else { &[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] };
    steps.iter().map(|&(s, t)| cell.point([s, t]).into()).collect()
}

/// The cell, or its descendants at `level` when it is coarser.
fn split(cell: &Cell, level: u8) -> Vec<Cell> {
    let steps = level.saturating_sub(cell.level);
    let part = |i: u32, j: u32| Cell {
        level: cell.level + steps,
        i: (cell.i << steps) + i,
        j: (cell.j << steps) + j,
        ..*cell
    };
    (0..1u32 << steps).flat_map(|j| (0..1u32 << steps).map(move |i| part(i, j))).collect()
}

fn facet_point(facets: &Facets, facet: &Facet, u: f64, v: f64) -> DVec3 {
    let corners = facet.corners();
    let at = |corner: u32| facets.positions()[corner as usize];
    let (first, second, last) = (at(corners[0]), at(corners[1]), at(corners[corners.len() - 1]));
    first + u * (second - first) + v * (last - first)
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbriel_geometry::{Placement, Rectangle};
    use umbriel_scene::Sides;

    fn object(shape: Shape) -> Object {
        Object::new("body".into(), shape, Placement::IDENTITY, Sides::Auto).expect("a body")
    }

    fn cell(level: u8, i: u32, j: u32) -> Cell {
        Cell { face: 0, corner: 0, level, i, j, verdict: Verdict::Lit }
    }

    /// Twice the area of the triangles.
    fn doubled_area(mesh: &ColoredMesh) -> DVec3 {
        let corner = |index: u32| DVec3::from_array(mesh.positions[index as usize]);
        let cross = |[a, b, c]: [u32; 3]| (corner(b) - corner(a)).cross(corner(c) - corner(a));
        mesh.triangles.iter().map(|&triangle| cross(triangle)).sum()
    }

    #[test]
    fn cells_tile_their_face() {
        let rectangle = object(Shape::Rectangle(Rectangle { size: [4.0, 2.0] }));
        let quarters = [cell(1, 0, 0), cell(1, 1, 0), cell(1, 0, 1), cell(1, 1, 1)];
        assert_eq!(doubled_area(&mesh(&rectangle, &quarters)), DVec3::new(0.0, 16.0, 0.0));
        let positions = vec![[0.0; 3], [4.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
        let triangle = umbriel_geometry::Mesh::new(positions, vec![[0, 1, 2]]).expect("a mesh");
        let triangle = object(Shape::Mesh(triangle.into()));
        assert_eq!(doubled_area(&mesh(&triangle, &quarters[..3])), DVec3::new(0.0, 0.0, 8.0));
    }

    #[test]
    fn a_sphere_is_round_and_looks_outward() {
        let sphere = object(Shape::Sphere(Sphere { radius: 2.0 }));
        let whole: Vec<Cell> = (0..6).map(|face| Cell { face, ..cell(0, 0, 0) }).collect();
        let mesh = mesh(&sphere, &whole);
        let corner = |index: u32| DVec3::from_array(mesh.positions[index as usize]);
        let volume: f64 = mesh.triangles.iter().map(|&[a, b, c]| corner(a).dot(corner(b).cross(corner(c))) / 6.0).sum();
        let exact = 4.0 / 3.0 * std::f64::consts::PI * 8.0;
        assert!(volume > 0.98 * exact && volume < exact, "{volume} is not {exact}");
    }
}
