//! Light space: where shadow rays are points and nearer means nearer to the light.
//!
//! A sun has one frame: the scene is sheared along the light onto the coordinate plane most across it, u = x − z·lx/lz,
//! v = y − z·ly/lz, depth = −z (for a light that comes mostly along z). A point light has six, one for each face of a
//! cube round it: u = x/z, v = y/z, depth = z, with x, y, z relative to the light; so a light inside the scene is no
//! special case. Points become points, and what must be looked at for a receiver is what overlaps its rectangle and is
//! not deeper.
//!
//! Guarantee: a returned box holds the image of every point of the body that the frame sees, rounding included.

use umbriel_geometry::{Aabb, Approx, LightSource, Point};

use glam::DVec3;

/// One view from the light; boxes have x = u, y = v, z = depth.
#[derive(Clone, Copy, Debug)]
pub(crate) enum LightFrame {
    /// Parallel light: `across` are the two other axes, `slope` the shear along each.
    Sun { axis: usize, sign: f64, slope: [Approx; 2] },
    /// One of six frusta: `sign` times the axis points into it.
    Frustum { light: DVec3, axis: usize, sign: f64 },
}

impl LightFrame {
    /// All frames of a light.
    pub(crate) fn all(light: &LightSource) -> Vec<Self> {
        let xyz = light.xyz();
        if light.is_sun() {
            return vec![Self::of_sun(xyz, xyz.abs().max_position())];
        }
        let sides = (0..3).flat_map(|axis| [-1.0, 1.0].map(|sign| (axis, sign)));
        sides.map(|(axis, sign)| Self::Frustum { light: xyz, axis, sign }).collect()
    }

    /// Further frames of a sun that comes as much along other axes as along the one that [`LightFrame::all`] takes.
    pub(crate) fn ties(light: &LightSource) -> Vec<Self> {
        let xyz = light.xyz();
        let first = xyz.abs().max_position();
        let is_tie = |&axis: &usize| axis != first && xyz[axis].abs() == xyz[first].abs();
        let is_sun = light.is_sun();
        (0..3).filter(|_| is_sun).filter(is_tie).map(|axis| Self::of_sun(xyz, axis)).collect()
    }

    /// Of a sun in this direction, sheared onto the plane across an axis.
    fn of_sun(xyz: DVec3, axis: usize) -> Self {
        let along = Approx::exact(xyz[axis]);
        let slope = [1, 2].map(|k| Approx::exact(xyz[(axis + k) % 3]).divided_by(along));
        Self::Sun { axis, sign: xyz[axis].signum(), slope }
    }

    /// The light-space box of the convex hull of `points`; `None` when the frame sees nothing of it.
    pub(crate) fn bounds(&self, points: &[Point]) -> Option<Aabb> {
        match *self {
            Self::Sun { axis, sign, slope } => {
                let image = |point: &Point| {
                    let c = point.coordinates();
                    let flat = [0, 1].map(|k| c[(axis + k + 1) % 3] - c[axis] * slope[k]);
                    let depth = c[axis] * Approx::exact(-sign);
                    [flat[0], flat[1], depth]
                };
                Some(points.iter().fold(Aabb::EMPTY, |bounds, point| bounds.union(outward(&image(point)))))
            }
            Self::Frustum { light, axis, sign } => frustum_bounds(points, light, axis, sign),
        }
    }
}

/// The box of a hull in one of the six frusta, |x| ≤ z and |y| ≤ z.
fn frustum_bounds(points: &[Point], light: DVec3, axis: usize, sign: f64) -> Option<Aabb> {
    let light = Point::exact(light).coordinates();
    let local = points.iter().map(|point| {
        let c = point.coordinates();
        let z = (c[axis] - light[axis]) * Approx::exact(sign);
        [c[(axis + 1) % 3] - light[(axis + 1) % 3], c[(axis + 2) % 3] - light[(axis + 2) % 3], z]
    });
    // Beyond one of the frustum's five planes as a whole?
    let mut beyond = [true; 5];
    let mut in_front = true;
    let mut bounds = Aabb::EMPTY;
    for [x, y, z] in local {
        let outside = [z, z - x, z + x, z - y, z + y].map(|distance| distance.upper() < 0.0);
        beyond = std::array::from_fn(|plane| beyond[plane] && outside[plane]);
        in_front &= z.lower() > 0.0;
        bounds = bounds.union(if in_front {
            outward(&[x.divided_by(z), y.divided_by(z), z])
        } else {
            Aabb { min: DVec3::new(-1.0, -1.0, z.lower()), max: DVec3::new(1.0, 1.0, z.upper()) }
        });
    }
    if beyond.contains(&true) {
        return None;
    }
    let window = DVec3::new(1.0, 1.0, f64::INFINITY);
    let floor = DVec3::new(-1.0, -1.0, 0.0);
    // A hull that reaches behind the light can appear anywhere in the window.
    let (min, max) =
        if in_front { (bounds.min, bounds.max) } else { (floor.with_z(bounds.min.z), window.with_z(bounds.max.z)) };
    let clipped = Aabb { min: min.max(floor), max: max.min(window) };
    (!clipped.is_empty()).then_some(clipped)
}

fn outward(image: &[Approx; 3]) -> Aabb {
    Aabb { min: DVec3::from_array(image.map(Approx::lower)), max: DVec3::from_array(image.map(Approx::upper)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(corners: [[f64; 3]; 3]) -> [Point<'static>; 3] {
        corners.map(|corner| Point::exact(DVec3::from_array(corner)))
    }

    #[test]
    fn points_on_one_shadow_ray_share_their_place() {
        let sun = LightSource::sun([0.3, -1.0, 0.2]).expect("a sun");
        let frame = LightFrame::all(&sun)[0];
        let low = DVec3::new(1.0, 2.0, 3.0);
        let high = low + DVec3::new(-0.3, 1.0, -0.2) * 2.0;
        let [low, high] = [low, high].map(|p| frame.bounds(&[Point::exact(p)]).expect("seen"));
        assert!((low.center() - high.center()).truncate().length() < 1e-14);
        assert!(high.max.z < low.min.z, "nearer to the light is less deep");
    }

    #[test]
    fn every_direction_is_seen_by_a_frustum() {
        let lamp = LightSource::point([1.0, 2.0, 3.0]).expect("a lamp");
        let frames = LightFrame::all(&lamp);
        let around = triangle([[9.0, 1.0, 3.0], [-5.0, 1.5, 12.0], [-5.0, 1.2, -9.0]]);
        let seen = frames.iter().filter(|frame| frame.bounds(&around).is_some()).count();
        assert!(seen >= 5, "a triangle under the lamp fills the horizon");
        let far = triangle([[9.0, 2.0, 3.0], [9.0, 2.5, 3.0], [9.0, 2.0, 3.5]]);
        let seen: Vec<usize> = (0..6).filter(|&k| frames[k].bounds(&far).is_some()).collect();
        assert_eq!(seen, [1], "only +x");
    }
}
