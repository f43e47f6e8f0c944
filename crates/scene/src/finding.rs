//! Findings: what was taken otherwise than the file says, told once with a count.

/// What kind of thing was found. The snake-case name is part of the JSON contract.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum FindingKind {
    /// Edges whose directed uses do not cancel: the component is open and counts as two-sided.
    OpenEdges,
    /// Edges that two triangles use in one direction: they are wound differently, and the edge is open.
    InconsistentWinding,
    /// Triangles without area.
    ZeroAreaFaces,
    /// Triangles with the same corners as another one.
    DuplicateFaces,
    /// A body none of whose surface lies in the box that cuts it.
    NoSurface,
    /// A quadric without an inside: a plane, a line or a point counted twice. It blocks, and has no surface of its own.
    NoInside,
    /// Neither a triangle nor a body in the whole scene: nothing casts or receives a shadow.
    EmptyScene,
    /// A MASK material taken as opaque.
    MaskAsOpaque,
    /// A BLEND material taken as opaque.
    BlendAsOpaque,
    /// A BLEND material that blocks nothing, as the user wants.
    BlendIgnored,
    /// A spot light taken as a point light.
    SpotAsPoint,
    /// An area light (a sphere, a rectangle, a sun with a diameter) taken as its centre.
    AreaLightAsPoint,
    /// An optional extension of the file that is not read.
    UnknownExtension,
    /// Points, lines, or primitives without positions, which have no surface.
    NotTriangles,
    /// Skins taken at their bind pose, or morph targets at their default weights.
    Deformation,
    /// A rule of the file's format that is broken without leaving a doubt about what is meant; the subject says where.
    BrokenRule,
    /// Rows of a text file that are not a line each: one number that lacks or is too many shifts all that follow.
    UnevenRows,
    /// A shape that has no body here: a plane without an end, a capsule with two radii, one made from a mesh.
    UnreadShape,
    /// A MASK material without a texture, or with one that is not there or not read: its alpha counts as one.
    MissingTexture,
    /// A material library that is not there.
    MissingMaterials,
    /// An OBJ whose extents look z-up.
    LooksZUp,
    /// A polygon whose corners do not lie in a plane; it was triangulated all the same.
    NonPlanarPolygons,
    /// A polygon that crosses itself, as seen along its normal: triangles of it lie on each other or are turned over.
    CrossingPolygons,
    /// An object that is another one again: the same body in the same place.
    DuplicateObjects,
    /// Cells that overlap, or portals between the same cells.
    OverlappingCells,
    /// Suns of a table at or below the horizon; they give no light.
    SunsBelowHorizon,
    /// Suns of a table, given by their directions, that do not shine downward; they are taken as they are.
    SunsFromBelow,
    /// Lights whose shadows take more than the typical effort: not all cells are as fine as they are where nobody says how fine.
    CutShort,
    /// Objects of which some stays undecided whatever the detail, because too many faces lie over too many others to measure all of them.
    Crowded,
}

impl FindingKind {
    /// The name used in JSON output.
    pub fn name(self) -> &'static str {
        match self {
            Self::OpenEdges => "open_edges",
            Self::InconsistentWinding => "inconsistent_winding",
            Self::ZeroAreaFaces => "zero_area_faces",
            Self::DuplicateFaces => "duplicate_faces",
            Self::NoSurface => "no_surface",
            Self::NoInside => "no_inside",
            Self::EmptyScene => "empty_scene",
            Self::MaskAsOpaque => "mask_as_opaque",
            Self::BlendAsOpaque => "blend_as_opaque",
            Self::BlendIgnored => "blend_ignored",
            Self::SpotAsPoint => "spot_as_point",
            Self::AreaLightAsPoint => "area_light_as_point",
            Self::UnknownExtension => "unknown_extension",
            Self::NotTriangles => "not_triangles",
            Self::Deformation => "deformation",
            Self::BrokenRule => "broken_rule",
            Self::UnevenRows => "uneven_rows",
            Self::UnreadShape => "unread_shape",
            Self::MissingTexture => "missing_texture",
            Self::MissingMaterials => "missing_materials",
            Self::LooksZUp => "looks_z_up",
            Self::NonPlanarPolygons => "non_planar_polygons",
            Self::CrossingPolygons => "crossing_polygons",
            Self::DuplicateObjects => "duplicate_objects",
            Self::OverlappingCells => "overlapping_cells",
            Self::SunsBelowHorizon => "suns_below_horizon",
            Self::SunsFromBelow => "suns_from_below",
            Self::CutShort => "cut_short",
            Self::Crowded => "crowded",
        }
    }
}

/// Something a user should know about how the scene was read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// What was found.
    pub kind: FindingKind,
    /// The object, light, extension or element of the file it concerns; empty for the whole scene.
    pub subject: String,
    /// How many times.
    pub count: usize,
    /// The first places, [`Finding::PLACES`] at most ("line 12", "face 3"); none where the subject says it all.
    pub places: Vec<String>,
}

impl Finding {
    /// How many places are told.
    pub const PLACES: usize = 5;
}
