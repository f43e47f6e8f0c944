//! MASK materials as cut-outs, and the textures behind them.
//!
//! A material's alpha is its factor times the vertices' alpha times the texture's, sampled at the finest level: by `magFilter`, else
//! by `minFilter` as far as it speaks of texels, else linearly. KHR_texture_transform moves texture coordinates by scale, turn, offset, in
//! that order. Only the alpha of textures that a MASK material needs is decoded, once for each image.

use std::{
    collections::{HashMap, HashSet},
    sync::Arc,
};

use umbriel_geometry::cut_out::{AlphaMap, CutOut, Filter, Wrap};
use umbriel_scene::FindingKind;

use super::{
    accessor::Accessors,
    container::head_of_data,
    json::{Document, Image, Material, Sampler, TextureReference, TextureTransform, existing},
    views::Views,
};
use crate::{
    error::{LoadProblem, brief},
    model::Findings,
    picture,
};

/// The alpha of an image; `None` for one without, or why it is not read.
type Alpha = Result<Option<Arc<AlphaMap>>, String>;

/// The textures of a document, decoded when first asked for.
#[derive(Debug)]
pub(super) struct Textures<'a> {
    document: &'a Document,
    accessors: &'a Accessors<'a>,
    images: HashMap<usize, Alpha>,
}

/// How a MASK material cuts.
#[derive(Clone, Debug)]
pub(super) struct MaskMaterial<'a> {
    pub(super) cut_out: CutOut,
    /// Where its texture coordinates come from.
    pub(super) reference: Option<&'a TextureReference>,
    /// Why there is no texture, if there is none.
    pub(super) missing: Option<String>,
}

impl<'a> Textures<'a> {
    pub(super) fn new(document: &'a Document, accessors: &'a Accessors<'a>) -> Self {
        Self { document, accessors, images: HashMap::new() }
    }

    /// How a MASK material cuts. What is missing counts as an alpha of one.
    pub(super) fn mask(&mut self, material: &'a Material) -> Result<MaskMaterial<'a>, LoadProblem> {
        let base = material.base_color();
        let reference = base.base_color_texture.as_ref();
        let alpha = match reference {
            None => Err("it has no texture".to_owned()),
            Some(reference) => self.alpha_of(reference.index)?,
        };
        let (map, missing) = match alpha {
            Ok(map) => (map, None),
            Err(reason) => (None, Some(reason)),
        };
        let texture = reference.and_then(|reference| self.document.textures.get(reference.index));
        let sampler = texture.and_then(|texture| self.document.samplers.get(texture.sampler?));
        let sampler = sampler.cloned().unwrap_or_default();
        let cut_out = CutOut {
            map,
            filter: filter(&sampler),
            wrap: [sampler.wrap_s, sampler.wrap_t].map(wrap),
            factor: base.base_color_factor.map_or(1.0, |[.., alpha]| alpha.clamp(0.0, 1.0)),
            cutoff: least_opaque(material.alpha_cutoff.unwrap_or(0.5)),
        };
        Ok(MaskMaterial { cut_out, reference, missing })
    }

    fn alpha_of(&mut self, texture: usize) -> Result<Alpha, LoadProblem> {
        let declared = existing(&self.document.textures, texture, "texture")?;
        let Some(image) = declared.source else {
            return Ok(Err(format!("texture {texture} has no image that is PNG or JPEG")));
        };
        let content = existing(&self.document.images, image, "image")?;
        if !self.images.contains_key(&image) {
            let alpha = self.read(image, content);
            self.images.insert(image, alpha);
        }
        Ok(self.images[&image].clone())
    }

    fn read(&self, index: usize, image: &Image) -> Alpha {
        let place = format!("image {index}");
        let told = |problem: LoadProblem| format!("{place}: {problem}");
        let views = self.accessors.views();
        let alpha = match (&image.uri, image.buffer_view) {
            (Some(uri), _) => {
                let bytes = views.resource(uri, &place).map_err(told)?;
                picture::alpha(&bytes, self.accessors.ledger())
            }
            (None, Some(view)) => {
                let (_, bytes) = views.get(view).map_err(told)?;
                picture::alpha(bytes, self.accessors.ledger())
            }
            (None, None) => Err("it has neither a uri nor a buffer view".to_owned()),
        };
        // The reason is told for every primitive with that picture.
        alpha.map(|map| map.map(Arc::new)).map_err(|reason| brief(&format!("{place}: {reason}")).into_owned())
    }
}

/// The least alpha that is opaque. Renderers compare 32-bit floats, so what such a float does not tell from the cutoff reaches it: a
/// texel of 51 / 255 is a little below the f64 that is nearest to 0.2. Halfway to the float below holds texels, factors and
/// colours to one rule; texels of 16 bits are 256 such halves apart, or more.
fn least_opaque(cutoff: f64) -> f64 {
    let single = cutoff as f32;
    if single.is_finite() { f64::midpoint(single.next_down().into(), single.into()).max(0.0) } else { cutoff.max(0.0) }
}

/// Pictures that no material cuts out with, so that nothing decodes them: those that are not there are told, and of those in buffer views and
/// data URIs whose bytes are at hand those that are cut off.
pub(super) fn check_rest(document: &Document, accessors: &Accessors) -> Findings {
    let masks = document.materials.iter().filter(|material| material.alpha_mode.as_deref() == Some("MASK"));
    let textures = masks.filter_map(|material| material.base_color().base_color_texture.as_ref());
    let read: HashSet<usize> = textures.filter_map(|texture| document.textures.get(texture.index)?.source).collect();
    let (mut findings, mut looked_at) = (Findings::default(), HashMap::new());
    for (index, image) in document.images.iter().enumerate().filter(|(index, _)| !read.contains(index)) {
        if let Err(problem) = check_unread(image, accessors.views(), &mut looked_at, &format!("image {index}")) {
            findings.add(FindingKind::BrokenRule, &format!("unused: {problem}"), 1);
        }
    }
    findings
}

/// See [`check_rest`]. What is wrong with the picture in a view is `looked_at` once, however many images share it.
fn check_unread(
    image: &Image,
    views: &Views,
    looked_at: &mut HashMap<usize, Option<&'static str>>,
    place: &str,
) -> Result<(), LoadProblem> {
    let fault = match (&image.uri, image.buffer_view) {
        (Some(uri), _) => views.check(uri, place)?.and_then(|bytes| picture::fault(&bytes)),
        (None, Some(view)) if views.is_at_hand(view) => match looked_at.get(&view) {
            Some(&fault) => fault,
            None => {
                let fault = picture::fault(views.get(view)?.1);
                looked_at.insert(view, fault);
                fault
            }
        },
        _ => None,
    };
    fault.map_or(Ok(()), |fault| Err(LoadProblem::element(place, fault)))
}

/// What pictures in buffer views and data URIs begin with, where their bytes are at hand: something else than their types say is told.
pub(super) fn check(document: &Document, accessors: &Accessors) -> Findings {
    let mut findings = Findings::default();
    for (index, image) in document.images.iter().enumerate() {
        // Types are written in letters of either size.
        let known = |stated: &str| KINDS.iter().map(|(kind, _)| *kind).find(|kind| kind.eq_ignore_ascii_case(stated));
        let stated = image.mime_type.as_deref().and_then(known);
        let data = image.uri.as_deref().and_then(head_of_data);
        let in_uri = data.as_ref().and_then(|(kind, _)| known(kind));
        // Pictures do not stand in compressed views.
        let view = image.buffer_view.filter(|&view| stated.is_some() && accessors.views().is_at_hand(view));
        let bytes = match (&data, view.map(|view| accessors.views().get(view))) {
            (Some((_, bytes)), _) => bytes,
            (None, Some(Ok((_, bytes)))) => bytes,
            _ => continue,
        };
        let found = picture_kind(bytes).unwrap_or("no picture");
        for (name, stated) in [("mimeType", stated), ("data URI's type", in_uri)] {
            if let Some(stated) = stated.filter(|&stated| stated != found) {
                let subject = format!("image {index}: its {name} is {stated}, its bytes are {found}");
                findings.add(FindingKind::BrokenRule, &subject, 1);
            }
        }
    }
    findings
}

/// The kinds of pictures that glTF and its extensions have, each with bytes that it has at a place.
const KINDS: [(&str, (usize, &[u8])); 6] = [
    ("image/png", (0, b"\x89PNG")),
    ("image/jpeg", (0, b"\xff\xd8\xff")),
    ("image/webp", (8, b"WEBP")),
    ("image/ktx2", (0, b"\xabKTX 20")),
    ("image/avif", (4, b"ftypavi")),
    ("image/vnd-ms.dds", (0, b"DDS ")),
];

fn picture_kind(bytes: &[u8]) -> Option<&'static str> {
    let begins = |&(_, (at, mark)): &(&str, (usize, &[u8]))| bytes.get(at..).is_some_and(|rest| rest.starts_with(mark));
    KINDS.into_iter().find(begins).map(|(kind, _)| kind)
}

/// Whether these are numbers that a sampler may have.
pub(super) fn is_regular(sampler: &Sampler) -> bool {
    let is_wrap = |wrap: Option<u32>| matches!(wrap, None | Some(33071 | 33648 | 10497));
    matches!(sampler.mag_filter, None | Some(9728 | 9729))
        && matches!(sampler.min_filter, None | Some(9728 | 9729 | 9984..=9987))
        && is_wrap(sampler.wrap_s)
        && is_wrap(sampler.wrap_t)
}

fn filter(sampler: &Sampler) -> Filter {
    match sampler.mag_filter.or(sampler.min_filter) {
        // NEAREST, NEAREST_MIPMAP_NEAREST, NEAREST_MIPMAP_LINEAR.
        Some(9728 | 9984 | 9986) => Filter::Nearest,
        _ => Filter::Linear,
    }
}

fn wrap(code: Option<u32>) -> Wrap {
    match code {
        Some(33071) => Wrap::ClampToEdge,
        Some(33648) => Wrap::MirroredRepeat,
        _ => Wrap::Repeat,
    }
}

impl TextureReference {
    /// Which texture coordinates it takes.
    pub(super) fn set(&self) -> u32 {
        self.extensions.transform.as_ref().and_then(|transform| transform.tex_coord).unwrap_or(self.tex_coord)
    }

    /// Texture coordinates as the texture takes them: scaled, turned, moved; rounded at each step.
    pub(super) fn moved(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let Some(TextureTransform { offset, rotation, scale, .. }) = &self.extensions.transform else { return [u, v] };
        let (u, v) = (u * scale[0], v * scale[1]);
        // Counter-clockwise as seen with v pointing down.
        let (sin, cos) = libm::sincos(*rotation);
        [cos * u + sin * v + offset[0], cos * v - sin * u + offset[1]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_transform_scales_turns_and_moves() {
        // The example of the extension: the lower left quadrant of the picture, turned by a quarter.
        let text = r#"{ "index": 0, "extensions": { "KHR_texture_transform": {
            "offset": [0, 1], "rotation": 1.57079632679489661923, "scale": [0.5, 0.5] } } }"#;
        let reference: TextureReference = serde_json::from_str(text).expect("a reference");
        let near = |[a, b]: [f64; 2], [c, d]: [f64; 2]| (a - c).abs() < 1e-15 && (b - d).abs() < 1e-15;
        for (from, to) in [([0.0, 0.0], [0.0, 1.0]), ([1.0, 0.0], [0.0, 0.5]), ([0.0, 1.0], [0.5, 1.0])] {
            assert!(near(reference.moved(from), to), "{from:?} goes to {:?}", reference.moved(from));
        }
        assert_eq!(reference.set(), 0);
    }

    #[test]
    fn the_filter_is_that_of_the_finest_level() {
        let of = |mag_filter, min_filter| filter(&Sampler { mag_filter, min_filter, ..Sampler::default() });
        assert_eq!(of(Some(9728), Some(9729)), Filter::Nearest);
        assert_eq!(of(Some(9729), Some(9728)), Filter::Linear);
        assert_eq!((of(None, Some(9986)), of(None, Some(9985))), (Filter::Nearest, Filter::Linear));
        assert_eq!(of(None, None), Filter::Linear);
    }
}
