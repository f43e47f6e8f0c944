//! The coarse step: which objects may shadow which, by their boxes and families (Xie et al. 2001, "Coarse step").

use umbriel_bvh::{Families, Influences, Member, ObjectTree, influences};
use umbriel_geometry::{Aabb, LightSource};
use umbriel_scene::FamilyTree;

use crate::bodies::Bodies;

/// The tree of bounding cubes over a scene's families; what no light reaches is left out. A scene whose families do not form a tree over its objects is
/// grouped by place instead.
pub(crate) fn object_tree(bodies: &Bodies) -> ObjectTree {
    let families = families_of(&bodies.scene.families);
    let lit = |(object, bounds): (usize, &Aabb)| if bodies.is_dark(object) { Aabb::EMPTY } else { *bounds };
    let boxes: Vec<Aabb> = bodies.boxes.iter().enumerate().map(lit).collect();
    ObjectTree::build(&boxes, &families).unwrap_or_else(|_| {
        ObjectTree::build(&boxes, &Families::default()).expect("fewer than 2^30 objects without families")
    })
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
