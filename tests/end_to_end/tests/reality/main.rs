//! What stands between a drawing and a sensor on a desk. One program, which is linked once.

mod apart;
mod bridges;
mod grip;
mod hands;
mod held;
mod leak;
mod lens;
mod motion;
mod mounts;
mod others;
mod parts;
mod press;
mod rtac0;
mod seen;
mod sensors;
mod stuck;
mod tools;
