//! A bake that models only what each light reaches through the portals of a scene's cells.
//!
//! For each light the objects that it may reach, and the receivers that are asked for, make a scene of their own, which is baked
//! as any other. A receiver that light does not reach is paired with nothing, and all of it is in shadow. What a ray of the
//! light meets first is always among what is reached ([`umbriel_visibility::portals`]), so no occluder is missing: the first one on
//! the way to a point that is reached, or to one that is not, is there.
//!
//! Cost: that of the objects that are reached and the receivers that are asked for; nothing grows with the rest of the scene.

use std::collections::{BTreeMap, BTreeSet};

use umbriel_scene::Scene;
use umbriel_visibility::portals::{Reach, Start, reach_of_light};

use crate::{
    bake::Stage,
    progress::{Cancelled, Progress},
    report::{LightReport, ObjectReport, PortalWork, Report},
    request::{Detail, OwnDetails, Request},
};

/// The objects that some of the lights of a scene may reach through its portals, ascending: all others are in shadow, whatever the detail.
/// All objects where the scene has no cells. Cost: that of the cells that light enters.
///
/// # Panics
/// If the scene does not have one of the lights.
pub fn reached_receivers(scene: &Scene, lights: &[usize]) -> Vec<usize> {
    if scene.cells.is_empty() {
        return (0..scene.objects.len()).collect();
    }
    let reaches = lights.iter().map(|&light| reach_of_light(scene, &scene.lights[light].source));
    let reached: BTreeSet<usize> = reaches.flat_map(|reach| reach.indices().collect::<Vec<_>>()).collect();
    reached.into_iter().collect()
}

/// As [`bake`](crate::bake()), light by light.
pub(crate) fn bake(scene: &Scene, request: &Request, progress: &dyn Progress) -> Result<Report, Cancelled> {
    let mut report = Report::default();
    for &light in &request.lights {
        let reach = reach_of_light(scene, &scene.lights[light].source);
        let part = Part::new(scene, request, light, &reach);
        report.work.portals += part.work(scene, &reach);
        let objects = part.bake(request, progress, &mut report)?;
        report.lights.push(LightReport { light, objects });
    }
    Ok(report)
}

/// The details of a light and of the objects that are taken, under their new numbers.
fn own_of(request: &Request, light: usize, place: &BTreeMap<usize, usize>) -> OwnDetails {
    let objects = request.own.objects.iter().filter_map(|(object, &detail)| Some((*place.get(object)?, detail)));
    OwnDetails {
        objects: objects.collect(),
        lights: request.own.lights.get(&light).map(|&detail| (0, detail)).into_iter().collect(),
    }
}

/// What one light needs of a scene.
struct Part {
    scene: Scene,
    request: Request,
    /// Whether light may reach the objects.
    reached: Vec<bool>,
}

impl Part {
    fn new(scene: &Scene, request: &Request, light: usize, reach: &Reach) -> Self {
        // Whether an object is reached, by its index.
        let mut taken: BTreeMap<usize, bool> = request.receivers.iter().map(|&receiver| (receiver, false)).collect();
        if reach.indices().any(|object| taken.contains_key(&object)) {
            taken.extend(reach.indices().map(|object| (object, true)));
        }
        let place: BTreeMap<usize, usize> = taken.keys().enumerate().map(|(place, &object)| (object, place)).collect();
        let detail = match request.detail {
            Detail::Time { limit } => Detail::Time { limit: limit / request.lights.len().max(1) as u32 },
            detail => detail,
        };
        let receivers: Vec<usize> = request.receivers.iter().map(|receiver| place[receiver]).collect();
        Self {
            reached: taken.values().copied().collect(),
            scene: Scene {
                objects: taken.keys().map(|&object| scene.objects[object].clone()).collect(),
                lights: vec![scene.lights[light].clone()],
                ..Scene::default()
            },
            request: Request {
                detail,
                own: own_of(request, light, &place),
                lights: vec![0],
                receivers,
                ..request.clone()
            },
        }
    }

    fn work(&self, scene: &Scene, reach: &Reach) -> PortalWork {
        let is_of_use = self.reached.contains(&true);
        PortalWork {
            lights_left_out: u64::from(!is_of_use),
            cells: reach.cells.len() as u64,
            passages: reach.passages as u64,
            objects: reach.objects.len() as u64,
            objects_left_out: (scene.objects.len() - reach.objects.len()) as u64,
            receivers_left_out: self.request.receivers.iter().filter(|&&receiver| !self.reached[receiver]).count()
                as u64,
            lights_outside: u64::from(reach.start != Start::Cells),
        }
    }

    /// The reports, with objects and receivers numbered as in the whole scene.
    fn bake(
        self,
        request: &Request,
        progress: &dyn Progress,
        report: &mut Report,
    ) -> Result<Vec<ObjectReport>, Cancelled> {
        let stage = Stage::with_reached(&self.scene, &self.request, self.reached);
        let mut expense = stage.expense();
        let mut objects = stage.bake(
            &self.scene.lights[0].source,
            self.request.own.lights.get(&0).copied(),
            progress,
            &mut expense,
        )?;
        for (object, &number) in objects.iter_mut().zip(&request.receivers) {
            object.object = number;
        }
        report.work.add(&expense.work);
        report.time.coarse += expense.time.coarse;
        report.time.fine += expense.time.fine;
        Ok(objects)
    }
}
