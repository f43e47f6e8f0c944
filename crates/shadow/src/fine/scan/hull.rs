//! The outline of a convex solid: the convex hull of its corners' images.
//!
//! Source: monotone chains (Andrew 1979), after corners well inside of the octagon of the extreme ones are left out (Akl and Toussaint 1978).
//! Exact on images. Cost: some nanoseconds a corner, O(n log n) for those that are left.

use super::view::Image;

/// Corners from which on leaving some out pays.
const MANY: usize = 32;

/// Above the rounding error of a cross product of differences of images, each below 2^31: three roundings of at most 2^62.
const CROSS_ERROR: f64 = 4096.0;

/// The corners of the hull of images, counter-clockwise, none of them on a line with its neighbours; one or two where all lie
/// at a point or on a line.
#[inline(always)]
pub(super) fn hull(images: &[Image], storage: &mut Vec<[i32; 2]>, outline: &mut Vec<[i32; 2]>) {
    storage.clear();
    if images.len() < MANY {
        storage.extend(images.iter().map(|image| [image.x, image.y]));
    } else {
        keep_outer(images, storage);
    }
    storage.sort_unstable();
    storage.dedup();
    outline.clear();
    if storage.len() < 3 {
        return outline.extend_from_slice(storage);
    }
    for &point in storage.iter() {
        push(outline, 0, point);
    }
    let start = outline.len() - 1;
    for &point in storage[..storage.len() - 1].iter().rev() {
        push(outline, start, point);
    }
    outline.pop();
}

/// Adds a point to the chain that begins at `start`, which keeps turning left.
#[inline(always)]
fn push(chain: &mut Vec<[i32; 2]>, start: usize, point: [i32; 2]) {
    while let [.., a, b] = chain[start..] {
        if cross(a, b, point) > 0 {
            break;
        }
        chain.pop();
    }
    chain.push(point);
}

/// Twice the area of a triangle, positive where it turns left. Coordinates differ by less than 2^31.
#[inline(always)]
fn cross([ax, ay]: [i32; 2], [bx, by]: [i32; 2], [cx, cy]: [i32; 2]) -> i64 {
    let away = |to: i32, from: i32| i64::from(to) - i64::from(from);
    away(bx, ax) * away(cy, ay) - away(by, ay) * away(cx, ax)
}

/// The images that are not inside of the octagon of the extreme ones.
#[inline(always)]
fn keep_outer(images: &[Image], kept: &mut Vec<[i32; 2]>) {
    let octagon = extremes(images);
    for image in images {
        let point = [f64::from(image.x), f64::from(image.y)];
        let mut least = f64::INFINITY;
        for k in 0..8 {
            let (a, b) = (octagon[k], octagon[(k + 1) % 8]);
            let left = (b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0]);
            // A corner that is two extremes at once has no side.
            least = if a == b { least } else { least.min(left) };
        }
        // No side at all where all images are one.
        if least <= CROSS_ERROR || least == f64::INFINITY {
            kept.push([image.x, image.y]);
        }
    }
}

/// The images farthest in eight directions, counter-clockwise.
#[inline(always)]
fn extremes(images: &[Image]) -> [[f64; 2]; 8] {
    const DIRECTIONS: [[f64; 2]; 8] =
        [[1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [-1.0, 1.0], [-1.0, 0.0], [-1.0, -1.0], [0.0, -1.0], [1.0, -1.0]];
    let mut most = [f64::NEG_INFINITY; 8];
    let mut octagon = [[0.0; 2]; 8];
    for image in images {
        let point = [f64::from(image.x), f64::from(image.y)];
        for k in 0..8 {
            let far = DIRECTIONS[k][0] * point[0] + DIRECTIONS[k][1] * point[1];
            let is_farther = far > most[k];
            most[k] = if is_farther { far } else { most[k] };
            octagon[k] = if is_farther { point } else { octagon[k] };
        }
    }
    octagon
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn hull_of(points: &[[i32; 2]]) -> Vec<[i32; 2]> {
        let images: Vec<Image> = points.iter().map(|&[x, y]| Image { x, y, depth: 0.0 }).collect();
        let mut outline = vec![[7, 7]];
        hull(&images, &mut vec![[9, 9]], &mut outline);
        outline
    }

    proptest! {
        /// Coarse grids bring equal points and points on lines; far ones bring large products.
        #[test]
        fn all_images_are_to_the_left_of_all_edges(
            points in prop::collection::vec([-6i32..=6, -6i32..=6], 1..90),
            step in prop_oneof![Just(1), Just(1 << 26)],
        ) {
            let points: Vec<[i32; 2]> = points.into_iter().map(|point| point.map(|x| x * step + x)).collect();
            let outline = hull_of(&points);
            prop_assert!(outline.iter().all(|corner| points.contains(corner)));
            let next = |k: usize| outline[(k + 1) % outline.len()];
            for (k, &corner) in outline.iter().enumerate() {
                prop_assert!(points.iter().all(|&point| cross(corner, next(k), point) >= 0));
                prop_assert!(outline.len() < 3 || cross(corner, next(k), next(k + 1)) > 0);
            }
            prop_assert!(!outline.is_empty());
            let is_flat = points.iter().all(|&point| points.iter().all(|&other| cross(points[0], point, other) == 0));
            prop_assert_eq!(outline.len() < 3, is_flat);
        }
    }

    #[test]
    fn many_images_at_one_place_are_a_point() {
        assert_eq!(hull_of(&[[7, -3]; 42]), [[7, -3]]);
    }
}
