//! Attributes besides positions: texture coordinates, and alphas of colours.

use std::rc::Rc;

use umbriel_scene::FindingKind;

use super::{MaskVertices, Primitives, Shown, Source};
use crate::{
    error::LoadProblem,
    gltf::{accessor::within, json::TextureReference, textures::MaskMaterial},
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
        let places = match self.places.get(&accessor).filter(|_| !source.streams(&name)) {
            Some(places) => Rc::clone(places),
            None => Rc::new(self.attribute::<2>(source, &name, accessor)?),
        };
        if !source.streams(&name) {
            self.places.insert(accessor, Rc::clone(&places));
        }
        check_count(&format!("{}, {name}", source.place), places.len(), shown.count)?;
        let mut morphed = shown.used.of(&places);
        for (weight, accessor, place) in targets(source, shown, &name) {
            let steps = match self.places.get(&accessor) {
                Some(steps) => Rc::clone(steps),
                None => Rc::new(self.finite::<2>(accessor, &place)?),
            };
            self.places.insert(accessor, Rc::clone(&steps));
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
        let alphas = match self.alphas.get(&accessor).filter(|_| !source.streams(COLOR)) {
            Some(alphas) => Rc::clone(alphas),
            None => Rc::new(self.read_alphas(source, COLOR, accessor)?),
        };
        if !source.streams(COLOR) {
            self.alphas.insert(accessor, Rc::clone(&alphas));
        }
        check_count(&format!("{}, {COLOR}", source.place), alphas.len(), shown.count)?;
        let mut morphed = shown.used.of(&alphas);
        for (weight, accessor, place) in targets(source, shown, COLOR) {
            if !self.has_alpha(accessor, &place)? {
                continue;
            }
            let steps = match self.alpha_steps.get(&accessor) {
                Some(steps) => Rc::clone(steps),
                None => Rc::new(self.finite::<4>(accessor, &place)?.into_iter().map(|color| color[3]).collect()),
            };
            self.alpha_steps.insert(accessor, Rc::clone(&steps));
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

    /// The alphas of colours, brought between 0 and 1.
    fn read_alphas(&mut self, source: &Source, name: &str, accessor: usize) -> Result<Vec<f64>, LoadProblem> {
        let colors = self.attribute::<4>(source, name, accessor)?;
        let beyond = colors.iter().filter(|color| !(0.0..=1.0).contains(&color[3])).count();
        let subject = format!("{}: alphas of {name} below 0 or above 1", source.place);
        self.findings.add(FindingKind::BrokenRule, &subject, beyond);
        Ok(colors.into_iter().map(|color| color[3].clamp(0.0, 1.0)).collect())
    }

    /// An attribute of finite numbers, from the stream or from its accessor.
    fn attribute<const N: usize>(
        &mut self,
        source: &Source,
        name: &str,
        accessor: usize,
    ) -> Result<Vec<[f64; N]>, LoadProblem> {
        let place = format!("{}, {name}", source.place);
        match self.compressed::<N>(source, name, accessor)? {
            Some(vectors) => all_finite(vectors, &place),
            None => self.finite(accessor, &place),
        }
    }

    /// The finite numbers of an accessor.
    fn finite<const N: usize>(&self, accessor: usize, place: &str) -> Result<Vec<[f64; N]>, LoadProblem> {
        let vectors = self.accessors.vectors::<N>(accessor).map_err(|problem| within(problem, place))?;
        all_finite(vectors, place)
    }
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
