//! Primitives: vertices and the triangles between them, from accessors or a Draco stream, morphed by their weights.
//!
//! Exporters like to share one vertex buffer among many primitives, so an accessor is decoded once, and a primitive costs the corners
//! that it has, not the vertices that it could have.

mod attributes;

use std::{
    collections::{HashMap, HashSet},
    rc::Rc,
};

use umbriel_geometry::{AXES, accept_point};
use umbriel_scene::FindingKind;

use super::{
    accessor::{Accessors, Component, within},
    draco,
    hierarchy::clear_tiny,
    json::{Accessor, DracoPrimitive, Primitive},
    textures::MaskMaterial,
};
use crate::{error::LoadProblem, model::Findings, triangulate::SIX_DIGITS};

/// The extension that compresses primitives.
const DRACO: &str = "KHR_draco_mesh_compression";

/// What a primitive without vertices costs, in elements: a mesh is read again for every set of morph weights.
const PRIMITIVE: usize = 16;

/// The content of a primitive: the vertices that its triangles use, in the order of the file.
pub(super) struct Geometry {
    pub(super) vertices: Vec<[f64; 3]>,
    /// Corners, as numbers of these vertices.
    pub(super) faces: Vec<[u32; 3]>,
    /// The texture coordinates that lay out light maps, one pair a vertex, if they are wanted and there.
    pub(super) texture: Option<Vec<[f64; 2]>>,
    /// What cuts it out, if something does.
    pub(super) mask: MaskVertices,
}

/// What the vertices of a primitive say about its cut-out; nothing where that is not there or not wanted.
#[derive(Default)]
pub(super) struct MaskVertices {
    /// Texture coordinates.
    pub(super) places: Option<Vec<[f64; 2]>>,
    /// Alphas of vertex colours, 0 to 1.
    pub(super) alphas: Option<Vec<f64>>,
}

/// Elements that primitives may share, one a vertex.
type Shared<T> = Rc<Vec<T>>;

/// The vertices that the triangles of a primitive use, ascending.
struct Used(Vec<u32>);

impl Used {
    fn by(faces: &[[u32; 3]]) -> Self {
        let mut used = faces.as_flattened().to_vec();
        used.sort_unstable();
        used.dedup();
        Self(used)
    }

    /// What those vertices have of all.
    fn of<T: Copy>(&self, all: &[T]) -> Vec<T> {
        self.0.iter().map(|&vertex| all[vertex as usize]).collect()
    }

    /// The triangles, with their corners counted among the vertices in use.
    fn renumbered(&self, faces: Vec<[u32; 3]>) -> Vec<[u32; 3]> {
        let number = |vertex: u32| self.0.partition_point(|&other| other < vertex) as u32;
        faces.into_iter().map(|face| face.map(number)).collect()
    }
}

/// Which vertices of a primitive are wanted, and how they are morphed.
struct Shown<'p> {
    /// How many vertices there are, used or not.
    count: usize,
    used: &'p Used,
    /// Of its morph targets.
    weights: &'p [f64],
}

/// Where the content of a primitive comes from.
struct Source<'p> {
    primitive: &'p Primitive,
    place: &'p str,
    /// The decoded stream and the numbers of its attributes.
    stream: Option<(draco::Decoded, &'p DracoPrimitive)>,
}

/// Reads the primitives of a document.
#[derive(Debug)]
pub(super) struct Primitives<'a> {
    accessors: &'a Accessors<'a>,
    quantized: bool,
    /// Which texture coordinates lay out light maps.
    lightmap_set: Option<u32>,
    /// What accessors hold: positions, texture coordinates, and the alphas of colours.
    positions: HashMap<usize, Shared<[f64; 3]>>,
    places: HashMap<usize, Shared<[f64; 2]>>,
    alphas: HashMap<usize, Shared<f64>>,
    /// What colours of morph targets add to alphas.
    alpha_steps: HashMap<usize, Shared<f64>>,
    /// The accessors of positions that were found sound.
    accepted: HashSet<usize>,
    /// Why streams are not read, by their views: decoding up to a fault may take long.
    refused_streams: HashMap<usize, String>,
    /// Rules that primitives break without harm.
    pub(super) findings: Findings,
}

impl<'a> Primitives<'a> {
    pub(super) fn new(accessors: &'a Accessors<'a>, quantized: bool, lightmap_set: Option<u32>) -> Self {
        let (positions, places, alphas, alpha_steps) = Default::default();
        let (accepted, refused_streams, findings) = Default::default();
        Self {
            accessors,
            quantized,
            lightmap_set,
            positions,
            places,
            alphas,
            alpha_steps,
            accepted,
            refused_streams,
            findings,
        }
    }

    /// Enters a primitive into the account of the scene, whatever it holds.
    pub(super) fn count(&self) -> Result<(), LoadProblem> {
        self.accessors.count(PRIMITIVE)
    }

    /// Reads a primitive of triangles. `place` is what messages call it; `weights` are those of its morph targets; `mask` cuts it
    /// out.
    pub(super) fn read(
        &mut self,
        primitive: &Primitive,
        weights: &[f64],
        mask: Option<&MaskMaterial>,
        place: &str,
    ) -> Result<Geometry, LoadProblem> {
        let refused = |message: String| LoadProblem::element(place, message);
        let source = self.source(primitive, place)?;
        let (vertices, corners) = self.content(&source)?;
        let mode = if source.stream.is_some() { 4 } else { primitive.mode.unwrap_or(4) };
        let faces = triangles_of(mode, &corners).map_err(refused)?;
        if (mode == 4 && !corners.len().is_multiple_of(3)) || (mode != 4 && corners.len() < 3) {
            self.findings.add(FindingKind::BrokenRule, &format!("{place}: corners are left over"), 1);
        }
        let used = Used::by(&faces);
        let shown = Shown { count: vertices.len(), used: &used, weights };
        let texture = match self.lightmap_set {
            Some(set) => self.places(&source, &shown, set)?,
            None => None,
        };
        let mask = mask.map(|mask| self.mask(&source, &shown, mask)).transpose()?.unwrap_or_default();
        let vertices = self.morphed(&source, &vertices, weights, &used)?;
        Ok(Geometry { vertices, faces: used.renumbered(faces), texture, mask })
    }

    /// Looks at what [`Self::read`] does not: a primitive that is not `shown`, and targets without weight. Its faults are told.
    pub(super) fn check_rest(&mut self, primitive: &Primitive, shown: bool, place: &str) {
        let is_whole = shown || !primitive.attributes.contains_key("POSITION");
        let content = if is_whole { Ok(()) } else { self.check_content(primitive, place) };
        let targets = self.check_targets(primitive, place);
        for problem in [content, targets].into_iter().filter_map(Result::err) {
            self.findings.add(FindingKind::BrokenRule, &format!("unused: {problem}"), 1);
        }
    }

    fn check_content(&mut self, primitive: &Primitive, place: &str) -> Result<(), LoadProblem> {
        let source = self.source(primitive, place)?;
        self.content(&source).map(|_| ())
    }

    fn check_targets(&mut self, primitive: &Primitive, place: &str) -> Result<(), LoadProblem> {
        let accessors = primitive.targets.iter().filter_map(|target| target.get("POSITION"));
        for &accessor in accessors {
            if !self.accepted.contains(&accessor) {
                self.positions(accessor).map_err(|problem| within(problem, place))?;
            }
        }
        Ok(())
    }

    fn source<'p>(&mut self, primitive: &'p Primitive, place: &'p str) -> Result<Source<'p>, LoadProblem> {
        let stream = match &primitive.extensions.draco {
            Some(draco) => Some((self.decompress(draco).map_err(|problem| within(problem, place))?, draco)),
            None => None,
        };
        if let Some((decoded, draco)) = &stream {
            let is_there = |(name, &id): (&String, &u32)| decoded.has(id) && primitive.attributes.contains_key(name);
            let missing = draco.attributes.iter().filter(|&attribute| !is_there(attribute)).count();
            let subject = format!("{place}, {DRACO}: attributes that the stream or the primitive does not have");
            self.findings.add(FindingKind::BrokenRule, &subject, missing);
            if !matches!(primitive.mode, None | Some(4 | 5)) {
                let subject = format!("{place}, {DRACO}: its mode is neither of triangles nor of strips");
                self.findings.add(FindingKind::BrokenRule, &subject, 1);
            }
        }
        Ok(Source { primitive, place, stream })
    }

    /// The positions and the corners, which are in range.
    fn content(&mut self, source: &Source) -> Result<(Shared<[f64; 3]>, Vec<u32>), LoadProblem> {
        let refused = |message: String| LoadProblem::element(source.place, message);
        let vertices = self.vertices(source)?;
        let count = u32::try_from(vertices.len()).map_err(|_| refused("it has more than 2^32 vertices".to_owned()))?;
        let corners = self.corners(source, count)?;
        match corners.iter().enumerate().find(|&(_, &index)| index >= count) {
            Some((at, index)) => Err(refused(format!("index {at} is {index}, but there are {count} vertices"))),
            None => Ok((vertices, corners)),
        }
    }

    fn decompress(&mut self, draco: &DracoPrimitive) -> Result<draco::Decoded, LoadProblem> {
        let ledger = self.accessors.ledger();
        let (_, stream) = self.accessors.views().get(draco.buffer_view)?;
        if let Some(message) = self.refused_streams.get(&draco.buffer_view) {
            return Err(LoadProblem::element(DRACO, message));
        }
        let decoded = draco::decode(stream, ledger.elements_left()).map_err(|message| {
            self.refused_streams.insert(draco.buffer_view, message.clone());
            LoadProblem::element(DRACO, message)
        })?;
        self.accessors.count(decoded.len())?;
        self.accessors.count(decoded.corner_count())?;
        Ok(decoded)
    }

    /// The positions of a primitive, each one accepted, used or not.
    fn vertices(&mut self, source: &Source) -> Result<Shared<[f64; 3]>, LoadProblem> {
        let Some(&accessor) = source.primitive.attributes.get("POSITION") else {
            return Err(LoadProblem::element(source.place, "it has no POSITION attribute"));
        };
        if let Some(positions) = self.compressed::<3>(source, "POSITION", accessor)? {
            accept_all(&positions, &format!("{}, {DRACO}", source.place))?;
            return Ok(Rc::new(positions));
        }
        self.shared_positions(accessor).map_err(|problem| within(problem, source.place))
    }

    fn shared_positions(&mut self, accessor: usize) -> Result<Shared<[f64; 3]>, LoadProblem> {
        if let Some(positions) = self.positions.get(&accessor) {
            return Ok(Rc::clone(positions));
        }
        let positions = Rc::new(self.positions(accessor)?);
        self.positions.insert(accessor, Rc::clone(&positions));
        Ok(positions)
    }

    fn positions(&mut self, index: usize) -> Result<Vec<[f64; 3]>, LoadProblem> {
        let place = format!("accessor {index}");
        let (declared, component) = self.accessors.declared(index)?;
        match component {
            Component::F32 => {}
            Component::U32 => return Err(LoadProblem::element(place, "positions cannot be 32-bit integers")),
            _ if self.quantized => {}
            _ => {
                let message = "positions must be 32-bit floats, unless the file uses KHR_mesh_quantization";
                return Err(LoadProblem::element(place, message));
            }
        }
        let positions = self.accessors.vectors::<3>(index)?;
        accept_all(&positions, &place)?;
        if self.accepted.insert(index)
            && let Some((rule, beyond)) = extent_rule(declared, component, &positions)
        {
            let subject = format!("{place}: {rule}");
            match beyond {
                Some(vertex) => {
                    self.findings.add_at(FindingKind::BrokenRule, &subject, format_args!("position {vertex}"));
                }
                None => self.findings.add(FindingKind::BrokenRule, &subject, 1),
            }
        }
        Ok(positions)
    }

    /// An attribute out of a stream, if the primitive has one with that attribute in it.
    fn compressed<const N: usize>(
        &mut self,
        source: &Source,
        name: &str,
        accessor: usize,
    ) -> Result<Option<Vec<[f64; N]>>, LoadProblem> {
        let Some((decoded, draco)) = &source.stream else { return Ok(None) };
        let Some(&id) = draco.attributes.get(name) else { return Ok(None) };
        let (declared, component) =
            self.accessors.declared(accessor).map_err(|problem| within(problem, source.place))?;
        let place = format!("{}, {DRACO}", source.place);
        let values = decoded.vectors(id, declared.normalized).map_err(|fault| LoadProblem::element(&place, fault))?;
        for (differs, what) in [
            (declared.count != values.len(), "another number of elements"),
            (decoded.component(id) != Some(component), "another type of components"),
        ] {
            let subject = format!("{place}: {name} has {what} than its accessor");
            self.findings.add(FindingKind::BrokenRule, &subject, usize::from(differs));
        }
        Ok(Some(values))
    }

    /// The corners of the triangles, strips and fans as they come.
    fn corners(&mut self, source: &Source, count: u32) -> Result<Vec<u32>, LoadProblem> {
        let problem = |problem| within(problem, source.place);
        if let Some((decoded, _)) = &source.stream {
            let corners = decoded.corners();
            // A strip has fewer corners than the triangles that it stands for.
            let is_list = source.primitive.mode.is_none_or(|mode| mode == 4);
            if let Some(indices) = source.primitive.indices.filter(|_| is_list) {
                let (declared, _) = self.accessors.declared(indices).map_err(problem)?;
                if declared.count != corners.len() {
                    let subject = format!("{}, {DRACO}: indices are more or fewer than their accessor's", source.place);
                    self.findings.add(FindingKind::BrokenRule, &subject, 1);
                }
            }
            return Ok(corners);
        }
        match source.primitive.indices {
            Some(indices) => {
                let corners = self.accessors.indices(indices).map_err(problem)?;
                let (declared, component) = self.accessors.declared(indices)?;
                for (is_broken, rule) in [
                    (
                        corners.contains(&component.greatest_index()),
                        "the greatest index of its type, taken as any other",
                    ),
                    (!is_range_of(declared, &corners), "its min and max are not those of its indices"),
                ] {
                    let subject = format!("accessor {indices}: {rule}");
                    self.findings.add(FindingKind::BrokenRule, &subject, usize::from(is_broken));
                }
                Ok(corners)
            }
            None => {
                self.accessors.count(count as usize)?;
                Ok((0..count).collect())
            }
        }
    }

    /// The vertices in use with the displacements of the morph targets added, each times its weight, target by target.
    fn morphed(
        &mut self,
        source: &Source,
        all: &[[f64; 3]],
        weights: &[f64],
        used: &Used,
    ) -> Result<Vec<[f64; 3]>, LoadProblem> {
        let mut vertices = used.of(all);
        for (number, (target, &weight)) in source.primitive.targets.iter().zip(weights).enumerate() {
            let Some(&accessor) = target.get("POSITION").filter(|_| weight != 0.0) else { continue };
            let place = format!("{}, morph target {number}", source.place);
            let steps = self.shared_positions(accessor).map_err(|problem| within(problem, &place))?;
            if steps.len() != all.len() {
                let message = format!("{} displacements for {} vertices", steps.len(), all.len());
                return Err(LoadProblem::element(place, message));
            }
            self.accessors.count(vertices.len())?;
            for (vertex, step) in vertices.iter_mut().zip(used.of(&steps)) {
                vertex.iter_mut().zip(step).for_each(|(coordinate, step)| *coordinate += weight * step);
            }
        }
        let tiny = clear_tiny(vertices.as_flattened_mut());
        let subject = || format!("{}: morphed coordinates below 2^-200 are taken as 0", source.place);
        if tiny > 0 {
            self.findings.add(FindingKind::BrokenRule, &subject(), tiny);
        }
        Ok(vertices)
    }
}

/// What is wrong with the extent that an accessor of positions declares, and the first position beyond it, if there is one: six written digits are as good as all.
fn extent_rule(
    declared: &Accessor,
    component: Component,
    positions: &[[f64; 3]],
) -> Option<(&'static str, Option<usize>)> {
    let (Some(min), Some(max)) = (&declared.min, &declared.max) else { return Some(("it has no min and max", None)) };
    // Told of every accessor elsewhere.
    if min.len() != 3 || max.len() != 3 {
        return None;
    }
    let largest = positions.as_flattened().iter().fold(0.0, |largest: f64, coordinate| largest.max(coordinate.abs()));
    let slack = SIX_DIGITS * largest;
    let scaled = |said: f64| component.scaled(said, declared.normalized);
    let is_near = |said: f64, found: f64| (scaled(said) - found).abs() <= slack;
    let fits = (0..3).all(|axis| {
        let along = || positions.iter().map(|position| position[axis]);
        let (low, high) = (along().fold(f64::INFINITY, f64::min), along().fold(f64::NEG_INFINITY, f64::max));
        is_near(min[axis], low) && is_near(max[axis], high)
    });
    let is_beyond = |position: &[f64; 3]| {
        (0..3).any(|axis| position[axis] < scaled(min[axis]) - slack || position[axis] > scaled(max[axis]) + slack)
    };
    let rule = "its min and max are not those of its positions";
    (!fits && !positions.is_empty()).then(|| (rule, positions.iter().position(is_beyond)))
}

/// Whether an accessor of indices declares their least and greatest, or nothing of them.
fn is_range_of(declared: &Accessor, indices: &[u32]) -> bool {
    let is = |said: &Option<Vec<f64>>, found: Option<&u32>| {
        let (Some(said), Some(&found)) = (said, found) else { return true };
        said.len() != 1 || said[0] == f64::from(found)
    };
    is(&declared.min, indices.iter().min()) && is(&declared.max, indices.iter().max())
}

fn accept_all(positions: &[[f64; 3]], place: &str) -> Result<(), LoadProblem> {
    for (vertex, &position) in positions.iter().enumerate() {
        accept_point(position).map_err(|(axis, defect)| {
            LoadProblem::element(place, format!("position {vertex}: coordinate {} {defect}", AXES[axis]))
        })?;
    }
    Ok(())
}

/// The triangles of a list (4), a strip (5) or a fan (6), wound as glTF says; corners that make no triangle are left.
fn triangles_of(mode: u32, corners: &[u32]) -> Result<Vec<[u32; 3]>, String> {
    match mode {
        4 => Ok(corners.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect()),
        5 => {
            let turned = |(i, c): (usize, &[u32])| if i % 2 == 0 { [c[0], c[1], c[2]] } else { [c[0], c[2], c[1]] };
            Ok(corners.windows(3).enumerate().map(turned).collect())
        }
        6 => {
            let hub = corners.first().copied().unwrap_or_default();
            Ok(corners.get(1..).unwrap_or_default().windows(2).map(|c| [c[0], c[1], hub]).collect())
        }
        _ => Err(format!("its mode {mode} is none of glTF's (0 to 6)")),
    }
}

#[cfg(test)]
mod tests {
    use super::triangles_of;

    #[test]
    fn strips_and_fans_keep_their_orientation() {
        assert_eq!(triangles_of(4, &[0, 1, 2, 2, 1, 3]), Ok(vec![[0, 1, 2], [2, 1, 3]]));
        assert_eq!(triangles_of(5, &[0, 1, 2, 3, 4]), Ok(vec![[0, 1, 2], [1, 3, 2], [2, 3, 4]]));
        assert_eq!(triangles_of(6, &[7, 1, 2, 3]), Ok(vec![[1, 2, 7], [2, 3, 7]]));
        assert_eq!(triangles_of(4, &[0, 1]), Ok(Vec::new()));
        assert_eq!(triangles_of(5, &[0, 1]), Ok(Vec::new()));
        assert_eq!(triangles_of(6, &[]), Ok(Vec::new()));
        assert!(triangles_of(7, &[0, 1, 2]).is_err());
    }
}
