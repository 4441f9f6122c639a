//! What walks over instances read.
//!
//! The eight-way tree will stand here, beside the records that it leads to.

mod instance;

pub use instance::InstanceRecord;
