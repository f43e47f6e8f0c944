//! Kinds of defects, what each does to the result, and the sums over a scene.

/// What limits the answers about a surface. The snake-case name is part of the JSON contract.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum DefectKind {
    /// Edges whose directed uses do not cancel. Area: their components.
    OpenEdges,
    /// Edges that exactly two faces use in the same direction; they are also open. Area: their components.
    InconsistentOrientation,
    /// Edges of three faces or more. Area: the faces at them.
    NonManifoldEdges,
    /// Closed components of negative volume. Area: theirs.
    InsideOut,
    /// Triangles with the same corners as an earlier one of the object. Area: the repeating ones.
    DuplicateFaces,
    /// Faces that overlap another face in the same plane, not turned away from it. Area: what is covered.
    CoplanarOverlap,
    /// The same with the faces back to back. Area: what is covered.
    Contact,
    /// Faces that were not compared with all faces of their plane whose boxes meet theirs: overlaps and contacts among them are counted in part. Area: theirs.
    CrowdedPlane,
    /// Faces without area, exactly.
    ZeroAreaFaces,
    /// Faces more than [`DefectKind::SLIVER_ASPECT`] times as long as high. Area: theirs.
    Slivers,
    /// Faces whose place or shape is known only as well as their coordinates are rounded. Area: theirs.
    CoarseCoordinates,
    /// Faces that fit into one cell as a whole. Area: theirs.
    SmallFaces,
    /// Components that fit into one cell, of several. Area: theirs.
    SmallComponents,
    /// An object without any area.
    NoSurface,
    /// Vertices that no triangle uses.
    UnreferencedVertices,
    /// A point light within a closed body whose faces look outward. Area: the body's closed components around it.
    LampInsideBody,
    /// A point light exactly on faces. Area: theirs.
    LampOnSurface,
    /// Faces in whose plane a light lies exactly. Area: theirs.
    EdgeOnFaces,
    /// A sun whose light travels upward.
    SunBelowHorizon,
    /// A light to which no surface at all is turned.
    NothingTurned,
}

impl DefectKind {
    /// A face is a sliver when its longest edge is more than this many times its height over it. Costs grow with that
    /// ratio, and nothing is decided by this number.
    pub const SLIVER_ASPECT: f64 = 1e4;

    /// The name used in JSON output.
    pub fn name(self) -> &'static str {
        match self {
            Self::OpenEdges => "open_edges",
            Self::InconsistentOrientation => "inconsistent_orientation",
            Self::NonManifoldEdges => "non_manifold_edges",
            Self::InsideOut => "inside_out",
            Self::DuplicateFaces => "duplicate_faces",
            Self::CoplanarOverlap => "coplanar_overlap",
            Self::Contact => "contact",
            Self::CrowdedPlane => "crowded_plane",
            Self::ZeroAreaFaces => "zero_area_faces",
            Self::Slivers => "slivers",
            Self::CoarseCoordinates => "coarse_coordinates",
            Self::SmallFaces => "small_faces",
            Self::SmallComponents => "small_components",
            Self::NoSurface => "no_surface",
            Self::UnreferencedVertices => "unreferenced_vertices",
            Self::LampInsideBody => "lamp_inside_body",
            Self::LampOnSurface => "lamp_on_surface",
            Self::EdgeOnFaces => "edge_on_faces",
            Self::SunBelowHorizon => "sun_below_horizon",
            Self::NothingTurned => "nothing_turned",
        }
    }

    /// What it does to the result, in one sentence or two.
    pub fn consequence(self) -> &'static str {
        match self {
            Self::OpenEdges => {
                "The component is not closed, so both of its sides can be lit, inner ones too. Light passes through real \
                 gaps only, never between faces that share an edge."
            }
            Self::InconsistentOrientation => {
                "Two faces use the edge in the same direction, so their component is not closed and counts as \
                 two-sided. Turn one of them over where the surface is meant to be closed."
            }
            Self::NonManifoldEdges => {
                "Three faces or more share an edge. Shadows are right all the same; the component is one-sided only if \
                 all directions cancel."
            }
            Self::InsideOut => {
                "Closed, with windings that face inward: taken as a cavity and lit on its inside only. An outer skin \
                 wound like this stays dark."
            }
            Self::DuplicateFaces => {
                "Faces that lie in each other do not shadow each other: both are lit alike, and the area counts for \
                 each of them."
            }
            Self::CoplanarOverlap => {
                "Faces lie exactly in one plane and overlap. Equal depth never blocks: both are lit alike, and what \
                 they share counts twice."
            }
            Self::Contact => {
                "Faces lie on each other back to back. Contact never blocks: a light inside one body lights the other \
                 through them; the hidden area counts for both."
            }
            Self::CrowdedPlane => {
                "Too many faces lie close to each other in one plane to compare all: overlap and contact may be more \
                 than is said."
            }
            Self::ZeroAreaFaces => "Faces without area have no lit side; they still block, as the segments they are.",
            Self::Slivers => {
                "Answers stay right; a sliver is divided as finely as its length asks for, many cells for hardly any \
                 area."
            }
            Self::CoarseCoordinates => {
                "Positions are rounded this far before they get here, and shadow borders move as much. Store the model \
                 nearer to its own origin, or with more digits."
            }
            Self::SmallFaces => {
                "The faces fit into a single cell: one that a shadow border touches is undecided as a whole. More depth \
                 helps."
            }
            Self::SmallComponents => {
                "Loose pieces smaller than a cell: whatever they shadow is undecided or costs a border of its own."
            }
            Self::NoSurface => "There is nothing to light; areas are zero.",
            Self::UnreferencedVertices => "No triangle uses them: they change nothing.",
            Self::LampInsideBody
            | Self::LampOnSurface
            | Self::EdgeOnFaces
            | Self::SunBelowHorizon
            | Self::NothingTurned => self.consequence_of_light(),
        }
    }

    /// The same for the kinds that are about lights.
    fn consequence_of_light(self) -> &'static str {
        match self {
            Self::LampInsideBody => {
                "The lamp is inside a closed body whose faces look away from it: it lights none of them, and nothing \
                 outside but what is in contact with the body."
            }
            Self::LampOnSurface => {
                "The lamp lies exactly on a face: that face stays dark, does not block, and light goes out on both of \
                 its sides."
            }
            Self::EdgeOnFaces => "The light lies exactly in the plane of these faces: neither of their sides is lit.",
            Self::SunBelowHorizon => "The light travels upward: what is lit is lit from below.",
            _ => "No surface has a lit side turned to the light: everything is dark.",
        }
    }
}

/// What a defect is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Place {
    /// An object of the scene, by its index.
    Object(usize),
    /// A light of the scene, by its index.
    Light(usize),
}

/// A number that belongs to a defect.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Note {
    /// How far positions may be off, metres.
    Rounding(f64),
    /// The boundary depth from which all but a hundredth of the object's surface is divided.
    Depth(u8),
    /// The object that a lamp is in (the first of several).
    Body(usize),
}

/// One kind of defect of one object or light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Defect {
    /// What it is.
    pub kind: DefectKind,
    /// Where.
    pub place: Place,
    /// How many edges, faces, components or vertices.
    pub count: usize,
    /// How much surface it concerns, square metres, rounded.
    pub area: f64,
    /// The same as a part (0 to 1) of the object's surface, or of the scene's for a light.
    pub share: f64,
    /// What else there is to say.
    pub note: Option<Note>,
}

impl Defect {
    pub(super) fn new(kind: DefectKind, place: Place, count: usize, area: f64) -> Self {
        Self { kind, place, count, area, share: 0.0, note: None }
    }

    pub(super) fn with(self, note: Note) -> Self {
        Self { note: Some(note), ..self }
    }
}

/// One kind of defect over the whole scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Total {
    /// What it is.
    pub kind: DefectKind,
    /// How many.
    pub count: usize,
    /// How much surface, square metres.
    pub area: f64,
    /// The same as a part (0 to 1) of the scene's flat surface.
    pub share: f64,
    /// The places, the largest area first.
    pub places: Vec<Place>,
    /// The farthest rounding or the greatest depth of all places.
    pub note: Option<Note>,
}

/// What was found about a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Diagnosis {
    /// How many objects there are.
    pub objects: usize,
    /// How many of them are curved: nothing is found about these, and areas leave them out.
    pub curved: usize,
    /// How many flat faces there are.
    pub faces: usize,
    /// Their area, square metres, each face once.
    pub area: f64,
    /// What was found, by kind, then by object or light.
    pub defects: Vec<Defect>,
}

impl Diagnosis {
    /// The sums over all objects and lights, one a kind, the largest area first.
    pub fn totals(&self) -> Vec<Total> {
        let of_one_kind = self.defects.chunk_by(|a, b| a.kind == b.kind);
        let mut totals: Vec<Total> = of_one_kind.map(|defects| self.total(defects)).collect();
        totals.sort_by(|a, b| b.area.total_cmp(&a.area).then(a.kind.cmp(&b.kind)));
        totals
    }

    fn total(&self, defects: &[Defect]) -> Total {
        let area = defects.iter().map(|defect| defect.area).sum::<f64>();
        let mut by_area: Vec<&Defect> = defects.iter().collect();
        by_area.sort_by(|a, b| b.area.total_cmp(&a.area).then(a.place.cmp(&b.place)));
        Total {
            kind: defects[0].kind,
            count: defects.iter().map(|defect| defect.count).sum(),
            area,
            share: if self.area > 0.0 { (area / self.area).min(1.0) } else { 0.0 },
            places: by_area.iter().map(|defect| defect.place).collect(),
            note: defects.iter().filter_map(|defect| defect.note).reduce(worse),
        }
    }
}

fn worse(a: Note, b: Note) -> Note {
    match (a, b) {
        (Note::Rounding(a), Note::Rounding(b)) => Note::Rounding(a.max(b)),
        (Note::Depth(a), Note::Depth(b)) => Note::Depth(a.max(b)),
        (first, _) => first,
    }
}
