//! What about a scene limits the answers, how much surface it concerns, and what it does to the result.
//!
//! A bake is right about the scene *as it is given*: open edges, doubled faces or coarse coordinates are no errors of
//! the computation, and nothing is repaired. [`examine`] finds them, so that a user knows which numbers to trust and
//! what to mend. Counts are exact decisions on placed coordinates (an edge's uses, a face without area, faces that lie
//! in one plane and overlap); areas are rounded sums in square metres.
//!
//! Cost: a sort of every mesh's vertices and edges, and one of all faces by their planes: O(n log n) in the faces of all
//! objects, plus one exact test for every two faces of one plane whose boxes meet, up to some dozens a face where they are very many. Faces of one object are placed at a
//! time; of the others only a number for their plane is kept (`planes`).
//!
//! What breaks it: where very many faces of one plane lie close to each other (their pairs would be the square of their number), overlaps are counted in part, which is told. Curved bodies
//! are exact by construction, and nothing is found about them.

mod coordinates;
mod defect;
mod detail;
mod edges;
mod lamps;
mod overlap;
mod planes;
mod plate;
mod surface;
#[cfg(test)]
mod tests;

use std::{
    collections::HashMap,
    sync::atomic::{AtomicUsize, Ordering},
};

use rayon::prelude::*;
use umbriel_scene::{Scene, first_alike};

use crate::{
    progress::{Cancelled, Progress},
    request::Detail,
};

pub use defect::{Defect, DefectKind, Diagnosis, Note, Place, Total};

use surface::Examined;

/// Examines all objects of a scene, and the chosen lights. `detail` says how large cells are, which tells what surface
/// is too finely meshed for them.
///
/// # Errors
/// [`Cancelled`] when `progress` says so.
///
/// # Panics
/// If `lights` names a light that the scene does not have.
pub fn examine(
    scene: &Scene,
    lights: &[usize],
    detail: Detail,
    progress: &dyn Progress,
) -> Result<Diagnosis, Cancelled> {
    let lamps = lamps::Chosen::new(scene, lights);
    let firsts = firsts(scene);
    let total = scene.objects.len();
    let done = AtomicUsize::new(0);
    let examined = firsts.par_iter().enumerate().map(|(object, &first)| {
        if progress.is_cancelled() {
            return Err(Cancelled);
        }
        // A copy takes over what is found of the first.
        let examined = if first == object { Examined::new(scene, object, detail, &lamps) } else { Examined::default() };
        progress.advance("surfaces", done.fetch_add(1, Ordering::Relaxed) as u64 + 1, total as u64);
        Ok(examined)
    });
    let mut examined = examined.collect::<Result<Vec<Examined>, Cancelled>>()?;
    let planes: Vec<_> = examined.iter_mut().map(|object| std::mem::take(&mut object.planes)).collect();
    let overlaps = overlap::find(scene, &planes, &firsts, progress)?;
    for (object, &first) in firsts.iter().enumerate().filter(|&(object, &first)| first != object) {
        examined[object] = examined[first].of_copy(Place::Object(object));
    }
    Ok(gather(&lamps, examined, overlaps))
}

/// For each object the first one that repeats it with the same sides: what is found of one is found of the other.
fn firsts(scene: &Scene) -> Vec<usize> {
    let mut known = HashMap::new();
    let alike = first_alike(&scene.objects).into_iter().zip(&scene.objects).enumerate();
    alike.map(|(number, (first, object))| *known.entry((first, object.sides)).or_insert(number)).collect()
}

/// All defects of all objects and lights, with their shares.
fn gather(lamps: &lamps::Chosen, examined: Vec<Examined>, overlaps: Vec<Defect>) -> Diagnosis {
    let areas: Vec<f64> = examined.iter().map(|object| object.area).collect();
    let area = areas.iter().sum();
    let mut diagnosis = Diagnosis {
        objects: examined.len(),
        curved: examined.iter().filter(|object| object.is_curved).count(),
        faces: examined.iter().map(|object| object.faces).sum(),
        area,
        defects: lamps.defects(&examined),
    };
    diagnosis.defects.extend(examined.into_iter().flat_map(|object| object.defects));
    diagnosis.defects.extend(overlaps);
    for defect in &mut diagnosis.defects {
        let whole = if let Place::Object(object) = defect.place { areas[object] } else { area };
        defect.share = if whole > 0.0 { (defect.area / whole).min(1.0) } else { 0.0 };
    }
    diagnosis.defects.sort_by_key(|defect| (defect.kind, defect.place));
    diagnosis
}
