//! Writers of file formats for meshes, drawings, images, arrays and solid trees.
//!
//! Every function is pure: equal arguments yield equal bytes on any machine, with any number of threads, in debug and
//! release. Nothing here opens a file.
//!
//! # Conventions
//!
//! - Lengths are in millimetres, in formats that state the unit and in those that cannot (STL). GLB, whose unit is the
//!   metre, has a root node that scales to it.
//! - Placement is baked into the vertices. No file relies on a transform, because slicers disagree about its unit. GLB,
//!   which is not meant for slicers, has a node for each body.
//! - Triangles come as [`fabkit_mesh::PrintMesh`], which is closed and oriented by construction.
//! - Archives carry the earliest time stamp of their format, never the clock's.

mod artwork;
mod drawing;
mod dxf;
mod error;
mod glb;
mod light;
mod manifest;
mod npz;
mod opc;
mod parquet;
mod pickle;
mod picture;
mod plate;
mod ply;
mod robot;
mod runs;
mod stl;
mod svg;
mod tetra;
mod three_mf;
mod tiff;
mod tree;
mod zarr;

pub use artwork::Artwork;
pub use drawing::lettering::lettering;
pub use drawing::{Drawing, NestedSheet, Operation, Piece, nest, widen_for_kerf};
pub use dxf::dxf;
pub use error::ExportError;
pub use glb::{GLB_EXPLODE_S, GlbBody, GlbPlace, GlbScene, glb};
pub use light::{
    LightBody, LightCamera, LightDocument, LightDome, LightPart, LightPlacement, LightPlane,
    LightSurface, light,
};
pub use manifest::{
    Compensation, FileEntry, GivenProfile, MachineEntry, Manifest, NotApplied, OptionsEntry,
    OtherFile, Otherness, PartEntry, PrintCompensation, ProfileEntry, SettingEntry, SheetFigures,
};
pub use npz::{Array, NpzPieces, Values, npy, npz};
pub use opc::zip;
pub use parquet::{Column, parquet};
pub use pickle::npy_of_lists;
pub use picture::{grey8_png, grey16_png, png, png_with_comment};
pub use plate::{Bed, Spot, pack};
pub use ply::{Cloud, CloudPoint};
pub use robot::{
    Inertia, Robot, RobotCamera, RobotFrame, RobotLamp, RobotLink, RobotMesh, RobotShape,
    RobotTetrahedra, RobotTouch, drake, mjcf, obj, sdf, tacex, tacsl, tacto, urdf, usd,
};
pub use runs::{Run, RunContent, zstd_of_runs};
pub use stl::stl;
pub use svg::{sheet_picture, svg};
pub use tetra::{TetraMesh, msh, msh2, vtk};
pub use three_mf::{Document, Object, SlicerSettings, three_mf, three_mf_of_one_piece};
pub use tiff::float_tiff;
pub use tree::{
    ExactFigures, LeafEntry, MeshFigures, SamplesDocument, TreeDocument, moments, samples, tree,
};
pub use zarr::{
    DamagedChunk, Element, InvalidMetadata, Shard, StoredChunk, ZarrArray, zarr_checksum,
    zarr_group, zarr_most_packed, zarr_pack, zarr_sealed, zarr_unpack,
};

/// Version of fabkit that files name as their producer.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Serialises a document as pretty JSON with a final newline.
fn json_bytes(document: &impl serde::Serialize) -> Result<Vec<u8>, ExportError> {
    let mut bytes = serde_json::to_vec_pretty(document)?;
    bytes.push(b'\n');
    Ok(bytes)
}
