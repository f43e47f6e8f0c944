//! Visible surface by ray casting (Appel, "Some techniques for shading machine renderings of solids", AFIPS 1968).
//!
//! Two levels: a tree over the objects' world boxes, and one BVH a mesh, which all instances of the mesh share; rays are
//! pulled into local coordinates. Rectangles, boxes and analytic bodies are hit as they are, not tessellated. O(log n) a ray in
//! practice. Double precision, rounded: for pictures, not for proofs. Equal distances go to the lower object and face; so objects and triangles that
//! repeat others are left out.

mod body;

use std::{
    collections::{BTreeSet, HashMap},
    ops::Range,
};

use glam::DVec3;
use rayon::prelude::*;
use umbriel_bvh::{BoxTree, Ray, Steps, TriangleBvh};
use umbriel_geometry::Aabb;
use umbriel_scene::{Scene, first_alike};

use crate::{
    acceleration::{Acceleration, Choice, CostModel, Prepared, Sampled},
    local::LocalHit,
    view::View,
};
pub(crate) use body::into_triangle;
use body::{Body, LocalShape, triangle_hit};

/// A point of a surface that a ray meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceHit {
    /// Index into the scene's objects.
    pub object: usize,
    /// Face of the object: a triangle, a side of a box, a patch of an analytic body.
    pub face: usize,
    /// First parameter of the face.
    pub u: f64,
    /// Second parameter of the face.
    pub v: f64,
    /// How far along the ray, in lengths of its direction.
    pub distance: f64,
    /// Unit normal on the side where the face's winding says its front is, world coordinates.
    pub normal: DVec3,
}

/// A scene made ready for rays.
#[derive(Debug)]
pub struct RayCaster {
    tree: BoxTree,
    bodies: Vec<Body>,
}

impl RayCaster {
    /// Pixels along a side of a square whose rays share their way through the trees where there is one for each ([`RayCaster::nearest_of`]).
    pub const SQUARE: u32 = TILE;

    /// Builds the trees; meshes shared by several objects are built once. O(n log n) in the number of objects and of
    /// distinct triangles.
    pub fn new(scene: &Scene) -> Self {
        Self::of_objects(scene, &Vec::from_iter(0..scene.objects.len()))
    }

    /// Only of some objects, by their indices; no ray meets the others.
    ///
    /// # Panics
    /// If the scene does not have one of them.
    pub fn of_objects(scene: &Scene, objects: &[usize]) -> Self {
        let mut meshes = HashMap::new();
        let mut bodies: Vec<Body> = scene.objects.iter().map(|_| Body::nothing()).collect();
        let objects: BTreeSet<usize> = objects.iter().copied().collect();
        let firsts = first_alike(objects.iter().map(|&object| &scene.objects[object]));
        let is_first = firsts.iter().enumerate().map(|(number, &first)| number == first);
        for (&object, _) in objects.iter().zip(is_first).filter(|(_, is_first)| *is_first) {
            bodies[object] = Body::new(&scene.objects[object], &mut meshes);
        }
        let boxes: Vec<Aabb> = bodies.iter().map(|body| body.bounds).collect();
        Self { tree: BoxTree::build(&boxes), bodies }
    }

    /// Makes the meshes ready for the rays of a view, `rays_a_pixel` for each pixel; answers what was chosen for each mesh, and
    /// why. Answers do not change, and other rays stay possible. An earlier view is forgotten.
    ///
    /// O(triangles × levels) for each mesh whose octree is built.
    pub fn prepare(
        &mut self,
        view: &View,
        rays_a_pixel: u32,
        acceleration: Acceleration,
        costs: &CostModel,
    ) -> Vec<Choice> {
        self.bodies.iter_mut().for_each(|body| body.prepared = None);
        let choose = |(object, body): (usize, &Body)| {
            let LocalShape::Mesh(bvh) = &body.shape else { return None };
            let is_clear = acceleration == Acceleration::Auto && rays_of(view, rays_a_pixel) <= FEW;
            let sampled = if is_clear { Sampled::default() } else { sampled(view, rays_a_pixel, body, bvh) };
            Some(Choice::new(object, acceleration, bvh.mesh(), sampled, costs))
        };
        let mut choices: Vec<Choice> = self.bodies.par_iter().enumerate().filter_map(choose).collect();
        if acceleration == Acceleration::Auto {
            Choice::limit_octrees(&mut choices);
        }
        let prepare = |choice: Choice| {
            let body = &self.bodies[choice.object];
            match &body.shape {
                LocalShape::Mesh(bvh) => Prepared::new(choice, bvh, &body.to_local, &view.beam()),
                _ => (choice, None),
            }
        };
        let prepared: Vec<_> = choices.into_par_iter().map(prepare).collect();
        let keep = |(choice, prepared): (Choice, Option<Prepared>)| {
            self.bodies[choice.object].prepared = prepared;
            choice
        };
        prepared.into_iter().map(keep).collect()
    }

    /// The first surface that `ray` meets.
    pub fn nearest(&self, ray: &Ray) -> Option<SurfaceHit> {
        let mut best: Option<(usize, LocalHit)> = None;
        self.tree.for_each_near(ray, f64::INFINITY, |object, _, t_max| {
            let object = object as usize;
            let body = &self.bodies[object];
            let Some(hit) = body.nearest(&body.pulled(ray), t_max) else { return t_max };
            let wins = best.is_none_or(|(winner, so_far)| {
                hit.distance < so_far.distance || (hit.distance == so_far.distance && object < winner)
            });
            if wins {
                best = Some((object, hit));
            }
            t_max.min(hit.distance)
        });
        best.map(|(object, hit)| self.surface_hit(object, hit))
    }

    /// [`RayCaster::nearest`] of many rays. Sixteen that follow each other share their way through the trees, which pays where they go nearly the same
    /// way, as those of neighbouring pixels do. The answers are the same, but where surfaces of two objects coincide up to rounding either may be answered.
    pub fn nearest_of(&self, rays: &[Ray]) -> Vec<Option<SurfaceHit>> {
        let mut hits = Vec::with_capacity(rays.len());
        for rays in rays.chunks(BUNDLE) {
            let found = self.nearest_of_bundle(rays);
            hits.extend(
                found[..rays.len()].iter().map(|found| found.map(|(object, hit)| self.surface_hit(object, hit))),
            );
        }
        hits
    }

    /// The nearest hits of at most [`BUNDLE`] rays, with their objects.
    fn nearest_of_bundle(&self, rays: &[Ray]) -> [Option<(usize, LocalHit)>; BUNDLE] {
        let mut best = [None::<(usize, LocalHit)>; BUNDLE];
        let mut ends = [f64::INFINITY; BUNDLE];
        let mut bundle = Vec::with_capacity(BUNDLE);
        let enter = |bounds: &Aabb| {
            let met = rays.iter().enumerate().filter_map(|(lane, ray)| Some((ray.span(bounds)?.0, 1u32 << lane)));
            met.reduce(|(entry, lanes), (other, lane)| (entry.min(other), lanes | lane))
        };
        self.tree.for_each_entered(enter, f64::INFINITY, |object, (_, lanes), _| {
            let object = object as usize;
            let body = &self.bodies[object];
            bundle.clear();
            bundle.extend(lanes_of(lanes).map(|lane| (body.pulled(&rays[lane]), ends[lane])));
            let mut take = |lane: usize, hit: LocalHit| {
                let wins = best[lane].is_none_or(|(winner, so_far)| {
                    hit.distance < so_far.distance || (hit.distance == so_far.distance && object < winner)
                });
                if wins {
                    best[lane] = Some((object, hit));
                    ends[lane] = ends[lane].min(hit.distance);
                }
            };
            if let LocalShape::Mesh(bvh) = &body.shape
                && body.prepared.is_none()
            {
                let hits = lanes_of(lanes).zip(bvh.nearest_hits(&bundle));
                hits.for_each(|(lane, hit)| hit.into_iter().for_each(|hit| take(lane, triangle_hit(bvh, hit))));
            } else {
                let hits =
                    lanes_of(lanes).zip(&bundle).map(|(lane, (local, t_max))| (lane, body.nearest(local, *t_max)));
                hits.for_each(|(lane, hit)| hit.into_iter().for_each(|hit| take(lane, hit)));
            }
            ends[..rays.len()].iter().fold(0.0, |end, &other| end.max(other))
        });
        best
    }

    fn surface_hit(&self, object: usize, LocalHit { distance, face, u, v, normal }: LocalHit) -> SurfaceHit {
        let body = &self.bodies[object];
        let face = body.faces.as_ref().map_or(face, |faces| faces[face] as usize);
        SurfaceHit { object, face, u, v, distance, normal: body.world_normal(normal) }
    }

    /// What is seen at the middle of every pixel, row by row from the upper left; bands are cast in parallel.
    pub fn picture(&self, view: &View) -> Vec<Option<SurfaceHit>> {
        let band = |band: u32| {
            let mut hits = vec![None; rows_of(view, band).len() * view.width as usize];
            self.for_each_pixel(view, band, |(x, y), found| {
                let place = (y - band * TILE) as usize * view.width as usize + x as usize;
                hits[place] = found.map(|(object, hit)| self.surface_hit(object, hit));
            });
            hits
        };
        (0..view.height.div_ceil(TILE)).into_par_iter().flat_map_iter(band).collect()
    }

    /// At how many pixels' middles each object is seen, by the objects' indices; bands are cast in parallel.
    pub fn coverage(&self, view: &View) -> Vec<u64> {
        let count = |mut counts: Vec<u64>, band: u32| {
            self.for_each_pixel(view, band, |_, found| found.into_iter().for_each(|(object, _)| counts[object] += 1));
            counts
        };
        let none = || vec![0; self.bodies.len()];
        let sum = |a: Vec<u64>, b: Vec<u64>| a.into_iter().zip(b).map(|(a, b)| a + b).collect();
        (0..view.height.div_ceil(TILE)).into_par_iter().fold(none, count).reduce(none, sum)
    }

    /// Casts the rays of a band of a picture, square by square, and tells what each pixel's meets.
    fn for_each_pixel(&self, view: &View, band: u32, mut tell: impl FnMut((u32, u32), Option<(usize, LocalHit)>)) {
        let eye = view.rays();
        let mut rays = Vec::with_capacity(BUNDLE);
        for left in (0..view.width).step_by(TILE as usize) {
            let pixels = tile(view, rows_of(view, band), left);
            rays.clear();
            rays.extend(pixels.clone().map(|pixel| eye.of_pixel(pixel)));
            pixels.zip(self.nearest_of_bundle(&rays)).for_each(|(pixel, found)| tell(pixel, found));
        }
    }
}

/// The rows of a band of a picture: [`TILE`], fewer at its end.
fn rows_of(view: &View, band: u32) -> Range<u32> {
    band * TILE..view.height.min((band + 1) * TILE)
}

/// Rays that share their way through the trees, and the side of a square of pixels that has so many.
const BUNDLE: usize = TriangleBvh::BUNDLE;
const TILE: u32 = 4;

const _: () = assert!((TILE * TILE) as usize == BUNDLE);

/// The pixels of a square in these rows that begins `left`.
fn tile(view: &View, rows: Range<u32>, left: u32) -> impl Iterator<Item = (u32, u32)> + Clone {
    let columns = left..view.width.min(left + TILE);
    rows.flat_map(move |y| columns.clone().map(move |x| (x, y)))
}

/// The numbers of the bits that are set.
fn lanes_of(mut bits: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = (bits != 0).then_some(bits.trailing_zeros() as usize)?;
        bits &= bits - 1;
        Some(lane)
    })
}

/// Rays of a whole picture for which nothing that must be built can pay, whatever the mesh: so few take a BVH less than a millisecond or two, of which a
/// sample alone would take a tenth.
const FEW: u64 = 64 * 64;

/// All rays of a picture.
fn rays_of(view: &View, rays_a_pixel: u32) -> u64 {
    u64::from(view.width) * u64::from(view.height) * u64::from(rays_a_pixel)
}

/// How many of the picture's rays meet a box, and what they look at in the BVH inside, by one of 128 of them: no more than two thousand, or 36,864
/// where they are a good part of the picture, since samples of a few hundred are off by a tenth.
fn sampled(view: &View, rays_a_pixel: u32, body: &Body, bvh: &TriangleBvh) -> Sampled {
    const EACH: u64 = 128;
    let rays = rays_of(view, rays_a_pixel);
    let [coarse, fine] = [12, 48].map(|most| (rays / (EACH * BUNDLE as u64)).isqrt().clamp(2, most) as u32);
    let few = sampled_on(coarse, view, body, bvh);
    let is_large = 16 * few.rays >= u64::from(view.width) * u64::from(view.height);
    let pixels = if is_large && fine > coarse { sampled_on(fine, view, body, bvh) } else { few };
    Sampled { rays: pixels.rays * u64::from(rays_a_pixel), ..pixels }
}

/// By a grid of so many tiles each way; one ray a pixel.
fn sampled_on(grid: u32, view: &View, body: &Body, bvh: &TriangleBvh) -> Sampled {
    let at =
        |n: u32, pixels: u32| (u64::from(2 * n + 1) * u64::from(pixels) / u64::from(2 * grid)) as u32 / TILE * TILE;
    let eye = view.rays();
    let of_tile = |n: u32| {
        let top = at(n / grid, view.height);
        let pixels = tile(view, top..view.height.min(top + TILE), at(n % grid, view.width));
        let rays: Vec<Ray> = pixels.map(|pixel| eye.of_pixel(pixel)).collect();
        let met = rays.iter().filter(|ray| ray.span(&body.bounds).is_some());
        let local: Vec<(Ray, f64)> = met.map(|ray| (body.pulled(ray), f64::INFINITY)).collect();
        (bvh.nearest_hits_steps(&local), local.len(), rays.len())
    };
    let sum = |a: (Steps, usize, usize), b: (Steps, usize, usize)| (a.0 + b.0, a.1 + b.1, a.2 + b.2);
    let tiles = (0..grid * grid).into_par_iter().map(of_tile);
    let (steps, sent, cast) = tiles.reduce(|| (Steps::default(), 0, 0), sum);
    let rays = u64::from(view.width) * u64::from(view.height) * sent as u64 / cast.max(1) as u64;
    Sampled { rays, steps, sent }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{DAffine3, DQuat};
    use umbriel_geometry::{Analytic, Cuboid, Mesh, Placement, Rectangle};
    use umbriel_scene::{Camera, Object, Projection, Shape, Sides};

    use super::*;

    fn object(name: &str, shape: Shape, map: DAffine3) -> Object {
        let placement = Placement::new(map).expect("regular");
        Object::new(name.into(), shape, placement, Sides::Auto).expect("a body")
    }

    fn scene(objects: Vec<Object>) -> Scene {
        Scene { objects: objects.into(), ..Default::default() }
    }

    /// A unit square of two triangles in the plane z = 0, seen from +z.
    fn square() -> Shape {
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        Shape::Mesh(Arc::new(Mesh::new(positions, vec![[0, 1, 2], [0, 2, 3]]).expect("a mesh")))
    }

    #[test]
    fn what_is_given_again_is_seen_once() {
        // The second half of the square is triangle 3; the first one is there thrice, from other corners.
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let triangles = vec![[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 3]];
        let mesh = || Shape::Mesh(Arc::new(Mesh::new(positions.clone(), triangles.clone()).expect("a mesh")));
        let at = |z: f64| DAffine3::from_translation(DVec3::Z * z);
        let objects = vec![
            object("back", mesh(), at(-1.0)),
            object("front", mesh(), at(0.0)),
            object("again", mesh(), at(0.0)),
            object("square", square(), at(0.0)),
        ];
        let seen = |caster: &RayCaster, x: f64, y: f64| {
            let ray = Ray::new(DVec3::new(x, y, 2.0), DVec3::NEG_Z);
            let [alone, bundled] = [caster.nearest(&ray), caster.nearest_of(&[ray])[0]];
            assert_eq!(alone, bundled);
            alone.map(|hit| (hit.object, hit.face, hit.distance))
        };
        let scene = scene(objects);
        let whole = RayCaster::new(&scene);
        assert_eq!(seen(&whole, 0.75, 0.25), Some((1, 0, 2.0)));
        assert_eq!(seen(&whole, 0.25, 0.75), Some((1, 3, 2.0)));
        // Of objects without the first one, the second one stands for it, whatever their order.
        let others = RayCaster::of_objects(&scene, &[3, 2, 2]);
        assert_eq!(seen(&others, 0.25, 0.75), Some((2, 3, 2.0)));
    }

    #[test]
    fn a_sphere_and_a_box_are_seen_where_they_are() {
        let sphere = Shape::from(Analytic::Sphere { radius: 1.0 });
        let cuboid = Shape::Cuboid(Cuboid { size: [2.0, 2.0, 2.0] });
        let caster = RayCaster::new(&scene(vec![
            object("sphere", sphere, DAffine3::from_translation(DVec3::new(-2.0, 0.0, 0.0))),
            object("box", cuboid, DAffine3::from_translation(DVec3::new(2.0, 0.0, 0.0))),
        ]));
        let camera = Camera {
            eye: DVec3::new(0.0, 0.0, 10.0),
            target: DVec3::ZERO,
            up: DVec3::Y,
            projection: Projection::Orthographic { height: 4.0 },
        };
        let (width, height) = (80, 40);
        let picture = caster.picture(&View { camera, width, height });
        for (index, hit) in picture.iter().enumerate() {
            let at = |pixel: usize, pixels: u32| (pixel as f64 + 0.5 - 0.5 * f64::from(pixels)) / 10.0;
            let (x, y) = (at(index % width as usize, width), -at(index / width as usize, height));
            let expected = if (x + 2.0).hypot(y) < 1.0 {
                Some((0, 10.0 - (1.0 - (x + 2.0).powi(2) - y * y).sqrt()))
            } else if (x - 2.0).abs() < 1.0 && y.abs() < 1.0 {
                Some((1, 9.0))
            } else {
                None
            };
            assert_eq!(hit.map(|hit| hit.object), expected.map(|(object, _)| object), "at ({x}, {y})");
            if let (Some(hit), Some((_, distance))) = (hit, expected) {
                assert!((hit.distance - distance).abs() < 1e-12);
                assert!(hit.normal.z > 0.0 && (hit.normal.length() - 1.0).abs() < 1e-12);
            }
        }
        let count = |object| picture.iter().flatten().filter(|hit| hit.object == object).count() as u64;
        assert_eq!(caster.coverage(&View { camera, width, height }), [count(0), count(1)]);
        let away = Camera { target: DVec3::new(0.0, 0.0, 20.0), ..camera };
        assert_eq!(caster.coverage(&View { camera: away, width, height }), [0, 0]);
        let middle = picture[20 * width as usize + 60].expect("the box");
        assert_eq!((middle.face, middle.normal), (5, DVec3::Z));
    }

    #[test]
    fn instances_share_a_mesh_and_keep_their_own_place() {
        let shape = square();
        let turned = DAffine3::from_rotation_translation(
            DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2),
            DVec3::new(0.0, 0.0, 5.0),
        );
        let mirrored = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        let objects = [DAffine3::from_scale(DVec3::new(2.0, 4.0, 1.0)), turned, mirrored];
        let caster = RayCaster::new(&scene(objects.map(|map| object("o", shape.clone(), map)).to_vec()));
        let shared = |body: &Body| match &body.shape {
            LocalShape::Mesh(bvh) => Arc::as_ptr(bvh),
            _ => std::ptr::null(),
        };
        assert!(caster.bodies.iter().all(|body| shared(body) == shared(&caster.bodies[0])));
        let ray = Ray::new(DVec3::new(1.5, 1.0, 3.0), DVec3::NEG_Z);
        let hit = caster.nearest(&ray).expect("the stretched one");
        assert_eq!((hit.object, hit.face, hit.distance, hit.u, hit.v), (0, 0, 3.0, 0.5, 0.25));
        let hit = caster.nearest(&Ray::new(DVec3::new(3.0, 0.75, 4.5), DVec3::NEG_X)).expect("the turned one");
        assert_eq!((hit.object, hit.face, hit.distance), (1, 1, 3.0));
        assert!((hit.normal - DVec3::X).length() < 1e-12);
        let hit = caster.nearest(&Ray::new(DVec3::new(-0.75, 0.5, 3.0), DVec3::NEG_Z)).expect("the mirrored one");
        assert_eq!((hit.object, hit.normal), (2, DVec3::Z), "a mirrored front stays in front");
        assert_eq!(caster.nearest(&Ray::new(DVec3::new(-1.5, 0.5, 3.0), DVec3::NEG_Z)), None);
    }

    #[test]
    fn the_nearer_body_hides_the_farther_one_at_any_scale() {
        for scale in [2.0f64.powi(-40), 1.0, 2.0f64.powi(40)] {
            let sphere = Shape::from(Analytic::Sphere { radius: scale });
            let floor = Shape::Rectangle(Rectangle { size: [8.0 * scale; 2] });
            let above = DAffine3::from_translation(DVec3::new(0.0, 2.0 * scale, 0.0));
            let caster = RayCaster::new(&scene(vec![
                object("floor", floor, DAffine3::IDENTITY),
                object("sphere", sphere, above),
            ]));
            let down =
                |x: f64| caster.nearest(&Ray::new(DVec3::new(x, 9.0, 0.0) * scale, DVec3::NEG_Y)).expect("a hit");
            assert_eq!((down(0.5).object, down(2.0).object), (1, 0));
            assert_eq!((down(2.0).u, down(2.0).v, down(2.0).distance), (0.75, 0.5, 9.0 * scale));
            let up = caster.nearest(&Ray::new(DVec3::new(0.0, 2.0, 0.0) * scale, DVec3::Y)).expect("from inside");
            assert_eq!((up.object, up.face, up.distance), (1, 3, scale));
        }
    }

    #[test]
    fn hulls_look_outward_mirrored_or_not() {
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let hull = Shape::Convex(Arc::new(umbriel_geometry::Convex::new(corners.to_vec()).expect("a corner of space")));
        let hit = |map: DAffine3| {
            let caster = RayCaster::new(&scene(vec![object("hull", hull.clone(), map)]));
            caster.nearest(&Ray::new(DVec3::new(0.125, 0.25, -3.0), DVec3::Z)).expect("its foot")
        };
        let plain = hit(DAffine3::IDENTITY);
        let mirrored = DAffine3::from_cols_array(&[0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
        let other = hit(mirrored);
        assert_eq!((plain.normal, other.normal), (DVec3::NEG_Z, DVec3::NEG_Z));
        assert_eq!((plain.face, plain.distance), (other.face, other.distance));
    }
}
