//! The least winding in a cell that several segments meet.
//!
//! [`tile`](super::tile) takes from the winding at a cell's middle all that the segments through the cell may take, as if one lay outside the other. Where a
//! rough body is seen against its own shadow, its border runs to and fro, and the way in gives what the way out takes. So here the regions are looked at
//! into which the segments divide the cell. The straight way from the middle to the region with the least winding enters it from the left of some segment to the right; so
//! the regions on the right of segments that have the middle on their left are all that need be known. The winding right of one point of such a segment follows from
//! the straight way there from the middle; along the segment it changes where others cross it.
//!
//! Guarantee: never above the least winding in the cell, wherever in their margins the segments lie. What the margins leave open counts as it takes most;
//! segments that share an end do not cross, and the same edge there and back takes nothing (NUMERICS.md, "Borders on a face").
//! Cost: some 20 ns for each pair of segments.

use glam::DVec2;

use super::segments::{CornerKey, Segment};

/// With more segments a cell is not looked at.
pub(super) const MOST_SEGMENTS: usize = 16;

/// Half the edge of the square round a cell's middle that segments are cut to, in cells.
const REACH: f64 = 1.0;

/// Cross products of ways within that square are off by less than this many margins.
const DOUBT: f64 = 64.0;

/// A segment that may meet a cell, and the corners at its ends.
pub(super) type Met<'s> = (&'s Segment, &'s [Option<CornerKey>; 2]);

/// The segments round the middle of one cell after the other.
#[derive(Debug, Default)]
pub(super) struct Surroundings {
    pieces: Vec<Piece>,
    crossings: Vec<Crossing>,
    /// What is no farther from 0 has no sign.
    doubt: f64,
}

/// What is near a cell of a segment, from the cell's middle.
#[derive(Clone, Copy, Debug)]
struct Piece {
    from: DVec2,
    to: DVec2,
    net: i32,
    /// The corners at the segment's ends.
    edge: [Option<CornerKey>; 2],
    /// The corners at its own ends; none where it was cut.
    ends: [Option<CornerKey>; 2],
    /// The part that is in the cell, from 0 to 1 along the piece.
    inside: [f64; 2],
    /// Whether the cell's middle is on its left.
    holds_middle: bool,
}

/// A crossing with another piece on the way along one.
#[derive(Clone, Copy, Debug)]
struct Crossing {
    /// Where, from 0 to 1, within `slip`.
    at: f64,
    slip: f64,
    /// How the winding changes on the way forward.
    change: i32,
}

impl Surroundings {
    /// Whether the winding is surely at least 1 everywhere in the cell round `middle`, where it is `winding`; `segments` are all that may meet the cell.
    pub(super) fn are_covered<'s>(
        &mut self,
        middle: [f64; 2],
        winding: i32,
        segments: impl Iterator<Item = Met<'s>> + Clone,
    ) -> bool {
        let margin = segments.clone().fold(0.0_f32, |most, (segment, _)| most.max(segment.margin));
        self.doubt = DOUBT * f64::from(margin);
        // What the cell is widened by must stay within the square that segments are cut to.
        if winding < 1 || self.doubt >= REACH - 0.5 {
            return false;
        }
        self.pieces.clear();
        for piece in segments.filter_map(|met| Piece::new(middle, met, self.doubt)) {
            match self.pieces.iter().position(|other| piece.is_reverse_of(other)) {
                Some(other) => drop(self.pieces.swap_remove(other)),
                None => self.pieces.push(piece),
            }
        }
        self.middle_is_clear()
            && (0..self.pieces.len())
                .all(|own| !self.pieces[own].holds_middle || self.is_covered_right_of(own, winding))
    }

    /// Whether it is sure on which side of each piece the middle lies; notes it.
    fn middle_is_clear(&mut self) -> bool {
        self.pieces.iter_mut().all(|piece| {
            let side = piece.side(DVec2::ZERO, self.doubt);
            piece.holds_middle = side == Some(true);
            side.is_some()
        })
    }

    /// Whether the winding is at least 1 just right of a piece, all along it in the cell; it has the middle, with this winding, on its left.
    fn is_covered_right_of(&mut self, own: usize, winding: i32) -> bool {
        let piece = self.pieces[own];
        let start = 0.5 * (piece.inside[0] + piece.inside[1]);
        let place = piece.at(start);
        // It hardly touches the cell.
        if !place.abs().cmple(DVec2::splat(0.5)).all() {
            return false;
        }
        let mut winding = winding - piece.net;
        self.crossings.clear();
        for (_, other) in self.pieces.iter().enumerate().filter(|&(number, _)| number != own) {
            // First from the middle to the place, then along the piece.
            let Some(is_left) = other.side(place, self.doubt) else {
                winding -= other.net;
                continue;
            };
            winding += other.least_change_on_the_way_to(place, is_left, self.doubt);
            match other.encounter(&piece, self.doubt) {
                Encounter::None => {}
                Encounter::Crossing(crossing) => self.crossings.push(crossing),
                Encounter::Open => winding -= if is_left { other.net } else { 0 },
            }
        }
        let ahead = self.lowest_until([start, piece.inside[1]], winding);
        self.crossings.iter_mut().for_each(Crossing::turn_round);
        ahead.min(self.lowest_until([1.0 - start, 1.0 - piece.inside[0]], winding)) >= 1
    }

    /// The least winding from one place to another on the way along a piece.
    fn lowest_until(&mut self, [start, end]: [f64; 2], mut winding: i32) -> i32 {
        let mut lowest = winding;
        self.crossings.sort_unstable_by(|a, b| a.due().total_cmp(&b.due()).then(a.change.cmp(&b.change)));
        for crossing in self.crossings.iter().filter(|crossing| crossing.at > start && crossing.due() <= end) {
            winding += crossing.change;
            lowest = lowest.min(winding);
        }
        lowest
    }
}

/// What is known of a crossing.
enum Encounter {
    None,
    Crossing(Crossing),
    /// There may be one.
    Open,
}

impl Crossing {
    /// From where on it counts: what takes comes as soon as it may, what gives as late.
    fn due(&self) -> f64 {
        if self.change < 0 { self.at - self.slip } else { self.at + self.slip }
    }

    /// On the way back.
    fn turn_round(&mut self) {
        (self.at, self.change) = (1.0 - self.at, -self.change);
    }
}

impl Piece {
    /// `None` if the segment is not in the cell.
    fn new(middle: [f64; 2], (segment, corners): Met, doubt: f64) -> Option<Self> {
        let way = [segment.from, segment.to].map(|end| DVec2::from(end) - DVec2::from(middle));
        let [near, inside] = within(way, [REACH, 0.5 + doubt])?;
        let is_whole = [near[0] <= 0.0, near[1] >= 1.0];
        let [from, to] = [0, 1].map(|end| if is_whole[end] { way[end] } else { along(way, near[end]) });
        let inside = inside.map(|t| (t - near[0]) / (near[1] - near[0]));
        let ends = [0, 1].map(|end| corners[end].filter(|_| is_whole[end]));
        Some(Self { from, to, net: segment.net, edge: *corners, ends, inside, holds_middle: false })
    }

    fn at(&self, t: f64) -> DVec2 {
        along([self.from, self.to], t)
    }

    /// Whether it is the same edge the other way, with as many facets on its left.
    fn is_reverse_of(&self, other: &Self) -> bool {
        let [from, to] = self.edge;
        from.is_some() && to.is_some() && [to, from] == other.edge && self.net == other.net
    }

    /// The cross product of the piece with the way from its start to a point: positive on its left.
    fn left(&self, point: DVec2) -> f64 {
        (self.to - self.from).perp_dot(point - self.from)
    }

    /// Whether a point is on its left; `None` in doubt.
    fn side(&self, point: DVec2, doubt: f64) -> Option<bool> {
        sign(self.left(point), doubt)
    }

    /// How the winding changes across it on the straight way from the cell's middle to a point on its left or not; at least.
    fn least_change_on_the_way_to(&self, point: DVec2, is_left: bool, doubt: f64) -> i32 {
        if is_left == self.holds_middle {
            return 0;
        }
        let change = if is_left { self.net } else { -self.net };
        match [self.from, self.to].map(|end| sign(point.perp_dot(end), doubt)) {
            [Some(from), Some(to)] if from == to => 0,
            [Some(_), Some(_)] => change,
            _ => change.min(0),
        }
    }

    /// Where it is crossed on the way along `other`.
    fn encounter(&self, other: &Self, doubt: f64) -> Encounter {
        let mut sides = [None; 2];
        for (end, side) in sides.iter_mut().enumerate() {
            if self.ends[end].is_some() && other.ends.contains(&self.ends[end]) {
                continue;
            }
            *side = other.side([self.from, self.to][end], doubt);
            if side.is_none() {
                return Encounter::Open;
            }
        }
        let [before, behind] = [other.from, other.to].map(|point| self.left(point));
        match (sides, [before, behind].map(|left| sign(left, doubt))) {
            // With a common end they meet nowhere else.
            ([None, _] | [_, None], _) => Encounter::None,
            ([from, to], _) if from == to => Encounter::None,
            (_, [Some(before), Some(behind)]) if before == behind => Encounter::None,
            (_, [Some(_), Some(is_gain)]) => {
                let whole = before.abs() + behind.abs();
                let change = if is_gain { self.net } else { -self.net };
                Encounter::Crossing(Crossing { at: before.abs() / whole, slip: doubt / whole, change })
            }
            _ => Encounter::Open,
        }
    }
}

/// Whether a number that is known to `doubt` is positive; `None` if that is open.
fn sign(number: f64, doubt: f64) -> Option<bool> {
    (number.abs() > doubt).then_some(number > 0.0)
}

/// From where to where a way is in the squares of these half edges (Liang & Barsky 1984); `None` if it misses the last.
fn within([from, to]: [DVec2; 2], halves: [f64; 2]) -> Option<[[f64; 2]; 2]> {
    let mut ranges = [[0.0_f64, 1.0_f64]; 2];
    for (start, step) in from.to_array().into_iter().zip((to - from).to_array()) {
        let inverse = 1.0 / step;
        for (range, half) in ranges.iter_mut().zip(halves) {
            if step == 0.0 {
                *range = if start.abs() > half { [1.0, 0.0] } else { *range };
                continue;
            }
            let [a, b] = [(-half - start) * inverse, (half - start) * inverse];
            *range = [range[0].max(a.min(b)), range[1].min(a.max(b))];
        }
    }
    (ranges[1][0] <= ranges[1][1]).then_some(ranges)
}

fn along([from, to]: [DVec2; 2], t: f64) -> DVec2 {
    from + (to - from) * t
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cell about this point is looked at.
    const MIDDLE: [f64; 2] = [3.5, 7.5];

    /// Closed polygons with corners near the cell, whose windings add up with what is everywhere.
    struct Polygons {
        corners: Vec<Vec<[f64; 2]>>,
        nets: Vec<i32>,
        everywhere: i32,
    }

    impl Polygons {
        fn segments(&self) -> Vec<(Segment, [Option<CornerKey>; 2])> {
            let mut segments = Vec::new();
            for (polygon, (corners, &net)) in self.corners.iter().zip(&self.nets).enumerate() {
                for (number, &from) in corners.iter().enumerate() {
                    let next = (number + 1) % corners.len();
                    let segment = Segment { from, to: corners[next], margin: 1e-13, net, is_beside: false };
                    segments.push((
                        segment,
                        [number, next].map(|corner| Some(CornerKey::numbered(polygon as u64, corner as u32))),
                    ));
                }
            }
            segments
        }

        /// The winding round a point that is on no polygon: crossings of the way to the right.
        fn winding(&self, [x, y]: [f64; 2]) -> i32 {
            let sides = self.segments();
            let changes = sides.iter().map(|(Segment { from, to, net, .. }, _)| {
                if (from[1] <= y) == (to[1] <= y) {
                    return 0;
                }
                let at = from[0] + (y - from[1]) / (to[1] - from[1]) * (to[0] - from[0]);
                let turn = if to[1] > from[1] { *net } else { -net };
                if at > x { turn } else { 0 }
            });
            self.everywhere + changes.sum::<i32>()
        }

        /// The least winding in the cell, found round all places where borders meet.
        fn lowest(&self) -> i32 {
            let sides = self.segments();
            let square =
                [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]].map(|p| [p[0] + MIDDLE[0], p[1] + MIDDLE[1]]);
            let of_square = (0..4).map(|k| [square[k], square[(k + 1) % 4]]);
            let lines: Vec<[[f64; 2]; 2]> = sides.iter().map(|(s, _)| [s.from, s.to]).chain(of_square).collect();
            let mut places: Vec<[f64; 2]> = lines.iter().flatten().copied().chain([MIDDLE]).collect();
            for (number, a) in lines.iter().enumerate() {
                for b in &lines[..number] {
                    let (a, b) = (a.map(DVec2::from), b.map(DVec2::from));
                    let (u, v) = (a[1] - a[0], b[1] - b[0]);
                    let t = (b[0] - a[0]).perp_dot(v) / u.perp_dot(v);
                    places.extend((0.0..=1.0).contains(&t).then(|| along(a, t).to_array()));
                }
            }
            let round = (0..64).map(|k| DVec2::from_angle(f64::from(k) * 0.098 + 0.0123) * 1e-7);
            let round: Vec<[f64; 2]> = round.map(|step| step.to_array()).collect();
            let near = places.iter().flat_map(|p| round.iter().map(|step| [p[0] + step[0], p[1] + step[1]]));
            let is_in = |p: &[f64; 2]| (0..2).all(|axis| (p[axis] - MIDDLE[axis]).abs() < 0.5);
            near.filter(is_in).map(|p| self.winding(p)).min().expect("the middle")
        }

        fn are_covered(&self) -> bool {
            let segments = self.segments();
            let met = segments.iter().map(|(segment, ends)| (segment, ends));
            Surroundings::default().are_covered(MIDDLE, self.winding(MIDDLE), met)
        }
    }

    #[test]
    fn what_is_covered_is_told_by_the_regions_of_the_cell() {
        let mut seed = 7_u64;
        let mut random = move |most: u64| {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 33) % most
        };
        let (mut covered, mut proved) = (0, 0);
        for round in 0..4_000 {
            // Corners on a grid, which often meet and touch borders, or anywhere.
            let grid = [8, 1 << 20][round % 2];
            let mut place = |_| 2.0 * (random(grid) as f64 + 0.5) / grid as f64 - 1.0;
            let mut polygon = |_| {
                let corners = (0..3).map(|_| [place(0) + MIDDLE[0], place(1) + MIDDLE[1] + 0.001]);
                corners.collect::<Vec<[f64; 2]>>()
            };
            let corners: Vec<_> = (0..1 + round % 3).map(&mut polygon).collect();
            let nets = corners.iter().map(|_| 1 + random(2) as i32).collect();
            let polygons = Polygons { corners, nets, everywhere: 1 + random(3) as i32 };
            let is_covered = polygons.lowest() >= 1;
            let is_proved = polygons.are_covered();
            assert!(is_covered || !is_proved, "{:?} {:?} {}", polygons.corners, polygons.nets, polygons.everywhere);
            covered += usize::from(is_covered && grid > 8);
            proved += usize::from(is_proved && grid > 8);
        }
        // All but those that the margins leave open.
        assert!(covered > 500 && proved * 100 > covered * 99, "{proved} of {covered}");
    }

    /// An opening round (0.32, 0.32) from the middle: a corner of one polygon lies on an edge of another, and beyond it a third takes what the second gave.
    #[test]
    fn what_corners_on_edges_leave_open_gives_nothing() {
        let about_middle = |corners: &[[f64; 2]]| -> Vec<[f64; 2]> {
            corners.iter().map(|p| [p[0] + MIDDLE[0], p[1] + MIDDLE[1]]).collect()
        };
        let mirrored = |corners: &[[f64; 2]]| -> Vec<[f64; 2]> { corners.iter().rev().map(|p| [p[1], p[0]]).collect() };
        let half = [[-3.0, 0.3125], [-3.0, -3.0], [3.0, -3.0], [3.0, 0.3125]];
        let bent = [[0.1125, 0.2125], [0.2125, 0.3125], [1.1125, 0.6625], [1.1125, 3.0], [0.0625, 3.0]];
        let all = [half.to_vec(), mirrored(&half), bent.to_vec(), mirrored(&bent)];
        let corners = all.iter().map(|corners| about_middle(corners)).collect();
        let polygons = Polygons { corners, nets: vec![1; 4], everywhere: 0 };
        assert_eq!(polygons.winding(MIDDLE), 2);
        assert_eq!(polygons.winding([MIDDLE[0] + 0.3225, MIDDLE[1] + 0.3225]), 0);
        assert!(!polygons.are_covered());
    }

    #[test]
    fn nothing_is_known_where_margins_are_wide() {
        let segment = Segment { from: [603.5, 9.33], to: [-596.5, 8.13], margin: 0.75, net: 1, is_beside: false };
        let met = [(&segment, &[None; 2]); 2];
        assert!(!Surroundings::default().are_covered(MIDDLE, 2, met.into_iter()));
    }

    #[test]
    fn an_edge_there_and_back_takes_nothing() {
        let spike = vec![[2.0, 7.2], [6.0, 7.9]];
        let polygons = Polygons { corners: vec![spike], nets: vec![2], everywhere: 1 };
        assert!(polygons.are_covered());
        let bare = Polygons { everywhere: 0, ..polygons };
        assert!(!bare.are_covered());
    }
}
