//! What is written of a design, and read again.

mod circuit_boards;
mod defaults;
mod determinism;
mod folders;
mod glb;
mod outputs;
mod package;
mod reread;
mod seams;
mod sheets;
mod tetrahedra;
mod topology;
mod verify;
