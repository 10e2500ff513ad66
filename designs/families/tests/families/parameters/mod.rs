//! Reading sensor files: values, limits, layers, hostile text, schema.

mod bulb;
mod hostile;
mod layers;
mod reading;
mod schema;
