//! A baked scene whose proved cells are put to the oracle.

use umbriel_geometry::LightSource;
use umbriel_scene::Scene;
use umbriel_shadow::{Cell, CellMethod, Detail, Report, Request, Silent, Verdict, bake};

use crate::oracle::{
    Oracle,
    dice::Dice,
    fixtures::{has_triangles, lit_by},
};

/// A baked scene with one light.
pub(crate) struct Case {
    /// What it is called in complaints.
    pub(crate) title: String,
    /// The scene with its light.
    pub(crate) scene: Scene,
    /// The light.
    pub(crate) light: LightSource,
    /// The bake, cells kept.
    pub(crate) report: Report,
}

impl Case {
    /// Bakes all of a scene under one light; `depth` is both depths.
    pub(crate) fn new(name: &str, scene: &Scene, light: LightSource, depth: u8) -> Self {
        Self::by(CellMethod::Auto, name, scene, light, depth)
    }

    /// Bakes by a method of the caller's choice.
    pub(crate) fn by(method: CellMethod, name: &str, scene: &Scene, light: LightSource, depth: u8) -> Self {
        let scene = lit_by(scene.clone(), light);
        let detail = Detail::Depth { interior: depth, boundary: depth };
        let request = Request { keep_cells: true, method, ..Request::everything(&scene, detail) };
        let report = bake(&scene, &request, &Silent).expect("nobody cancels");
        Self { title: format!("{name} under {light:?} at depth {depth}"), scene, light, report }
    }

    /// All cells with their objects.
    pub(crate) fn cells(&self) -> impl Iterator<Item = (usize, Cell)> + '_ {
        let objects = self.report.lights.iter().flat_map(|light| &light.objects);
        objects.flat_map(|object| object.cells.iter().map(|&cell| (object.object, cell)))
    }

    /// The decided cells with their objects.
    pub(crate) fn proved(&self) -> Vec<(usize, Cell)> {
        self.cells().filter(|(_, cell)| cell.verdict != Verdict::Undecided).collect()
    }

    /// Whether the faces of an object are triangles.
    pub(crate) fn is_mesh(&self, object: usize) -> bool {
        has_triangles(&self.scene.objects[object].shape)
    }

    /// Asks the oracle about points of one decided cell.
    pub(crate) fn judge(
        &self,
        oracle: &Oracle,
        (object, cell): (usize, Cell),
        points: u64,
        dice: &mut Dice,
    ) -> Option<String> {
        let is_mesh = self.is_mesh(object);
        let expected = cell.verdict == Verdict::Lit;
        (0..points).find_map(|_| {
            let [u, v] = point_of(&cell, is_mesh, dice);
            if !oracle.has_point(object, cell.face as usize, [u, v]) {
                return None;
            }
            let lit = oracle.lit(object, cell.face as usize, [u, v], &self.light);
            let name = &self.scene.objects[object].name;
            (lit != expected).then(|| format!("{}: {name} {cell:?} is wrong at ({u}, {v})", self.title))
        })
    }
}

/// A point of the closed cell; on a triangle, of what u + v ≤ 1 leaves of it. All numbers are exact.
pub(crate) fn point_of(cell: &Cell, is_triangle: bool, dice: &mut Dice) -> [f64; 2] {
    let is_cut = is_triangle && cell.i + cell.j + 1 == 1 << cell.level;
    cell.point(dice.parameters(is_cut))
}
