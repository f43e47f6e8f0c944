//! Borders of the facets that are found over a face, where a mesh has many more: cells against exact answers, and against a quadtree's.

use glam::{DAffine3, DVec3};
use umbriel_geometry::{LightSource, Mesh, Placement, Rectangle};
use umbriel_scene::{Light, Object, Scene, Shape, Sides};
use umbriel_shadow::{CellMethod, Detail, Place, Queries, Report, Request, Silent, Verdict, bake};

/// Tiles of the floor along each side, two metres each: over one there is less than a twelfth of the mesh.
const TILES: u32 = 6;

/// Pyramids of the mesh along each side of a tile.
const PYRAMIDS: u32 = 6;

fn object(name: String, shape: Shape, at: DVec3) -> Object {
    let placement = Placement::new(DAffine3::from_translation(at)).expect("regular");
    Object::new(name, shape, placement, Sides::Two).expect("an object")
}

/// Pyramids in rows, of four sides or with an open one, some of them through the floor. Neighbours share corners.
fn pyramids() -> Mesh {
    let count = TILES * PYRAMIDS;
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    let step = 2.0 / f64::from(PYRAMIDS);
    for (row, column) in (0..=count).flat_map(|row| (0..=count).map(move |column| (row, column))) {
        positions.push([f64::from(column) * step, 0.4, f64::from(row) * step]);
    }
    let corner = |row: u32, column: u32| row * (count + 1) + column;
    for (row, column) in (0..count).flat_map(|row| (0..count).map(move |column| (row, column))) {
        let number = row * 7 + column * 3;
        if number.is_multiple_of(4) {
            continue;
        }
        let height = if number.is_multiple_of(5) { -0.3 } else { 0.9 };
        let tip = positions.len() as u32;
        positions.push([(f64::from(column) + 0.5) * step, height, (f64::from(row) + 0.4) * step]);
        let base = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[down, right]| corner(row + down, column + right));
        let sides = if number.is_multiple_of(3) { 3 } else { 4 };
        triangles.extend((0..sides).map(|k| [base[k], base[(k + 1) % 4], tip]));
    }
    Mesh::new(positions, triangles).expect("a mesh")
}

fn scene(light: LightSource) -> Scene {
    let mut objects = vec![object("pyramids".into(), Shape::Mesh(pyramids().into()), DVec3::ZERO)];
    for (row, column) in (0..TILES).flat_map(|row| (0..TILES).map(move |column| (row, column))) {
        let at = DVec3::new(f64::from(column) * 2.0 + 1.0, 0.0, f64::from(row) * 2.0 + 1.0);
        let tile = Shape::Rectangle(Rectangle { size: [2.0; 2] });
        objects.push(object(format!("tile {row} {column}"), tile, at));
    }
    Scene { objects: objects.into(), lights: vec![Light::new("light", light)], ..Scene::default() }
}

fn baked(scene: &Scene, method: CellMethod) -> Report {
    let receivers = (1..scene.objects.len()).collect();
    let detail = Detail::Depth { interior: 7, boundary: 7 };
    let request = Request { keep_cells: true, method, receivers, ..Request::everything(scene, detail) };
    bake(scene, &request, &Silent).expect("nobody cancels")
}

#[test]
fn what_is_drawn_of_a_part_of_a_mesh_is_true() {
    let sun = LightSource::sun([0.4, -1.0, 0.3]).expect("a sun");
    let low = LightSource::sun([1.0, -0.2, 0.1]).expect("a sun");
    let lamp = LightSource::point([5.3, 3.7, 6.1]).expect("a lamp");
    for light in [sun, low, lamp] {
        let scene = scene(light);
        let queries = Queries::new(&scene);
        let [drawn, divided] = [CellMethod::Borders, CellMethod::Quadtree].map(|method| baked(&scene, method));
        let (mut proved, mut undecided) = ([0; 2], [0.0; 2]);
        for (drawn, divided) in drawn.lights[0].objects.iter().zip(&divided.lights[0].objects) {
            undecided = [undecided[0] + drawn.undecided(), undecided[1] + divided.undecided()];
            for cell in drawn.cells.iter().filter(|cell| cell.verdict != Verdict::Undecided) {
                for place in [[0.5, 0.5], [0.01, 0.02], [0.99, 0.97]] {
                    let [u, v] = cell.point(place);
                    let place = Place::Surface { object: drawn.object, face: cell.face as usize, u, v };
                    let lit = queries.lit(&place, &light).expect("a point").lit;
                    assert_eq!(lit, cell.verdict == Verdict::Lit, "{cell:?} of {} under {light:?}", drawn.object);
                    proved[usize::from(lit)] += 1;
                }
            }
        }
        assert!(proved.iter().all(|&count| count > 3000), "{proved:?} dark and lit under {light:?}");
        assert!(undecided[0] < 1.25 * undecided[1], "{undecided:?} m² drawn and divided under {light:?}");
    }
}
