//! The coarse step as its source prints it (Xie, Yu, Hao and Sun, "The new algorithm of shadow volume with LOD", Journal
//! of the National University of Defense Technology 23(3), 2001): ten bodies in three levels of families, eight pairs
//! registered level by level, six printed pairs of bodies among those that they are refined to.

use std::{ops::ControlFlow, path::PathBuf};

use glam::DVec3;
use umbriel_bvh::{
    Exclusion, Families, Member, NodeId, ObjectTree, cannot_shadow, for_each_influence, influences, influences_with,
    level_pairs, may_shadow,
};
use umbriel_io::{LoadOptions, load};
use umbriel_scene::{FamilyTree, Object, Scene};
use umbriel_shadow::{Detail, Request, Silent, bake};

fn ten_bodies() -> Scene {
    let file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/ten-bodies.gltf");
    let scene = load(&file, &LoadOptions::default()).expect("a stored scene").scene;
    assert!(scene.findings.is_empty(), "{:?}", scene.findings);
    let towards_sun = scene.lights[0].source.xyz().normalize();
    let meant = DVec3::new(-1.0, 2.0, 0.0).normalize();
    // The rotation in the file has eight digits.
    assert!(scene.lights[0].source.is_sun() && (towards_sun - meant).abs().max_element() < 1e-7, "{towards_sun}");
    scene
}

/// The families as the tree takes them.
fn families(tree: &FamilyTree) -> Families {
    let member = |member: &umbriel_scene::Member| match *member {
        umbriel_scene::Member::Object(object) => Member::Object(object as u32),
        umbriel_scene::Member::Family(family) => Member::Family(family as u32),
    };
    Families {
        members: tree.families.iter().map(|family| family.members.iter().map(member).collect()).collect(),
        roots: tree.roots.iter().map(member).collect(),
    }
}

fn tree_of(scene: &Scene) -> ObjectTree {
    let boxes: Vec<_> = scene.objects.iter().map(Object::bounds).collect();
    ObjectTree::build(&boxes, &families(&scene.families)).expect("a forest over the bodies")
}

/// The tree of a scene, with the names that the source gives to its nodes: the numbers of the bodies below them.
struct Named<'a> {
    scene: &'a Scene,
    tree: ObjectTree,
}

impl<'a> Named<'a> {
    fn new(scene: &'a Scene) -> Self {
        Self { scene, tree: tree_of(scene) }
    }

    fn name(&self, node: NodeId) -> String {
        let mut names: Vec<&str> = self
            .tree
            .objects_below(node)
            .iter()
            .map(|&object| self.scene.objects[object as usize].name.as_str())
            .collect();
        names.sort_unstable();
        names.concat()
    }

    /// The names of all nodes, level by level below the root.
    fn levels(&self) -> Vec<Vec<String>> {
        let mut levels = Vec::new();
        let mut nodes = Vec::from_iter(self.tree.root());
        loop {
            nodes = nodes.iter().flat_map(|&node| self.tree.children_of(node)).copied().collect();
            if nodes.is_empty() {
                return levels;
            }
            let mut names: Vec<String> = nodes.iter().map(|&node| self.name(node)).collect();
            names.sort();
            levels.push(names);
        }
    }

    /// The registered pairs of siblings with their level, as printed.
    fn level_pairs(&self) -> Vec<(u32, String)> {
        let pairs = level_pairs(&self.tree, &self.scene.lights[0].source);
        let mut printed: Vec<_> = pairs
            .iter()
            .map(|pair| (pair.level, format!("[{}]->[{}]", self.name(pair.occluder), self.name(pair.receiver))))
            .collect();
        printed.sort();
        printed
    }

    /// The pairs of bodies `(occluder, receiver)` that `may` holds of, as printed.
    fn printed(&self, may: impl Fn(u32, u32) -> bool) -> Vec<String> {
        let bodies = || 0..self.scene.objects.len() as u32;
        let name = |body: u32| &self.scene.objects[body as usize].name;
        let pairs = bodies().flat_map(|occluder| bodies().map(move |receiver| (occluder, receiver)));
        let pairs = pairs.filter(|&(occluder, receiver)| occluder != receiver && may(occluder, receiver));
        let mut printed: Vec<_> = pairs.map(|(a, b)| format!("[{}]->[{}]", name(a), name(b))).collect();
        printed.sort();
        printed
    }

    /// The pairs of bodies that the coarse step ends with.
    fn final_pairs(&self, exclusion: Exclusion) -> Vec<String> {
        let found = influences_with(&self.tree, &self.scene.lights[0].source, |_| true, exclusion);
        self.printed(|occluder, receiver| found.occluders_of(receiver).contains(&occluder))
    }
}

#[test]
fn the_levels_are_those_of_the_source() {
    let scene = ten_bodies();
    let expected: [&[&str]; 3] =
        [&["0123456", "7", "89"], &["024", "13", "56", "8", "9"], &["0", "1", "2", "3", "4", "5", "6"]];
    assert_eq!(Named::new(&scene).levels(), expected);
}

#[test]
fn eight_pairs_are_registered_level_by_level() {
    let scene = ten_bodies();
    let mut expected = [
        (1, "[7]->[0123456]"),
        (1, "[89]->[7]"),
        (2, "[8]->[9]"),
        (2, "[56]->[13]"),
        (2, "[13]->[024]"),
        (3, "[5]->[6]"),
        (3, "[3]->[1]"),
        (3, "[4]->[0]"),
    ]
    .map(|(level, pair)| (level, pair.to_owned()));
    expected.sort();
    assert_eq!(Named::new(&scene).level_pairs(), expected);
}

#[test]
fn the_six_printed_pairs_remain_and_three_that_the_source_leaves_open() {
    let scene = ten_bodies();
    let printed = ["[8]->[9]", "[5]->[6]", "[3]->[1]", "[4]->[0]", "[7]->[6]", "[7]->[2]"];
    // One pair of bodies each for [89]->[7], [56]->[13] and [13]->[024].
    let left_open = ["[9]->[7]", "[5]->[3]", "[1]->[4]"];
    let mut expected: Vec<&str> = printed.into_iter().chain(left_open).collect();
    expected.sort_unstable();
    let named = Named::new(&scene);
    assert_eq!(named.final_pairs(Exclusion::Planes), expected);
    assert_eq!(named.final_pairs(Exclusion::Off), expected);
}

#[test]
fn the_final_pairs_are_those_of_all_pairs_of_bodies() {
    let scene = ten_bodies();
    let (named, sun) = (Named::new(&scene), &scene.lights[0].source);
    let bounds = |body: u32| scene.objects[body as usize].bounds();
    let by_boxes =
        named.printed(|a, b| may_shadow(&bounds(a), &bounds(b), sun) && !cannot_shadow(&bounds(a), &bounds(b), sun));
    assert_eq!(named.final_pairs(Exclusion::Planes), by_boxes);
    // The bodies are boxes, so this decides again, in other terms: the sun draws them on the plane y = 0 as rectangles
    // whose extents are s = x + y/2 and z, and all that stand one over the other are apart in y.
    let by_drawing = named.printed(|a, b| {
        let (a, b) = (bounds(a), bounds(b));
        let meet = |a: [f64; 2], b: [f64; 2]| a[0] < b[1] && b[0] < a[1];
        let s = |of: umbriel_geometry::Aabb| [of.min.x + of.min.y / 2.0, of.max.x + of.max.y / 2.0];
        a.min.y >= b.max.y && meet(s(a), s(b)) && meet([a.min.z, a.max.z], [b.min.z, b.max.z])
    });
    assert_eq!(by_drawing, by_boxes);
}

#[test]
fn families_change_the_way_and_not_the_result() {
    let scene = ten_bodies();
    let (named, sun) = (Named::new(&scene), &scene.lights[0].source);
    let boxes: Vec<_> = scene.objects.iter().map(Object::bounds).collect();
    let built = ObjectTree::build(&boxes, &Families::default()).expect("no families, no defect");
    let (given, built) = (influences(&named.tree, sun, |_| true), influences(&built, sun, |_| true));
    for body in 0..10 {
        assert_eq!(given.occluders_of(body), built.occluders_of(body));
    }
}

/// The pipeline walks the families of the file: its counts are those of this tree.
#[test]
fn a_bake_takes_the_families_of_the_file() {
    let scene = ten_bodies();
    let go_on = |_: &[u32], _: &[u32]| ControlFlow::Continue(());
    let counts = for_each_influence(&tree_of(&scene), &scene.lights[0].source, |_| true, go_on);
    let request = Request::everything(&scene, Detail::Depth { interior: 2, boundary: 2 });
    let work = bake(&scene, &request, &Silent).expect("nobody cancels").work;
    assert_eq!((work.pairs_tested, work.pairs_excluded), (counts.tested, counts.excluded));
    assert_eq!((work.pairs_registered, counts.registered), (9, 9));
}
