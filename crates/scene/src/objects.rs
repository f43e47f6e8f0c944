//! The objects of a scene in a list, their boxes beside it.

use std::{
    ops::{Deref, DerefMut},
    sync::OnceLock,
};

use umbriel_geometry::BoxColumns;

use crate::object::Object;

/// The objects of a scene: a `Vec` that keeps the boxes of its objects side by side as well, where what matters to a question is found without a look at the rest. The boxes are
/// gathered when the list is made, unless some of them have not been found yet; what changes the list forgets them, and they are gathered anew when they are next asked for.
#[derive(Clone, Debug, Default)]
pub struct Objects {
    list: Vec<Object>,
    boxes: OnceLock<BoxColumns>,
}

impl Objects {
    /// The world boxes of all objects ([`Object::bounds`]), by their places in the list. Cost: a look at every object where they are not gathered, else nothing.
    pub fn boxes(&self) -> &BoxColumns {
        self.boxes.get_or_init(|| self.list.iter().map(|object| object.bounds()).collect())
    }
}

impl From<Vec<Object>> for Objects {
    fn from(list: Vec<Object>) -> Self {
        let objects = Self { list, boxes: OnceLock::new() };
        if objects.list.iter().all(Object::knows_bounds) {
            objects.boxes();
        }
        objects
    }
}

impl<const N: usize> From<[Object; N]> for Objects {
    fn from(list: [Object; N]) -> Self {
        Self::from(Vec::from(list))
    }
}

impl FromIterator<Object> for Objects {
    fn from_iter<I: IntoIterator<Item = Object>>(objects: I) -> Self {
        Self::from(Vec::from_iter(objects))
    }
}

impl Deref for Objects {
    type Target = Vec<Object>;

    fn deref(&self) -> &Vec<Object> {
        &self.list
    }
}

impl DerefMut for Objects {
    fn deref_mut(&mut self) -> &mut Vec<Object> {
        self.boxes = OnceLock::new();
        &mut self.list
    }
}

impl<'a> IntoIterator for &'a Objects {
    type Item = &'a Object;
    type IntoIter = std::slice::Iter<'a, Object>;

    fn into_iter(self) -> Self::IntoIter {
        self.list.iter()
    }
}

impl<'a> IntoIterator for &'a mut Objects {
    type Item = &'a mut Object;
    type IntoIter = std::slice::IterMut<'a, Object>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter_mut()
    }
}

impl IntoIterator for Objects {
    type Item = Object;
    type IntoIter = std::vec::IntoIter<Object>;

    fn into_iter(self) -> Self::IntoIter {
        self.list.into_iter()
    }
}

#[cfg(test)]
mod tests {
    use glam::{DAffine3, DVec3};
    use umbriel_geometry::{Analytic, Cuboid, Placement};

    use super::*;
    use crate::object::{Shape, Sides};

    fn placed(shape: Shape, x: f64) -> Object {
        let placement = Placement::new(DAffine3::from_translation(DVec3::X * x)).expect("regular");
        Object::new(format!("at {x}"), shape, placement, Sides::Auto).expect("an object")
    }

    fn cuboid(x: f64) -> Object {
        placed(Shape::Cuboid(Cuboid { size: [1.0; 3] }), x)
    }

    /// The boxes as they have to be.
    fn gathered(objects: &Objects) -> BoxColumns {
        objects.iter().map(|object| object.bounds()).collect()
    }

    #[test]
    fn boxes_follow_every_change_of_the_list() {
        let mut objects: Objects = (0..20).map(|k| cuboid(f64::from(k))).collect();
        assert!(objects.boxes.get().is_some(), "they are there from the beginning");
        assert_eq!(*objects.boxes(), gathered(&objects));
        objects.push(cuboid(-3.0));
        assert_eq!((objects.boxes().len(), objects.boxes()), (21, &gathered(&objects)));
        objects[4] = cuboid(50.0);
        assert_eq!(*objects.boxes(), gathered(&objects));
        objects.remove(2);
        assert_eq!((objects.boxes().len(), objects.boxes()), (20, &gathered(&objects)));
        assert_eq!(objects.clone().boxes(), objects.boxes());
        assert!(Objects::default().boxes().is_empty());
    }

    #[test]
    fn what_takes_long_to_bound_is_bounded_when_it_is_asked_for() {
        let matrix = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, -1.0]];
        let quadric = Shape::from(Analytic::Quadric { matrix, within: [[-1.0; 3], [1.0; 3]] });
        let objects = Objects::from(vec![cuboid(0.0), placed(quadric, 4.0)]);
        assert!(objects.boxes.get().is_none());
        assert_eq!(*objects.boxes(), gathered(&objects));
    }
}
