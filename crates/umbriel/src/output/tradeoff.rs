//! What settings cost and give: a table for people, CSV, JSON (names and order of the fields are a contract), and charts.

use std::fmt::Write;

use serde::Serialize;
use umbriel_shadow::tradeoff::{Family, Measurement, pareto};

use crate::output::drawing::{Anchor, BLACK, Colour, Drawing, GRAY};

const SCHEMA: u32 = 1;

/// A measured setting, with the most memory that it held while it ran.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    pub(crate) measured: Measurement,
    /// Which settings it is one of that differ in one number; they are joined in charts.
    pub(crate) ladder: usize,
    pub(crate) peak_bytes: Option<u64>,
}

/// All settings on one scene.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tradeoff {
    pub(crate) scene: String,
    pub(crate) light: String,
    pub(crate) triangles: usize,
    pub(crate) judged: usize,
    pub(crate) threads: usize,
    pub(crate) rows: Vec<Row>,
    /// Settings that gave nothing, and why.
    pub(crate) refused: Vec<(String, String)>,
}

#[derive(Serialize)]
struct Document<'a> {
    schema: u32,
    umbriel: &'static str,
    scene: &'a str,
    light: &'a str,
    triangles: usize,
    judged_points: usize,
    threads: usize,
    settings: Vec<Entry<'a>>,
    refused: Vec<Refusal<'a>>,
}

#[derive(Serialize)]
struct Entry<'a> {
    name: &'a str,
    family: &'static str,
    first_seconds: f64,
    second_seconds: f64,
    peak_bytes: Option<u64>,
    stored_bytes: u64,
    rays: u64,
    pieces: u64,
    undecided: f64,
    wrong: f64,
    border_distance: f64,
    on_time_front: bool,
    on_memory_front: bool,
}

#[derive(Serialize)]
struct Refusal<'a> {
    name: &'a str,
    reason: &'a str,
}

/// What a family is called, and its colour.
pub(crate) fn family(family: Family) -> (&'static str, Colour) {
    match family {
        Family::Bake => ("umbriel, cells with proofs", [0xc8, 0x50, 0x2d]),
        Family::Limit => ("umbriel, cells by a limit", [0x90, 0x28, 0x50]),
        Family::Points => ("umbriel, every point", [0x20, 0x90, 0x80]),
        Family::Samples => ("umbriel, samples", [0xe0, 0xa0, 0x30]),
        Family::RaySamples => ("rays, as many samples", [0x3c, 0x6e, 0x9f]),
        Family::Rays => ("rays, every point", [0x70, 0xb0, 0xd8]),
        Family::ShadowVolume => ("shadow volume, every point", [0x5a, 0x8f, 0x3c]),
        Family::ShadowMap => ("shadow map, every point", [0x8a, 0x58, 0xa8]),
        Family::Literal => ("the source's words", [0x80, 0x80, 0x80]),
    }
}

impl Tradeoff {
    fn measured(&self) -> Vec<Measurement> {
        self.rows.iter().map(|row| row.measured.clone()).collect()
    }

    /// Which rows are on the front of time and error, and on that of stored bytes and error.
    fn fronts(&self) -> [Vec<bool>; 2] {
        let measured = self.measured();
        [pareto(&measured, Measurement::seconds), pareto(&measured, |one| one.bytes as f64)]
    }

    fn entries(&self) -> Vec<Entry<'_>> {
        let [by_time, by_memory] = self.fronts();
        let share = |count: u64, row: &Row| count as f64 / row.measured.score.points.max(1) as f64;
        let entry = |(number, row): (usize, &Row)| {
            let Measurement { first_seconds, second_seconds, rays, pieces, bytes, score, .. } = row.measured;
            Entry {
                name: &self.rows[number].measured.name,
                family: family(row.measured.family).0,
                first_seconds,
                second_seconds,
                peak_bytes: row.peak_bytes,
                stored_bytes: bytes,
                rays,
                pieces,
                undecided: share(score.undecided, row),
                wrong: share(score.wrong, row),
                border_distance: score.border_distance,
                on_time_front: by_time[number],
                on_memory_front: by_memory[number],
            }
        };
        self.rows.iter().enumerate().map(entry).collect()
    }

    pub(crate) fn to_json(&self) -> String {
        let document = Document {
            schema: SCHEMA,
            umbriel: env!("CARGO_PKG_VERSION"),
            scene: &self.scene,
            light: &self.light,
            triangles: self.triangles,
            judged_points: self.judged,
            threads: self.threads,
            settings: self.entries(),
            refused: self.refused.iter().map(|(name, reason)| Refusal { name, reason }).collect(),
        };
        // Plain numbers and strings: there is nothing to refuse.
        serde_json::to_string_pretty(&document).unwrap_or_default() + "\n"
    }

    pub(crate) fn to_csv(&self) -> String {
        let mut text = String::from(
            "name,family,first_seconds,second_seconds,peak_bytes,stored_bytes,rays,pieces,undecided,wrong,border_distance,\
             on_time_front,on_memory_front\n",
        );
        for entry in self.entries() {
            let Entry { name, family, first_seconds, second_seconds, stored_bytes, rays, pieces, .. } = entry;
            let Entry { undecided, wrong, border_distance, on_time_front, on_memory_front, .. } = entry;
            let peak = entry.peak_bytes.map(|bytes| bytes.to_string()).unwrap_or_default();
            let _ = writeln!(
                text,
                "\"{name}\",\"{family}\",{first_seconds},{second_seconds},{peak},{stored_bytes},{rays},{pieces},{undecided},\
                 {wrong},{border_distance},{on_time_front},{on_memory_front}"
            );
        }
        text
    }

    pub(crate) fn to_text(&self) -> String {
        let Self { scene, light, triangles, judged, threads, .. } = self;
        let mut text = format!(
            "{scene}, light {light}: {triangles} triangles, {judged} judged points, {threads} threads\n\
             t, m: on the front of time, of stored memory and error\n\n\
             {:<22}{:>10}{:>11}{:>9}{:>11}{:>12}{:>12}{:>13}{:>11}{:>10}  front\n",
            "setting",
            "first ms",
            "second ms",
            "peak MB",
            "stored MB",
            "rays",
            "pieces",
            "undecided %",
            "wrong %",
            "border m"
        );
        for entry in self.entries() {
            let peak = entry.peak_bytes.map_or_else(|| "-".into(), |bytes| format!("{:.1}", bytes as f64 / 1e6));
            let fronts = [(entry.on_time_front, 't'), (entry.on_memory_front, 'm')];
            let front: String = fronts.into_iter().filter(|(is_on, _)| *is_on).map(|(_, letter)| letter).collect();
            let _ = writeln!(
                text,
                "{:<22}{:>10.2}{:>11.2}{peak:>9}{:>11.3}{:>12}{:>12}{:>13.5}{:>11.5}{:>10.4}  {front}",
                entry.name,
                1e3 * entry.first_seconds,
                1e3 * entry.second_seconds,
                entry.stored_bytes as f64 / 1e6,
                entry.rays,
                entry.pieces,
                100.0 * entry.undecided,
                100.0 * entry.wrong,
                entry.border_distance
            );
        }
        for (name, reason) in &self.refused {
            let _ = writeln!(text, "{name:<22}{reason}");
        }
        text
    }

    /// Error against time and against stored memory, logarithmic.
    pub(crate) fn chart(&self) -> Drawing {
        let mut drawing = Drawing { width: 1000, height: 480, marks: Vec::new() };
        drawing.words([500.0, 20.0], Anchor::Middle, format!("{}, {}", self.scene, self.light), BLACK);
        let [by_time, by_memory] = self.fronts();
        let time = |row: &Row| 1e3 * row.measured.seconds();
        let memory = |row: &Row| row.measured.bytes as f64 / 1e6;
        self.panel(&mut drawing, [70.0, 40.0], "milliseconds after loading", &time, &by_time);
        self.panel(&mut drawing, [560.0, 40.0], "megabytes stored", &memory, &by_memory);
        self.legend(&mut drawing, [70.0, 420.0]);
        drawing
    }

    /// The least error that can be told from none: half a judged point.
    fn least_error(&self) -> f64 {
        0.5 / self.judged.max(1) as f64
    }

    fn panel(
        &self,
        drawing: &mut Drawing,
        [left, top]: [f64; 2],
        title: &str,
        cost: &dyn Fn(&Row) -> f64,
        front: &[bool],
    ) {
        const SIZE: [f64; 2] = [400.0, 310.0];
        let error = |row: &Row| row.measured.score.error().max(self.least_error());
        let points: Vec<[f64; 2]> = self.rows.iter().map(|row| [cost(row).max(1e-6), error(row)]).collect();
        let Some([x, y]) =
            [0, 1].map(|axis| Axis::over(&points, axis)).into_iter().collect::<Option<Vec<_>>>().map(|a| [a[0], a[1]])
        else {
            return;
        };
        let place = |[a, b]: [f64; 2]| [left + x.part(a) * SIZE[0], top + (1.0 - y.part(b)) * SIZE[1]];
        for power in y.powers() {
            let [_, height] = place([x.low, power]);
            drawing.line(&[[left, height], [left + SIZE[0], height]], 1.0, GRAY);
            drawing.words([left - 5.0, height + 4.0], Anchor::End, percent(power), BLACK);
        }
        for power in x.powers() {
            let [at, _] = place([power, y.low]);
            drawing.line(&[[at, top], [at, top + SIZE[1]]], 1.0, GRAY);
            drawing.words([at, top + SIZE[1] + 16.0], Anchor::Middle, format!("{power}"), BLACK);
        }
        drawing.line(&[[left, top], [left, top + SIZE[1]], [left + SIZE[0], top + SIZE[1]]], 1.0, BLACK);
        drawing.words([left + 0.5 * SIZE[0], top + SIZE[1] + 34.0], Anchor::Middle, title, BLACK);
        drawing.words([left + 4.0, top - 4.0], Anchor::Start, "wrong or undecided", BLACK);
        self.curves(drawing, &points, &place);
        for (point, _) in points.iter().zip(front).filter(|(_, is_on)| **is_on) {
            drawing.dot(place(*point), 7.0, BLACK, false);
        }
    }

    /// The settings of each ladder, joined, in the colour of their family.
    fn curves(&self, drawing: &mut Drawing, points: &[[f64; 2]], place: &dyn Fn([f64; 2]) -> [f64; 2]) {
        let mut rest = points;
        for ladder in self.rows.chunk_by(|a, b| a.ladder == b.ladder) {
            let (own, others) = rest.split_at(ladder.len());
            rest = others;
            let own: Vec<[f64; 2]> = own.iter().map(|&point| place(point)).collect();
            let (_, colour) = family(ladder[0].measured.family);
            drawing.line(&own, 1.5, colour);
            own.iter().for_each(|at| drawing.dot(*at, 3.5, colour, true));
        }
    }

    fn families(&self) -> Vec<(Family, Colour)> {
        let mut families: Vec<(Family, Colour)> = Vec::new();
        for row in &self.rows {
            let kind = row.measured.family;
            if families.iter().all(|(known, _)| *known != kind) {
                families.push((kind, family(kind).1));
            }
        }
        families
    }

    fn legend(&self, drawing: &mut Drawing, [left, top]: [f64; 2]) {
        for (number, (kind, colour)) in self.families().into_iter().enumerate() {
            let at = [left + 230.0 * (number % 4) as f64, top + 20.0 * (number / 4) as f64];
            drawing.dot([at[0], at[1] - 4.0], 4.0, colour, true);
            drawing.words([at[0] + 10.0, at[1]], Anchor::Start, family(kind).0, BLACK);
        }
        let at = [left + 690.0, top + 40.0];
        drawing.dot([at[0], at[1] - 4.0], 7.0, BLACK, false);
        drawing.words([at[0] + 12.0, at[1]], Anchor::Start, "beaten by nothing", BLACK);
    }
}

/// A power of ten as per cent, without zeros to spare.
fn percent(share: f64) -> String {
    let text = format!("{:.8}", 100.0 * share);
    format!("{} %", text.trim_end_matches('0').trim_end_matches('.'))
}

/// A logarithmic axis over whole powers of ten.
#[derive(Clone, Copy)]
struct Axis {
    low: f64,
    high: f64,
}

impl Axis {
    fn over(points: &[[f64; 2]], axis: usize) -> Option<Self> {
        let coordinates = || points.iter().map(|point| point[axis]);
        let (low, high) = (coordinates().fold(f64::INFINITY, f64::min), coordinates().fold(0.0, f64::max));
        let (low, high) = (10f64.powf(low.log10().floor()), 10f64.powf(high.log10().ceil()));
        (low > 0.0 && high >= low).then_some(Self { low, high: if high > low { high } else { 10.0 * low } })
    }

    /// Where a value stands, 0 to 1.
    fn part(&self, value: f64) -> f64 {
        (value / self.low).ln() / (self.high / self.low).ln()
    }

    fn powers(&self) -> impl Iterator<Item = f64> + use<> {
        let [low, high] = [self.low, self.high].map(|value| value.log10().round() as i32);
        (low..=high).map(|power| format!("1e{power}").parse().unwrap_or(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbriel_shadow::tradeoff::Score;

    fn row(name: &str, family: Family, seconds: f64, wrong: u64) -> Row {
        let score = Score { points: 1000, wrong, ..Score::default() };
        let measured = Measurement {
            name: name.into(),
            family,
            ready_seconds: 0.0,
            first_seconds: 0.0,
            second_seconds: seconds,
            rays: 0,
            pieces: 1,
            bytes: 1000,
            score,
        };
        Row { measured, ladder: family as usize, peak_bytes: None }
    }

    #[test]
    fn all_forms_tell_the_front() {
        let rows = vec![row("good", Family::Bake, 0.01, 1), row("bad", Family::ShadowMap, 0.02, 5)];
        let tradeoff = Tradeoff { scene: "town".into(), judged: 1000, rows, ..Tradeoff::default() };
        assert!(tradeoff.to_text().contains("0.10000") && tradeoff.to_text().contains("  tm\n"));
        let csv = tradeoff.to_csv();
        assert!(csv.lines().nth(1).is_some_and(|line| line.ends_with("true,true")), "{csv}");
        assert!(csv.lines().nth(2).is_some_and(|line| line.ends_with("false,false")), "{csv}");
        assert!(tradeoff.to_json().contains("\"judged_points\": 1000"));
        let svg = tradeoff.chart().to_svg();
        assert!(svg.contains("milliseconds") && svg.contains("0.1 %"), "{svg}");
        assert!(Tradeoff::default().chart().to_svg().ends_with("</svg>\n"));
    }
}
