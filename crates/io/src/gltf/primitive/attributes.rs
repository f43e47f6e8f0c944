//! Attributes besides positions: texture coordinates, and alphas of colours.

use std::{collections::HashMap, rc::Rc};

use umbriel_scene::FindingKind;

use super::{MaskVertices, Primitives, Shared, Shown, Source};
use crate::{
    error::LoadProblem,
    gltf::{
        accessor::{Accessors, within},
        json::TextureReference,
        textures::MaskMaterial,
    },
    model::Findings,
};

/// The vertex colours that count.
const COLOR: &str = "COLOR_0";

impl Primitives<'_> {
    /// A set of texture coordinates, morphed, one pair a vertex in use, if the primitive has it.
    pub(super) fn places(
        &mut self,
        source: &Source,
        shown: &Shown,
        set: u32,
    ) -> Result<Option<Vec<[f64; 2]>>, LoadProblem> {
        let name = format!("TEXCOORD_{set}");
        let Some(&accessor) = source.primitive.attributes.get(&name) else { return Ok(None) };
        let (accessors, place) = (self.accessors, format!("{}, {name}", source.place));
        let places = match self.compressed::<2>(source, &name, accessor)? {
            Some(places) => Rc::new(all_finite(places, &place)?),
            None => remembered(&mut self.places, accessor, || finite(accessors, accessor, &place))?,
        };
        check_count(&place, places.len(), shown.count)?;
        let mut morphed = shown.used.of(&places);
        for (weight, accessor, place) in targets(source, shown, &name) {
            let steps = remembered(&mut self.places, accessor, || finite(accessors, accessor, &place))?;
            check_count(&place, steps.len(), shown.count)?;
            self.accessors.count(morphed.len())?;
            for (at, step) in morphed.iter_mut().zip(shown.used.of(&steps)) {
                at.iter_mut().zip(step).for_each(|(coordinate, step)| *coordinate += weight * step);
            }
        }
        Ok(Some(morphed))
    }

    /// What cuts out the vertices of a primitive.
    pub(super) fn mask(
        &mut self,
        source: &Source,
        shown: &Shown,
        mask: &MaskMaterial,
    ) -> Result<MaskVertices, LoadProblem> {
        let set = mask.reference.filter(|_| mask.cut_out.map.is_some()).map(TextureReference::set);
        let places = match set {
            Some(set) => self.places(source, shown, set)?,
            None => None,
        };
        Ok(MaskVertices { places, alphas: self.alphas(source, shown)? })
    }

    /// The alphas of the vertices' colours, morphed, if these have any.
    fn alphas(&mut self, source: &Source, shown: &Shown) -> Result<Option<Vec<f64>>, LoadProblem> {
        let Some(&accessor) = source.primitive.attributes.get(COLOR) else { return Ok(None) };
        if !self.has_alpha(accessor, source.place)? {
            return Ok(None);
        }
        let (accessors, place) = (self.accessors, format!("{}, {COLOR}", source.place));
        let alphas = match self.compressed::<4>(source, COLOR, accessor)? {
            Some(colors) => Rc::new(alphas_of(&all_finite(colors, &place)?, &place, &mut self.findings)),
            None => remembered(&mut self.alphas, accessor, || {
                Ok(alphas_of(&finite(accessors, accessor, &place)?, &place, &mut self.findings))
            })?,
        };
        check_count(&place, alphas.len(), shown.count)?;
        let mut morphed = shown.used.of(&alphas);
        for (weight, accessor, place) in targets(source, shown, COLOR) {
            if !self.has_alpha(accessor, &place)? {
                continue;
            }
            let steps = remembered(&mut self.alpha_steps, accessor, || {
                Ok(finite::<4>(accessors, accessor, &place)?.into_iter().map(|color| color[3]).collect())
            })?;
            check_count(&place, steps.len(), shown.count)?;
            self.accessors.count(morphed.len())?;
            morphed.iter_mut().zip(shown.used.of(&steps)).for_each(|(alpha, step)| *alpha += weight * step);
        }
        // All targets are added before colours are brought between 0 and 1.
        morphed.iter_mut().for_each(|alpha| *alpha = alpha.clamp(0.0, 1.0));
        Ok(Some(morphed))
    }

    /// Whether colours have a fourth component.
    fn has_alpha(&self, accessor: usize, place: &str) -> Result<bool, LoadProblem> {
        let (declared, _) = self.accessors.declared(accessor).map_err(|problem| within(problem, place))?;
        Ok(declared.kind == "VEC4")
    }
}

/// What an accessor is remembered to hold, or is read to hold now.
fn remembered<T>(
    known: &mut HashMap<usize, Shared<T>>,
    accessor: usize,
    read: impl FnOnce() -> Result<Vec<T>, LoadProblem>,
) -> Result<Shared<T>, LoadProblem> {
    if let Some(values) = known.get(&accessor) {
        return Ok(Rc::clone(values));
    }
    let values = Rc::new(read()?);
    known.insert(accessor, Rc::clone(&values));
    Ok(values)
}

/// The alphas of the colours at a place, brought between 0 and 1.
fn alphas_of(colors: &[[f64; 4]], place: &str, findings: &mut Findings) -> Vec<f64> {
    let beyond = colors.iter().filter(|color| !(0.0..=1.0).contains(&color[3])).count();
    findings.add(FindingKind::BrokenRule, &format!("{place}: alphas below 0 or above 1"), beyond);
    colors.iter().map(|color| color[3].clamp(0.0, 1.0)).collect()
}

/// The finite numbers of an accessor.
fn finite<const N: usize>(accessors: &Accessors, accessor: usize, place: &str) -> Result<Vec<[f64; N]>, LoadProblem> {
    all_finite(accessors.vectors(accessor).map_err(|problem| within(problem, place))?, place)
}

/// The morph targets of an attribute that count: their weights, their accessors, and what messages call them.
fn targets<'p>(source: &'p Source, shown: &'p Shown, name: &'p str) -> impl Iterator<Item = (f64, usize, String)> + 'p {
    let weighted = source.primitive.targets.iter().zip(shown.weights).enumerate();
    weighted.filter(|(_, (_, weight))| **weight != 0.0).filter_map(move |(number, (target, &weight))| {
        let &accessor = target.get(name)?;
        Some((weight, accessor, format!("{}, morph target {number}, {name}", source.place)))
    })
}

fn all_finite<const N: usize>(vectors: Vec<[f64; N]>, place: &str) -> Result<Vec<[f64; N]>, LoadProblem> {
    match vectors.iter().position(|vector| !vector.iter().all(|coordinate| coordinate.is_finite())) {
        Some(vertex) => {
            let message = format!("vertex {vertex} has a coordinate that is not finite");
            Err(LoadProblem::element(place, message))
        }
        None => Ok(vectors),
    }
}

fn check_count(place: &str, elements: usize, vertices: usize) -> Result<(), LoadProblem> {
    if elements == vertices {
        return Ok(());
    }
    Err(LoadProblem::element(place, format!("{elements} elements for {vertices} vertices")))
}
