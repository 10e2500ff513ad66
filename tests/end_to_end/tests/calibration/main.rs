//! Cameras, poses and light from captures: simulated ones, whose truth is known, and published ones.

mod calibrate;
mod camera_files;
mod drawn;
mod fit_light;
mod found_marks;
mod halves_as_targets;
mod intrinsics;
mod planning;
mod real_captures;
mod sigma;
