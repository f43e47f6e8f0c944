//! The coarse step: which objects may shadow which, by their boxes and families (Xie et al. 2001, "Coarse step").

use umbriel_bvh::{Families, Influences, Member, ObjectTree, Shaft, influences};
use umbriel_geometry::{Aabb, LightSource};
use umbriel_scene::FamilyTree;

use crate::bodies::Bodies;

/// The tree of bounding cubes over a scene's families; what no light reaches is left out, and so is what may shadow none of the receivers under `lights`, if
/// these are known. A scene whose families do not form a tree over its objects is
/// grouped by place instead.
pub(crate) fn object_tree(bodies: &Bodies, receivers: &[usize], lights: Option<&[LightSource]>) -> ObjectTree {
    let families = families_of(&bodies.scene.families);
    let lit = |(object, bounds): (usize, &Aabb)| if bodies.is_dark(object) { Aabb::EMPTY } else { *bounds };
    let mut boxes: Vec<Aabb> = bodies.boxes.iter().enumerate().map(lit).collect();
    if let Some(lights) = lights.filter(|_| receivers.len() < boxes.len()) {
        leave_out_idle(&mut boxes, receivers, lights);
    }
    ObjectTree::build(&boxes, &families).unwrap_or_else(|_| {
        ObjectTree::build(&boxes, &Families::default()).expect("fewer than 2^30 objects without families")
    })
}

/// Leaves out what lies in no shaft from all of the receivers together to a light. The test of a shaft is monotone in both boxes, so nothing that may shadow
/// one of the receivers goes. Cost: one test an object and light.
fn leave_out_idle(boxes: &mut [Aabb], receivers: &[usize], lights: &[LightSource]) {
    let all = receivers.iter().fold(Aabb::EMPTY, |all, &receiver| all.union(boxes[receiver]));
    let shafts: Vec<Shaft> = lights.iter().map(|light| Shaft::new(&all, light)).collect();
    let kept: Vec<Aabb> = receivers.iter().map(|&receiver| boxes[receiver]).collect();
    for bounds in boxes.iter_mut().filter(|bounds| !shafts.iter().any(|shaft| shaft.may_meet(bounds))) {
        *bounds = Aabb::EMPTY;
    }
    receivers.iter().zip(kept).for_each(|(&receiver, bounds)| boxes[receiver] = bounds);
}

fn families_of(tree: &FamilyTree) -> Families {
    let member = |member: &umbriel_scene::Member| match *member {
        umbriel_scene::Member::Object(object) => Member::Object(object as u32),
        umbriel_scene::Member::Family(family) => Member::Family(family as u32),
    };
    Families {
        members: tree.families.iter().map(|family| family.members.iter().map(member).collect()).collect(),
        roots: tree.roots.iter().map(member).collect(),
    }
}

/// Which objects may shadow each asked receiver.
pub(crate) fn coarse_step(tree: &ObjectTree, receivers: &[usize], light: &LightSource) -> Influences {
    let mut is_asked = vec![false; tree.objects()];
    receivers.iter().for_each(|&receiver| is_asked[receiver] = true);
    influences(tree, light, |object| is_asked[object as usize])
}
