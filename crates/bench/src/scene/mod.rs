//! What is traced: scenes that the program makes, and files.

mod bench_scene;
mod camera;
mod choice;
mod diagonals;
mod pile;
mod shapes;
mod terrain;

pub(crate) use bench_scene::BenchScene;
pub(crate) use camera::PinholeCamera;
pub(crate) use choice::SceneChoice;
