//! What the camera sees of what presses: depth, forces, images.

mod behind_interface;
mod capture;
mod depth;
mod depth_mesh;
mod followed_marks;
mod giving_way;
mod implausible;
mod lens_effects;
mod markers_against_themselves;
mod materials_in_images;
mod optics;
mod presses;
mod pressing;
mod reconstruct;
mod seeing;
