//! `umbriel query`: exact answers to single points, one row a point and one column a light. For lights with an extent the answer is the
//! share of the light that reaches the point.

use std::{
    fs::{self, File},
    io::{self, Write},
    path::Path,
    sync::atomic::{AtomicU64, Ordering},
};

use rayon::prelude::*;
use umbriel_io::{
    npy::{NpyError, NpyPoints, read_npy_points, write_npy_bytes},
    write::{PointRow, PointTable, PointsError, Staged, read_points, write_rows},
};
use umbriel_scene::{FindingKind, Light, Scene};
use umbriel_shadow::{
    Cancelled, Expected, FacePoint, Fraction, Place, Points, PointsError as NoAnswer, Progress, Queries, QueryDefect,
    SearchCosts,
};

use crate::{
    cli::{Failure, acceleration, args::QueryArgs, plan},
    output::{self, Format},
    progress::{Bar, Interrupt},
};

/// Points of faces answered between two looks at the interrupt flag.
const CHUNK: usize = 256;

pub(crate) fn run(args: &QueryArgs) -> Result<(), Failure> {
    let files = output::targets(&args.output, &[Format::Csv, Format::Npy], &[&args.scene.scene, &args.points])?;
    let asked = Asked::read(&args.points)?;
    let mut loaded = plan::load(&args.scene)?;
    output::check_unread(&files, &loaded.file.files)?;
    let interrupt = &Interrupt::install();
    let lights = plan::choose_lights(&mut loaded.file, &args.lights, &args.scene.scene)?;
    // Here lights are what they are.
    loaded.file.scene.findings.retain(|finding| finding.kind != FindingKind::AreaLightAsPoint);
    if lights.iter().any(|&light| !loaded.file.scene.lights[light].extent.is_point()) {
        plan::add_masks_as_opaque(&mut loaded.file.scene);
    }
    let scene = &loaded.file.scene;
    check_forms(&files, lights.iter().map(|&light| &scene.lights[light]))?;
    plan::tell_findings(scene, args.scene.quiet);
    let places = asked.places(scene).map_err(|refusal| refusal.in_file(&args.points))?;
    let bar = Bar::new(interrupt, args.scene.quiet);
    let queries = prepared(args, scene, &lights, &places);
    let column = |&light: &usize| {
        let column = places.column(&queries, &scene.lights[light], &bar)?;
        Ok(if args.errors { column.with_errors() } else { column })
    };
    let answers = lights.iter().map(column).collect::<Result<Vec<_>, _>>();
    let answers = answers.map_err(|error| asked.failure(error, &args.points))?;
    if !args.scene.quiet {
        let in_space = places.count_in_space(&queries, &bar).map_err(|error| asked.failure(error, &args.points))?;
        drop(bar);
        tell_in_space(in_space);
    }
    let names: Vec<&str> = lights.iter().map(|&light| scene.lights[light].name.as_str()).collect();
    let result = Answered { asked: &asked, names, answers };
    if files.is_empty() {
        let mut text = Vec::new();
        result.write_csv(&mut text).map_err(|error| Failure::of_output(&error))?;
        return output::print(&String::from_utf8_lossy(&text));
    }
    let stage = |file: &output::Target| Staged::new(&file.path, |out| result.write(file.format, out));
    let staged = files.iter().map(stage).collect::<Result<Vec<_>, _>>()?;
    interrupt.check()?;
    output::commit_all(staged)
}

/// Ready for the points under each light, which is told. Shares of area lights are not found by rays to one point.
fn prepared<'a>(args: &QueryArgs, scene: &'a Scene, lights: &[usize], places: &Places) -> Queries<'a> {
    let mut queries = Queries::new(scene);
    let (asked, expected) = (args.acceleration.of_rays(), Expected::Loose(places.points().len() as u64));
    let lights = lights.iter().map(|&light| &scene.lights[light]).filter(|light| light.extent.is_point());
    let prepare = |light: &'a Light| {
        (light.name.as_str(), queries.prepare(&light.source, expected, asked, &SearchCosts::MEASURED))
    };
    let choices: Vec<_> = lights.map(prepare).collect();
    if !args.scene.quiet {
        acceleration::tell_lights(choices.iter().map(|(name, choice)| (*name, choice)));
    }
    queries
}

/// Whether the files can hold the answers: bytes hold no shares.
fn check_forms<'a>(files: &[output::Target], mut lights: impl Iterator<Item = &'a Light>) -> Result<(), Failure> {
    let has_bytes = files.iter().any(|file| file.format == Format::Npy);
    match lights.find(|light| has_bytes && !light.extent.is_point()) {
        None => Ok(()),
        Some(Light { name, .. }) => Err(Failure::Unusable(format!(
            "light \"{name}\" has an extent: its answers are shares, which a .npy of bytes cannot hold; write a .csv, or choose \
             other lights with --light"
        ))),
    }
}

/// The answers for one light.
enum Column {
    /// Lit or not.
    Lit(Vec<bool>),
    /// The share of an area light that reaches the point.
    Shares(Vec<Fraction>),
    /// The same, and by how much the truth may differ.
    SharesAndErrors(Vec<Fraction>),
}

impl Column {
    /// What is a share is told with its error.
    fn with_errors(self) -> Self {
        match self {
            Self::Shares(shares) => Self::SharesAndErrors(shares),
            other => other,
        }
    }

    fn len(&self) -> usize {
        match self {
            Self::Lit(lit) => lit.len(),
            Self::Shares(shares) | Self::SharesAndErrors(shares) => shares.len(),
        }
    }

    /// The headings of its columns.
    fn names(&self, light: &str) -> Vec<String> {
        match self {
            Self::Lit(_) | Self::Shares(_) => vec![light.to_owned()],
            Self::SharesAndErrors(_) => vec![light.to_owned(), format!("{light}_error")],
        }
    }

    /// As many texts as headings.
    fn texts(&self, row: usize) -> Vec<String> {
        match self {
            Self::Lit(lit) => vec![u8::from(lit[row]).to_string()],
            Self::Shares(shares) => texts(&[shares[row].value]),
            Self::SharesAndErrors(shares) => texts(&[shares[row].value, shares[row].max_error]),
        }
    }

    fn byte(&self, row: usize) -> u8 {
        match self {
            Self::Lit(lit) => u8::from(lit[row]),
            Self::Shares(shares) | Self::SharesAndErrors(shares) => u8::from(shares[row].value > 0.0),
        }
    }
}

/// The points as they came.
enum Asked {
    Table(PointTable),
    Array(NpyPoints),
}

impl Asked {
    fn read(path: &Path) -> Result<Self, Failure> {
        let unreadable = |error| Failure::Unusable(format!("{} cannot be read: {error}", path.display()));
        // A pipe or a device may never end.
        if !fs::metadata(path).map_err(unreadable)?.is_file() {
            return Err(unreadable(io::Error::new(io::ErrorKind::InvalidInput, "it is not a regular file")));
        }
        let file = File::open(path).map_err(unreadable)?;
        if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("npy")) {
            return read_npy_points(file).map(Self::Array).map_err(|error| match error {
                NpyError::Unreadable(error) => unreadable(error),
                defect => Failure::Refused(format!("{}: {defect}", path.display())),
            });
        }
        read_points(file).map(Self::Table).map_err(|error| match error {
            PointsError::Unreadable(error) => unreadable(error),
            defect => Failure::Refused(format!("{}: {defect}", path.display())),
        })
    }

    /// The points as queries take them.
    fn places(&self, scene: &Scene) -> Result<Places<'_>, Refusal> {
        Ok(match self {
            Self::Array(NpyPoints::PositionsSingle(rows)) => Places::Given(Points::FreeSingle(rows)),
            Self::Array(NpyPoints::PositionsDouble(rows)) => Places::Given(Points::FreeDouble(rows)),
            Self::Array(NpyPoints::NormalsSingle(rows)) => Places::Given(Points::OrientedSingle(rows)),
            Self::Array(NpyPoints::NormalsDouble(rows)) => Places::Given(Points::OrientedDouble(rows)),
            Self::Table(table) => Places::of_table(table, scene)?,
        })
    }

    /// Why there are no answers, with the line or row of the file.
    fn failure(&self, error: NoAnswer, path: &Path) -> Failure {
        match error {
            NoAnswer::Refused { index, defect } => match self {
                Self::Table(table) => Refusal { line: table.lines[index], message: defect.to_string() }.in_file(path),
                Self::Array(_) => Failure::Refused(format!("{}: row {index}: {defect}", path.display())),
            },
            _ => Cancelled.into(),
        }
    }
}

/// A row that has no answer.
struct Refusal {
    line: u64,
    message: String,
}

impl Refusal {
    fn in_file(self, path: &Path) -> Failure {
        Failure::Refused(format!("{}: line {}: {}", path.display(), self.line, self.message))
    }
}

/// Where the points are.
enum Places<'a> {
    Given(Points<'a>),
    Free(Vec<[f64; 3]>),
    Oriented(Vec<[f64; 6]>),
    OnFaces(Vec<FacePoint>),
}

impl Places<'_> {
    /// All rows of a table are of one kind.
    fn of_table(table: &PointTable, scene: &Scene) -> Result<Self, Refusal> {
        let numbers = scene.objects.iter().enumerate().map(|(number, object)| (object.name.as_str(), number));
        let numbers: std::collections::HashMap<&str, usize> = numbers.collect();
        let (mut free, mut oriented, mut on_faces) = (Vec::new(), Vec::new(), Vec::new());
        for (point, &line) in table.points.iter().zip(&table.lines) {
            match point {
                PointRow::Position(position) => free.push(*position),
                PointRow::PositionAndNormal([x, y, z], [nx, ny, nz]) => oriented.push([*x, *y, *z, *nx, *ny, *nz]),
                PointRow::Surface { object: name, face, u, v } => {
                    let object = numbers.get(name.as_str()).copied().ok_or_else(|| Refusal {
                        line,
                        message: format!("there is no object \"{name}\"; `umbriel info` lists the names"),
                    })?;
                    let faces = scene.objects[object].face_count();
                    if *face >= faces {
                        let message = format!("face {face}: \"{name}\" has faces 0 to {}", faces.saturating_sub(1));
                        return Err(Refusal { line, message });
                    }
                    on_faces.push(FacePoint::new(object, *face, *u, *v));
                }
            }
        }
        Ok(match (free.is_empty(), oriented.is_empty()) {
            (false, _) => Self::Free(free),
            (_, false) => Self::Oriented(oriented),
            _ => Self::OnFaces(on_faces),
        })
    }

    /// All of them.
    fn points(&self) -> Points<'_> {
        match self {
            Self::Given(points) => *points,
            Self::Free(rows) => Points::FreeDouble(rows),
            Self::Oriented(rows) => Points::OrientedDouble(rows),
            Self::OnFaces(points) => Points::OnFaces(points),
        }
    }

    /// The answers for a light: lit or not, or for an area light shares.
    fn column(&self, queries: &Queries, light: &Light, bar: &Bar) -> Result<Column, NoAnswer> {
        if light.extent.is_point() {
            return queries.lit_many(self.points(), &light.source, bar).map(Column::Lit);
        }
        let share = |place: &Place| queries.visible_fraction(place, light);
        answer_each(&self.listed(), share, bar).map(Column::Shares)
    }

    /// The points one by one.
    fn listed(&self) -> Vec<Place> {
        let points = self.points();
        (0..points.len()).map(|index| points.place(index)).collect()
    }

    fn count_in_space(&self, queries: &Queries, bar: &Bar) -> Result<usize, NoAnswer> {
        // Only points with a normal are meant to lie on a surface.
        let points @ (Points::OrientedSingle(_) | Points::OrientedDouble(_)) = self.points() else { return Ok(0) };
        let in_space = queries.in_space_many(points, bar)?;
        Ok(in_space.into_iter().filter(|&is_in_space| is_in_space).count())
    }
}

/// Answers points one by one, on all threads.
fn answer_each<T: Send>(
    places: &[Place],
    answer: impl Fn(&Place) -> Result<T, QueryDefect> + Sync,
    bar: &Bar,
) -> Result<Vec<T>, NoAnswer> {
    let (done, total) = (AtomicU64::new(0), places.len() as u64);
    // The first row that is refused is told, whichever thread comes first.
    let chunk = |places: &[Place]| -> Result<Vec<Result<T, QueryDefect>>, Cancelled> {
        if bar.is_cancelled() {
            return Err(Cancelled);
        }
        let answers = places.iter().map(&answer).collect();
        let now = done.fetch_add(places.len() as u64, Ordering::Relaxed) + places.len() as u64;
        bar.advance("points", now, total);
        Ok(answers)
    };
    let chunks = places.par_chunks(CHUNK).map(chunk).collect::<Result<Vec<_>, Cancelled>>()?;
    let answers = chunks.into_iter().flatten().enumerate();
    answers.map(|(index, answer)| answer.map_err(|defect| NoAnswer::Refused { index, defect })).collect()
}

fn tell_in_space(count: usize) {
    if count > 0 {
        output::tell(&format!("note: {count} points with a normal lie on no surface; taken as points in space"));
    }
}

/// Points and their answers, a list a light.
struct Answered<'a> {
    asked: &'a Asked,
    names: Vec<&'a str>,
    answers: Vec<Column>,
}

impl Answered<'_> {
    fn write(&self, format: Format, out: &mut impl Write) -> io::Result<()> {
        match format {
            Format::Npy => write_npy_bytes(self.answers.len(), &self.bytes(), out),
            _ => self.write_csv(out),
        }
    }

    /// A byte a point and light, row by row.
    fn bytes(&self) -> Vec<u8> {
        let count = self.answers.first().map_or(0, Column::len);
        (0..count).flat_map(|row| self.answers.iter().map(move |column| column.byte(row))).collect()
    }

    /// The rows as they came, with a column a light: 1 lit, 0 not, of an area light the share that reaches the point; where errors are asked for, a
    /// second one by how much the truth may differ.
    fn write_csv(&self, out: &mut impl Write) -> io::Result<()> {
        let columns: Vec<&str> = match self.asked {
            Asked::Table(table) => table.text.header.iter().map(String::as_str).collect(),
            Asked::Array(NpyPoints::PositionsSingle(_) | NpyPoints::PositionsDouble(_)) => vec!["x", "y", "z"],
            Asked::Array(_) => vec!["x", "y", "z", "nx", "ny", "nz"],
        };
        let of_lights: Vec<String> =
            self.answers.iter().zip(&self.names).flat_map(|(column, light)| column.names(light)).collect();
        let header: Vec<&str> = columns.into_iter().chain(of_lights.iter().map(String::as_str)).collect();
        let count = match self.asked {
            Asked::Table(table) => table.points.len(),
            Asked::Array(points) => points.len(),
        };
        let row = |row: usize| {
            let answers = self.answers.iter().flat_map(move |column| column.texts(row));
            self.asked.fields(row).into_iter().chain(answers)
        };
        write_rows(&header, (0..count).map(row), out)
    }
}

impl Asked {
    /// A row as it came; numbers of an array by as many digits as tell them apart.
    fn fields(&self, row: usize) -> Vec<String> {
        match self {
            Self::Table(table) => table.text.rows[row].clone(),
            Self::Array(NpyPoints::PositionsSingle(rows)) => texts(&rows[row]),
            Self::Array(NpyPoints::PositionsDouble(rows)) => texts(&rows[row]),
            Self::Array(NpyPoints::NormalsSingle(rows)) => texts(&rows[row]),
            Self::Array(NpyPoints::NormalsDouble(rows)) => texts(&rows[row]),
        }
    }
}

fn texts(numbers: &[impl ToString]) -> Vec<String> {
    numbers.iter().map(ToString::to_string).collect()
}
