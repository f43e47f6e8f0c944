//! Accessors: typed elements out of buffers, every size checked before anything is allocated.

use std::cell::Cell;

use super::{
    json::{Accessor, Document, Sparse, existing},
    views::Views,
};
use crate::{
    error::{LoadProblem, excerpt},
    ledger::Ledger,
};

/// What an element without bytes of its own (all zeros) counts in the account of the scene: nothing in the file bounds their number.
const ZERO: usize = 4;

/// The type of a component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    pub(super) fn of(code: u32) -> Result<Self, String> {
        match code {
            5120 => Ok(Self::I8),
            5121 => Ok(Self::U8),
            5122 => Ok(Self::I16),
            5123 => Ok(Self::U16),
            5125 => Ok(Self::U32),
            5126 => Ok(Self::F32),
            _ => Err(format!("its component type {code} is none of glTF's")),
        }
    }

    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// The value of a component, exact.
    fn value(self, bytes: &[u8]) -> f64 {
        let two = || [bytes[0], bytes[1]];
        let four = || [bytes[0], bytes[1], bytes[2], bytes[3]];
        match self {
            Self::I8 => f64::from(bytes[0] as i8),
            Self::U8 => f64::from(bytes[0]),
            Self::I16 => f64::from(i16::from_le_bytes(two())),
            Self::U16 => f64::from(u16::from_le_bytes(two())),
            Self::U32 => f64::from(u32::from_le_bytes(four())),
            Self::F32 => f64::from(f32::from_le_bytes(four())),
        }
    }

    /// The value of a component, divided where it is normalised.
    pub(super) fn decode(self, bytes: &[u8], normalized: bool) -> f64 {
        self.scaled(self.value(bytes), normalized)
    }

    /// What a stored number stands for.
    pub(super) fn scaled(self, value: f64, normalized: bool) -> f64 {
        if normalized { (value / self.one()).max(-1.0) } else { value }
    }

    /// The greatest index of that type, which glTF leaves to those who begin a new strip with it.
    pub(super) fn greatest_index(self) -> u32 {
        match self {
            Self::U8 => u8::MAX.into(),
            Self::U16 => u16::MAX.into(),
            _ => u32::MAX,
        }
    }

    /// From one normalised number to the next; 0 for floats.
    pub(super) fn step(self) -> f64 {
        if self == Self::F32 { 0.0 } else { 1.0 / self.one() }
    }

    /// What stands for 1 when components are normalised.
    fn one(self) -> f64 {
        match self {
            Self::I8 => f64::from(i8::MAX),
            Self::U8 => f64::from(u8::MAX),
            Self::I16 => f64::from(i16::MAX),
            Self::U16 => f64::from(u16::MAX),
            Self::U32 | Self::F32 => 1.0,
        }
    }
}

/// Equal elements at equal distances.
struct Strided<'a> {
    bytes: &'a [u8],
    stride: usize,
    size: usize,
    count: usize,
}

impl<'a> Strided<'a> {
    fn iter(&self) -> impl Iterator<Item = &'a [u8]> {
        let (bytes, stride, size) = (self.bytes, self.stride, self.size);
        (0..self.count).map(move |i| &bytes[i * stride..i * stride + size])
    }
}

/// Reads the accessors of a document.
#[derive(Debug)]
pub(super) struct Accessors<'a> {
    document: &'a Document,
    views: Views<'a>,
    /// Which accessors have been read.
    read: Vec<Cell<bool>>,
}

impl<'a> Accessors<'a> {
    pub(super) fn new(document: &'a Document, views: Views<'a>) -> Self {
        let read = vec![Cell::new(false); document.accessors.len()];
        Self { document, views, read }
    }

    /// Whether the elements of an accessor have been read.
    pub(super) fn is_read(&self, index: usize) -> bool {
        self.read.get(index).is_some_and(Cell::get)
    }

    /// The declared accessor.
    pub(super) fn declared(&self, index: usize) -> Result<(&'a Accessor, Component), LoadProblem> {
        let refused = |message| LoadProblem::element(format!("accessor {index}"), message);
        let accessor = existing(&self.document.accessors, index, "accessor")?;
        Component::of(accessor.component_type).map(|component| (accessor, component)).map_err(refused)
    }

    /// Elements of `N` components as f64: floats and integers exactly, normalised integers divided.
    pub(super) fn vectors<const N: usize>(&self, index: usize) -> Result<Vec<[f64; N]>, LoadProblem> {
        let kind = match N {
            1 => "SCALAR",
            2 => "VEC2",
            3 => "VEC3",
            4 => "VEC4",
            _ => "MAT4",
        };
        let (accessor, component) = self.declared(index)?;
        let place = || format!("accessor {index}");
        if accessor.kind != kind {
            let message = format!("its type is {}, needed is {kind}", excerpt(&accessor.kind));
            return Err(LoadProblem::element(place(), message));
        }
        let decode = |bytes: &[u8]| -> [f64; N] {
            std::array::from_fn(|i| component.decode(&bytes[i * component.size()..], accessor.normalized))
        };
        let size = N * component.size();
        let mut elements = match accessor.buffer_view {
            Some(view) => {
                let strided = self.strided(view, accessor.byte_offset(), size, accessor.count);
                let strided = strided.map_err(|problem| within(problem, &place()))?;
                self.count(accessor.count)?;
                strided.iter().map(decode).collect()
            }
            None => {
                self.count(accessor.count.saturating_mul(ZERO))?;
                vec![[0.0; N]; accessor.count]
            }
        };
        if let Some(sparse) = &accessor.sparse {
            self.replace(sparse, size, decode, &mut elements).map_err(|problem| within(problem, &place()))?;
        }
        self.read[index].set(true);
        Ok(elements)
    }

    /// Enters elements into the account of the scene, before there are any.
    pub(super) fn count(&self, elements: usize) -> Result<(), LoadProblem> {
        self.views.ledger().decode(elements)
    }

    /// The buffer views behind the accessors.
    pub(super) fn views(&self) -> &Views<'a> {
        &self.views
    }

    /// The account of the scene.
    pub(super) fn ledger(&self) -> &Ledger {
        self.views.ledger()
    }

    /// Indices of vertices: unsigned integers of any size.
    pub(super) fn indices(&self, index: usize) -> Result<Vec<u32>, LoadProblem> {
        let (accessor, component) = self.declared(index)?;
        if accessor.normalized || !matches!(component, Component::U8 | Component::U16 | Component::U32) {
            let message = "indices must be unsigned integers, not normalised";
            return Err(LoadProblem::element(format!("accessor {index}"), message));
        }
        Ok(self.vectors::<1>(index)?.into_iter().map(|[value]| value as u32).collect())
    }

    /// Puts the values of a sparse accessor in their places.
    fn replace<const N: usize>(
        &self,
        sparse: &Sparse,
        size: usize,
        decode: impl Fn(&[u8]) -> [f64; N],
        elements: &mut [[f64; N]],
    ) -> Result<(), LoadProblem> {
        let from = &sparse.values;
        let places = self.places(sparse, elements.len())?;
        let values = self.strided(from.buffer_view, from.byte_offset, size, sparse.count)?;
        for (place, value) in places.into_iter().zip(values.iter()) {
            elements[place] = decode(value);
        }
        Ok(())
    }

    /// Which of `count` elements a sparse accessor replaces: ascending, and in range.
    pub(super) fn places(&self, sparse: &Sparse, count: usize) -> Result<Vec<usize>, LoadProblem> {
        let refused = |message: String| LoadProblem::element("sparse", message);
        let component = Component::of(sparse.indices.component_type).map_err(refused)?;
        if !matches!(component, Component::U8 | Component::U16 | Component::U32) {
            return Err(refused("its indices must be unsigned integers".to_owned()));
        }
        let at = &sparse.indices;
        if sparse.count > count {
            return Err(refused(format!("{} of its {count} elements are sparse", sparse.count)));
        }
        let strided = self.strided(at.buffer_view, at.byte_offset, component.size(), sparse.count)?;
        let places: Vec<usize> = strided.iter().map(|bytes| component.value(bytes) as usize).collect();
        let mut next = 0;
        for &place in &places {
            if place < next || place >= count {
                return Err(refused(format!("index {place} does not ascend or is not below {count}")));
            }
            next = place + 1;
        }
        Ok(places)
    }

    /// The bytes of `count` elements in a view.
    fn strided(&self, view: usize, offset: usize, size: usize, count: usize) -> Result<Strided<'_>, LoadProblem> {
        let (declared, bytes) = self.views.get(view)?;
        let refused = |message: String| LoadProblem::element(format!("buffer view {view}"), message);
        let stride = declared.stride(size);
        if stride < size {
            return Err(refused(format!("its stride of {stride} bytes is less than an element's {size}")));
        }
        let needed = match count {
            0 => Some(0),
            _ => (count - 1).checked_mul(stride).and_then(|last| last.checked_add(size)),
        };
        let bytes = bytes.get(offset..).filter(|bytes| needed.is_some_and(|needed| needed <= bytes.len()));
        let bytes = bytes.ok_or_else(|| refused(format!("{count} elements of {size} bytes do not fit into it")))?;
        Ok(Strided { bytes, stride, size, count })
    }
}

/// The same problem, told of the element that led to it.
pub(super) fn within(problem: LoadProblem, outer: &str) -> LoadProblem {
    match problem {
        LoadProblem::Element { place, message } => LoadProblem::element(format!("{outer}, {place}"), message),
        other => other,
    }
}
