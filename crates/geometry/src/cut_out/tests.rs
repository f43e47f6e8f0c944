use glam::DVec3;
use proptest::prelude::*;

use super::*;
use crate::decisions::Decisions;

/// A unit square's lower left half at height one, texture coordinates its x and z.
const CORNERS: [[f64; 3]; 3] = [[0.0, 1.0, 0.0], [0.0, 1.0, 1.0], [1.0, 1.0, 0.0]];

fn cut_out(map: Option<AlphaMap>, filter: Filter, wrap: Wrap) -> CutOut {
    CutOut { map: map.map(Arc::new), filter, wrap: [wrap; 2], factor: 1.0, cutoff: 0.5 }
}

fn part(cut_out: CutOut, scale: f64) -> CutOutPart {
    let vertices = CORNERS.map(|[x, _, z]| TexturePoint { place: [x * scale, z * scale], alpha: 1.0 });
    CutOutPart { faces: 0..1, cut_out, first_vertex: 0, vertices: vertices.to_vec() }
}

fn mesh(part: CutOutPart) -> Mesh {
    Mesh::new(CORNERS.to_vec(), vec![[0, 1, 2]]).expect("a mesh").with_cut_outs(vec![part]).expect("cut-outs")
}

/// Whether the triangle is opaque straight above (x, z).
fn is_opaque(part: &CutOutPart, [x, z]: [f64; 2]) -> bool {
    let overhead = LightSource::sun([0.0, -1.0, 0.0]).expect("a sun");
    let corners = CORNERS.map(|corner| Point::exact(corner.into()));
    let probe = Probe::<Dyadic>::at(DVec3::new(x, 0.0, z));
    part.face(0, &[[0, 1, 2]]).is_opaque_at(corners.each_ref(), &probe, &overhead)
}

/// Two by two texels, opaque at the upper left and the lower right.
fn checkers() -> AlphaMap {
    AlphaMap::new([2, 2], vec![AlphaMap::ONE, 0, 0, AlphaMap::ONE]).expect("a map")
}

#[test]
fn texels_are_squares_closed_where_they_begin() {
    let part = part(cut_out(Some(checkers()), Filter::Nearest, Wrap::Repeat), 1.0);
    assert!(is_opaque(&part, [0.25, 0.25]) && is_opaque(&part, [0.0, 0.0]));
    assert!(!is_opaque(&part, [0.5, 0.25]) && !is_opaque(&part, [0.25, 0.5]));
    assert!(is_opaque(&part, [0.5_f64.next_down(), 0.25]), "one float before the border");
    assert!(is_opaque(&part, [0.5, 0.5]), "the lower right texel begins here");
    assert_eq!(mesh(part).opacity(0), Opacity::Mixed);
}

#[test]
fn a_way_through_the_border_of_texels_is_told_exactly() {
    let part = part(cut_out(Some(checkers()), Filter::Nearest, Wrap::Repeat), 1.0);
    let level = |place: [f64; 2]| {
        let before = Decisions::of_thread();
        is_opaque(&part, place);
        Decisions::of_thread() - before
    };
    let (clear, border) = (level([0.3, 0.3]), level([0.5, 0.3]));
    assert_eq!((clear.double, clear.all()), (1, 1));
    assert_eq!((border.exact, border.all()), (1, 1));
}

#[test]
fn lines_between_middles_reach_the_cutoff_where_they_say() {
    // Alpha rises from 0 at x = ¼ to 1 at x = ¾ and reaches ½ in the middle, exactly.
    let ramp = AlphaMap::new([2, 1], vec![0, AlphaMap::ONE]).expect("a map");
    let part = part(cut_out(Some(ramp), Filter::Linear, Wrap::ClampToEdge), 1.0);
    for z in [0.0, 0.1, 0.3] {
        assert!(is_opaque(&part, [0.5, z]) && is_opaque(&part, [0.6, z]));
        assert!(!is_opaque(&part, [0.5_f64.next_down(), z]) && !is_opaque(&part, [0.1, z]));
    }
}

#[test]
fn factor_and_vertex_alpha_count() {
    let mut part = part(cut_out(None, Filter::Linear, Wrap::Repeat), 1.0);
    assert!(!mesh(part.clone()).has_holes(), "alpha one everywhere");
    part.cut_out.factor = 0.5;
    assert!(!mesh(part.clone()).has_holes(), "alpha at the cutoff is opaque");
    part.cut_out.factor = 0.5_f64.next_down();
    assert_eq!(mesh(part.clone()).opacity(0), Opacity::Clear);
    // Alpha falls along x from 1 to 0: half of it where x = ½.
    part.cut_out.factor = 1.0;
    part.vertices[2].alpha = 0.0;
    assert!(is_opaque(&part, [0.5, 0.25]) && !is_opaque(&part, [0.5_f64.next_up(), 0.25]));
    part.cut_out.cutoff = 0.0;
    assert!(!mesh(part.clone()).has_holes(), "nothing is below a cutoff of zero");
    part.cut_out.cutoff = 1.5;
    assert_eq!(mesh(part).opacity(0), Opacity::Clear, "nothing reaches a cutoff above one");
}

#[test]
fn products_beside_the_cutoff_are_compared_exactly() {
    let mut seen = [0; 2];
    for (factor, alpha) in (1..20u32).flat_map(|i| (1..20u32).map(move |k| (f64::from(i) / 20.0, f64::from(k) / 21.0)))
    {
        let product = factor * alpha;
        // A fused product tells what rounding took away.
        let is_reached = f64::mul_add(factor, alpha, -product) >= 0.0;
        let mut part = part(cut_out(None, Filter::Linear, Wrap::Repeat), 1.0);
        part.vertices.iter_mut().for_each(|vertex| vertex.alpha = alpha);
        (part.cut_out.factor, part.cut_out.cutoff) = (factor, product);
        assert_eq!(
            mesh(part).opacity(0),
            if is_reached { Opacity::Opaque } else { Opacity::Clear },
            "{factor} {alpha}"
        );
        seen[usize::from(is_reached)] += 1;
    }
    assert!(seen.iter().all(|&count| count > 50), "{seen:?}");
}

#[test]
fn triangles_within_one_kind_of_texels_are_known() {
    let of = |scale, filter| mesh(part(cut_out(Some(checkers()), filter, Wrap::ClampToEdge), scale)).opacity(0);
    assert_eq!(of(0.25, Filter::Nearest), Opacity::Opaque);
    assert_eq!(of(0.24, Filter::Linear), Opacity::Opaque, "before the first middle the border goes on");
    assert_eq!(of(0.26, Filter::Linear), Opacity::Opaque, "just past it alpha is nearly one");
    assert_eq!(of(0.6, Filter::Linear), Opacity::Mixed, "beyond ½ it is below ½");
    let clear = AlphaMap::new([2, 2], vec![0, 1, 2, 3]).expect("a map");
    assert_eq!(mesh(part(cut_out(Some(clear), Filter::Linear, Wrap::Repeat), 9.0)).opacity(0), Opacity::Clear);
}

#[test]
fn parts_between_two_texels_are_known() {
    // Alpha rises from 0 at x = ¼ to 1 at x = ¾.
    let ramp = AlphaMap::new([2, 1], vec![0, AlphaMap::ONE]).expect("a map");
    let part = part(cut_out(Some(ramp), Filter::Linear, Wrap::ClampToEdge), 1.0);
    let face = part.face(0, &[[0, 1, 2]]);
    let told = |from: f64, to: f64| face.opacity_within([from, 0.0], [to, 0.25]);
    assert_eq!(told(0.501, 0.6), Opacity::Opaque);
    assert_eq!(told(0.1, 0.499), Opacity::Clear);
    assert_eq!([told(0.499, 0.501), told(0.0, 1.0)], [Opacity::Mixed; 2]);
}

#[test]
fn seen_edge_on_it_is_opaque() {
    let part = part(cut_out(Some(checkers()), Filter::Nearest, Wrap::Repeat), 1.0);
    let level = LightSource::sun([-1.0, 0.0, 0.0]).expect("a sun");
    let corners = CORNERS.map(|corner| Point::exact(corner.into()));
    let probe = Probe::<Dyadic>::at(DVec3::new(-1.0, 1.0, 0.75));
    assert!(part.face(0, &[[0, 1, 2]]).is_opaque_at(corners.each_ref(), &probe, &level));
}

#[test]
fn faults_are_refused() {
    let fine = part(cut_out(None, Filter::Linear, Wrap::Repeat), 1.0);
    let refused = |change: &dyn Fn(&mut CutOutPart)| {
        let mut part = fine.clone();
        change(&mut part);
        Mesh::new(CORNERS.to_vec(), vec![[0, 1, 2]]).expect("a mesh").with_cut_outs(vec![part]).err()
    };
    assert_eq!(refused(&|_| ()), None);
    for number in [f64::NAN, f64::INFINITY, -0.5, 1.5] {
        assert_eq!(refused(&|part| part.cut_out.factor = number), Some(CutOutDefect::Number));
        assert_eq!(refused(&|part| part.vertices[1].alpha = number), Some(CutOutDefect::Number));
    }
    assert_eq!(refused(&|part| part.cut_out.cutoff = f64::NAN), Some(CutOutDefect::Number));
    assert_eq!(refused(&|part| part.vertices[0].place[1] = 1e10), Some(CutOutDefect::Number));
    assert_eq!(refused(&|part| part.faces = 0..2), Some(CutOutDefect::Part));
    assert_eq!(refused(&|part| part.first_vertex = 1), Some(CutOutDefect::Part));
    assert_eq!(refused(&|part| part.vertices.truncate(2)), Some(CutOutDefect::Part));
}

#[test]
fn floors_of_products_are_exact() {
    let third = 1.0 / 3.0;
    assert_eq!(floor_of_product(third, 3.0), 0, "the float is below a third, the rounded product is one");
    assert_eq!(floor_of_product(third.next_up(), 3.0), 1);
    assert_eq!(floor_of_product(-f64::MIN_POSITIVE, 1e-300), -1, "too small for floats");
    assert_eq!(floor_of_product(-0.0, 7.0), 0);
}

/// Alpha by the book, in plain floats: texel or bilinear mean, of wrapped coordinates.
fn by_the_book(cut_out: &CutOut, place: [f64; 2]) -> f64 {
    let map = cut_out.map.as_ref().expect("a map");
    let size = map.size();
    let at = |column: f64, row: f64| {
        let texel = [(column, 0), (row, 1)].map(|(index, axis)| cut_out.wrap[axis].texel(index as i64, size[axis]));
        f64::from(map.texel(texel)) / 65535.0
    };
    let [u, v] = [place[0] * f64::from(size[0]), place[1] * f64::from(size[1])];
    if cut_out.filter == Filter::Nearest {
        return at(u.floor(), v.floor());
    }
    let (u, v) = (u - 0.5, v - 0.5);
    let (i, j) = (u.floor(), v.floor());
    let (s, t) = (u - i, v - j);
    let line = |j: f64| at(i, j) * (1.0 - s) + at(i + 1.0, j) * s;
    line(j) * (1.0 - t) + line(j + 1.0) * t
}

proptest! {
    #[test]
    fn points_are_decided_as_samplers_read_them(
        size in prop::array::uniform2(1u32..6),
        texels in prop::collection::vec(any::<u16>(), 25),
        (is_linear, wrap) in (any::<bool>(), 0usize..3),
        (x, z, scale) in (0.0..0.5f64, 0.0..0.5f64, -5.0..5.0f64),
        shares in prop::array::uniform3(0.01..1.0f64),
        light in prop::array::uniform3(-4.0..4.0f64),
    ) {
        let map = AlphaMap::new(size, texels[..(size[0] * size[1]) as usize].to_vec()).expect("a map");
        let filter = if is_linear { Filter::Linear } else { Filter::Nearest };
        let wrap = [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge][wrap];
        let part = part(cut_out(Some(map), filter, wrap), scale);
        let alpha = by_the_book(&part.cut_out, [x * scale, z * scale]);
        // Rounding cannot matter that far from the cutoff; on texel borders it can, but they are met by chance never.
        if (alpha - 0.5).abs() > 1e-9 {
            prop_assert_eq!(is_opaque(&part, [x, z]), alpha >= 0.5);
        }
        // A lamp sees the point (x, 1, z) of the triangle from wherever it stands above.
        let lamp = DVec3::new(light[0], 2.0 + light[1].abs(), light[2]);
        let met = DVec3::new(x, 1.0, z);
        let behind = met + (met - lamp) * shares[0];
        let source = LightSource::point(lamp.to_array()).expect("a lamp");
        let corners = CORNERS.map(|corner| Point::exact(corner.into()));
        let face = part.face(0, &[[0, 1, 2]]);
        if (alpha - 0.5).abs() > 1e-6 {
            let decided = face.is_opaque_at(corners.each_ref(), &Probe::<Dyadic>::at(behind), &source);
            let border = |place: f64, count: u32| {
                let texel = place * scale * f64::from(count);
                is_linear || (texel - texel.round()).abs() > 1e-9
            };
            if border(x, size[0]) && border(z, size[1]) {
                prop_assert_eq!(decided, alpha >= 0.5, "{} {}", x, z);
            }
        }
    }

    #[test]
    fn what_is_said_of_hulls_holds_for_their_points(
        texels in prop::collection::vec(prop::sample::select(vec![0u16, u16::MAX]), 16),
        is_linear in any::<bool>(),
        ways in prop::collection::vec(prop::array::uniform3(0.0..1.0f64), 4),
        shares in prop::array::uniform4(0.0..1.0f64),
    ) {
        let map = AlphaMap::new([4, 4], texels).expect("a map");
        let filter = if is_linear { Filter::Linear } else { Filter::Nearest };
        let part = part(cut_out(Some(map), filter, Wrap::Repeat), 1.0);
        let face = part.face(0, &[[0, 1, 2]]);
        let exact: Vec<_> = ways.iter().map(|way| way.map(Approx::exact)).collect();
        let mean = [0, 1, 2].map(|k| ways.iter().zip(shares).map(|(way, share)| way[k] * share).sum::<f64>());
        prop_assume!(mean.iter().sum::<f64>() > 1e-3);
        // The mean is rounded: a hair's breadth from a border either answer may come out.
        let error = |value: f64| Approx { value, error: value * 1e-12 };
        if let Some(is_opaque) = face.is_opaque_on(mean.map(error)) {
            // Whatever the corner that is counted first.
            for corner in 0..3 {
                let way = [0, 1, 2].map(|k| mean[(k + usize::from(corner)) % 3]);
                prop_assert_eq!(face.counted_from(corner).probably_opaque_on(way), is_opaque);
                prop_assert_eq!(face.counted_from(corner).probably_opaque_on(way.map(|weight| -weight)), is_opaque);
            }
            let told = face.opacity_over(exact);
            prop_assert!(told == Opacity::Mixed || (told == Opacity::Opaque) == is_opaque, "{told:?}");
        }
    }
}
