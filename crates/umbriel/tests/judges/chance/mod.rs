//! Random scenes full of exact coincidences.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use umbriel_geometry::{Analytic, Convex, LightSource, Placement};
use umbriel_scene::{Object, Scene, Shape, Sides};

use crate::oracle::{
    Oracle,
    dice::Dice,
    fixtures::{analytic, cuboid, elsewhere, features, mesh, rectangle, scene, sphere, tricky_light},
};

/// A point on the coarse or the fine grid.
fn corner(dice: &mut Dice) -> [f64; 3] {
    if dice.one_in(4) { dice.grid_point(4, 0.5) } else { dice.grid_point(2, 1.0) }
}

/// Any triangles over a few corners: some twice, some reversed, some without area, several at one edge.
fn soup(dice: &mut Dice) -> Shape {
    let positions: Vec<[f64; 3]> = (0..3 + dice.below(4)).map(|_| corner(dice)).collect();
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    for _ in 0..1 + dice.below(6) {
        let last = triangles.last().copied().unwrap_or([0, 1, 2]);
        triangles.push(match dice.below(6) {
            0 => last,
            1 => [last[1], last[0], last[2]],
            // A neighbour at the last one's first edge, the right way round.
            2 | 3 => [last[1], last[0], dice.below(positions.len() as u64) as u32],
            _ => std::array::from_fn(|_| dice.below(positions.len() as u64) as u32),
        });
    }
    shaken(positions, &triangles, dice)
}

/// A closed tetrahedron, flat or inside out at times.
fn tetrahedron(dice: &mut Dice) -> Shape {
    let positions: Vec<[f64; 3]> = (0..4).map(|_| corner(dice)).collect();
    shaken(positions, &[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], dice)
}

/// A box of triangles, its sides cut along either diagonal; some triangles may be missing, turned or doubled.
fn crate_of_triangles(dice: &mut Dice) -> Shape {
    let (low, size) = (corner(dice), [0; 3].map(|_| dice.pick(&[0.5, 1.0, 2.0, 3.0])));
    let at = |i: usize| std::array::from_fn(|k| low[k] + if i >> k & 1 == 0 { 0.0 } else { size[k] });
    let mut triangles = Vec::new();
    for [a, b, c, d] in umbriel_geometry::Cuboid::FACES {
        triangles.extend(if dice.one_in(2) { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] });
    }
    if dice.one_in(3) {
        for _ in 0..1 + dice.below(3) {
            let place = dice.index(triangles.len());
            match dice.below(3) {
                0 => drop(triangles.remove(place)),
                1 => triangles[place].swap(0, 1),
                _ => triangles.push(triangles[place]),
            }
        }
    }
    shaken((0..8).map(at).collect(), &triangles, dice)
}

/// A sheet of eight triangles over 3 × 3 corners that are moved about, so that it folds over itself.
fn sheet(dice: &mut Dice) -> Shape {
    let height = dice.grid(2, 1.0);
    let mut positions = Vec::new();
    for i in 0..3 {
        for k in 0..3 {
            let mut at = [f64::from(i) - 1.0, height, f64::from(k) - 1.0];
            match dice.below(4) {
                0 => at[1] += dice.grid(2, 0.5),
                1 => at = std::array::from_fn(|axis| at[axis] + dice.grid(1, 1.0)),
                _ => {}
            }
            positions.push(at);
        }
    }
    let quads = [0, 1, 3, 4].map(|first| [first, first + 1, first + 4, first + 3]);
    let halves = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect::<Vec<_>>();
    shaken(positions, &halves, dice)
}

/// A mesh, at times with some coordinates an ulp or two off.
fn shaken(mut positions: Vec<[f64; 3]>, triangles: &[[u32; 3]], dice: &mut Dice) -> Shape {
    if dice.one_in(5) {
        positions.iter_mut().flatten().for_each(|coordinate| *coordinate = dice.nudged(*coordinate));
    }
    mesh(&positions, triangles)
}

fn any_shape(dice: &mut Dice) -> Shape {
    let mut size = || dice.pick(&[0.5, 1.0, 1.0, 2.0, 2.0, 3.0, 4.0]);
    let [a, b, c] = [size(), size(), size()];
    match dice.below(12) {
        0 | 1 => soup(dice),
        2 => tetrahedron(dice),
        3 => crate_of_triangles(dice),
        4 => sheet(dice),
        5 => rectangle(a, b),
        6 | 7 => cuboid(a, b, c),
        8 => sphere(a * 0.5),
        9 => any_hull(dice),
        _ => analytic(any_analytic(dice, a * 0.5, b * 0.5, c)),
    }
}

/// A hull of few points on the grid, many of them in common planes.
fn any_hull(dice: &mut Dice) -> Shape {
    loop {
        let points: Vec<[f64; 3]> = (0..4 + dice.below(5)).map(|_| corner(dice)).collect();
        if let Ok(convex) = Convex::new(points) {
            return Shape::Convex(convex.into());
        }
    }
}

fn any_analytic(dice: &mut Dice, radius: f64, other: f64, height: f64) -> Analytic {
    match dice.below(8) {
        0 => Analytic::Ellipsoid { radii: [radius, height * 0.5, other] },
        1 => Analytic::Cylinder { radius, height },
        2 => Analytic::Cone { radius, height },
        3 => Analytic::Frustum { bottom_radius: radius, top_radius: other, height },
        4 => Analytic::Capsule { radius, height },
        5 => Analytic::Paraboloid { radius, height },
        6 if dice.one_in(2) => {
            let matrix = std::array::from_fn(|_| std::array::from_fn(|_| dice.grid(2, 0.5)));
            let within = [[-radius, -height * 0.5, -other], [radius, height * 0.5, other]];
            Analytic::Quadric { matrix, within }
        }
        6 => Analytic::Hyperboloid { waist_radius: radius.min(other), end_radius: radius.max(other), height },
        _ => Analytic::Disk { radius },
    }
}

/// A placement that often keeps coordinates short: moved, mirrored, axes exchanged, sheared, stretched; seldom turned.
fn any_map(dice: &mut Dice) -> DAffine3 {
    let step = dice.pick(&[1.0, 0.5, 0.25]);
    let translation = DVec3::from_array(dice.grid_point(2, step));
    let sign = |dice: &mut Dice| if dice.one_in(2) { -1.0 } else { 1.0 };
    let matrix3 = match dice.below(8) {
        0 => DMat3::from_diagonal(DVec3::new(sign(dice), sign(dice), sign(dice))),
        1 | 2 => {
            let axes = dice.pick(&[[0, 1, 2], [1, 2, 0], [2, 0, 1], [1, 0, 2], [0, 2, 1], [2, 1, 0]]);
            DMat3::from_cols(DVec3::AXES[axes[0]], DVec3::AXES[axes[1]] * sign(dice), DVec3::AXES[axes[2]])
        }
        3 => {
            let column = |dice: &mut Dice| DVec3::from_array(dice.grid_point(2, 0.5));
            DMat3::from_cols(column(dice), column(dice), column(dice))
        }
        4 if dice.one_in(2) => {
            let part = |dice: &mut Dice| dice.float(-1.0, 1.0);
            DMat3::from_quat(DQuat::from_xyzw(part(dice), part(dice), part(dice), 0.5).normalize())
        }
        _ => DMat3::IDENTITY,
    };
    DAffine3 { matrix3, translation }
}

fn any_object(number: u64, dice: &mut Dice) -> Object {
    let sides = dice.pick(&[Sides::Auto, Sides::Auto, Sides::Auto, Sides::One, Sides::Two]);
    loop {
        let (shape, placement) = (any_shape(dice), Placement::new(any_map(dice)));
        // Singular matrices and quadrics that are the same everywhere are refused.
        if let Some(object) = placement.ok().and_then(|p| Object::new(format!("{number}"), shape, p, sides).ok()) {
            return object;
        }
    }
}

/// One more object of a shape that is there: of a mesh or hull an instance.
fn any_instance(number: u64, shape: &Shape, dice: &mut Dice) -> Option<Object> {
    let placement = Placement::new(any_map(dice)).ok()?;
    Object::new(format!("{number}"), shape.clone(), placement, Sides::Auto).ok()
}

/// One to five objects, at times two of one shape; seldom tiny, huge or far away.
pub(crate) fn any_scene(dice: &mut Dice) -> Scene {
    let mut objects: Vec<Object> = (0..1 + dice.below(4)).map(|number| any_object(number, dice)).collect();
    if dice.one_in(4) {
        let number = objects.len();
        objects.extend(any_instance(number as u64, &objects[dice.index(number)].shape.clone(), dice));
    }
    match dice.below(16) {
        0 => elsewhere(&objects, 2f64.powi(dice.pick(&[-60, -20, 40])), DVec3::ZERO),
        1 => {
            elsewhere(&objects, 1.0, DVec3::from_array(dice.pick(&[[1e6 + 0.1, -3e5, 7e5 / 3.0], [4096.0, 0.0, 0.0]])))
        }
        2 => elsewhere(&objects, 1.0 / 3.0, DVec3::splat(0.1)),
        _ => scene(objects),
    }
}

/// A light on the grid, on a corner, in the middle of an edge, on a face, or one that grazes.
pub(crate) fn any_light(scene: &Scene, dice: &mut Dice) -> LightSource {
    let features = features(scene);
    let on_face = |dice: &mut Dice| {
        let oracle = Oracle::new(scene);
        // A quadric may have no point at all in its box.
        for _ in 0..50 {
            let object = dice.index(scene.objects.len());
            let (face, parameters) = (dice.index(scene.objects[object].face_count()), dice.parameters(true));
            if oracle.has_point(object, face, parameters) {
                return oracle.point(object, face, parameters).approximate();
            }
        }
        dice.grid_point(3, 1.0)
    };
    loop {
        let light = match dice.below(10) {
            0 | 1 => LightSource::point(dice.grid_point(3, 1.0)),
            2 => LightSource::point(dice.grid_point(6, 0.5)),
            3 | 4 => LightSource::sun(dice.grid_point(1, 1.0)),
            5 => LightSource::sun(dice.grid_point(3, 1.0)),
            6 => LightSource::point(dice.pick(&features)),
            7 => LightSource::point(on_face(dice)),
            _ => {
                let x = on_face(dice);
                Ok(tricky_light(dice, x, &features))
            }
        };
        if let Ok(light) = light {
            return light;
        }
    }
}
