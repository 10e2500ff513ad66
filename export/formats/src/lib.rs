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
//!
//! ```
//! use fabkit_export::{DocumentInfo, Drawing, dxf, stl};
//! use fabkit_geometry::{Path, Profile, Solid};
//!
//! let washer = Profile::new(Path::circle([0.0, 0.0], 5.0)).with_hole(Path::circle([0.0, 0.0], 2.0));
//! let cut = dxf(DocumentInfo { title: "washer", design_hash: "" }, &Drawing::from_piece(&washer))?;
//! assert_eq!(String::from_utf8(cut)?.matches("\nCIRCLE\n").count(), 2);
//! let mesh = fabkit_mesh::mesh(&Solid::extrusion(washer, 1.0), 0.01)?.to_print()?;
//! let print = stl("washer", &mesh)?;
//! assert_eq!(print.len(), 84 + 50 * mesh.triangles().len());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod artwork;
mod bed_layout;
mod drawing;
mod dxf;
mod error;
mod glb;
mod manifest;
mod npz;
mod opc;
mod optics;
mod parquet;
mod pickle;
mod ply;
mod png_image;
mod robot;
mod stl;
mod svg;
mod tetra;
mod three_mf;
mod tiff;
mod tree;
mod zarr;
mod zstd_runs;

pub use artwork::Artwork;
pub use bed_layout::{Bed, BedPosition, pack};
pub use drawing::lettering::lettering;
pub use drawing::{Drawing, NestedSheet, Operation, Piece, nest, widen_for_kerf};
pub use dxf::dxf;
pub use error::ExportError;
pub use glb::{GLB_EXPLODE_S, GlbBody, GlbPlacement, GlbScene, glb};
pub use manifest::{
    Compensation, FileEntry, MachineEntry, Manifest, OptionsEntry, PartEntry, PrintCompensation,
    ProfileEntry, ProfileReference, SettingEntry, SheetFigures, UncompensatedBody, UnlistedFile,
    UnlistedReason,
};
pub use npz::{NpyArray, NpyValues, NpzWriter, npy, npz};
pub use opc::zip;
pub use optics::{
    LightBody, LightCamera, LightDocument, LightDome, LightPlacement, LightPlane, LightSurface,
    OpticalRole, light,
};
pub use parquet::{ParquetColumn, parquet};
pub use pickle::npy_lists;
pub use ply::{CloudPoint, PointCloud};
pub use png_image::{grey8_png, grey16_png, png, png_with_comment};
pub use robot::{
    Inertia, Robot, RobotCamera, RobotFrame, RobotLightSource, RobotLink, RobotMesh,
    RobotSensingSurface, RobotShape, RobotTetrahedra, drake, mjcf, obj, sdf, tacex, tacsl, tacto,
    urdf, usd,
};
pub use stl::stl;
pub use svg::{sheet_preview, svg};
pub use tetra::{TetraMesh, msh, msh2, vtk};
pub use three_mf::{DocumentInfo, PrintObject, SlicerSettings, three_mf, three_mf_single_item};
pub use tiff::float_tiff;
pub use tree::{
    ExactFigures, LeafEntry, MeshFigures, SamplesDocument, TreeDocument, moments, samples, tree,
};
pub use zarr::{
    DamagedChunk, InvalidMetadata, Shard, StoredChunk, ZarrArray, ZarrType, zarr_append_checksum,
    zarr_checksum, zarr_group, zarr_max_packed_size, zarr_pack, zarr_unpack,
};
pub use zstd_runs::{ByteRun, RunContent, encode_zstd_runs};

/// Version of fabkit that files name as their producer.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Serialises a document as pretty JSON with a final newline.
fn json_bytes(document: &impl serde::Serialize) -> Result<Vec<u8>, ExportError> {
    let mut bytes = serde_json::to_vec_pretty(document)?;
    bytes.push(b'\n');
    Ok(bytes)
}
