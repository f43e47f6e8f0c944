//! How the tree lies in memory: nodes of eight boxes, packs of eight triangles, both by coordinate and lane.

/// Children of a node, triangles of a pack.
pub(super) const WIDTH: usize = 8;

/// Eight boxes and where they lead. Four cache lines.
// | min x × 8 | min y × 8 | min z × 8 | max x × 8 | max y × 8 | max z × 8 | children × 8 | leaves | padding |
// |  32 bytes |           |           |           |           |           |  32          |   4    |   28    |
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// The boxes' planes, rounded outward; an empty lane has min = +∞ and max = −∞, and no ray meets it.
    pub(super) planes: [[f32; WIDTH]; 6],
    /// Inner children: indices of nodes. Leaves: indices of packs.
    pub(super) children: [u32; WIDTH],
    /// Bit i is set where child i is a leaf.
    pub(super) leaves: u32,
}

const _: () = assert!(size_of::<Node>() == 256);

impl Node {
    pub(super) const EMPTY: Self = Self {
        planes: [
            [f32::INFINITY; WIDTH],
            [f32::INFINITY; WIDTH],
            [f32::INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
        ],
        children: [0; WIDTH],
        leaves: 0,
    };
}

/// Up to eight triangles. Lanes that are left over repeat the first triangle. Five cache lines.
// | a.x × 8 | a.y × 8 | a.z × 8 | b.x … b.z | c.x … c.z | triangles × 8 |
// |   32    |         |         |    96     |    96     |      32       |
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Pack {
    /// Corner, axis, lane; each coordinate at most half an ulp of f32 from the corner in the frame.
    pub(super) corners: [[[f32; WIDTH]; 3]; 3],
    /// Which triangles of the mesh they are.
    pub(super) triangles: [u32; WIDTH],
}

const _: () = assert!(size_of::<Pack>() == 320);

impl Pack {
    /// To be filled.
    pub(super) const ZERO: Self = Self { corners: [[[0.0; WIDTH]; 3]; 3], triangles: [0; WIDTH] };
}
