//! `umbriel query`: exact answers to single points, one row a point and one column a light.

use std::{
    fs::{self, File},
    io,
    path::Path,
    sync::atomic::{AtomicU64, Ordering},
};

use rayon::prelude::*;
use umbriel_io::write::{PointRow, PointTable, PointsError, Staged, Table, read_points};
use umbriel_scene::Scene;
use umbriel_shadow::{Answer, Cancelled, Place, Precision, Progress, Queries, QueryDefect};

use crate::{
    cli::{Failure, args::QueryArgs, plan},
    output::{self, Format},
    progress::{Bar, Interrupt},
};

/// Points answered between two looks at the interrupt flag.
const CHUNK: usize = 256;

pub(crate) fn run(args: &QueryArgs) -> Result<(), Failure> {
    let files = output::targets(&args.output, &[Format::Csv], &[&args.scene.scene, &args.points])?;
    let points = read(&args.points)?;
    let mut loaded = plan::load(&args.scene)?;
    output::check_unread(&files, &loaded.file.files)?;
    let interrupt = &Interrupt::install();
    let lights = plan::choose_lights(&mut loaded.file, &args.lights, &args.scene.scene)?;
    let scene = &loaded.file.scene;
    plan::tell_findings(scene, args.scene.quiet);
    let places = places(scene, &points).map_err(|defect| defect.in_file(&args.points))?;
    let bar = Bar::new(interrupt, args.scene.quiet);
    let answers = answer(scene, &places, &lights, &bar)?;
    drop(bar);
    let answers = answers.map_err(|(row, defect)| Refusal { line: points.lines[row], message: defect.to_string() });
    let answers = answers.map_err(|refusal| refusal.in_file(&args.points))?;
    tell_in_space(&answers, args.scene.quiet);
    let table = answered(scene, &lights, points.text, &answers);
    if files.is_empty() {
        let mut text = Vec::new();
        table.write(&mut text).map_err(|error| Failure::of_output(&error))?;
        return output::print(&String::from_utf8_lossy(&text));
    }
    let stage = |file: &output::Target| Staged::new(&file.path, |out| table.write(out));
    let staged = files.iter().map(stage).collect::<Result<Vec<_>, _>>()?;
    interrupt.check()?;
    output::commit_all(staged)
}

fn read(path: &Path) -> Result<PointTable, Failure> {
    let unreadable = |error| Failure::Unusable(format!("{} cannot be read: {error}", path.display()));
    // A pipe or a device may never end.
    if !fs::metadata(path).map_err(unreadable)?.is_file() {
        return Err(unreadable(io::Error::new(io::ErrorKind::InvalidInput, "it is not a regular file")));
    }
    let file = File::open(path).map_err(unreadable)?;
    read_points(file).map_err(|error| match error {
        PointsError::Unreadable(error) => unreadable(error),
        defect => Failure::Refused(format!("{}: {defect}", path.display())),
    })
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

fn places(scene: &Scene, points: &PointTable) -> Result<Vec<Place>, Refusal> {
    let numbers = scene.objects.iter().enumerate().map(|(number, object)| (object.name.as_str(), number));
    let numbers: std::collections::HashMap<&str, usize> = numbers.collect();
    let place = |(point, &line): (&PointRow, &u64)| match point {
        PointRow::Position(position) => Ok(Place::Free { position: *position }),
        PointRow::PositionAndNormal(position, normal) => {
            Ok(Place::Oriented { position: *position, normal: *normal, precision: Precision::Double })
        }
        PointRow::Surface { object: name, face, u, v } => {
            let object = *numbers.get(name.as_str()).ok_or_else(|| Refusal {
                line,
                message: format!("there is no object \"{name}\"; `umbriel info` lists the names"),
            })?;
            let faces = scene.objects[object].face_count();
            if *face >= faces {
                let message = format!("face {face}: \"{name}\" has faces 0 to {}", faces.saturating_sub(1));
                return Err(Refusal { line, message });
            }
            Ok(Place::Surface { object, face: *face, u: *u, v: *v })
        }
    };
    points.points.iter().zip(&points.lines).map(place).collect()
}

/// One answer a light for every place, or the first row that is refused and why.
type Answers = Result<Vec<Vec<Answer>>, (usize, QueryDefect)>;

fn answer(scene: &Scene, places: &[Place], lights: &[usize], bar: &Bar) -> Result<Answers, Cancelled> {
    let queries = Queries::new(scene);
    let (done, total) = (AtomicU64::new(0), places.len() as u64);
    let one = |row: usize, place: &Place| -> Result<Vec<Answer>, (usize, QueryDefect)> {
        let lit = |&light: &usize| queries.lit(place, &scene.lights[light].source);
        lights.iter().map(lit).collect::<Result<_, _>>().map_err(|defect| (row, defect))
    };
    let chunk = |(number, places): (usize, &[Place])| -> Result<Vec<Result<Vec<Answer>, _>>, Cancelled> {
        if bar.is_cancelled() {
            return Err(Cancelled);
        }
        let answers = places.iter().enumerate().map(|(i, place)| one(number * CHUNK + i, place)).collect();
        let now = done.fetch_add(places.len() as u64, Ordering::Relaxed) + places.len() as u64;
        bar.advance("points", now, total);
        Ok(answers)
    };
    let chunks = places.par_chunks(CHUNK).enumerate().map(chunk).collect::<Result<Vec<_>, Cancelled>>()?;
    Ok(chunks.into_iter().flatten().collect())
}

fn tell_in_space(answers: &[Vec<Answer>], quiet: bool) {
    let in_space = answers.iter().filter(|row| row.iter().any(|answer| answer.in_space)).count();
    if in_space > 0 && !quiet {
        output::tell(&format!("note: {in_space} points with a normal lie on no surface; taken as points in space"));
    }
}

/// The rows as they came, with a column a light: 1 lit, 0 not.
fn answered(scene: &Scene, lights: &[usize], mut table: Table, answers: &[Vec<Answer>]) -> Table {
    table.header.extend(lights.iter().map(|&light| scene.lights[light].name.clone()));
    for (row, answers) in table.rows.iter_mut().zip(answers) {
        row.extend(answers.iter().map(|answer| u8::from(answer.lit).to_string()));
    }
    table
}
