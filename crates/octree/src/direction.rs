//! The 26 directions in which cells touch: through a face, along an edge, at a corner.

/// A step of −1, 0 or 1 along each axis, not all 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Direction([i8; 3]);

impl Direction {
    /// The six directions through faces: −x, +x, −y, +y, −z, +z.
    pub const FACES: [Self; 6] =
        [Self([-1, 0, 0]), Self([1, 0, 0]), Self([0, -1, 0]), Self([0, 1, 0]), Self([0, 0, -1]), Self([0, 0, 1])];

    /// The direction with these steps; `None` unless each is −1, 0 or 1 and one is not 0.
    pub fn new(steps: [i8; 3]) -> Option<Self> {
        let is_sound = steps.iter().all(|step| (-1..=1).contains(step)) && steps != [0; 3];
        is_sound.then_some(Self(steps))
    }

    /// All 26 directions.
    pub fn all() -> impl Iterator<Item = Self> {
        (0..27i8).filter_map(|n| Self::new([n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1]))
    }

    /// The twelve directions along edges.
    pub fn edges() -> impl Iterator<Item = Self> {
        Self::all().filter(|direction| direction.axes() == 2)
    }

    /// The eight directions at corners.
    pub fn corners() -> impl Iterator<Item = Self> {
        Self::all().filter(|direction| direction.axes() == 3)
    }

    /// The steps along x, y and z.
    pub fn steps(self) -> [i8; 3] {
        self.0
    }

    /// The way back.
    #[must_use]
    pub fn opposite(self) -> Self {
        Self(self.0.map(|step| -step))
    }

    /// Along how many axes it steps: 1 through a face, 2 along an edge, 3 at a corner.
    pub fn axes(self) -> usize {
        self.0.iter().filter(|step| **step != 0).count()
    }

    /// Whether the child with this number of a cell in this direction touches where one comes from.
    pub(crate) fn is_near_side(self, child: u64) -> bool {
        self.0.iter().enumerate().all(|(axis, step)| match step {
            0 => true,
            step => (child >> axis & 1 == 1) == (*step == -1),
        })
    }
}
