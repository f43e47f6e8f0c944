//! What material libraries (MTL) say of transparency. Surfaces of an OBJ block light as if they were opaque; that it is so is told.

use std::collections::BTreeSet;

use crate::text;

/// The names of the materials that are not opaque: a `d` below 1, without one a `Tr` above 0, or a picture for it (`map_d`).
pub(super) fn transparent(library: &str) -> BTreeSet<&str> {
    let mut names = BTreeSet::new();
    let mut material = Material::default();
    for line in text::lines(library) {
        let line = line.trim();
        let numbers = line.split_once('#').map_or(line, |(numbers, _)| numbers);
        let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        // An option may stand before the number.
        let number = || numbers.split_whitespace().next_back()?.parse::<f64>().ok();
        match keyword {
            "newmtl" => {
                names.extend(material.transparent_name());
                material = Material { name: Some(rest.trim()), ..Material::default() };
            }
            "d" => material.dissolve = number(),
            "Tr" => material.transparency = number(),
            "map_d" => material.has_map = true,
            _ => {}
        }
    }
    names.extend(material.transparent_name());
    names
}

#[derive(Default)]
struct Material<'a> {
    name: Option<&'a str>,
    dissolve: Option<f64>,
    transparency: Option<f64>,
    has_map: bool,
}

impl<'a> Material<'a> {
    fn transparent_name(&self) -> Option<&'a str> {
        let opacity = self.dissolve.or_else(|| Some(1.0 - self.transparency?));
        self.name.filter(|_| self.has_map || opacity.is_some_and(|opacity| opacity < 1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn materials_that_are_not_opaque_are_found() {
        let library = "d 0\nnewmtl wall\nd 1.0 # not 0.5\nTr 1\nnewmtl glass pane\r\n  d -halo 0.3 # was 1\rnewmtl leaf\nKd 1 1 1\nmap_d leaf.png\n\
            newmtl veil\nTr 0.5\nnewmtl solid\nTr 0\nnewmtl odd\nd x";
        assert_eq!(transparent(library).into_iter().collect::<Vec<_>>(), ["glass pane", "leaf", "veil"]);
    }
}
