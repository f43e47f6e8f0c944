//! The law of the costs: a straight line through each series of times.
//!
//! Times vary by orders of magnitude, so each point counts by its relative error: the line a + b·x minimises Σ ((a + b·x)/t − 1)².

use std::fmt;

use super::{scaling::Series, table::Row};

/// seconds = fixed + slope · number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Law {
    pub(super) fixed: f64,
    pub(super) slope: f64,
    /// The greatest relative difference between the line and what was measured.
    pub(super) off: f64,
}

impl Law {
    /// The line through (number, seconds). `None` for fewer than two different numbers.
    pub(super) fn through(points: &[(f64, f64)]) -> Option<Self> {
        // Normal equations with p = 1/t, q = x/t against 1.
        let sums = points.iter().fold([0.0; 5], |[pp, pq, qq, p1, q1], &(x, t)| {
            let (p, q) = (1.0 / t, x / t);
            [pp + p * p, pq + p * q, qq + q * q, p1 + p, q1 + q]
        });
        let [pp, pq, qq, p1, q1] = sums;
        let determinant = pp * qq - pq * pq;
        let is_line = points.iter().any(|&(x, _)| x != points[0].0) && determinant > 0.0;
        is_line.then(|| {
            let (fixed, slope) = ((p1 * qq - q1 * pq) / determinant, (q1 * pp - p1 * pq) / determinant);
            let off = points.iter().map(|&(x, t)| ((fixed + slope * x) / t - 1.0).abs()).fold(0.0, f64::max);
            Self { fixed, slope, off }
        })
    }
}

impl fmt::Display for Law {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let Self { fixed, slope, off } = self;
        write!(formatter, "{:.1} ms + {:.2} ns each, within {:.0} %", fixed * 1e3, slope * 1e9, off * 100.0)
    }
}

/// A line of text a series: the laws of both sides, and what follows for threads.
pub(super) fn describe(series: &Series) -> String {
    let own = |row: &Row| row.own.seconds;
    let line = |seconds: &dyn Fn(&Row) -> Option<f64>| {
        let points: Option<Vec<(f64, f64)>> =
            series.points.iter().map(|(number, row)| Some((*number as f64, seconds(row)?))).collect();
        points.and_then(|points| Law::through(&points)).map_or_else(|| "unknown".into(), |law| law.to_string())
    };
    if series.over == "threads" {
        let walls = series.points.iter().map(|(_, row)| own(row).wall);
        let first = walls.clone().next().unwrap_or(f64::NAN);
        let gains: Vec<String> = walls.map(|wall| format!("{:.2}", first / wall)).collect();
        return format!("over threads, times as fast as one: {}", gains.join(", "));
    }
    let peer = line(&|row| row.embree.as_ref().map(|peer| peer.total.cpu));
    format!("over {}: {}; Embree {peer}", series.over, line(&|row| Some(own(row).cpu)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_found() {
        let law = Law::through(&[(1.0, 5.0), (10.0, 23.0), (1000.0, 2003.0)]).expect("a line");
        assert!((law.fixed - 3.0).abs() < 1e-9 && (law.slope - 2.0).abs() < 1e-9 && law.off < 1e-9, "{law:?}");
        assert_eq!(Law::through(&[(2.0, 1.0), (2.0, 1.5)]), None);
        assert_eq!(Law::through(&[]), None);
    }

    #[test]
    fn what_is_no_line_is_told() {
        let law = Law::through(&[(1.0, 1.0), (2.0, 4.0), (3.0, 9.0)]).expect("a line");
        assert!(law.off > 0.1, "{law:?}");
    }
}
