//! Pieces of charts: logarithmic axes, words and lines of an SVG.

use std::fmt::Write;

/// A logarithmic axis.
pub(crate) struct Axis {
    pub(crate) min: f64,
    pub(crate) max: f64,
}

impl Axis {
    /// From the least to the greatest coordinate; `None` without points.
    pub(crate) fn over(points: &[[f64; 2]], axis: usize) -> Option<Self> {
        let coordinates = || points.iter().map(|point| point[axis]);
        let (min, max) = (coordinates().fold(f64::INFINITY, f64::min), coordinates().fold(0.0, f64::max));
        (min > 0.0 && max >= min).then_some(Self { min, max })
    }

    /// With a tenth of room on either side of the values.
    pub(crate) fn around(values: &[f64]) -> Self {
        let (min, max) = values.iter().fold((f64::MAX, 0.0f64), |(min, max), &x| (min.min(x), max.max(x)));
        Self { min: min / 1.1, max: max * 1.1 }
    }

    /// Where a value stands, 0 to 1.
    pub(crate) fn part(&self, value: f64) -> f64 {
        let width = (self.max / self.min).ln();
        if width > 0.0 { (value / self.min).ln() / width } else { 0.5 }
    }

    /// Whether a value stands on it.
    pub(crate) fn holds(&self, value: f64) -> bool {
        (self.min..=self.max).contains(&value)
    }

    /// 1, 2 and 5 times powers of ten inside.
    pub(crate) fn ticks(&self) -> impl Iterator<Item = f64> {
        let values = (-6..6).flat_map(|power| [1.0, 2.0, 5.0].map(|digit| digit * 10f64.powi(power)));
        values.filter(|value| self.holds(*value))
    }
}

pub(crate) fn text(body: &mut String, [x, y]: [f64; 2], anchor: &str, words: &str) {
    let _ = writeln!(body, "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{words}</text>");
}

pub(crate) fn stroke(body: &mut String, points: &[[f64; 2]], colour: &str) {
    let path: Vec<String> = points.iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
    let _ = writeln!(body, "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\"/>", path.join(" "));
}
