//! Families: objects that lie together, and families of families.

/// A member of a family: an object by its index, or another family by its index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Member {
    /// Index into the scene's objects.
    Object(usize),
    /// Index into [`FamilyTree::families`].
    Family(usize),
}

/// A named group of objects and smaller families.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Family {
    /// The name the file gives (a node, a group); may be empty.
    pub name: String,
    /// What belongs to it.
    pub members: Vec<Member>,
}

/// The families of a scene as a forest. Objects in no family are members of the scene itself.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FamilyTree {
    /// All families; a family's index is greater than its parent's.
    pub families: Vec<Family>,
    /// What stands at the top.
    pub roots: Vec<Member>,
}
