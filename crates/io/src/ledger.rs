//! What a scene has cost so far, against limits that grow with its files.
//!
//! A small file can ask for much: thousands of nodes that place one mesh, primitives that share one accessor, accessors
//! without bytes of their own. Each quantity may reach a generous base, plus some for the bytes of the files that were
//! read; so whatever is written out in full is always read, and only multiplication is limited.

use std::{
    cell::RefCell,
    collections::BTreeMap,
    fs,
    io::{self, Read},
    path::{Path, PathBuf},
};

use crate::{error::LoadProblem, folder::Located};

/// What is limited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quantity {
    /// Elements of accessors, decoded.
    Elements,
    /// Objects, families and lights.
    Parts,
    /// Triangles, counted once for every object or cell that places them.
    PlacedTriangles,
    /// Vertices, counted in the same way: a mesh may hold any number that no triangle uses.
    PlacedVertices,
    /// For each object its vertices times its boxes, since every vertex is looked for in these.
    BoxedVertices,
    /// Texels of pictures, decoded.
    Texels,
}

impl Quantity {
    /// The limit for a scene without files.
    fn base(self) -> u64 {
        match self {
            Self::Elements => 1 << 24,
            Self::Parts => 1 << 18,
            Self::PlacedTriangles => 1 << 23,
            Self::PlacedVertices => 3 << 23,
            Self::BoxedVertices => 1 << 30,
            Self::Texels => 1 << 26,
        }
    }

    /// How much so many bytes of files add. Models are placed some times on average; elements stand for bytes; and no object
    /// is written in four (the shortest of an OBJ, each in a family of its own, take seven a part). Pictures of leaves are packed to a quarter
    /// of a byte a texel at best.
    fn for_bytes(self, bytes: u64) -> u64 {
        match self {
            Self::Elements => bytes,
            Self::Parts => bytes / 4,
            Self::PlacedTriangles => 8 * bytes,
            Self::PlacedVertices => 24 * bytes,
            Self::BoxedVertices => 64 * bytes,
            Self::Texels => 4 * bytes,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Elements => "decoded elements of accessors",
            Self::Parts => "objects, families and lights",
            Self::PlacedTriangles => "placed triangles",
            Self::PlacedVertices => "placed vertices",
            Self::BoxedVertices => "pairs of a vertex and a box",
            Self::Texels => "texels of pictures",
        }
    }
}

/// The account of one scene.
#[derive(Debug, Default)]
pub(crate) struct Ledger {
    account: RefCell<Account>,
}

#[derive(Debug, Default)]
struct Account {
    /// How many bytes of each were read.
    files: BTreeMap<PathBuf, u64>,
    bytes: u64,
    elements: u64,
    texels: u64,
    /// Those of pictures without alpha.
    opaque_texels: u64,
}

impl Ledger {
    /// The bytes of a regular file.
    pub(crate) fn read(&self, file: &Located) -> Result<Vec<u8>, LoadProblem> {
        self.read_most(file, usize::MAX).map(|(bytes, _)| bytes)
    }

    /// At most so many bytes of a regular file, and whether these are all.
    pub(crate) fn read_most(&self, file: &Located, most: usize) -> Result<(Vec<u8>, bool), LoadProblem> {
        let unreadable = |source| LoadProblem::Unreadable { path: file.shown.clone(), source };
        // A pipe or a device may never end.
        let metadata = fs::metadata(&file.real).map_err(unreadable)?;
        if !metadata.is_file() {
            return Err(unreadable(io::Error::new(io::ErrorKind::InvalidInput, "it is not a regular file")));
        }
        let most = most as u64;
        let mut bytes = Vec::new();
        bytes.try_reserve_exact(usize::try_from(metadata.len().min(most)).unwrap_or(usize::MAX)).map_err(|_| {
            unreadable(io::Error::new(io::ErrorKind::OutOfMemory, "it is larger than the memory that is left"))
        })?;
        let content = fs::File::open(&file.real).map_err(unreadable)?;
        content.take(most).read_to_end(&mut bytes).map_err(unreadable)?;
        let is_whole = bytes.len() as u64 >= metadata.len();
        let mut account = self.account.borrow_mut();
        let counted = account.files.entry(file.real.clone()).or_default();
        let more = (bytes.len() as u64).saturating_sub(*counted);
        *counted += more;
        account.bytes += more;
        Ok((bytes, is_whole))
    }

    /// Counts the bytes of a file that was read elsewhere.
    pub(crate) fn count(&self, bytes: &[u8]) {
        self.account.borrow_mut().bytes += bytes.len() as u64;
    }

    /// Whether so much is acceptable.
    pub(crate) fn check(&self, quantity: Quantity, count: u64) -> Result<(), LoadProblem> {
        let most = quantity.base() + quantity.for_bytes(self.account.borrow().bytes);
        if count <= most { Ok(()) } else { Err(LoadProblem::TooMuch { what: quantity.name(), count, most }) }
    }

    /// How many elements may still be decoded.
    pub(crate) fn elements_left(&self) -> u64 {
        let account = self.account.borrow();
        (Quantity::Elements.base() + account.bytes).saturating_sub(account.elements)
    }

    /// Adds to the elements that were decoded, before they are.
    pub(crate) fn decode(&self, count: usize) -> Result<(), LoadProblem> {
        let mut account = self.account.borrow_mut();
        account.elements = account.elements.saturating_add(count as u64);
        let elements = account.elements;
        drop(account);
        self.check(Quantity::Elements, elements)
    }

    /// Adds to the texels that were decoded, before they are.
    pub(crate) fn picture(&self, texels: u64) -> Result<(), LoadProblem> {
        let all = self.account.borrow().texels.saturating_add(texels);
        self.check(Quantity::Texels, all)?;
        self.account.borrow_mut().texels = all;
        Ok(())
    }

    /// Adds to the texels that are decoded and not kept, if so many more may be.
    pub(crate) fn may_look_at(&self, texels: u64) -> bool {
        let all = self.account.borrow().opaque_texels.saturating_add(texels);
        let is_little = self.check(Quantity::Texels, all).is_ok();
        if is_little {
            self.account.borrow_mut().opaque_texels = all;
        }
        is_little
    }

    /// All files that were read.
    pub(crate) fn files(&self) -> Vec<PathBuf> {
        self.account.borrow().files.keys().cloned().collect()
    }
}

/// A file that the user names: nothing to resolve.
pub(crate) fn as_named(path: &Path) -> Located {
    let real = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
    Located { shown: path.to_path_buf(), real }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_grow_with_the_files_and_each_file_counts_once() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.bin");
        fs::write(&path, [7; 1000]).expect("written");
        let ledger = Ledger::default();
        let base = Quantity::Parts.base();
        assert!(ledger.check(Quantity::Parts, base).is_ok() && ledger.check(Quantity::Parts, base + 1).is_err());
        for _ in 0..3 {
            assert_eq!(ledger.read(&as_named(&path)).expect("bytes").len(), 1000);
        }
        assert!(ledger.check(Quantity::Parts, base + 250).is_ok());
        assert!(ledger.check(Quantity::Parts, base + 251).is_err());
        assert_eq!(ledger.files(), [path.canonicalize().expect("a path")]);
    }

    #[test]
    fn decoded_elements_add_up() {
        let ledger = Ledger::default();
        let most = Quantity::Elements.base() as usize;
        assert!(ledger.decode(most / 2).is_ok() && ledger.decode(most / 2).is_ok());
        let message = ledger.decode(1).expect_err("too much").to_string();
        assert!(message.contains("decoded elements") && message.contains(&most.to_string()), "{message}");
        assert!(ledger.decode(usize::MAX).is_err());
    }
}
