//! Scenes in which so much lies over everything that the pairs of all faces and the facets over them are the square of the input.
//!
//! What [`crowd`] says of one receiver, this says of a scene: how many pairs all receivers together may have goes by how many faces there are. Where
//! they have more, which is expected from a few faces that no order picks, each face looks for what is over it in trees over all facets of the scene
//! ([`Throng`](crate::fine::occluders::throng::Throng)), and faces under more than a few facets are divided as those in crowds: what is told of them is proved, and most stays undecided. No list of
//! pairs of objects is made then, so neither step goes with the square of the objects. Guarantee: whether a scene is a throng goes by its receivers, its occluders and the light, not
//! by any order. Cost: a ticket for each face, the facets over some hundred, and the trees. Not bounded: pairs with curved bodies, and scenes of more than [`MOST`] faces.

use rayon::prelude::*;

use crate::{
    bake::Stage,
    bodies::{Bodies, Body},
    coarse::{Influences, most_faces},
    fine::{Occluders, crowd, occluders::Among},
    tickets,
};

/// Faces of a scene at most, instances counted each: trees over more would not fit beside the rest.
const MOST: usize = 1 << 21;

/// Pairs of a face and a facet over it that any scene may have, and for each face of a receiver and each facet: as many as a face in a crowd has. Those of hostile scenes take some ten
/// microseconds each.
const FREE_PAIRS: usize = 1 << 19;
const PAIRS_EACH: usize = crowd::PAIRS;

/// Whether the receivers of a bake have too many pairs of a face and a facet over it to measure them all.
pub(crate) fn is_throng(stage: &Stage, influences: &Influences, occluders: &Occluders) -> bool {
    let scene = stage.bodies.scene;
    let facets: usize = stage.coarse.occluders().map(|object| most_faces(&scene.objects[object])).sum();
    let receivers: Vec<usize> = stage.first_receivers().collect();
    let faces: usize = receivers.iter().map(|&object| most_faces(&scene.objects[object])).sum();
    let allowed = FREE_PAIRS + PAIRS_EACH * (faces + facets);
    let is_few = influences.is_whole() && influences.face_pairs() <= allowed as u64;
    if is_few || faces > MOST || facets > MOST {
        return false;
    }
    let faces = Faces::of(&stage.bodies, &receivers);
    crowd::is_crowd(&faces.halvings, allowed, |place, most| {
        // Instances are placed for this one face, and forgotten.
        let bodies = Bodies::of_group(&stage.bodies);
        let (object, face) = faces.at(place);
        match bodies.get(object) {
            Body::Flat(facets) => {
                let over = influences.occluders_of(object as u32);
                let occluders = Occluders::of_group(&bodies, occluders);
                occluders.burden_of_face(Among::Objects(&over), (object, facets, face), most)
            }
            Body::Analytic(_) => 0,
        }
    })
}

/// The flat faces of some objects, in a row.
struct Faces {
    /// Where each object's faces begin, and the object; ascending.
    starts: Vec<(usize, usize)>,
    /// How often the faces can be halved until each is left out.
    halvings: Vec<u8>,
}

impl Faces {
    fn of(bodies: &Bodies, objects: &[usize]) -> Self {
        let of_object = |&object: &usize| {
            bodies.look_at(object, |body| match body {
                Body::Flat(facets) => {
                    let tickets = tickets::tickets(&bodies.scene.objects[object], facets);
                    tickets.into_iter().map(tickets::halvings).collect()
                }
                Body::Analytic(_) => Vec::new(),
            })
        };
        let of_objects: Vec<Vec<u8>> = objects.par_iter().map(of_object).collect();
        let mut first = 0;
        let start = |(&object, halvings): (&usize, &Vec<u8>)| {
            let start = (first, object);
            first += halvings.len();
            start
        };
        Self { starts: objects.iter().zip(&of_objects).map(start).collect(), halvings: of_objects.concat() }
    }

    /// The object and its face at a place in the row.
    fn at(&self, place: usize) -> (usize, usize) {
        let (start, object) = self.starts[self.starts.partition_point(|(start, _)| *start <= place) - 1];
        (object, place - start)
    }
}
