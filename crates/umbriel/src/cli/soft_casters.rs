//! What blocks in a scene for the methods of pictures: the boxes of objects, made once.

use glam::{DAffine3, DVec3};
use umbriel_geometry::Placement;
use umbriel_scene::{FamilyTree, Member, Scene};
use umbriel_shadow::soft_image::{
    Blocker, BoxTree, Outline, covering_outlines, hide_others, may_hide_itself, visible_outlines,
};
use umbriel_visibility::depth_map::LightSpace;

use crate::cli::Failure;

/// The objects that block, and their boxes in local coordinates.
pub(super) struct Casters {
    trees: Vec<BoxTree>,
    /// Objects by the families at the top of the scene, each a blocker.
    groups: Vec<Vec<usize>>,
    /// Of objects: whether they may hide others.
    hide_others: Vec<bool>,
}

/// How many boxes a frame uses, and what became of them.
pub(super) struct BoxCounts {
    pub(super) boxes: usize,
    /// Boxes that reach the plane of the light and have no parts.
    pub(super) left_out: usize,
    /// Of the outlines that are left.
    pub(super) corners: Vec<usize>,
}

impl Casters {
    /// A blocker is whatever has some other surface behind it as the light sees it, of its own or of another object.
    pub(super) fn new(scene: &Scene, space: &LightSpace) -> Self {
        let trees: Vec<BoxTree> = scene.objects.iter().map(BoxTree::of).collect();
        let hide_others = hide_others(space, &scene.objects, &trees);
        let blocks = |&object: &usize| hide_others[object] || may_hide_itself(&scene.objects[object]);
        let families = &scene.families;
        let groups = families.roots.iter().map(|&member| objects_of(families, member));
        let mut groups: Vec<Vec<usize>> = groups.collect();
        if groups.is_empty() {
            // A scene of one's own making may have no families.
            groups = (0..scene.objects.len()).map(|object| vec![object]).collect();
        }
        groups.iter_mut().for_each(|group| group.retain(blocks));
        groups.retain(|group| !group.is_empty());
        Self { trees, groups, hide_others }
    }

    /// The scene with everything that hides other objects moved.
    pub(super) fn moved(&self, scene: &Scene, by: DVec3) -> Result<Scene, Failure> {
        let mut moved = scene.clone();
        if by == DVec3::ZERO {
            return Ok(moved);
        }
        for (object, _) in moved.objects.iter_mut().zip(&self.hide_others).filter(|(_, hides)| **hides) {
            let refused =
                |reason: String| Failure::Refused(format!("--step moves \"{}\" too far: {reason}", object.name));
            let map = DAffine3 { translation: object.placement.map().translation + by, ..*object.placement.map() };
            let placement = Placement::new(map).map_err(|defect| refused(defect.to_string()))?;
            *object = object.moved(placement).map_err(|defect| refused(defect.to_string()))?;
        }
        Ok(moved)
    }

    /// The outlines of a group's boxes, before any corner is removed, and how many boxes have none.
    fn outlines(
        &self,
        group: &[usize],
        scene: &Scene,
        space: &LightSpace,
        is_fine: impl Fn([f64; 2]) -> bool,
    ) -> (Vec<Outline>, usize) {
        let cuts =
            group.iter().map(|&object| self.trees[object].cut(scene.objects[object].placement.map(), space, &is_fine));
        cuts.fold((Vec::new(), 0), |(mut outlines, left_out), cut| {
            outlines.extend(cut.outlines);
            (outlines, left_out + cut.left_out)
        })
    }

    /// One blocker a group: what a frame computes anew from the boxes.
    pub(super) fn blockers(&self, scene: &Scene, space: &LightSpace) -> Vec<Blocker> {
        let blocker = |group: &Vec<usize>| {
            let (outlines, _) = self.outlines(group, scene, space, |_| true);
            Blocker::of(&visible_outlines(&outlines))
        };
        self.groups.iter().filter_map(blocker).collect()
    }

    /// One blocker a box, with boxes replaced by their parts until the penumbra of each, on a receiver at this depth under a light of
    /// this width, is known within `tolerance` metres.
    pub(super) fn refined(
        &self,
        scene: &Scene,
        space: &LightSpace,
        receiver: f64,
        [width, tolerance]: [f64; 2],
    ) -> Vec<Blocker> {
        let is_fine = |depths| {
            let [widest, narrowest] = Blocker::interval(space, depths, receiver, width);
            widest - narrowest <= tolerance
        };
        let blockers = |group: &Vec<usize>| {
            let (outlines, _) = self.outlines(group, scene, space, is_fine);
            let covering = covering_outlines(&outlines);
            covering.iter().filter_map(|outline| Blocker::of(std::slice::from_ref(outline))).collect::<Vec<_>>()
        };
        self.groups.iter().flat_map(blockers).collect()
    }

    pub(super) fn counts(&self, scene: &Scene, space: &LightSpace) -> BoxCounts {
        let mut counts = BoxCounts { boxes: 0, left_out: 0, corners: Vec::new() };
        for group in &self.groups {
            let (outlines, left_out) = self.outlines(group, scene, space, |_| true);
            counts.boxes += outlines.len() + left_out;
            counts.left_out += left_out;
            counts.corners.extend(visible_outlines(&outlines).iter().map(|outline| outline.corners.len()));
        }
        counts
    }
}

/// The objects below a member.
fn objects_of(tree: &FamilyTree, member: Member) -> Vec<usize> {
    match member {
        Member::Object(object) => vec![object],
        Member::Family(family) => {
            tree.families[family].members.iter().flat_map(|&member| objects_of(tree, member)).collect()
        }
    }
}
