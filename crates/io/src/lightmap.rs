//! Where the triangles of a mesh lie on its light map.

/// A mesh's layout on a picture: texture coordinates, one triple a triangle of the mesh, in its order.
///
/// (0, 0) is the upper left corner of the picture and (1, 1) the lower right one, as in glTF. Triangles that the file
/// gives no coordinates have all three at (0, 0): no area, no place on the picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightmapLayout {
    /// The coordinates of the triangles' corners; finite.
    pub triangles: Vec<[[f64; 2]; 3]>,
}

impl LightmapLayout {
    /// The layout, unless no triangle has a place.
    pub(crate) fn of(triangles: Vec<[[f64; 2]; 3]>) -> Option<Self> {
        let has_place = |triangle: &[[f64; 2]; 3]| *triangle != NOWHERE;
        triangles.iter().any(has_place).then_some(Self { triangles })
    }
}

/// The coordinates of a triangle that has none.
pub(crate) const NOWHERE: [[f64; 2]; 3] = [[0.0; 2]; 3];
