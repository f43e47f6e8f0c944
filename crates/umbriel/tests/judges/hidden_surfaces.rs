//! All methods of hidden surfaces on all fixtures: no pixel differs. `cargo xtask pictures` does the same with large pictures.

use crate::stored;
use umbriel::{
    io::{LoadOptions, load},
    scene::{Camera, Projection, Scene},
    visibility::{
        View,
        hidden_surface::{DepthBuffer, DepthSort, HiddenSurface, RayCasting, RayTree, ScanLine, Shot, Warnock, draw},
    },
};

/// The scene's own camera, two perspectives, and one along an axis in parallel, where edges run through many pixel centres.
fn views(scene: &Scene) -> Vec<View> {
    let (width, height) = (72, 54);
    let from = |turn, elevation| View::around(scene, turn, elevation, width, height);
    let level = from(0.0, 0.0);
    let projection = Projection::Orthographic { height: 0.5 * (level.camera.eye - level.camera.target).length() };
    let around = [from(30.0, 35.0), from(-130.0, 8.0), View { camera: Camera { projection, ..level.camera }, ..level }];
    let own = scene.camera.map(|_| View::of(scene, width, height));
    own.into_iter().chain(around).collect()
}

#[test]
fn all_methods_show_the_same_faces_of_all_fixtures() {
    let mut covered = 0;
    for path in stored::scenes() {
        let scene = load(&path, &LoadOptions::default()).expect("a fixture").scene;
        for view in views(&scene) {
            let shot = Shot::new(&scene, &view).expect("a shot");
            let methods: [Box<dyn HiddenSurface>; 6] = [
                Box::new(RayCasting::new(&shot, RayTree::Boxes)),
                Box::new(RayCasting::new(&shot, RayTree::Octree)),
                Box::new(DepthBuffer::default()),
                Box::new(ScanLine::default()),
                Box::new(Warnock::default()),
                Box::new(DepthSort::default()),
            ];
            let pictures =
                methods.iter().map(|method| (method.name(), draw(method.as_ref(), &shot).0)).collect::<Vec<_>>();
            covered += pictures[0].1.covered();
            for (name, picture) in &pictures[1..] {
                assert_eq!(picture.differences(&pictures[0].1), 0, "{name}, {}, {view:?}", path.display());
            }
        }
    }
    assert!(covered > 10_000, "the cameras look past the scenes");
}
