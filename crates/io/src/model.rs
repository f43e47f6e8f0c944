//! What a reader makes of a file, in the file's own axes; and the step from there to a scene.

use std::{
    collections::{BTreeMap, HashMap},
    sync::Arc,
};

use glam::{DAffine3, DVec3};
use umbriel_geometry::{LightSource, Mesh, Placement, PlacementDefect};
use umbriel_scene::{
    Camera, Family, FamilyTree, Finding, FindingKind, Light, Member, Object, PartBox, Projection, Scene, Shape, Sides,
};

use crate::{
    error::{LoadProblem, brief, excerpt},
    ledger::{Ledger, Quantity},
    lightmap::LightmapLayout,
    names::{Names, printable},
    rooms::{self, CellShape, ModelCell, ModelPortal, Outline},
};

/// A body as read. Its name need not be unique within a scene yet.
#[derive(Clone, Debug)]
pub(crate) struct ModelObject {
    pub(crate) name: String,
    pub(crate) shape: Shape,
    /// Local to the file's coordinates.
    pub(crate) map: DAffine3,
    /// What the file says about its sides.
    pub(crate) sides: Option<Sides>,
    /// Where its triangles lie on a light map.
    pub(crate) lightmap: Option<Arc<LightmapLayout>>,
    /// Boxes that hold all of it, in its coordinates.
    pub(crate) boxes: Vec<PartBox>,
}

/// The content of a file.
#[derive(Clone, Debug, Default)]
pub(crate) struct Model {
    pub(crate) objects: Vec<ModelObject>,
    pub(crate) families: FamilyTree,
    pub(crate) lights: Vec<Light>,
    pub(crate) camera: Option<Camera>,
    pub(crate) cells: Vec<ModelCell>,
    pub(crate) portals: Vec<ModelPortal>,
    pub(crate) findings: Findings,
}

/// Findings that are told apart. Three bytes may break a rule, and its words take a hundred: what is beyond this many only counts.
const MOST_SUBJECTS: usize = 1 << 16;

/// The subject of those.
const OTHERS: &str = "(others)";

/// Findings by kind and subject, counts added up, the first places kept.
#[derive(Clone, Debug, Default)]
pub(crate) struct Findings(BTreeMap<(FindingKind, String), Found>);

#[derive(Clone, Debug, Default)]
struct Found {
    count: usize,
    places: Vec<String>,
}

impl Findings {
    pub(crate) fn add(&mut self, kind: FindingKind, subject: &str, count: usize) {
        if count > 0 {
            self.entry(kind, subject).count += count;
        }
    }

    /// So many more, for a reason that a user can look up; each reason is told once.
    pub(crate) fn add_with(&mut self, kind: FindingKind, subject: &str, count: usize, reason: &str) {
        if count > 0 {
            let found = self.entry(kind, subject);
            found.count += count;
            if found.places.len() < Finding::PLACES && !found.places.iter().any(|place| place == reason) {
                found.places.push(reason.to_owned());
            }
        }
    }

    /// One more, at a place that a user can look up.
    pub(crate) fn add_at(&mut self, kind: FindingKind, subject: &str, place: impl std::fmt::Display) {
        let found = self.entry(kind, subject);
        found.count += 1;
        if found.places.len() < Finding::PLACES {
            found.places.push(place.to_string());
        }
    }

    fn entry(&mut self, kind: FindingKind, subject: &str) -> &mut Found {
        let key = (kind, subject.to_owned());
        let is_one_more = self.0.len() >= MOST_SUBJECTS && !self.0.contains_key(&key);
        self.0.entry(if is_one_more { (kind, OTHERS.to_owned()) } else { key }).or_default()
    }

    /// Takes over the findings of a part; `rename` says what its subjects are called in the whole.
    pub(crate) fn absorb(&mut self, part: Self, rename: impl Fn(&str) -> String) {
        for ((kind, subject), found) in part.0 {
            let entry = self.entry(kind, &rename(&subject));
            entry.count += found.count;
            entry.places.extend(found.places);
            entry.places.truncate(Finding::PLACES);
        }
    }

    /// Takes out the findings about some subjects, those of each by themselves.
    pub(crate) fn split_off(&mut self, is_wanted: impl Fn(&str) -> bool) -> HashMap<String, Self> {
        let (wanted, rest) = std::mem::take(&mut self.0).into_iter().partition(|((_, subject), _)| is_wanted(subject));
        self.0 = rest;
        let wanted: BTreeMap<(FindingKind, String), Found> = wanted;
        let mut parts: HashMap<String, Self> = HashMap::new();
        for (key, found) in wanted {
            parts.entry(key.1.clone()).or_default().0.insert(key, found);
        }
        parts
    }

    pub(crate) fn into_list(self) -> Vec<Finding> {
        let shown = |text: String| brief(&text).into_owned();
        let finding = |((kind, subject), Found { count, places })| {
            let places = places.into_iter().map(shown).collect();
            Finding { kind, subject: shown(subject), count, places }
        };
        self.0.into_iter().map(finding).collect()
    }
}

impl Model {
    /// Takes in the content of another file under one name: a single object gets the name itself, several become the
    /// family `name` with objects `name/...`. Lights, cells and portals come along unless a part was picked; a camera never does.
    /// Refuses what has a light that `map` moves out of range.
    pub(crate) fn take_in(
        &mut self,
        mut part: Self,
        name: &str,
        map: DAffine3,
        sides: Option<Sides>,
        picked: bool,
    ) -> Result<(), String> {
        let alone = part.objects.len() == 1;
        let full = |inner: &str| if inner.is_empty() { name.to_owned() } else { format!("{name}/{inner}") };
        let first = self.objects.len();
        if alone {
            let inner = std::mem::replace(&mut part.objects[0].name, name.to_owned());
            self.findings
                .absorb(part.findings, |subject| if subject == inner { name.to_owned() } else { full(subject) });
        } else {
            part.objects.iter_mut().for_each(|object| object.name = full(&object.name));
            self.findings.absorb(part.findings, full);
        }
        for object in part.objects {
            self.objects.push(ModelObject { map: map * object.map, sides: sides.or(object.sides), ..object });
        }
        if alone {
            self.families.roots.push(Member::Object(first));
        } else {
            let place = |object| Some(first + object);
            let family = self.families.families.len();
            self.families.families.push(Family { name: name.to_owned(), members: Vec::new() });
            let members = copy_members(&part.families, &part.families.roots, &mut self.families, place);
            self.families.families[family].members = members;
            self.families.roots.push(Member::Family(family));
        }
        if !picked {
            for light in part.lights {
                let moved = moved_light(&light, &map)
                    .ok_or_else(|| format!("its light \"{}\" {LOST_LIGHT}", excerpt(&light.name)))?;
                self.lights.push(Light { name: full(&light.name), ..moved });
            }
            let cells = part.cells.into_iter();
            self.cells.extend(cells.map(|cell| ModelCell { name: full(&cell.name), map: map * cell.map, ..cell }));
            self.portals.extend(part.portals.into_iter().map(|portal| ModelPortal {
                name: full(&portal.name),
                cells: portal.cells.map(|cell| full(&cell)),
                map: map * portal.map,
                ..portal
            }));
        }
        Ok(())
    }

    /// Only an object, or all objects of a family; without findings. Takes no longer than that has parts.
    pub(crate) fn pick(&self, root: Member) -> Self {
        let chosen = objects_below(&self.families, root);
        let objects: Vec<_> = chosen.iter().map(|&old| self.objects[old].clone()).collect();
        let roots = match root {
            Member::Family(family) => self.families.families[family].members.as_slice(),
            Member::Object(_) => &[root],
        };
        let mut families = FamilyTree::default();
        let place = |object| chosen.binary_search(&object).ok();
        families.roots = copy_members(&self.families, roots, &mut families, place);
        Self { objects, families, ..Self::default() }
    }

    /// Tells a rule of the format that an element breaks without harm.
    pub(crate) fn tell(&mut self, place: &str, rule: &str) {
        self.findings.add(FindingKind::BrokenRule, &format!("{place}: {rule}"), 1);
    }

    /// Whether there are not too many objects, families and lights.
    pub(crate) fn check_size(&self, ledger: &Ledger) -> Result<(), LoadProblem> {
        let rooms = self.cells.len() + self.portals.len();
        let parts = self.objects.len() + self.families.families.len() + self.lights.len() + rooms;
        ledger.check(Quantity::Parts, parts as u64)
    }

    /// Whether objects, cells and portals do not place too much.
    fn check_placed(&self, ledger: &Ledger) -> Result<(), LoadProblem> {
        let size = |mesh: &Mesh| (mesh.triangles().len(), mesh.positions().len());
        let of_object = |object: &ModelObject| match &object.shape {
            Shape::Mesh(mesh) => size(mesh),
            _ => (0, 0),
        };
        let of_cell = |cell: &ModelCell| match &cell.shape {
            CellShape::Mesh(mesh) => size(mesh),
            _ => (0, 0),
        };
        let of_portal = |portal: &ModelPortal| match &portal.outline {
            Outline::HullOf(mesh) => (0, mesh.positions().len()),
            Outline::Corners(_) => (0, 0),
        };
        let sizes = || {
            let rooms = self.cells.iter().map(of_cell).chain(self.portals.iter().map(of_portal));
            self.objects.iter().map(of_object).chain(rooms)
        };
        let boxed = self.objects.iter().map(|object| object.boxes.len() as u64 * of_object(object).1 as u64);
        ledger.check(Quantity::PlacedTriangles, sizes().map(|(triangles, _)| triangles as u64).sum())?;
        ledger.check(Quantity::PlacedVertices, sizes().map(|(_, vertices)| vertices as u64).sum())?;
        ledger.check(Quantity::BoxedVertices, boxed.sum())
    }

    /// Turns the content into a scene: names made unique, everything turned by `turn`, every object checked.
    pub(crate) fn into_scene(self, turn: DAffine3, sides: Sides, ledger: &Ledger) -> Result<Scene, LoadProblem> {
        self.check_size(ledger)?;
        self.check_placed(ledger)?;
        let mut names = Names::default();
        let mut objects = Vec::with_capacity(self.objects.len());
        for object in given_back(self.objects) {
            let name = names.unique(&object.name);
            let refused = |defect: &dyn std::fmt::Display| LoadProblem::element(format!("object \"{name}\""), defect);
            let (shape, placement) = placed(object.shape, turn * object.map).map_err(|defect| refused(&*defect))?;
            let sides = object.sides.unwrap_or(sides);
            let checked =
                Object::new(name.clone(), shape, placement, sides).and_then(|placed| placed.with_boxes(object.boxes));
            objects.push(checked.map_err(|defect| refused(&defect))?);
        }
        let mut names = Names::default();
        let mut lights = Vec::with_capacity(self.lights.len());
        for light in self.lights {
            let name = names.unique(&light.name);
            let moved = moved_light(&light, &turn)
                .ok_or_else(|| LoadProblem::element(format!("light \"{name}\""), format!("it {LOST_LIGHT}")))?;
            lights.push(Light { name, ..moved });
        }
        let mut families = self.families;
        for family in &mut families.families {
            family.name = printable(&family.name).into_owned();
        }
        let camera = self.camera.map(|camera| turned_camera(&camera, &turn));
        let cells = rooms::graph(self.cells, self.portals, &turn, &objects)?;
        let mut findings = self.findings.into_list();
        findings.extend(rooms::overlaps(&cells));
        if objects.iter().all(|object| object.face_count() == 0) {
            let (kind, subject, places) = (FindingKind::EmptyScene, String::new(), Vec::new());
            findings.push(Finding { kind, subject, count: 1, places });
        }
        Ok(Scene { objects: objects.into(), families, lights, camera, cells, findings })
    }
}

/// The items of a list from the first on. Its room is given back as they go: what is made of them takes as much.
fn given_back<T>(mut list: Vec<T>) -> impl Iterator<Item = T> {
    list.reverse();
    std::iter::from_fn(move || {
        if list.len() <= list.capacity() / 2 {
            list.shrink_to_fit();
        }
        list.pop()
    })
}

/// A shape and its placement. A mesh that its map flattens becomes one of its own, as flat: a placement has to be regular.
fn placed(shape: Shape, map: DAffine3) -> Result<(Shape, Placement), Box<dyn std::error::Error>> {
    match (Placement::new(map), shape) {
        (Err(PlacementDefect::Singular), Shape::Mesh(mesh)) => {
            Ok((Shape::Mesh(Arc::new(mesh.mapped(&map)?)), Placement::IDENTITY))
        }
        (placement, shape) => Ok((shape, placement?)),
    }
}

/// What a light does that is none once moved.
const LOST_LIGHT: &str = "lies too far away or has no direction";

/// A light moved with its model; `None` where the result is no light.
fn moved_light(light: &Light, map: &DAffine3) -> Option<Light> {
    let source = if light.source.is_sun() {
        LightSource::sun(map.transform_vector3(-light.source.xyz()).to_array()).ok()
    } else {
        LightSource::point(map.transform_point3(light.source.xyz()).to_array()).ok()
    };
    Light::with_extent(light.name.clone(), source?, light.extent.mapped(&map.matrix3)).ok()
}

fn turned_camera(camera: &Camera, turn: &DAffine3) -> Camera {
    let point = |v: DVec3| turn.transform_point3(v);
    Camera { eye: point(camera.eye), target: point(camera.target), up: turn.transform_vector3(camera.up), ..*camera }
}

/// A camera, unless it has no view.
pub(crate) fn camera(eye: DVec3, target: DVec3, up: DVec3, projection: Projection) -> Result<Camera, &'static str> {
    let regular = match projection {
        Projection::Perspective { vertical_degrees } => vertical_degrees > 0.0 && vertical_degrees < 180.0,
        Projection::Orthographic { height } => height > 0.0 && height.is_finite(),
        _ => true,
    };
    let finite = eye.is_finite() && target.is_finite() && up.is_finite();
    if !regular {
        Err("its field of view must be between 0 and 180 degrees, or its height a positive number of metres")
    } else if !finite || (target - eye).cross(up) == DVec3::ZERO {
        Err("its eye and target must be two points, and its up vector not parallel to the view")
    } else {
        Ok(Camera { eye, target, up, projection })
    }
}

/// The objects below a member, in the order of the file.
fn objects_below(tree: &FamilyTree, root: Member) -> Vec<usize> {
    let (mut open, mut objects) = (vec![root], Vec::new());
    while let Some(member) = open.pop() {
        match member {
            Member::Object(object) => objects.push(object),
            Member::Family(family) => open.extend(&tree.families[family].members),
        }
    }
    objects.sort_unstable();
    objects
}

/// Copies families below `members` into another tree; `place` says where objects went. Parents come before children.
fn copy_members(
    source: &FamilyTree,
    members: &[Member],
    target: &mut FamilyTree,
    place: impl Fn(usize) -> Option<usize>,
) -> Vec<Member> {
    let mut open = Vec::new();
    let copy = |members: &[Member], target: &mut FamilyTree, open: &mut Vec<(usize, usize)>| -> Vec<Member> {
        let copied = members.iter().filter_map(|&member| match member {
            Member::Object(object) => place(object).map(Member::Object),
            Member::Family(family) => {
                let new = target.families.len();
                target.families.push(Family { name: source.families[family].name.clone(), members: Vec::new() });
                open.push((family, new));
                Some(Member::Family(new))
            }
        });
        copied.collect()
    };
    let roots = copy(members, target, &mut open);
    while let Some((old, new)) = open.pop() {
        target.families[new].members = copy(&source.families[old].members, target, &mut open);
    }
    roots
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn findings_beyond_a_number_only_count() {
        let mut findings = Findings::default();
        (0..MOST_SUBJECTS + 1000)
            .for_each(|number| findings.add(FindingKind::BrokenRule, &format!("image {number}"), 1));
        findings.add(FindingKind::BrokenRule, "image 7", 1);
        let list = findings.into_list();
        assert_eq!(list.len(), MOST_SUBJECTS + 1);
        assert_eq!(list.iter().map(|finding| finding.count).sum::<usize>(), MOST_SUBJECTS + 1001);
        let others = list.iter().find(|finding| finding.subject == OTHERS).expect("told");
        assert_eq!(others.count, 1000);
    }
}
