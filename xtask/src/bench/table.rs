//! Results as rows: text for the terminal, JSON for programs.

use anyhow::Result;
use serde::Serialize;

use super::{
    clock::Seconds,
    duel::{Own, Peer},
    judge::Verdicts,
    options::short,
    scaling::Series,
};

/// One line of the table.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Row {
    pub(super) scene: String,
    pub(super) triangles: usize,
    /// `samples` of a bake, or loose `points`, `shuffled` or not.
    pub(super) task: &'static str,
    /// The light's name, or how many there are.
    pub(super) light: String,
    pub(super) lights: usize,
    /// As asked for.
    pub(super) samples: u64,
    pub(super) threads: usize,
    pub(super) own: OwnFigures,
    pub(super) embree: Option<PeerFigures>,
    pub(super) rivals: Vec<RivalFigures>,
}

/// What the bake took and found.
#[derive(Clone, Debug, Serialize)]
pub(super) struct OwnFigures {
    pub(super) seconds: Seconds,
    pub(super) memory_bytes: Option<u64>,
    pub(super) samples: u64,
    pub(super) lit: u64,
}

/// What the best configuration of Embree took and found.
#[derive(Clone, Debug, Serialize)]
pub(super) struct PeerFigures {
    pub(super) configuration: String,
    pub(super) build: Seconds,
    pub(super) rays: Seconds,
    pub(super) total: Seconds,
    pub(super) memory_bytes: u64,
    pub(super) lit: u64,
    /// The places that the two answer differently, decided exactly.
    pub(super) differing: Option<Verdicts>,
}

/// What single rays through a tree in Rust took and found, the build included.
#[derive(Clone, Debug, Serialize)]
pub(super) struct RivalFigures {
    pub(super) name: &'static str,
    pub(super) total: Seconds,
    pub(super) lit: u64,
}

impl OwnFigures {
    pub(super) fn new(own: &Own, memory_bytes: Option<u64>) -> Self {
        Self { seconds: own.seconds, memory_bytes, samples: own.samples, lit: own.lit }
    }
}

impl PeerFigures {
    pub(super) fn new(peer: Peer, differing: Option<Verdicts>) -> Self {
        Self {
            configuration: peer.setup.to_string(),
            build: peer.build,
            rays: peer.rays,
            total: peer.total(),
            memory_bytes: peer.memory,
            lit: peer.lit,
            differing,
        }
    }
}

impl Row {
    /// How many times as long Embree takes: by processor time on one thread, on several by the clock.
    pub(super) fn ratio(&self) -> Option<f64> {
        let measure = |seconds: Seconds| if self.threads == 1 { seconds.cpu } else { seconds.wall };
        self.embree.as_ref().map(|peer| measure(peer.total) / measure(self.own.seconds))
    }

    /// The line; times are seconds of processor time and, behind a bar, by the clock.
    pub(super) fn line(&self) -> String {
        let own = &self.own;
        let head = format!(
            "{:<8} {:<8} {:<8} {:>5} {:>2}  {:>7.3}|{:<7.3} {:>6}",
            self.scene,
            self.task,
            self.light,
            short(self.samples),
            self.threads,
            own.seconds.cpu,
            own.seconds.wall,
            mebibytes(own.memory_bytes)
        );
        let rivals: String = self.rivals.iter().map(|rival| self.rival_line(rival)).collect();
        let Some(peer) = &self.embree else { return head + &rivals };
        let differing = peer.differing.map(|verdicts| format!(", differing: {verdicts}")).unwrap_or_default();
        format!(
            "{head}  {:>7.3}|{:<7.3} {:>6}  {:<23} {:>7.2}  {:+} lit{differing}{rivals}",
            peer.total.cpu,
            peer.total.wall,
            mebibytes(Some(peer.memory_bytes)),
            peer.configuration,
            self.ratio().unwrap_or(f64::NAN),
            peer.lit as i64 - own.lit as i64
        )
    }

    fn rival_line(&self, rival: &RivalFigures) -> String {
        let (total, ratio) = (rival.total, rival.total.cpu / self.own.seconds.cpu);
        format!(
            "\n{:47}{:>7.3}|{:<7.3} {:>6}  {:<23} {ratio:>7.2}  {:+} lit",
            "",
            total.cpu,
            total.wall,
            "",
            rival.name,
            rival.lit as i64 - self.own.lit as i64
        )
    }
}

/// The names of the columns of [`Row::line`].
pub(super) fn heading() -> String {
    format!(
        "{:<8} {:<8} {:<8} {:>5} {:>2}  {:>7}|{:<7} {:>6}  {:>7}|{:<7} {:>6}  {:<23} {:>7}  lit against own",
        "scene",
        "task",
        "light",
        "n",
        "th",
        "own cpu",
        "wall",
        "MiB",
        "Embree",
        "wall",
        "MiB",
        "best configuration",
        "ratio"
    )
}

fn mebibytes(bytes: Option<u64>) -> String {
    bytes.map_or_else(|| "-".into(), |bytes| format!("{:.0}", bytes as f64 / f64::from(1 << 20)))
}

/// All rows and series as JSON.
pub(super) fn json(rows: &[Row], series: &[Series]) -> Result<String> {
    #[derive(Serialize)]
    struct Document<'a> {
        schema: u32,
        umbriel: &'a str,
        threads_of_the_machine: usize,
        rows: Vec<Line<'a>>,
        series: &'a [Series],
    }
    #[derive(Serialize)]
    struct Line<'a> {
        #[serde(flatten)]
        row: &'a Row,
        ratio: Option<f64>,
    }
    let rows = rows.iter().map(|row| Line { row, ratio: row.ratio() }).collect();
    let threads_of_the_machine = std::thread::available_parallelism().map_or(1, usize::from);
    let document = Document { schema: 1, umbriel: env!("CARGO_PKG_VERSION"), threads_of_the_machine, rows, series };
    Ok(serde_json::to_string_pretty(&document)? + "\n")
}
