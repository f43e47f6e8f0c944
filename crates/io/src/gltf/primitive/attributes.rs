//! Attributes besides positions: texture coordinates, and alphas of colours.

use std::rc::Rc;

use umbriel_scene::FindingKind;

use super::{MaskVertices, Primitives, Shared, Source, Used};
use crate::{
    error::LoadProblem,
    gltf::{accessor::within, json::TextureReference, textures::MaskMaterial},
};

impl Primitives<'_> {
    /// A set of texture coordinates, one pair a vertex, if the primitive has it.
    pub(super) fn places(
        &mut self,
        source: &Source,
        count: usize,
        set: u32,
    ) -> Result<Option<Shared<[f64; 2]>>, LoadProblem> {
        let name = format!("TEXCOORD_{set}");
        let Some(&accessor) = source.primitive.attributes.get(&name) else { return Ok(None) };
        let places = match self.places.get(&accessor).filter(|_| !source.streams(&name)) {
            Some(places) => Rc::clone(places),
            None => Rc::new(self.attribute::<2>(source, &name, accessor)?),
        };
        if !source.streams(&name) {
            self.places.insert(accessor, Rc::clone(&places));
        }
        check_count(source, &name, places.len(), count).map(|()| Some(places))
    }

    /// What cuts out the vertices of a primitive.
    pub(super) fn mask(
        &mut self,
        source: &Source,
        count: usize,
        mask: &MaskMaterial,
        used: &Used,
    ) -> Result<MaskVertices, LoadProblem> {
        let set = mask.reference.filter(|_| mask.cut_out.map.is_some()).map(TextureReference::set);
        let places = match set {
            Some(set) => self.places(source, count, set)?.map(|places| used.of(&places)),
            None => None,
        };
        let alphas = self.alphas(source, count)?.map(|alphas| used.of(&alphas));
        Ok(MaskVertices { places, alphas })
    }

    /// The alphas of the vertices' colours, if these have any.
    fn alphas(&mut self, source: &Source, count: usize) -> Result<Option<Shared<f64>>, LoadProblem> {
        const NAME: &str = "COLOR_0";
        let Some(&accessor) = source.primitive.attributes.get(NAME) else { return Ok(None) };
        let (declared, _) = self.accessors.declared(accessor).map_err(|problem| within(problem, source.place))?;
        if declared.kind != "VEC4" {
            return Ok(None);
        }
        let alphas = match self.alphas.get(&accessor).filter(|_| !source.streams(NAME)) {
            Some(alphas) => Rc::clone(alphas),
            None => Rc::new(self.read_alphas(source, NAME, accessor)?),
        };
        if !source.streams(NAME) {
            self.alphas.insert(accessor, Rc::clone(&alphas));
        }
        check_count(source, NAME, alphas.len(), count).map(|()| Some(alphas))
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
        let vectors = match self.compressed::<N>(source, name, accessor)? {
            Some(vectors) => vectors,
            None => self.accessors.vectors::<N>(accessor).map_err(|problem| within(problem, source.place))?,
        };
        match vectors.iter().position(|vector| !vector.iter().all(|coordinate| coordinate.is_finite())) {
            Some(vertex) => {
                let message = format!("vertex {vertex} has a coordinate that is not finite");
                Err(LoadProblem::element(format!("{}, {name}", source.place), message))
            }
            None => Ok(vectors),
        }
    }
}

/// Whether an attribute has an element for each vertex.
fn check_count(source: &Source, name: &str, elements: usize, vertices: usize) -> Result<(), LoadProblem> {
    if elements == vertices {
        return Ok(());
    }
    let message = format!("{elements} elements for {vertices} vertices");
    Err(LoadProblem::element(format!("{}, {name}", source.place), message))
}
