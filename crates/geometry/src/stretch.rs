//! How much linear maps stretch areas: their cofactors take areas with their normals to the world's.

use crate::{
    approx::{Approx, sorted},
    placement::Placement,
};

/// The cofactors of a placement's linear part, by rows.
pub(crate) fn cofactors(placement: &Placement) -> [[Approx; 3]; 3] {
    let adjugate = placement.adjugate();
    std::array::from_fn(|i| std::array::from_fn(|j| adjugate[j][i]))
}

/// The factor by which all areas grow, when the cofactors are those of a similarity up to rounding.
pub(crate) fn common_stretch(cofactors: &[[Approx; 3]; 3]) -> Option<Approx> {
    let [least, most] = stretches(cofactors);
    let stretch = between(least, most);
    (most - least <= stretch.value * 1e3 * f64::EPSILON).then_some(stretch)
}

/// Something from `least` to `most`, which are not negative.
pub(crate) fn between(least: f64, most: f64) -> Approx {
    let value = 0.5 * (least + most);
    Approx { value, error: (most - least) * (0.5 + 4.0 * f64::EPSILON) + value * f64::EPSILON }
}

/// Factors that areas grow by at least and at most: by Gershgorin's circles on the Gram matrix of the cofactors, whose eigenvalues are the squares of the
/// stretches.
pub(crate) fn stretches(cofactors: &[[Approx; 3]; 3]) -> [f64; 2] {
    // Smallest product first, so that the world's axes may change places.
    let product = |k: usize, l: usize| {
        let [least, middle, greatest] = sorted([0, 1, 2].map(|row| cofactors[row][k].value * cofactors[row][l].value));
        least + middle + greatest
    };
    let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
    for k in 0..3 {
        let off: f64 = [1, 2].map(|step| product(k, (k + step) % 3).abs()).iter().sum();
        least = least.min(product(k, k) - off);
        most = most.max(product(k, k) + off);
    }
    // Products, sums and cancellation in the cofactors: below 32 roundings of the largest entries.
    let rounding = 64.0 * f64::EPSILON * most;
    [(least - rounding).max(0.0).sqrt(), (most + rounding).sqrt()]
}
