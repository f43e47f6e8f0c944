//! The ten bodies given by formulas, stretched and turned: their patches, their boxes, their areas with bounds, and
//! what they block. No triangles anywhere.

use std::error::Error;

use glam::{DAffine3, DVec3};
use umbriel_geometry::{
    Analytic, Approx, LightSource, PlacedAnalytic, Placement, Point, Sign, analytic::PatchArea, blocking::Probe,
};

/// The hyperboloid below once more, as a matrix and a box: x² + z² ≤ 1/4 + 3/4·y², |y| ≤ 1.
const BY_MATRIX: Analytic = Analytic::Quadric {
    matrix: [[1.0, 0.0, 0.0, 0.0], [0.0, -0.75, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, -0.25]],
    within: [[-1.0; 3], [1.0; 3]],
};

/// Areas are summed over cells of this edge. Whole patches would do, but for the quadric: its patches end somewhere
/// within their parameter squares, and what the border runs through is known only to a share of a cell.
const CELL: f64 = 1.0 / 32.0;

#[expect(clippy::print_stdout, reason = "an example shows what it found")]
fn main() -> Result<(), Box<dyn Error>> {
    let bodies = [
        Analytic::Sphere { radius: 1.0 },
        Analytic::Ellipsoid { radii: [1.0, 0.5, 2.0] },
        Analytic::Cylinder { radius: 0.5, height: 2.0 },
        Analytic::Cone { radius: 1.0, height: 2.0 },
        Analytic::Frustum { bottom_radius: 1.0, top_radius: 0.5, height: 2.0 },
        Analytic::Capsule { radius: 0.5, height: 1.0 },
        Analytic::Paraboloid { radius: 1.0, height: 2.0 },
        Analytic::Hyperboloid { waist_radius: 0.5, end_radius: 1.0, height: 2.0 },
        Analytic::Disk { radius: 1.0 },
        BY_MATRIX,
    ];
    // Any regular matrix does: here one axis is half as long again, and everything is turned.
    let map = DAffine3::from_rotation_x(0.5) * DAffine3::from_scale(DVec3::new(1.5, 1.0, 1.0));
    let lamp = LightSource::point([0.0, 5.0, 0.0])?;
    println!("body         faces  area as it is, m²       area stretched, m²      box stretched, m");
    for body in bodies {
        let stretched = PlacedAnalytic::new(body, Placement::new(map)?)?;
        let areas = [area(&PlacedAnalytic::new(body, Placement::IDENTITY)?), area(&stretched)];
        let [plain, wide] = areas.map(|area| format!("{:>10.6} ± {:<9.1e}", area.value, area.error));
        let size = stretched.bounds().max - stretched.bounds().min;
        println!("{:<12} {:>4}   {plain} {wide}  {size:.3}", body.name(), body.face_count());

        // The origin is inside of all but the disk, where it lies on the surface; then it does not block itself.
        let middle = stretched.side(&Point::exact(DVec3::ZERO), false);
        assert_eq!(middle, if body.is_closed() { Sign::Negative } else { Sign::Zero });
        assert_eq!(
            stretched.blocks(&Probe::<umbriel_geometry::Dyadic>::at(DVec3::ZERO), None, &lamp),
            body.is_closed()
        );
    }
    Ok(())
}

/// The area of all patches, square metres.
fn area(body: &PlacedAnalytic) -> Approx {
    let cells = (0..32).flat_map(|i| (0..32).map(move |j| [CELL * f64::from(i), CELL * f64::from(j)]));
    let of_patch = |patch: PatchArea| cells.clone().fold(Approx::exact(0.0), |sum, at| sum + patch.of_cell(at, CELL));
    let patches = body.charts().iter().map(|chart| PatchArea::new(chart, body.placement()));
    patches.fold(Approx::exact(0.0), |sum, patch| sum + of_patch(patch))
}
