//! Lit areas that are known by formula, for the fixtures that are simple enough. Derived here from the numbers of the
//! scene files, with nothing of the library.

use std::f64::consts::PI;

/// What is lit of an object, square metres.
pub(super) struct ClosedForm {
    pub(super) fixture: &'static str,
    pub(super) light: &'static str,
    pub(super) object: &'static str,
    pub(super) lit: f64,
}

pub(super) fn all() -> Vec<ClosedForm> {
    let tables = [ball_over_floor(), box_over_floor(), lamp_in_box(), touching(), placed(), z_up(), lattice()];
    tables.into_iter().flatten().collect()
}

fn of(fixture: &'static str, rows: &[(&'static str, &'static str, f64)]) -> Vec<ClosedForm> {
    rows.iter().map(|&(light, object, lit)| ClosedForm { fixture, light, object, lit }).collect()
}

/// A unit ball whose centre is 2 above a floor of 64 m².
fn ball_over_floor() -> Vec<ClosedForm> {
    // A sun at elevation e casts an ellipse of area πr²/sin e; here 1/sin e = |(0.5, −1, 0)|.
    let ellipse = PI * 1.25_f64.sqrt();
    // A lamp at distance D = 3 from the centre sees a cone of half angle asin(r/D); it stands H = 5 above the floor.
    let disk = PI * 25.0 / 8.0;
    // Of the ball it lights the cap of height r − r²/D; a sun lights a half.
    let (half, cap) = (2.0 * PI, 2.0 * PI * (1.0 - 1.0 / 3.0));
    of(
        "ball-over-floor",
        &[
            ("noon", "floor", 64.0 - PI),
            ("slant", "floor", 64.0 - ellipse),
            ("lamp", "floor", 64.0 - disk),
            ("noon", "ball", half),
            ("slant", "ball", half),
            ("lamp", "ball", cap),
        ],
    )
}

/// What an upright box of the size (x, y, z) casts on level ground: its footprint, swept along the sun's run per drop.
fn cast([x, y, z]: [f64; 3], [run_x, run_z]: [f64; 2]) -> f64 {
    x * z + y * (z * run_x.abs() + x * run_z.abs())
}

/// A box of 2 × 1 × 1.5 whose top is at 2.5, over a floor of 100 m².
fn box_over_floor() -> Vec<ClosedForm> {
    let size = [2.0, 1.0, 1.5];
    // The lamp stands at 5, over the middle: seen from it the top hides all the rest, and doubles on the floor.
    let doubled = 4.0 * 3.0;
    of(
        "box-over-floor",
        &[
            ("noon", "floor", 100.0 - cast(size, [0.0, 0.0])),
            ("slant", "floor", 100.0 - cast(size, [0.5, 0.25])),
            ("lamp", "floor", 100.0 - doubled),
            ("noon", "box", 3.0),
            ("slant", "box", 3.0 + 1.5 + 2.0),
            ("lamp", "box", 3.0),
        ],
    )
}

/// The box is one-sided, so the lamp inside lights nothing of it; its bottom is in contact with the floor.
fn lamp_in_box() -> Vec<ClosedForm> {
    of(
        "lamp-in-box",
        &[("lamp", "floor", 4.0), ("lamp", "box", 0.0), ("noon", "floor", 36.0 - 4.0), ("noon", "box", 4.0)],
    )
}

/// Three unit cubes in a row cast what one box casts; the lid lies in the top of the middle one and hides nothing of it.
fn touching() -> Vec<ClosedForm> {
    let row = [3.0, 1.0, 1.0];
    of(
        "touching",
        &[
            ("noon", "floor", 64.0 - cast(row, [0.0, 0.0])),
            ("slant", "floor", 64.0 - cast(row, [0.5, 0.25])),
            ("noon", "west", 1.0),
            ("noon", "middle", 1.0),
            ("noon", "east", 1.0),
            ("noon", "lid", 1.0),
            // The top and the −z side of each, and of the first its −x side; the others' −x sides touch a neighbour.
            ("slant", "west", 3.0),
            ("slant", "middle", 2.0),
            ("slant", "east", 2.0),
            ("slant", "lid", 1.0),
            ("lamp", "middle", 1.0),
            ("lamp", "lid", 1.0),
        ],
    )
}

/// Under a vertical sun: the shadows of an ellipsoid, a parallelepiped, a box and a parallelogram.
fn placed() -> Vec<ClosedForm> {
    // The shadow of M·(unit ball) is the image of the ball under the x and z rows of M: π·√det(P·Pᵀ).
    let (row_x, row_z): ([f64; 3], [f64; 3]) = ([1.0, 0.5, 0.0], [0.0, 0.0, 0.75]);
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let ellipse = PI * (dot(row_x, row_x) * dot(row_z, row_z) - dot(row_x, row_z).powi(2)).sqrt();
    // The edges of the leaning box, seen from above (x, z): its shadow is the sum of the three pairs' parallelograms.
    let (a, b, c) = ((1.0, 0.0), (0.5, 0.25), (0.0, -1.5));
    let flat = |p: (f64, f64), q: (f64, f64)| (p.0 * q.1 - p.1 * q.0).abs();
    let leaning = flat(a, b) + flat(b, c) + flat(c, a);
    // The mirrored box stands upright: its shadow is its footprint of 2 × 1.
    let tilted = flat((2.0 * 0.75, 0.0), (0.0, 1.0));
    of("placed", &[("noon", "floor", 144.0 - ellipse - leaning - 2.0 - tilted), ("noon", "mirrored box", 2.0)])
}

/// A box of 2 × 1.5 × 1 high, the sun in the south at 45 degrees: the shadow grows by the height, 2 wide.
fn z_up() -> Vec<ClosedForm> {
    of("z-up", &[("sun", "floor", 64.0 - (3.0 + 2.0))])
}

/// Half of a sheet of 2 × 2 over a floor of 64 m²: a level sheet casts its own form, however the sun stands. A sheet itself has no shadow.
fn lattice() -> Vec<ClosedForm> {
    let floor = 64.0 - 0.5 * 4.0;
    let rows = ["noon", "slant"].map(|sun| [(sun, "ground", floor), (sun, "lattice", 4.0)]);
    of("lattice", &rows.concat())
}
