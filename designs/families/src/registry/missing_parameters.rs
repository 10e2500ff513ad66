//! Parameters that people look for in sensor files but that do not exist.

/// Last words of paths, and the reason why there is no such parameter.
pub(super) const ABSENT: &[(&str, &str)] = &[
    ("focal_length", "a lens is told by its field of view; calibration measures its focal length"),
    ("flange", "the base has mounting holes, and what it is screwed to is made for those"),
    ("housing.edge_fillet", "fabkit cannot do this: cut sheets have square edges"),
    ("holder.shoulder", "a small tip stands on a wide body where `holder.width` is larger"),
    ("shell.shoulder", "a small tip stands on a wide body where `shell.rim` is larger"),
    (
        "body.shoulder",
        "the housing is as wide as the camera's board asks for, however narrow the tip is",
    ),
    ("cable_angle", "a box has walls: `cable_side` says which one the cable leaves by"),
    ("cable_side", "what is round has no sides: `cable_angle` turns what the cable leaves by"),
    ("resolution", "`width_px` and `height_px` say how many pixels a camera has"),
    ("fov", "`field_of_view` is that of the camera"),
    ("exposure", "that is set where images are taken; it shapes no part"),
    ("gain", "that is set where images are taken; it shapes no part"),
    ("color", "a part has the colour of its `material`"),
    ("colour", "a part has the colour of its `material`"),
    ("hardness", "a gel is as hard as its `material`"),
    ("stiffness", "a gel is as stiff as its `material`"),
    ("infill", "that is the slicer's"),
    ("layer_height", "that is the slicer's"),
    ("scale", "sizes are parameters of their own; what follows from them follows"),
];
