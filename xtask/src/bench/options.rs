//! What a run of the benchmark measures.

use std::path::PathBuf;

use super::scenes::CLASSES;

/// The whole job against ray engines, in one run and in turn.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct Options {
    /// A quick look: small scenes, 256k samples, two runs
    #[arg(long)]
    pub(super) small: bool,
    /// Only these scenes
    #[arg(long, value_name = "NAME", value_delimiter = ',', value_parser = scene_name)]
    pub(super) scene: Vec<String>,
    /// Scenes of one's own: files that the library reads, with their lights, or else two suns and a lamp
    #[arg(long, value_name = "FILE", conflicts_with_all = ["proofs", "exact", "scaling", "memory"])]
    pub(super) file: Vec<PathBuf>,
    /// Only these lights: `high sun`, `low sun`, `lamp`
    #[arg(long, value_name = "NAME", value_delimiter = ',', value_parser = ["high sun", "low sun", "lamp"])]
    pub(super) light: Vec<String>,
    /// Numbers of samples; k is 2^10, M is 2^20
    #[arg(long, value_name = "N", value_delimiter = ',', default_value = "4M", value_parser = count)]
    pub(super) samples: Vec<u64>,
    /// Numbers of threads
    #[arg(long, value_name = "N", value_delimiter = ',', default_value = "1")]
    pub(super) threads: Vec<usize>,
    /// Runs of each side, of which the quickest counts
    #[arg(long, value_name = "N", default_value_t = 5)]
    pub(super) runs: usize,
    /// Loose points off the surface, in its order and in a random one, instead of samples
    #[arg(long)]
    pub(super) points: bool,
    /// Also single rays through trees in Rust: the workspace's own, and others with `--features rivals`
    #[arg(long)]
    pub(super) rivals: bool,
    /// Only series over samples, triangles, lights and threads
    #[arg(long)]
    pub(super) scaling: bool,
    /// Only proofs on the ground beside as many samples: times, and what is left undecided
    #[arg(long)]
    pub(super) proofs: bool,
    /// Only what the exact levels of the filters take
    #[arg(long)]
    pub(super) exact: bool,
    /// Write all figures
    #[arg(long, value_name = "FILE")]
    pub(super) json: Option<PathBuf>,
    /// Draw the ratios and the series
    #[arg(long, value_name = "FILE.svg")]
    pub(super) chart: Option<PathBuf>,
    /// Only the benchmarks of the single layers (`cargo bench`)
    #[arg(long)]
    pub(super) micro: bool,
    /// Only what `cargo xtask ci` asks: no collapse against single rays through a tree
    #[arg(long)]
    pub(super) guard: bool,
    /// Only the peak memory of one bake, bytes; in a process of its own nothing else is counted
    #[arg(long, hide = true)]
    pub(super) memory: bool,
}

impl Options {
    /// With what `--small` stands for.
    pub(super) fn completed(mut self) -> Self {
        if self.small {
            self.samples = vec![1 << 18];
            self.runs = self.runs.min(2);
            if self.scene.is_empty() && self.file.is_empty() {
                self.scene = ["bunny", "spot", "delft", "city"].map(String::from).to_vec();
            }
        }
        self
    }
}

/// `4M`, `256k`, `1000`.
pub(super) fn count(text: &str) -> Result<u64, String> {
    let (digits, unit) = match text.as_bytes().last() {
        Some(b'k') => (&text[..text.len() - 1], 1 << 10),
        Some(b'M') => (&text[..text.len() - 1], 1 << 20),
        _ => (text, 1),
    };
    let number: u64 = digits.parse().map_err(|_| format!("{text} is no number of samples"))?;
    number.checked_mul(unit).filter(|&count| count > 0).ok_or_else(|| format!("{text} is out of range"))
}

/// `4M` for 4,194,304.
pub(super) fn short(count: u64) -> String {
    match count {
        _ if count.is_multiple_of(1 << 20) => format!("{}M", count >> 20),
        _ if count.is_multiple_of(1 << 10) => format!("{}k", count >> 10),
        _ => count.to_string(),
    }
}

fn scene_name(text: &str) -> Result<String, String> {
    let known = CLASSES.map(|class| class.name);
    let is_known = known.contains(&text);
    is_known.then(|| text.to_owned()).ok_or_else(|| format!("the scenes are {}", known.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_have_units() {
        assert_eq!(count("4M"), Ok(4_194_304));
        assert_eq!(count("256k").map(short).as_deref(), Ok("256k"));
        assert_eq!(count("1000"), Ok(1000));
        for wrong in ["", "M", "0", "-1", "4G", "99999999999999999M"] {
            assert!(count(wrong).is_err(), "{wrong}");
        }
    }
}
