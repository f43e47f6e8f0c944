//! Primitives compressed by KHR_draco_mesh_compression, decoded by `draco-core`.
//!
//! A stream describes far more than its length when much of it is alike, so what it may become is limited by what the
//! scene has left of its decoded elements. The stream's own order of vertices and triangles is kept.

use draco_core::{DataType, DecodeLimits, DecoderBuffer, Mesh, MeshDecoder, PointAttribute, PointIndex};

use super::{accessor::Component, views::ELEMENT};

/// A decoded primitive.
pub(super) struct Decoded(Mesh);

/// Decodes a stream to at most so many vertices and corners of triangles.
pub(super) fn decode(stream: &[u8], most: u64) -> Result<Decoded, String> {
    let limits = DecodeLimits::default()
        .with_max_points(most)
        .with_max_faces(most / 3)
        .with_max_decoded_bytes(most.saturating_mul(ELEMENT as u64));
    let mut mesh = Mesh::new();
    MeshDecoder::new()
        .decode(&mut DecoderBuffer::new(stream).with_limits(limits), &mut mesh)
        .map_err(|fault| format!("its stream is not read: {fault}"))?;
    Ok(Decoded(mesh))
}

impl Decoded {
    /// The number of vertices.
    pub(super) fn len(&self) -> usize {
        self.0.num_points()
    }

    /// Whether there is an attribute of that number.
    pub(super) fn has(&self, id: u32) -> bool {
        self.0.attribute_by_unique_id(id).is_some()
    }

    /// The type of an attribute's components, if glTF has it.
    pub(super) fn component(&self, id: u32) -> Option<Component> {
        component(self.0.attribute_by_unique_id(id)?.data_type()).ok()
    }

    /// The number of corners of triangles.
    pub(super) fn corner_count(&self) -> usize {
        3 * self.0.num_faces()
    }

    /// The corners of the triangles, three each.
    pub(super) fn corners(&self) -> Vec<u32> {
        self.0.faces().iter().flatten().map(|corner| corner.0).collect()
    }

    /// The attribute of that number, a value for each vertex; integers are divided where the accessor says that they are
    /// normalised.
    pub(super) fn vectors<const N: usize>(&self, id: u32, normalized: bool) -> Result<Vec<[f64; N]>, String> {
        let attribute = self.0.attribute_by_unique_id(id).ok_or_else(|| format!("it has no attribute {id}"))?;
        let component = component(attribute.data_type())?;
        if usize::from(attribute.num_components()) != N {
            let has = attribute.num_components();
            return Err(format!("its attribute {id} has {has} components, needed are {N}"));
        }
        let stride = usize::try_from(attribute.byte_stride()).unwrap_or_default();
        let vector = |point: u32| {
            let bytes = value(attribute, point, stride, N * component.size())?;
            Some(std::array::from_fn(|i| component.decode(&bytes[i * component.size()..], normalized)))
        };
        let points = u32::try_from(self.len()).map_err(|_| "it has more than 2^32 vertices".to_owned())?;
        let vectors = (0..points).map(vector).collect::<Option<_>>();
        vectors.ok_or_else(|| format!("its attribute {id} has no value for some vertex"))
    }
}

/// The bytes of a vertex' value, if it has one.
fn value(attribute: &PointAttribute, point: u32, stride: usize, size: usize) -> Option<&[u8]> {
    let index = attribute.mapped_index(PointIndex(point)).0 as usize;
    let start = index.checked_mul(stride)?;
    attribute.buffer().data().get(start..start.checked_add(size)?)
}

fn component(kind: DataType) -> Result<Component, String> {
    match kind {
        DataType::Int8 => Ok(Component::I8),
        DataType::Uint8 => Ok(Component::U8),
        DataType::Int16 => Ok(Component::I16),
        DataType::Uint16 => Ok(Component::U16),
        DataType::Uint32 => Ok(Component::U32),
        DataType::Float32 => Ok(Component::F32),
        other => Err(format!("it holds components of the type {other:?}, which glTF does not have")),
    }
}
