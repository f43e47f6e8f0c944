//! What is made of single objects when it is first asked for. Of the objects that nothing is asked of it costs less than half a byte, and no time.

use std::sync::OnceLock;

/// Objects whose places are made together.
const PAGE: usize = 64;

/// A place an object.
#[derive(Debug)]
pub(crate) struct ByObject<T> {
    pages: Vec<OnceLock<Box<[OnceLock<T>]>>>,
}

impl<T> ByObject<T> {
    /// Empty places for so many objects.
    pub(crate) fn new(objects: usize) -> Self {
        Self { pages: (0..objects.div_ceil(PAGE)).map(|_| OnceLock::new()).collect() }
    }

    /// What was made of an object.
    pub(crate) fn get(&self, object: usize) -> Option<&T> {
        self.pages[object / PAGE].get()?[object % PAGE].get()
    }

    /// The same, made now if it was not.
    pub(crate) fn get_or_init(&self, object: usize, make: impl FnOnce() -> T) -> &T {
        let page = self.pages[object / PAGE].get_or_init(|| (0..PAGE).map(|_| OnceLock::new()).collect());
        page[object % PAGE].get_or_init(make)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_made_once_and_apart() {
        let places = ByObject::new(130);
        for object in [0, 63, 64, 129] {
            assert_eq!(places.get(object), None);
            assert_eq!(*places.get_or_init(object, || object), object);
            assert_eq!(*places.get_or_init(object, || unreachable!()), object);
        }
        assert_eq!((places.get(65), places.get(129)), (None, Some(&129)));
        assert_eq!(places.pages.iter().filter(|page| page.get().is_some()).count(), 3);
    }
}
